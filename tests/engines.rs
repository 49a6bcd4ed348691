//! Interpreter and native shaders give the same images, byte for byte.

use std::path::{Path, PathBuf};

use jit::shaders::{Evaluation, SurfaceReport};
use support::scenes::{Engine, render_by, shared};

mod support {
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod scenes;
}

fn gml_files(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("readable").path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "gml"));
    paths.sort();
    assert!(!paths.is_empty(), "{}", folder.display());
    paths
}

/// Renders a scene by both engines; returns how the surfaces were evaluated.
fn compare(path: &Path) -> Vec<SurfaceReport> {
    let text = String::from_utf8_lossy(&std::fs::read(path).expect("readable")).into_owned();
    let interpreted = render_by(Engine::Interpreter, path, &text);
    let native = render_by(Engine::Native, path, &text);
    let (interpreted, (native, reports)) = match (interpreted, native) {
        (Ok((interpreted, _)), Ok(native)) => (interpreted, native),
        (Err(a), Err(b)) => {
            assert_eq!(a, b, "{}", path.display());
            return Vec::new();
        }
        (a, b) => panic!("{}: {:?} but {:?}", path.display(), a.err(), b.err()),
    };
    assert_eq!(interpreted.len(), native.len());
    for (a, b) in interpreted.iter().zip(&native) {
        assert!(a.image == b.image, "{} {}: images differ", path.display(), a.name);
        assert_eq!(a.counts, b.counts, "{}", path.display());
    }
    reports
}

/// Compares all scenes of a folder, and prints how many surfaces were declined and why.
fn compare_folder(folder: &Path) {
    let (mut n_surfaces, mut n_declined) = (0, 0);
    for path in gml_files(folder) {
        for report in compare(&path) {
            n_surfaces += 1;
            if let Evaluation::Declined(unsupported) = report.evaluation {
                n_declined += 1;
                println!("{}: {}", path.display(), unsupported.reason);
            }
        }
    }
    println!("{}: {n_surfaces} surfaces, {n_declined} declined", folder.display());
    assert!(n_declined * 20 <= n_surfaces, "more than 5 % of the surfaces stay interpreted");
}

#[test]
fn our_scenes_are_the_same() {
    compare_folder(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"));
}

#[test]
fn golden_scenes_are_the_same() {
    compare_folder(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden"));
}

#[test]
fn shared_scenes_are_the_same() {
    for folder in ["contest", "chicago"] {
        if let Some(scenes) = shared("scenes") {
            compare_folder(&scenes.join(folder));
        }
    }
    if let Some(folder) = shared("stability") {
        compare_folder(&folder);
    }
}
