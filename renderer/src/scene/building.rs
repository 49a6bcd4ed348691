//! A leaf from its placement: all that follows from that alone, so that leaves are made in parallel.

use crate::bounds::{self, Bounds};
use crate::camera;
use crate::intern::{self, FaceKey};
use crate::numeric::affine::Affine;
use crate::numeric::ball::Ball;
use crate::numeric::ball::rounded::LEAST;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::ShapeKind;
use crate::placement::{Bounded, Placement};
use crate::ray::Conditioning;
use crate::scene::{Leaf, largest_row};
use crate::shape;

/// A leaf, and what the scene needs to know of it while it is built.
pub(super) struct Built<R> {
    /// Its first face is yet to be numbered.
    pub(super) leaf: Leaf<R>,
    pub(super) world_from_object: Affine<R>,
    pub(super) conditioning: Conditioning,
    /// A box around it, with room for rounding.
    pub(super) bounds: Bounds,
    /// Of its faces, as many as it has.
    keys: [FaceKey; shape::MAX_FACES],
}

impl<R: Real> Built<R> {
    pub(super) fn new(kind: ShapeKind, placement: &Placement) -> Self {
        let object_from_world: Affine<R> = placement.object_from_world.rounded();
        let world_from_object: Affine<R> = placement.world_from_object.rounded();
        let leaf = Leaf {
            kind,
            first_face: 0,
            object_from_world,
            is_unturned: object_from_world.is_diagonal(),
            is_diagonal: world_from_object.is_diagonal(),
            eye: object_from_world.point(camera::eye()),
            at_eye: faces_at_eye(kind, &placement.object_from_world),
        };
        let stretch = largest_row(&world_from_object);
        let conditioning = Conditioning {
            linear: stretch * leaf.linear_size(),
            shift: stretch * leaf.shift_size(),
        };
        let maps = [&world_from_object, &object_from_world].map(Affine::to_daffine3);
        let bounds = bounds::of_shape(kind, &maps[0], &maps[1]);
        Built {
            leaf,
            world_from_object,
            conditioning,
            bounds: bounds.padded(|size| conditioning.error(size)),
            keys: intern::face_keys(kind, placement),
        }
    }
}

impl<R> Built<R> {
    /// Those of its faces.
    pub(super) fn keys(&self) -> &[FaceKey] {
        &self.keys[..shape::forms(self.leaf.kind).len()]
    }
}

/// The faces, by bit, whose surfaces the eye lies on, as far as double-double can tell.
fn faces_at_eye(kind: ShapeKind, object_from_world: &Bounded) -> u8 {
    // The eye is at -z.
    let eye: Vec3<Ball<f64>> = object_from_world.column(3) - object_from_world.column(2);
    // Where balls of doubles are more than four radii away from 0, those of double-double, whose radii
    // are not larger, do not hold it: their middles are within the two radii of one another. Eight, and
    // what stands for numbers below the range of doubles, leave room for how the radii are rounded.
    let is_off = |form| {
        let height = shape::height(form, eye);
        height.to_f64().abs() > 8.0 * (height.radius() + LEAST)
    };
    if shape::forms(kind).iter().all(is_off) {
        return 0;
    }
    shape::faces_at(kind, object_from_world.rounded().point(camera::eye()))
}
