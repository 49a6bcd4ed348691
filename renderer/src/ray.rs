//! Rays in world space, and what they meet.

use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::shape::Root;

/// A ray in world space. The direction has any length; `t` counts in its lengths.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray<R> {
    pub(crate) origin: Vec3<R>,
    pub(crate) dir: Vec3<R>,
    /// The surface that it starts on, unless it starts at the eye.
    pub(crate) on: Option<On<R>>,
    pub(crate) medium: Medium,
}

/// The face that a ray starts on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct On<R> {
    pub(crate) leaf: u32,
    /// The world-space surface that the face is part of.
    pub(crate) surface: u32,
    /// The origin in the leaf's object space, where it is known best.
    pub(crate) point: Vec3<R>,
}

/// What a ray runs through at first. Light that is reflected, and the light of lamps on the same
/// side, stay in the medium that the ray came through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Medium {
    /// Yet to be seen, as for the eye.
    Unknown,
    /// No solid: the first boundary is an entry.
    Outside,
    /// The inside of a solid: the first boundary is an exit.
    Inside,
}

/// A boundary of the scene, or of a part of it, on a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing<R> {
    pub(crate) t: R,
    /// How far `t` may be off: crossings within their tolerances of one another are one.
    pub(crate) tolerance: f64,
    pub(crate) leaf: u32,
    pub(crate) root: Root,
    /// Whether the ray goes from outside to inside.
    pub(crate) entering: bool,
}

impl<R: Real> Crossing<R> {
    /// Whether it lies ahead of the origin by more than the tolerance.
    pub(crate) fn is_ahead(&self) -> bool {
        self.t.to_f64() > self.tolerance
    }

    /// Whether two crossings cannot be told apart.
    pub(crate) fn ties_with(&self, other: &Crossing<R>) -> bool {
        (self.t - other.t).abs().to_f64() <= self.tolerance + other.tolerance
    }
}
