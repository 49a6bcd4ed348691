//! `gmlvm run`: compiles a scene, runs it, and writes the images it renders.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use jit::shaders::{Evaluation, SurfaceReport};
use vm::machine::Machine;
use vm::program::LoadedProgram;

use crate::args::{Engine, RunArgs};
use crate::console;
use crate::failure::Failure;
use crate::load::Source;
use crate::report::Reporter;
use crate::run::Renders;
use crate::run::stats::{Counts, Phases, seconds};

pub(super) fn run(args: &RunArgs, reporter: &Reporter) -> Result<u8, Failure> {
    let mut host = Renders::new(args, reporter)?;
    start_threads(args)?;
    let mut source = Source::read(&args.scene, &args.inputs, reporter)?;
    let compile_start = Instant::now();
    let program = Arc::new(LoadedProgram::new(source.compile(reporter)?));
    let run_start = Instant::now();
    let functions = &program.bytecode.functions;
    host.stats.counts = Counts {
        functions: functions.len(),
        instructions: functions.iter().map(|function| function.code.len()).sum(),
        ..Counts::default()
    };
    let outcome = Machine::new(&program, args.limits.machine()).run(&mut host);
    host.stats.phases = Phases {
        read: seconds(source.read_time),
        compile: seconds(run_start - compile_start),
        run: seconds(run_start.elapsed().saturating_sub(host.busy)),
        ..host.stats.phases
    };
    reporter.detail(&host.stats.phases_line());
    for line in surface_lines(&host.surfaces, &source) {
        reporter.detail(&line);
    }
    if let Err(error) = outcome {
        return Err(match host.stopped_by {
            Some(failure) => failure,
            None => source.stopped(error.into_diagnostic(), reporter),
        });
    }
    write_stats(args, host)?;
    Ok(0)
}

/// How the surface functions were evaluated, a line for each function and way.
fn surface_lines(reports: &[SurfaceReport], source: &Source<'_>) -> Vec<String> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for report in reports {
        let how = match &report.evaluation {
            Evaluation::Constant => "constant".to_owned(),
            Evaluation::Native { n_bytes, n_uniforms } => {
                format!("native, {n_bytes} bytes of code, {n_uniforms} uniforms")
            }
            Evaluation::Declined(why) => {
                format!("interpreted: {} at {}", why.reason, source.place(why.span))
            }
            Evaluation::Cold => "interpreted: called too seldom to be worth compiling".to_owned(),
        };
        *counts.entry(format!("surface at {}: {how}", source.place(report.span))).or_default() += 1;
    }
    let times =
        |(line, n): (String, usize)| if n == 1 { line } else { format!("{line} ({n} times)") };
    counts.into_iter().map(times).collect()
}

fn start_threads(args: &RunArgs) -> Result<(), Failure> {
    let n_threads = args.threads.map_or(0, usize::from);
    rayon::ThreadPoolBuilder::new().num_threads(n_threads).build_global().map_err(|error| {
        Failure::Usage(format!("cannot start the threads: {}", console::reason(&error)))
    })
}

fn write_stats(args: &RunArgs, mut host: Renders<'_>) -> Result<(), Failure> {
    let Some(path) = &args.stats else { return Ok(()) };
    host.stats.version = env!("CARGO_PKG_VERSION");
    host.stats.scene = args.scene.display().to_string();
    host.stats.engine = match args.engine {
        Engine::Auto => "auto",
        Engine::Interp => "interp",
        Engine::Jit => "jit",
    };
    host.stats.threads = rayon::current_num_threads();
    host.stats.write(path)
}
