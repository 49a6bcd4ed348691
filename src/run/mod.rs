//! What `render` does: the host of a running program that traces its images and writes them.

use std::io::{self, IsTerminal};
use std::path::Path;
use std::time::{Duration, Instant};

use compiler::diagnostic::{Code, Diagnostic};
use compiler::source::Span;
use jit::shaders::SurfaceReport;
use rayon::ThreadPool;
use vm::host::{Host, RenderJob};

use crate::args::{ImageFormat, RunArgs};
use crate::clean::clean;
use crate::console;
use crate::failure::Failure;
use crate::formats::{self, Picture};
use crate::frames;
use crate::load::is_stdio;
use crate::measure::machine;
use crate::output::{Contents, Problem, Target, Written};
use crate::parts::store::{self, ImageParts, Store};
use crate::perf::PerfMap;
use crate::preview::Preview;
use crate::report::Reporter;
use crate::run::certainty::Known;
use crate::run::digest::Digest;
use crate::run::limits::Used;
use crate::run::naming::{Destination, Naming, Number, Sink};
use crate::run::plan::Plan;
use crate::run::stats::{ImageStats, Stats, seconds};
use crate::trace::{self, Settings, TraceFailure, Traced};
use crate::values::Size;

pub(crate) mod certainty;
pub(crate) mod digest;
pub(crate) mod economy;
pub(crate) mod naming;
pub(crate) mod plan;
pub(crate) mod progress;
pub(crate) mod stats;

pub(crate) mod limits;
mod writable;

/// What came of tracing an image.
struct Outcome {
    traced: Traced,
    /// How many pixels were traced now.
    n_pixels: u64,
    /// What there is of parts, in words.
    parts: Option<String>,
}

/// The host of `gmlvm run`, and of each run of `gmlvm bench`.
pub(crate) struct Renders<'a> {
    args: &'a RunArgs,
    reporter: &'a Reporter,
    threads: &'a ThreadPool,
    naming: Naming,
    /// What the run has had so far, with the current image.
    used: Used,
    /// Where images have gone, with their marks.
    written: Written,
    /// Where images are drawn besides, if they are.
    preview: Option<Preview>,
    /// The frame that is being run, if there are frames.
    pub(crate) frame: Option<u32>,
    /// What the images took.
    pub(crate) stats: Stats,
    /// How the surface functions of all images were evaluated.
    pub(crate) surfaces: Vec<SurfaceReport>,
    /// Who is told of machine code.
    pub(crate) perf_map: Option<PerfMap>,
    /// Where parts of images are kept, if they are.
    pub(crate) parts: Option<Store>,
    /// Time spent on images.
    pub(crate) busy: Duration,
    /// The files that went to memory, and the time that hashing them took.
    pub(crate) digest: Digest,
    pub(crate) hash_time: Duration,
    /// Why the run ended, where no diagnostic can tell.
    pub(crate) stopped_by: Option<Failure>,
}

impl<'a> Renders<'a> {
    /// A host as the command line asks for.
    ///
    /// # Errors
    /// When the options contradict one another, or image bytes would go to a terminal.
    pub(crate) fn new(
        args: &'a RunArgs,
        threads: &'a ThreadPool,
        reporter: &'a Reporter,
    ) -> Result<Self, Failure> {
        let has_frames = args.frames.is_some();
        let naming = Naming::new(args.output.as_deref(), &args.out_dir, has_frames)?;
        store::check(args)?;
        frames::check(args)?;
        if let Some(file) = &args.mark_uncertain {
            certainty::check_name(file, has_frames)?;
        }
        if let Some(file) = args.stats.as_ref().filter(|file| !is_stdio(file)) {
            let target = Target::path(file.clone());
            let checked = target.check(args.outputs.existing());
            checked.map_err(|problem| target.failure(problem))?;
        }
        if matches!(naming, Naming::Stdout) {
            let usage = |message: &str| Err(Failure::Usage(message.to_owned()));
            if args.stats.as_deref().is_some_and(is_stdio) {
                return usage("the image and the statistics cannot both go to the standard output");
            }
            if io::stdout().is_terminal() {
                let message = "will not write image bytes to a terminal; redirect the output, or use \
                               `--preview` in place of `--output -`";
                return usage(message);
            }
        }
        let preview = args.outputs.preview.then(|| Preview::new(reporter)).flatten();
        Ok(Renders { preview, ..Renders::with(naming, args, threads, reporter) })
    }

    /// A host that writes images to memory only.
    pub(crate) fn to_memory(
        args: &'a RunArgs,
        threads: &'a ThreadPool,
        reporter: &'a Reporter,
    ) -> Self {
        Renders::with(Naming::Memory, args, threads, reporter)
    }

    fn with(
        naming: Naming,
        args: &'a RunArgs,
        threads: &'a ThreadPool,
        reporter: &'a Reporter,
    ) -> Self {
        Renders {
            args,
            reporter,
            threads,
            naming,
            used: Used::default(),
            written: Written::default(),
            preview: None,
            frame: None,
            stats: Stats::default(),
            surfaces: Vec::new(),
            perf_map: None,
            parts: None,
            busy: Duration::ZERO,
            digest: Digest::default(),
            hash_time: Duration::ZERO,
            stopped_by: None,
        }
    }

    fn image(&mut self, job: &RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        let start = Instant::now();
        let Size { width, height } = plan::size(job, &self.args.picture);
        let precision = self.args.precision();
        self.used.add(width, height);
        self.args.limits.check(job, self.used, width, height, precision)?;
        let plan = Plan::new(job, &self.args.picture).map_err(|failure| self.stop(failure))?;
        let destination = self.destination(job)?;
        let shown = match &destination.sink {
            Sink::File(target) => clean(&target.shown().to_string_lossy()).into_owned(),
            Sink::Stdout | Sink::Memory => "-".to_owned(),
        };
        let is_whole = self.parts.as_ref().is_none_or(|parts| parts.shard().is_none());
        if is_whole {
            self.check_existing(job, &destination, &shown)?;
        }
        let Outcome { traced, n_pixels, parts } =
            self.trace(job, &plan, destination.format, &shown)?;
        let write_time = match is_whole {
            true => self.write(&destination, &traced.picture, job, &shown)?,
            false => Duration::ZERO,
        };
        let time = start.elapsed().as_secs_f64();
        let parts = parts.map_or(String::new(), |line| format!("  {line}"));
        self.reporter.note(&format!("{shown}  {width}x{height}{parts}  {time:.2} s"));
        if let Some(preview) = self.preview.filter(|_| is_whole) {
            preview.draw(&traced.picture);
        }
        let known = self.certainty(job, &traced)?;
        if self.parts.is_none() {
            self.explain(job, &plan, &traced)?;
        }
        let file = (is_whole && matches!(destination.sink, Sink::File(_))).then_some(shown);
        let mut stats = image_stats(file, job, &plan, &traced, known, write_time);
        stats.pixels = n_pixels;
        self.stats.add(stats);
        self.surfaces.extend(traced.surfaces);
        Ok(())
    }

    /// Tells how the pixels of an image are known, if that was asked for.
    fn certainty(
        &mut self,
        job: &RenderJob<'_>,
        traced: &Traced,
    ) -> Result<Option<Known>, Box<Diagnostic>> {
        let Some(certainties) = &traced.certainties else { return Ok(None) };
        let known = Known::count(certainties);
        self.reporter.note(&format!("  {}", known.line()));
        if let Some(file) = &self.args.mark_uncertain {
            let (target, existing) = (self.marks(file, job)?, self.args.outputs.existing());
            self.check_written(&target, marks_of(job))?;
            certainty::write_marks(&target, certainties, &traced.picture, existing)
                .map_err(|problem| certainty::unwritable(problem, job, file))?;
            self.written.add(&target, marks_of(job));
        }
        Ok(Some(known))
    }

    /// The file for the marks of a job's image.
    fn marks(&self, file: &Path, job: &RenderJob<'_>) -> Result<Target, Box<Diagnostic>> {
        let target = naming::filled(file, &job.name, self.number());
        target.map_err(|problem| certainty::unwritable(problem, job, file))
    }

    /// Fails if something else of this run has been written there.
    fn check_written(
        &mut self,
        target: &Target,
        contents: Contents,
    ) -> Result<(), Box<Diagnostic>> {
        self.written.check(target, &contents).map_err(|failure| self.stop(failure))
    }

    /// Fails if a file that is to stay has the name of the image or of its marks.
    fn check_existing(
        &mut self,
        job: &RenderJob<'_>,
        destination: &Destination,
        shown: &str,
    ) -> Result<(), Box<Diagnostic>> {
        let existing = self.args.outputs.existing();
        if let Sink::File(target) = &destination.sink {
            self.check_written(target, image_of(job))?;
            let checked = target.check(existing);
            checked.map_err(|problem| unwritable(problem, job, shown, &self.args.out_dir))?;
        }
        let Some(file) = &self.args.mark_uncertain else { return Ok(()) };
        let target = self.marks(file, job)?;
        self.check_written(&target, marks_of(job))?;
        target.check(existing).map_err(|problem| certainty::unwritable(problem, job, file))
    }

    /// Which image the current one is.
    fn number(&self) -> Number {
        Number { image: self.used.images, frame: self.frame }
    }

    fn destination(&mut self, job: &RenderJob<'_>) -> Result<Destination, Box<Diagnostic>> {
        let destination = self
            .naming
            .destination(&job.name, self.number(), self.args.format)
            .map_err(|problem| {
                let path = self.args.out_dir.join(&*job.name);
                unwritable(problem, job, &path.to_string_lossy(), &self.args.out_dir)
            })?;
        if matches!(destination.sink, Sink::Stdout) && self.used.images > 1 {
            let message = "the scene renders more than one image, and the standard output has room \
                           for one; use `--output NAME` with {n} in the name";
            return Err(self.stop(Failure::Usage(message.to_owned())));
        }
        Ok(destination)
    }

    fn trace(
        &mut self,
        job: &RenderJob<'_>,
        plan: &Plan,
        format: ImageFormat,
        shown: &str,
    ) -> Result<Outcome, Box<Diagnostic>> {
        let settings = self.settings();
        let is_linear = format == ImageFormat::Pfm;
        let (n_image, view, reporter) = (self.used.images, &plan.view, self.reporter);
        let parts = self.parts.as_ref();
        let parts = parts.map(|store| store.image(job, n_image, view, format, reporter));
        let mut parts = match parts.transpose() {
            Ok(parts) => parts,
            Err(failure) => return Err(self.stop(failure)),
        };
        let n_pixels = parts.as_ref().map_or(plan.n_pixels(), |parts| parts.n_pixels(view));
        let line = parts.as_ref().map(ImageParts::line);
        let bar = progress::bar(shown, n_pixels, reporter.quiet);
        let progress = |n| bar.inc(n);
        let traced = match &mut parts {
            Some(parts) => trace::trace_parts(job, plan, settings, parts, is_linear, &progress),
            None => trace::trace_job(job, plan, settings, is_linear, &progress),
        };
        bar.finish();
        if let Some(failure) = parts.and_then(ImageParts::problem) {
            return Err(self.stop(failure));
        }
        let traced = traced.map_err(|failure| surface_error(failure, job))?;
        Ok(Outcome { traced, n_pixels, parts: line })
    }

    fn settings(&self) -> Settings<'_> {
        Settings {
            threads: self.threads,
            engine: self.args.engine,
            precision: self.args.precision(),
            omissions: self.args.economy.omissions(),
            sampling: self.args.sampling.sampling(),
            limits: self.args.limits.machine(),
            perf_map: self.perf_map.as_ref(),
            clock: machine::time,
        }
    }

    /// Tells what an image uses of the model and what leaving out the rest saves, if that was asked
    /// for.
    fn explain(
        &self,
        job: &RenderJob<'_>,
        plan: &Plan,
        traced: &Traced,
    ) -> Result<(), Box<Diagnostic>> {
        if self.args.economy.explain {
            let settings = Settings { perf_map: None, ..self.settings() };
            let lines = economy::explained(job, plan, settings, traced);
            for line in lines.map_err(|failure| surface_error(failure, job))? {
                self.reporter.note(&line);
            }
        }
        Ok(())
    }

    /// Writes an image; returns how long that took.
    fn write(
        &mut self,
        destination: &Destination,
        picture: &Picture,
        job: &RenderJob<'_>,
        shown: &str,
    ) -> Result<Duration, Box<Diagnostic>> {
        let start = Instant::now();
        let format = destination.format;
        match &destination.sink {
            Sink::Stdout => console::data(|out| formats::write(format, picture, out))
                .map_err(|failure| self.stop(failure))?,
            Sink::File(target) => {
                let mut fill = |out: &mut dyn io::Write| formats::write(format, picture, out);
                target
                    .write(self.args.outputs.existing(), &mut fill)
                    .map_err(|problem| unwritable(problem, job, shown, &self.args.out_dir))?;
                self.written.add(target, image_of(job));
            }
            Sink::Memory => {
                let mut file = Vec::new();
                formats::write(format, picture, &mut file)
                    .map_err(|error| unwritable(error.into(), job, shown, &self.args.out_dir))?;
                let write_time = start.elapsed();
                self.digest.add(&file);
                self.hash_time += start.elapsed() - write_time;
                return Ok(write_time);
            }
        }
        Ok(start.elapsed())
    }

    /// Notes with the parts that there are no further images.
    ///
    /// # Errors
    /// When that cannot be written.
    pub(crate) fn finish_parts(&self) -> Result<(), Failure> {
        self.parts.as_ref().map_or(Ok(()), |parts| parts.finish(self.used.images))
    }

    /// Ends the program for a reason that is none of its own; what is returned is never shown.
    fn stop(&mut self, failure: Failure) -> Box<Diagnostic> {
        self.stopped_by = Some(failure);
        stopped()
    }
}

impl Host for Renders<'_> {
    fn render(&mut self, mut job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        let start = Instant::now();
        job.depth = self.args.picture.depth.unwrap_or(job.depth);
        let outcome = self.image(&job);
        self.busy += start.elapsed();
        outcome
    }
}

/// What the file of a job's image holds.
fn image_of(job: &RenderJob<'_>) -> Contents {
    Contents { name: job.name.to_string(), option: "--output" }
}

/// What the file of its marks holds.
fn marks_of(job: &RenderJob<'_>) -> Contents {
    Contents { name: job.name.to_string(), option: "--mark-uncertain" }
}

/// What ends a program for a reason that is none of its own, which the host keeps; never shown.
pub(crate) fn stopped() -> Box<Diagnostic> {
    Box::new(Diagnostic::new(Code::CannotWrite, Span::NONE, "stopped"))
}

/// The error that says why the job's image, shown under this name, is not written.
pub(crate) fn unwritable(
    problem: Problem,
    job: &RenderJob<'_>,
    shown: &str,
    out_dir: &Path,
) -> Box<Diagnostic> {
    let span = job.origin.span;
    let diagnostic = match problem {
        Problem::Refused(reason) => {
            let message = format!("the file name `{}` {reason}", clean(&job.name));
            let rule = format!(
                "images are written only below `{}` (--out-dir), and not through links; a scene \
                 cannot change this",
                clean(&out_dir.to_string_lossy())
            );
            Diagnostic::new(Code::RefusedPath, span, message)
                .note(rule)
                .help("to choose the name yourself: `--output '{n}.ppm'`")
        }
        Problem::Failed(reason) => {
            let message = format!("could not write `{}`: {reason}", clean(shown));
            Diagnostic::new(Code::CannotWrite, span, message)
                .note("nothing half-written is left behind")
        }
    };
    Box::new(diagnostic)
}

/// The error of a surface function, with the pixel that met it.
pub(crate) fn surface_error(failure: TraceFailure, job: &RenderJob<'_>) -> Box<Diagnostic> {
    let (x, y) = (failure.x, failure.y);
    let mut diagnostic = failure.error.into_diagnostic();
    if diagnostic.primary.span != job.origin.span {
        diagnostic = diagnostic.also(job.origin.span, "while this image was rendered");
    }
    let place = format!("first met at pixel ({x}, {y}); see it alone with `--region {x},{y},1,1`");
    Box::new(diagnostic.note(place))
}

/// Times and counts of an image that has been traced.
pub(crate) fn image_stats(
    file: Option<String>,
    job: &RenderJob<'_>,
    plan: &Plan,
    traced: &Traced,
    certainty: Option<Known>,
    write_time: Duration,
) -> ImageStats {
    ImageStats {
        file,
        width: plan.view.width,
        height: plan.view.height,
        dialect: plan.dialect(),
        max_bounces: plan.illumination.max_bounces,
        shapes: traced.used.shapes,
        surfaces: traced.n_surfaces,
        lights: job.lights.len(),
        pixels: plan.n_pixels(),
        rays: traced.rays.into(),
        certainty,
        build: seconds(traced.build_time),
        jit: seconds(traced.jit_time),
        trace: seconds(traced.trace_time),
        write: seconds(write_time),
    }
}
