//! `run --frames`: a scene for each frame of an animation.

use crate::gmlvm::{Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// As bright as the clock says.
fn scene(name: &str) -> String {
    ball(name).replace("0.5 0.5 0.5 point", "clock clock clock point")
}

#[test]
fn frames_are_runs_with_frame_and_clock() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", scene("d/a.ppm") + &scene("b"));
    let ended = sandbox.run(&["s.gml", "--frames", "9..11", "-o", "out", "--stats", "stats"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    for (frame, clock) in [("0009", "0.0"), ("0010", "0.5"), ("0011", "1.0")] {
        let clock = format!("clock={clock}");
        assert_eq!(sandbox.run(&["s.gml", "-D", &clock, "-o", "one"]).code, 0);
        for (made, single) in
            [(format!("out/d/a-{frame}.ppm"), "one/d/a.ppm"), (format!("out/b-{frame}"), "one/b")]
        {
            assert_eq!(sandbox.read(&made), sandbox.read(single), "{made}");
        }
    }
    let stats = String::from_utf8(sandbox.read("stats")).expect("text");
    assert!(stats.contains("\"images\": 6,"), "{stats}");
    // The numbers in a name are the frame's.
    let args = ["s.gml", "--frames", "9..10", "--output", "n/{frame}-{n}.png"];
    assert_eq!(sandbox.run(&args).code, 0);
    let made: Vec<_> = sandbox.files().into_iter().filter(|f| f.starts_with("n/0")).collect();
    assert_eq!(made, ["n/0009-1.png", "n/0009-2.png", "n/0010-3.png", "n/0010-4.png"]);
    sandbox.file("f.gml", "frame 10 eqi { } { x } if\n".to_owned() + &scene("f.ppm"));
    assert_eq!(sandbox.run(&["f.gml", "--frames", "10..10"]).code, 0);
    assert_eq!(sandbox.run(&["f.gml", "--frames", "10..11"]).code, 1);
}

/// Shards have whole frames, with the clock of the whole range.
#[test]
fn frames_are_shared_out() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", scene("a.ppm"));
    assert_eq!(sandbox.run(&["s.gml", "--frames", "1..7", "-o", "single"]).code, 0);
    for shard in ["1/3", "2/3", "3/3"] {
        let ended = sandbox.run(&["s.gml", "--frames", "1..7", "--shard", shard, "-o", "out"]);
        assert!(
            ended.code == 0 && (2..=3).contains(&ended.stderr.lines().count()),
            "{}",
            ended.stderr
        );
    }
    for frame in 1..=7 {
        let [made, single] =
            ["out", "single"].map(|d| sandbox.read(&format!("{d}/a-{frame:04}.ppm")));
        assert_eq!(made, single);
    }
    // So is the limit for images that of the whole run.
    let ended = sandbox.run(&["s.gml", "--frames", "1..7", "-o", "few", "--max-images", "3"]);
    assert_eq!(ended.code, 4, "{}", ended.stderr);
}

#[test]
fn frames_that_make_no_sense() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", scene("a.ppm"));
    for options in [
        &["--frames", "2..1"][..],
        &["--frames", "x"],
        &["--frames", "1..2", "--output", "a.ppm"],
        &["--frames", "1..2", "--output", "-"],
        &["--frames", "1..2", "--certify", "--mark-uncertain", "m.png"],
        &["--frames", "1..2", "--shard", "1/2", "--output", "{n}.ppm"],
        &["--frames", "1..2", "--parts", "p"],
        &["--output", "{frame}.ppm"],
        &["--shard", "1/2"],
    ] {
        let ended = sandbox.run(&[&["run", "s.gml"], options].concat());
        assert_eq!(ended.code, 2, "{options:?}: {}", ended.stderr);
    }
    assert_eq!(sandbox.run(&["-", "--frames", "1..2"]).code, 2);
    for name in ["", "d/", "../a", ".."] {
        let ended = sandbox.file("s.gml", scene(name)).run(&["s.gml", "--frames", "1..2"]);
        assert_eq!(ended.code, 5, "{name}: {}", ended.stderr);
    }
    assert_eq!(sandbox.files(), ["s.gml"]);
}
