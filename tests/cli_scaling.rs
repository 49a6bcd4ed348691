//! `gmlvm chart --scaling`: what it prints, draws, exports, reads again and refuses. No test depends on
//! how long anything takes.

use serde_json::Value;

use crate::chart::{
    assert_drawn_from_data, assert_refused, chart, charted, json, list, number, texts,
};
use crate::gmlvm::Sandbox;

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/chart.rs"]
mod chart;

const COMMON: &[&str] = &["--runs", "2", "--warmup", "0", "--size", "16x12"];

const SERIES: [&str; 4] = ["spheres", "holes", "reflections", "lights"];

#[test]
fn series_become_tables_data_and_a_drawing() {
    let sandbox = Sandbox::new();
    let args = ["--scaling", "--up-to", "10", "-o", "o/c.svg", "--export", "o/c.json"];
    let table = charted(&sandbox, &args);
    for (name, to) in SERIES.iter().zip([10, 10, 10, 8]) {
        assert!(table.contains(&format!("\n{name} ")), "{table}");
        assert!(table.contains(&format!("\n  from 1 to {to} {name}: ")), "{table}");
    }
    assert_eq!(table.matches(": 192 pixels each, 2 rounds\n").count(), 4, "{table}");
    assert_eq!(table.matches("  rendered\n").count(), 2 + 3 + 3 + 4, "{table}");

    let exported = json(&sandbox.read("o/c.json"));
    let all = list(&exported["series"]);
    let names: Vec<_> = all.iter().map(|s| s["series"].as_str().expect("a name")).collect();
    assert_eq!(names, SERIES);
    for point in all.iter().flat_map(|series| list(&series["points"])) {
        assert_eq!((&point["outcome"], &point["pixels"]), (&"rendered".into(), &192.into()));
        for times in ["program", "preparing", "tracing"] {
            let times: Vec<_> = list(&point[times]).iter().filter_map(Value::as_f64).collect();
            assert!(times.len() == 2 && times.iter().all(|time| *time > 0.0), "{point}");
        }
    }

    let svg = String::from_utf8(sandbox.read("o/c.svg")).expect("text");
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    let texts = texts(&svg);
    for text in ["tracing a ray", "preparing a solid", "lights above three spheres and a floor"] {
        assert!(texts.contains(&text), "{text}: {texts:?}");
    }
    assert!(!texts.contains(&"no image"));
    assert_eq!(sandbox.files(), ["o/", "o/c.json", "o/c.svg"]);
}

/// Each size is of what the series says: rays are those that so many reflections or lights ask for.
#[test]
fn scenes_are_of_their_size() {
    let sandbox = Sandbox::new();
    charted(&sandbox, &["--scaling=all", "--up-to", "8", "--export", "c.json"]);
    let exported = json(&sandbox.read("c.json"));
    let rays = |series: usize| -> Vec<(u64, u64)> {
        let points = list(&exported["series"][series]["points"]).iter();
        points.map(|point| (number(&point["n"]), number(&point["rays"]))).collect()
    };
    let lights = rays(3);
    assert_eq!(lights.iter().map(|(n, _)| *n).collect::<Vec<_>>(), [1, 2, 4, 8]);
    // Every ray from the eye that meets something asks for each light but those behind the surface.
    for (n, rays) in lights {
        assert!(192 + 192 * n / 4 < rays && rays <= 192 * (1 + n), "{n}: {rays}");
    }
    // In a closed room each ray is reflected n times, and asks for the light at each of n + 1 places.
    for (n, rays) in rays(2) {
        assert!(192 * (n + 1) < rays && rays <= 2 * 192 * (n + 1), "{n}: {rays}");
    }
}

/// What a file holds is charted as what was measured, byte for byte.
#[test]
fn data_is_charted_without_measuring() {
    let sandbox = Sandbox::new();
    let args = ["--scaling=holes,lights", "--up-to", "3", "-o", "1.svg", "--export", "1.json"];
    let table = charted(&sandbox, &args);
    assert!(table.contains("\nholes ") && !table.contains("\nspheres "), "{table}");
    let args = ["--scaling", "1.json", "-o", "2.svg", "--export", "2.json"];
    assert_eq!(charted(&sandbox, &args), table);
    assert!(sandbox.read("1.svg") == sandbox.read("2.svg"));
    assert!(sandbox.read("1.json") == sandbox.read("2.json"));
    let text = charted(&sandbox, &["--scaling", "1.json", "--export", "-"]);
    assert!(text.as_bytes() == sandbox.read("1.json"));

    charted(&sandbox, &["--scaling", "1.json", "-o", "c.png"]);
    assert!(sandbox.read("c.png").starts_with(b"\x89PNG\r\n\x1a\n"));
    charted(&sandbox, &["--scaling", "1.json", "-o", "c.html"]);
    let page = String::from_utf8(sandbox.read("c.html")).expect("text");
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<h1>Growth</h1>"));
    assert_eq!(page.matches("<tr>").count(), 1 + 2 + 1 + 2, "{page}");
    assert!(page.contains("<p>from 1 to 3 holes: "), "{page}");
}

/// Sizes that take too long, or are beyond a limit, are shown as such; the others are measured.
#[test]
fn failures_are_shown() {
    let sandbox = Sandbox::new();
    let args = ["--scaling=spheres", "--up-to", "10", "--timeout", "0.000001ms", "-o", "c.svg"];
    let table = charted(&sandbox, &args);
    assert_eq!(table.matches("  took more than ").count(), 2, "{table}");
    let svg = String::from_utf8(sandbox.read("c.svg")).expect("text");
    assert!(texts(&svg).contains(&"no image"));

    let args = ["--scaling=reflections", "--max-reflections", "3", "--up-to", "10"];
    let table = charted(&sandbox, &[&args[..], &["--export", "c.json", "-o", "c.png"]].concat());
    assert_eq!(table.matches("  rendered\n").count(), 2, "{table}");
    assert!(table.contains("failed: the reflection depth is 10; the limit is 3"), "{table}");
    assert!(table.contains("\n  from 1 to 3 reflections: "), "{table}");
    assert_eq!(charted(&sandbox, &["--scaling", "c.json"]), table);

    // Nothing is known of the image of a program that ends before it renders one.
    let table = charted(&sandbox, &["--scaling", "--fuel", "3", "--up-to", "1", "-o", "c.svg"]);
    assert_eq!(table.matches("failed: ").count(), 4, "{table}");
}

#[test]
fn exit_codes() {
    let table: [(&[&str], i32, &str); 10] = [
        (&["--scaling=cubes"], 2, "reflections"),
        (&["--scaling", "--up-to", "0"], 2, "--up-to"),
        (&["--scaling", "--methods", "jit-f64"], 2, "--methods"),
        (&["--scaling", "--depth", "3"], 2, "--depth"),
        (&["--scaling", "-D", "n=3"], 2, "--define"),
        (&["ball.gml", "--up-to", "3"], 2, "--scaling"),
        (&["--scaling", "ball.gml"], 2, ": not data of `--scaling`: "),
        (&["--scaling", "empty.json"], 2, "holds no chart"),
        (&["--scaling", "none.json"], 2, "cannot read `none.json`"),
        (&["--scaling", "--region", "90,0,1,1", "-o", "c.svg"], 2, "no pixel"),
    ];
    for (args, code, message) in table {
        let sandbox = Sandbox::new();
        sandbox.file("ball.gml", gmlvm::ball("ball.ppm")).file("empty.json", "{\"series\": []}");
        assert_refused(&sandbox, args, code, message);
    }
}

/// Files are not trusted: what is in them is checked, and texts are made fit to be shown.
#[test]
fn bad_data_is_refused() {
    let sandbox = Sandbox::new();
    charted(&sandbox, &["--scaling=holes", "--up-to", "3", "--export", "good.json"]);
    let good = json(&sandbox.read("good.json"));
    let changes: [(&str, Value, &str); 9] = [
        ("/series/0/series", "cubes".into(), "the name of a series"),
        ("/series/0/points", Value::Array(Vec::new()), "expected sizes"),
        ("/series/0/points/1/n", 1.into(), "that ascend"),
        ("/series/0/points/1/n", 1_000_001.into(), "from 1 to 1000000"),
        ("/series/0/points/0/rays", 191.into(), "at least as many rays"),
        ("/series/0/points/0/tracing", Value::Array(Vec::new()), "times of all kinds"),
        ("/series/0/points/0/tracing/0", 0.0.into(), "times above zero"),
        ("/series/0/points/0/program/0", (-1.0).into(), "times above zero"),
        ("/series", Value::Array(vec![good["series"][0].clone(); 101]), "room for 100 charts"),
    ];
    for (place, value, message) in changes {
        let mut bad = good.clone();
        *bad.pointer_mut(place).expect("it is there") = value;
        sandbox.file("bad.json", bad.to_string());
        let ended = chart(&sandbox, &["--scaling", "bad.json", "-o", "c.svg"]);
        assert_eq!(ended.code, 2, "{place}: {}", ended.stderr);
        assert!(ended.stderr.contains(message), "{place}: {}", ended.stderr);
        assert!(!sandbox.path("c.svg").exists(), "{place}");
    }
    let mut uneven = good.clone();
    for times in ["program", "preparing", "tracing"] {
        uneven["series"][0]["points"][0][times] = vec![1.0].into();
    }
    sandbox.file("uneven.json", uneven.to_string());
    let ended = chart(&sandbox, &["--scaling", "uneven.json"]);
    assert!(ended.stderr.contains("as many rounds"), "{}", ended.stderr);

    let mut odd = good;
    odd["series"][0]["about"]["date"] = "\u{1b}[2J<text>".into();
    for times in ["program", "preparing"] {
        odd["series"][0]["points"][0][times] = vec![0.0, 1e300].into();
    }
    odd["series"][0]["points"][0]["tracing"] = vec![1e-300, 1e300].into();
    sandbox.file("odd.json", odd.to_string());
    charted(&sandbox, &["--scaling", "odd.json", "-o", "c.svg"]);
    let svg = String::from_utf8(sandbox.read("c.svg")).expect("text");
    assert!(!svg.contains('\u{1b}') && !svg.contains("[2J<text>"), "{svg}");
}

/// The drawing of the documentation is that of the data beside it.
#[test]
fn the_chart_of_the_documentation_is_of_its_data() {
    assert_drawn_from_data("scaling", &["--scaling"]);
}
