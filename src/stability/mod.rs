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
    let mut sources = SourceMap::default();
    let file = sources.add(&format!("{}.gml", case.name), case.text.as_bytes().to_vec());
    let file = file.expect("the suite's scenes are short");
    let program = compiler::compile(&mut sources, file, &mut Embedded, &[])
        .map_err(|diagnostics| reporter.diagnostics(&diagnostics, &sources, None))?;
    let program = Arc::new(LoadedProgram::new(program));
    let ours = methods.iter().map(|_| Vec::new()).collect();
    let mut images = Images { methods, threads, naive: Vec::new(), ours };
    Machine::new(&program, LIMITS)
        .run(&mut images)
        .map_err(|error| reporter.diagnostics(&[error.into_diagnostic()], &sources, None))?;
    let error = |images: &Vec<Image>| case.oracle.error(images);
    Ok(Row {
        case,
        n_pixels: images.naive.iter().map(Image::n_pixels).sum(),
        naive: error(&images.naive),
        ours: images.ours.iter().map(error).collect(),
    })
}

/// The file that scenes of the suite include.
struct Embedded;

impl Includes for Embedded {
    fn load(&mut self, _: &str, name: &str) -> Option<(String, Vec<u8>)> {
        (name == "common.gml").then(|| (name.to_owned(), COMMON.as_bytes().to_vec()))
    }
}

/// A host that renders each job with all methods.
struct Images<'m> {
    methods: &'m [Method],
    threads: &'m ThreadPool,
    naive: Vec<Image>,
    /// By method.
    ours: Vec<Vec<Image>>,
}

impl Host for Images<'_> {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        self.naive.push(naive_image(&job));
        for (method, images) in self.methods.iter().zip(&mut self.ours) {
            images.push(render(&job, *method, self.threads));
        }
        Ok(())
    }
}

fn naive_image(job: &RenderJob<'_>) -> Image {
    let illumination = job.illumination(Dialect::Auto);
    let (_, functions) = surfaces::scene::<f64>(&job.object);
    let naive::Traced { pixels, n_blocked } =
        naive::Tracer::<f64>::new(job, &functions, &illumination, LIMITS, naive::EPSILON)
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
