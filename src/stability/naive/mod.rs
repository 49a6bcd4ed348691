//! A ray tracer as textbooks have it, without care and without a hierarchy: the test double of the
//! stability suite, and a series of the charts.
//!
//! It does what the renderer does, but for what the suite is about. Rays have unit length, and start
//! to count an epsilon away from where they start; transforms are matrices, and their inverses are
//! computed. That it fails most of the cases shows that they ask for something. No image that anyone
//! asks for is made by it.

use std::collections::HashMap;
use std::sync::Arc;

use renderer::camera::{Region, View};
use renderer::light::{Attenuation, Light};
use renderer::shade::Illumination;
use renderer::surface::{SurfaceEval, SurfaceId};
use vm::host::RenderJob;
use vm::machine::Limits;
use vm::surfaces::InterpSurfaces;
use vm::value::Closure;

use self::solid::{Ray, Solid};
use self::vector::Vector;

pub(crate) use self::vector::Number;

mod solid;
mod vector;

/// The epsilon of the suite's column: what is nearer is where the ray starts.
pub(super) const EPSILON: f64 = 1e-6;

/// What a job looks like, in linear light.
pub(crate) struct Traced {
    /// Row by row from the upper left, those of the region alone; none where a surface function
    /// fails.
    pub(crate) pixels: Vec<Option<[f64; 3]>>,
    /// Rays toward lights that met something.
    pub(crate) n_blocked: u64,
}

/// A job's solid is nested deeper than this tracer can follow.
#[derive(Debug)]
pub(crate) struct TooDeep;

/// A job made ready for tracing.
pub(crate) struct Tracer<'p, F> {
    solid: Solid<F>,
    illumination: &'p Illumination,
    surfaces: InterpSurfaces<'p>,
    epsilon: F,
    n_blocked: u64,
}

/// What a point of a path shows, but for what it reflects.
struct Shown<F> {
    diffuse: Vector<F>,
    specular: Vector<F>,
    color: Vector<F>,
    ks: F,
    /// The ray that it reflects, if any.
    reflected: Option<Ray<F>>,
}

/// A surface function has failed.
struct Unanswered;

impl<'p, F: Number> Tracer<'p, F> {
    /// Prepares a job. What is nearer than `epsilon` is where a ray starts.
    ///
    /// # Errors
    /// When it is beyond this tracer's means.
    pub(crate) fn new(
        job: &'p RenderJob<'_>,
        functions: &'p [Arc<Closure>],
        illumination: &'p Illumination,
        limits: Limits,
        epsilon: f64,
    ) -> Result<Self, TooDeep> {
        let numbers: HashMap<_, _> = functions
            .iter()
            .zip(0..)
            .map(|(function, number)| (Arc::as_ptr(function), SurfaceId(number)))
            .collect();
        Ok(Tracer {
            solid: Solid::new(&job.object, &|function| numbers[&Arc::as_ptr(function)])?,
            illumination,
            surfaces: InterpSurfaces::new(job.program, functions, limits),
            epsilon: F::of(epsilon),
            n_blocked: 0,
        })
    }

    /// Traces the pixels that the view asks for. `progress` is told how many have been added.
    pub(crate) fn trace(mut self, view: &View, progress: &dyn Fn(u64)) -> Traced {
        let Region { x, y, width, height } = view.region;
        let mut pixels = Vec::new();
        for row in y..y + height {
            for column in x..x + width {
                let color = self.radiance(primary(view, column, row)).ok();
                pixels.push(color.map(|Vector(color)| color.map(F::double)));
            }
            progress(u64::from(width));
        }
        Traced { pixels, n_blocked: self.n_blocked }
    }

    /// The light that comes along a ray.
    fn radiance(&mut self, ray: Ray<F>) -> Result<Vector<F>, Unanswered> {
        let mut path = Vec::new();
        let mut next = Some(ray);
        while let Some(ray) = next {
            let is_last = path.len() as u64 >= u64::from(self.illumination.max_bounces);
            let Some(shown) = self.bounce(&ray)? else { break };
            next = shown.reflected.filter(|_| !is_last);
            path.push(shown);
        }
        let Illumination { clamp_reflection, tint_specular, .. } = *self.illumination;
        Ok(path.iter().rev().fold(Vector::zero(), |light, shown| {
            let light = if clamp_reflection { light.clamped() } else { light };
            let specular = shown.specular + light * shown.ks;
            let tint = |light: Vector<F>| light.scaled_by(shown.color);
            shown.diffuse + if tint_specular { tint(specular) } else { specular }
        }))
    }

    /// What the point shows that a ray meets, if it meets one.
    fn bounce(&mut self, ray: &Ray<F>) -> Result<Option<Shown<F>>, Unanswered> {
        let Some(hit) = self.solid.first_hit(ray, self.epsilon) else { return Ok(None) };
        let point = ray.at(hit.t);
        let outward = hit.shape.normal(&hit, point).normalized();
        let normal = if outward.dot(ray.dir) > F::zero() { -outward } else { outward };
        let texture = hit.shape.texture(&hit, point);
        let sample = self.surfaces.eval(hit.shape.surface, &texture).map_err(|_| Unanswered)?;
        let [kd, ks, exponent] = [sample.kd, sample.ks, sample.phong_exp].map(F::of);
        let mut diffuse = Vector::of(self.illumination.ambient) * kd;
        let mut specular = Vector::zero();
        for light in &self.illumination.lights {
            let (toward, distance, intensity) =
                arriving(light, point, self.illumination.attenuation);
            let cos = normal.dot(toward);
            if !(cos > F::zero() && intensity.0.into_iter().any(|c| c > F::zero())) {
                continue;
            }
            let shadow = Ray { origin: point, dir: toward };
            let blocker = self.solid.first_hit(&shadow, self.epsilon);
            if blocker.is_some_and(|blocker| blocker.t < distance - self.epsilon) {
                self.n_blocked += 1;
                continue;
            }
            diffuse = diffuse + intensity * (kd * cos);
            let highlight = normal.dot((toward - ray.dir).normalized());
            if highlight > F::zero() {
                specular = specular + intensity * (ks * highlight.powf(exponent));
            }
        }
        let color = Vector::of(sample.color);
        let twice = (F::one() + F::one()) * ray.dir.dot(normal);
        let dir = (ray.dir - normal * twice).normalized();
        let reflected = (sample.ks != 0.0).then_some(Ray { origin: point, dir });
        let diffuse = diffuse.scaled_by(color);
        Ok(Some(Shown { diffuse, specular, color, ks, reflected }))
    }
}

/// From the eye through a pixel, whose place is measured from the upper left corner.
fn primary<F: Number>(view: &View, x: u32, y: u32) -> Ray<F> {
    let half = F::of(0.5);
    let width = F::of(2.0) * (F::of(view.fov_deg).to_radians() * half).tan();
    let pixel = width / F::of(f64::from(view.width));
    let height = pixel * F::of(f64::from(view.height));
    let across = -width * half + (F::of(f64::from(x)) + half) * pixel;
    let up = height * half - (F::of(f64::from(y)) + half) * pixel;
    Ray { origin: -Vector::axis(2), dir: Vector([across, up, F::one()]).normalized() }
}

/// Unit vector toward a light, its distance, and what would arrive of it.
fn arriving<F: Number>(
    light: &Light,
    point: Vector<F>,
    attenuation: Attenuation,
) -> (Vector<F>, F, Vector<F>) {
    let (position, color) = match *light {
        Light::Directional { dir, color } => {
            let dir = Vector::<F>::of(dir);
            return (-dir / dir.length(), F::infinity(), Vector::of(color));
        }
        Light::Point { position, color } | Light::Spot { position, color, .. } => (position, color),
    };
    let to_light = Vector::of(position) - point;
    let distance = to_light.length();
    let toward = to_light / distance;
    let spot = match *light {
        Light::Spot { at, cutoff_deg, exponent, .. } => {
            let axis = (Vector::of(at) - Vector::of(position)).normalized();
            let cos = (-axis).dot(toward);
            let is_outside = cos < F::of(cutoff_deg).to_radians().cos();
            if is_outside { F::zero() } else { cos.powf(F::of(exponent)) }
        }
        _ => F::one(),
    };
    let (numerator, [a0, a1, a2]) = match attenuation {
        Attenuation::Icfp => (100.0, [99.0, 0.0, 1.0]),
        Attenuation::Polynomial(coefficients) => (1.0, coefficients),
    };
    let [a0, a1, a2] = [a0, a1, a2].map(F::of);
    let fading = F::of(numerator) / (a0 + a1 * distance + a2 * distance * distance);
    (toward, distance, Vector::of(color) * spot * fading)
}
