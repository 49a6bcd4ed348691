//! One pixel looked at closely: what its ray meets first, and what it takes to find its colour.

use glam::DVec3;

use crate::camera::{ImagePoint, View};
use crate::numeric::real::Real;
use crate::object::ShapeKind;
use crate::scene::Scene;
use crate::shade::{Illumination, RayCounts, Shader};
use crate::surface::{SurfaceEval, SurfaceId, SurfacePoint};

/// What a ray from the eye meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Index of the shape among those of [`Scene::shapes`].
    pub shape: usize,
    /// Its kind.
    pub kind: ShapeKind,
    /// Its surface function.
    pub surface: SurfaceId,
    /// Where on it.
    pub at: SurfacePoint,
    /// The point in world space.
    pub point: DVec3,
    /// How far that is from the eye.
    pub distance: f64,
}

/// A pixel's centre, looked at.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// The light that arrives, linear red, green and blue.
    pub light: DVec3,
    /// What is seen; nothing where the ray meets none.
    pub seen: Option<Seen>,
    /// The rays that it took.
    pub rays: RayCounts,
}

/// Looks through the centre of the pixel at `column` and `row`, which need not be in the view's region.
///
/// # Errors
/// What a surface function does wrong.
pub fn probe<R: Real, E: SurfaceEval>(
    scene: &Scene<R>,
    illumination: &Illumination,
    view: &View,
    [column, row]: [u32; 2],
    surfaces: E,
) -> Result<Probe, E::Error> {
    let (grid, centre) = (view.grid(1), ImagePoint::centre(column, row));
    let mut shader = Shader::new(scene, illumination, surfaces);
    let seen = shader.seen(&grid, centre);
    let light = shader.radiance(&grid, centre)?.to_dvec3();
    Ok(Probe { light, seen, rays: shader.counts })
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::light::{Attenuation, Light};
    use crate::object::{Object, TransformOp};
    use crate::surface::{Locate, SurfaceSample};

    struct White;

    impl SurfaceEval for White {
        type Error = Infallible;

        fn eval(&mut self, _: SurfaceId, at: &impl Locate) -> Result<SurfaceSample, Infallible> {
            let _ = at;
            Ok(SurfaceSample { color: DVec3::ONE, kd: 1.0, ks: 0.5, phong_exp: 1.0 })
        }
    }

    #[test]
    fn the_nearest_shape_is_seen() {
        let ball = |surface: u32, z: f64| {
            Object::shape(ShapeKind::Sphere, surface)
                .transformed(TransformOp::Translate(DVec3::new(0.0, 0.0, z)))
                .expect("in range")
        };
        let scene: Scene = Scene::new(&ball(3, 9.0).union(&ball(7, 4.0)), |s| SurfaceId(*s));
        let illumination = Illumination {
            ambient: DVec3::ONE,
            lights: vec![Light::Directional { dir: DVec3::Z, color: DVec3::ONE }],
            attenuation: Attenuation::Icfp,
            tint_specular: true,
            clamp_reflection: false,
            max_bounces: 1,
        };
        let view = View::whole(3, 3, 90.0);
        let centre = probe(&scene, &illumination, &view, [1, 1], White).expect("no errors");
        let seen = centre.seen.expect("a ball");
        assert_eq!((seen.kind, seen.surface, seen.shape), (ShapeKind::Sphere, SurfaceId(7), 1));
        // The front of the ball is hit head on, where all is exact; the eye is at z = -1.
        assert_eq!((seen.distance, seen.point), (4.0, DVec3::new(0.0, 0.0, 3.0)));
        assert_eq!((centre.rays.primary, centre.rays.reflected), (1, 1));
        assert!(centre.light.min_element() >= 1.0, "{}", centre.light);
        let corner = probe(&scene, &illumination, &view, [0, 0], White).expect("no errors");
        assert_eq!((corner.seen, corner.light), (None, DVec3::ZERO));
        assert_eq!((corner.rays.primary, corner.rays.surface_calls), (1, 0));
    }
}
