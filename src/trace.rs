//! The one place where a render job meets the renderer: object to scene, scene to pixels.

use std::sync::Arc;
use std::time::{Duration, Instant};

use jit::shaders::{Observer, Shaders, SurfaceReport, Tiering};
use rayon::ThreadPool;
use renderer::certify::{CertainScene, Certainty};
use renderer::image::{Image, Pixel};
use renderer::numeric::dd::Dd;
use renderer::numeric::real::Real;
use renderer::sampling::Sampling;
use renderer::scene::Scene;
use renderer::shade::RayCounts;
use renderer::surface::SurfaceEval;
use vm::error::Error;
use vm::host::RenderJob;
use vm::machine::Limits;
use vm::surfaces::{self, InterpSurfaces};
use vm::value::Closure;

use crate::args::{Engine, Precision};
use crate::formats::{Picture, Pixels};
use crate::perf::PerfMap;
use crate::run::plan::Plan;

/// What came of a render job.
pub(crate) struct Traced {
    /// The image.
    pub(crate) picture: Picture,
    /// How each of its pixels is known, if that was asked for.
    pub(crate) certainties: Option<Vec<Certainty>>,
    /// The rays it took.
    pub(crate) rays: RayCounts,
    /// Shapes of the scene.
    pub(crate) n_shapes: usize,
    /// How each surface function of the scene was evaluated; empty with the interpreter.
    pub(crate) surfaces: Vec<SurfaceReport>,
    /// Surface functions of the scene.
    pub(crate) n_surfaces: usize,
    /// How long it took to make the scene traceable.
    pub(crate) build_time: Duration,
    /// How long compiling surface functions took, summed over threads.
    pub(crate) jit_time: Duration,
    /// How long the rays took, with what was compiled on their way.
    pub(crate) trace_time: Duration,
}

/// The first pixel whose surface function is wrong.
pub(crate) type TraceFailure = renderer::Failure<Box<Error>>;

/// How an image is traced, besides what its plan says.
#[derive(Clone, Copy)]
pub(crate) struct Settings<'s> {
    /// The threads that trace.
    pub(crate) threads: &'s ThreadPool,
    /// What evaluates surface functions.
    pub(crate) engine: Engine,
    /// The numbers of the rays.
    pub(crate) precision: Precision,
    /// Which points make a pixel; certified ones are seen at their centres.
    pub(crate) sampling: Sampling,
    /// Linear light in place of bytes.
    pub(crate) is_linear: bool,
    /// What each call of a surface function may use up.
    pub(crate) limits: Limits,
    /// Who is told of machine code.
    pub(crate) perf_map: Option<&'s PerfMap>,
}

/// Traces the image of `job` as `plan` says. `progress` is told how many pixels have been added.
///
/// # Errors
/// What a surface function does wrong.
pub(crate) fn trace_job(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Traced, TraceFailure> {
    match settings.precision {
        Precision::F64 => trace_with::<Scene<f64>>(job, plan, settings, progress),
        Precision::Dd => trace_with::<Scene<Dd>>(job, plan, settings, progress),
        Precision::Certified => trace_with::<CertainScene>(job, plan, settings, progress),
    }
}

/// What is made of a job's object to be traced.
trait Traceable: Send + Sync + Sized {
    /// Makes it, with the surface functions by number.
    fn build(job: &RenderJob<'_>) -> (Self, Vec<Arc<Closure>>);

    fn n_shapes(&self) -> usize;

    fn render<E: SurfaceEval<Error = Box<Error>> + Send, P: Pixel + PartialEq>(
        &self,
        plan: &Plan,
        sampling: Sampling,
        worker: impl Fn() -> E + Sync,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Rendered<P>, TraceFailure>;
}

struct Rendered<P> {
    image: Image<P>,
    certainties: Option<Vec<Certainty>>,
    rays: RayCounts,
}

impl<R: Real> Traceable for Scene<R> {
    fn build(job: &RenderJob<'_>) -> (Self, Vec<Arc<Closure>>) {
        surfaces::scene(&job.object)
    }

    fn n_shapes(&self) -> usize {
        Scene::n_shapes(self)
    }

    fn render<E: SurfaceEval<Error = Box<Error>> + Send, P: Pixel + PartialEq>(
        &self,
        Plan { view, illumination }: &Plan,
        sampling: Sampling,
        worker: impl Fn() -> E + Sync,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Rendered<P>, TraceFailure> {
        let (image, rays) =
            renderer::sampling::sample(self, illumination, view, sampling, worker, progress)?;
        Ok(Rendered { image, certainties: None, rays })
    }
}

impl Traceable for CertainScene {
    fn build(job: &RenderJob<'_>) -> (Self, Vec<Arc<Closure>>) {
        // Both number the surface functions alike: in the order of the operands.
        let (exact, _) = surfaces::scene(&job.object);
        let (quick, functions) = surfaces::scene(&job.object);
        (CertainScene::new(quick, exact), functions)
    }

    fn n_shapes(&self) -> usize {
        CertainScene::n_shapes(self)
    }

    fn render<E: SurfaceEval<Error = Box<Error>> + Send, P: Pixel + PartialEq>(
        &self,
        Plan { view, illumination }: &Plan,
        _: Sampling,
        worker: impl Fn() -> E + Sync,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Rendered<P>, TraceFailure> {
        let (image, certainties, rays) =
            renderer::certify::certify(self, illumination, view, worker, progress)?;
        Ok(Rendered { image, certainties: Some(certainties), rays })
    }
}

fn trace_with<T: Traceable>(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Traced, TraceFailure> {
    let start = Instant::now();
    let (scene, surfaces) = settings.threads.install(|| T::build(job));
    let built = Instant::now();
    let limits = settings.limits;
    let shaders = match settings.engine {
        Engine::Interp => None,
        Engine::Auto => Some(Tiering::Hot),
        Engine::Jit => Some(Tiering::Eager),
    };
    let observe = settings.perf_map.map(|map| |region| map.add(region));
    let observer = observe.as_ref().map(|observe| observe as Observer<'_>);
    let shaders =
        shaders.map(|tiering| Shaders::observed(job.program, &surfaces, limits, tiering, observer));
    let made = Instant::now();
    let times = || shaders.as_ref().map_or(Duration::ZERO, |shaders| shaders.times().total());
    let times_before = times();
    let (picture, certainties, rays) = match &shaders {
        Some(shaders) => trace(&scene, plan, settings, || shaders.worker(), progress)?,
        None => {
            let worker = || InterpSurfaces::new(job.program, &surfaces, limits);
            trace(&scene, plan, settings, worker, progress)?
        }
    };
    let trace_time = made.elapsed();
    let jit_time = (made - built) + (times() - times_before);
    Ok(Traced {
        picture,
        certainties,
        rays,
        n_shapes: scene.n_shapes(),
        surfaces: shaders.map(|shaders| shaders.report()).unwrap_or_default(),
        n_surfaces: surfaces.len(),
        build_time: built - start,
        jit_time,
        trace_time,
    })
}

fn trace<E: SurfaceEval<Error = Box<Error>> + Send>(
    scene: &impl Traceable,
    plan: &Plan,
    settings: Settings<'_>,
    worker: impl Fn() -> E + Send + Sync,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<(Picture, Option<Vec<Certainty>>, RayCounts), TraceFailure> {
    settings.threads.install(|| {
        let sampling = settings.sampling;
        if settings.is_linear {
            return Ok(picture(scene.render(plan, sampling, worker, progress)?, Pixels::Linear));
        }
        Ok(picture(scene.render(plan, sampling, worker, progress)?, Pixels::Bytes))
    })
}

fn picture<P>(
    Rendered { image, certainties, rays }: Rendered<P>,
    pixels: impl FnOnce(Vec<P>) -> Pixels,
) -> (Picture, Option<Vec<Certainty>>, RayCounts) {
    let Image { width, height, pixels: all } = image;
    (Picture { width, height, pixels: pixels(all) }, certainties, rays)
}
