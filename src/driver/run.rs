//! `gmlvm run`: compiles a scene, runs it, and writes the images it renders.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use jit::shaders::SurfaceReport;
use rayon::ThreadPool;
use vm::machine::Machine;
use vm::program::LoadedProgram;

use crate::args::{RunArgs, sampling};
use crate::console;
use crate::failure::Failure;
use crate::listing::numbered;
use crate::listing::text::evaluation;
use crate::load::Source;
use crate::parts::store::Store;
use crate::perf::PerfMap;
use crate::report::Reporter;
use crate::run::Renders;
use crate::run::stats::{Counts, Phases, seconds};

pub(super) fn run(args: &RunArgs, reporter: &Reporter) -> Result<u8, Failure> {
    if args.inputs.untrusted {
        confine(args, reporter);
    }
    let threads = threads(args.threads.map_or(0, usize::from))?;
    let mut host = Renders::new(args, &threads, reporter)?;
    host.perf_map = args.perf_map.then(PerfMap::create).transpose()?;
    match args.frames {
        Some(frames) => {
            let shard = args.parts.shard.map(|choice| choice.resolve()).transpose()?;
            for frame in frames.of(shard) {
                let mut args = args.clone();
                args.inputs.defines.extend(frames.definitions(frame));
                host.frame = Some(frame);
                execute(&args, &mut host, reporter)?;
            }
        }
        None => execute(args, &mut host, reporter)?,
    }
    host.perf_map.take().map_or(Ok(()), PerfMap::finish)?;
    write_stats(args, threads.current_num_threads(), host)?;
    Ok(0)
}

/// Has the kernel refuse this thread, and those to come, all writing but where the outputs go.
#[cfg(target_os = "linux")]
fn confine(args: &RunArgs, reporter: &Reporter) {
    let confinement = crate::confine::confine(&args.writable());
    reporter.detail(confinement.line());
}

#[cfg(not(target_os = "linux"))]
fn confine(_: &RunArgs, reporter: &Reporter) {
    reporter.detail("not confined: there is no Landlock on this system");
}

/// Reads, compiles and runs a scene. What that took is added to the host's statistics.
///
/// # Errors
/// When something is wrong; with the program, the user has been told.
pub(super) fn execute(
    args: &RunArgs,
    host: &mut Renders<'_>,
    reporter: &Reporter,
) -> Result<(), Failure> {
    let start = Instant::now();
    let mut source = Source::read(&args.scene, &args.inputs, reporter)?;
    let compile_start = Instant::now();
    let program = Arc::new(LoadedProgram::new(source.compile(reporter)?));
    let run_start = Instant::now();
    let functions = &program.bytecode.functions;
    host.stats.counts = Counts {
        functions: functions.len(),
        instructions: functions.iter().map(|function| function.code.len()).sum(),
        ..host.stats.counts
    };
    let (busy, hashing) = (host.busy, host.hash_time);
    if let Some(map) = &mut host.perf_map {
        map.name_shaders(&program.bytecode, &source.sources);
    }
    host.parts = Store::open(args, &source.sources)?;
    let outcome = Machine::new(&program, args.limits.machine()).run(host);
    let Phases { read, compile, run, .. } = host.stats.phases;
    host.stats.total += seconds(start.elapsed().saturating_sub(host.hash_time - hashing));
    host.stats.phases = Phases {
        read: read + seconds(source.read_time),
        compile: compile + seconds(run_start - compile_start),
        run: run + seconds(run_start.elapsed().saturating_sub(host.busy - busy)),
        ..host.stats.phases
    };
    if reporter.verbose {
        reporter.detail(&host.stats.phases_line());
        for line in surface_lines(&host.surfaces, &source) {
            reporter.detail(&line);
        }
    }
    outcome.map_err(|error| match host.stopped_by.take() {
        Some(failure) => failure,
        None => source.stopped(error.into_diagnostic(), reporter),
    })?;
    host.finish_parts()
}

/// A pool of so many threads; 0 stands for one per processor.
///
/// # Errors
/// When the system does not give them.
pub(crate) fn threads(n: usize) -> Result<ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().map_err(|error| {
        Failure::Usage(format!("cannot start the threads: {}", console::reason(&error)))
    })
}

/// How the surface functions were evaluated, a line for each function and way. Surfaces are numbered
/// through all images.
fn surface_lines(reports: &[SurfaceReport], source: &Source<'_>) -> Vec<String> {
    let mut alike: Vec<(String, Vec<usize>)> = Vec::new();
    let mut by_line = HashMap::new();
    for (number, report) in reports.iter().enumerate() {
        let how = evaluation(&report.evaluation, &source.sources);
        let line = format!("{}: {how}", source.place(report.span));
        let index = *by_line.entry(line.clone()).or_insert(alike.len());
        if index == alike.len() {
            alike.push((line, Vec::new()));
        }
        alike[index].1.push(number);
    }
    alike.iter().map(|(line, numbers)| format!("{} at {line}", numbered(numbers))).collect()
}

fn write_stats(args: &RunArgs, n_threads: usize, mut host: Renders<'_>) -> Result<(), Failure> {
    let Some(path) = &args.stats else { return Ok(()) };
    host.stats.version = env!("CARGO_PKG_VERSION");
    host.stats.scene = args.scene.display().to_string();
    host.stats.engine = args.engine.name();
    host.stats.precision = args.precision().name();
    host.stats.sampling = sampling::name(args.sampling.sampling());
    host.stats.threads = n_threads;
    host.stats.write(path, args.outputs.existing())
}
