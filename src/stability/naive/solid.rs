//! Solids of the naive tracer: transforms as products and inverses of matrices, roots by the
//! schoolbook's formula, set operations by asking whether the point that was hit is inside.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use renderer::object::{NodeKind, Object, SetOp, ShapeKind, TransformOp};
use renderer::surface::{SurfaceId, SurfacePoint};
use vm::value::Closure;

use super::EPSILON;

/// A line with a direction.
#[derive(Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: DVec3,
    pub(super) dir: DVec3,
}

impl Ray {
    pub(super) fn at(&self, t: f64) -> DVec3 {
        self.origin + self.dir * t
    }
}

/// What a ray may meet.
pub(super) enum Solid {
    Shape(Shape),
    Combined(SetOp, Box<[Solid; 2]>),
}

/// A shape where it stands.
pub(super) struct Shape {
    kind: ShapeKind,
    pub(super) surface: SurfaceId,
    object_from_world: DAffine3,
}

/// Where a ray crosses the surface of a shape.
#[derive(Clone, Copy)]
pub(super) struct Hit<'s> {
    pub(super) t: f64,
    pub(super) shape: &'s Shape,
    face: u8,
}

impl Solid {
    /// The object under a transform. `number` tells the numbers of surface functions.
    pub(super) fn new(
        object: &Object<Arc<Closure>>,
        placed: DAffine3,
        number: &impl Fn(&Arc<Closure>) -> SurfaceId,
    ) -> Solid {
        let operand = |index: usize, placed: DAffine3| {
            let operand = object.children().nth(index).expect("as many as its kind takes");
            Solid::new(operand, placed, number)
        };
        match object.kind() {
            NodeKind::Shape(kind, surface) => Solid::Shape(Shape {
                kind: *kind,
                surface: number(surface),
                object_from_world: placed.inverse(),
            }),
            NodeKind::Transformed(op) => operand(0, placed * matrix(*op)),
            NodeKind::Combined(op) => {
                Solid::Combined(*op, Box::new([operand(0, placed), operand(1, placed)]))
            }
        }
    }

    /// The first crossing beyond the epsilon.
    pub(super) fn first_hit(&self, ray: &Ray) -> Option<Hit<'_>> {
        let mut hits = Vec::new();
        self.hits(ray, &mut hits);
        hits.into_iter().filter(|hit| hit.t > EPSILON).reduce(|a, b| if b.t < a.t { b } else { a })
    }

    fn hits<'s>(&'s self, ray: &Ray, hits: &mut Vec<Hit<'s>>) {
        match self {
            Solid::Shape(shape) => shape.hits(ray, hits),
            Solid::Combined(op, operands) => {
                for (own, other) in [(0, 1), (1, 0)] {
                    let before = hits.len();
                    operands[own].hits(ray, hits);
                    let counts = |hit: &Hit<'_>| match op {
                        SetOp::Union => true,
                        SetOp::Difference if own == 0 => !operands[other].contains(ray.at(hit.t)),
                        SetOp::Intersect | SetOp::Difference => {
                            operands[other].contains(ray.at(hit.t))
                        }
                    };
                    hits.extract_if(before.., |hit| !counts(hit)).for_each(drop);
                }
            }
        }
    }

    fn contains(&self, point: DVec3) -> bool {
        match self {
            Solid::Shape(shape) => {
                contains(shape.kind, shape.object_from_world.transform_point3(point))
            }
            Solid::Combined(op, operands) => {
                let [a, b] = &**operands;
                match op {
                    SetOp::Union => a.contains(point) || b.contains(point),
                    SetOp::Intersect => a.contains(point) && b.contains(point),
                    SetOp::Difference => a.contains(point) && !b.contains(point),
                }
            }
        }
    }
}

fn matrix(op: TransformOp) -> DAffine3 {
    match op {
        TransformOp::Translate(by) => DAffine3::from_translation(by),
        TransformOp::Scale(by) => DAffine3::from_scale(by),
        TransformOp::RotateX(angle) => {
            DAffine3::from_mat3(DMat3::from_rotation_x(angle.to_radians()))
        }
        TransformOp::RotateY(angle) => {
            DAffine3::from_mat3(DMat3::from_rotation_y(angle.to_radians()))
        }
        TransformOp::RotateZ(angle) => {
            DAffine3::from_mat3(DMat3::from_rotation_z(angle.to_radians()))
        }
    }
}

fn contains(kind: ShapeKind, p: DVec3) -> bool {
    let is_in_slab = |x: f64| (0.0..=1.0).contains(&x);
    let across = p.x * p.x + p.z * p.z;
    match kind {
        ShapeKind::Sphere => p.length_squared() <= 1.0,
        ShapeKind::Cube => p.to_array().into_iter().all(is_in_slab),
        ShapeKind::Cylinder => across <= 1.0 && is_in_slab(p.y),
        ShapeKind::Cone => across <= p.y * p.y && is_in_slab(p.y),
        ShapeKind::Plane => p.y <= 0.0,
    }
}

impl Shape {
    /// Normal, of any length, at a point of the world.
    pub(super) fn normal(&self, hit: &Hit<'_>, point: DVec3) -> DVec3 {
        let p = self.object_from_world.transform_point3(point);
        let own = match (self.kind, hit.face) {
            (ShapeKind::Sphere, _) => p,
            (ShapeKind::Cylinder, 0) => DVec3::new(p.x, 0.0, p.z),
            (ShapeKind::Cone, 0) => DVec3::new(p.x, -p.y, p.z),
            (ShapeKind::Cube, 0) => DVec3::NEG_Z,
            (ShapeKind::Cube, 1) => DVec3::Z,
            (ShapeKind::Cube, 2) => DVec3::NEG_X,
            (ShapeKind::Cube, 3) => DVec3::X,
            (ShapeKind::Cylinder, 2) | (ShapeKind::Cube, 5) => DVec3::NEG_Y,
            _ => DVec3::Y,
        };
        self.object_from_world.matrix3.transpose() * own
    }

    /// Face and texture coordinates of a point of the world.
    pub(super) fn texture(&self, hit: &Hit<'_>, point: DVec3) -> SurfacePoint {
        let p = self.object_from_world.transform_point3(point);
        let half = |x: f64| (x + 1.0) / 2.0;
        let (u, v) = match (self.kind, hit.face) {
            (ShapeKind::Sphere, _) => (turns(p.x, p.z, (1.0 - p.y * p.y).sqrt()), half(p.y)),
            (ShapeKind::Cylinder, 0) => (turns(p.x, p.z, 1.0), p.y),
            (ShapeKind::Cone, 0) => (turns(p.x, p.z, p.y), p.y),
            (ShapeKind::Cylinder | ShapeKind::Cone, _) => (half(p.x), half(p.z)),
            (ShapeKind::Cube, 2 | 3) => (p.z, p.y),
            (ShapeKind::Cube, 0 | 1) => (p.x, p.y),
            (ShapeKind::Cube | ShapeKind::Plane, _) => (p.x, p.z),
        };
        SurfacePoint { face: hit.face, u, v }
    }

    fn hits<'s>(&'s self, ray: &Ray, hits: &mut Vec<Hit<'s>>) {
        let local = Ray {
            origin: self.object_from_world.transform_point3(ray.origin),
            dir: self.object_from_world.transform_vector3(ray.dir),
        };
        let mut put = |t: f64, face: u8, holds: &dyn Fn(DVec3) -> bool| {
            if t.is_finite() && holds(local.at(t)) {
                hits.push(Hit { t, shape: self, face });
            }
        };
        let is_in_slab = |x: f64| (0.0..=1.0).contains(&x);
        let is_in_disc = |p: DVec3| p.x * p.x + p.z * p.z <= 1.0;
        let cap = |y: f64| (y - local.origin.y) / local.dir.y;
        match self.kind {
            ShapeKind::Plane => put(cap(0.0), 0, &|_| true),
            ShapeKind::Sphere => {
                for t in roots(&local, DVec3::ONE, 1.0) {
                    put(t, 0, &|_| true);
                }
            }
            ShapeKind::Cylinder => {
                for t in roots(&local, DVec3::new(1.0, 0.0, 1.0), 1.0) {
                    put(t, 0, &|p| is_in_slab(p.y));
                }
                put(cap(1.0), 1, &is_in_disc);
                put(cap(0.0), 2, &is_in_disc);
            }
            ShapeKind::Cone => {
                for t in roots(&local, DVec3::new(1.0, -1.0, 1.0), 0.0) {
                    put(t, 0, &|p| is_in_slab(p.y));
                }
                put(cap(1.0), 1, &is_in_disc);
            }
            ShapeKind::Cube => {
                for (face, axis, offset) in
                    [(0, 2, 0.0), (1, 2, 1.0), (2, 0, 0.0), (3, 0, 1.0), (4, 1, 1.0), (5, 1, 0.0)]
                {
                    let t = (offset - local.origin[axis]) / local.dir[axis];
                    let others = [(axis + 1) % 3, (axis + 2) % 3];
                    put(t, face, &|p| others.into_iter().all(|axis| is_in_slab(p[axis])));
                }
            }
        }
    }
}

/// Where `s1 x² + s2 y² + s3 z² = k` on a ray: `(-b ± sqrt(b² - 4ac)) / 2a`, or `-c / b`.
fn roots(ray: &Ray, signs: DVec3, k: f64) -> [f64; 2] {
    let a = (signs * ray.dir).dot(ray.dir);
    let b = 2.0 * (signs * ray.dir).dot(ray.origin);
    let c = (signs * ray.origin).dot(ray.origin) - k;
    if a == 0.0 {
        return [-c / b; 2];
    }
    // The root of a negative number is NaN, which is nowhere on the ray.
    let root = (b * b - 4.0 * a * c).sqrt();
    [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)]
}

/// The angle around the y axis in turns, from the formulas `x = r sin u`, `z = r cos u`.
fn turns(x: f64, z: f64, r: f64) -> f64 {
    let turns = (z / r).acos() / std::f64::consts::TAU;
    if x < 0.0 { 1.0 - turns } else { turns }
}
