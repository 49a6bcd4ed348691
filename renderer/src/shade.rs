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

use crate::camera::{Grid, ImagePoint};
use crate::light::{Attenuation, Lamp, Light};
use crate::numeric::dd::Dd;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::ShapeKind;
use crate::obstacles::Obstacles;
use crate::plan::Part;
use crate::probe::Seen;
use crate::ray::{Crossing, Medium, On, Ray};
use crate::scene::Scene;
use crate::shape;
use crate::signature::Signature;
use crate::surface::{
    Bounded, BoundedPoint, BoundedSample, Locate, LocateBounded, Needs, SurfaceEval, SurfaceId,
    SurfacePoint, SurfaceSample,
};
use crate::trace::Workspace;

mod ahead;
mod direct;
mod rest;

pub(crate) use ahead::Ahead;
use rest::Rest;

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

impl std::iter::Sum for RayCounts {
    fn sum<I: Iterator<Item = RayCounts>>(parts: I) -> Self {
        parts.fold(RayCounts::default(), |mut all, part| {
            all.add(&part);
            all
        })
    }
}

/// Follows rays through a scene, for one thread.
pub(crate) struct Shader<'s, R, E> {
    scene: &'s Scene<R>,
    /// What is seen of it.
    grid: Grid<R>,
    illumination: &'s Illumination,
    lamps: Vec<Lamp<R>>,
    /// For each lamp, what may be in its way.
    obstacles: Vec<Obstacles>,
    /// For each lamp, the component that was found last to be in its way.
    blockers: Vec<Option<u32>>,
    ambient: Vec3<R>,
    pub(crate) surfaces: E,
    workspace: Workspace<R>,
    /// The path so far.
    path: Vec<Bounce<R>>,
    rest: Rest,
    /// What the colour that was found last hangs on and could not be decided for certain, if numbers
    /// keep account of that: the first of it.
    pub(crate) doubt: Option<Doubt>,
    /// Whether the colour is of no use in case of doubt.
    gives_up: bool,
    /// What has been decided on the path so far, if that is asked for.
    signature: Signature,
    pub(crate) counts: RayCounts,
}

/// What could not be decided for certain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// Which boundary a ray meets first.
    Boundary,
    /// Whether a light reaches a point.
    Light,
    /// What the surface function does.
    Surface,
    /// What the colour is as a pixel.
    Color,
}

/// What a surface function answers, in the tracer's numbers.
struct Sample<R> {
    color: Vec3<R>,
    kd: R,
    ks: R,
    phong_exp: f64,
}

impl<R: Real> Sample<R> {
    fn new(sample: &SurfaceSample) -> Self {
        Sample {
            color: Vec3::from_dvec3(sample.color),
            kd: R::from_f64(sample.kd),
            ks: R::from_f64(sample.ks),
            phong_exp: sample.phong_exp,
        }
    }

    /// None if the exponent is not known exactly.
    #[inline(always)]
    fn of_bounded(sample: &BoundedSample) -> Option<Self> {
        let number = |x: Bounded| R::from_bounded(Dd::from(x.value), x.error);
        let [red, green, blue] = sample.color.map(number);
        (sample.phong_exp.error == 0.0).then(|| Sample {
            color: Vec3::new(red, green, blue),
            kd: number(sample.kd),
            ks: number(sample.ks),
            phong_exp: sample.phong_exp.value,
        })
    }

    /// What stands for an unknown answer.
    fn black() -> Self {
        Sample { color: Vec3::ZERO, kd: R::ZERO, ks: R::ZERO, phong_exp: 0.0 }
    }
}

/// What a point of a path shows.
#[derive(Clone, Copy)]
struct Bounce<R> {
    /// By itself.
    local: Vec3<R>,
    /// Of each colour that arrives from where it reflects.
    factor: Vec3<R>,
}

/// What a point of a path shows, and the reflected ray, unless that cannot matter.
type Bounced<R> = (Bounce<R>, Option<Ray<R>>);

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

impl<R: Real> Place<R> {
    /// The texture coordinates, 0 where they are not needed.
    #[inline]
    fn coordinates(&self, needs: Needs) -> [R; 2] {
        let Place { kind, face, point, size } = *self;
        let u = if needs.u { shape::texture_u(kind, face, point) } else { R::ZERO };
        let v = if needs.v { shape::texture_v(kind, face, point) } else { R::ZERO };
        [u, v].map(|coordinate| shape::settled(coordinate, size))
    }
}

impl<R: Real> Locate for Place<R> {
    #[inline]
    fn locate(&self, needs: Needs) -> SurfacePoint {
        let [u, v] = self.coordinates(needs).map(R::nearest_double);
        SurfacePoint { face: self.face, u, v }
    }
}

impl<R: Real> LocateBounded for Place<R> {
    #[inline]
    fn locate_bounded(&self, needs: Needs) -> BoundedPoint {
        // The coordinates are meant to be rounded to doubles, which the nearest may be half a unit
        // away from; what is exact is a double already.
        let bounded = |x: R| {
            let (value, radius) = (x.to_f64(), x.radius());
            let rounding = f64::EPSILON * (value.abs() + radius);
            Bounded { value, error: if radius == 0.0 { 0.0 } else { radius + rounding } }
        };
        let [u, v] = self.coordinates(needs).map(bounded);
        BoundedPoint { face: self.face, u, v }
    }
}

impl<'s, R: Real, E: SurfaceEval> Shader<'s, R, E> {
    pub(crate) fn new(
        scene: &'s Scene<R>,
        grid: Grid<R>,
        illumination: &'s Illumination,
        surfaces: E,
    ) -> Self {
        let lamp = |light| Lamp::new(light, illumination.attenuation, scene.omissions);
        let lamps: Vec<Lamp<R>> = illumination.lights.iter().map(lamp).collect();
        Shader {
            scene,
            grid,
            illumination,
            obstacles: lamps.iter().map(|lamp| Obstacles::new(scene, lamp.whence())).collect(),
            blockers: vec![None; lamps.len()],
            lamps,
            ambient: Vec3::from_dvec3(illumination.ambient),
            surfaces,
            workspace: Workspace::new(scene),
            path: Vec::new(),
            rest: Rest::UNKNOWN,
            doubt: None,
            gives_up: false,
            signature: Signature::NONE,
            counts: RayCounts::default(),
        }
    }

    /// The same, but in case of doubt it need not find the colour.
    pub(crate) fn giving_up(self) -> Self {
        Shader { gives_up: true, ..self }
    }

    /// Sees whether there was a doubt since this was done last.
    #[inline(always)]
    fn notice(&mut self, doubt: Doubt) {
        if R::take_doubt() {
            self.doubt.get_or_insert(doubt);
        }
    }

    /// Whether what it would find is of no use.
    #[inline(always)]
    fn has_given_up(&self) -> bool {
        self.gives_up && self.doubt.is_some()
    }

    /// What is first met at a point of the image plane.
    pub(crate) fn seen(&mut self, from: ImagePoint) -> Option<Seen> {
        let ray = self.eye_ray(from);
        let crossing = self.scene.first_hit(&ray, &mut self.workspace)?;
        let (hit, place) = self.hit(&ray, ray.dir, crossing);
        let leaf = &self.scene.leaves[crossing.leaf() as usize];
        Some(Seen {
            shape: crossing.leaf() as usize,
            kind: leaf.kind,
            surface: self.scene.details[crossing.leaf() as usize].surface,
            at: place.locate(Needs::ALL),
            point: hit.point.to_dvec3(),
            distance: crossing.t.to_f64() * ray.dir.to_dvec3().length(),
        })
    }

    /// The light that arrives at the eye from a point of the image plane; black where there is nothing.
    #[inline(never)]
    pub(crate) fn radiance(&mut self, from: ImagePoint) -> Result<Vec3<R>, E::Error> {
        self.follow::<false>(from)
    }

    /// The same, and what was decided on the way: which faces were met, which lamps reach them, and
    /// what their surface functions have decided.
    #[inline(never)]
    pub(crate) fn signed_radiance(
        &mut self,
        from: ImagePoint,
    ) -> Result<(Vec3<R>, Signature), E::Error> {
        self.signature = Signature::NONE;
        let light = self.follow::<true>(from)?;
        Ok((light, self.signature))
    }

    /// Takes a decision into account, if that is asked for.
    #[inline(always)]
    fn sign<const SIGNED: bool>(&mut self, decision: u64) {
        if SIGNED {
            self.signature = self.signature.with(decision);
        }
    }

    #[inline(always)]
    fn follow<const SIGNED: bool>(&mut self, from: ImagePoint) -> Result<Vec3<R>, E::Error> {
        self.start();
        let ray = self.eye_ray(from);
        self.go_on::<SIGNED>(ray)
    }

    /// The ray from the eye through a point of the image plane.
    #[inline(always)]
    fn eye_ray(&mut self, from: ImagePoint) -> Ray<R> {
        self.workspace.tiles.enter(from, &self.grid, self.scene);
        self.grid.ray(from)
    }

    /// Begins a path.
    #[inline(always)]
    fn start(&mut self) {
        self.counts.primary += 1;
        self.path.clear();
        self.doubt = None;
    }

    /// The light that arrives at the eye along the path so far from the end of this ray.
    #[inline(always)]
    fn go_on<const SIGNED: bool>(&mut self, ray: Ray<R>) -> Result<Vec3<R>, E::Error> {
        let (mut ray, mut light, mut weight) = (ray, Vec3::ZERO, self.weight());
        while let Some(crossing) = self.scene.first_hit(&ray, &mut self.workspace) {
            self.notice(Doubt::Boundary);
            if self.has_given_up() {
                break;
            }
            let (bounce, reflected) = self.bounce::<SIGNED>(&ray, crossing)?;
            let Some(reflected) = reflected else {
                light = self.reflected(&bounce, light);
                break;
            };
            weight *= bounce.factor.max_norm().to_f64();
            self.path.push(bounce);
            if !SIGNED
                && Self::may_end(weight)
                && let Some(light) = self.without_rest()
            {
                self.counts.reflected -= 1;
                return Ok(light);
            }
            ray = reflected;
        }
        self.notice(Doubt::Boundary);
        for bounce in self.path.iter().rev() {
            light = self.reflected(bounce, light);
        }
        Ok(light)
    }

    /// The light from a point at which this light arrives from where it reflects.
    #[inline(always)]
    fn reflected(&self, bounce: &Bounce<R>, mut light: Vec3<R>) -> Vec3<R> {
        if self.illumination.clamp_reflection {
            light = light.map(|c| c.max(R::ZERO).min(R::ONE));
        }
        bounce.local + bounce.factor.scaled_by(light)
    }

    /// What the point that a ray has met shows, and the reflected ray, unless that cannot matter.
    #[inline(always)]
    fn bounce<const SIGNED: bool>(
        &mut self,
        ray: &Ray<R>,
        crossing: Crossing<R>,
    ) -> Result<Bounced<R>, E::Error> {
        let dir = ray.dir.normalized().unwrap_or(Vec3::ZERO);
        let (hit, at) = self.hit(ray, dir, crossing);
        self.notice(Doubt::Boundary);
        let side = u64::from(at.face) << 1 | u64::from(crossing.is_entry());
        self.sign::<SIGNED>(u64::from(crossing.leaf()) << 32 | side);
        let surface = self.scene.details[crossing.leaf() as usize].surface;
        let sample = self.sample::<SIGNED>(surface, &at)?;
        self.lit::<SIGNED>(dir, &hit, &sample)
    }

    /// What a point with this sample shows that is seen in a direction, and the reflected ray, unless
    /// that cannot matter. It never fails: it returns what its caller does, so that nothing is moved.
    #[inline(always)]
    fn lit<const SIGNED: bool>(
        &mut self,
        dir: Vec3<R>,
        hit: &Hit<R>,
        sample: &Sample<R>,
    ) -> Result<Bounced<R>, E::Error> {
        let (diffuse, specular) = self.direct_light::<SIGNED>(hit, dir, sample);
        self.notice(Doubt::Light);
        let Sample { color, ks, .. } = *sample;
        let tint = |light: Vec3<R>| {
            if self.illumination.tint_specular { light.scaled_by(color) } else { light }
        };
        let local = diffuse.scaled_by(color) + tint(specular);
        let bounce = Bounce { local, factor: tint(Vec3::new(ks, ks, ks)) };
        let is_last = self.path.len() as u64 >= u64::from(self.illumination.max_bounces);
        let reflects = !is_last && ks != R::ZERO;
        self.notice(Doubt::Surface);
        let Some(normal) = hit.normal.filter(|_| reflects && !self.has_given_up()) else {
            return Ok((bounce, None));
        };
        self.counts.reflected += 1;
        let twice = dir.dot(normal) * R::from_f64(2.0);
        let reflected = dir - normal * twice;
        let (origin, on, medium) = (hit.point, Some(hit.on), hit.medium);
        Ok((bounce, Some(Ray { origin, dir: reflected, on, medium })))
    }

    /// Asks the surface function.
    #[inline(always)]
    fn sample<const SIGNED: bool>(
        &mut self,
        surface: SurfaceId,
        at: &Place<R>,
    ) -> Result<Sample<R>, E::Error> {
        self.counts.surface_calls += 1;
        if SIGNED {
            let (sample, Signature(decisions)) = self.surfaces.eval_signed(surface, at)?;
            self.sign::<SIGNED>(decisions);
            return Ok(Sample::new(&sample));
        }
        if !R::ASKS_FOR_BOUNDS {
            let sample = if self.scene.omissions.holds(Part::Coordinates) {
                self.surfaces.eval(surface, at)?
            } else {
                self.eval_at_all_coordinates(surface, at)?
            };
            self.notice(Doubt::Surface);
            return Ok(Sample::new(&sample));
        }
        let bounded = self.surfaces.eval_bounded(surface, at);
        self.notice(Doubt::Surface);
        Ok(bounded.as_ref().and_then(Sample::of_bounded).unwrap_or_else(|| {
            self.doubt.get_or_insert(Doubt::Surface);
            Sample::black()
        }))
    }

    #[cold]
    #[inline(never)]
    fn eval_at_all_coordinates(
        &mut self,
        surface: SurfaceId,
        at: &Place<R>,
    ) -> Result<SurfaceSample, E::Error> {
        self.surfaces.eval(surface, &at.locate(Needs::ALL))
    }

    #[inline(always)]
    fn hit(&self, ray: &Ray<R>, dir: Vec3<R>, crossing: Crossing<R>) -> (Hit<R>, Place<R>) {
        let leaf = &self.scene.leaves[crossing.leaf() as usize];
        let face = crossing.root().face();
        let local = self.scene.local_ray(crossing.leaf(), ray);
        let computed = shape::hit_point(leaf.kind, &local, crossing.root());
        let size = leaf.origin_size(ray) + computed.max_norm().to_f64();
        let point = computed.map(|coordinate| shape::settled(coordinate, size));
        let outward = shape::normal(leaf.kind, face, point);
        let [world_point, outward] = self.scene.in_world(crossing.leaf(), point, outward);
        let normal = outward.normalized().map(|n| if n.dot(dir) > R::ZERO { -n } else { n });
        let on = On { leaf: crossing.leaf(), surface: self.scene.face_surface(leaf, face), point };
        let medium = if crossing.is_entry() { Medium::Outside } else { Medium::Inside };
        let hit = Hit { on, point: world_point, normal, medium };
        (hit, Place { kind: leaf.kind, face, point, size })
    }
}
