//! Measuring: all sizes of a series in turn, round by round, each from its program on.

use std::sync::Arc;

use compiler::bytecode::Constant;
use compiler::diagnostic::Diagnostic;
use compiler::preprocess::NoIncludes;
use compiler::source::SourceMap;
use renderer::shade::RayCounts;
use vm::host::{Host, RenderJob};
use vm::machine::Machine;
use vm::program::LoadedProgram;

use crate::args::{Engine, Precision};
use crate::chart::data::Outcome;
use crate::chart::measure::{Bench, outcome};
use crate::chart::render::{Setting, Stop, in_time};
use crate::chart::scaling::data::{Measured, Point, Times};
use crate::chart::scaling::series::{SERIES, Series};
use crate::failure::Failure;
use crate::measure::machine::thread_time;
use crate::measure::rounds::Rounds;
use crate::run;
use crate::run::limits::Used;
use crate::run::plan::{self, Plan};
use crate::trace;
use crate::values::Size;

/// The series asked for.
pub(crate) fn asked(words: &[String]) -> impl Iterator<Item = &'static Series> {
    SERIES.iter().filter(|series| words.iter().any(|word| series.is_meant_by(word)))
}

/// Measures a series up to the size asked for. Sizes that give no image have an outcome that says so.
///
/// # Errors
/// When the region asked for has no pixels.
pub(crate) fn measure(series: &Series, bench: Bench<'_>) -> Result<Measured, Failure> {
    let Bench { args, reporter, .. } = bench;
    let sizes = series.sizes.iter().filter(|n| **n <= args.up_to);
    let mut contenders: Vec<_> =
        sizes.map(|n| Contender { n: *n, times: None, stopped: None }).collect();
    let rounds = Rounds::new(args.warmup, args.runs, None);
    let bar = rounds.bar(series.name, contenders.len(), reporter.quiet);
    rounds.each(contenders.len(), |index, counts| {
        contenders[index].run(series, bench, counts)?;
        bar.inc(1);
        Ok(())
    })?;
    bar.finish();
    let points = contenders.into_iter().map(Contender::point).collect();
    let series = series.name.to_owned();
    Ok(Measured { series, points, about: bench.about.clone() })
}

/// A size in the contest.
struct Contender {
    n: u64,
    /// Of the rounds that counted so far.
    times: Option<Times>,
    stopped: Option<Outcome<Times>>,
}

impl Contender {
    /// Runs the program once.
    fn run(&mut self, series: &Series, bench: Bench<'_>, counts: bool) -> Result<(), Failure> {
        if self.stopped.is_some() {
            return Ok(());
        }
        let setting = setting(bench);
        let host = || Once { bench, rendered: None, stopped_by: None };
        // A scene of a million solids leaves memory behind that the allocator tidies when it is asked
        // for more: by a small scene that is not measured, and not by the one that is.
        let _ = run_program(series, series.sizes[0], &mut host());
        let mut host = host();
        let start = thread_time();
        let ended = run_program(series, self.n, &mut host);
        let program = (thread_time() - start).as_secs_f64();
        let Once { rendered, stopped_by, .. } = host;
        if let Some(failure) = stopped_by {
            return Err(failure);
        }
        match (rendered, ended) {
            (Some(Err(stop)), _) | (_, Err(stop)) => self.stopped = Some(outcome(stop, setting)),
            (Some(Ok(rendered)), Ok(())) if counts => self.add(rendered, program),
            (Some(Ok(_)), Ok(())) => {}
            (None, Ok(())) => unreachable!("each program renders an image"),
        }
        Ok(())
    }

    fn add(&mut self, rendered: Rendered, program: f64) {
        let Rendered { rays, pixels, preparing, tracing } = rendered;
        let times = self.times.get_or_insert_with(|| Times {
            rays: rays.primary + rays.reflected + rays.shadow,
            pixels,
            program: Vec::new(),
            preparing: Vec::new(),
            tracing: Vec::new(),
        });
        times.program.push(program);
        times.preparing.push(preparing);
        times.tracing.push(tracing);
    }

    fn point(self) -> Point {
        let Contender { n, times, stopped } = self;
        let rendered = || Outcome::Rendered(times.expect("a round counts, or it was stopped"));
        Point { n, outcome: stopped.unwrap_or_else(rendered) }
    }
}

fn setting(bench: Bench<'_>) -> Setting<'_> {
    let Bench { args, thread, .. } = bench;
    Setting { threads: thread, limits: args.limits.machine(), timeout: Some(args.timeout) }
}

/// Compiles and runs the program of a series for a size.
fn run_program(series: &Series, n: u64, host: &mut Once<'_>) -> Result<(), Stop> {
    let mut sources = SourceMap::default();
    let name = format!("{}.gml", series.name);
    let root = sources.add(&name, series.program.into()).expect("programs of ours are short");
    let bindings = [(Arc::from("n"), Constant::Int(n.cast_signed()))];
    let program = compiler::compile(&mut sources, root, &mut NoIncludes, &bindings)
        .expect("programs of ours are right");
    let program = Arc::new(LoadedProgram::new(program));
    let limits = host.bench.args.limits.machine();
    let ended = Machine::new(&program, limits).run(host);
    match ended {
        Ok(_) => Ok(()),
        Err(error) => Err(Stop::Wrong(Box::new(error.into_diagnostic()))),
    }
}

/// A host that traces the one image of a program.
struct Once<'b> {
    bench: Bench<'b>,
    rendered: Option<Result<Rendered, Stop>>,
    /// Why there is nothing to measure.
    stopped_by: Option<Failure>,
}

/// An image that was traced: its rays, and seconds.
struct Rendered {
    rays: RayCounts,
    pixels: u64,
    preparing: f64,
    tracing: f64,
}

impl Once<'_> {
    fn trace(&self, job: &RenderJob<'_>, plan: &Plan) -> Result<Rendered, Stop> {
        let setting = setting(self.bench);
        let settings = setting.of_tracer(Engine::Auto, Precision::F64);
        in_time(setting, |progress| {
            let traced = trace::trace_job(job, plan, settings, false, progress)
                .map_err(|failure| Stop::Wrong(run::surface_error(failure, job)))?;
            Ok(Rendered {
                rays: traced.rays,
                pixels: plan.n_pixels(),
                preparing: (traced.build_time + traced.jit_time).as_secs_f64(),
                tracing: traced.trace_time.as_secs_f64(),
            })
        })
    }
}

impl Host for Once<'_> {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        let args = self.bench.args;
        let Size { width, height } = plan::size(&job, &args.picture);
        let mut used = Used::default();
        used.add(width, height);
        args.limits.check(&job, used, width, height, Precision::F64)?;
        match Plan::new(&job, &args.picture) {
            Ok(plan) => self.rendered = Some(self.trace(&job, &plan)),
            Err(failure) => self.stopped_by = Some(failure),
        }
        Ok(())
    }
}
