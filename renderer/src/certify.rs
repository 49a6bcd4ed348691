//! Images whose pixels are certain, or said not to be.
//!
//! A pixel is traced in balls of rough doubles. Where a decision hangs on more than those tell, which
//! may be that a result is exact, it is traced again in balls of doubles, and then in balls of
//! double-double; and where they leave it open too, which takes an exact tie, or something very near to
//! one, the rules for ties decide, and the pixel is said to hang on them.

use crate::camera::{ImagePoint, View};
use crate::image::{Image, Pixel};
use crate::numeric::ball::Ball;
use crate::numeric::ball::rough::Rough;
use crate::numeric::dd::Dd;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::plan::{Omissions, Use};
use crate::render::{Failure, pixels};
use crate::scene::Scene;
use crate::shade::{Doubt, Illumination, RayCounts, Shader};
use crate::surface::SurfaceEval;

/// How a pixel is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Certainty {
    /// It has not been traced.
    #[default]
    Unknown,
    /// For certain, by bounds of errors in doubles.
    Double,
    /// For certain, by bounds of errors in double-double.
    DoubleDouble,
    /// By the rules for ties, where bounds leave this open first.
    Rule(Doubt),
}

/// A scene in the numbers that certain images need.
#[derive(Debug)]
pub struct CertainScene {
    rough: Scene<Ball<Rough>>,
    double: Scene<Ball<f64>>,
    exact: Scene<Ball<Dd>>,
}

impl CertainScene {
    /// As [`Scene::BYTES_PER_SHAPE`].
    pub const BYTES_PER_SHAPE: u64 = Scene::<Ball<Rough>>::BYTES_PER_SHAPE
        + Scene::<Ball<f64>>::BYTES_PER_SHAPE
        + Scene::<Ball<Dd>>::BYTES_PER_SHAPE;

    /// Makes it of the same scene in all of them.
    #[must_use]
    pub fn new(
        rough: Scene<Ball<Rough>>,
        double: Scene<Ball<f64>>,
        exact: Scene<Ball<Dd>>,
    ) -> Self {
        CertainScene { rough, double, exact }
    }

    /// As [`Scene::leaving_out`].
    #[must_use]
    pub fn leaving_out(self, omissions: Omissions) -> Self {
        let CertainScene { rough, double, exact } = self;
        CertainScene {
            rough: rough.leaving_out(omissions),
            double: double.leaving_out(omissions),
            exact: exact.leaving_out(omissions),
        }
    }

    /// What it uses of the model.
    #[must_use]
    pub fn used(&self, illumination: &Illumination) -> Use {
        Use::of(&self.rough, illumination)
    }
}

/// Where so many pixels in a row are left open by balls of rough doubles, the next will be as well: then
/// one in so many is tried in them first. Of eight pictures with such stretches, the time with 1 is 1.09 to 1.54
/// times that with 4, with 2 it is 1.02 to 1.16, with 8 it is 0.98 to 1.04, and with 16 it is 1.02 to 1.22.
const MAX_OPEN: u32 = 4;

/// What one thread finds pixels with.
struct Worker<'s, E> {
    rough: Shader<'s, Ball<Rough>, E>,
    double: Shader<'s, Ball<f64>, E>,
    exact: Shader<'s, Ball<Dd>, E>,
    row: u32,
    /// How many of its pixels in a row have been left open by balls of rough doubles, up to the last that
    /// was tried.
    n_open: u32,
}

impl<'s, E: SurfaceEval> Worker<'s, E> {
    fn new(
        scene: &'s CertainScene,
        illumination: &'s Illumination,
        view: &View,
        surfaces: impl Fn() -> E,
    ) -> Self {
        Worker {
            rough: Shader::new(&scene.rough, view.grid(1), illumination, surfaces()).giving_up(),
            double: Shader::new(&scene.double, view.grid(1), illumination, surfaces()).giving_up(),
            exact: Shader::new(&scene.exact, view.grid(1), illumination, surfaces()),
            row: 0,
            n_open: 0,
        }
    }

    /// As [`Shader::for_pixels`].
    fn for_pixels<P: Pixel>(self) -> Self {
        Worker {
            rough: self.rough.for_pixels::<P>(),
            double: self.double.for_pixels::<P>(),
            exact: self.exact.for_pixels::<P>(),
            ..self
        }
    }

    /// Whether a pixel is tried in balls of rough doubles first: of a stretch of a row that these leave
    /// open, only some are.
    fn tries_roughly(&mut self, column: u32, row: u32) -> bool {
        if self.row != row {
            (self.row, self.n_open) = (row, 0);
        }
        self.n_open < MAX_OPEN || column.is_multiple_of(MAX_OPEN)
    }

    /// A pixel, if balls of rough doubles find it for certain.
    fn roughly<P: Pixel>(&mut self, at: ImagePoint) -> Option<P> {
        let found = if_certain(&mut self.rough, at);
        self.n_open = if found.is_some() { 0 } else { self.n_open + 1 };
        found
    }

    /// A pixel, if balls of either kind of doubles find it for certain. Where those of doubles leave it
    /// open, those of rough ones are asked in any case: how it is known must not depend on which pixels
    /// are traced before it.
    fn in_doubles<P: Pixel>(&mut self, at: ImagePoint, tries_roughly: bool) -> Option<P> {
        let found = if tries_roughly { self.roughly(at) } else { None };
        let found = found.or_else(|| if_certain(&mut self.double, at));
        found.or_else(|| if tries_roughly { None } else { self.roughly(at) })
    }
}

/// An image, how each of its pixels is known, and the rays that it took.
pub type Certified<P> = (Image<P>, Vec<Certainty>, RayCounts);

/// Renders an image as [`render`](crate::render()) does, and says how each pixel is known.
///
/// # Errors
/// The failure of the first pixel, in reading order, that has one.
pub fn certify<E: SurfaceEval + Send, P: Pixel>(
    scene: &CertainScene,
    illumination: &Illumination,
    view: &View,
    worker: impl Fn() -> E + Sync,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Certified<P>, Failure<E::Error>> {
    let make = || Worker::new(scene, illumination, view, &worker).for_pixels::<P>();
    let (found, workers) = pixels(view, 1, make, progress, |worker, column, row| {
        let tries_roughly = worker.tries_roughly(column, row);
        let at = ImagePoint::centre(column, row);
        if let Some(pixel) = worker.in_doubles::<P>(at, tries_roughly) {
            return Ok((pixel, Certainty::Double));
        }
        let light = worker.exact.radiance(at)?;
        let of_color = (!is_one_pixel::<_, P>(light)).then_some(Doubt::Color);
        let doubt = worker.exact.doubt.or(of_color);
        Ok((pixel(light), doubt.map_or(Certainty::DoubleDouble, Certainty::Rule)))
    })?;
    let mut counts = RayCounts::default();
    for Worker { rough, double, exact, .. } in workers {
        counts.add(&rough.counts);
        counts.add(&double.counts);
        counts.add(&exact.counts);
    }
    let (pixels, certainties) = found.into_iter().unzip();
    Ok((Image { width: view.width, height: view.height, pixels }, certainties, counts))
}

/// A channel of a pixel's linear light in balls of doubles, and how far it is from the exact number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Account {
    /// How far off it may be, by the ball's radius; infinite where balls of doubles leave it open.
    pub bound: f64,
    /// How far the ball's middle is from the number in double-double; NaN if that is left open.
    pub error: f64,
    /// How far off the number in double-double may be.
    pub exact_bound: f64,
}

/// What balls say of each pixel of the view, by channel, and what is so; none where balls of
/// double-double leave open what there is to see.
///
/// # Errors
/// As [`certify`].
pub fn accounts<E: SurfaceEval + Send>(
    scene: &CertainScene,
    illumination: &Illumination,
    view: &View,
    worker: impl Fn() -> E + Sync,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Option<[Account; 3]>>, Failure<E::Error>> {
    let make = || Worker::new(scene, illumination, view, &worker);
    let (accounts, _) = pixels(view, 1, make, progress, |worker, column, row| {
        let Worker { double, exact, .. } = worker;
        let in_doubles = double.radiance(ImagePoint::centre(column, row)).ok();
        let in_doubles = in_doubles.filter(|_| double.doubt.is_none());
        let light = exact.radiance(ImagePoint::centre(column, row))?;
        Ok(exact.doubt.is_none().then(|| account(in_doubles, light)))
    })?;
    Ok(accounts)
}

/// A colour in balls of doubles, if they know it, beside the same in double-double.
fn account(in_doubles: Option<Vec3<Ball<f64>>>, light: Vec3<Ball<Dd>>) -> [Account; 3] {
    let exact: [Ball<Dd>; 3] = light.into();
    let in_doubles: Option<[Ball<f64>; 3]> = in_doubles.map(Vec3::into);
    [0, 1, 2].map(|channel| {
        let exact = exact[channel];
        let (bound, error) = in_doubles.map_or((f64::INFINITY, f64::NAN), |channels| {
            let middle = Ball::from_f64(channels[channel].to_f64());
            (channels[channel].radius(), (exact - middle).to_f64().abs())
        });
        Account { bound, error, exact_bound: exact.radius() }
    })
}

/// Whether light is one pixel, wherever in its bounds it is.
fn is_one_pixel<R: Real, P: Pixel>(light: Vec3<R>) -> bool {
    let ends: [[f64; 2]; 3] = light.map(R::ends).into();
    // What is infinite is not less than that far apart, nor is NaN.
    let is_finite = ends.iter().all(|[least, most]| most - least < f64::INFINITY);
    let [least, most] = [0, 1].map(|end| P::from_linear(ends.map(|ends| ends[end])));
    is_finite && least == most
}

/// The pixel of light, by the middles of its balls: pixels that are equal may hold more than is compared.
fn pixel<R: Real, P: Pixel>(light: Vec3<R>) -> P {
    P::from_linear(light.map(R::to_f64).into())
}

/// A pixel, if a shader finds it for certain.
fn if_certain<R: Real, E: SurfaceEval, P: Pixel>(
    shader: &mut Shader<'_, R, E>,
    at: ImagePoint,
) -> Option<P> {
    let light = shader.radiance(at).ok()?;
    (shader.doubt.is_none() && is_one_pixel::<R, P>(light)).then(|| pixel(light))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::convert::Infallible;

    use glam::DVec3;

    use super::*;
    use crate::camera::Region;
    use crate::light::Attenuation;
    use crate::object::{Object, ShapeKind, TransformOp};
    use crate::surface::{
        Bounded, BoundedSample, Locate, LocateBounded, Needs, SurfaceId, SurfaceSample,
    };

    /// Grey, which balls of rough doubles alone know, on the right half of a face.
    struct Shy {
        is_rough: bool,
    }

    thread_local! {
        static N_MADE: Cell<u32> = const { Cell::new(0) };
    }

    impl Shy {
        /// The first of the three of a worker is that of rough doubles.
        fn new() -> Self {
            let n_made = N_MADE.get();
            N_MADE.set(n_made + 1);
            Shy { is_rough: n_made.is_multiple_of(3) }
        }
    }

    impl SurfaceEval for Shy {
        type Error = Infallible;

        fn eval(&mut self, _: SurfaceId, _: &impl Locate) -> Result<SurfaceSample, Infallible> {
            Ok(SurfaceSample { color: DVec3::splat(0.5), kd: 1.0, ks: 0.0, phong_exp: 1.0 })
        }

        fn eval_bounded(&mut self, _: SurfaceId, at: &impl LocateBounded) -> Option<BoundedSample> {
            let [zero, half, one] = [0.0, 0.5, 1.0].map(Bounded::exact);
            let sample = BoundedSample { color: [half; 3], kd: one, ks: zero, phong_exp: one };
            (self.is_rough && at.locate_bounded(Needs::ALL).u.value > 0.5).then_some(sample)
        }
    }

    /// Part of a row of 34 pixels of a face, in this ambient light.
    fn of_a_face<P: Pixel>(ambient: f64, x: u32, width: u32) -> (Image<P>, Vec<Certainty>) {
        let wall = Object::shape(ShapeKind::Cube, ())
            .transformed(TransformOp::Translate(DVec3::new(-0.5, -0.5, -0.5)))
            .expect("in range");
        let scene = CertainScene::new(
            Scene::new(&wall, |()| SurfaceId(0)),
            Scene::new(&wall, |()| SurfaceId(0)),
            Scene::new(&wall, |()| SurfaceId(0)),
        );
        let illumination = Illumination {
            ambient: DVec3::splat(ambient),
            lights: Vec::new(),
            attenuation: Attenuation::Icfp,
            tint_specular: true,
            clamp_reflection: false,
            max_bounces: 0,
        };
        let region = Region { x, y: 0, width, height: 1 };
        let view = View { region, ..View::whole(34, 1, 40.0) };
        let found = certify(&scene, &illumination, &view, Shy::new, &|_| {});
        let (image, certainties, _) = found.expect("no errors");
        (image, certainties)
    }

    #[test]
    fn how_a_pixel_is_known_hangs_on_no_other() {
        let known = |x: u32, width: u32| of_a_face::<[u8; 3]>(1.0, x, width).1;
        let whole = known(0, 34);
        assert_eq!(whole[..17], [Certainty::DoubleDouble; 17]);
        assert_eq!(whole[17..], [Certainty::Double; 17]);
        assert_eq!(known(18, 16)[18..], whole[18..]);
    }

    /// Light that is compared as bytes.
    #[derive(Clone, Copy, Default)]
    struct AsBytes([f64; 3]);

    impl PartialEq for AsBytes {
        fn eq(&self, other: &Self) -> bool {
            <[u8; 3]>::from_linear(self.0) == <[u8; 3]>::from_linear(other.0)
        }
    }

    impl Pixel for AsBytes {
        fn from_linear(color: [f64; 3]) -> Self {
            AsBytes(color)
        }

        fn shown(color: [f64; 3]) -> [f64; 3] {
            color
        }
    }

    #[test]
    fn pixels_hold_the_middles_of_balls() {
        let (image, known) = of_a_face::<AsBytes>(0.7, 18, 16);
        assert_eq!(known[18..], [Certainty::Double; 16]);
        assert!(image.pixels[18..].iter().all(|pixel| pixel.0 == [0.7 * 0.5; 3]));
    }
}
