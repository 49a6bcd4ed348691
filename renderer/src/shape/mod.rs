//! The five unit solids: where a ray is inside them, and what their surfaces are like there.
//!
//! All are convex, so a ray is inside during one span of its parameter at most. Everything here is
//! in object space. A ray comes with its moment `m = o × d`: the discriminants and hit points of all
//! quadrics follow from `d` and `m` alone, free of the cancellation that `b² - ac` and `o + t d`
//! suffer far from the solid.

pub(crate) mod cone;
pub(crate) mod cube;
pub(crate) mod cylinder;
pub(crate) mod plane;
pub(crate) mod quadric;
pub(crate) mod slab;
pub(crate) mod sphere;

use crate::numeric::ball::Ball;
use crate::numeric::dd::Dd;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::ShapeKind;

/// A ray in a shape's object space. The direction has any length, so that the parameter `t` is the
/// same in all spaces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalRay<R> {
    pub(crate) origin: Vec3<R>,
    pub(crate) dir: Vec3<R>,
    pub(crate) moment: Vec3<R>,
    /// Faces, by bit, that the origin is known to lie on: there the root is 0 exactly.
    pub(crate) on: u8,
}

impl<R: Real> LocalRay<R> {
    pub(crate) fn new(origin: Vec3<R>, dir: Vec3<R>, on: u8) -> Self {
        LocalRay { origin, dir, moment: origin.cross(dir), on }
    }

    pub(crate) fn is_on(&self, face: u8) -> bool {
        self.on >> face & 1 == 1
    }
}

/// Where a line crosses a face. A line meets a quadric twice: of the roots `(b ± s) / a` with
/// `s >= 0`, `plus` tells which one. One word, so that it is moved as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Root(u32);

impl Root {
    #[inline(always)]
    pub(crate) fn new(face: u8, plus: bool) -> Self {
        Root(u32::from(face) << 1 | u32::from(plus))
    }

    /// The only crossing of a plane.
    #[inline(always)]
    pub(crate) fn plane(face: u8) -> Self {
        Root::new(face, false)
    }

    #[inline(always)]
    pub(crate) fn bits(self) -> u32 {
        self.0
    }

    /// The root that has these bits.
    #[inline(always)]
    pub(crate) fn from_bits(bits: u32) -> Self {
        Root(bits)
    }

    #[inline(always)]
    pub(crate) fn face(self) -> u8 {
        (self.0 >> 1) as u8
    }

    #[inline(always)]
    pub(crate) fn plus(self) -> bool {
        self.0 & 1 == 1
    }
}

/// One end of a span; an infinite end is never met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct End<R> {
    pub(crate) t: R,
    pub(crate) root: Root,
}

/// The part of a line that is inside a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span<R> {
    pub(crate) enter: End<R>,
    pub(crate) exit: End<R>,
}

impl<R: Real> Span<R> {
    /// The whole line.
    pub(crate) fn line() -> Self {
        let end = |t: f64| End { t: R::from_f64(t), root: Root::plane(0) };
        Span { enter: end(f64::NEG_INFINITY), exit: end(f64::INFINITY) }
    }

    /// What is in both; nothing if that has no length.
    #[inline]
    pub(crate) fn and(self, other: Span<R>) -> Option<Span<R>> {
        let enter = if other.enter.t > self.enter.t { other.enter } else { self.enter };
        let exit = if other.exit.t < self.exit.t { other.exit } else { self.exit };
        (enter.t < exit.t).then_some(Span { enter, exit })
    }
}

/// The surface that a face is part of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Form {
    /// `s1 x² + s2 y² + s3 z² = k`
    Quadric { signs: [f64; 3], k: f64 },
    /// The coordinate with this index has this value.
    Plane { axis: usize, offset: f64 },
}

/// The surfaces of a shape's faces, by face.
pub(crate) fn forms(kind: ShapeKind) -> &'static [Form] {
    match kind {
        ShapeKind::Sphere => &sphere::FORMS,
        ShapeKind::Cube => &cube::FORMS,
        ShapeKind::Cylinder => &cylinder::FORMS,
        ShapeKind::Cone => &cone::FORMS,
        ShapeKind::Plane => &plane::FORMS,
    }
}

/// Faces that a shape has at most.
pub(crate) const MAX_FACES: usize = 6;

/// What is 0 where a point lies on a surface.
pub(crate) fn height<R: Real>(form: &Form, p: Vec3<R>) -> R {
    let coordinates: [R; 3] = p.into();
    match *form {
        Form::Quadric { signs, k } => R::signed_squares(signs, coordinates, k),
        Form::Plane { axis, offset } => coordinates[axis] - R::from_f64(offset),
    }
}

/// The faces, by bit, whose surfaces a point lies on, as far as its bounds can tell.
pub(crate) fn faces_at(kind: ShapeKind, p: Vec3<Ball<Dd>>) -> u8 {
    let is_on = |form: &Form| height(form, p).holds_zero();
    let bits = forms(kind).iter().enumerate().map(|(face, form)| u8::from(is_on(form)) << face);
    bits.fold(0, |bits, bit| bits | bit)
}

/// Where a ray's line is inside a shape.
#[inline(always)]
pub(crate) fn span<R: Real>(kind: ShapeKind, ray: &LocalRay<R>) -> Option<Span<R>> {
    match kind {
        ShapeKind::Sphere => sphere::span(ray),
        ShapeKind::Cube => cube::span(ray),
        ShapeKind::Cylinder => taken_apart(cylinder::span(ray)),
        ShapeKind::Cone => taken_apart(cone::span(ray)),
        ShapeKind::Plane => plane::span(ray),
    }
}

/// The answer of a function that is called, in registers like those beside it that are not.
#[inline(always)]
fn taken_apart<R: Real>(span: Option<Span<R>>) -> Option<Span<R>> {
    let Span { enter: End { t: from, root: of_enter }, exit: End { t: to, root: of_exit } } = span?;
    Some(Span { enter: End { t: from, root: of_enter }, exit: End { t: to, root: of_exit } })
}

/// The point where a ray's line crosses a face; planar coordinates are exact.
#[inline(always)]
pub(crate) fn hit_point<R: Real>(kind: ShapeKind, ray: &LocalRay<R>, root: Root) -> Vec3<R> {
    match forms(kind)[root.face() as usize] {
        Form::Plane { axis, offset } => slab::hit_point(ray, axis, R::from_f64(offset)),
        Form::Quadric { signs, k } => quadric::hit_point(ray, signs, k, root.plus()),
    }
}

/// A coordinate, but 0 where it is nothing beside the terms of this size that it was computed from.
///
/// Which cell of a texture a point is in, and which way the apex of a cone faces, may hang on whether a
/// coordinate is 0 exactly. That rounding cannot tell, so that it is laid down: below 2^-80 it is.
#[inline]
pub(crate) fn settled<R: Real>(coordinate: R, size: f64) -> R {
    const NOTHING: f64 = 1.0 / (1u64 << 40) as f64 / (1u64 << 40) as f64;
    if coordinate.is_below(NOTHING * size) { R::ZERO } else { coordinate }
}

/// The outward normal at a point of a face, of any length; zero at the apex of a cone.
#[inline(always)]
pub(crate) fn normal<R: Real>(kind: ShapeKind, face: u8, p: Vec3<R>) -> Vec3<R> {
    match forms(kind)[face as usize] {
        Form::Quadric { signs, .. } => p.with_signs(signs),
        Form::Plane { axis, offset } => {
            // The lower bound of an axis faces down, but for the half-space y <= 0.
            let up = offset > 0.0 || kind == ShapeKind::Plane;
            let along = |other| match (axis == other, up) {
                (false, _) => R::ZERO,
                (true, true) => R::ONE,
                (true, false) => -R::ONE,
            };
            Vec3::new(along(0), along(1), along(2))
        }
    }
}

/// First texture coordinate of a point of a face (reference, table 1): in [0, 1], around an axis in
/// [0, 1), but unbounded on planes.
pub(crate) fn texture_u<R: Real>(kind: ShapeKind, face: u8, p: Vec3<R>) -> R {
    match (kind, face) {
        (ShapeKind::Plane, _) => p.x,
        (ShapeKind::Sphere, _) | (ShapeKind::Cylinder | ShapeKind::Cone, 0) => {
            let turns = R::turns(p.x, p.z);
            // From half a unit in the last place below it on, the nearest double is a whole turn.
            let last = Dd::ONE - Dd::from(f64::EPSILON / 4.0);
            if turns < R::from_dd(last) { turns } else { R::ZERO }
        }
        (ShapeKind::Cylinder | ShapeKind::Cone, _) => within(half(p.x)),
        (ShapeKind::Cube, 2 | 3) => within(p.z),
        (ShapeKind::Cube, _) => within(p.x),
    }
}

/// Second texture coordinate of a point of a face (reference, table 1): in [0, 1], but unbounded on
/// planes.
pub(crate) fn texture_v<R: Real>(kind: ShapeKind, face: u8, p: Vec3<R>) -> R {
    match (kind, face) {
        (ShapeKind::Plane, _) => p.z,
        (ShapeKind::Sphere, _) => within(half(p.y)),
        (ShapeKind::Cylinder | ShapeKind::Cone, 0) | (ShapeKind::Cube, 0..=3) => within(p.y),
        (ShapeKind::Cylinder | ShapeKind::Cone, _) => within(half(p.z)),
        (ShapeKind::Cube, _) => within(p.z),
    }
}

/// From [-1, 1] to [0, 1].
fn half<R: Real>(x: R) -> R {
    (x + R::ONE) / R::from_f64(2.0)
}

/// Rounding may step over an edge, where a table lookup in the surface function would fail.
fn within<R: Real>(x: R) -> R {
    x.max(R::ZERO).min(R::ONE)
}

#[cfg(test)]
mod tests;
