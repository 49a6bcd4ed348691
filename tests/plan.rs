//! What a scene has no use for may be left out: that changes no byte of any image, nor what goes
//! wrong with one.

use std::path::Path;

use compiler::diagnostic::Diagnostic;
use jit::shaders::{Shaders, Tiering};
use renderer::camera::View;
use renderer::certify::{CertainScene, certify};
use renderer::image::{Image, Pixel};
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
type Outcome<I> = Result<I, (u32, u32, String)>;

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
        let base = by_engines::<f64, [u8; 3]>(&job, Omissions::ALL);
        for omissions in [Omissions::NONE].into_iter().chain(by_parts) {
            let other = by_engines::<f64, [u8; 3]>(&job, omissions);
            assert!(base == other, "{}: {omissions:?} differs", job.name);
        }
        let [base, other] =
            [Omissions::ALL, Omissions::NONE].map(|o| by_engines::<Dd, [u8; 3]>(&job, o));
        assert!(base == other, "{}: differs in double-double", job.name);
        let [[base, jit], [other, _]] = [Omissions::ALL, Omissions::NONE].map(|o| bits(&job, o));
        assert!(base == other, "{}: differs in linear light", job.name);
        assert!(base == jit, "{}: differs in linear light by engine", job.name);
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

/// The bits that both engines give the pixels of a job's image in linear light.
fn bits(job: &RenderJob<'_>, omissions: Omissions) -> [Outcome<Vec<[u32; 3]>>; 2] {
    by_engines::<f64, [f32; 3]>(job, omissions).map(|outcome| {
        let pixels = outcome?.pixels.into_iter();
        Ok(pixels.map(|pixel| pixel.map(f32::to_bits)).collect())
    })
}

/// What both engines make of a job's image.
fn by_engines<R: Real, P: Pixel>(
    job: &RenderJob<'_>,
    omissions: Omissions,
) -> [Outcome<Image<P>>; 2] {
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

/// Lights that add nothing are left out, but what they would be added to may be less than zero; and
/// the bits of a NaN are those of whatever operation was the last.
#[test]
fn zeros_and_nans_are_the_same() {
    let image = |color: &str, ambient: &str| {
        format!(
            "{ambient} point [ 1.0 -1.0 1.0 point 0.5 0.5 0.5 point light ]
             {{ /v /u /face {color} point 0.0 0.0 1.0 }} sphere 0.0 0.0 3.0 translate
             2 70.0 20 15 \"a.ppm\" render\n"
        )
    };
    let text = image("-1.0 -1.0 -0.0", "-1.0 0.0 -1.0")
        + &image("-1.0 -1.0 -1.0", "0.0 0.0 0.0")
        + &image("1.0 v subf 0.0 mulf 0.0 divf frac 0.0 0.0 divf negf 0.5", "0.5 0.5 0.5");
    let mut host = Comparing::default();
    run(Path::new("zeros.gml"), &text, &mut host).expect("it renders");
    assert_eq!(host.n_images, 3);
}

/// Two mirrors that face one another, in which paths have no end.
const HALL: &str = "\
{ /v /u /face 0.9 0.95 0.9 point 0.2 0.7 9.0 } /mirror
{ /v /u /face 0.9 0.4 0.2 point 0.6 0.5 9.0 } /matte
mirror plane -90.0 rotatez -2.0 0.0 0.0 translate
mirror plane 90.0 rotatez 2.0 0.0 0.0 translate union
matte sphere 0.3 0.0 5.0 translate union
mirror plane 0.0 -2.0 0.0 translate union /hall
1.0 1.5 0.0 point 0.9 0.9 0.8 point pointlight /lamp
";

/// Holds the rays of an image with and without the rest of paths against one another.
struct CountingRests {
    n_reflected: Vec<[u64; 2]>,
}

impl Host for CountingRests {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        let (view, illumination) = (view(&job), job.illumination(Dialect::Auto));
        let found = [Omissions::ALL, Omissions::ALL.without(Part::Rest)].map(|omissions| {
            let (scene, surfaces): (Scene<f64>, _) = scene(&job.object);
            let scene = scene.leaving_out(omissions);
            let shaders = Shaders::new(job.program, &surfaces, LIMITS, Tiering::Hot);
            let worker = || shaders.worker();
            let found = renderer::render(&scene, &illumination, &view, worker, &|_| {});
            found.unwrap_or_else(|_| panic!("{} is rendered", job.name))
        });
        let [(image, ending), (other, whole)]: [(Image<[u8; 3]>, RayCounts); 2] = found;
        assert!(image == other, "{}", job.name);
        self.n_reflected.push([ending.reflected, whole.reflected]);
        Ok(())
    }
}

/// In both dialects, whose bounds are different; and nothing ends where there is no bound, where a
/// surface is not constant, or where few reflections are allowed.
#[test]
fn paths_end_where_the_rest_changes_nothing() {
    let image = |lamp: &str, hall: &str, depth: u32, attn: &str| {
        format!("0.1 0.1 0.1 point [ {lamp} ] {attn} {hall} {depth} 70.0 40 30 \"a.ppm\" render\n")
    };
    let chequered = "{ /v /u /face u floor 2 modi real 1.0 1.0 point 0.5 0.5 1.0 } cube hall union";
    let glaring = "{ /v /u /face 1.0 1.0 1.0 point 0.5 2.0 1.0 } cube hall union";
    let spot = "0.0 0.0 0.0 point 0.0 0.0 1.0 point 0.1 0.1 0.1 point 60.0 -3.0 spotlight";
    let text = [
        HALL,
        &image("lamp", "hall", 200, ""),
        &image("lamp", "hall", 200, "1.0 0.0 0.0 point"),
        &image("lamp", chequered, 200, ""),
        &image("lamp", glaring, 200, ""),
        &image(spot, "hall", 200, ""),
        &image("lamp", "hall", 15, ""),
    ];
    let mut host = CountingRests { n_reflected: Vec::new() };
    run(Path::new("hall.gml"), &text.concat(), &mut host).expect("it renders");
    let [icfp, chicago, others @ ..] = &host.n_reflected[..] else { panic!("six images") };
    for [ending, whole] in [icfp, chicago] {
        assert!(ending * 5 < *whole, "{ending} of {whole}");
    }
    assert_eq!(others.len(), 4);
    assert!(others.iter().all(|[ending, whole]| ending == whole), "{others:?}");
    let mut host = Comparing::default();
    run(Path::new("hall.gml"), &text[..3].concat(), &mut host).expect("it renders");
    assert_eq!(host.n_images, 2);
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
