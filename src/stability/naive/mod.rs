//! A ray tracer as textbooks have it, in doubles and without care: the suite's test double.
//!
//! It does what the renderer does, but for what the suite is about. Rays have unit length, and start
//! to count an epsilon away from where they start; transforms are matrices, and their inverses are
//! computed. That it fails most of the cases shows that they ask for something. No image that anyone
//! asks for is made by it.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use renderer::camera::View;
use renderer::image::Pixel;
use renderer::light::{Attenuation, Light};
use renderer::shade::Illumination;
use renderer::surface::{SurfaceEval, SurfaceId};
use vm::host::{Dialect, RenderJob};
use vm::surfaces::{self, InterpSurfaces};

use self::solid::{Ray, Solid};
use super::LIMITS;
use super::image::Image;

mod solid;

/// What is nearer than this is where the ray starts.
const EPSILON: f64 = 1e-6;

const EYE: DVec3 = DVec3::NEG_Z;

/// The image of a job; no pixel where a surface function fails.
pub(super) fn render(job: &RenderJob<'_>) -> Image {
    let (_, functions) = surfaces::scene::<f64>(&job.object);
    let numbers: HashMap<_, _> =
        functions.iter().zip(0..).map(|(f, number)| (Arc::as_ptr(f), SurfaceId(number))).collect();
    let mut tracer = Tracer {
        solid: Solid::new(&job.object, DAffine3::IDENTITY, &|f| numbers[&Arc::as_ptr(f)]),
        illumination: job.illumination(Dialect::Auto),
        surfaces: InterpSurfaces::new(job.program, &functions, LIMITS),
        n_blocked: 0,
    };
    let view = View::whole(job.width, job.height, job.fov_deg);
    let bounces = tracer.illumination.max_bounces;
    let places = (0..job.height).flat_map(|y| (0..job.width).map(move |x| (x, y)));
    let pixels = places
        .map(|(x, y)| {
            let color = tracer.radiance(&primary(&view, x, y), bounces)?;
            Some(<[u8; 3]>::from_linear(color.to_array()))
        })
        .collect();
    Image { width: job.width, height: job.height, pixels, n_blocked: tracer.n_blocked }
}

/// From the eye through a pixel, whose place is measured from the upper left corner.
fn primary(view: &View, x: u32, y: u32) -> Ray {
    let width = 2.0 * (view.fov_deg.to_radians() / 2.0).tan();
    let pixel = width / f64::from(view.width);
    let height = pixel * f64::from(view.height);
    let across = -width / 2.0 + (f64::from(x) + 0.5) * pixel;
    let up = height / 2.0 - (f64::from(y) + 0.5) * pixel;
    Ray { origin: EYE, dir: DVec3::new(across, up, 1.0).normalize() }
}

struct Tracer<'p> {
    solid: Solid,
    illumination: Illumination,
    surfaces: InterpSurfaces<'p>,
    n_blocked: u64,
}

impl Tracer<'_> {
    /// The light that comes along a ray, with so many reflections at most; none if a surface
    /// function fails.
    fn radiance(&mut self, ray: &Ray, bounces: u32) -> Option<DVec3> {
        let Some(hit) = self.solid.first_hit(ray) else { return Some(DVec3::ZERO) };
        let point = ray.at(hit.t);
        let outward = hit.shape.normal(&hit, point).normalize();
        let normal = if outward.dot(ray.dir) > 0.0 { -outward } else { outward };
        let texture = hit.shape.texture(&hit, point);
        let sample = self.surfaces.eval(hit.shape.surface, &texture).ok()?;
        let mut diffuse = self.illumination.ambient * sample.kd;
        let mut specular = DVec3::ZERO;
        for light in &self.illumination.lights {
            let (toward, distance, intensity) =
                arriving(light, point, self.illumination.attenuation);
            let cos = normal.dot(toward);
            if !(cos > 0.0 && intensity.max_element() > 0.0) {
                continue;
            }
            let blocker = self.solid.first_hit(&Ray { origin: point, dir: toward });
            if blocker.is_some_and(|blocker| blocker.t < distance - EPSILON) {
                self.n_blocked += 1;
                continue;
            }
            diffuse += sample.kd * cos * intensity;
            let highlight = normal.dot((toward - ray.dir).normalize());
            if highlight > 0.0 {
                specular += sample.ks * highlight.powf(sample.phong_exp) * intensity;
            }
        }
        if bounces > 0 && sample.ks != 0.0 {
            let dir = (ray.dir - 2.0 * ray.dir.dot(normal) * normal).normalize();
            let reflected = self.radiance(&Ray { origin: point, dir }, bounces - 1)?;
            specular += sample.ks * reflected.clamp(DVec3::ZERO, DVec3::ONE);
        }
        Some(diffuse * sample.color + specular)
    }
}

/// Unit vector toward a light, its distance, and what would arrive of it.
fn arriving(light: &Light, point: DVec3, attenuation: Attenuation) -> (DVec3, f64, DVec3) {
    let (position, color) = match *light {
        Light::Directional { dir, color } => return (-dir / dir.length(), f64::INFINITY, color),
        Light::Point { position, color } | Light::Spot { position, color, .. } => (position, color),
    };
    let distance = (position - point).length();
    let toward = (position - point) / distance;
    let spot = match *light {
        Light::Spot { at, cutoff_deg, exponent, .. } => {
            let cos = -(at - position).normalize().dot(toward);
            if cos < cutoff_deg.to_radians().cos() { 0.0 } else { cos.powf(exponent) }
        }
        _ => 1.0,
    };
    let fading = match attenuation {
        Attenuation::Icfp => 100.0 / (99.0 + distance * distance),
        Attenuation::Polynomial([a0, a1, a2]) => {
            1.0 / (a0 + a1 * distance + a2 * distance * distance)
        }
    };
    (toward, distance, color * spot * fading)
}
