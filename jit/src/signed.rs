//! Signatures of what surface functions decide, by signed shaders, and when those are compiled.
//!
//! A signed shader is specialized like the plain one, and notes on its way each decision that the
//! interpreter would make, also those that are known beforehand: so the signatures are the same
//! numbers, whoever makes the call.

use std::sync::Arc;

use renderer::signature::Signature;
use renderer::surface::{Locate, Needs, SurfaceEval, SurfaceId, SurfacePoint, SurfaceSample};
use vm::error::Error;

use crate::abi::SignedFn;
use crate::code::{Code, Native, isa};
use crate::shaders::{Bound, NativeSurfaces, Shaders, Tier, needs};
use crate::sir::Version;
use crate::specialize::specialize;

/// How a surface function is evaluated with a signature.
pub(crate) enum Signed {
    /// The answer and the decisions are the same everywhere.
    Constant(SurfaceSample, Signature),
    Native(Native<SignedFn>, Needs),
    Interpreted,
}

/// The signed version of a specialized function.
pub(crate) struct SignedVersion {
    /// None if answer and decisions are the same everywhere.
    code: Option<Arc<Code<SignedFn>>>,
    needs: Needs,
    fuel: i64,
}

impl Shaders<'_> {
    /// How a surface on which it has been decided is evaluated with a signature; `found` is what a call
    /// has given.
    fn signed(&self, index: usize, found: (SurfaceSample, Signature)) -> &Signed {
        self.slots[index].signed.get_or_init(|| {
            let is_declined = matches!(self.slots[index].tier.get(), Some(Tier::Interpreted(_)));
            let Ok(Bound { variant, uniforms }) = self.variant(index) else {
                return Signed::Interpreted;
            };
            let version = || self.signed_version(index);
            match variant.signed.get_or_init(version).as_ref().filter(|_| !is_declined) {
                None => Signed::Interpreted,
                Some(SignedVersion { code: None, .. }) => Signed::Constant(found.0, found.1),
                Some(SignedVersion { code: Some(code), needs, fuel }) => {
                    Signed::Native(Native::new(code.clone(), uniforms, *fuel), *needs)
                }
            }
        })
    }

    fn signed_version(&self, index: usize) -> Option<SignedVersion> {
        let (outline, _) = self.cell(&self.surfaces[index]);
        let work = || specialize(&self.program.bytecode, &outline, Version::Signed);
        let shader = self.specializing.measure(work).ok()?;
        if self.are_limits_tight(&shader) {
            return None;
        }
        let needs = needs(&shader);
        let is_constant = needs == Needs { face: false, u: false, v: false };
        let mut code = None;
        if !is_constant {
            let compile = || Code::compile_signed(&shader, self.max_calls(&shader), &isa()?).ok();
            let made = self.generating.measure(compile)?;
            self.announce(index, &made);
            code = Some(Arc::new(made));
        }
        Some(SignedVersion { code, needs, fuel: self.fuel(&shader) })
    }
}

impl NativeSurfaces<'_> {
    /// [`SurfaceEval::eval_signed`].
    #[inline]
    pub(crate) fn sign(
        &mut self,
        surface: SurfaceId,
        at: &impl Locate,
    ) -> Result<(SurfaceSample, Signature), Box<Error>> {
        let index = surface.0 as usize;
        match self.shaders.slots[index].signed.get() {
            Some(Signed::Native(native, needs)) => {
                let SurfacePoint { face, u, v } = at.locate(*needs);
                match native.call(face, u, v) {
                    Some(found) => Ok(found),
                    None => self.interpreter.eval_signed(surface, at),
                }
            }
            Some(Signed::Constant(sample, signature)) => Ok((*sample, *signature)),
            Some(Signed::Interpreted) => self.interpreter.eval_signed(surface, at),
            None => self.sign_cold(index, surface, at),
        }
    }

    #[cold]
    fn sign_cold(
        &mut self,
        index: usize,
        surface: SurfaceId,
        at: &impl Locate,
    ) -> Result<(SurfaceSample, Signature), Box<Error>> {
        let found = self.interpreter.eval_signed(surface, at)?;
        let slot = &self.shaders.slots[index];
        if slot.tier.get().is_none() {
            self.shaders.warm_up(index, self.interpreter.fuel_used(), found.0);
        }
        if slot.tier.get().is_some() {
            self.shaders.signed(index, found);
        }
        Ok(found)
    }
}
