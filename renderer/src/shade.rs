//! What a ray sees: the illumination equations, along a path of reflections.
//!
//! The equations are (reference 4.7)
//!
//! ```text
//! ICFP:     I = (kd (Ia + Σ (N·Lj) Ij) + ks (Σ (N·Hj)^n Ij + Is)) C
//! Chicago:  I =  kd (Ia + Σ (N·Lj) Ij) C + ks (Σ (N·Hj)^n Ij + clamp(Is))
//! ```
//!
//! so that each bounce contributes `local + factor Is`: paths are followed by iteration and summed
//! up from their ends, however long they are.

use glam::DVec3;

use crate::light::{Arriving, Attenuation, Lamp, Light};
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::ShapeKind;
use crate::ray::{Crossing, Medium, On, Ray, TIE_ROUNDINGS};
use crate::scene::Scene;
use crate::shape;
use crate::surface::{Locate, Needs, SurfaceEval, SurfacePoint, SurfaceSample};
use crate::trace::Workspace;

/// Light, and how surfaces answer it.
#[derive(Clone, Debug)]
pub struct Illumination {
    /// Ambient light, linear RGB.
    pub ambient: DVec3,
    /// The lights, in order.
    pub lights: Vec<Light>,
    /// How point and spot lights grow weaker.
    pub attenuation: Attenuation,
    /// Whether highlights and reflections take on the surface's colour (ICFP).
    pub tint_specular: bool,
    /// Whether reflected light is clamped to [0, 1] before use (Chicago).
    pub clamp_reflection: bool,
    /// The most reflections along one path.
    pub max_bounces: u32,
}

/// How many rays an image took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Rays from the eye.
    pub primary: u64,
    /// Reflected rays.
    pub reflected: u64,
    /// Rays toward lights.
    pub shadow: u64,
    /// Rays toward lights that met something.
    pub blocked: u64,
    /// Calls of surface functions.
    pub surface_calls: u64,
}

impl RayCounts {
    /// Adds the counts of another part of the image.
    pub fn add(&mut self, other: &RayCounts) {
        self.primary += other.primary;
        self.reflected += other.reflected;
        self.shadow += other.shadow;
        self.blocked += other.blocked;
        self.surface_calls += other.surface_calls;
    }
}

/// Follows rays through a scene, for one thread.
pub(crate) struct Shader<'s, R, E> {
    scene: &'s Scene<R>,
    illumination: &'s Illumination,
    lamps: Vec<Lamp<R>>,
    ambient: Vec3<R>,
    surfaces: E,
    workspace: Workspace<R>,
    /// The path so far: what each point shows by itself, and the factor of what it reflects.
    path: Vec<(Vec3<R>, Vec3<R>)>,
    pub(crate) counts: RayCounts,
}

/// The point that a ray has met.
struct Hit<R> {
    on: On<R>,
    point: Vec3<R>,
    /// Unit normal on the viewer's side; none where the surface has none.
    normal: Option<Vec3<R>>,
    /// The medium that the viewer is in.
    medium: Medium,
}

/// The same point in its solid's object space.
struct Place<R> {
    kind: ShapeKind,
    face: u8,
    point: Vec3<R>,
    /// Of the terms that it was computed from.
    size: f64,
}

impl<R: Real> Locate for Place<R> {
    #[inline]
    fn locate(&self, needs: Needs) -> SurfacePoint {
        let Place { kind, face, point, size } = *self;
        let u = if needs.u { shape::texture_u(kind, face, point) } else { 0.0 };
        let v = if needs.v { shape::texture_v(kind, face, point) } else { 0.0 };
        let [u, v] = [u, v].map(|coordinate| shape::settled(coordinate, size));
        SurfacePoint { face, u, v }
    }
}

impl<'s, R: Real, E: SurfaceEval> Shader<'s, R, E> {
    pub(crate) fn new(scene: &'s Scene<R>, illumination: &'s Illumination, surfaces: E) -> Self {
        Shader {
            scene,
            illumination,
            lamps: illumination.lights.iter().map(Lamp::new).collect(),
            ambient: Vec3::from_dvec3(illumination.ambient),
            surfaces,
            workspace: Workspace::new(scene),
            path: Vec::new(),
            counts: RayCounts::default(),
        }
    }

    /// The light that arrives along a ray from the eye; black where it meets nothing.
    pub(crate) fn radiance(&mut self, ray: Ray<R>) -> Result<Vec3<R>, E::Error> {
        self.counts.primary += 1;
        self.path.clear();
        let mut next = Some(ray);
        while let Some(ray) = next {
            let Some(crossing) = self.scene.first_hit(&ray, &mut self.workspace) else { break };
            next = self.bounce(&ray, &crossing)?;
        }
        let mut light: Vec3<R> = Vec3::ZERO;
        for &(local, factor) in self.path.iter().rev() {
            if self.illumination.clamp_reflection {
                light = light.map(|c| c.max(R::ZERO).min(R::ONE));
            }
            light = local + factor.scaled_by(light);
        }
        Ok(light)
    }

    /// Adds a point to the path. Returns the reflected ray, unless it cannot matter.
    fn bounce(&mut self, ray: &Ray<R>, crossing: &Crossing<R>) -> Result<Option<Ray<R>>, E::Error> {
        let dir = ray.dir.normalized().unwrap_or(Vec3::ZERO);
        let (hit, at) = self.hit(ray, dir, crossing);
        self.counts.surface_calls += 1;
        let surface = self.scene.leaves[crossing.leaf as usize].surface;
        let sample = self.surfaces.eval(surface, &at)?;
        let (diffuse, specular) = self.direct_light(&hit, dir, &sample);
        let color = Vec3::from_dvec3(sample.color);
        let ks = R::from_f64(sample.ks);
        let tint = |light: Vec3<R>| {
            if self.illumination.tint_specular { light.scaled_by(color) } else { light }
        };
        let local = diffuse.scaled_by(color) + tint(specular);
        let factor = tint(Vec3::new(ks, ks, ks));
        let is_last = self.path.len() as u64 >= u64::from(self.illumination.max_bounces);
        self.path.push((local, factor));
        let Some(normal) = hit.normal.filter(|_| sample.ks != 0.0 && !is_last) else {
            return Ok(None);
        };
        self.counts.reflected += 1;
        let twice = dir.dot(normal) * R::from_f64(2.0);
        let reflected = dir - normal * twice;
        Ok(Some(Ray { origin: hit.point, dir: reflected, on: Some(hit.on), medium: hit.medium }))
    }

    fn hit(&self, ray: &Ray<R>, dir: Vec3<R>, crossing: &Crossing<R>) -> (Hit<R>, Place<R>) {
        let leaf = &self.scene.leaves[crossing.leaf as usize];
        let face = crossing.root.face;
        let local = self.scene.local_ray(crossing.leaf, ray);
        let computed = shape::hit_point(leaf.kind, &local, crossing.root);
        let size = leaf.origin_size(ray) + computed.max_norm().to_f64();
        let point = computed.map(|coordinate| shape::settled(coordinate, size));
        let outward =
            leaf.object_from_world.transposed_vector(shape::normal(leaf.kind, face, point));
        let normal = outward.normalized().map(|n| if n.dot(dir) > R::ZERO { -n } else { n });
        let on = On { leaf: crossing.leaf, surface: self.scene.face_surface(leaf, face), point };
        let medium = if crossing.entering { Medium::Outside } else { Medium::Inside };
        let hit = Hit { on, point: leaf.world_from_object.point(point), normal, medium };
        (hit, Place { kind: leaf.kind, face, point, size })
    }

    /// The light of ambient light and lamps: diffuse, still without the surface's colour, and
    /// specular.
    fn direct_light(
        &mut self,
        hit: &Hit<R>,
        dir: Vec3<R>,
        sample: &SurfaceSample,
    ) -> (Vec3<R>, Vec3<R>) {
        let (kd, ks) = (R::from_f64(sample.kd), R::from_f64(sample.ks));
        let mut diffuse = self.ambient * kd;
        let mut specular = Vec3::ZERO;
        let Some(normal) = hit.normal else { return (diffuse, specular) };
        for idx in 0..self.lamps.len() {
            let Some(light) = self.lamps[idx].arriving(hit.point, self.illumination.attenuation)
            else {
                continue;
            };
            let cos = normal.dot(light.toward);
            // A light behind the surface does not reach the viewer's side, nor does one in its plane,
            // as far as rounding can tell; NaN reaches nothing.
            let faces_light = cos.to_f64() > TIE_ROUNDINGS * R::UNIT_ROUNDOFF;
            if !faces_light || self.is_in_shadow(hit, &light) {
                continue;
            }
            diffuse = diffuse + light.intensity * (kd * cos);
            if sample.ks == 0.0 {
                continue;
            }
            let halfway = (light.toward - dir).normalized();
            let highlight = halfway.map_or(R::ZERO, |h| normal.dot(h));
            if highlight > R::ZERO {
                specular =
                    specular + light.intensity * (ks * R::power(highlight, sample.phong_exp));
            }
        }
        (diffuse, specular)
    }

    fn is_in_shadow(&mut self, hit: &Hit<R>, light: &Arriving<R>) -> bool {
        self.counts.shadow += 1;
        let ray =
            Ray { origin: hit.point, dir: light.shadow_dir, on: Some(hit.on), medium: hit.medium };
        let is_blocked = self.scene.is_blocked(&ray, light.shadow_end, &mut self.workspace);
        self.counts.blocked += u64::from(is_blocked);
        is_blocked
    }
}
