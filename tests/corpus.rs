//! Scenes of the ICFP contest and of the Chicago course, which none of us wrote, against images of
//! an independent implementation. They lie beside the checkout and are skipped where absent.

use std::path::Path;

use support::png::read_png;
use support::scenes::{Rendered, render_file, shared};

mod support {
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod png;
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod scenes;
}

/// Of an image, at most one pixel in a thousand may be off by more than a level, except where the
/// scene itself turns on the last bit of a texture coordinate.
fn allowed_share(folder: &str, scene: &str) -> f64 {
    match (folder, scene) {
        // The grass takes floor(3000 u v).
        (_, "golf") => 0.015,
        // The edges of the checkers meet pixel centres along the diagonal.
        ("chicago", "test-plane") => 0.003,
        _ => 0.001,
    }
}

/// The share of pixels of which a channel is off by more than one level.
fn share_off(rendered: &Rendered, expected: &[[u8; 3]]) -> f64 {
    let is_off = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1);
    let n_off = rendered.image.pixels.iter().zip(expected).filter(|&pair| is_off(pair)).count();
    n_off as f64 / expected.len() as f64
}

#[track_caller]
fn check_folder(folder: &str, n_images: usize) {
    let Some(scenes) = shared("scenes").map(|path| path.join(folder)) else { return };
    let mut paths: Vec<_> = std::fs::read_dir(&scenes)
        .expect("a folder")
        .map(|e| e.expect("readable").path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "gml"));
    paths.sort();
    let mut compared = 0;
    for path in paths {
        let scene = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let images =
            render_file(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        for rendered in images {
            let base = Path::new(&rendered.name).with_extension("png");
            let expected = scenes.join("expected").join(base.file_name().expect("a name"));
            let golden = read_png(&expected).unwrap_or_else(|| panic!("no {}", expected.display()));
            assert_eq!(
                (rendered.image.width, rendered.image.height),
                (golden.width, golden.height),
                "{}",
                rendered.name
            );
            let share = share_off(&rendered, &golden.pixels);
            println!(
                "{folder}/{scene} {}: {:.4} % off by more than a level",
                rendered.name,
                100.0 * share
            );
            assert!(
                share <= allowed_share(folder, &scene),
                "{folder}/{scene} {}: {share}",
                rendered.name
            );
            compared += 1;
        }
    }
    assert_eq!(compared, n_images);
}

#[test]
fn scenes_of_the_contest() {
    check_folder("contest", 36);
}

#[test]
fn scenes_of_the_course() {
    check_folder("chicago", 5);
}
