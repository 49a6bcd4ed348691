//! The stability suite holds its bounds with every engine, and breaks a naive renderer.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use serde_json::Value;

use crate::gmlvm::Sandbox;

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// The table of `docs/stability.md`, between these lines.
const MARKS: [&str; 2] = ["<!-- cases -->\n", "<!-- /cases -->"];

/// What `gmlvm stability --json` says of the cases.
static CASES: LazyLock<Vec<Value>> = LazyLock::new(|| {
    let ended = Sandbox::new().run(&["stability", "--json"]);
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""));
    let table: Value = serde_json::from_slice(&ended.stdout).expect("JSON");
    table["cases"].as_array().expect("an array").clone()
});

fn text<'c>(case: &'c Value, field: &str) -> &'c str {
    case[field].as_str().expect("text")
}

fn number(case: &Value, field: &str) -> u64 {
    case[field].as_u64().expect("a number")
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn all_cases_are_within_their_bounds_with_both_engines_in_both_precisions() {
    assert!(CASES.len() >= 40, "{}", CASES.len());
    for case in &*CASES {
        let ours = case["ours"].as_array().expect("an array");
        let methods: Vec<_> = ours.iter().map(|ours| text(ours, "method")).collect();
        assert_eq!(methods, ["interp", "jit", "interp dd", "jit dd"]);
        for ours in ours {
            assert!(number(ours, "error") <= number(case, "bound"), "{case}");
        }
        assert!(number(case, "pixels") <= 64 * 48 * 12, "{case}");
    }
}

#[test]
fn a_naive_renderer_fails_two_cases_of_three() {
    let fails = |case: &&Value| number(case, "naive") > number(case, "bound");
    let n_failed = CASES.iter().filter(fails).count();
    assert!(3 * n_failed >= 2 * CASES.len(), "{n_failed} of {}", CASES.len());
}

#[test]
fn every_scene_is_a_case_and_says_what_it_provokes() {
    let mut names: Vec<_> =
        CASES.iter().map(|case| format!("{}.gml", text(case, "name"))).collect();
    names.push("common.gml".to_owned());
    names.sort();
    let folder = root().join("tests/stability");
    let files = fs::read_dir(&folder).expect("a folder");
    let mut files: Vec<_> =
        files.map(|file| file.expect("readable").file_name().display().to_string()).collect();
    files.sort();
    assert_eq!(files, names);
    for file in files {
        let scene = fs::read_to_string(folder.join(&file)).expect("text");
        let head: Vec<_> = scene.lines().take_while(|line| line.starts_with('%')).collect();
        assert!(file == "common.gml" || head.len() >= 3, "{file}: {head:?}");
    }
}

/// The same text for people has a line for each case.
#[test]
fn the_table_has_a_line_for_each_case_and_engine() {
    let ended = Sandbox::new().run(&[
        "stability",
        "--engines",
        "auto",
        "--precisions",
        "f64,certified",
        "-j",
        "2",
    ]);
    let lines: Vec<_> = ended.text().lines().collect();
    assert_eq!((ended.code, lines.len()), (0, CASES.len() + 2));
    assert!(lines[0].starts_with("case ") && lines[0].contains(" auto "));
    for (line, case) in lines[1..].iter().zip(&*CASES) {
        assert!(line.starts_with(text(case, "name")) && line.ends_with(text(case, "failure")));
    }
    let sum = format!("{0} of {0} cases are within their bounds", CASES.len());
    assert!(lines[CASES.len() + 1].starts_with(&sum));
}

#[test]
fn the_documentation_shows_the_table() {
    let path: PathBuf = root().join("docs/stability.md");
    let page = fs::read_to_string(&path).expect("text");
    let (before, rest) = page.split_once(MARKS[0]).expect("a mark");
    let (shown, after) = rest.split_once(MARKS[1]).expect("a mark");
    let table = table();
    if without_naive(shown) != without_naive(&table) {
        assert!(
            std::env::var_os("GMLVM_BLESS").is_some(),
            "docs/stability.md does not show the table; GMLVM_BLESS=1 corrects it"
        );
        let page = format!("{before}{}{table}{}{after}", MARKS[0], MARKS[1]);
        fs::write(path, page).expect("written");
    }
}

fn table() -> String {
    let mut table =
        "| case | pixels | naive | interp | jit | interp dd | jit dd | bound | what fails |\n\
         | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |\n"
            .to_owned();
    for case in &*CASES {
        let name = text(case, "name");
        let ours = case["ours"].as_array().expect("an array");
        let errors: Vec<String> = ours.iter().map(|ours| ours["error"].to_string()).collect();
        writeln!(
            table,
            "| [`{name}`](../tests/stability/{name}.gml) | {} | {} | {} | {} | {} |",
            case["pixels"],
            case["naive"],
            errors.join(" | "),
            case["bound"],
            text(case, "failure").replace('^', "\\^")
        )
        .expect("a string takes all");
    }
    table
}

/// A table without the naive renderer's column, which depends on the system's sines.
fn without_naive(table: &str) -> String {
    let mut kept = String::new();
    for line in table.lines() {
        let cells = line.split('|').enumerate().filter(|(index, _)| *index != 3);
        kept.extend(cells.map(|(_, cell)| cell));
        kept.push('\n');
    }
    kept
}
