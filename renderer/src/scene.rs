//! What is traced: the description flattened into shapes with their placements, and the trees of
//! set operations above them.
//!
//! A scene is a union of components. Most are single shapes; the others are trees whose root is an
//! intersection or a difference. Shapes are numbered in the order of the program's operands, which
//! decides who paints coincident surfaces. A hierarchy over the components, and one over the leaves of
//! each tree, tell which of them a ray may meet.

use crate::hierarchy::Hierarchy;
use crate::numeric::affine::Affine;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::{SetOp, ShapeKind};
use crate::plan::{Omissions, Part};
use crate::ray::{Conditioning, Ray};
use crate::surface::SurfaceId;

mod building;
mod flatten;

/// The scene to trace, in the numbers `R`.
#[derive(Debug)]
pub struct Scene<R = f64> {
    pub(crate) leaves: Vec<Leaf<R>>,
    /// Of each leaf, by index.
    pub(crate) details: Vec<Detail>,
    /// The maps from object to world space that details refer to: the rows of the matrix and the shift;
    /// of a diagonal matrix the diagonal and the shift.
    maps: Vec<Vec3<R>>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) components: Vec<Component>,
    /// Over the components, by index.
    pub(crate) hierarchy: Hierarchy,
    pub(crate) trees: Vec<Tree>,
    /// Of all leaves.
    pub(crate) conditioning: Conditioning,
    /// The size of the largest coordinate of bounded components.
    pub(crate) extent: f64,
    /// The world-space surface of each face, faces of one leaf in a row. Equal surfaces have equal
    /// numbers, and those that several faces share have the lowest. Empty where none is shared: then
    /// each face's number is that of its surface.
    pub(crate) face_surfaces: Vec<u32>,
    pub(crate) n_shared: u32,
    /// What may be left out.
    pub(crate) omissions: Omissions,
}

/// A shape where it stands: what tells whether a ray meets it. In doubles that is two cache lines.
#[derive(Debug)]
#[repr(C, align(64))]
pub(crate) struct Leaf<R> {
    pub(crate) object_from_world: Affine<R>,
    /// The eye in object space.
    pub(crate) eye: Vec3<R>,
    pub(crate) kind: ShapeKind,
    /// Whether `object_from_world` is treated as a diagonal matrix.
    pub(crate) is_unturned: bool,
    /// Whether the matrix of the map back is kept as its diagonal.
    is_diagonal: bool,
    /// Faces, by bit, whose surfaces the eye lies on, as far as double-double can tell.
    pub(crate) at_eye: u8,
    /// Index of its first face in the scene's list.
    pub(crate) first_face: u32,
}

/// What else there is to know of a leaf, once a ray has met it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Detail {
    pub(crate) surface: SurfaceId,
    /// Its node, if it is part of a tree.
    pub(crate) node: u32,
    /// Where its map from object to world space begins.
    map: u32,
}

/// A part of the union that the scene is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Component {
    Leaf(u32),
    /// A tree by its root node, and its index among the trees.
    Tree {
        root: u32,
        tree: u32,
    },
}

/// The shapes of a tree of set operations, for finding those that a ray may meet.
#[derive(Debug)]
pub(crate) struct Tree {
    /// Of a carving, the shapes that it is carved from, all of which a ray has to meet; of other trees
    /// none.
    pub(crate) whole: Vec<u32>,
    /// Of the others.
    pub(crate) hierarchy: Hierarchy,
}

/// A node of a tree of set operations: true inside its solid. Operands are numbered in their order.
///
/// An operation may have many operands, as many as follow from its being associative: a union of
/// unions is one, and so is the difference of a difference. All are sums with a threshold, of +1 for
/// an operand that is true, but -1 for those taken away.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// The node above, [`NONE`] for a root.
    pub(crate) parent: u32,
    /// What it adds to the sum of the node above while it is true.
    pub(crate) weight: i32,
    /// The least sum that makes it true.
    pub(crate) threshold: i32,
    pub(crate) kind: Kind,
}

/// What a node stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Leaf(u32),
    Combined(SetOp),
}

/// No node.
pub(crate) const NONE: u32 = u32::MAX;

impl<R: Real> Scene<R> {
    /// The same scene, of which only these parts may be left out; at first, all may.
    #[must_use]
    pub fn leaving_out(mut self, omissions: Omissions) -> Self {
        self.omissions = omissions;
        for leaf in &mut self.leaves {
            leaf.is_unturned &= omissions.holds(Part::Turns);
        }
        self
    }

    /// Kind and surface function of each shape.
    pub fn shapes(&self) -> impl Iterator<Item = (ShapeKind, SurfaceId)> {
        let leaves = self.leaves.iter().zip(&self.details);
        leaves.map(|(leaf, detail)| (leaf.kind, detail.surface))
    }

    /// Brings a point of a leaf's surface and the normal there from object space to world space; the
    /// normal gets any length.
    #[inline(always)]
    pub(crate) fn in_world(&self, index: u32, p: Vec3<R>, normal: Vec3<R>) -> [Vec3<R>; 2] {
        let leaf = &self.leaves[index as usize];
        let map = &self.maps[self.details[index as usize].map as usize..];
        let object_from_world = &leaf.object_from_world;
        let map = if leaf.is_diagonal {
            let [Vec3 { x, y, z }, shift] = *map.first_chunk().expect("a diagonal and a shift");
            let zero = R::ZERO;
            let rows =
                [Vec3::new(x, zero, zero), Vec3::new(zero, y, zero), Vec3::new(zero, zero, z)];
            Affine { rows, shift }
        } else {
            let [x, y, z, shift] = *map.first_chunk().expect("three rows and a shift");
            Affine { rows: [x, y, z], shift }
        };
        // What is infinite or NaN times 0 is NaN, which the products that are left out would add.
        if leaf.is_diagonal && leaf.is_unturned && p.to_dvec3().element_sum().is_finite() {
            [map.point_by_diagonal(p), object_from_world.vector_by_diagonal(normal)]
        } else {
            [map.point(p), object_from_world.transposed_vector(normal)]
        }
    }

    /// The world-space surface that a face of a leaf is part of.
    pub(crate) fn face_surface(&self, leaf: &Leaf<R>, face: u8) -> u32 {
        let number = leaf.first_face + u32::from(face);
        self.face_surfaces.get(number as usize).copied().unwrap_or(number)
    }
}

impl<R: Real> Leaf<R> {
    /// A point of world space in object space.
    #[inline(always)]
    pub(crate) fn local_point(&self, p: Vec3<R>) -> Vec3<R> {
        let map = &self.object_from_world;
        if self.is_unturned { map.point_by_diagonal(p) } else { map.point(p) }
    }

    /// A vector of world space in object space.
    #[inline(always)]
    pub(crate) fn local_vector(&self, v: Vec3<R>) -> Vec3<R> {
        let map = &self.object_from_world;
        if self.is_unturned { map.vector_by_diagonal(v) } else { map.vector(v) }
    }

    /// The size of the terms that a ray's origin is computed from in object space.
    #[inline]
    pub(crate) fn origin_size(&self, ray: &Ray<R>) -> f64 {
        self.linear_size() * ray.origin.max_norm().to_f64() + self.shift_size()
    }

    /// The size of the entries of the matrix to object space, the largest sum of a row. With that of
    /// the shift, it bounds what rounding does to a ray's origin.
    #[inline]
    pub(crate) fn linear_size(&self) -> f64 {
        largest_row(&self.object_from_world)
    }

    /// The size of the shift to object space.
    #[inline]
    pub(crate) fn shift_size(&self) -> f64 {
        self.object_from_world.shift.max_norm().to_f64()
    }
}

/// The largest of the sums of the sizes of a row's entries.
#[inline]
fn largest_row<R: Real>(map: &Affine<R>) -> f64 {
    let size = |row: &Vec3<R>| (row.x.abs() + row.y.abs() + row.z.abs()).to_f64();
    map.rows.iter().map(size).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::{Object, TransformOp};
    use glam::DVec3;

    /// A point and a normal of world space, in which numbers that are not are all the same.
    fn in_world(omissions: Omissions, p: Vec3<f64>) -> [[Option<f64>; 3]; 2] {
        let ops = [
            TransformOp::Scale(DVec3::new(3.0, -0.7, 0.1)),
            TransformOp::Translate(DVec3::new(0.3, -2.0, 7.0)),
        ];
        let sphere = Object::shape(ShapeKind::Sphere, ());
        let placed =
            ops.iter().fold(sphere, |object, &op| object.transformed(op).expect("regular"));
        let scene: Scene<f64> = Scene::new(&placed, |()| SurfaceId(0)).leaving_out(omissions);
        let number = |x: f64| (!x.is_nan()).then_some(x);
        scene.in_world(0, p, p).map(|v| <[f64; 3]>::from(v).map(number))
    }

    #[test]
    fn zeros_are_left_out_of_points_and_normals_where_nothing_changes() {
        let numbers = [0.0, 0.6, -1e-310, 1e308, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        for x in numbers {
            for y in numbers {
                for z in numbers {
                    let p = Vec3::new(x, y, z);
                    let [found, all] = [Omissions::ALL, Omissions::NONE].map(|o| in_world(o, p));
                    assert_eq!(found, all, "{p:?}");
                }
            }
        }
    }
}
