//! The one place where a render job meets the renderer: object to scene, scene to pixels.

use std::time::{Duration, Instant};

use renderer::image::{Image, Pixel};
use renderer::scene::Scene;
use renderer::shade::RayCounts;
use vm::error::Error;
use vm::host::RenderJob;
use vm::machine::Limits;
use vm::surfaces::{self, InterpSurfaces};

use crate::formats::{Picture, Pixels};
use crate::run::plan::Plan;

/// What came of a render job.
pub(crate) struct Traced {
    /// The image.
    pub(crate) picture: Picture,
    /// The rays it took.
    pub(crate) rays: RayCounts,
    /// Shapes of the scene.
    pub(crate) n_shapes: usize,
    /// Surface functions of the scene.
    pub(crate) n_surfaces: usize,
    /// How long it took to make the scene traceable.
    pub(crate) build_time: Duration,
    /// How long the rays took.
    pub(crate) trace_time: Duration,
}

/// The first pixel whose surface function is wrong.
pub(crate) type TraceFailure = renderer::Failure<Box<Error>>;

/// Traces the image of `job` as `plan` says; `is_linear` asks for linear light in place of bytes.
/// `progress` is told how many pixels have been added.
///
/// # Errors
/// What a surface function does wrong.
pub(crate) fn trace_job(
    job: &RenderJob<'_>,
    plan: &Plan,
    is_linear: bool,
    limits: Limits,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Traced, TraceFailure> {
    let start = Instant::now();
    let (scene, surfaces): (Scene, _) = surfaces::scene(&job.object);
    let built = Instant::now();
    let Plan { view, illumination } = plan;
    let worker = || InterpSurfaces::new(job.program, &surfaces, limits);
    let (picture, rays) = if is_linear {
        let traced = renderer::render(&scene, illumination, view, worker, progress)?;
        picture(traced, Pixels::Linear)
    } else {
        let traced = renderer::render(&scene, illumination, view, worker, progress)?;
        picture(traced, Pixels::Bytes)
    };
    Ok(Traced {
        picture,
        rays,
        n_shapes: scene.n_shapes(),
        n_surfaces: surfaces.len(),
        build_time: built - start,
        trace_time: built.elapsed(),
    })
}

fn picture<P: Pixel>(
    (image, rays): (Image<P>, RayCounts),
    pixels: impl FnOnce(Vec<P>) -> Pixels,
) -> (Picture, RayCounts) {
    let Image { width, height, pixels: all } = image;
    (Picture { width, height, pixels: pixels(all) }, rays)
}
