//! A line and the unit sphere, alone: by this charts measure what the tracer computes of its rays.

use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::ShapeKind;
use crate::shape::{self, LocalRay};

/// Where a line enters the unit sphere around the origin; none where it misses or only touches it. The
/// direction has any length but 0.
#[must_use]
pub fn enters_sphere<R: Real>(origin: Vec3<R>, dir: Vec3<R>) -> Option<Vec3<R>> {
    let ray = LocalRay::new(origin, dir, 0);
    let span = shape::span(ShapeKind::Sphere, &ray)?;
    Some(shape::hit_point(ShapeKind::Sphere, &ray, span.enter.root))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_enter_on_the_side_that_they_come_from() {
        let enters = |y: f64| {
            enters_sphere(Vec3::new(-5.0, y, 0.0), Vec3::new(2.0, 0.0, 0.0)).map(Vec3::to_dvec3)
        };
        assert_eq!(enters(0.0), Some(glam::DVec3::new(-1.0, 0.0, 0.0)));
        assert_eq!(enters(0.6), Some(glam::DVec3::new(-0.8, 0.6, 0.0)));
        assert_eq!(enters(1.0), None);
        assert_eq!(enters(1.5), None);
    }
}
