//! The hinge between scenes and programs: a surface is a number here, and whoever can evaluate the
//! numbers may drive the renderer.

use glam::DVec3;

use crate::signature::Signature;

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

/// A real number that is known up to a bound: it differs from `value` by at most `error`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    /// A number near it.
    pub value: f64,
    /// How far off that may be: at least 0, infinite where nothing is known.
    pub error: f64,
}

impl Bounded {
    /// The number itself.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        Bounded { value, error: 0.0 }
    }
}

/// Where on a solid a surface function is asked, as far as that is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedPoint {
    /// The face, as GML numbers them.
    pub face: u8,
    /// First texture coordinate.
    pub u: Bounded,
    /// Second texture coordinate.
    pub v: Bounded,
}

/// A place on a solid whose texture coordinates are known up to bounds.
pub trait LocateBounded {
    /// Encloses what [`Locate::locate`] would say in exact arithmetic, rounded to doubles; what is
    /// not needed may be anything.
    fn locate_bounded(&self, needs: Needs) -> BoundedPoint;
}

/// What a surface function answers somewhere within the bounds of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedSample {
    /// Surface colour C, linear RGB.
    pub color: [Bounded; 3],
    /// Diffuse coefficient.
    pub kd: Bounded,
    /// Specular coefficient.
    pub ks: Bounded,
    /// Phong exponent n.
    pub phong_exp: Bounded,
}

/// The most points that a surface function is asked at at once.
pub const MAX_BATCH: usize = 64;

/// Evaluates surface functions for one thread.
pub trait SurfaceEval {
    /// Why a function has no answer.
    type Error: Send;

    /// Calls a surface function.
    ///
    /// # Errors
    /// What the function does wrong; it ends the image.
    fn eval(&mut self, surface: SurfaceId, at: &impl Locate) -> Result<SurfaceSample, Self::Error>;

    /// What a surface function answers everywhere, if it is known to.
    fn constant(&mut self, surface: SurfaceId) -> Option<SurfaceSample> {
        let _ = surface;
        None
    }

    /// Whether there are surfaces by now that have [`SurfaceEval::batch_needs`].
    fn has_batches(&self) -> bool {
        false
    }

    /// What of points [`SurfaceEval::eval_batch`] reads, if it is quicker than many calls of a surface
    /// function.
    fn batch_needs(&self, surface: SurfaceId) -> Option<Needs> {
        let _ = surface;
        None
    }

    /// Calls a surface function at points, at most [`MAX_BATCH`] of them, and appends its answers in
    /// their order; none where it must be called alone, since it may fail.
    fn eval_batch(
        &mut self,
        surface: SurfaceId,
        points: &[SurfacePoint],
        samples: &mut Vec<Option<SurfaceSample>>,
    ) {
        let _ = surface;
        samples.extend(points.iter().map(|_| None));
    }

    /// Calls a surface function, and tells the signature of its decisions. By itself the answer stands
    /// for them.
    ///
    /// # Errors
    /// What the function does wrong; it ends the image.
    fn eval_signed(
        &mut self,
        surface: SurfaceId,
        at: &impl Locate,
    ) -> Result<(SurfaceSample, Signature), Self::Error> {
        let sample = self.eval(surface, at)?;
        let [r, g, b] = sample.color.to_array();
        let numbers = [r, g, b, sample.kd, sample.ks, sample.phong_exp];
        let signature = |so_far: Signature, number: &f64| so_far.with(number.to_bits());
        Ok((sample, numbers.iter().fold(Signature::NONE, signature)))
    }

    /// Bounds of what the function answers at all points that doubles can name within those of `at`;
    /// none where it would have to decide something that the bounds leave open, may fail, or cannot
    /// be evaluated in this way.
    fn eval_bounded(
        &mut self,
        surface: SurfaceId,
        at: &impl LocateBounded,
    ) -> Option<BoundedSample> {
        let _ = (surface, at);
        None
    }
}
