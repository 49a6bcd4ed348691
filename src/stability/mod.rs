//! The stability suite: scenes that break ray tracers, what their images must be, and how far those
//! of the renderer, and of a naive one, are from it.
//!
//! Scenes are part of the binary; their files are in `tests/stability`.

use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use compiler::preprocess::Includes;
use compiler::source::SourceMap;
use rayon::ThreadPool;
use renderer::camera::View;
use renderer::image::Pixel;
use renderer::plan::Omissions;
use renderer::sampling::Sampling;
use vm::host::{Dialect, Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;
use vm::surfaces;

use crate::args::{Engine, Precision};
use crate::failure::Failure;
use crate::formats::{Picture, Pixels};
use crate::measure::machine;
use crate::report::Reporter;
use crate::run::plan::Plan;
use crate::trace::{self, Settings, Traced};
use cases::COMMON;
use image::Image;

pub(crate) use cases::{CASES, Case};

mod cases;
mod image;
pub(crate) mod naive;
mod oracle;

/// No scene of the suite comes near.
const LIMITS: Limits = Limits { fuel: 100_000_000, max_depth: 1000, max_memory: 1 << 28 };

/// A way to render that the suite holds to its bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Method {
    /// What evaluates surface functions.
    pub(crate) engine: Engine,
    /// The numbers that rays are traced in.
    pub(crate) precision: Precision,
}

impl Method {
    /// The heading of its column.
    pub(crate) fn name(self) -> String {
        self.engine.in_precision(self.precision)
    }
}

/// A way to render that can be held against what is known of a case.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Way {
    /// The renderer.
    Ours(Method),
    /// The naive one in doubles, with this epsilon.
    NaiveDoubles(f64),
    /// The same in single precision.
    NaiveSingles(f64),
}

/// How far images of a case are from what is known of them.
pub(crate) struct Row {
    pub(crate) case: &'static Case,
    /// Pixels of all images.
    pub(crate) n_pixels: u64,
    /// Those of the naive renderer.
    pub(crate) naive: u64,
    /// Those of each method.
    pub(crate) ours: Vec<u64>,
}

impl Row {
    /// Whether all methods are within the case's bound.
    pub(crate) fn holds(&self) -> bool {
        self.ours.iter().all(|&error| error <= self.case.bound)
    }
}

/// All cases, each measured when it is asked for.
pub(crate) fn rows<'a>(
    methods: &'a [Method],
    threads: &'a ThreadPool,
    reporter: &'a Reporter,
) -> impl Iterator<Item = Result<Row, Failure>> + 'a {
    CASES.iter().map(move |case| measure(case, methods, threads, reporter))
}

fn measure(
    case: &'static Case,
    methods: &[Method],
    threads: &ThreadPool,
    reporter: &Reporter,
) -> Result<Row, Failure> {
    let ours = methods.iter().map(|method| Way::Ours(*method));
    let ways: Vec<_> = std::iter::once(Way::NaiveDoubles(naive::EPSILON)).chain(ours).collect();
    let Wrong { n_pixels, mut by_way } = wrong(case, &ways, threads, reporter)?;
    let ours = by_way.split_off(1);
    Ok(Row { case, n_pixels, naive: by_way[0], ours })
}

/// What of a case's images is not as it must be.
pub(crate) struct Wrong {
    /// Pixels of all images.
    pub(crate) n_pixels: u64,
    /// Wrong pixels, and rays that are blocked by nothing, of each way.
    pub(crate) by_way: Vec<u64>,
}

/// Renders a case in each of these ways.
///
/// # Errors
/// What is wrong with the scene.
pub(crate) fn wrong(
    case: &'static Case,
    ways: &[Way],
    threads: &ThreadPool,
    reporter: &Reporter,
) -> Result<Wrong, Failure> {
    let mut sources = SourceMap::default();
    let file = sources.add(&format!("{}.gml", case.name), case.text.as_bytes().to_vec());
    let file = file.expect("the suite's scenes are short");
    let program = compiler::compile(&mut sources, file, &mut Embedded, &[])
        .map_err(|diagnostics| reporter.diagnostics(&diagnostics, &sources, None))?;
    let program = Arc::new(LoadedProgram::new(program));
    let by_way = ways.iter().map(|_| Vec::new()).collect();
    let mut images = Images { ways, threads, by_way };
    Machine::new(&program, LIMITS)
        .run(&mut images)
        .map_err(|error| reporter.diagnostics(&[error.into_diagnostic()], &sources, None))?;
    let Images { by_way, .. } = images;
    let n_pixels = by_way.first().map_or(0, |images| images.iter().map(Image::n_pixels).sum());
    Ok(Wrong { n_pixels, by_way: by_way.iter().map(|images| case.oracle.error(images)).collect() })
}

/// The file that scenes of the suite include.
struct Embedded;

impl Includes for Embedded {
    fn load(&mut self, _: &str, name: &str) -> Option<(String, Vec<u8>)> {
        (name == "common.gml").then(|| (name.to_owned(), COMMON.as_bytes().to_vec()))
    }
}

/// A host that renders each job in all ways.
struct Images<'w> {
    ways: &'w [Way],
    threads: &'w ThreadPool,
    by_way: Vec<Vec<Image>>,
}

impl Host for Images<'_> {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        for (way, images) in self.ways.iter().zip(&mut self.by_way) {
            images.push(match *way {
                Way::Ours(method) => render(&job, method, self.threads),
                Way::NaiveDoubles(epsilon) => naive_image::<f64>(&job, epsilon),
                Way::NaiveSingles(epsilon) => naive_image::<f32>(&job, epsilon),
            });
        }
        Ok(())
    }
}

fn naive_image<F: naive::Number>(job: &RenderJob<'_>, epsilon: f64) -> Image {
    let illumination = job.illumination(Dialect::Auto);
    let (_, functions) = surfaces::scene::<f64>(&job.object);
    let naive::Traced { pixels, n_blocked } =
        naive::Tracer::<F>::new(job, &functions, &illumination, LIMITS, epsilon)
            .expect("no solid of the suite is nested deep")
            .trace(&View::whole(job.width, job.height, job.fov_deg), &|_| {});
    let pixels = pixels.into_iter().map(|light| light.map(<[u8; 3]>::from_linear)).collect();
    Image { width: job.width, height: job.height, pixels, n_blocked }
}

fn render(job: &RenderJob<'_>, method: Method, threads: &ThreadPool) -> Image {
    let plan = Plan {
        view: View::whole(job.width, job.height, job.fov_deg),
        illumination: job.illumination(Dialect::Auto),
    };
    let settings = Settings {
        threads,
        engine: method.engine,
        precision: method.precision,
        omissions: Omissions::ALL,
        sampling: Sampling::Centre,
        limits: LIMITS,
        perf_map: None,
        clock: machine::time,
    };
    let (pixels, n_blocked) = match trace::trace_job(job, &plan, settings, false, &|_| {}) {
        Ok(Traced { picture: Picture { pixels: Pixels::Bytes(pixels), .. }, rays, .. }) => {
            (pixels.into_iter().map(Some).collect(), rays.blocked)
        }
        // A surface function has failed: there is no image, and no pixel is right.
        _ => (vec![None; (job.width * job.height) as usize], 0),
    };
    Image { width: job.width, height: job.height, pixels, n_blocked }
}
