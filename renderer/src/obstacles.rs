//! What may be in the way of a lamp, of the components that no box bounds.
//!
//! Light on the way to a point outside all solids does not cross a plane that the lamp is in front of,
//! as both ends lie on the same side of it. Which planes these are is found once for each lamp.

use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::ShapeKind;
use crate::plan::Part;
use crate::ray::TIE_ROUNDINGS;
use crate::scene::{Component, Leaf, Scene};

/// Where light comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Whence<R> {
    /// From infinity; the unit vector toward the lamp.
    Toward(Vec3<R>),
    /// From a point.
    At(Vec3<R>),
}

/// The unbounded components that may be in the way of a lamp.
#[derive(Clone, Debug)]
pub(crate) struct Obstacles {
    /// Those that matter for points whose coordinates have at most this size.
    within: f64,
    of_near: Vec<u32>,
}

impl Obstacles {
    pub(crate) fn new<R: Real>(scene: &Scene<R>, whence: Option<Whence<R>>) -> Self {
        let mut obstacles = Obstacles { within: f64::INFINITY, of_near: Vec::new() };
        let whence = whence.filter(|_| scene.omissions.holds(Part::Obstacles));
        for &index in scene.hierarchy.unbounded() {
            let within = match (whence, scene.components[index as usize]) {
                (Some(whence), Component::Leaf(leaf)) => {
                    scene.in_front(&scene.leaves[leaf as usize], whence)
                }
                _ => None,
            };
            match within {
                Some(within) => obstacles.within = obstacles.within.min(within),
                None => obstacles.of_near.push(index),
            }
        }
        obstacles
    }

    /// Those that matter for a point whose coordinates have at most this size; none if all do.
    #[inline(always)]
    pub(crate) fn for_point_of(&self, size: f64) -> Option<&[u32]> {
        (size <= self.within).then_some(&self.of_near)
    }
}

impl<R: Real> Scene<R> {
    /// Whether light from there is in front of a plane, which is then found to be missed by rays to
    /// points of this size at most, however that is rounded.
    fn in_front(&self, leaf: &Leaf<R>, whence: Whence<R>) -> Option<f64> {
        if leaf.kind != ShapeKind::Plane {
            return None;
        }
        let position = match whence {
            // How a ray's height changes is computed alike for all points.
            Whence::Toward(dir) => {
                let rise = leaf.object_from_world.rows[1].dot(dir);
                return rise.is_surely_positive().then_some(f64::INFINITY);
            }
            Whence::At(position) => position,
        };
        let height = leaf.object_from_world.point(position).y;
        // A plane is found to be missed where h(p) + t n·(q - p) is above 0, for the point p, the lamp
        // q and the end of ties t. Of that, h(q) is what remains but for four roundings of each of the
        // terms, of sizes L |p| + S and L |q - p|, with L and S the sizes of the map's entries; and but
        // for L |q - p| (t - 1), where t - 1 is at most 8 errors of the origin over |q - p| and 4
        // tolerances of 1. A tolerance is 64 roundings, to which those of the terms are nothing: 16
        // tolerances for each of the sizes are more than all of it.
        let tolerance = TIE_ROUNDINGS * f64::UNIT_ROUNDOFF;
        let room = (height.to_f64() - height.radius()) / (16.0 * tolerance);
        let (size, shift) = (leaf.linear_size(), leaf.shift_size());
        let of_lamp = position.max_norm().to_f64() * size;
        let of_origin = self.conditioning;
        let within =
            (room - shift - of_lamp - size * of_origin.shift) / (size * (1.0 + of_origin.linear));
        (within > 0.0).then_some(within)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::{Object, TransformOp};
    use crate::surface::SurfaceId;
    use glam::DVec3;

    /// Half-spaces below y = -1 and above y = 3, and a ball.
    fn room() -> Scene<f64> {
        let shape = |kind| Object::shape(kind, ());
        let changed = |object: Object<()>, op| object.transformed(op).expect("regular");
        let at = |object, y| changed(object, TransformOp::Translate(DVec3::new(0.0, y, 0.0)));
        let floor = at(shape(ShapeKind::Plane), -1.0);
        let ceiling = at(changed(shape(ShapeKind::Plane), TransformOp::RotateX(180.0)), 3.0);
        let all = floor.union(&ceiling).union(&shape(ShapeKind::Sphere));
        Scene::new(&all, |()| SurfaceId(0))
    }

    #[test]
    fn planes_behind_lamps_are_none() {
        let obstacles = |whence| Obstacles::new(&room(), whence);
        let inside = obstacles(Some(Whence::At(Vec3::new(0.5, 2.5, -1.0))));
        assert_eq!(inside.for_point_of(1e6), Some(&[][..]));
        // Far away rounding may put the point on the other side.
        assert_eq!(inside.for_point_of(1e13), None);
        assert_eq!(inside.for_point_of(f64::NAN), None);
        let above = obstacles(Some(Whence::At(Vec3::new(0.5, 3.5, -1.0))));
        assert_eq!(above.for_point_of(1.0), Some(&[1][..]));
        let in_the_plane = obstacles(Some(Whence::At(Vec3::new(0.5, 3.0, -1.0))));
        assert_eq!(in_the_plane.for_point_of(1.0), Some(&[1][..]));
        let from_above = obstacles(Some(Whence::Toward(Vec3::new(0.0, 1.0, 0.0))));
        assert_eq!(from_above.for_point_of(1e300), Some(&[1][..]));
        let level = obstacles(Some(Whence::Toward(Vec3::new(1.0, 0.0, 0.0))));
        assert_eq!(level.for_point_of(1.0), Some(&[0, 1][..]));
    }
}
