//! A host that takes every render job, looks whether it could be done, and does nothing.

use std::io;
use std::path::Path;
use std::sync::Arc;

use compiler::diagnostic::{Code, Diagnostic};
use vm::host::{Host, RenderJob};
use vm::machine::Machine;
use vm::program::LoadedProgram;
use vm::value::Value;

use crate::args::{Inputs, LimitArgs, Precision};
use crate::failure::Failure;
use crate::load::Source;
use crate::output;
use crate::report::Reporter;
use crate::run;
use crate::run::limits::Used;

struct Accepts<'v> {
    limits: LimitArgs,
    used: Used,
    visit: Visit<'v>,
    /// Why the run ended, where no diagnostic can tell.
    stopped_by: Option<io::Error>,
}

/// Has a look at each job that would be rendered; an error ends the run.
pub(super) type Visit<'v> = &'v mut dyn FnMut(&RenderJob<'_>) -> io::Result<()>;

impl Host for Accepts<'_> {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        self.used.add(job.width, job.height);
        self.limits.check(&job, self.used, job.width, job.height, Precision::F64)?;
        output::stem(&job.name).map(drop).map_err(|reason| {
            run::unwritable(output::Problem::Refused(reason), &job, &job.name, Path::new("."))
        })?;
        (self.visit)(&job).map_err(|error| {
            self.stopped_by = Some(error);
            // Never shown.
            Box::new(Diagnostic::new(Code::CannotWrite, job.origin.span, "stopped"))
        })
    }
}

/// Runs a compiled program without rendering.
///
/// # Errors
/// What stopped it.
pub(crate) fn run_to_the_end(
    program: &Arc<LoadedProgram>,
    limits: LimitArgs,
) -> Result<Vec<Value>, Box<vm::error::Error>> {
    let mut host =
        Accepts { limits, used: Used::default(), visit: &mut |_| Ok(()), stopped_by: None };
    Machine::new(program, limits.machine()).run(&mut host)
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
    run_visited(&source, &program, limits, reporter, &mut |_| Ok(()))
}

/// Runs a compiled program without rendering; returns its final stack, bottom first.
///
/// # Errors
/// When it is wrong, of which the user has been told, or when `visit` fails to write.
pub(super) fn run_visited(
    source: &Source<'_>,
    program: &Arc<LoadedProgram>,
    limits: LimitArgs,
    reporter: &Reporter,
    visit: Visit<'_>,
) -> Result<Vec<Value>, Failure> {
    let mut host = Accepts { limits, used: Used::default(), visit, stopped_by: None };
    let outcome = Machine::new(program, limits.machine()).run(&mut host);
    outcome.map_err(|error| match host.stopped_by {
        Some(error) => Failure::stdout(&error),
        None => source.stopped(error.into_diagnostic(), reporter),
    })
}
