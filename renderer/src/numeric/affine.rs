//! Affine maps over any [`Real`].

use glam::{DAffine3, DMat3};

use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;

/// The map `p -> linear p + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine<R> {
    /// Rows of the matrix.
    pub rows: [Vec3<R>; 3],
    /// What is added.
    pub shift: Vec3<R>,
}

impl<R: Real> Affine<R> {
    /// The image of a point.
    #[inline(always)]
    pub fn point(&self, p: Vec3<R>) -> Vec3<R> {
        let ([x, y, z], shift) = (self.rows, self.shift);
        Vec3::new(x.dot_and(p, shift.x), y.dot_and(p, shift.y), z.dot_and(p, shift.z))
    }

    /// The image of a vector: the shift does not count.
    #[inline(always)]
    pub fn vector(&self, v: Vec3<R>) -> Vec3<R> {
        let [x, y, z] = self.rows;
        Vec3::new(x.dot(v), y.dot(v), z.dot(v))
    }

    /// Whether all entries of the matrix off its diagonal are 0.
    #[must_use]
    pub fn is_diagonal(&self) -> bool {
        let [x, y, z] = self.rows;
        [x.y, x.z, y.x, y.z, z.x, z.y].into_iter().all(R::is_surely_zero)
    }

    /// As [`Affine::point`] where the matrix is diagonal. The products left out are 0, so that they
    /// could change no more than the sign of a 0, on which nothing hangs.
    #[inline(always)]
    pub fn point_by_diagonal(&self, p: Vec3<R>) -> Vec3<R> {
        let [x, y, z] = self.rows;
        Vec3::new(
            x.x.mul_add(p.x, self.shift.x),
            y.y.mul_add(p.y, self.shift.y),
            z.z.mul_add(p.z, self.shift.z),
        )
    }

    /// As [`Affine::vector`] where the matrix is diagonal, and as [`Affine::transposed_vector`], since
    /// such a matrix is its own transpose.
    #[inline(always)]
    pub fn vector_by_diagonal(&self, v: Vec3<R>) -> Vec3<R> {
        let [x, y, z] = self.rows;
        Vec3::new(x.x * v.x, y.y * v.y, z.z * v.z)
    }

    /// The nearest map with entries that are doubles.
    #[must_use]
    pub fn to_daffine3(&self) -> DAffine3 {
        let [x, y, z] = self.rows.map(Vec3::to_dvec3);
        let matrix3 = DMat3::from_cols(x, y, z).transpose();
        DAffine3 { matrix3, translation: self.shift.to_dvec3() }
    }

    /// The transposed matrix times a vector: of the map from world to object space, this takes
    /// object-space normals to world-space normals.
    #[inline(always)]
    pub fn transposed_vector(&self, v: Vec3<R>) -> Vec3<R> {
        let [x, y, z] = self.rows;
        let along = |column: [R; 3]| R::dot(column, v.into());
        Vec3::new(along([x.x, y.x, z.x]), along([x.y, y.y, z.y]), along([x.z, y.z, z.z]))
    }
}
