//! `run --certify`: how pixels are known, as a line, as statistics and as a picture.

use serde_json::Value;

use crate::gmlvm::{Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;
#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/png.rs"]
mod png;

/// A cube with an edge toward the eye, in the middle of a picture with an odd number of columns: there
/// the rays meet two faces at once.
const EDGE: &str = "\
{ /v /u /face 1.0 face real 5.0 divf subf 0.5 0.5 point 1.0 0.0 1.0 } cube
-0.5 -0.5 -0.5 translate 45.0 rotatey 0.0 0.0 2.0 translate /scene
1.0 1.0 1.0 point [] scene 1 60.0 33 33 \"edge.ppm\" render
";

/// A plane whose chequers meet at the centres of the middle column, where doubles may not know the
/// coordinate for sure.
const TILES: &str = "\
{ /v /u /face u 3.0 mulf floor v floor addi 2 modi 0 eqi { 1.0 1.0 1.0 point } { 0.1 0.1 0.1 point } if
  1.0 0.0 1.0 } plane 0.3 0.7 0.0 translate 10.0 rotatez -10.0 rotatez 0.0 -1.4 0.0 translate /scene
1.0 1.0 1.0 point [] scene 1 60.0 33 33 \"tiles.ppm\" render
";

/// Runs a scene with `--certify` and returns the line about certainty and its statistics.
fn certify(sandbox: &Sandbox, text: &str, more: &[&str]) -> (String, Value) {
    sandbox.file("s.gml", text);
    let args = [&["s.gml", "--certify", "--engine", "jit", "--stats", "s.json"], more].concat();
    let ended = sandbox.run(&args);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let stats: Value = serde_json::from_slice(&sandbox.read("s.json")).expect("JSON");
    let line = ended.stderr.lines().find(|line| line.contains("pixels are certain"));
    (line.expect("a line").trim().to_owned(), stats["images"][0]["certainty"].clone())
}

fn number(value: &Value) -> u64 {
    value.as_u64().expect("a number")
}

#[test]
fn a_ball_is_certain_in_doubles() {
    let sandbox = Sandbox::new();
    let (line, certainty) = certify(&sandbox, &ball("a.ppm"), &[]);
    let n_pixels = number(&certainty["f64"]);
    assert!(n_pixels > 0);
    assert_eq!(
        line,
        format!("{n_pixels} of {n_pixels} pixels are certain, {n_pixels} of them in doubles")
    );
    let certified = sandbox.read("a.ppm");
    assert_eq!(sandbox.run(&["s.gml"]).code, 0);
    assert_eq!(certified, sandbox.read("a.ppm"), "certainty changes no pixel");
    assert_eq!(sandbox.run(&["s.gml", "--stats", "s.json"]).code, 0);
    let stats: Value = serde_json::from_slice(&sandbox.read("s.json")).expect("JSON");
    assert!(stats["images"][0].get("certainty").is_none(), "it was not asked for");
}

#[test]
fn an_edge_is_decided_by_the_rules_and_marked() {
    let sandbox = Sandbox::new();
    let marks = ["--mark-uncertain", "{name}-marks.png"];
    let (line, certainty) = certify(&sandbox, EDGE, &marks);
    let by_rules = number(&certainty["rules"]["boundary"]);
    assert!((1..=33).contains(&by_rules), "{certainty}");
    assert_eq!(number(&certainty["f64"]) + number(&certainty["dd"]) + by_rules, 33 * 33);
    assert!(
        line.ends_with(&format!("; {by_rules} by the rules for ties (boundary {by_rules})")),
        "{line}"
    );
    let marks = png::read_png(&sandbox.path("edge-marks.png")).expect("marks");
    assert_eq!((marks.width, marks.height), (33, 33));
    let marked: Vec<usize> = (0..33 * 33).filter(|&at| marks.pixels[at] == [213, 94, 0]).collect();
    assert_eq!(marked.len() as u64, by_rules);
    assert!(marked.iter().all(|at| at % 33 == 16), "only the middle column is in doubt");
}

#[test]
fn what_doubles_leave_open_twice_their_digits_decide() {
    let sandbox = Sandbox::new();
    let (_, certainty) = certify(&sandbox, TILES, &[]);
    assert!(number(&certainty["dd"]) > 0, "{certainty}");
    let certified = sandbox.read("tiles.ppm");
    assert_eq!(sandbox.run(&["s.gml", "--precision", "dd"]).code, 0);
    assert_eq!(certified, sandbox.read("tiles.ppm"));
}

#[test]
fn engines_and_threads_certify_the_same_image() {
    let sandbox = Sandbox::new();
    sandbox.file("edge.gml", EDGE).file("tiles.gml", TILES);
    let image = |name: &str, more: &[&str]| {
        let scene = format!("{name}.gml");
        let args = [&[&*scene, "--certify"], more].concat();
        assert_eq!(sandbox.run(&args).code, 0);
        sandbox.read(&format!("{name}.ppm"))
    };
    for name in ["edge", "tiles"] {
        let expected = image(name, &["--engine", "jit", "-j", "1"]);
        for engine in ["interp", "auto", "jit"] {
            assert_eq!(image(name, &["--engine", engine, "-j", "2"]), expected, "{name} {engine}");
        }
    }
}

/// Both ways to ask for certainty are as good for marks.
#[test]
fn a_precision_is_enough_for_marks() {
    let marks = [&["--certify"][..], &["--precision", "certified"]].map(|asked| {
        let sandbox = Sandbox::new();
        sandbox.file("s.gml", EDGE);
        let ended = sandbox.run(&[&["s.gml", "--mark-uncertain", "m.png"], asked].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        sandbox.read("m.png")
    });
    assert!(marks[0] == marks[1]);
}

#[test]
fn contradictory_options_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    for (args, words) in [
        (&["--certify", "--precision", "dd"][..], "cannot be used with"),
        (&["--mark-uncertain", "m.png"], "'--certify' or '--precision certified'"),
        (&["--mark-uncertain", "m.png", "--precision", "dd"], "'--precision certified'"),
        (&["--certify", "--mark-uncertain", "m.ppm"], "must end in .png"),
        (&["--certify", "--mark-uncertain", "{x}.png"], "placeholders are {name} and {n}"),
    ] {
        let ended = sandbox.run(&[&["s.gml"], args].concat());
        assert_eq!(ended.code, 2, "{args:?}");
        assert!(ended.stderr.contains(words), "{args:?}: {}", ended.stderr);
    }
    assert_eq!(sandbox.files(), ["s.gml"], "nothing was written");
}
