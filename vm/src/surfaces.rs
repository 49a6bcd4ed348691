//! Surface functions by interpretation.

use std::collections::HashMap;
use std::sync::Arc;

use compiler::scalar::Operands;
use glam::DVec3;
use renderer::numeric::real::Real;
use renderer::object::Object;
use renderer::scene::Scene;
use renderer::signature::Signature;
use renderer::surface::{
    Bounded, BoundedPoint, BoundedSample, Locate, LocateBounded, Needs, SurfaceEval, SurfaceId,
    SurfacePoint, SurfaceSample,
};

use crate::error::{Error, Problem};
use crate::machine::{Limits, Machine};
use crate::program::LoadedProgram;
use crate::value::Closure;
use crate::word::{Tag, Word};

/// The scene to trace, and its surface functions by [`SurfaceId`]. Shapes that were given the same
/// closure share its number.
#[must_use]
pub fn scene<R: Real>(object: &Object<Arc<Closure>>) -> (Scene<R>, Vec<Arc<Closure>>) {
    let mut surfaces: Vec<Arc<Closure>> = Vec::new();
    let mut ids = HashMap::new();
    let scene = Scene::new(object, |closure: &Arc<Closure>| {
        *ids.entry(Arc::as_ptr(closure)).or_insert_with(|| {
            surfaces.push(closure.clone());
            SurfaceId(surfaces.len() as u32 - 1)
        })
    });
    (scene, surfaces)
}

/// Evaluates the surface functions of a scene, for one thread.
pub struct InterpSurfaces<'p> {
    machine: Machine<'p>,
    surfaces: &'p [Arc<Closure>],
}

impl<'p> InterpSurfaces<'p> {
    /// The functions by [`SurfaceId`]; each call may use up the limits anew.
    #[must_use]
    pub fn new(
        program: &'p Arc<LoadedProgram>,
        surfaces: &'p [Arc<Closure>],
        limits: Limits,
    ) -> Self {
        let mut machine = Machine::new(program, limits);
        machine.surfaces = vec![Word::NOTHING; surfaces.len()];
        // Every call begins with registers, the first one too.
        machine.grow_registers(1);
        InterpSurfaces { machine, surfaces }
    }

    /// The index of a surface function that the machine has.
    fn imported(&mut self, surface: SurfaceId) -> usize {
        let index = surface.0 as usize;
        if self.machine.surfaces[index].tag != Tag::Closure {
            self.machine.surfaces[index] = self.machine.import(&self.surfaces[index]);
        }
        index
    }

    /// The fuel that the last call has used up: how long it took, roughly.
    #[must_use]
    pub fn fuel_used(&self) -> u64 {
        self.machine.limits.fuel - self.machine.fuel
    }
}

impl SurfaceEval for InterpSurfaces<'_> {
    type Error = Box<Error>;

    fn eval(&mut self, surface: SurfaceId, at: &impl Locate) -> Result<SurfaceSample, Box<Error>> {
        let index = self.imported(surface);
        self.machine.surface_at::<false>(index, at.locate(Needs::ALL))
    }

    fn eval_signed(
        &mut self,
        surface: SurfaceId,
        at: &impl Locate,
    ) -> Result<(SurfaceSample, Signature), Box<Error>> {
        let index = self.imported(surface);
        self.machine.signature = Signature::NONE;
        let sample = self.machine.surface_at::<true>(index, at.locate(Needs::ALL))?;
        Ok((sample, self.machine.signature))
    }

    fn eval_bounded(
        &mut self,
        surface: SurfaceId,
        at: &impl LocateBounded,
    ) -> Option<BoundedSample> {
        let at = known(&at.locate_bounded(Needs::ALL), Needs::ALL)?;
        self.eval(surface, &at).ok().as_ref().map(exact)
    }
}

/// The point, if as much of it as is needed is known exactly: then evaluation is the bound.
#[must_use]
#[inline]
pub fn known(at: &BoundedPoint, needs: Needs) -> Option<SurfacePoint> {
    let is_unknown = |is_needed: bool, coordinate: Bounded| is_needed && coordinate.error != 0.0;
    let has_unknown = is_unknown(needs.u, at.u) || is_unknown(needs.v, at.v);
    (!has_unknown).then_some(SurfacePoint { face: at.face, u: at.u.value, v: at.v.value })
}

/// What is known of a number that differs from `value` by at most `error`: of NaN, nothing.
#[must_use]
#[inline]
pub fn bounded(value: f64, error: f64) -> Bounded {
    let is_unknown = value.is_nan() || error.is_nan();
    Bounded { value, error: if is_unknown { f64::INFINITY } else { error } }
}

/// The sample itself.
#[must_use]
#[inline]
pub fn exact(sample: &SurfaceSample) -> BoundedSample {
    let exact = |value| bounded(value, 0.0);
    BoundedSample {
        color: sample.color.to_array().map(exact),
        kd: exact(sample.kd),
        ks: exact(sample.ks),
        phong_exp: exact(sample.phong_exp),
    }
}

impl Machine<'_> {
    /// Calls a surface function on a stack with nothing but face, u and v; an error is what the function
    /// does wrong, or that it leaves anything but a colour, kd, ks and n.
    fn surface_at<const SIGNED: bool>(
        &mut self,
        index: usize,
        at: SurfacePoint,
    ) -> Result<SurfaceSample, Box<Error>> {
        self.reset();
        let face = Word::from_int(i64::from(at.face));
        let arguments = [face, Word::from_real(at.u), Word::from_real(at.v)];
        self.stack.push::<3>().iter_mut().zip(&arguments).for_each(|(slot, word)| slot.set(word));
        self.call::<SIGNED>(self.surfaces[index], None)?;
        if let Some(sample) = sample(self.stack.as_slice()) {
            return Ok(sample);
        }
        self.closure = self.surfaces[index].address();
        let found = self.stack.as_slice().iter().map(|word| word.type_of()).collect();
        Err(self.error(Problem::SurfaceResult(found)))
    }
}

/// What a surface function has left, if it is what it should leave.
fn sample(stack: &[Word]) -> Option<SurfaceSample> {
    let [color, kd, ks, phong_exp] = stack else { return None };
    Some(SurfaceSample {
        color: DVec3::from_array(color.as_point()?),
        kd: kd.as_real()?,
        ks: ks.as_real()?,
        phong_exp: phong_exp.as_real()?,
    })
}

#[cfg(test)]
mod tests;
