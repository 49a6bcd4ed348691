//! Pixels looked at closely: what a pixel's ray meets first, and what it takes to find its colour.

use glam::DVec3;

use crate::camera::{ImagePoint, View};
use crate::numeric::real::Real;
use crate::object::ShapeKind;
use crate::render::{self, Failure};
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
    /// The work of surface functions, in the unit of whoever measures it.
    pub work: u64,
}

/// Looks through the centre of the pixel at `column` and `row`, which need not be in the view's region.
/// `work` tells all the work that an evaluator of surfaces has done so far.
///
/// # Errors
/// What a surface function does wrong.
pub fn probe<R: Real, E: SurfaceEval>(
    scene: &Scene<R>,
    illumination: &Illumination,
    view: &View,
    [column, row]: [u32; 2],
    surfaces: E,
    work: impl Fn(&E) -> u64,
) -> Result<Probe, E::Error> {
    let centre = ImagePoint::centre(column, row);
    let mut shader = Shader::new(scene, view.grid(1), illumination, surfaces);
    let seen = shader.seen(centre);
    let light = shader.radiance(centre)?.to_dvec3();
    Ok(Probe { light, seen, rays: shader.counts, work: work(&shader.surfaces) })
}

/// What it takes to find the colour of a pixel's centre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Rays of all kinds.
    pub rays: u64,
    /// Work of surface functions, in the unit of whoever measures it.
    pub work: u64,
}

/// Finds the costs of all pixels of a view on the current rayon thread pool, row by row; those outside
/// its region cost nothing. `worker` makes what one thread evaluates surfaces with, and `work` tells all
/// the work that such a one has done so far.
///
/// # Errors
/// The failure of the first pixel, in reading order, that has one.
pub fn costs<R: Real, E: SurfaceEval + Send>(
    scene: &Scene<R>,
    illumination: &Illumination,
    view: &View,
    worker: impl Fn() -> E + Sync,
    work: impl Fn(&E) -> u64 + Sync,
) -> Result<Vec<Cost>, Failure<E::Error>> {
    let make = || Shader::new(scene, view.grid(1), illumination, worker());
    let (costs, _) = render::pixels(view, 1, make, &|_| {}, |shader, column, row| {
        let so_far = |shader: &Shader<'_, R, E>| {
            let RayCounts { primary, reflected, shadow, .. } = shader.counts;
            (primary + reflected + shadow, work(&shader.surfaces))
        };
        let (rays, done) = so_far(shader);
        shader.radiance(ImagePoint::centre(column, row))?;
        let (rays_after, done_after) = so_far(shader);
        Ok(Cost { rays: rays_after - rays, work: done_after - done })
    })?;
    Ok(costs)
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
        let centre = probe(&scene, &illumination, &view, [1, 1], White, |_| 0).expect("no errors");
        let seen = centre.seen.expect("a ball");
        assert_eq!((seen.kind, seen.surface, seen.shape), (ShapeKind::Sphere, SurfaceId(7), 1));
        // The front of the ball is hit head on, where all is exact; the eye is at z = -1.
        assert_eq!((seen.distance, seen.point), (4.0, DVec3::new(0.0, 0.0, 3.0)));
        assert_eq!((centre.rays.primary, centre.rays.reflected), (1, 1));
        assert!(centre.light.min_element() >= 1.0, "{}", centre.light);
        let corner = probe(&scene, &illumination, &view, [0, 0], White, |_| 0).expect("no errors");
        assert_eq!((corner.seen, corner.light), (None, DVec3::ZERO));
        assert_eq!((corner.rays.primary, corner.rays.surface_calls), (1, 0));
    }

    /// Counts its calls.
    struct Busy(u64);

    impl SurfaceEval for Busy {
        type Error = Infallible;

        fn eval(&mut self, id: SurfaceId, at: &impl Locate) -> Result<SurfaceSample, Infallible> {
            self.0 += 1;
            White.eval(id, at)
        }
    }

    #[test]
    fn the_costs_of_pixels_are_those_of_looking_at_each() {
        let ball = Object::shape(ShapeKind::Sphere, 0)
            .transformed(TransformOp::Translate(DVec3::new(0.4, 0.0, 2.0)))
            .expect("in range");
        let floor = Object::shape(ShapeKind::Plane, 1)
            .transformed(TransformOp::Translate(DVec3::new(0.0, -1.0, 0.0)))
            .expect("in range");
        let scene: Scene = Scene::new(&ball.union(&floor), |s| SurfaceId(*s));
        let illumination = Illumination {
            ambient: DVec3::ONE,
            lights: vec![Light::Directional { dir: DVec3::NEG_Y, color: DVec3::ONE }],
            attenuation: Attenuation::Icfp,
            tint_specular: true,
            clamp_reflection: false,
            max_bounces: 3,
        };
        let mut view = View::whole(9, 7, 90.0);
        view.region.y = 2;
        view.region.height = 4;
        let found = costs(&scene, &illumination, &view, || Busy(0), |busy| busy.0);
        let found = found.expect("no errors");
        assert_eq!(found.len(), 9 * 7);
        for (cost, place) in found.iter().zip(0..) {
            let (column, row) = (place % 9, place / 9);
            let looked = probe(&scene, &illumination, &view, [column, row], White, |_| 0);
            let rays = looked.expect("no errors").rays;
            let expected = Cost {
                rays: rays.primary + rays.reflected + rays.shadow,
                work: rays.surface_calls,
            };
            let is_inside = (2..6).contains(&row);
            assert_eq!(*cost, if is_inside { expected } else { Cost::default() }, "{column} {row}");
        }
        assert!(found.iter().any(|cost| cost.rays > 3 && cost.work > 1), "mirrors were met");
        assert!(found.iter().any(|cost| (cost.rays, cost.work) == (1, 0)), "nothing was met");
    }
}
