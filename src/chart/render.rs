//! One image by one method, timed.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::time::Duration;

use compiler::diagnostic::Diagnostic;
use rayon::ThreadPool;
use renderer::camera::Region;
use renderer::image::{Image, Pixel};
use renderer::plan::Omissions;
use renderer::sampling::Sampling;
use vm::host::RenderJob;
use vm::machine::Limits;
use vm::surfaces;

use crate::args::{Engine, Precision};
use crate::chart::errors::Light;
use crate::chart::methods::{Numbers, Render};
use crate::measure::machine::thread_time;
use crate::run;
use crate::run::plan::Plan;
use crate::stability::naive::{self, Number, TooDeep};
use crate::trace::{self, Settings, Traced};

/// What rendering takes besides job, plan and method.
#[derive(Clone, Copy)]
pub(super) struct Setting<'s> {
    /// Times are those of the thread that begins, so that only those of one thread mean anything.
    pub(super) threads: &'s ThreadPool,
    pub(super) limits: Limits,
    /// Processor time after which it is given up.
    pub(super) timeout: Option<Duration>,
}

impl<'s> Setting<'s> {
    /// The settings of our own tracer: by the processor time of one thread.
    pub(super) fn of_tracer(self, engine: Engine, precision: Precision) -> Settings<'s> {
        Settings {
            threads: self.threads,
            engine,
            precision,
            omissions: Omissions::ALL,
            sampling: Sampling::Centre,
            limits: self.limits,
            perf_map: None,
            clock: thread_time,
        }
    }
}

/// What came of it.
pub(super) struct Rendered {
    /// Those of the region alone.
    pub(super) pixels: Vec<Light>,
    /// From the eye.
    pub(super) n_rays: u64,
    pub(super) preparing: Duration,
    pub(super) tracing: Duration,
}

/// Why there is no image.
pub(super) enum Stop {
    /// A surface function is wrong.
    Wrong(Box<Diagnostic>),
    /// The naive tracer cannot follow.
    TooDeep,
    TimedOut,
}

impl From<TooDeep> for Stop {
    fn from(_: TooDeep) -> Stop {
        Stop::TooDeep
    }
}

/// What a tracer is unwound with when its time is over.
struct GivenUp;

/// Renders a job.
///
/// # Errors
/// Why it ended early.
pub(super) fn render(
    job: &RenderJob<'_>,
    plan: &Plan,
    how: Render,
    setting: Setting<'_>,
) -> Result<Rendered, Stop> {
    let ours = |engine, precision| setting.of_tracer(engine, precision);
    in_time(setting, |progress| match how {
        Render::Tracer(engine, precision) => traced(job, plan, ours(engine, precision), progress),
        Render::Naive(Numbers::F32, epsilon) => {
            naive::<f32>(job, plan, epsilon, setting.limits, progress)
        }
        Render::Naive(Numbers::F64, epsilon) => {
            naive::<f64>(job, plan, epsilon, setting.limits, progress)
        }
        Render::Sampled(sampling) => {
            let settings = Settings { sampling, ..ours(Engine::Jit, Precision::F64) };
            traced(job, plan, settings, progress)
        }
    })
}

/// Lets a tracer run on the setting's threads, and gives it up when its time is over. The tracer
/// tells its progress to what it gets.
///
/// # Errors
/// The tracer's, or that its time was over.
pub(super) fn in_time<T: Send>(
    setting: Setting<'_>,
    tracer: impl FnOnce(&(dyn Fn(u64) + Sync)) -> Result<T, Stop> + Send,
) -> Result<T, Stop> {
    let run = || {
        let start = thread_time();
        // Tracers know no other way out between two rows than to unwind.
        tracer(&|_| {
            if setting.timeout.is_some_and(|timeout| thread_time() - start > timeout) {
                resume_unwind(Box::new(GivenUp));
            }
        })
    };
    match catch_unwind(AssertUnwindSafe(|| setting.threads.install(run))) {
        Ok(ended) => ended,
        Err(reason) if reason.is::<GivenUp>() => Err(Stop::TimedOut),
        Err(panic) => resume_unwind(panic),
    }
}

/// A pixel as it is traced, neither clamped nor rounded.
#[derive(Clone, Copy, Default)]
struct Linear([f64; 3]);

/// Two are the same if they are the same bytes.
impl PartialEq for Linear {
    fn eq(&self, other: &Self) -> bool {
        <[u8; 3]>::from_linear(self.0) == <[u8; 3]>::from_linear(other.0)
    }
}

impl Pixel for Linear {
    fn from_linear(color: [f64; 3]) -> Self {
        Linear(color)
    }

    fn shown(color: [f64; 3]) -> [f64; 3] {
        color
    }
}

/// Our own tracer.
fn traced(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Rendered, Stop> {
    let traced = trace::trace_pixels(job, plan, settings, progress)
        .map_err(|failure| Stop::Wrong(run::surface_error(failure, job)))?;
    let Traced { picture, rays, build_time, jit_time, trace_time, .. } = traced;
    let pixels = lights(&picture, plan.view.region);
    let preparing = build_time + jit_time;
    Ok(Rendered { pixels, n_rays: rays.primary, preparing, tracing: trace_time })
}

fn naive<F: Number>(
    job: &RenderJob<'_>,
    plan: &Plan,
    epsilon: f64,
    limits: Limits,
    progress: &dyn Fn(u64),
) -> Result<Rendered, Stop> {
    // Only our own tracer lists them, with a scene that this one has no use for.
    let (_, functions) = surfaces::scene::<f64>(&job.object);
    let start = thread_time();
    let tracer = naive::Tracer::<F>::new(job, &functions, &plan.illumination, limits, epsilon)?;
    let made = thread_time();
    let pixels = tracer.trace(&plan.view, progress).pixels;
    let n_rays = plan.n_pixels();
    Ok(Rendered { pixels, n_rays, preparing: made - start, tracing: thread_time() - made })
}

/// The pixels of a region as they are.
fn lights(image: &Image<Linear>, region: Region) -> Vec<Light> {
    let Region { x, y, width, height } = region;
    let at = |x: u32, y: u32| image.pixels[y as usize * image.width as usize + x as usize];
    let places = (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y)));
    places.map(|(x, y)| Some(at(x, y).0)).collect()
}
