//! The hinge between scenes and programs: a surface is a number here, and whoever can evaluate the
//! numbers may drive the renderer.

use glam::DVec3;

/// Index of a surface function in the render job that owns it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SurfaceId(pub u32);

/// Where on a solid a surface function is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The face, as GML numbers them.
    pub face: u8,
    /// First texture coordinate, in [0, 1] but for planes.
    pub u: f64,
    /// Second texture coordinate, in [0, 1] but for planes.
    pub v: f64,
}

/// What of a point a surface function reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// The face.
    pub face: bool,
    /// The first texture coordinate, which takes an arc tangent on curved faces.
    pub u: bool,
    /// The second texture coordinate.
    pub v: bool,
}

impl Needs {
    /// Everything.
    pub const ALL: Needs = Needs { face: true, u: true, v: true };
}

/// A place on a solid that tells what is needed of it, so that what nobody reads is not computed.
pub trait Locate {
    /// The point; what is not needed may be anything.
    fn locate(&self, needs: Needs) -> SurfacePoint;
}

impl Locate for SurfacePoint {
    #[inline]
    fn locate(&self, _: Needs) -> SurfacePoint {
        *self
    }
}

/// What a surface function answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample {
    /// Surface colour C, linear RGB.
    pub color: DVec3,
    /// Diffuse coefficient.
    pub kd: f64,
    /// Specular coefficient.
    pub ks: f64,
    /// Phong exponent n.
    pub phong_exp: f64,
}

/// Evaluates surface functions for one thread.
pub trait SurfaceEval {
    /// Why a function has no answer.
    type Error: Send;

    /// Calls a surface function.
    ///
    /// # Errors
    /// What the function does wrong; it ends the image.
    fn eval(&mut self, surface: SurfaceId, at: &impl Locate) -> Result<SurfaceSample, Self::Error>;
}
