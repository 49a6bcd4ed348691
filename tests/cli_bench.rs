//! `gmlvm bench`: what it prints, exports, compares and refuses. No test depends on how long
//! anything takes.

use serde_json::{Value, json};

use crate::gmlvm::{Ended, Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// A scene of two images with three surface functions: one reads its place, one is constant, one
/// recurses in a way that is not compiled.
const SCENE: &str = "\
{ /v /u /face u v 0.5 point 0.8 0.2 6.0 } sphere 0.0 0.0 3.0 translate /near
{ /v /u /face 0.1 0.2 0.3 point 0.8 0.2 6.0 } cylinder -1.0 0.0 5.0 translate /far
{ /self /n n 1 lessi { 0.0 } { [ n 1 subi self self apply ] } if } /nest
{ /v /u /face u 200.0 mulf floor nest nest apply /x 0.1 0.0 0.0 point 0.8 0.2 6.0 } cube
1.0 0.0 5.0 translate /block
near far union block union /all
1.0 1.0 1.0 point [ 1.0 -1.0 0.0 point 1.0 1.0 1.0 point light ] all 2 90.0 12 9 \"a.ppm\" render
1.0 1.0 1.0 point [ ] all 1 60.0 6 5 \"b.png\" render
";

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", SCENE).file("ball.gml", ball("ball.ppm"));
    sandbox
}

fn json(text: &[u8]) -> Value {
    serde_json::from_slice(text).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

fn assert_ok(ended: &Ended) {
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""), "{}", ended.text());
}

#[test]
fn tables_show_all_variants_and_nothing_is_written() {
    let sandbox = sandbox();
    let args = ["bench", "s.gml", "ball.gml", "--runs", "2", "-j", "1,2", "--engines", "jit,auto"];
    let ended = sandbox.run(&args);
    assert_ok(&ended);
    let text = ended.text();
    assert!(text.contains("\ns.gml: 2 images, 138 pixels, "), "{text}");
    assert!(text.contains("\nball.gml: 1 image, 48 pixels, "), "{text}");
    for line in ["  jit         1 ", "  jit         2 ", "  auto        1 ", "  auto        2 "] {
        // Twice for each scene: times, and phases.
        assert_eq!(text.matches(line).count(), 4, "{line}\n{text}");
    }
    // Two rounds are too few for any claim.
    assert_eq!(text.matches("too few runs to tell").count(), 6, "{text}");
    assert_eq!(sandbox.files(), ["ball.gml", "s.gml"]);
}

#[test]
fn exports_have_the_shape_of_hyperfine() {
    let sandbox = sandbox();
    let args =
        ["bench", "s.gml", "--runs", "7", "--size", "5x4", "-D", "x=1", "--export", "o/b.json"];
    assert_ok(&sandbox.run(&args));
    let exported = json(&sandbox.read("o/b.json"));
    let results = exported["results"].as_array().expect("a list");
    assert_eq!(results.len(), 3);
    for (result, engine) in results.iter().zip(["interp", "jit", "auto"]) {
        let command = format!("gmlvm run s.gml --engine {engine} -j 1 --size 5x4 -D x=1");
        assert_eq!(result["command"], command.as_str());
        let times: Vec<_> = result["times"].as_array().expect("times").iter().map(number).collect();
        assert_eq!((times.len(), &result["exit_codes"]), (7, &json!([0, 0, 0, 0, 0, 0, 0])));
        let mut sorted = times.clone();
        sorted.sort_by(f64::total_cmp);
        let of = |key: &str| number(&result[key]);
        assert_eq!((of("min"), of("median"), of("max")), (sorted[0], sorted[3], sorted[6]));
        assert!((of("mean") - times.iter().sum::<f64>() / 7.0).abs() < 1e-12);
        assert!(of("stddev") >= 0.0 && of("user") >= 0.0 && of("system") >= 0.0 && sorted[0] > 0.0);
        let details = &result["gmlvm"];
        assert_eq!((&details["engine"], &details["threads"]), (&engine.into(), &1.into()));
        assert_eq!((&details["images"], &details["pixels"]), (&2.into(), &40.into()));
        assert_eq!(details["image_hash"], results[0]["gmlvm"]["image_hash"]);
        assert_eq!(details["rays"], results[0]["gmlvm"]["rays"]);
        assert_eq!(details["rays"]["primary"], 40);
        for phase in ["read", "compile", "run", "build", "jit", "trace", "write"] {
            assert!(number(&details["phases"][phase]) >= 0.0, "{phase}");
        }
        let ratio = &details["ratio_to_first"];
        assert_eq!(ratio.is_null(), engine == "interp");
        if let Some(interval) = ratio["interval"].as_array() {
            let (low, high) = (number(&interval[0]), number(&interval[1]));
            let verdict = match () {
                () if high < 1.0 => "faster",
                () if low > 1.0 => "slower",
                () => "no difference within noise",
            };
            assert!(low <= number(&ratio["ratio"]) && number(&ratio["ratio"]) <= high);
            assert_eq!(ratio["verdict"], verdict);
        }
    }
    assert!(number(&exported["gmlvm"]["machine"]["cores"]) >= 1.0);
    assert_eq!(exported["gmlvm"]["version"], env!("CARGO_PKG_VERSION"));
}

/// Precisions are variants as engines are, and each has its own images.
#[test]
fn precisions_are_variants() {
    let sandbox = sandbox();
    // Lines between tiles run through the centres of pixels, where the last digit decides.
    let tiles = "{ /v /u /face u floor v floor addi 2 modi real /c c c c point 1.0 0.0 1.0 } plane
        0.0 -1.0 0.0 translate /tiles
        1.0 1.0 1.0 point [ ] tiles 1 90.0 48 36 \"t.ppm\" render";
    sandbox.file("tiles.gml", tiles);
    let bench = ["bench", "tiles.gml", "--engines", "interp,jit", "--precision", "f64,dd"];
    let ended = sandbox.run(&[&bench[..], &["--runs", "2", "--export", "o.json"]].concat());
    assert_ok(&ended);
    for line in ["  interp      1 ", "  interp dd   1 ", "  jit         1 ", "  jit dd      1 "] {
        assert_eq!(ended.text().matches(line).count(), 2, "{line}\n{}", ended.text());
    }
    let exported = json(&sandbox.read("o.json"));
    let results = exported["results"].as_array().expect("a list");
    let commands: Vec<_> = results.iter().map(|result| result["command"].as_str()).collect();
    let command = |rest: &str| format!("gmlvm run tiles.gml --engine {rest}");
    let expected = ["interp -j 1", "interp -j 1 --precision dd", "jit -j 1"].map(command);
    assert_eq!(commands[..3], expected.each_ref().map(|command| Some(command.as_str())));
    let of = |index: usize, key: &str| &results[index]["gmlvm"][key];
    assert_eq!(
        ["f64", "dd", "f64", "dd"],
        [0, 1, 2, 3].map(|index| of(index, "precision").clone())
    );
    assert_eq!(of(0, "image_hash"), of(2, "image_hash"));
    assert_eq!(of(1, "image_hash"), of(3, "image_hash"));
    assert_ne!(of(0, "image_hash"), of(1, "image_hash"));
    let args = [&bench[..], &["--runs", "1", "--compare", "o.json"]].concat();
    let ended = sandbox.run(&args);
    assert_ok(&ended);
    assert_eq!(ended.text().matches("too few runs to tell").count(), 7, "{}", ended.text());
}

/// The hash is that of the files that `run` writes, one behind the other.
#[test]
fn the_hash_is_of_the_images() {
    let sandbox = sandbox();
    assert_eq!(sandbox.run(&["s.gml", "--dialect", "chicago"]).code, 0);
    let files = [sandbox.read("a.ppm"), sandbox.read("b.png")].concat();
    let hash = files.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    });
    let hash_of = |options: &[&str]| {
        let args = [&["bench", "s.gml", "--runs", "1", "--warmup", "0", "--export", "-"], options];
        let ended = sandbox.run(&args.concat());
        assert_ok(&ended);
        json(&ended.stdout)["results"][0]["gmlvm"]["image_hash"].clone()
    };
    assert_eq!(hash_of(&["--dialect", "chicago"]), format!("{hash:016x}"));
    assert_ne!(hash_of(&["--size", "3x3"]), hash_of(&[]));
    assert_ne!(hash_of(&["--region", "0,0,3,3"]), hash_of(&[]));
}

#[test]
fn surfaces_are_benchmarked_alone() {
    let sandbox = sandbox();
    let args = ["bench", "s.gml", "--surfaces", "--runs", "6", "--export", "b.json"];
    let ended = sandbox.run(&args);
    assert_ok(&ended);
    let text = ended.text();
    assert!(text.contains("s.gml: 3 surface functions; 6 rounds"), "{text}");
    assert!(text.contains("\n  s.gml:2:1, constant (found in "), "{text}");
    assert!(text.contains("\n  s.gml:4:1, not compiled: "), "{text}");
    let exported = json(&sandbox.read("b.json"));
    let results = exported["results"].as_array().expect("a list");
    let names: Vec<_> = results.iter().map(|result| result["command"].as_str()).collect();
    let expected = ["s.gml:1:1 interp", "s.gml:1:1 native", "s.gml:2:1 interp", "s.gml:4:1 interp"];
    assert_eq!(names, expected.map(Some));
    let details: Vec<_> = results.iter().map(|result| &result["gmlvm"]).collect();
    let evaluations: Vec<_> = details.iter().map(|details| &details["evaluation"]).collect();
    assert_eq!(evaluations, ["native", "native", "constant", "declined"]);
    assert!(details[3]["reason"].as_str().expect("a reason").contains(" at s.gml:"));
    assert!(number(&details[1]["code_bytes"]) > 0.0 && number(&details[1]["generate"]) > 0.0);
    assert_eq!((&details[1]["points"], &details[1]["failing_points"]), (&json!(1024), &json!(0)));
    assert!(number(&details[1]["ratio_to_first"]["ratio"]) > 0.0);
    assert_eq!((&details[2]["code_bytes"], &details[2]["generate"]), (&Value::Null, &json!(0.0)));
    assert!(results.iter().all(|result| result["times"].as_array().is_some_and(|t| t.len() == 6)));
}

/// Points where a function fails are not timed; and closures that differ in numbers are one.
#[test]
fn surfaces_that_fail_and_surfaces_that_are_alike() {
    let sandbox = Sandbox::new();
    let scene = "{ /k { /v /u /face u v k point 1.0 0.0 1.0 } sphere } /make
        { /v /u /face u 0.5 lessf { 1 0.0 addf } { v } if v v point 1.0 0.0 1.0 } cube
        0.1 make apply union 0.2 make apply union 0.3 make apply union /all
        1.0 1.0 1.0 point [ ] all 1 60.0 6 5 \"b.ppm\" render";
    sandbox.file("s.gml", scene);
    let ended = sandbox.run(&["bench", "s.gml", "--surfaces", "--runs", "1"]);
    assert_ok(&ended);
    let text = ended.text();
    assert!(text.contains("  s.gml:1:6, 3 times\n"), "{text}");
    assert!(text.contains(" of the points"), "{text}");
    sandbox.file("s.gml", scene.replace("u 0.5 lessf", "u 2.0 lessf"));
    let ended = sandbox.run(&["bench", "s.gml", "--surfaces", "--runs", "1"]);
    assert_eq!(ended.code, 0);
    assert!(
        ended.stderr.contains("function at s.gml:2:9 fails wherever it is called"),
        "{}",
        ended.stderr
    );
}

#[test]
fn comparisons_with_another_day() {
    let sandbox = sandbox();
    let bench = ["bench", "s.gml", "--engines", "interp", "--runs", "6"];
    assert_ok(&sandbox.run(&[&bench[..], &["--export", "old.json"]].concat()));
    let exported = json(&sandbox.read("old.json"));
    let time = number(&exported["results"][0]["median"]);
    let against = |factors: [f64; 6], hash: &str| {
        let mut old = exported.clone();
        old["results"][0]["times"] = json!(factors.map(|factor| factor * time));
        old["results"][0]["gmlvm"]["image_hash"] = hash.into();
        sandbox.file("altered.json", old.to_string());
        let ended = sandbox.run(&[&bench[..], &["--compare", "altered.json"]].concat());
        assert_ok(&ended);
        ended.text().rsplit_once("--engine interp -j 1\n    ").expect("it is compared").1.to_owned()
    };
    let hash = exported["results"][0]["gmlvm"]["image_hash"].as_str().expect("text");
    let faster = against([1e6; 6], hash);
    assert!(faster.starts_with("0.000 [") && faster.ends_with("]  faster\n"), "{faster}");
    let slower = against([1e-6; 6], hash);
    assert!(slower.ends_with("]  slower\n"), "{slower}");
    let noise = against([1e-6, 1e6, 1e-6, 1e6, 1e-6, 1e6], "other");
    assert!(noise.ends_with("]  no difference within noise; other images\n"), "{noise}");
}

#[test]
fn comparisons_with_hyperfine_and_with_other_commands() {
    let sandbox = sandbox();
    let hyperfine = json!({ "results": [{
        "command": "gmlvm run ball.gml --engine jit -j 1", "mean": 9.0, "stddev": null,
        "median": 9.0, "user": 1.0, "system": 0.0, "min": 9.0, "max": 9.0, "times": [9.0],
        "exit_codes": [0],
    }]});
    sandbox.file("h.json", hyperfine.to_string());
    let args = ["bench", "ball.gml", "--runs", "1", "--compare", "h.json"];
    let ended = sandbox.run(&args);
    assert_ok(&ended);
    let compared = ended.text().split_once("against h.json").expect("it is compared").1;
    assert_eq!(compared.matches("not measured then").count(), 2, "{compared}");
    assert!(compared.contains("-j 1\n    0.000  too few runs to tell"), "{compared}");
}

#[test]
fn bad_files_to_compare_with_are_errors_that_say_where() {
    let sandbox = sandbox();
    let files = [
        ("{\n  \"results\": [\n    { \"command\": \"x\" }\n] }", "3:22: ", "`times`"),
        ("{\n  \"results\": 5 }", "2:14: ", "expected a sequence"),
        ("{ \"results\": [", "1:14: ", "EOF"),
        ("{\"results\":[\n{\"command\":\"x\",\"times\":[]}]}", "2:", "at least one time"),
        ("{\"results\":[\n{\"command\":\"x\",\"times\":[1.0,0.0]}]}", "2:", "above zero"),
        ("\u{1b}[2J", "1:1: ", "expected value"),
    ];
    for (text, place, reason) in files {
        sandbox.file("old.json", text);
        let ended = sandbox.run(&["bench", "ball.gml", "--compare", "old.json"]);
        assert_eq!((ended.code, ended.text()), (2, ""), "{text}");
        let expected = format!("error: old.json:{place}");
        assert!(ended.stderr.starts_with(&expected), "{text}: {}", ended.stderr);
        assert!(ended.stderr.contains(reason), "{text}: {}", ended.stderr);
    }
    let ended = sandbox.run(&["bench", "ball.gml", "--compare", "none.json"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("cannot read `none.json`"), "{}", ended.stderr);
}

#[test]
fn exit_codes() {
    let table: [(&[&str], i32); 16] = [
        (&["ball.gml", "--runs", "0"], 2),
        (&["ball.gml", "--runs", "2", "--time", "1s"], 2),
        (&["ball.gml", "--time", "0s"], 2),
        (&["ball.gml", "--threads", "0"], 2),
        (&["ball.gml", "--threads", "1,x"], 2),
        (&["ball.gml", "--engines", "fast"], 2),
        (&["ball.gml", "--surfaces", "--engines", "jit"], 2),
        (&[], 2),
        (&["-"], 2),
        (&["none.gml"], 2),
        (&["bad.gml", "ball.gml", "--runs", "1"], 1),
        (&["wrong.gml", "--runs", "1"], 1),
        (&["away.gml", "--runs", "1"], 5),
        (&["ball.gml", "--runs", "1", "--max-pixels", "10"], 4),
        (&["ball.gml", "--runs", "1", "--surfaces", "--max-images", "0"], 4),
        (&["ball.gml", "--runs", "1", "--export", "ball.gml/x"], 3),
    ];
    for (args, code) in table {
        let sandbox = sandbox();
        sandbox.file("bad.gml", "{").file("away.gml", ball("../a.ppm"));
        sandbox.file("wrong.gml", ball("a.ppm").replace("1.0 0.0 1.0", "1.0 0.0"));
        let before = sandbox.files();
        let ended = sandbox.run(&[&["bench"], args].concat());
        assert_eq!(ended.code, code, "{args:?}: {}", ended.stderr);
        assert!(!ended.stderr.is_empty(), "{args:?}");
        assert_eq!(sandbox.files(), before, "{args:?}");
    }
}

/// A scene that fails does not keep others from being measured and exported.
#[test]
fn the_rest_is_measured() {
    let sandbox = sandbox();
    sandbox.file("bad.gml", "{");
    let args = ["bench", "bad.gml", "ball.gml", "--time", "1ms", "--export", "b.json"];
    let ended = sandbox.run(&args);
    assert_eq!(ended.code, 1);
    assert!(ended.stderr.contains(" --> bad.gml:1:1"), "{}", ended.stderr);
    assert!(ended.text().contains("ball.gml: 1 image"), "{}", ended.text());
    assert_eq!(json(&sandbox.read("b.json"))["results"].as_array().map(Vec::len), Some(3));
}

/// A function that never ends stops at its fuel, and is not asked for all of its points.
#[test]
fn surfaces_that_never_end() {
    let sandbox = Sandbox::new();
    let scene = "{ /self self self apply } /f { /v /u /face f f apply } sphere /s
        1.0 1.0 1.0 point [ ] s 1 60.0 6 5 \"b.ppm\" render";
    sandbox.file("s.gml", scene);
    let args = ["bench", "s.gml", "--surfaces", "--runs", "1", "--fuel", "100000000"];
    let ended = sandbox.run(&args);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stderr.contains("fails wherever it is called"), "{}", ended.stderr);
}
