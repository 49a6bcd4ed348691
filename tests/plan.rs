//! What a scene has no use for may be left out: that changes no byte of any image, nor what goes
//! wrong with one.

use std::path::Path;

use compiler::diagnostic::Diagnostic;
use jit::shaders::{Shaders, Tiering};
use renderer::camera::View;
use renderer::certify::{CertainScene, certify};
use renderer::image::Image;
use renderer::numeric::dd::Dd;
use renderer::numeric::real::Real;
use renderer::plan::{Omissions, Part};
use renderer::scene::Scene;
use renderer::shade::RayCounts;
use renderer::surface::{Locate, Needs, SurfaceEval, SurfaceId, SurfacePoint, SurfaceSample};
use support::scenes::{LIMITS, run, shared};
use vm::host::{Dialect, Host, RenderJob};
use vm::surfaces::{InterpSurfaces, scene};

mod support {
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod scenes;
}

/// Columns of an image at most: what is left out does not depend on its size.
const WIDTH: u32 = 40;

/// What an image is, or the pixel where its surface function fails and why.
type Outcome = Result<Image<[u8; 3]>, (u32, u32, String)>;

/// The same with the numbers of rays.
type Counted = Result<(Image<[u8; 3]>, RayCounts), (u32, u32, String)>;

/// Renders each image with and without omissions, and counts them.
#[derive(Default)]
struct Comparing {
    n_images: usize,
}

impl Host for Comparing {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        let by_parts = Part::ALL.map(|part| Omissions::ALL.without(part));
        let base = by_engines::<f64>(&job, Omissions::ALL);
        for omissions in [Omissions::NONE].into_iter().chain(by_parts) {
            let other = by_engines::<f64>(&job, omissions);
            assert!(base == other, "{}: {omissions:?} differs", job.name);
        }
        let [base, other] = [Omissions::ALL, Omissions::NONE].map(|o| by_engines::<Dd>(&job, o));
        assert!(base == other, "{}: differs in double-double", job.name);
        let [base, other] = [Omissions::ALL, Omissions::NONE].map(|o| certain(&job, o));
        assert!(base == other, "{}: differs where it is certain", job.name);
        compare_batches(&job);
        self.n_images += 1;
        Ok(())
    }
}

/// Asks another evaluator at many points at once, at all but every fifth.
struct InBatches<E>(E);

impl<E: SurfaceEval> SurfaceEval for InBatches<E> {
    type Error = E::Error;

    fn eval(&mut self, surface: SurfaceId, at: &impl Locate) -> Result<SurfaceSample, E::Error> {
        self.0.eval(surface, at)
    }

    fn has_batches(&self) -> bool {
        true
    }

    fn batch_needs(&self, surface: SurfaceId) -> Option<Needs> {
        (surface.0 % 7 != 6).then_some(Needs::ALL)
    }

    fn eval_batch(
        &mut self,
        surface: SurfaceId,
        points: &[SurfacePoint],
        samples: &mut Vec<Option<SurfaceSample>>,
    ) {
        let numbered = points.iter().enumerate();
        let sample = |(index, at)| self.0.eval(surface, at).ok().filter(|_| index % 5 != 4);
        samples.extend(numbered.map(sample));
    }
}

/// Whether surface functions are asked at one point after the other or at many at once, images, failures
/// and the numbers of rays are the same.
fn compare_batches(job: &RenderJob<'_>) {
    let (view, illumination) = (view(job), job.illumination(Dialect::Auto));
    let outcomes = [Omissions::ALL.without(Part::Calls), Omissions::ALL].map(|omissions| {
        let (scene, surfaces): (Scene<f64>, _) = scene(&job.object);
        let scene = scene.leaving_out(omissions);
        let worker = || InBatches(InterpSurfaces::new(job.program, &surfaces, LIMITS));
        let outcome = renderer::render(&scene, &illumination, &view, worker, &|_| {});
        outcome.map_err(|failure| (failure.x, failure.y, failure.error.into_diagnostic().message))
    });
    let [single, many]: [Counted; 2] = outcomes;
    assert!(single == many, "{}: differs in batches", job.name);
}

/// What both engines make of a job's image.
fn by_engines<R: Real>(job: &RenderJob<'_>, omissions: Omissions) -> [Outcome; 2] {
    let (scene, surfaces): (Scene<R>, _) = scene(&job.object);
    let scene = scene.leaving_out(omissions);
    let (view, illumination) = (view(job), job.illumination(Dialect::Auto));
    let interp = || InterpSurfaces::new(job.program, &surfaces, LIMITS);
    let shaders = Shaders::new(job.program, &surfaces, LIMITS, Tiering::Eager);
    let outcomes = [
        renderer::render(&scene, &illumination, &view, interp, &|_| {}),
        renderer::render(&scene, &illumination, &view, || shaders.worker(), &|_| {}),
    ];
    outcomes.map(|outcome| match outcome {
        Ok((image, _)) => Ok(image),
        Err(failure) => Err((failure.x, failure.y, failure.error.into_diagnostic().message)),
    })
}

/// The pixels of a certified image; none if a surface function fails.
fn certain(job: &RenderJob<'_>, omissions: Omissions) -> Vec<[u8; 3]> {
    let (rough, surfaces) = scene(&job.object);
    let (double, _) = scene(&job.object);
    let (exact, _) = scene(&job.object);
    let scene = CertainScene::new(rough, double, exact).leaving_out(omissions);
    let shaders = Shaders::new(job.program, &surfaces, LIMITS, Tiering::Eager);
    let illumination = job.illumination(Dialect::Auto);
    let found = certify(&scene, &illumination, &view(job), || shaders.worker(), &|_| {});
    found.map_or_else(|_| Vec::new(), |(image, ..)| image.pixels)
}

fn view(job: &RenderJob<'_>) -> View {
    let width = job.width.min(WIDTH);
    let height = (u64::from(job.height) * u64::from(width)).div_ceil(u64::from(job.width));
    View::whole(width, height as u32, job.fov_deg)
}

fn compare_folder(folder: &Path) {
    let mut host = Comparing::default();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("readable").path();
        if path.extension().is_some_and(|extension| extension == "gml") {
            let text = std::fs::read(&path).expect("readable");
            // What goes wrong with a program goes wrong before its images.
            let _ = run(&path, &String::from_utf8_lossy(&text), &mut host);
        }
    }
    assert!(host.n_images > 0, "{}", folder.display());
}

#[test]
fn our_scenes_are_the_same() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    compare_folder(&root.join("scenes"));
    compare_folder(&root.join("tests/stability"));
    compare_folder(&root.join("tests/golden"));
}

#[test]
fn shared_scenes_are_the_same() {
    if let Some(scenes) = shared("scenes") {
        compare_folder(&scenes.join("contest"));
        compare_folder(&scenes.join("chicago"));
    }
    if let Some(folder) = shared("stability") {
        compare_folder(&folder);
    }
}
