//! Measuring: all methods in turn, round by round, on each image of a scene.

use std::path::Path;
use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use rayon::ThreadPool;
use vm::host::{Host, RenderJob};
use vm::machine::Machine;
use vm::program::LoadedProgram;

use crate::args::{ChartArgs, Precision};
use crate::chart::data::{About, Chart, Figures, Measured, Outcome};
use crate::chart::errors::{Light, Sums};
use crate::chart::methods::{Diagram, METHODS, Method, Render};
use crate::chart::render::{self, Setting, Stop};
use crate::clean::clean;
use crate::failure::Failure;
use crate::load::Source;
use crate::measure::rounds::Rounds;
use crate::report::Reporter;
use crate::run::limits::Used;
use crate::run::plan::Plan;
use crate::run::{self, plan};
use crate::values::Size;

/// What measuring takes besides the scene.
#[derive(Clone, Copy)]
pub(crate) struct Bench<'b> {
    pub(crate) args: &'b ChartArgs,
    /// One thread, whose processor time is measured.
    pub(crate) thread: &'b ThreadPool,
    pub(crate) two_threads: &'b ThreadPool,
    /// What references are traced by.
    pub(crate) all_threads: &'b ThreadPool,
    pub(crate) about: &'b About,
    pub(crate) reporter: &'b Reporter,
}

/// Measures the methods asked for on a scene: a chart for each diagram that has any of them.
///
/// # Errors
/// What is wrong with the scene.
pub(crate) fn measure(scene: &Path, bench: Bench<'_>) -> Result<Vec<Chart>, Failure> {
    let source = Source::read(scene, &bench.args.inputs, bench.reporter)?;
    measure_source(source, scene, bench)
}

/// The same of a scene that has been read, under the name `scene`.
///
/// # Errors
/// What is wrong with the scene.
pub(crate) fn measure_source(
    source: Source<'_>,
    scene: &Path,
    bench: Bench<'_>,
) -> Result<Vec<Chart>, Failure> {
    let name = clean(&scene.display().to_string()).into_owned();
    let mut contest = Contest::new(&name, bench);
    each_image(source, scene, bench, &mut |job, plan, used| contest.image(job, plan, used))?;
    Ok(contest.charts())
}

/// What is done with an image, which comes with what has been asked for by then.
pub(crate) type OfImage<'f> =
    &'f mut dyn FnMut(&RenderJob<'_>, &Plan, Used) -> Result<(), Box<Diagnostic>>;

/// Runs the program of a scene, and does something with each image that it asks for.
///
/// # Errors
/// What is wrong with the scene, or that it asks for none.
pub(crate) fn each_image(
    mut source: Source<'_>,
    scene: &Path,
    bench: Bench<'_>,
    of_image: OfImage<'_>,
) -> Result<(), Failure> {
    let Bench { args, reporter, .. } = bench;
    let program = Arc::new(LoadedProgram::new(source.compile(reporter)?));
    let mut host = Images { bench, of_image, used: Used::default(), stopped_by: None };
    let outcome = Machine::new(&program, args.limits.machine()).run(&mut host);
    outcome.map_err(|error| match host.stopped_by.take() {
        Some(failure) => failure,
        None => source.stopped(error.into_diagnostic(), reporter),
    })?;
    if host.used.images == 0 {
        let name = clean(&scene.display().to_string()).into_owned();
        return Err(Failure::Usage(format!("`{name}` renders no image that could be charted")));
    }
    Ok(())
}

/// A host that does something with each job.
struct Images<'b> {
    bench: Bench<'b>,
    of_image: OfImage<'b>,
    used: Used,
    stopped_by: Option<Failure>,
}

impl Host for Images<'_> {
    fn render(&mut self, mut job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        let picture = &self.bench.args.picture;
        job.depth = picture.depth.unwrap_or(job.depth);
        match Plan::new(&job, picture) {
            Ok(plan) => {
                self.used.add(plan.view.width, plan.view.height);
                (self.of_image)(&job, &plan, self.used)
            }
            Err(failure) => {
                // What is returned is never shown.
                self.stopped_by = Some(failure);
                Err(run::stopped())
            }
        }
    }
}

/// All methods, which render each image.
struct Contest<'b> {
    scene: &'b str,
    bench: Bench<'b>,
    contenders: Vec<Contender>,
    used: Used,
    n_pixels: u64,
}

/// A method in the contest.
struct Contender {
    method: &'static Method,
    /// Seconds by round, of all images so far.
    tracing: Vec<f64>,
    preparing: Vec<f64>,
    sums: Sums,
    /// Rays from the eye, and pixels, of all images so far.
    n_rays: u64,
    n_pixels: u64,
    /// Rounds of this image that counted, and whether it has been compared.
    n_rounds: usize,
    is_compared: bool,
    stopped: Option<Outcome<Figures>>,
}

/// What images are compared with, by diagram.
type References = Vec<(Diagram, Vec<Light>)>;

impl<'b> Contest<'b> {
    fn new(scene: &'b str, bench: Bench<'b>) -> Self {
        let asked = &bench.args.methods;
        let is_asked = |method: &&Method| asked.iter().any(|word| method.is_meant_by(word));
        let n_rounds = bench.args.runs as usize;
        let contender = |method| Contender {
            method,
            tracing: vec![0.0; n_rounds],
            preparing: vec![0.0; n_rounds],
            sums: Sums::default(),
            n_rays: 0,
            n_pixels: 0,
            n_rounds: 0,
            is_compared: false,
            stopped: None,
        };
        let contenders = METHODS.iter().filter(is_asked).map(contender).collect();
        Contest { scene, bench, contenders, used: Used::default(), n_pixels: 0 }
    }

    fn diagrams(&self) -> impl Iterator<Item = Diagram> {
        let has =
            |diagram: &Diagram| self.contenders.iter().any(|c| c.method.diagram() == *diagram);
        Diagram::ALL.into_iter().filter(has)
    }

    fn references(&self, job: &RenderJob<'_>, plan: &Plan) -> Result<References, Box<Diagnostic>> {
        let Bench { args, all_threads, .. } = self.bench;
        let setting =
            Setting { threads: all_threads, limits: args.limits.machine(), timeout: None };
        let reference = |diagram: Diagram| {
            let how = diagram.reference();
            self.check(job, how)?;
            match render::render(job, plan, how, setting) {
                Ok(rendered) => Ok((diagram, rendered.pixels)),
                Err(Stop::Wrong(diagnostic)) => Err(diagnostic),
                Err(Stop::TooDeep | Stop::TimedOut) => {
                    unreachable!("neither is possible without a naive tracer or a timeout")
                }
            }
        };
        self.diagrams().map(reference).collect()
    }

    /// Fails if an image is too large for this method, or the scene.
    fn check(&self, job: &RenderJob<'_>, how: Render) -> Result<(), Box<Diagnostic>> {
        let args = self.bench.args;
        let Size { width, height } = plan::size(job, &args.picture);
        let precision = match how {
            Render::Tracer(_, precision) => precision,
            Render::Naive(..) | Render::Sampled(_) => Precision::F64,
        };
        args.limits.check(job, self.used, width, height, precision)
    }

    fn image(
        &mut self,
        job: &RenderJob<'_>,
        plan: &Plan,
        used: Used,
    ) -> Result<(), Box<Diagnostic>> {
        let Bench { args, thread, reporter, .. } = self.bench;
        self.used = used;
        let references = self.references(job, plan)?;
        let mut contenders = std::mem::take(&mut self.contenders);
        for contender in &mut contenders {
            contender.begin(self.check(job, contender.method.render));
        }
        let setting =
            Setting { threads: thread, limits: args.limits.machine(), timeout: Some(args.timeout) };
        let rounds = Rounds::new(args.warmup, args.runs, None);
        let bar = rounds.bar(self.scene, contenders.len(), reporter.quiet);
        let done: Result<(), std::convert::Infallible> =
            rounds.each(contenders.len(), |index, counts| {
                contenders[index].run(job, plan, setting, &references, counts);
                bar.inc(1);
                Ok(())
            });
        let Ok(()) = done;
        bar.finish();
        self.contenders = contenders;
        self.n_pixels += plan.n_pixels();
        Ok(())
    }

    fn charts(self) -> Vec<Chart> {
        let diagrams: Vec<_> = self.diagrams().collect();
        let mut measured: Vec<_> =
            self.contenders.into_iter().map(|c| (c.method.diagram(), c.measured())).collect();
        let chart = |diagram: Diagram| Chart {
            scene: self.scene.to_owned(),
            diagram,
            images: self.used.images,
            pixels: self.n_pixels,
            methods: measured.extract_if(.., |(of, _)| *of == diagram).map(|(_, m)| m).collect(),
            about: self.bench.about.clone(),
        };
        diagrams.into_iter().map(chart).collect()
    }
}

impl Contender {
    /// Begins with the next image, unless that is beyond a limit.
    fn begin(&mut self, check: Result<(), Box<Diagnostic>>) {
        self.n_rounds = 0;
        self.is_compared = false;
        if let Err(diagnostic) = check {
            self.stopped.get_or_insert(Outcome::Failed { reason: diagnostic.message });
        }
    }

    fn run(
        &mut self,
        job: &RenderJob<'_>,
        plan: &Plan,
        setting: Setting<'_>,
        references: &References,
        counts: bool,
    ) {
        if self.stopped.is_some() {
            return;
        }
        let rendered = match render::render(job, plan, self.method.render, setting) {
            Ok(rendered) => rendered,
            Err(stop) => {
                self.stopped = Some(outcome(stop, setting));
                return;
            }
        };
        if !self.is_compared {
            let is_own = |(diagram, _): &&(Diagram, _)| *diagram == self.method.diagram();
            let (_, reference) = references.iter().find(is_own).expect("of each diagram");
            self.sums.add(&rendered.pixels, reference);
            self.n_rays += rendered.n_rays;
            self.n_pixels += plan.n_pixels();
            self.is_compared = true;
        }
        if counts {
            self.tracing[self.n_rounds] += rendered.tracing.as_secs_f64();
            self.preparing[self.n_rounds] += rendered.preparing.as_secs_f64();
            self.n_rounds += 1;
        }
    }

    fn measured(self) -> Measured {
        let Contender { method, tracing, preparing, sums, n_rays, n_pixels, stopped, .. } = self;
        let rays = n_rays as f64 / n_pixels as f64;
        let figures = Figures { tracing, preparing, rays, errors: sums.errors() };
        let outcome = stopped.unwrap_or(Outcome::Rendered(figures));
        Measured { method: method.name.to_owned(), outcome }
    }
}

/// Why there is no image, as charts show it.
pub(super) fn outcome<F>(stop: Stop, setting: Setting<'_>) -> Outcome<F> {
    let failed = |reason: String| Outcome::Failed { reason };
    match stop {
        Stop::Wrong(diagnostic) => failed(diagnostic.message),
        Stop::TooDeep => failed("the solid is nested too deep".to_owned()),
        Stop::TimedOut => {
            Outcome::TimedOut { seconds: setting.timeout.unwrap_or_default().as_secs_f64() }
        }
    }
}
