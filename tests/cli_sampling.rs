//! `run --samples` and `--adaptive` from the command line.

use serde_json::Value;

use crate::gmlvm::{Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// A wall whose left half is bright, in one pixel; what the right half shows is up to the test.
fn halves(right: &str) -> String {
    format!(
        "{{ /v /u /face u 0.5 lessf {{ 4.0 }} {{ {right} }} if /c c c c point 1.0 0.0 1.0 }} cube
         -0.5 -0.5 0.0 translate 4.0 uscale /wall
         1.0 1.0 1.0 point [] wall 0 90.0 1 1 \"a.ppm\" render"
    )
}

/// Runs a scene with options, and returns its statistics.
fn run(sandbox: &Sandbox, text: &str, options: &[&str]) -> Value {
    sandbox.file("s.gml", text);
    let ended = sandbox.run(&[&["s.gml", "--stats", "s.json"], options].concat());
    assert_eq!(ended.code, 0, "{options:?}: {}", ended.stderr);
    serde_json::from_slice(&sandbox.read("s.json")).expect("JSON")
}

#[test]
fn methods_and_their_rays_are_in_the_statistics() {
    let sandbox = Sandbox::new();
    let cases: [(&[&str], &str, u64); 5] = [
        (&[], "centre", 1),
        (&["--samples", "1"], "centre", 1),
        (&["--samples", "6", "--precision", "dd"], "grid 6", 36),
        // The corners, and the points of each level that squares in the left of the middle need.
        (&["--adaptive=1"], "adaptive 1", 4 + 5),
        (&["--adaptive", "--precision", "dd"], "adaptive 3", 4 + 5 + 9 + 17),
    ];
    for (options, method, n_rays) in cases {
        let stats = run(&sandbox, &halves("0.0"), options);
        assert_eq!(stats["sampling"], method);
        assert_eq!(stats["rays"]["primary"], n_rays, "{method}");
    }
}

#[test]
fn one_sample_changes_no_byte() {
    let sandbox = Sandbox::new();
    run(&sandbox, &ball("a.ppm"), &[]);
    let plain = sandbox.read("a.ppm");
    run(&sandbox, &ball("a.ppm"), &["--samples", "1"]);
    assert_eq!(sandbox.read("a.ppm"), plain);
    run(&sandbox, &ball("a.ppm"), &["--adaptive"]);
    assert_ne!(sandbox.read("a.ppm"), plain);
}

#[test]
fn bytes_are_made_of_clamped_samples_and_pfm_of_light() {
    let sandbox = Sandbox::new();
    run(&sandbox, &halves("0.0"), &["--samples", "2"]);
    assert!(sandbox.read("a.ppm").ends_with(b"\n255\n\x7f\x7f\x7f"));
    run(&sandbox, &halves("0.0"), &["--samples", "2", "--format", "pfm"]);
    let half_of_four = 2.0f32.to_le_bytes().repeat(3);
    assert!(sandbox.read("a.pfm").ends_with(&half_of_four));
}

#[test]
fn what_fails_at_any_sample_fails_at_its_pixel() {
    let sandbox = Sandbox::new();
    // The centre is on the right.
    run(&sandbox, &halves("0.0").replace("{ 4.0 }", "{ -1.0 sqrt }"), &[]);
    for options in [["--samples", "2"], ["--adaptive=1", "-q"]] {
        for engine in ["interp", "jit"] {
            let ended = sandbox.run(&[&["s.gml", "--engine", engine], &options[..]].concat());
            assert_eq!(ended.code, 1, "{options:?}");
            assert!(ended.stderr.contains("first met at pixel (0, 0)"), "{}", ended.stderr);
        }
    }
}

#[test]
fn contradictions_and_numbers_out_of_range_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    let cases: [(&[&str], &str); 8] = [
        (&["--samples", "2", "--adaptive"], "cannot be used with"),
        (&["--samples", "1", "--certify"], "cannot be used with"),
        (&["--adaptive", "--certify"], "cannot be used with"),
        (&["--samples", "2", "--precision", "certified"], "one sample at the centre"),
        (&["--adaptive=2", "--precision", "certified"], "one sample at the centre"),
        (&["--samples", "0"], "0 is not in 1..=64"),
        (&["--samples", "65"], "65 is not in 1..=64"),
        (&["--adaptive=7"], "7 is not in 1..=6"),
    ];
    for (options, message) in cases {
        let ended = sandbox.run(&[&["s.gml"], options].concat());
        assert_eq!(ended.code, 2, "{options:?}");
        assert!(ended.stderr.contains(message), "{options:?}: {}", ended.stderr);
    }
    assert_eq!(sandbox.files(), ["s.gml"]);
}
