//! Bounds of what surface functions answer, by bounded shaders.
//!
//! A function is compiled when its bounds are first asked for, whatever the tiering: where there are
//! none, a pixel is traced again in double-double, and a hundred such pixels take longer than compiling
//! does. And so it does not depend on the moment how a pixel is known.

use std::sync::OnceLock;

use renderer::surface::{
    BoundedSample, LocateBounded, Needs, SurfaceEval, SurfaceId, SurfacePoint,
};
use vm::surfaces::{exact, known};

use crate::abi::BoundedFn;
use crate::bounded::bounded;
use crate::code::{Code, isa};
use crate::shaders::{NativeSurfaces, Shaders, Tier, Variant};
use crate::sir::Shader;

/// One bounded version of a shader; none if it cannot be compiled.
pub(crate) type BoundedCode = OnceLock<Option<Code<BoundedFn>>>;

impl Shaders<'_> {
    /// The bounded version of a surface's shader for points of which u, v or both are not known; none
    /// if it cannot be compiled.
    fn bounded_code<'v>(
        &self,
        index: usize,
        variant: &'v Variant,
        is_unknown: [bool; 2],
    ) -> Option<&'v Code<BoundedFn>> {
        let way = usize::from(is_unknown[0]) + 2 * usize::from(is_unknown[1]) - 1;
        let compile = || {
            let work = || self.compile_bounded(&bounded(&variant.shader, is_unknown));
            let code = self.generating.measure(work)?;
            self.announce(index, &code);
            Some(code)
        };
        variant.bounded[way].get_or_init(compile).as_ref()
    }

    fn compile_bounded(&self, shader: &Shader) -> Option<Code<BoundedFn>> {
        Code::compile_bounded(shader, self.max_calls(shader), &isa()?).ok()
    }
}

impl NativeSurfaces<'_> {
    /// [`SurfaceEval::eval_bounded`].
    #[inline(always)]
    pub(crate) fn bounds(
        &mut self,
        surface: SurfaceId,
        at: &impl LocateBounded,
    ) -> Option<BoundedSample> {
        let index = surface.0 as usize;
        let shaders = self.shaders;
        let slot = &shaders.slots[index];
        if slot.tier.get().is_none() {
            self.decide_at(index, surface, at);
        }
        if let Some(Tier::Constant(sample)) = slot.tier.get() {
            return Some(exact(sample));
        }
        let Some((native, needs)) = slot.native.get() else {
            return self.interpreter.eval_bounded(surface, at);
        };
        let at = at.locate_bounded(*needs);
        if let Some(at) = known(&at, *needs) {
            return self.eval(surface, &at).ok().as_ref().map(exact);
        }
        let is_unknown = [needs.u && at.u.error != 0.0, needs.v && at.v.error != 0.0];
        let bound = slot.variant.get()?.as_ref().ok()?;
        let code = shaders.bounded_code(index, &bound.variant, is_unknown)?;
        native.call_bounded(code, at.face, at.u, at.v)
    }

    /// Decides how a surface is evaluated from now on.
    #[cold]
    #[inline(never)]
    fn decide_at(&mut self, index: usize, surface: SurfaceId, at: &impl LocateBounded) {
        let at = at.locate_bounded(Needs::ALL);
        let centre = SurfacePoint { face: at.face, u: at.u.value, v: at.v.value };
        self.shaders.decide(index, || self.interpreter.eval(surface, &centre).ok());
    }
}
