//! Bounds of what surface functions answer, by bounded shaders, and when those are compiled.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use renderer::surface::{
    BoundedSample, LocateBounded, Needs, SurfaceEval, SurfaceId, SurfacePoint,
};
use vm::surfaces::{exact, known};

use crate::abi::BoundedFn;
use crate::bounded::bounded;
use crate::code::{Code, isa};
use crate::shaders::{
    COMPILE_FUEL, COMPILE_FUEL_PER_INST, NativeSurfaces, Shaders, Tier, Tiering, Variant,
};
use crate::sir::{Body, Shader};

/// What a request without an answer costs, in the fuel of the interpreter (a unit in about 2 ns):
/// about 10 µs, in which the renderer finds the coordinates in double-double.
const REFUSAL_FUEL: u64 = 5_000;

/// Instructions of a bounded shader for each one of the plain shader: 2 to 7 in our scenes. They take
/// as long to compile as others.
const EXPANSION: u64 = 5;

/// One bounded version of a shader.
#[derive(Default)]
pub(crate) struct BoundedCode {
    /// What requests without an answer have cost.
    spent: AtomicU64,
    /// None if it cannot be compiled.
    code: OnceLock<Option<Code<BoundedFn>>>,
}

impl Shaders<'_> {
    /// The bounded version of a surface's shader for points of which u, v or both are not known; none
    /// if it cannot be compiled, or has not been wanted so often that this pays. It is compiled once the
    /// refusals have cost as much as that takes, so that an image, whenever it ends, has lost at most
    /// twice the least that was possible.
    fn bounded_code<'v>(
        &self,
        index: usize,
        variant: &'v Variant,
        is_unknown: [bool; 2],
    ) -> Option<&'v Code<BoundedFn>> {
        let way = usize::from(is_unknown[0]) + 2 * usize::from(is_unknown[1]) - 1;
        let BoundedCode { spent, code } = &variant.bounded[way];
        if code.get().is_none() && self.tiering == Tiering::Hot {
            let spent = spent.fetch_add(REFUSAL_FUEL, Ordering::Relaxed) + REFUSAL_FUEL;
            let n_insts = variant.shader.bodies().map(Body::n_insts).sum::<usize>() as u64;
            if spent < COMPILE_FUEL + COMPILE_FUEL_PER_INST * EXPANSION * n_insts {
                return None;
            }
        }
        let compile = || {
            let work = || self.compile_bounded(&bounded(&variant.shader, is_unknown));
            let code = self.generating.measure(work)?;
            self.announce(index, &code);
            Some(code)
        };
        code.get_or_init(compile).as_ref()
    }

    fn compile_bounded(&self, shader: &Shader) -> Option<Code<BoundedFn>> {
        Code::compile_bounded(shader, self.max_calls(shader), &isa()?).ok()
    }
}

impl NativeSurfaces<'_> {
    /// [`SurfaceEval::eval_bounded`].
    pub(crate) fn bounds(
        &mut self,
        surface: SurfaceId,
        at: &impl LocateBounded,
    ) -> Option<BoundedSample> {
        let index = surface.0 as usize;
        let shaders = self.shaders;
        let slot = &shaders.slots[index];
        if slot.tier.get().is_none() {
            self.bounds_cold(index, surface, at)?;
        }
        match slot.tier.get() {
            Some(Tier::Constant(sample)) => Some(exact(sample)),
            Some(Tier::Native(native, needs)) => {
                let at = at.locate_bounded(*needs);
                if let Some(at) = known(&at, *needs) {
                    return self.eval(surface, &at).ok().as_ref().map(exact);
                }
                let is_unknown = [needs.u && at.u.error != 0.0, needs.v && at.v.error != 0.0];
                let bound = slot.variant.get()?.as_ref().ok()?;
                let code = shaders.bounded_code(index, &bound.variant, is_unknown)?;
                native.call_bounded(code, at.face, at.u, at.v)
            }
            Some(Tier::Interpreted(_)) | None => self.interpreter.eval_bounded(surface, at),
        }
    }

    /// Counts a request about a surface that has not been decided on. There is something to answer
    /// if it is decided on now, or if the point is known; otherwise this is a refusal.
    fn bounds_cold(
        &mut self,
        index: usize,
        surface: SurfaceId,
        at: &impl LocateBounded,
    ) -> Option<()> {
        let at = at.locate_bounded(Needs::ALL);
        let is_known = known(&at, Needs::ALL).is_some();
        let centre = SurfacePoint { face: at.face, u: at.u.value, v: at.v.value };
        let sample = self.interpreter.eval(surface, &centre).ok()?;
        let spent = self.interpreter.fuel_used() + if is_known { 0 } else { REFUSAL_FUEL };
        self.shaders.warm_up(index, spent, sample);
        (is_known || self.shaders.slots[index].tier.get().is_some()).then_some(())
    }
}
