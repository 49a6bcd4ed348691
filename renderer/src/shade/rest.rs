//! The rest of a path: what it can add at most, and where that cannot change a pixel.
//!
//! The light that arrives at the eye is a chain of monotone functions of what a point reflects. So if
//! the least and the most that the rest can be make one and the same pixel, all between does, and the path
//! ends there. The functions stay monotone when rounded to doubles; balls enclose their results; and
//! double-double, which rounds by 2^-104, has [`ROOM`].

use glam::DVec3;

use super::{Bounce, Illumination, Shader};
use crate::image::Pixel;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::plan::Part;
use crate::scene::Scene;
use crate::surface::{SurfaceEval, SurfaceId, SurfaceSample};

/// Images whose paths have fewer reflections are none the quicker: of those in our scenes less than a
/// twentieth would be left out, and whether surfaces are constant has to be found out first.
const MIN_BOUNCES: u32 = 16;

/// A byte is 1/255 of what can be shown: as long as the rest may be more, it is not tried.
const SMALL: f64 = 1.0 / 256.0;

/// Where the rest is less, it is not tried either, lest `ROOM` is used up by roundings of double-double.
const TINY: f64 = SMALL * SMALL * SMALL * SMALL;

/// Bounds are larger by this share, for fewer than 2^30 roundings of 2^-53: each of [`MAX_TERMS`] lights,
/// reflections and factors of a power takes a few. What is left of it above [`TINY`] is 2^-52, beside
/// which roundings of double-double are nothing.
const ROOM: f64 = 1.0 / (1 << 20) as f64;

/// The most reflections and lights, and the highest exponent, for which that is room enough.
const MAX_TERMS: f64 = 65536.0;

/// What the rest of any path can be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    /// In all channels, at least and at most; infinite if that is not known.
    ends: [f64; 2],
    /// Whether some colours are all the same pixel.
    is_one_pixel: fn(&[[f64; 3]]) -> bool,
}

impl Rest {
    pub(super) const UNKNOWN: Rest =
        Rest { ends: [f64::NEG_INFINITY, f64::INFINITY], is_one_pixel: |_| false };

    /// What reflected light can be where all surfaces are constant.
    fn new<R: Real, P: Pixel>(
        scene: &Scene<R>,
        illumination: &Illumination,
        constant: impl FnMut(SurfaceId) -> Option<SurfaceSample>,
    ) -> Option<Self> {
        let is_one_pixel = |colors: &[[f64; 3]]| {
            let mut pixels = colors.iter().map(|color| P::from_linear(*color));
            let first = pixels.next();
            pixels.all(|pixel| Some(pixel) == first)
        };
        let samples = samples(scene, constant)?;
        let ends = if illumination.clamp_reflection {
            [-ROOM, 1.0 + ROOM]
        } else {
            let most = most(&samples, illumination)?;
            [-most, most].map(|end| end * (1.0 + ROOM))
        };
        Some(Rest { ends, is_one_pixel })
    }
}

/// What the surfaces of a scene answer, if all are constant.
fn samples<R: Real>(
    scene: &Scene<R>,
    mut constant: impl FnMut(SurfaceId) -> Option<SurfaceSample>,
) -> Option<Vec<SurfaceSample>> {
    let (mut samples, mut is_known) = (Vec::new(), Vec::new());
    for (_, surface) in scene.shapes() {
        let index = surface.0 as usize;
        is_known.resize(is_known.len().max(index + 1), false);
        if !std::mem::replace(&mut is_known[index], true) {
            samples.push(constant(surface)?);
        }
    }
    Some(samples)
}

/// A bound of the size of reflected light: what a point shows by itself is at most `local`, and of what
/// arrives there it reflects at most `factor`.
fn most(samples: &[SurfaceSample], illumination: &Illumination) -> Option<f64> {
    let Illumination { ambient, lights, max_bounces, .. } = illumination;
    let n_bounces = f64::from(*max_bounces);
    if n_bounces > MAX_TERMS || lights.len() as f64 > MAX_TERMS {
        return None;
    }
    let of_lights: f64 = lights.iter().map(|light| size(light.greatest())).sum();
    let of_lights = of_lights * illumination.attenuation.greatest();
    let (mut local, mut factor) = (0.0, 0.0);
    for SurfaceSample { color, kd, ks, phong_exp } in samples {
        if !(0.0..=MAX_TERMS).contains(phong_exp) {
            return None;
        }
        let [diffuse, specular] = [*kd, *ks].map(|k| size(DVec3::splat(k)));
        let tint = if illumination.tint_specular { size(*color) } else { 1.0 };
        let by_itself =
            diffuse * size(*color) * (size(*ambient) + of_lights) + specular * tint * of_lights;
        if !by_itself.is_finite() {
            return None;
        }
        local = f64::max(local, by_itself);
        factor = f64::max(factor, specular * tint);
    }
    let n_at_most = f64::min(1.0 / (1.0 - factor), n_bounces + 1.0);
    let most = local * n_at_most;
    (factor <= 1.0 && most.is_finite()).then_some(most)
}

/// The size of the largest entry, infinite if one is no number.
fn size(v: DVec3) -> f64 {
    if v.is_finite() { v.abs().max_element() } else { f64::INFINITY }
}

impl<R: Real, E: SurfaceEval> Shader<'_, R, E> {
    /// The same for light that becomes such pixels: paths end where their rest cannot change them.
    pub(crate) fn for_pixels<P: Pixel>(mut self) -> Self {
        let may_pay = self.illumination.max_bounces >= MIN_BOUNCES;
        if may_pay && self.scene.omissions.holds(Part::Rest) {
            let Shader { scene, illumination, surfaces, .. } = &mut self;
            let rest = Rest::new::<R, P>(scene, illumination, |surface| surfaces.constant(surface));
            self.rest = rest.unwrap_or(Rest::UNKNOWN);
        }
        self
    }

    /// About how much of the pixel the rest of the path can make up.
    #[inline(always)]
    pub(super) fn weight(&self) -> f64 {
        let factors = self.path.iter().map(|bounce| bounce.factor.max_norm().to_f64());
        factors.fold(self.rest.ends[1], |weight, factor| weight * factor)
    }

    /// Whether it may be worth the while to see if the rest changes the pixel, if it makes up so much.
    #[inline(always)]
    pub(super) fn may_end(weight: f64) -> bool {
        weight < SMALL && weight > TINY
    }

    /// The light that arrives at the eye along the path, if the pixel is the same whatever the rest of
    /// it is.
    #[cold]
    #[inline(never)]
    pub(super) fn without_rest(&self) -> Option<Vec3<R>> {
        let (last, before) = self.path.split_last()?;
        let [least, most] = self.rest.ends.map(|end| {
            let rest = Vec3::from_f64s([end; 3]);
            let light = last.local + last.factor.scaled_by(rest);
            before
                .iter()
                .rev()
                .fold(light, |light, bounce: &Bounce<R>| self.reflected(bounce, light))
        });
        let ends = |light: Vec3<R>| -> [[f64; 3]; 2] {
            let channels: [[f64; 2]; 3] = light.map(R::ends).into();
            [0, 1].map(|end| channels.map(|ends| ends[end]))
        };
        let colors = [ends(least), ends(most)];
        let is_finite = colors.as_flattened().as_flattened().iter().all(|c| c.is_finite());
        (is_finite && (self.rest.is_one_pixel)(colors.as_flattened())).then_some(most)
    }
}
