//! What is told of shaders: how surfaces are evaluated, what has been compiled, and how long that took.

use std::sync::Arc;
use std::time::Duration;

use compiler::source::Span;
use vm::value::Closure;

use crate::shaders::{Shaders, Slot, Tier};
use crate::unsupported::Unsupported;

/// How a surface function is evaluated, for reports.
#[derive(Clone, Debug, PartialEq)]
pub enum Evaluation {
    /// It ignores where it is asked.
    Constant,
    /// By machine code of so many bytes, with so many numbers that other surfaces may have
    /// different.
    Native {
        /// Bytes of code.
        n_bytes: usize,
        /// Uniforms.
        n_uniforms: u32,
        /// Whether it is evaluated at many points at once where there are many.
        in_batches: bool,
    },
    /// By the interpreter, since it cannot be compiled.
    Declined(Unsupported),
    /// By the interpreter, since it has not been called often.
    Cold,
}

/// One surface function of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceReport {
    /// The function's source text.
    pub span: Span,
    /// How it is evaluated.
    pub evaluation: Evaluation,
}

/// A piece of machine code that has been made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// The source text of the surface function.
    pub span: Span,
    /// Where the code starts.
    pub address: usize,
    /// Its length in bytes.
    pub n_bytes: usize,
}

/// Is told of each piece of machine code once it is made, by the thread that made it.
pub type Observer<'o> = &'o (dyn Fn(Region) + Sync);

/// Time spent on compiling so far, summed over threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CompileTimes {
    /// From bytecode to SSA.
    pub specialize: Duration,
    /// From SSA to machine code.
    pub generate: Duration,
}

impl CompileTimes {
    /// Both.
    #[must_use]
    pub fn total(self) -> Duration {
        self.specialize + self.generate
    }
}

impl Shaders<'_> {
    /// How each surface is evaluated by now.
    #[must_use]
    pub fn report(&self) -> Vec<SurfaceReport> {
        let of = |(closure, slot): (&Arc<Closure>, &Slot)| {
            let span = self.program.bytecode.functions[closure.function as usize].span;
            let evaluation = match (slot.native.get(), slot.tier.get()) {
                (Some((native, _)), _) => Evaluation::Native {
                    n_bytes: native.code.n_bytes,
                    n_uniforms: native.n_uniforms(),
                    in_batches: slot.batch().is_some_and(|(batch, _)| batch.pays),
                },
                (None, Some(Tier::Interpreted(why))) => Evaluation::Declined(why.clone()),
                (None, Some(Tier::Constant(_))) => Evaluation::Constant,
                (None, Some(Tier::Native) | None) => Evaluation::Cold,
            };
            SurfaceReport { span, evaluation }
        };
        self.surfaces.iter().zip(&self.slots).map(of).collect()
    }

    /// Time spent on compiling by now.
    #[must_use]
    pub fn times(&self) -> CompileTimes {
        CompileTimes { specialize: self.specializing.total(), generate: self.generating.total() }
    }
}
