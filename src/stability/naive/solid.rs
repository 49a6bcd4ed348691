//! Solids of the naive tracer: transforms as products and inverses of matrices, roots by the
//! schoolbook's formula, set operations by asking whether the point that was hit is inside.

use std::sync::Arc;

use renderer::object::{NodeKind, Object, SetOp, ShapeKind, TransformOp};
use renderer::surface::{SurfaceId, SurfacePoint};
use vm::value::Closure;

use super::TooDeep;
use super::vector::{Affine, Number, Vector};

/// Operations on sets that lie inside one another, beyond which a solid is refused: all of this goes
/// by recursion. Unions of unions count as one.
const MAX_NESTING: usize = 500;

/// A line with a direction.
#[derive(Clone, Copy)]
pub(super) struct Ray<F> {
    pub(super) origin: Vector<F>,
    pub(super) dir: Vector<F>,
}

impl<F: Number> Ray<F> {
    pub(super) fn at(&self, t: F) -> Vector<F> {
        self.origin + self.dir * t
    }
}

/// What a ray may meet.
pub(super) enum Solid<F> {
    Shape(Shape<F>),
    /// Of any number.
    Union(Vec<Solid<F>>),
    /// An intersection or a difference.
    Combined(SetOp, Box<[Solid<F>; 2]>),
}

/// A shape where it stands.
pub(super) struct Shape<F> {
    kind: ShapeKind,
    pub(super) surface: SurfaceId,
    object_from_world: Affine<F>,
}

/// Where a ray crosses the surface of a shape.
#[derive(Clone, Copy)]
pub(super) struct Hit<'s, F> {
    pub(super) t: F,
    pub(super) shape: &'s Shape<F>,
    face: u8,
}

impl<F: Number> Solid<F> {
    /// The whole object. `number` tells the numbers of surface functions.
    ///
    /// # Errors
    /// When it is nested too deep.
    pub(super) fn new(
        object: &Object<Arc<Closure>>,
        number: &impl Fn(&Arc<Closure>) -> SurfaceId,
    ) -> Result<Self, TooDeep> {
        Solid::placed(object, Affine::identity(), number, MAX_NESTING)
    }

    /// The object under a transform.
    fn placed(
        object: &Object<Arc<Closure>>,
        placed: Affine<F>,
        number: &impl Fn(&Arc<Closure>) -> SurfaceId,
        nesting_left: usize,
    ) -> Result<Self, TooDeep> {
        let nesting_left = nesting_left.checked_sub(1).ok_or(TooDeep)?;
        let mut solids = Vec::new();
        let mut pending = vec![(object, placed)];
        while let Some((object, placed)) = pending.pop() {
            match object.kind() {
                NodeKind::Shape(kind, surface) => solids.push(Solid::Shape(Shape {
                    kind: *kind,
                    surface: number(surface),
                    object_from_world: placed.inverse(),
                })),
                NodeKind::Transformed(op) => {
                    let placed = placed.after(&map(*op));
                    pending.extend(object.children().map(|inner| (inner, placed)));
                }
                NodeKind::Combined(SetOp::Union) => {
                    pending.extend(object.children().rev().map(|operand| (operand, placed)));
                }
                NodeKind::Combined(op) => {
                    let mut operands = object
                        .children()
                        .map(|operand| Solid::placed(operand, placed, number, nesting_left));
                    let mut operand = || operands.next().expect("an operation has two operands");
                    solids.push(Solid::Combined(*op, Box::new([operand()?, operand()?])));
                }
            }
        }
        Ok(Solid::Union(solids))
    }

    /// The first crossing beyond the epsilon.
    pub(super) fn first_hit(&self, ray: &Ray<F>, epsilon: F) -> Option<Hit<'_, F>> {
        let mut hits = Vec::new();
        self.hits(ray, &mut hits);
        hits.into_iter().filter(|hit| hit.t > epsilon).reduce(|a, b| if b.t < a.t { b } else { a })
    }

    fn hits<'s>(&'s self, ray: &Ray<F>, hits: &mut Vec<Hit<'s, F>>) {
        match self {
            Solid::Shape(shape) => shape.hits(ray, hits),
            Solid::Union(operands) => operands.iter().for_each(|solid| solid.hits(ray, hits)),
            Solid::Combined(op, operands) => {
                for (own, other) in [(0, 1), (1, 0)] {
                    let before = hits.len();
                    operands[own].hits(ray, hits);
                    let is_outside = *op == SetOp::Difference && own == 0;
                    let counts =
                        |hit: &Hit<'_, F>| operands[other].contains(ray.at(hit.t)) != is_outside;
                    hits.extract_if(before.., |hit| !counts(hit)).for_each(drop);
                }
            }
        }
    }

    fn contains(&self, point: Vector<F>) -> bool {
        match self {
            Solid::Shape(shape) => contains(shape.kind, shape.object_from_world.point(point)),
            Solid::Union(operands) => operands.iter().any(|solid| solid.contains(point)),
            Solid::Combined(op, operands) => {
                let [a, b] = &**operands;
                a.contains(point) && b.contains(point) != (*op == SetOp::Difference)
            }
        }
    }
}

fn map<F: Number>(op: TransformOp) -> Affine<F> {
    match op {
        TransformOp::Translate(by) => Affine::translation(Vector::of(by)),
        TransformOp::Scale(by) => Affine::scale(Vector::of(by)),
        TransformOp::RotateX(angle) => Affine::rotation(angle, 1, 2),
        TransformOp::RotateY(angle) => Affine::rotation(angle, 2, 0),
        TransformOp::RotateZ(angle) => Affine::rotation(angle, 0, 1),
    }
}

fn contains<F: Number>(kind: ShapeKind, p: Vector<F>) -> bool {
    let Vector([x, y, z]) = p;
    let across = x * x + z * z;
    match kind {
        ShapeKind::Sphere => p.dot(p) <= F::one(),
        ShapeKind::Cube => p.0.into_iter().all(is_in_slab),
        ShapeKind::Cylinder => across <= F::one() && is_in_slab(y),
        ShapeKind::Cone => across <= y * y && is_in_slab(y),
        ShapeKind::Plane => y <= F::zero(),
    }
}

fn is_in_slab<F: Number>(x: F) -> bool {
    x >= F::zero() && x <= F::one()
}

impl<F: Number> Shape<F> {
    /// Normal, of any length, at a point of the world.
    pub(super) fn normal(&self, hit: &Hit<'_, F>, point: Vector<F>) -> Vector<F> {
        let p = self.object_from_world.point(point);
        let Vector([x, y, z]) = p;
        let own = match (self.kind, hit.face) {
            (ShapeKind::Sphere, _) => p,
            (ShapeKind::Cylinder, 0) => Vector([x, F::zero(), z]),
            (ShapeKind::Cone, 0) => Vector([x, -y, z]),
            (ShapeKind::Cube, 0) => -Vector::axis(2),
            (ShapeKind::Cube, 1) => Vector::axis(2),
            (ShapeKind::Cube, 2) => -Vector::axis(0),
            (ShapeKind::Cube, 3) => Vector::axis(0),
            (ShapeKind::Cylinder, 2) | (ShapeKind::Cube, 5) => -Vector::axis(1),
            _ => Vector::axis(1),
        };
        self.object_from_world.transposed_vector(own)
    }

    /// Face and texture coordinates of a point of the world.
    pub(super) fn texture(&self, hit: &Hit<'_, F>, point: Vector<F>) -> SurfacePoint {
        let Vector([x, y, z]) = self.object_from_world.point(point);
        let one = F::one();
        let half = |x: F| (x + one) / F::of(2.0);
        let (u, v) = match (self.kind, hit.face) {
            (ShapeKind::Sphere, _) => (turns(x, z, (one - y * y).sqrt()), half(y)),
            (ShapeKind::Cylinder, 0) => (turns(x, z, one), y),
            (ShapeKind::Cone, 0) => (turns(x, z, y), y),
            (ShapeKind::Cylinder | ShapeKind::Cone, _) => (half(x), half(z)),
            (ShapeKind::Cube, 2 | 3) => (z, y),
            (ShapeKind::Cube, 0 | 1) => (x, y),
            (ShapeKind::Cube | ShapeKind::Plane, _) => (x, z),
        };
        SurfacePoint { face: hit.face, u: u.double(), v: v.double() }
    }

    fn hits<'s>(&'s self, ray: &Ray<F>, hits: &mut Vec<Hit<'s, F>>) {
        let local = Ray {
            origin: self.object_from_world.point(ray.origin),
            dir: self.object_from_world.vector(ray.dir),
        };
        let (zero, one) = (F::zero(), F::one());
        let mut put = |t: F, face: u8, holds: &dyn Fn(Vector<F>) -> bool| {
            if t.is_finite() && holds(local.at(t)) {
                hits.push(Hit { t, shape: self, face });
            }
        };
        let is_in_disc = |p: Vector<F>| p[0] * p[0] + p[2] * p[2] <= one;
        let cap = |y: F| (y - local.origin[1]) / local.dir[1];
        match self.kind {
            ShapeKind::Plane => put(cap(zero), 0, &|_| true),
            ShapeKind::Sphere => {
                for t in roots(&local, [one; 3], one) {
                    put(t, 0, &|_| true);
                }
            }
            ShapeKind::Cylinder => {
                for t in roots(&local, [one, zero, one], one) {
                    put(t, 0, &|p| is_in_slab(p[1]));
                }
                put(cap(one), 1, &is_in_disc);
                put(cap(zero), 2, &is_in_disc);
            }
            ShapeKind::Cone => {
                for t in roots(&local, [one, -one, one], zero) {
                    put(t, 0, &|p| is_in_slab(p[1]));
                }
                put(cap(one), 1, &is_in_disc);
            }
            ShapeKind::Cube => {
                for (face, axis, offset) in [
                    (0, 2, zero),
                    (1, 2, one),
                    (2, 0, zero),
                    (3, 0, one),
                    (4, 1, one),
                    (5, 1, zero),
                ] {
                    let t = (offset - local.origin[axis]) / local.dir[axis];
                    let others = [(axis + 1) % 3, (axis + 2) % 3];
                    put(t, face, &|p| others.into_iter().all(|axis| is_in_slab(p[axis])));
                }
            }
        }
    }
}

/// Where `s1 x² + s2 y² + s3 z² = k` on a ray: `(-b ± sqrt(b² - 4ac)) / 2a`, or `-c / b`.
fn roots<F: Number>(ray: &Ray<F>, signs: [F; 3], k: F) -> [F; 2] {
    let signed = |v: Vector<F>| v.scaled_by(Vector(signs));
    let two = F::of(2.0);
    let a = signed(ray.dir).dot(ray.dir);
    let b = two * signed(ray.dir).dot(ray.origin);
    let c = signed(ray.origin).dot(ray.origin) - k;
    if a == F::zero() {
        return [-c / b; 2];
    }
    // The root of a negative number is NaN, which is nowhere on the ray.
    let root = (b * b - F::of(4.0) * a * c).sqrt();
    [(-b - root) / (two * a), (-b + root) / (two * a)]
}

/// The angle around the y axis in turns, from the formulas `x = r sin u`, `z = r cos u`.
fn turns<F: Number>(x: F, z: F, r: F) -> F {
    let turns = (z / r).acos() / F::of(std::f64::consts::TAU);
    if x < F::zero() { F::one() - turns } else { turns }
}
