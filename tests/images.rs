//! Golden images: `tests/golden/*.gml`, one feature each, beside the PNGs of what they render; and
//! pixels that the reference gives in numbers.
//!
//! `GMLVM_BLESS=1` writes the PNGs anew. On a mismatch what was rendered is written to the folder
//! for temporary files of the build, and the message says where.

use std::path::{Path, PathBuf};

use support::png::{read_png, write_png};
use support::scenes::{Rendered, render_file, render_text};

mod support {
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod png;
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod scenes;
}

/// Compares an image with its golden file byte by byte: the bits are the same on every target.
fn check_golden(rendered: &Rendered, golden: &Path) -> Result<(), String> {
    if std::env::var_os("GMLVM_BLESS").is_some() {
        write_png(golden, &rendered.image);
        return Ok(());
    }
    let expected = read_png(golden).ok_or_else(|| format!("there is no {}", golden.display()))?;
    if expected == rendered.image {
        return Ok(());
    }
    let found = Path::new(env!("CARGO_TARGET_TMPDIR")).join(golden.file_name().expect("a name"));
    write_png(&found, &rendered.image);
    let n_off = expected.pixels.iter().zip(&rendered.image.pixels).filter(|(a, b)| a != b).count();
    Err(format!("{}: {n_off} pixels differ, see {}", golden.display(), found.display()))
}

#[test]
fn images_are_as_they_were() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(&folder)
        .expect("a folder")
        .map(|entry| entry.expect("readable").path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "gml"));
    paths.sort();
    assert!(paths.len() >= 11, "only {} scenes", paths.len());
    let mut failures = Vec::new();
    for path in paths {
        let images =
            render_file(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        for rendered in images {
            let golden = folder.join(&rendered.name).with_extension("png");
            failures.extend(check_golden(&rendered, &golden).err());
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// The only image of a program.
#[track_caller]
fn render(program: &str) -> Rendered {
    let mut images = render_text(Path::new("micro.gml"), program).expect("a fine program");
    assert_eq!(images.len(), 1);
    images.remove(0)
}

#[track_caller]
fn check_pixels(rendered: &Rendered, pixels: &[((u32, u32), [u8; 3])]) {
    for &((column, row), expected) in pixels {
        let found = rendered.image.pixels[(row * rendered.image.width + column) as usize];
        assert_eq!(found, expected, "pixel ({column}, {row})");
    }
}

/// Reference, section 10, scene A.
#[test]
fn a_lit_sphere() {
    let program = r#"
        { /v /u /face 0.8 0.6 0.4 point 0.7 0.3 8.0 } sphere 0.0 0.0 3.0 translate /s
        1.0 -1.0 1.0 point 0.9 0.9 0.9 point light /l
        0.2 0.2 0.2 point [ l ] s 0 60.0 9 9 "a.ppm" render"#;
    let pixels = [
        ((4, 4), [124, 93, 62]),
        ((3, 3), [194, 145, 97]),
        ((5, 5), [28, 21, 14]),
        ((2, 4), [124, 93, 62]),
        ((4, 2), [124, 93, 62]),
    ];
    check_pixels(&render(program), &pixels);
}

/// Scene B: texture, faces and rotations.
#[test]
fn a_turned_cylinder() {
    let program = r#"
        { /v /u /face
          face 0 eqi { u v 0.0 point } { face 1 eqi { 1.0 0.0 1.0 point } { 0.0 1.0 1.0 point } if } if
          1.0 0.0 1.0
        } cylinder 0.0 -0.5 0.0 translate 30.0 rotatey 40.0 rotatex 0.0 0.0 2.5 translate /s
        1.0 1.0 1.0 point [] s 0 60.0 9 9 "b.ppm" render"#;
    let bottom = [0, 255, 255];
    let pixels = [
        ((4, 4), bottom),
        ((2, 4), bottom),
        ((6, 4), bottom),
        ((4, 6), bottom),
        ((4, 2), [106, 152, 0]),
        ((3, 3), [119, 33, 0]),
    ];
    check_pixels(&render(program), &pixels);
}

/// Scene C: a spotlight with each kind of attenuation.
#[test]
fn a_spotlight_on_a_plane() {
    let scene = |attenuation: &str| {
        format!(
            r#"{{ /v /u /face 1.0 1.0 1.0 point 1.0 0.0 1.0 }} plane 0.0 -1.0 0.0 translate /ground
            0.0 3.0 4.0 point 0.0 -1.0 4.0 point 1.0 0.5 0.25 point 30.0 2.0 spotlight /spot
            0.0 0.0 0.0 point [ spot ] {attenuation} ground 0 90.0 11 11 "c.ppm" render"#
        )
    };
    let at = [(5, 6), (5, 7), (4, 6), (6, 7), (5, 9)];
    let cases = [
        ("", [[216, 108, 54], [140, 70, 35], [195, 97, 48], [137, 68, 34], [0, 0, 0]]),
        (
            "1.0 0.0 0.0 point",
            [[249, 124, 62], [168, 84, 42], [227, 113, 56], [165, 82, 41], [0, 0, 0]],
        ),
        (
            "1.0 0.1 0.05 point",
            [[112, 56, 28], [67, 33, 16], [100, 50, 25], [65, 32, 16], [0, 0, 0]],
        ),
    ];
    for (attenuation, expected) in cases {
        let pixels: Vec<_> = at.into_iter().zip(expected).collect();
        check_pixels(&render(&scene(attenuation)), &pixels);
    }
}

/// Scene D: two mirrors, by depth, in both dialects.
#[test]
fn facing_mirrors() {
    let scene = |attenuation: &str, depth: u32| {
        format!(
            r#"{{ /v /u /face 0.5 0.5 1.0 point 0.2 0.8 1.0 }} plane -90.0 rotatex 0.0 0.0 4.0 translate
            {{ /v /u /face 1.0 0.5 0.5 point 0.2 0.8 1.0 }} plane 90.0 rotatex 0.0 0.0 -4.0 translate
            union /mirrors
            1.0 1.0 1.0 point [] {attenuation} mirrors {depth} 60.0 3 3 "d.ppm" render"#
        )
    };
    let icfp = [[25, 25, 51], [45, 35, 71], [54, 39, 87], [60, 41, 94]];
    for (depth, expected) in icfp.into_iter().enumerate() {
        check_pixels(&render(&scene("", depth as u32)), &[((1, 1), expected)]);
    }
    let chicago = [[25, 25, 51], [25, 25, 51], [66, 45, 71], [82, 62, 104], [108, 75, 117]];
    for (depth, expected) in chicago.into_iter().enumerate() {
        check_pixels(&render(&scene("1.0 0.0 0.0 point", depth as u32)), &[((1, 1), expected)]);
    }
}

/// Scene E: a cavity that is green, and in its own shadow.
#[test]
fn a_cube_less_a_sphere() {
    let program = r#"
        { /b /g /r { /v /u /face r g b point 1.0 0.0 1.0 } } /matte
        1.0 0.0 0.0 matte apply cube -0.5 -0.5 -0.5 translate 2.0 uscale
        0.0 1.0 0.0 matte apply sphere 0.8 uscale 0.0 0.0 -1.0 translate
        difference 20.0 rotatey 0.0 0.0 3.0 translate /s
        0.0 0.0 1.0 point 0.7 0.7 0.7 point light /l
        0.3 0.3 0.3 point [ l ] s 0 60.0 9 9 "e.ppm" render"#;
    let pixels = [
        ((4, 4), [0, 237, 0]),
        ((3, 4), [0, 251, 0]),
        ((5, 4), [0, 76, 0]),
        ((2, 4), [0, 198, 0]),
        ((6, 4), [137, 0, 0]),
        ((4, 2), [244, 0, 0]),
        ((2, 2), [244, 0, 0]),
    ];
    check_pixels(&render(program), &pixels);
}
