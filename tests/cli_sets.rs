//! `gmlvm chart --set`: what each set measures, prints, draws, exports, reads again and refuses. No test
//! depends on how long anything takes.

use serde_json::Value;

use crate::chart::{
    assert_drawn_from_data, assert_refused, chart, charted, json, list, number, texts,
};
use crate::gmlvm::{Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/chart.rs"]
mod chart;

const COMMON: &[&str] = &["--runs", "2", "--warmup", "0"];

/// Sets of what is part of the program, and of scenes.
const OWN: [&str; 3] = ["distance", "stability", "bounces"];
const OF_SCENES: [&str; 5] = ["certainty", "bounds", "omissions", "differences", "threads"];

/// Rays that start on a solid meet it again if numbers are short and the epsilon is small.
const SCENE: &str = "\
{ /v /u /face u 6.0 mulf floor 2 modi 0 eqi { 0.9 0.5 0.1 point } { 0.2 0.4 0.8 point } if 1.0 0.0 1.0 } /stripes
stripes sphere 0.0 0.0 2.0 translate
{ /v /u /face 0.3 0.8 0.4 point 0.7 0.2 6.0 } plane 0.0 -1.0 0.0 translate union /all
0.2 0.2 0.2 point [ 1.0 -1.0 1.0 point 0.8 0.8 0.8 point light ] all 2 60.0 12 9 \"a.ppm\" render
";

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", SCENE).file("ball.gml", ball("ball.ppm"));
    sandbox
}

/// Measures a set on both scenes, or on its own; returns its panels, what is drawn and what is printed.
fn measured(set: &str) -> (Value, String, String) {
    let sandbox = sandbox();
    let scenes: &[&str] = if OF_SCENES.contains(&set) { &["s.gml", "ball.gml"] } else { &[] };
    let args = ["--set", set, "-o", "1.svg", "--export", "1.json"];
    let table = charted(&sandbox, &[&args, scenes].concat());
    // What a file holds is charted as what was measured, byte for byte.
    let again = ["--set", set, "1.json", "-o", "2.svg", "--export", "2.json"];
    assert_eq!(charted(&sandbox, &again), table);
    let same =
        |name: &str| sandbox.read(&format!("1.{name}")) == sandbox.read(&format!("2.{name}"));
    assert!(same("svg") && same("json"), "{set}");
    let svg = String::from_utf8(sandbox.read("1.svg")).expect("text");
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    let panels = json(&sandbox.read("1.json"))["panels"].take();
    for panel in list(&panels) {
        assert_eq!(panel["about"]["version"], env!("CARGO_PKG_VERSION"));
        for item in list(&panel["items"]) {
            assert_eq!(item["outcome"], "rendered", "{item}");
        }
    }
    (panels, svg, table)
}

/// The item of a name in a panel.
fn item<'p>(panel: &'p Value, name: &str) -> &'p Value {
    let found = list(&panel["items"]).iter().find(|item| item["name"] == name);
    found.unwrap_or_else(|| panic!("no {name}: {panel}"))
}

fn last_error(panel: &Value, name: &str) -> f64 {
    let point = list(&item(panel, name)["points"]).last().expect("points");
    point[1].as_f64().expect("a number")
}

/// Far away the textbook's formula fails and ours does not.
#[test]
fn distance() {
    let (panels, svg, table) = measured("distance");
    let [misses, points] = list(&panels) else { panic!("two panels: {panels}") };
    assert!(last_error(misses, "textbook-f32") > 0.1 && last_error(misses, "textbook-f64") > 0.1);
    for name in ["gmlvm-f64", "gmlvm-dd"] {
        assert_eq!(last_error(misses, name), 0.0, "{name}");
    }
    assert!(last_error(points, "kahan-f64") > 0.01 && last_error(points, "gmlvm-f64") < 1e-13);
    assert!(last_error(points, "gmlvm-dd") < 1e-26);
    let times = list(&item(misses, "gmlvm-f64")["times"]);
    assert!(times.len() == 2 && times.iter().all(|time| time.as_f64() > Some(0.0)));
    assert!(texts(&svg).contains(&"100 M") && table.contains("100 000 000"), "{table}");
}

/// Ours are right in all cases, and each naive way is wrong in most.
#[test]
fn stability() {
    let (panels, svg, _) = measured("stability");
    let [panel] = list(&panels) else { panic!("a panel: {panels}") };
    let n_cases = list(&panel["cases"]).len();
    for item in list(&panel["items"]) {
        let wrong: Vec<u64> = list(&item["wrong"]).iter().map(number).collect();
        assert_eq!(wrong.len(), n_cases);
        let n_wrong = wrong.iter().filter(|n| **n > 0).count();
        let is_naive = item["name"].as_str().is_some_and(|name| name.starts_with("naive"));
        assert!(if is_naive { 2 * n_wrong > n_cases } else { n_wrong == 0 }, "{item}");
    }
    assert!(texts(&svg).contains(&"nothing-left"));
}

#[test]
fn bounces() {
    let (panels, svg, table) = measured("bounces");
    let [panel] = list(&panels) else { panic!("a panel: {panels}") };
    let at = |name: &str, n: f64| {
        let points = list(&item(panel, name)["points"]);
        let point = points.iter().find(|point| point[0].as_f64() == Some(n));
        point.and_then(|point| point[1].as_f64()).unwrap_or_else(|| panic!("{name} at {n}"))
    };
    // A bound is above what it bounds, and what has 29 bits less is that much worse.
    assert!(at("bound of doubles", 8.0) > at("jit-f64", 8.0));
    for n in [5.0, 20.0, 40.0] {
        assert!(at("naive-f32-1e-3", n) > 1e6 * at("jit-f64", n), "{n}");
    }
    assert!(at("jit-f64", 60.0) > 1e6 * at("jit-f64", 10.0), "{panel}");
    assert!(texts(&svg).contains(&"half a level of a byte"));
    assert!(table.contains("\n  errors grow with each reflection, times: "), "{table}");
}

#[test]
fn certainty() {
    let (panels, svg, table) = measured("certainty");
    let [panel] = list(&panels) else { panic!("a panel for all scenes: {panels}") };
    for (name, n_pixels) in [("s.gml", 12 * 9), ("ball.gml", 8 * 6)] {
        let known = &item(panel, name)["known"];
        let rules = known["rules"].as_object().expect("rules").values().map(number);
        let total = number(&known["f64"]) + number(&known["dd"]) + rules.sum::<u64>();
        assert_eq!(total, n_pixels, "{known}");
    }
    assert!(texts(&svg).contains(&"rules: boundary") && table.contains("in double-double"));
}

#[test]
fn bounds() {
    let (panels, _, table) = measured("bounds");
    for (panel, n_pixels) in list(&panels).iter().zip([12 * 9, 8 * 6]) {
        let [dots] = list(&panel["items"]) else { panic!("an item: {panel}") };
        let channels = number(&dots["channels"]);
        assert!(channels > 0 && channels <= 3 * n_pixels, "{dots}");
        assert_eq!(number(&dots["unsound"]), 0);
        for point in list(&dots["points"]) {
            assert!(point[1].as_f64() <= point[0].as_f64(), "{point}");
        }
    }
    assert!(number(&panels[0]["items"][0]["exact"]) < number(&panels[0]["items"][0]["channels"]));
    assert!(table.contains("\n  0 of "), "{table}");
}

#[test]
fn omissions() {
    let (panels, svg, _) = measured("omissions");
    assert_eq!(list(&panels).len(), 2);
    for panel in list(&panels) {
        assert_eq!(list(&panel["items"]).len(), 12, "{panel}");
        assert_eq!(panel["items"][0]["base"], panel["items"][0]["times"]);
        assert_eq!(panel["items"][11]["base"], panel["items"][0]["times"]);
    }
    assert!(texts(&svg).contains(&"unread coordinates"));
}

#[test]
fn differences() {
    let (panels, svg, _) = measured("differences");
    let n_different = |panel: &Value, name: &str| {
        let rows = list(&item(panel, name)["rows"]);
        let marks = rows.iter().flat_map(|row| row.as_str().expect("text").chars());
        marks.filter(|mark| *mark != '.').count()
    };
    let [scene, ball] = list(&panels) else { panic!("two panels: {panels}") };
    for name in ["jit-f64", "jit-dd"] {
        assert_eq!([scene, ball].map(|panel| n_different(panel, name)), [0, 0], "{name}");
    }
    assert!(n_different(scene, "naive-f32-1e-9") > n_different(scene, "naive-f32-1e-3"));
    assert!(texts(&svg).contains(&"naive-f64-1e-6: 0"));
}

#[test]
fn threads() {
    let (panels, svg, table) = measured("threads");
    let [panel] = list(&panels) else { panic!("a panel for all scenes: {panels}") };
    assert_eq!(list(&panel["items"]).len(), 2);
    for item in list(&panel["items"]) {
        let work: Vec<usize> = list(&item["work"]).iter().map(|times| list(times).len()).collect();
        assert_eq!(work, [2, 2], "{item}");
    }
    assert!(table.contains("times as fast"), "{table}");
    assert!(texts(&svg).iter().any(|text| text.contains("one thread and two")));
}

/// What takes too long, or cannot be traced, is drawn as such; the others are measured.
#[test]
fn failures_are_shown() {
    let sandbox = sandbox();
    for set in ["certainty", "bounds", "omissions", "differences", "threads"] {
        let args = ["--set", set, "s.gml", "ball.gml", "--timeout", "0.000001ms"];
        let table =
            charted(&sandbox, &[&args[..], &["-o", "c.svg", "--export", "c.json"]].concat());
        assert!(table.contains("  took more than "), "{set}: {table}");
        assert!(!table.contains("  measured\n"), "{set}: {table}");
        assert_eq!(charted(&sandbox, &["--set", set, "c.json"]), table);
    }
    sandbox.file("bad.gml", "1 addi");
    let ended = chart(&sandbox, &["--set", "certainty", "bad.gml", "ball.gml"]);
    assert_eq!(ended.code, 1, "{}", ended.stderr);
    assert!(ended.text().contains("  ball.gml "), "{}", ended.text());
}

#[test]
fn exit_codes() {
    let table: [(&[&str], &str); 9] = [
        (&["--set", "C3", "ball.gml"], "distance, stability, certainty"),
        (&["--set", "certainty"], "`--set certainty` is measured on scenes"),
        (&["--set", "distance", "ball.gml"], "`--set distance` is not measured on scenes"),
        (&["--set", "distance", "--methods", "jit-f64"], "--methods"),
        (&["--set", "distance", "--scaling"], "--scaling"),
        (&["--set", "bounds", "empty.json"], "holds no chart"),
        (&["--set", "bounds", "none.json"], "cannot read `none.json`"),
        (&["--set", "bounds", "ball.gml", "--region", "90,0,1,1", "-o", "c.svg"], "no pixel"),
        (&["--set", "bounces", "--region", "90,0,1,1", "-o", "c.svg"], "no pixel"),
    ];
    for (args, message) in table {
        let sandbox = sandbox();
        sandbox.file("empty.json", "{\"panels\": []}");
        assert_refused(&sandbox, args, 2, message);
    }
}

/// Files are not trusted: what is in them is checked, and texts are made fit to be shown.
#[test]
fn bad_data_is_refused() {
    let (panels, ..) = measured("threads");
    let good = serde_json::json!({ "panels": panels });
    let (dots, ..) = measured("bounds");
    let dots = serde_json::json!({ "panels": dots });
    let changes: [(&str, &Value, &str, Value); 8] = [
        ("threads", &good, "/panels/0/kind", "misses".into()),
        ("threads", &good, "/panels/0/kind", "growth".into()),
        ("threads", &good, "/panels/0/form", "masks".into()),
        ("threads", &good, "/panels/0/items", Value::Array(Vec::new())),
        ("threads", &good, "/panels/0/items/0/times/0", (-1.0).into()),
        ("threads", &good, "/panels/0/items/0/times", vec![1.0].into()),
        ("threads", &good, "/panels/0/items/0/pixels", 0.into()),
        ("bounds", &dots, "/panels/0/items/0/unsound", u64::MAX.into()),
    ];
    let sandbox = Sandbox::new();
    for (set, good, place, value) in changes {
        let mut bad = good.clone();
        *bad.pointer_mut(place).expect("it is there") = value;
        sandbox.file("bad.json", bad.to_string());
        let ended = chart(&sandbox, &["--set", set, "bad.json", "-o", "c.svg"]);
        assert_eq!(ended.code, 2, "{place}: {}", ended.stderr);
        assert!(ended.stderr.contains("not data of `--set`"), "{place}: {}", ended.stderr);
        assert!(!sandbox.path("c.svg").exists(), "{place}");
    }
    sandbox.file("good.json", good.to_string());
    let ended = chart(&sandbox, &["--set", "bounds", "good.json"]);
    assert!(ended.stderr.contains("is of the set `threads`"), "{}", ended.stderr);

    // A bound that does not hold is seen.
    let mut unsound = dots;
    unsound["panels"][0]["items"][0]["unsound"] = 3.into();
    unsound["panels"][0]["items"][0]["points"][0] = vec![1e-16, 1e-12].into();
    sandbox.file("unsound.json", unsound.to_string());
    let table = charted(&sandbox, &["--set", "bounds", "unsound.json", "-o", "c.svg"]);
    assert!(table.contains("\n  3 of "), "{table}");

    let mut odd = good;
    odd["panels"][0]["items"][0]["name"] = "\u{1b}[2J<text>".into();
    odd["panels"][0]["items"][0]["times"] = vec![1e-300, 1e300].into();
    sandbox.file("odd.json", odd.to_string());
    let text = charted(&sandbox, &["--set", "threads", "odd.json", "-o", "c.svg"]);
    let svg = String::from_utf8(sandbox.read("c.svg")).expect("text");
    assert!(!text.contains('\u{1b}') && !svg.contains('\u{1b}') && !svg.contains("J<text>"));
}

/// What a file holds does not make a drawing without measure.
#[test]
fn drawings_have_bounds() {
    let sandbox = Sandbox::new();
    let (panels, ..) = measured("differences");
    let mut high = serde_json::json!({ "panels": [panels[0]] });
    high["panels"][0]["items"][0]["width"] = 1.into();
    high["panels"][0]["items"][0]["rows"] = vec![""; 7296].into();
    sandbox.file("high.json", high.to_string());
    for drawing in ["c.png", "c.svg"] {
        let args = ["--set", "differences", "high.json", "-o", drawing];
        assert_refused(&sandbox, &args, 2, "pixels high");
    }
    let (panels, ..) = measured("bounces");
    let mut far = serde_json::json!({ "panels": panels });
    let points = far["panels"][0]["items"][0]["points"].as_array_mut().expect("points");
    points.push(serde_json::json!([1e12, 0.5]));
    sandbox.file("far.json", far.to_string());
    charted(&sandbox, &["--set", "bounces", "far.json", "-o", "c.svg"]);
    let n_bytes = sandbox.read("c.svg").len();
    assert!(n_bytes < 1 << 20, "{n_bytes} bytes");
}

/// The drawings of the documentation are those of the data beside them.
#[test]
fn charts_of_the_documentation_are_of_their_data() {
    for set in OWN.into_iter().chain(OF_SCENES) {
        assert_drawn_from_data(set, &["--set", set]);
    }
}
