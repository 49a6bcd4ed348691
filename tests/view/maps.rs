//! What there is to know of all pixels of an image, asked for by clients.

use serde_json::{Value, json};

use crate::client::Server;
use crate::gmlvm::{Sandbox, ball};

/// A ball above a mirror, some of whose pixels take several rays.
const SCENE: &str = "\
{ /v /u /face u v 0.5 point 0.5 0.5 3.0 } /ground
{ /v /u /face 0.9 v u point 0.7 0.4 9.0 } /ball
0.3 0.3 0.3 point [1.0 -1.0 1.0 point 1.0 0.9 0.8 point light]
ball sphere 0.2 0.1 2.5 translate ground plane 0.0 -1.0 0.0 translate union
4 90.0 48 36 \"a.ppm\" render
";

fn of(server: &Server, map: &str) -> Vec<u8> {
    let answer = server.get(&format!("map?run=1&image=0&of={map}"));
    assert_eq!(answer.status, 200, "{map}: {answer:?}");
    assert!(answer.head.contains("application/octet-stream"), "{map}: {}", answer.head);
    answer.body
}

/// The numbers of a PFM file, the upper row first.
fn light(sandbox: &Sandbox, options: &[&str]) -> Vec<u8> {
    let line = ["run", "s.gml", "--engine", "interp", "--format", "pfm", "--output", "-", "-q"];
    let line = [&line, options].concat();
    let file = sandbox.run(&line).stdout;
    let rows = file.strip_prefix(b"PF\n48 36\n-1.0\n").expect("a PFM file");
    rows.rchunks_exact(48 * 12).flatten().copied().collect()
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    let (words, _) = bytes.as_chunks();
    words.iter().map(|word| f32::from_le_bytes(*word).into()).collect()
}

#[test]
fn maps_are_what_the_command_line_finds() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", SCENE);
    // What is certain in doubles depends on when bounded shaders are compiled; here they never are.
    let server = Server::start(&sandbox, &["s.gml", "--samples", "2", "--engine", "interp"]);
    server.events().until("ended", 1);
    let own = of(&server, "light");
    assert_eq!(own, light(&sandbox, &["--samples", "2"]));
    assert!(numbers(&of(&server, "error-f64")).iter().all(|error| *error == 0.0));
    for (map, options) in [
        ("error-dd", &["--samples", "2", "--precision", "dd"][..]),
        ("error-certified", &["--precision", "certified"]),
    ] {
        let errors = numbers(&of(&server, map));
        let (one, other) = (numbers(&own), numbers(&light(&sandbox, options)));
        assert_eq!(errors.len(), one.len());
        for ((error, a), b) in errors.iter().zip(&one).zip(&other) {
            // The files' numbers, and the error itself, are rounded to 24 bits, by half a unit each.
            let rounding = f64::from(f32::EPSILON) * (a.abs() + b.abs() + error);
            assert!((error - (a - b).abs()).abs() <= rounding, "{map}: {a} and {b}, {error}");
        }
        // The one differs in the last bits, the other has no samples.
        let largest = errors.iter().copied().fold(0.0, f64::max);
        assert!(
            largest > 0.0 && (largest > 0.01) == (map == "error-certified"),
            "{map}: {largest}"
        );
    }

    let certainty = server.get("map?run=1&image=0&of=certainty");
    assert!(certainty.head.contains("image/png"), "{}", certainty.head);
    let line = "run s.gml --engine interp --certify --mark-uncertain marks.png";
    sandbox.run(&line.split(' ').collect::<Vec<_>>());
    assert_eq!(certainty.body, sandbox.read("marks.png"));
}

#[test]
fn costs_are_those_of_the_statistics_and_of_pixels() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", SCENE);
    let server = Server::start(&sandbox, &["s.gml"]);
    server.events().until("ended", 1);
    let bytes = of(&server, "cost");
    let (words, _) = bytes.as_chunks();
    let (costs, _) = words.as_chunks();
    let costs: Vec<[u64; 2]> = costs
        .iter()
        .map(|pair: &[[u8; 4]; 2]| pair.map(|n| u32::from_le_bytes(n).into()))
        .collect();
    assert_eq!(costs.len(), 48 * 36);
    sandbox.run(&["run", "s.gml", "--stats", "stats.json"]);
    let stats: Value = serde_json::from_slice(&sandbox.read("stats.json")).expect("JSON");
    let rays = |stats: &Value| {
        let kinds = ["primary", "reflected", "shadow"];
        kinds.iter().map(|kind| stats[kind].as_u64().expect("a number")).sum::<u64>()
    };
    assert_eq!(costs.iter().map(|cost| cost[0]).sum::<u64>(), rays(&stats["rays"]));
    for (x, y) in [(0, 0), (24, 18), (20, 30), (47, 35)] {
        let pixel = server.get(&format!("pixel?run=1&image=0&x={x}&y={y}")).json();
        let expected = [rays(&pixel["rays"]), pixel["instructions"].as_u64().expect("a number")];
        assert_eq!(costs[y * 48 + x], expected, "({x}, {y})");
    }
    assert!(costs.contains(&[1, 0]) && costs.iter().any(|cost| cost[0] > 4 && cost[1] > 0));
}

#[test]
fn what_is_not_to_be_had_is_said() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    let server = Server::start(&sandbox, &["s.gml"]);
    server.events().until("ended", 1);
    for bad in ["", "run=1&image=0", "run=1&image=0&of=", "run=1&image=0&of=Light", "of=cost"] {
        assert_eq!(server.get(&format!("map?{bad}")).status, 400, "{bad}");
    }
    assert_eq!(server.get("map?run=2&image=0&of=cost").status, 204);
    let no_image = server.get("map?run=1&image=1&of=cost");
    assert_eq!(no_image.status, 200);
    assert!(no_image.json()["error"].is_string(), "{no_image:?}");
    for file in ["chart.js", "compare.js", "compare.css"] {
        assert_eq!(server.get(file).status, 200, "{file}");
    }
}

/// A surface that is known to be the same everywhere costs a run nothing; its cost in instructions is
/// found by interpreting it at each pixel.
#[test]
fn the_time_limit_holds_for_maps_too() {
    let sandbox = Sandbox::new();
    let scene = "\
{ /self /n n 0 eqi { 1.0 } { n 1 subi self self apply } if } /loop
{ /v /u /face 1.0 1.0 1.0 point 1.0 0.0 3000 loop loop apply } /slow
1.0 1.0 1.0 point [] slow plane 0.0 -1.0 0.0 translate 1 90.0 2000 1500 \"a.ppm\" render
";
    sandbox.file("s.gml", scene);
    let server = Server::start(&sandbox, &["s.gml", "--engine", "jit", "--timeout", "4"]);
    let mut events = server.events();
    assert_eq!(events.until("ended", 1)["ok"], true);
    let map = server.get("map?run=1&image=0&of=cost");
    assert!(map.json()["error"].as_str().is_some_and(|e| e.contains("time limit")), "{map:?}");
    assert_eq!(server.get("pixel?run=1&image=0&x=0&y=0").json(), json!(null));
    let next = server.run(&ball("b.ppm"));
    assert_eq!(events.until("ended", next)["ok"], true);
    assert_eq!(of_run(&server, next), 8 * 6 * 8);
}

fn of_run(server: &Server, run: u64) -> usize {
    server.get(&format!("map?run={run}&image=0&of=cost")).body.len()
}
