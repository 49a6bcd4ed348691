//! The one place where a render job meets the renderer: object to scene, scene to pixels.

use std::sync::Arc;
use std::time::Duration;

use jit::shaders::{Observer, Shaders, SurfaceReport, Tiering};
use rayon::ThreadPool;
pub(crate) use renderer::certify::Account;
use renderer::certify::{self, CertainScene, Certainty};
use renderer::image::{Image, Pixel};
use renderer::numeric::dd::Dd;
use renderer::numeric::real::Real;
use renderer::plan::{Omissions, Use};
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
use crate::parts::store::ImageParts;
use crate::perf::PerfMap;
use crate::run::plan::Plan;

/// What came of a render job.
pub(crate) struct Traced<I = Picture> {
    /// The image.
    pub(crate) picture: I,
    /// How each of its pixels is known, if that was asked for.
    pub(crate) certainties: Option<Vec<Certainty>>,
    /// The rays it took.
    pub(crate) rays: RayCounts,
    /// What the scene uses of the model.
    pub(crate) used: Use,
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
    /// What may be left out of the model.
    pub(crate) omissions: Omissions,
    /// Which points make a pixel; certified ones are seen at their centres.
    pub(crate) sampling: Sampling,
    /// What each call of a surface function may use up.
    pub(crate) limits: Limits,
    /// Who is told of machine code.
    pub(crate) perf_map: Option<&'s PerfMap>,
    /// What tells the times: that of the day, or a processor's.
    pub(crate) clock: fn() -> Duration,
}

/// Traces the image of `job` as `plan` says, as linear light or as bytes. `progress` is told how many
/// pixels have been added.
///
/// # Errors
/// What a surface function does wrong.
pub(crate) fn trace_job(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    is_linear: bool,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Traced, TraceFailure> {
    Ok(if is_linear {
        trace_pixels(job, plan, settings, progress)?.map(|image| picture(image, Pixels::Linear))
    } else {
        trace_pixels(job, plan, settings, progress)?.map(|image| picture(image, Pixels::Bytes))
    })
}

/// The same in the pieces that `parts` says.
///
/// # Errors
/// What a surface function does wrong.
pub(crate) fn trace_parts(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    parts: &mut ImageParts<'_>,
    is_linear: bool,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Traced, TraceFailure> {
    Ok(if is_linear {
        let traced = trace_pieces(job, plan, settings, parts, progress)?;
        traced.map(|image| picture(image, Pixels::Linear))
    } else {
        let traced = trace_pieces(job, plan, settings, parts, progress)?;
        traced.map(|image| picture(image, Pixels::Bytes))
    })
}

/// The same in any pieces, as bytes.
///
/// # Errors
/// What a surface function does wrong.
pub(crate) fn trace_bytes(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    pieces: &mut dyn Pieces<[u8; 3]>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Traced, TraceFailure> {
    let traced = trace_pieces(job, plan, settings, pieces, progress)?;
    Ok(traced.map(|image| picture(image, Pixels::Bytes)))
}

/// Traces an image in pixels of any kind.
///
/// # Errors
/// What a surface function does wrong.
pub(crate) fn trace_pixels<P: Pixel>(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Traced<Image<P>>, TraceFailure> {
    trace_pieces(job, plan, settings, &mut Whole, progress)
}

fn trace_pieces<P: Pixel>(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    pieces: &mut dyn Pieces<P>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Traced<Image<P>>, TraceFailure> {
    match settings.precision {
        Precision::F64 => trace_with::<Scene<f64>, P>(job, plan, settings, pieces, progress),
        Precision::Dd => trace_with::<Scene<Dd>, P>(job, plan, settings, pieces, progress),
        Precision::Certified => {
            trace_with::<CertainScene, P>(job, plan, settings, pieces, progress)
        }
    }
}

/// Renders what a plan says of a scene that is ready to be traced.
pub(crate) type Render<'r, P> = &'r dyn Fn(&Plan) -> Result<Rendered<P>, TraceFailure>;

/// In which pieces an image is rendered.
pub(crate) trait Pieces<P> {
    /// Has all of them rendered; returns the image.
    ///
    /// # Errors
    /// What a surface function does wrong.
    fn render(&mut self, plan: &Plan, render: Render<'_, P>) -> Result<Rendered<P>, TraceFailure>;
}

/// In one piece.
struct Whole;

impl<P> Pieces<P> for Whole {
    fn render(&mut self, plan: &Plan, render: Render<'_, P>) -> Result<Rendered<P>, TraceFailure> {
        render(plan)
    }
}

/// What is made of a job's object to be traced.
trait Traceable: Send + Sync + Sized {
    /// Makes it, with the surface functions by number.
    fn build(job: &RenderJob<'_>, omissions: Omissions) -> (Self, Vec<Arc<Closure>>);

    /// What it uses of the model.
    fn used(&self, plan: &Plan) -> Use;

    fn render<E: SurfaceEval<Error = Box<Error>> + Send, P: Pixel>(
        &self,
        plan: &Plan,
        sampling: Sampling,
        worker: impl Fn() -> E + Sync,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Rendered<P>, TraceFailure>;
}

/// An image, how each of its pixels is known, if that was asked for, and the rays it took.
pub(crate) type Rendered<P> = (Image<P>, Option<Vec<Certainty>>, RayCounts);

impl<R: Real> Traceable for Scene<R> {
    fn build(job: &RenderJob<'_>, omissions: Omissions) -> (Self, Vec<Arc<Closure>>) {
        let (scene, functions) = surfaces::scene(&job.object);
        (scene.leaving_out(omissions), functions)
    }

    fn used(&self, plan: &Plan) -> Use {
        Use::of(self, &plan.illumination)
    }

    fn render<E: SurfaceEval<Error = Box<Error>> + Send, P: Pixel>(
        &self,
        Plan { view, illumination }: &Plan,
        sampling: Sampling,
        worker: impl Fn() -> E + Sync,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Rendered<P>, TraceFailure> {
        let (image, rays) =
            renderer::sampling::sample(self, illumination, view, sampling, worker, progress)?;
        Ok((image, None, rays))
    }
}

impl Traceable for CertainScene {
    fn build(job: &RenderJob<'_>, omissions: Omissions) -> (Self, Vec<Arc<Closure>>) {
        // All number the surface functions alike: in the order of the operands.
        let (exact, _) = Scene::build(job, omissions);
        let (double, _) = Scene::build(job, omissions);
        let (rough, functions) = Scene::build(job, omissions);
        (CertainScene::new(rough, double, exact), functions)
    }

    fn used(&self, plan: &Plan) -> Use {
        CertainScene::used(self, &plan.illumination)
    }

    fn render<E: SurfaceEval<Error = Box<Error>> + Send, P: Pixel>(
        &self,
        Plan { view, illumination }: &Plan,
        _: Sampling,
        worker: impl Fn() -> E + Sync,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Rendered<P>, TraceFailure> {
        let (image, certainties, rays) =
            certify::certify(self, illumination, view, worker, progress)?;
        Ok((image, Some(certainties), rays))
    }
}

/// What certified tracing says of each pixel's light, beside what is so: see [`certify::accounts`].
///
/// # Errors
/// What a surface function does wrong.
pub(crate) fn accounts(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<Option<[Account; 3]>>, TraceFailure> {
    let Plan { view, illumination } = plan;
    settings.threads.install(|| {
        let (scene, surfaces) = CertainScene::build(job, settings.omissions);
        let shaders = Shaders::new(job.program, &surfaces, settings.limits, Tiering::Eager);
        certify::accounts(&scene, illumination, view, || shaders.worker(), progress)
    })
}

fn trace_with<T: Traceable, P: Pixel>(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    pieces: &mut dyn Pieces<P>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Traced<Image<P>>, TraceFailure> {
    let now = settings.clock;
    let start = now();
    let (scene, surfaces) = settings.threads.install(|| T::build(job, settings.omissions));
    let built = now();
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
    let made = now();
    let times = || shaders.as_ref().map_or(Duration::ZERO, |shaders| shaders.times().total());
    let times_before = times();
    let (picture, certainties, rays) = pieces.render(plan, &|plan| {
        settings.threads.install(|| match &shaders {
            Some(shaders) => scene.render(plan, settings.sampling, || shaders.worker(), progress),
            None => {
                let worker = || InterpSurfaces::new(job.program, &surfaces, limits);
                scene.render(plan, settings.sampling, worker, progress)
            }
        })
    })?;
    let trace_time = now() - made;
    let jit_time = (made - built) + (times() - times_before);
    Ok(Traced {
        picture,
        certainties,
        rays,
        used: scene.used(plan),
        surfaces: shaders.map(|shaders| shaders.report()).unwrap_or_default(),
        n_surfaces: surfaces.len(),
        build_time: built - start,
        jit_time,
        trace_time,
    })
}

fn picture<P>(image: Image<P>, pixels: impl FnOnce(Vec<P>) -> Pixels) -> Picture {
    let Image { width, height, pixels: all } = image;
    Picture { width, height, pixels: pixels(all) }
}

impl<I> Traced<I> {
    fn map<J>(self, change: impl FnOnce(I) -> J) -> Traced<J> {
        Traced {
            picture: change(self.picture),
            certainties: self.certainties,
            rays: self.rays,
            used: self.used,
            surfaces: self.surfaces,
            n_surfaces: self.n_surfaces,
            build_time: self.build_time,
            jit_time: self.jit_time,
            trace_time: self.trace_time,
        }
    }
}
