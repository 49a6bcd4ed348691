//! Vectors and maps of the naive tracer, in the numbers that it is to have.

use std::ops::{Add, Div, Index, Mul, Neg, Sub};

use glam::DVec3;
use num_traits::Float;

/// The numbers of a naive tracer.
pub(crate) trait Number: Float + Send + Sync + 'static {
    /// The nearest to a double.
    fn of(value: f64) -> Self;

    /// The number as a double.
    fn double(self) -> f64;
}

impl Number for f32 {
    fn of(value: f64) -> f32 {
        value as f32
    }

    fn double(self) -> f64 {
        f64::from(self)
    }
}

impl Number for f64 {
    fn of(value: f64) -> f64 {
        value
    }

    fn double(self) -> f64 {
        self
    }
}

/// A point, a direction or a colour.
#[derive(Clone, Copy)]
pub(super) struct Vector<F>(pub(super) [F; 3]);

impl<F: Number> Vector<F> {
    pub(super) fn of(value: DVec3) -> Self {
        Vector(value.to_array().map(F::of))
    }

    pub(super) fn zero() -> Self {
        Vector([F::zero(); 3])
    }

    pub(super) fn axis(axis: usize) -> Self {
        Vector([0, 1, 2].map(|other| if other == axis { F::one() } else { F::zero() }))
    }

    pub(super) fn dot(self, other: Self) -> F {
        let Vector([x, y, z]) = self.scaled_by(other);
        x + y + z
    }

    fn cross(self, other: Self) -> Self {
        let (Vector([ax, ay, az]), Vector([bx, by, bz])) = (self, other);
        Vector([ay * bz - by * az, az * bx - bz * ax, ax * by - bx * ay])
    }

    pub(super) fn length(self) -> F {
        self.dot(self).sqrt()
    }

    pub(super) fn normalized(self) -> Self {
        self * self.length().recip()
    }

    /// Component by component.
    pub(super) fn scaled_by(self, other: Self) -> Self {
        Vector([0, 1, 2].map(|axis| self.0[axis] * other.0[axis]))
    }

    /// Cut to [0, 1].
    pub(super) fn clamped(self) -> Self {
        Vector(self.0.map(|x| x.max(F::zero()).min(F::one())))
    }
}

impl<F> Index<usize> for Vector<F> {
    type Output = F;

    fn index(&self, axis: usize) -> &F {
        &self.0[axis]
    }
}

impl<F: Number> Add for Vector<F> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Vector([0, 1, 2].map(|axis| self.0[axis] + other.0[axis]))
    }
}

impl<F: Number> Sub for Vector<F> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Vector([0, 1, 2].map(|axis| self.0[axis] - other.0[axis]))
    }
}

impl<F: Number> Neg for Vector<F> {
    type Output = Self;

    fn neg(self) -> Self {
        Vector(self.0.map(|x| -x))
    }
}

impl<F: Number> Mul<F> for Vector<F> {
    type Output = Self;

    fn mul(self, factor: F) -> Self {
        Vector(self.0.map(|x| x * factor))
    }
}

impl<F: Number> Div<F> for Vector<F> {
    type Output = Self;

    fn div(self, divisor: F) -> Self {
        Vector(self.0.map(|x| x / divisor))
    }
}

/// A linear map and a shift.
#[derive(Clone, Copy)]
pub(super) struct Affine<F> {
    /// The images of the axes.
    columns: [Vector<F>; 3],
    shift: Vector<F>,
}

impl<F: Number> Affine<F> {
    pub(super) fn identity() -> Self {
        Affine::translation(Vector::zero())
    }

    pub(super) fn translation(shift: Vector<F>) -> Self {
        Affine { columns: [0, 1, 2].map(Vector::axis), shift }
    }

    pub(super) fn scale(by: Vector<F>) -> Self {
        let columns = [0, 1, 2].map(|axis| Vector::axis(axis) * by[axis]);
        Affine { columns, shift: Vector::zero() }
    }

    /// From axis `i` toward axis `j`.
    pub(super) fn rotation(angle_deg: f64, i: usize, j: usize) -> Self {
        let (sin, cos) = F::of(angle_deg).to_radians().sin_cos();
        let mut map = Affine::identity();
        map.columns[i].0[i] = cos;
        map.columns[i].0[j] = sin;
        map.columns[j].0[i] = -sin;
        map.columns[j].0[j] = cos;
        map
    }

    /// The map that does `first`, then `self`.
    pub(super) fn after(&self, first: &Self) -> Self {
        Affine {
            columns: first.columns.map(|column| self.vector(column)),
            shift: self.point(first.shift),
        }
    }

    /// By cofactors.
    pub(super) fn inverse(&self) -> Self {
        let [x, y, z] = self.columns;
        let cofactors = [y.cross(z), z.cross(x), x.cross(y)];
        let reciprocal = z.dot(cofactors[2]).recip();
        let rows = cofactors.map(|row| row * reciprocal);
        let columns = [0, 1, 2].map(|column| Vector(rows.map(|row| row[column])));
        let linear = Affine { columns, shift: Vector::zero() };
        Affine { shift: -linear.vector(self.shift), ..linear }
    }

    pub(super) fn vector(&self, v: Vector<F>) -> Vector<F> {
        let [x, y, z] = self.columns;
        x * v[0] + y * v[1] + z * v[2]
    }

    pub(super) fn point(&self, p: Vector<F>) -> Vector<F> {
        self.vector(p) + self.shift
    }

    /// By the transposed linear map.
    pub(super) fn transposed_vector(&self, v: Vector<F>) -> Vector<F> {
        Vector(self.columns.map(|column| column.dot(v)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverses_undo_maps() {
        let map = Affine::rotation(30.0, 0, 2)
            .after(&Affine::translation(Vector([1.0, -2.0, 5.0])))
            .after(&Affine::scale(Vector([2.0, -3.0, 0.5])));
        let p = Vector([0.25, 7.0, -1.5]);
        let back = map.inverse().point(map.point(p));
        // Some 30 roundings of terms below 32.
        assert!((back - p).length() < 30.0 * 32.0 * f64::EPSILON);
        let turned = Affine::<f64>::rotation(90.0, 1, 2).vector(Vector::axis(1));
        assert!((turned - Vector::axis(2)).length() < f64::EPSILON);
    }
}
