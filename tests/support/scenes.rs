//! Runs a scene and keeps its images in memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use compiler::source::SourceMap;
use jit::shaders::{Shaders, SurfaceReport, Tiering};
use renderer::camera::View;
use renderer::image::Image;
use renderer::sampling::{Sampling, sample};
use renderer::shade::RayCounts;
use vm::host::{Dialect, Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;
use vm::surfaces::{InterpSurfaces, scene};

use beside::Beside;

#[path = "beside.rs"]
mod beside;

pub(crate) const LIMITS: Limits =
    Limits { fuel: 1_000_000_000, max_depth: 100_000, max_memory: 1 << 30 };

/// An image, and the name that the scene gives it.
pub(crate) struct Rendered {
    pub(crate) name: String,
    pub(crate) image: Image<[u8; 3]>,
    pub(crate) counts: RayCounts,
}

/// What evaluates surface functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Engine {
    Interpreter,
    Native,
    /// The first, and then the second.
    Tiered,
}

/// How a scene is rendered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub(crate) engine: Engine,
    pub(crate) sampling: Sampling,
    /// So many times smaller than it says, rounded down but not to 0.
    pub(crate) reduction: u32,
}

struct InMemory {
    way: Way,
    images: Vec<Rendered>,
    reports: Vec<SurfaceReport>,
}

impl Host for InMemory {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        let (scene, surfaces) = scene::<f64>(&job.object);
        let Way { engine, sampling, reduction } = self.way;
        let [width, height] = [job.width, job.height].map(|length| (length / reduction).max(1));
        let view = View::whole(width, height, job.fov_deg);
        let illumination = job.illumination(Dialect::Auto);
        let tiering = match engine {
            Engine::Tiered => Tiering::Hot,
            _ => Tiering::Eager,
        };
        let result = if engine == Engine::Interpreter {
            let worker = || InterpSurfaces::new(job.program, &surfaces, LIMITS);
            sample(&scene, &illumination, &view, sampling, worker, &|_| {})
        } else {
            let shaders = Shaders::new(job.program, &surfaces, LIMITS, tiering);
            self.reports.extend(shaders.report());
            sample(&scene, &illumination, &view, sampling, || shaders.worker(), &|_| {})
        };
        let (image, counts) =
            result.map_err(|failure| Box::new(failure.error.into_diagnostic()))?;
        self.images.push(Rendered { name: job.name.to_string(), image, counts });
        Ok(())
    }
}

/// The images of a program; `path` is the file that it stands for.
pub(crate) fn render_text(path: &Path, text: &str) -> Result<Vec<Rendered>, String> {
    render_by(Engine::Interpreter, path, text).map(|(images, _)| images)
}

/// The images of a program by an engine, and how each surface was evaluated.
pub(crate) fn render_by(
    engine: Engine,
    path: &Path,
    text: &str,
) -> Result<(Vec<Rendered>, Vec<SurfaceReport>), String> {
    render_in(Way { engine, sampling: Sampling::Centre, reduction: 1 }, path, text)
}

/// The same in any way.
pub(crate) fn render_in(
    way: Way,
    path: &Path,
    text: &str,
) -> Result<(Vec<Rendered>, Vec<SurfaceReport>), String> {
    let mut host = InMemory { way, images: Vec::new(), reports: Vec::new() };
    run(path, text, &mut host)?;
    Ok((host.images, host.reports))
}

/// Runs a program, which `host` renders the images of.
pub(crate) fn run(path: &Path, text: &str, host: &mut dyn Host) -> Result<(), String> {
    let mut sources = SourceMap::default();
    let file = sources
        .add(&path.display().to_string(), text.as_bytes().to_vec())
        .map_err(|_| "too large")?;
    let told = |sources: &SourceMap, diagnostic: &Diagnostic| {
        let span = diagnostic.primary.span;
        let place = sources.file_of(span).map(|file| file.line_column(span).to_string());
        format!(
            "{} at {}: {}",
            diagnostic.code.as_str(),
            place.unwrap_or_default(),
            diagnostic.message
        )
    };
    let bytecode = compiler::compile(&mut sources, file, &mut Beside, &[])
        .map_err(|diagnostics| told(&sources, &diagnostics[0]))?;
    let program = Arc::new(LoadedProgram::new(bytecode));
    let outcome = Machine::new(&program, LIMITS).run(host);
    outcome.map(|_| ()).map_err(|error| told(&sources, &error.into_diagnostic()))
}

/// The images of a scene file.
pub(crate) fn render_file(path: &Path) -> Result<Vec<Rendered>, String> {
    let text = std::fs::read(path).map_err(|error| error.to_string())?;
    render_text(path, &String::from_utf8_lossy(&text))
}

/// A folder of material beside the checkout, if it is there; says so otherwise.
pub(crate) fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(folder);
    if path.is_dir() {
        return Some(path);
    }
    println!("skipped: there is no {}", path.display());
    None
}
