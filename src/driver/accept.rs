//! A host that takes every render job, looks whether it could be done, and does nothing.

use std::path::Path;
use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use vm::host::{Host, RenderJob};
use vm::machine::Machine;
use vm::program::LoadedProgram;
use vm::value::Value;

use crate::args::{Inputs, LimitArgs};
use crate::failure::Failure;
use crate::load::Source;
use crate::output;
use crate::report::Reporter;
use crate::run;

struct Accepts {
    limits: LimitArgs,
    n_images: u64,
}

impl Host for Accepts {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        self.n_images += 1;
        self.limits.check(&job, self.n_images, job.width, job.height)?;
        output::stem(&job.name).map(drop).map_err(|reason| {
            run::unwritable(output::Problem::Refused(reason), &job, &job.name, Path::new("."))
        })
    }
}

/// Compiles and runs a program without rendering; returns its final stack, bottom first.
///
/// # Errors
/// When it is wrong; the user has been told.
pub(super) fn run_without_images(
    scene: &Path,
    inputs: &Inputs,
    limits: LimitArgs,
    reporter: &Reporter,
) -> Result<Vec<Value>, Failure> {
    let mut source = Source::read(scene, inputs, reporter)?;
    let program = Arc::new(LoadedProgram::new(source.compile(reporter)?));
    let mut host = Accepts { limits, n_images: 0 };
    Machine::new(&program, limits.machine())
        .run(&mut host)
        .map_err(|error| source.stopped(error.into_diagnostic(), reporter))
}
