//! What the user sees of every diagnostic: `tests/diagnostics/CODE.txt` holds the command, what it
//! writes to the standard error, and its exit code. `GMLVM_BLESS=1` rewrites the files.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use compiler::diagnostic::Code;

use crate::gmlvm::Sandbox;

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// Runs a scene, with other files around it and with options, and compares what comes of it.
#[track_caller]
fn check_with(name: &str, scene: &str, files: &[(&str, &str)], options: &[&str]) {
    let sandbox = Sandbox::new();
    sandbox.file("scene.gml", scene);
    for (file, contents) in files {
        sandbox.file(file, contents);
    }
    let before = sandbox.files();
    let args = [&["run", "scene.gml"], options].concat();
    let ended = sandbox.run(&args);
    assert_eq!(sandbox.files(), before, "{name} leaves something behind");
    assert!(ended.stderr.contains(&name[..5]), "{name}: {}", ended.stderr);
    golden(name, &format!("$ gmlvm {}\n{}exit {}\n", args.join(" "), ended.stderr, ended.code));
}

#[track_caller]
fn check(name: &str, scene: &str) {
    check_with(name, scene, &[], &[]);
}

fn directory() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/diagnostics")
}

#[track_caller]
fn golden(name: &str, text: &str) {
    let path = directory().join(format!("{name}.txt"));
    if std::env::var_os("GMLVM_BLESS").is_some() {
        fs::create_dir_all(directory()).expect("a directory");
        return fs::write(&path, text).expect("a golden file");
    }
    let expected = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        text == expected,
        "{name}: got\n{text}\nexpected\n{expected}\nGMLVM_BLESS=1 accepts what it is now"
    );
}

#[test]
fn lexical_errors() {
    check("E0001", "1 2 + % a plus sign");
    check("E0001-escape", "1 \u{1b}[2J 2");
    check("E0002", "\"never ends\n1");
    check("E0003", "1 99999999999999999999 1e999");
    check("E0004", "1 / x");
    check("E0005", "{ /addi }");
}

#[test]
fn brackets() {
    check("E0006", "[ [ { ] } ]");
    check("E0007", "1 { /x x\n  { /y y }\napply\n");
    check("E0008", &"{ ".repeat(600));
}

#[test]
fn preprocessor_errors() {
    check("E0009", "#if FOO\n1\n#endif\n");
    check("E0010", "#include \"missing.ins\"\n");
    check("E0010-outside", "#include \"../secret\"\n");
    check_with(
        "E0011",
        "#include \"a.ins\"\n",
        &[("a.ins", "#include \"b.ins\"\n"), ("b.ins", "#include \"a.ins\"\n")],
        &[],
    );
    check("E0012", "1 /* never ends\n2\n");
    check_with("E0102-included", "#include \"a.ins\"\nf apply", &[("a.ins", "{ g } /f\n")], &[]);
}

#[test]
fn too_much_text() {
    check("E0013", &" ".repeat(64 << 20));
}

#[test]
fn stack_and_names() {
    check("E0101", "5 [ 1 addi ]");
    check("E0101-binder", "1 /x\n/y");
    check("E0102", "0.4 /radius\n1 /n\n\n% a snow man\n{ n\n  raduis 2.0 divf } /f\nf apply\n");
    check("E0102-operator", "{ } shpere");
    check("E0102-elsewhere", "{ 1 /a a } apply a addi");
    check("E0102-nothing", "zzz");
}

#[test]
fn types() {
    check("E0201", "3 /n\n  n 0.5 addi\n");
    check("E0201-long-line", &format!("{} 1 0.5 addi {}", "1 ".repeat(400), "2 ".repeat(400)));
    check(
        "E0203",
        "0.5 0.5 0.5 point []\n{ /v /u /face\n  1.0 0.2 0.2 point 1.0 0.3\n} sphere\n0 60.0 9 9 \
         \"a.ppm\" render\n",
    );
}

#[test]
fn arithmetic() {
    check("E0301", "9223372036854775807 1 addi");
    check("E0302", "{ 1 0 divi } apply");
    check("E0303", "-1.0 sqrt");
    check("E0304", "[ 1 2 3 ] 3 get");
    check("E0305", "1.0 0.0 divf floor");
}

const BALL: &str = "0.5 0.5 0.5 point [] { /v /u /face 1.0 1.0 1.0 point 1.0 0.0 1.0 } sphere";

#[test]
fn rendering() {
    check("E0306", "{ } sphere 1.0 0.0 1.0 scale");
    check("E0307", &format!("{BALL} 0 180.0 9 9 \"a.ppm\" render"));
    check("E0307-light", "0.5 0.5 0.5 point [ 1 ] { } sphere 0 60.0 9 9 \"a.ppm\" render");
    check(
        "E0308",
        "0.5 0.5 0.5 point [] { /v /u /face\n  v v v point [] { } sphere 0 60.0 9 9 \"b.ppm\" \
         render\n} sphere 0 60.0 9 9 \"a.ppm\" render",
    );
    check(
        "E0304-surface",
        "[ 1.0 ] /table\n0.5 0.5 0.5 point [] { /v /u /face\n  table u 2.0 mulf floor get /c\n  c c \
         c point 1.0 0.0 1.0\n} sphere 0 60.0 9 9 \"a.ppm\" render",
    );
}

#[test]
fn limits() {
    let recursion =
        "{ /self /n\n  n 0 eqi { 1 }\n  { n 1 subi self self apply n muli } if\n} /fact\n";
    let endless = format!("{recursion}-1 fact fact apply");
    check_with(
        "E0401",
        "{ /self self self apply } /loop loop loop apply",
        &[],
        &["--fuel", "9999"],
    );
    check_with("E0402", &endless, &[], &["--max-depth", "10000"]);
    check_with(
        "E0403",
        "{ /self /a\n  [ a a a ] self self apply\n} /grow 1 grow grow apply",
        &[],
        &["--max-memory", "1M"],
    );
    check_with(
        "E0405",
        "{ /self self self apply } /loop loop loop apply",
        &[],
        &["--timeout", "200ms", "--fuel", "1000000000000000"],
    );
    let ball = format!("{BALL} 0 60.0 100 200 \"a.ppm\" render");
    check_with("E0404", &ball, &[], &["--max-pixels", "10000"]);
    check_with("E0404-images", &ball, &[], &["--max-images", "0"]);
    check("E0404-depth", &format!("{BALL} 2000000000 60.0 9 9 \"a.ppm\" render"));
    let doubling =
        format!("{BALL} /s {} s 0 60.0 9 9 \"a.ppm\" render", "s s union /s ".repeat(40));
    check("E0404-solids", &doubling);
}

#[test]
fn files() {
    check("E0501", &format!("{BALL} 0 60.0 9 9 \"../../.ssh/authorized_keys\" render"));
    let ball = format!("{BALL} 0 60.0 9 9 \"a.ppm\" render");
    check_with("E0601", &ball, &[("a.ppm/in-the-way", "")], &[]);
    check_with("E0601-parent", &ball, &[("out", "")], &["-o", "out"]);
}

/// The one diagnostic that would take gigabytes to provoke is rendered by a test of the driver.
#[test]
fn every_code_has_a_snapshot() {
    let have: BTreeSet<String> = fs::read_dir(directory())
        .expect("the snapshots are part of the project")
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.get(..5).map(str::to_owned))
        .collect();
    let want: BTreeSet<String> = Code::ALL.iter().map(|code| code.as_str().to_owned()).collect();
    assert_eq!(have, want);
}
