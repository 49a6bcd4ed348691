//! Images against a second tracer: the formulas of textbooks at 256 bits, without acceleration and
//! with no code of the first.
//!
//! What both share is the program that describes the scene, and the surface functions, which are
//! given coordinates rounded to doubles. `GMLVM_REFERENCE=96 cargo test --release --test reference --
//! --nocapture` traces all scenes with so many pixels on the longer side, and tells how many differ in
//! either precision, how many are certain, and how many of those that are not.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use compiler::diagnostic::Diagnostic;
use compiler::source::SourceMap;
use jit::shaders::{Shaders, Tiering};
use rayon::prelude::*;
use renderer::camera::View;
use renderer::certify::{CertainScene, Certainty, certify};
use renderer::numeric::dd::Dd;
use renderer::numeric::real::Real;
use vm::host::{Dialect, Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;
use vm::surfaces::{self, InterpSurfaces};

use beside::Beside;
use number::Map;
use shade::{Reference, Scenery};
use solid::Solid;

#[path = "../support/beside.rs"]
mod beside;
mod number;
mod shade;
mod solid;

const LIMITS: Limits = Limits { fuel: 1_000_000_000, max_depth: 100_000, max_memory: 1 << 30 };

type Bytes = Vec<[u8; 3]>;

/// Traces each image four times, and tells which pixels differ from the reference.
#[derive(Default)]
struct Compares {
    n_pixels: usize,
    in_f64: Vec<String>,
    in_dd: Vec<String>,
    certified: Vec<String>,
    /// Pixels that are said to be certain, by bounds in doubles and in double-double, and differ.
    unsound: Vec<String>,
    certain_in_f64: usize,
    certain_in_dd: usize,
}

impl Host for Compares {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        let (_, surfaces) = surfaces::scene::<f64>(&job.object);
        let number = |closure: &Arc<_>| {
            let index = surfaces.iter().position(|surface| Arc::ptr_eq(surface, closure));
            index.expect("all are listed") as u32
        };
        let solid = Solid::new(&job.object, &Map::identity(), &number);
        let illumination = job.illumination(Dialect::Auto);
        let side = side(solid.n_shapes(), illumination.max_bounces);
        let (width, height) = scaled(job.width, job.height, side);
        let view = View::whole(width, height, job.fov_deg);
        let scenery = Scenery::new(solid, illumination, view);
        let row = |row: u32| {
            let surfaces = InterpSurfaces::new(job.program, &surfaces, LIMITS);
            let mut reference = Reference::new(&scenery, surfaces);
            (0..width).map(|column| reference.pixel(column, row)).collect::<Result<Bytes, _>>()
        };
        let rows: Vec<Bytes> = (0..height).into_par_iter().map(row).collect::<Result<_, _>>()?;
        let expected = rows.concat();
        self.n_pixels += expected.len();
        self.in_f64.extend(differences(width, &traced::<f64>(&job, &view)?, &expected));
        self.in_dd.extend(differences(width, &traced::<Dd>(&job, &view)?, &expected));
        let (pixels, certainties) = certified(&job, &view)?;
        self.certified.extend(differences(width, &pixels, &expected));
        let is_certain = |c: &Certainty| !matches!(c, Certainty::Rule(_));
        // As if what is not certain were right.
        let believed: Bytes = (certainties.iter().zip(pixels.iter().zip(&expected)))
            .map(
                |(certainty, (found, expected))| {
                    *if is_certain(certainty) { found } else { expected }
                },
            )
            .collect();
        self.unsound.extend(differences(width, &believed, &expected));
        let count = |kind| certainties.iter().filter(|certainty| **certainty == kind).count();
        self.certain_in_f64 += count(Certainty::Double);
        self.certain_in_dd += count(Certainty::DoubleDouble);
        Ok(())
    }
}

/// Pixels on the longer side: few, for the sake of those who wait, where there is much to compute.
fn side(n_shapes: usize, max_bounces: u32) -> u32 {
    let asked = std::env::var("GMLVM_REFERENCE").ok();
    if let Some(side) = asked.and_then(|side| side.parse().ok()) {
        return side;
    }
    match (n_shapes, max_bounces) {
        (_, 100..) => 5,
        (200.., _) => 8,
        (20.., _) => 16,
        _ => 24,
    }
}

/// The size with so many pixels on the longer side, odd where it was: a scene may have been made to
/// show something at the centre of a pixel.
fn scaled(width: u32, height: u32, side: u32) -> (u32, u32) {
    let longest = width.max(height);
    if longest <= side {
        return (width, height);
    }
    let shrunk = |size: u32| (size * side / longest).max(1);
    let like = |small: u32, size: u32| small - (small % 2) + size % 2;
    (like(shrunk(width), width).max(1), like(shrunk(height), height).max(1))
}

fn traced<R: Real>(job: &RenderJob<'_>, view: &View) -> Result<Bytes, Box<Diagnostic>> {
    let (scene, surfaces) = surfaces::scene::<R>(&job.object);
    let illumination = job.illumination(Dialect::Auto);
    let worker = || InterpSurfaces::new(job.program, &surfaces, LIMITS);
    let result = renderer::render(&scene, &illumination, view, worker, &|_| {});
    let (image, _) = result.map_err(|failure| Box::new(failure.error.into_diagnostic()))?;
    Ok(image.pixels)
}

/// With bounded shaders, without which doubles can certify no texture.
fn certified(job: &RenderJob<'_>, view: &View) -> Result<(Bytes, Vec<Certainty>), Box<Diagnostic>> {
    let (exact, _) = surfaces::scene(&job.object);
    let (double, _) = surfaces::scene(&job.object);
    let (rough, surfaces) = surfaces::scene(&job.object);
    let scene = CertainScene::new(rough, double, exact);
    let shaders = Shaders::new(job.program, &surfaces, LIMITS, Tiering::Eager);
    let illumination = job.illumination(Dialect::Auto);
    let result = certify(&scene, &illumination, view, || shaders.worker(), &|_| {});
    let (image, certainties, _) =
        result.map_err(|failure| Box::new(failure.error.into_diagnostic()))?;
    Ok((image.pixels, certainties))
}

fn differences(width: u32, found: &[[u8; 3]], expected: &[[u8; 3]]) -> Vec<String> {
    let pixels = (0..).zip(found.iter().zip(expected));
    let differ = pixels.filter(|(_, (found, expected))| found != expected);
    let told = |(index, (found, expected)): (u32, (&[u8; 3], &[u8; 3]))| {
        format!("({}, {}) is {found:?}, not {expected:?}", index % width, index / width)
    };
    differ.map(told).collect()
}

/// Compares the images of a scene; none if the program is wrong.
fn compare(path: &Path) -> Option<Compares> {
    let mut sources = SourceMap::default();
    let text = std::fs::read(path).expect("a scene");
    let file = sources.add(&path.display().to_string(), text).expect("a small file");
    let bytecode = compiler::compile(&mut sources, file, &mut Beside, &[]).ok()?;
    let program = Arc::new(LoadedProgram::new(bytecode));
    let mut images = Compares::default();
    Machine::new(&program, LIMITS).run(&mut images).ok()?;
    Some(images)
}

/// The scenes of a folder.
fn scenes(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let paths = entries.map(|entry| entry.expect("a file").path());
    let mut scenes: Vec<PathBuf> =
        paths.filter(|path| path.extension().is_some_and(|extension| extension == "gml")).collect();
    scenes.sort();
    scenes
}

/// All scenes of a folder are in double-double, and certified, what they are in the reference; in
/// doubles all but those in which a surface function meets a whole number exactly.
#[track_caller]
fn check(folder: &str, wrong: &[&str], with_ties: &[&str]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    if !folder.is_dir() {
        println!("skipped: there is no {}", folder.display());
        return;
    }
    let (mut in_f64, mut in_dd, mut certified) = (Vec::new(), Vec::new(), Vec::new());
    let mut unsound = Vec::new();
    for path in scenes(&folder) {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let start = Instant::now();
        let Some(images) = compare(&path) else {
            assert!(wrong.contains(&&*name), "{name} stops with an error");
            continue;
        };
        println!(
            "{name}: of {} pixels {} differ in f64, {} in dd, {} certified; {} are certain in f64, \
             {} in dd, {} of them differ ({:.2} s)",
            images.n_pixels,
            images.in_f64.len(),
            images.in_dd.len(),
            images.certified.len(),
            images.certain_in_f64,
            images.certain_in_dd,
            images.unsound.len(),
            start.elapsed().as_secs_f64()
        );
        let first = |pixels: &[String]| pixels.first().map(|first| format!("{name}: {first}"));
        in_dd.extend(first(&images.in_dd));
        certified.extend(first(&images.certified));
        unsound.extend(first(&images.unsound));
        if !with_ties.contains(&&*name) {
            in_f64.extend(first(&images.in_f64));
        }
    }
    assert!(unsound.is_empty(), "scenes with pixels that are certain, but wrong: {unsound:#?}");
    assert!(certified.is_empty(), "scenes that differ when certified: {certified:#?}");
    assert!(in_dd.is_empty(), "scenes that differ in double-double: {in_dd:#?}");
    assert!(in_f64.is_empty(), "scenes that differ in doubles: {in_f64:#?}");
}

#[test]
fn our_scenes() {
    check("scenes", &[], &[]);
}

#[test]
fn scenes_made_to_break_tracers() {
    let with_ties = ["t06b_grazing_plane", "t06o_plane_fov1", "t44_zoo"];
    check("../shared/stability", &["t36_zero_scale"], &with_ties);
}

#[test]
fn scenes_of_the_course() {
    check("../shared/scenes/chicago", &[], &["golf", "test-plane"]);
}

#[test]
fn scenes_of_the_contest() {
    check("../shared/scenes/contest", &[], &["golf"]);
}
