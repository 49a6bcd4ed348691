//! What a ray sees, by the equations of the language's manual.

use compiler::diagnostic::Diagnostic;
use renderer::camera::View;
use renderer::light::{Attenuation, Light};
use renderer::object::ShapeKind;
use renderer::shade::Illumination;
use renderer::surface::{SurfaceEval, SurfaceId, SurfacePoint};
use vm::surfaces::InterpSurfaces;

use crate::number::{
    Big, NOTHING, Vector, big, is_positive, power, sin_cos_degrees, to_f64, turns,
};
use crate::solid::{Crossing, Leaf, Line, Solid};

/// What a ray runs through at first.
#[derive(Clone, Copy, PartialEq)]
enum Medium {
    Unknown,
    Outside,
    Inside,
}

/// What is traced.
pub(crate) struct Scenery {
    pub(crate) solid: Solid,
    pub(crate) illumination: Illumination,
    view: View,
    /// Side of a pixel.
    pixel: Big,
    /// Of each spot the cosine below which it is dark, of other lights nothing of use.
    cos_cutoffs: Vec<Big>,
}

impl Scenery {
    pub(crate) fn new(solid: Solid, illumination: Illumination, view: View) -> Self {
        let (sin, cos) = sin_cos_degrees(view.fov_deg / 2.0);
        let pixel = big(2.0) * sin / cos / big(f64::from(view.width));
        let cos_cutoff = |light: &Light| match light {
            Light::Spot { cutoff_deg, .. } if *cutoff_deg < 180.0 => sin_cos_degrees(*cutoff_deg).1,
            _ => big(-2.0),
        };
        let cos_cutoffs = illumination.lights.iter().map(cos_cutoff).collect();
        Scenery { solid, illumination, view, pixel, cos_cutoffs }
    }
}

/// The tracer, for one thread.
pub(crate) struct Reference<'s> {
    scenery: &'s Scenery,
    surfaces: InterpSurfaces<'s>,
}

/// A light as a point sees it.
struct Arriving {
    /// Of length 1.
    toward: Vector,
    /// From the point to the light; none for infinity.
    way: Option<Vector>,
    intensity: Vector,
}

impl<'s> Reference<'s> {
    pub(crate) fn new(scenery: &'s Scenery, surfaces: InterpSurfaces<'s>) -> Self {
        Reference { scenery, surfaces }
    }

    /// The bytes of a pixel.
    pub(crate) fn pixel(&mut self, column: u32, row: u32) -> Result<[u8; 3], Box<Diagnostic>> {
        let Scenery { view, pixel, .. } = self.scenery;
        let (width, height) = (f64::from(view.width), f64::from(view.height));
        let across = big(f64::from(column) + 0.5 - width / 2.0) * pixel;
        let up = big(height / 2.0 - f64::from(row) - 0.5) * pixel;
        let ray = Line {
            origin: Vector::from_f64s([0.0, 0.0, -1.0]),
            dir: Vector([across, up, big(1.0)]),
        };
        let light = self.radiance(ray)?;
        Ok(light.0.map(|c| (255.0 * to_f64(&c).clamp(0.0, 1.0)) as u8))
    }

    fn radiance(&mut self, eye: Line) -> Result<Vector, Box<Diagnostic>> {
        let mut path = Vec::new();
        let mut next = Some((eye, Medium::Unknown));
        while let Some((ray, medium)) = next {
            let Some(crossing) = self.first(&ray, medium) else { break };
            next = self.bounce(&ray, &crossing, &mut path)?;
        }
        let mut light = Vector::zero();
        for (local, factor) in path.into_iter().rev() {
            if self.scenery.illumination.clamp_reflection {
                light = Vector(light.0.map(|c| c.clamp(big(0.0), big(1.0))));
            }
            light = light.by_component(&factor).plus(&local);
        }
        Ok(light)
    }

    /// The first boundary: of a ray that starts outside the first entry, inside the first exit.
    fn first(&self, ray: &Line, medium: Medium) -> Option<Crossing<'s>> {
        let counts = |crossing: &Crossing<'s>| match medium {
            Medium::Unknown => true,
            Medium::Outside => crossing.entering,
            Medium::Inside => !crossing.entering,
        };
        let crossings = self.scenery.solid.boundaries(ray).crossings;
        crossings.into_iter().find(|crossing| crossing.is_ahead() && counts(crossing))
    }

    /// Adds what a point shows by itself, and the factor of what it reflects.
    fn bounce(
        &mut self,
        ray: &Line,
        crossing: &Crossing<'_>,
        path: &mut Vec<(Vector, Vector)>,
    ) -> Result<Option<(Line, Medium)>, Box<Diagnostic>> {
        let Crossing { leaf, face, .. } = *crossing;
        let dir = ray.dir.unit().expect("a direction");
        let point = ray.origin.plus(&ray.dir.times(&crossing.t));
        let on_object = leaf.object_from_world.point(&point);
        let size = leaf.size_at(&ray.origin) + on_object.size();
        let on_object = Vector(on_object.0.map(|c| settled(c, size)));
        let medium = if crossing.entering { Medium::Outside } else { Medium::Inside };
        let normal =
            leaf.object_from_world.transposed(&gradient(leaf.kind, face, &on_object)).unit();
        let normal = normal.map(|normal| {
            let is_seen_from_behind = is_positive(&normal.dot(&dir));
            if is_seen_from_behind { Vector::zero().minus(&normal) } else { normal }
        });
        let at = texture(leaf, face, &on_object, size);
        let sample = self
            .surfaces
            .eval(SurfaceId(leaf.surface), &at)
            .map_err(|error| Box::new(error.into_diagnostic()))?;
        let (kd, ks) = (big(sample.kd), big(sample.ks));
        let color = Vector::from_f64s(sample.color.to_array());
        let mut diffuse =
            Vector::from_f64s(self.scenery.illumination.ambient.to_array()).times(&kd);
        let mut specular = Vector::zero();
        let lights =
            if normal.is_some() { self.scenery.illumination.lights.as_slice() } else { &[] };
        for (light, cos_cutoff) in lights.iter().zip(&self.scenery.cos_cutoffs) {
            let normal = normal.as_ref().expect("there is one");
            let Some(light) = self.arriving(light, cos_cutoff, &point) else { continue };
            let cos = normal.dot(&light.toward);
            if to_f64(&cos) < NOTHING || self.is_in_shadow(&point, &light, medium) {
                continue;
            }
            diffuse = diffuse.plus(&light.intensity.times(&(&kd * cos)));
            let halfway = light.toward.minus(&dir).unit();
            let highlight = halfway.map_or(big(0.0), |halfway| normal.dot(&halfway));
            if is_positive(&highlight) {
                let factor = &ks * power(&highlight, sample.phong_exp);
                specular = specular.plus(&light.intensity.times(&factor));
            }
        }
        let tint = |light: Vector| {
            if self.scenery.illumination.tint_specular { light.by_component(&color) } else { light }
        };
        let local = diffuse.by_component(&color).plus(&tint(specular));
        let factor = tint(Vector([ks.clone(), ks.clone(), ks]));
        let is_last = path.len() as u64 >= u64::from(self.scenery.illumination.max_bounces);
        path.push((local, factor));
        Ok(normal.filter(|_| sample.ks != 0.0 && !is_last).map(|normal| {
            let twice = big(2.0) * dir.dot(&normal);
            (Line { origin: point, dir: dir.minus(&normal.times(&twice)) }, medium)
        }))
    }

    fn is_in_shadow(&self, point: &Vector, light: &Arriving, medium: Medium) -> bool {
        let dir = light.way.as_ref().unwrap_or(&light.toward).clone();
        let ray = Line { origin: point.clone(), dir };
        self.first(&ray, medium).is_some_and(|crossing| {
            let beyond = to_f64(&(&crossing.t - big(1.0)));
            light.way.is_none() || beyond < -crossing.nothing
        })
    }

    /// The light at a point; none if it has no direction or the point is outside its cone.
    fn arriving(&self, light: &Light, cos_cutoff: &Big, point: &Vector) -> Option<Arriving> {
        let vector = |v: glam::DVec3| Vector::from_f64s(v.to_array());
        let (position, color, spot) = match *light {
            Light::Directional { dir, color } => {
                let toward = Vector::zero().minus(&vector(dir)).unit()?;
                return Some(Arriving { toward, way: None, intensity: vector(color) });
            }
            Light::Point { position, color } => (position, color, None),
            Light::Spot { position, at, color, exponent, .. } => {
                (position, color, Some((at, exponent)))
            }
        };
        let way = vector(position).minus(point);
        let toward = way.unit()?;
        let mut intensity = vector(color).times(&self.attenuation(&way.length()));
        if let Some((at, exponent)) = spot {
            let axis = vector(at).minus(&vector(position)).unit()?;
            let cos = -axis.dot(&toward);
            if to_f64(&(&cos - cos_cutoff)) < -NOTHING {
                return None;
            }
            intensity = intensity.times(&power(&cos.max(big(0.0)), exponent));
        }
        Some(Arriving { toward, way: Some(way), intensity })
    }

    fn attenuation(&self, distance: &Big) -> Big {
        let (numerator, [a0, a1, a2]) = match self.scenery.illumination.attenuation {
            Attenuation::Icfp => (100.0, [99.0, 0.0, 1.0]),
            Attenuation::Polynomial(coefficients) => (1.0, coefficients),
        };
        let denominator = big(a0) + big(a1) * distance + big(a2) * distance * distance;
        if is_positive(&denominator) { big(numerator) / denominator } else { big(0.0) }
    }
}

/// 0 for what is below 2^-80 of the terms that it was computed from.
fn settled(coordinate: Big, size: f64) -> Big {
    let is_nothing = to_f64(&coordinate).abs() < f64::exp2(-80.0) * size;
    if is_nothing { big(0.0) } else { coordinate }
}

/// The outward normal, of any length.
fn gradient(kind: ShapeKind, face: u8, p: &Vector) -> Vector {
    let [x, y, z] = p.0.clone();
    let along = Vector::from_f64s;
    match (kind, face) {
        (ShapeKind::Sphere, _) => Vector([x, y, z]),
        (ShapeKind::Cylinder, 0) => Vector([x, big(0.0), z]),
        (ShapeKind::Cone, 0) => Vector([x, -y, z]),
        (ShapeKind::Cube, 0) => along([0.0, 0.0, -1.0]),
        (ShapeKind::Cube, 1) => along([0.0, 0.0, 1.0]),
        (ShapeKind::Cube, 2) => along([-1.0, 0.0, 0.0]),
        (ShapeKind::Cube, 3) => along([1.0, 0.0, 0.0]),
        (ShapeKind::Cylinder, 2) | (ShapeKind::Cube, 5) => along([0.0, -1.0, 0.0]),
        _ => along([0.0, 1.0, 0.0]),
    }
}

/// The inverse of the table of texture coordinates, rounded to doubles.
fn texture(leaf: &Leaf, face: u8, p: &Vector, size: f64) -> SurfacePoint {
    let [x, y, z] = &p.0;
    let half = |a: &Big| (a + big(1.0)) / big(2.0);
    let around = || {
        let turns = to_f64(&turns(x, z));
        big(if turns < 1.0 { turns } else { 0.0 })
    };
    let (u, v) = match (leaf.kind, face) {
        (ShapeKind::Plane, _) => (x.clone(), z.clone()),
        (ShapeKind::Sphere, _) => (around(), half(y)),
        (ShapeKind::Cylinder | ShapeKind::Cone, 0) => (around(), y.clone()),
        (ShapeKind::Cylinder | ShapeKind::Cone, _) => (half(x), half(z)),
        (ShapeKind::Cube, 0 | 1) => (x.clone(), y.clone()),
        (ShapeKind::Cube, 2 | 3) => (z.clone(), y.clone()),
        (ShapeKind::Cube, _) => (x.clone(), z.clone()),
    };
    let [u, v] = [u, v].map(|coordinate| {
        let rounded = to_f64(&settled(coordinate, size));
        if leaf.kind == ShapeKind::Plane { rounded } else { rounded.clamp(0.0, 1.0) }
    });
    SurfacePoint { face, u, v }
}
