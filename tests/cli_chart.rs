//! `gmlvm chart`: what it prints, draws, exports, reads again and refuses. No test depends on how long
//! anything takes.

use serde_json::Value;

use crate::chart::{assert_drawn_from_data, assert_refused, chart, charted, json, list, texts};
use crate::gmlvm::{Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/chart.rs"]
mod chart;

const COMMON: &[&str] = &["--runs", "2", "--warmup", "0"];

/// Two images. Rays that start on a solid meet it again if numbers are short and the epsilon is small.
const SCENE: &str = "\
{ /v /u /face 0.9 0.5 0.1 point 1.0 0.0 1.0 } sphere 0.9999 uscale /inner
{ /v /u /face 0.2 0.4 0.8 point 1.0 0.0 1.0 } sphere inner difference 0.0 0.0 2.0 translate /shell
shell { /v /u /face u v 0.5 point 0.7 0.2 6.0 } plane 0.0 -1.0 0.0 translate union /all
0.2 0.2 0.2 point [ 1.0 -1.0 1.0 point 0.8 0.8 0.8 point light ] all 2 60.0 12 9 \"a.ppm\" render
0.2 0.2 0.2 point [ ] all 2 60.0 6 5 \"b.ppm\" render
";

/// The methods of the chart about rounding.
const METHODS: [&str; 11] = [
    "interp-f64",
    "jit-f64",
    "interp-dd",
    "jit-dd",
    "jit-certified",
    "naive-f64-1e-3",
    "naive-f64-1e-6",
    "naive-f64-1e-9",
    "naive-f32-1e-3",
    "naive-f32-1e-6",
    "naive-f32-1e-9",
];

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", SCENE).file("ball.gml", ball("ball.ppm"));
    sandbox
}

#[test]
fn a_scene_becomes_a_table_data_and_a_drawing() {
    let sandbox = sandbox();
    let table = charted(&sandbox, &["s.gml", "-o", "o/c.svg", "--export", "o/c.json"]);
    assert!(
        table.contains("\ns.gml, rounding: 2 images, 138 pixels, 2 rounds; against "),
        "{table}"
    );
    let row = |name: &str| {
        let start = format!("  {name} ");
        let line = table.lines().find(|line| line.starts_with(&start));
        line.unwrap_or_else(|| panic!("{name}: {table}")).split_whitespace().collect::<Vec<_>>()
    };
    for name in METHODS {
        assert!(row(name).contains(&"front") || row(name).contains(&"dominated"), "{table}");
    }
    assert!(table.contains(" front\n"), "{table}");

    let exported = json(&sandbox.read("o/c.json"));
    let [chart] = list(&exported["charts"]) else { panic!("one chart: {exported}") };
    assert_eq!((&chart["scene"], &chart["diagram"]), (&"s.gml".into(), &"rounding".into()));
    assert_eq!((&chart["images"], &chart["pixels"]), (&2.into(), &138.into()));
    assert_eq!(chart["about"]["version"], env!("CARGO_PKG_VERSION"));
    let methods = list(&chart["methods"]);
    let names: Vec<_> = methods.iter().map(|m| m["method"].as_str().expect("a name")).collect();
    assert_eq!(names, METHODS);
    for method in methods {
        assert_eq!(method["outcome"], "rendered", "{method}");
        for times in [&method["tracing"], &method["preparing"]] {
            let times: Vec<_> = list(times).iter().filter_map(Value::as_f64).collect();
            assert!(times.len() == 2 && times.iter().all(|time| *time > 0.0), "{method}");
        }
    }
    let differing = |index: usize| methods[index]["differing"].as_u64().expect("a number");
    assert_eq!([0, 1, 2, 3, 4].map(differing), [0; 5], "{chart}");
    assert_eq!((&methods[3]["max"], &methods[3]["rms"]), (&0.0.into(), &0.0.into()));
    assert!(methods[0]["max"].as_f64().is_some_and(|max| max > 0.0 && max < 1e-9), "{chart}");
    // Points on the solids are off by more than 1e-9 of single precision.
    assert!(differing(10) > differing(8), "{chart}");

    let svg = String::from_utf8(sandbox.read("o/c.svg")).expect("text");
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    let texts = texts(&svg);
    let front = texts.iter().find(|text| text.starts_with("front: ")).expect("the front");
    assert!(METHODS.iter().any(|name| front.contains(name)), "{front}");
    for text in [&["s.gml, rounding", "0 of 138", "100 %"], &METHODS[..]].concat() {
        assert!(texts.contains(&text), "{text}: {texts:?}");
    }
    assert_eq!(sandbox.files(), ["ball.gml", "o/", "o/c.json", "o/c.svg", "s.gml"]);
}

/// What a file holds is charted as what was measured, byte for byte.
#[test]
fn data_is_charted_without_measuring() {
    let sandbox = sandbox();
    let methods = ["--methods", "jit-f64,naive-f32-1e-3,sampling"];
    let args = [&["s.gml", "ball.gml", "-o", "1.svg", "--export", "1.json"], &methods[..]].concat();
    let table = charted(&sandbox, &args);
    for name in ["s.gml, rounding", "s.gml, sampling", "ball.gml, rounding", "ball.gml, sampling"] {
        assert!(table.contains(&format!("\n{name}: ")), "{table}");
    }
    let args = ["1.json", "-o", "2.svg", "--export", "2.json"];
    assert_eq!(charted(&sandbox, &args), table);
    assert!(sandbox.read("1.svg") == sandbox.read("2.svg"));
    assert!(sandbox.read("1.json") == sandbox.read("2.json"));
    let text = charted(&sandbox, &["1.json", "--export", "-"]);
    assert!(text.as_bytes() == sandbox.read("1.json"));

    let exported = json(&sandbox.read("1.json"));
    let rms: Vec<_> = list(&exported["charts"][1]["methods"])
        .iter()
        .map(|method| method["rms"].as_f64().expect("finite"))
        .collect();
    // Grids of 1, 4, 16 and 64 rays; adaptive sampling of depth 1 to 4.
    assert_eq!(rms.len(), 8);
    assert!(rms[..4].is_sorted_by(|a, b| a > b), "{rms:?}");
    assert!(rms[4..].is_sorted_by(|a, b| a >= b) && rms[4] < rms[0], "{rms:?}");

    charted(&sandbox, &["1.json", "-o", "c.png"]);
    let png = sandbox.read("c.png");
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    let width = u32::from_be_bytes(png[16..20].try_into().expect("four bytes"));
    assert_eq!(width, 1600);
}

#[test]
fn pages_hold_drawing_and_tables() {
    let sandbox = sandbox();
    sandbox.file("a<b&c.gml", ball("ball.ppm"));
    let args = ["a<b&c.gml", "--methods", "jit-f64,jit-dd", "-o", "c.html"];
    charted(&sandbox, &args);
    let page = String::from_utf8(sandbox.read("c.html")).expect("text");
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<svg "));
    assert_eq!(page.matches("<tr").count(), 3, "{page}");
    assert!(page.contains("<td>jit-dd</td>") && page.contains("<th>standing</th>"));
    assert!(page.contains("a&lt;b&amp;c.gml, rounding") && !page.contains("a<b"), "{page}");
    // A mark leads to its row, and nothing leads elsewhere.
    for method in ["jit-f64", "jit-dd"] {
        assert!(page.contains(&format!("<a href=\"#t0-{method}\"><circle")), "{page}");
        assert!(page.contains(&format!("<tr id=\"t0-{method}\"><td>{method}</td>")), "{page}");
    }
    assert_eq!(page.matches("href=").count(), 2);
    for outside in ["<script", "src=", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
}

/// Methods that fail, or take too long, are shown as such.
#[test]
fn failures_are_shown() {
    let sandbox = sandbox();
    let ended =
        chart(&sandbox, &["s.gml", "--timeout", "0.000001ms", "-o", "c.svg", "--export", "c.json"]);
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""));
    assert_eq!(ended.text().matches("took more than ").count(), METHODS.len(), "{}", ended.text());
    let svg = String::from_utf8(sandbox.read("c.svg")).expect("text");
    assert!(texts(&svg).contains(&"no image"));
    let exported = json(&sandbox.read("c.json"));
    assert_eq!(exported["charts"][0]["methods"][0]["outcome"], "timed-out");
    assert_eq!(charted(&sandbox, &["c.json"]), ended.text());

    // Too deep for a tracer that recurses, but not for ours.
    let nested = "{ /v /u /face 1.0 1.0 1.0 point 1.0 0.0 1.0 } sphere /s
        { /self /n /o n 0 eqi { o } { o s 9.0 9.0 9.0 translate difference n 1 subi self self apply } if } /less
        s 3000 less less apply /o
        1.0 1.0 1.0 point [ ] o 1 60.0 4 3 \"n.ppm\" render";
    sandbox.file("n.gml", nested);
    let table = charted(&sandbox, &["n.gml", "--methods", "jit-f64,naive-f64-1e-6"]);
    assert!(table.contains("failed: the solid is nested too deep"), "{table}");
    assert_eq!(table.matches(" front\n").count(), 1, "{table}");
}

/// A surface that fails at some pixels for a naive tracer only is counted there.
#[test]
fn pixels_without_a_colour_are_counted() {
    let sandbox = sandbox();
    // Where x is 0, the naive tracer takes the arc cosine of z / r, which rounding makes more than 1.
    let scene = "{ /v /u /face u 8.0 mulf floor /n
            [ 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 ] n get /c c c c point 1.0 0.0 1.0 } sphere
        0.0 0.0 3.0 translate /ball
        1.0 1.0 1.0 point [ ] ball 1 40.0 31 31 \"m.ppm\" render";
    sandbox.file("m.gml", scene);
    charted(&sandbox, &["m.gml", "--methods", "jit-f64,naive-f64-1e-6", "--export", "m.json"]);
    let exported = json(&sandbox.read("m.json"));
    let [ours, naive] = list(&exported["charts"][0]["methods"]) else { panic!("two: {exported}") };
    assert_eq!((&ours["missing"], &ours["differing"]), (&0.into(), &0.into()));
    let [missing, gross, differing] =
        ["missing", "gross", "differing"].map(|key| naive[key].as_u64().expect("a number"));
    assert!(0 < missing && missing <= gross && gross <= differing && differing <= 31, "{naive}");
}

#[test]
fn exit_codes() {
    let table: [(&[&str], i32, &str); 14] = [
        (&[], 2, "required"),
        (&["-"], 2, "standard input"),
        (&["s.gml", "-o", "c.pdf"], 2, ".svg, .png or .html"),
        (&["s.gml", "-o", "c"], 2, ".svg, .png or .html"),
        (&["s.gml", "--runs", "0"], 2, "--runs"),
        (&["s.gml", "--methods", "fast"], 2, "naive-f32-1e-9"),
        (&["none.gml"], 2, "cannot read `none.gml`"),
        (&["none.json"], 2, "cannot read `none.json`"),
        (&["text.json", "-o", "c.svg"], 2, "text.json:1:1: not data of a chart"),
        (&["empty.gml", "-o", "c.svg"], 2, "renders no image"),
        (&["s.gml", "--region", "50,0,1,1", "-o", "c.svg"], 2, "no pixel"),
        (&["bad.gml", "-o", "c.svg"], 1, "bad.gml:1:1"),
        (&["s.gml", "--max-pixels", "10", "-o", "c.svg"], 4, "--max-pixels"),
        (&["ball.gml", "-o", "s.gml/c.svg"], 3, "could not write"),
    ];
    for (args, code, message) in table {
        let sandbox = sandbox();
        sandbox.file("bad.gml", "{").file("empty.gml", "1").file("text.json", "x");
        assert_refused(&sandbox, args, code, message);
    }
}

/// A scene that fails does not keep others from the chart.
#[test]
fn the_rest_is_charted() {
    let sandbox = sandbox();
    sandbox.file("bad.gml", "{");
    let args = ["bad.gml", "ball.gml", "--methods", "jit-f64", "-o", "c.svg"];
    let ended = chart(&sandbox, &args);
    assert_eq!(ended.code, 1);
    let svg = String::from_utf8(sandbox.read("c.svg")).expect("text");
    assert!(texts(&svg).contains(&"ball.gml, rounding"));
}

/// Files are not trusted: what is in them is checked, and texts are made fit to be shown.
#[test]
fn bad_data_is_refused() {
    let sandbox = sandbox();
    charted(&sandbox, &["ball.gml", "--methods", "jit-f64,jit-dd", "--export", "good.json"]);
    let good = json(&sandbox.read("good.json"));
    let method = &good["charts"][0]["methods"][0];
    let changes: [(&str, Value, &str); 10] = [
        ("/charts/0/pixels", 0.into(), "expected pixels"),
        ("/charts/0/methods", Value::Array(Vec::new()), "expected pixels and methods"),
        ("/charts/0/methods/0/method", "fast".into(), "no method `fast`"),
        ("/charts/0/methods/0/method", "grid-2x2".into(), "no method `grid-2x2`"),
        ("/charts/0/methods/0/tracing", Value::Array(Vec::new()), "times of both kinds"),
        ("/charts/0/methods/0/tracing/0", 0.0.into(), "times above zero"),
        ("/charts/0/methods/0/differing", 1_000_000.into(), "fewer pixels"),
        ("/charts/0/methods/0/max", (-1.0).into(), "errors from zero"),
        ("/charts", Value::Array(Vec::new()), "holds no chart"),
        ("/charts", Value::Array(vec![good["charts"][0].clone(); 101]), "room for 100 charts"),
    ];
    assert_eq!(method["outcome"], "rendered");
    for (place, value, message) in changes {
        let mut bad = good.clone();
        *bad.pointer_mut(place).expect("it is there") = value;
        sandbox.file("bad.json", bad.to_string());
        let ended = chart(&sandbox, &["bad.json", "-o", "c.svg"]);
        assert_eq!(ended.code, 2, "{place}: {}", ended.stderr);
        assert!(ended.stderr.contains(message), "{place}: {}", ended.stderr);
        assert!(!sandbox.path("c.svg").exists(), "{place}");
    }
    let mut odd = good;
    odd["charts"][0]["scene"] = "\u{1b}[2J<text>".into();
    odd["charts"][0]["methods"][0]["tracing"] = vec![1e-300, 1e300].into();
    sandbox.file("odd.json", odd.to_string());
    let text = charted(&sandbox, &["odd.json", "-o", "c.svg"]);
    let svg = String::from_utf8(sandbox.read("c.svg")).expect("text");
    assert!(
        !text.contains('\u{1b}') && !svg.contains('\u{1b}') && !svg.contains("<text>"),
        "{text}"
    );
}

/// The drawings of the documentation are those of the data beside them.
#[test]
fn charts_of_the_documentation_are_of_their_data() {
    for name in ["rounding", "sampling"] {
        assert_drawn_from_data(name, &[]);
    }
}
