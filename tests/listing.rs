//! `gmlvm disasm` on surface functions: what they were compiled to, and where that comes from.

use std::collections::BTreeSet;

use support::gmlvm::Sandbox;

mod support {
    #[allow(
        dead_code,
        unreachable_pub,
        reason = "shared with the fuzz targets, where it is public"
    )]
    pub(crate) mod generator;
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod gmlvm;
}

/// Two balls of one function and different colours, one that picks a function by its face, one that
/// is the same everywhere, and one whose recursion makes values
/// of another type at each level, so that it is not compiled.
const SCENE: &str = "\
[ { /x x 2.5 mulf } { sin } { 1.0 addf } { /x x x mulf } ] /functions
{ /share /color { /v /u /face color  u share mulf  0.25  1.0 } } /tinted
{ /v /u /face functions face get /f u f apply v 0.5 point 1.0 0.0 1.0 } /picked
{ /v /u /face 1.0 0.5 0.25 point 1.0 0.0 9.0 } /plain
{ /self /n n 0 eqi { 1 } { [ n 1 subi self self apply ] } if } /nest
{ /v /u /face u floor nest nest apply /nested 1.0 1.0 1.0 point 1.0 0.0 1.0 } /recursive
1.0 0.0 0.5 point 0.75 tinted apply sphere
0.0 1.0 0.5 point 0.5 tinted apply sphere union
picked sphere union  plain plane union  recursive cone union /all
0.5 0.5 0.5 point [] all 1 90.0 4 3 \"a.ppm\" render
0.5 0.5 0.5 point [] plain sphere 1 90.0 4 3 \"b.ppm\" render
";

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", SCENE);
    sandbox
}

fn show(sandbox: &Sandbox, args: &[&str]) -> String {
    let ended = sandbox.run(&[&["disasm", "s.gml"], args].concat());
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""), "{args:?}");
    ended.text().to_owned()
}

#[test]
fn surfaces_are_listed_with_what_they_captured() {
    let sandbox = sandbox();
    let text = show(&sandbox, &["--emit", "clif"]);
    let heads: Vec<_> = text.lines().filter(|line| line.starts_with("surface")).collect();
    assert_eq!(heads.len(), 5, "{heads:?}");
    assert!(heads[0].starts_with("surfaces 0-1: function 4, s.gml:2:17: native, "), "{heads:?}");
    assert!(
        heads[1].starts_with("surface 2: function 6 `picked`, s.gml:3:1: native, "),
        "{heads:?}"
    );
    let constant = "constant, color (1.0 0.5 0.25), kd 1.0, ks 0.0, n 9.0";
    assert_eq!(heads[2], format!("surface 3: function 7 `plain`, s.gml:4:1: {constant}"));
    assert!(heads[3].starts_with("surface 4: function 9 `recursive`, s.gml:6:1: interpreted: "));
    assert!(heads[3].contains(" at s.gml:6:"), "{heads:?}");
    assert_eq!(heads[4], format!("surface 5: function 7 `plain`, s.gml:4:1: {constant}"));
    let details = "\
  uniform 0: real color.x = 1.0
  uniform 1: real color.y = 0.0
  uniform 2: real color.z = 0.5
  uniform 3: real share = 0.75
  reads: u
  known results: red = uniform 0, green = uniform 1, blue = uniform 2, ks = 0.25, n = 1.0
";
    assert!(text.contains(details), "{text}");
    // Of the other ball, its own values.
    let other = show(&sandbox, &["--surface", "1"]);
    assert!(other.starts_with("surface 1: "), "{other}");
    assert!(other.contains("uniform 1: real color.y = 1.0\n"), "{other}");
    let multiplied = other.lines().find(|line| line.contains("fmul.f64"));
    assert!(multiplied.is_some_and(|line| line.ends_with("; 2:46")), "{multiplied:?}");
}

#[test]
fn machine_code_is_listed_beside_its_source() {
    let sandbox = sandbox();
    let text = show(&sandbox, &["--emit", "asm", "--surface", "2"]);
    if !cfg!(target_arch = "x86_64") {
        return;
    }
    let placed = |part: &str, place: &str| {
        let found =
            text.lines().filter(|line| line.contains(part)).any(|line| line.ends_with(place));
        assert!(found, "{part} {place} in {text}");
    };
    placed("cmp rsi, 4", "; 3:30");
    placed("table L", "; 3:41");
    placed("mov rax, sin", "; 1:23");
    placed("mulsd xmm0, xmm0, xmm0", "; 1:51");
    assert!(text.contains("   1 | [ { /x x 2.5 mulf } { sin }"), "{text}");
    assert!(text.lines().any(|line| line.contains("; 2.5") && line.ends_with("; 1:14")), "{text}");
    // Without what is different in each run.
    assert_eq!(text, show(&sandbox, &["--emit", "asm", "--surface", "2"]));
}

/// Every byte of random functions decodes to an instruction or a table, and every jump leads to a
/// label.
#[test]
fn all_machine_code_is_understood() {
    if !cfg!(target_arch = "x86_64") {
        return;
    }
    let sandbox = Sandbox::new();
    let (mut n_lines, mut n_tables) = (0, 0);
    for seed in 0..60 {
        let function = support::generator::program(&mut support::generator::Random::new(seed));
        let scene =
            format!("{function} /s 0.5 0.5 0.5 point [] s sphere 1 90.0 2 2 \"a.ppm\" render\n");
        let ended = sandbox.run_with(&["disasm", "-", "--emit", "asm"], scene.as_bytes());
        let Some((_, code)) = ended.text().split_once("\nasm:\n") else { continue };
        let (mut used, mut defined) = (BTreeSet::new(), BTreeSet::new());
        let mut last_offset = None;
        for line in code.lines() {
            let text = line.split(" ; ").next().expect("a part").trim();
            if let Some(label) = text.strip_suffix(':') {
                if label.starts_with("routine") || label == "shader" {
                    assert_eq!(used, defined, "{code}");
                    (used, defined, last_offset) = (BTreeSet::new(), BTreeSet::new(), None);
                    continue;
                }
                assert!(defined.insert(label), "{code}");
                continue;
            }
            let Some((offset, text)) = text.split_once("      ") else { continue };
            let offset = u32::from_str_radix(offset, 16).expect("an offset");
            assert!(last_offset.is_none_or(|last| last < offset), "{code}");
            assert!(!text.contains("(bad)"), "{code}");
            last_offset = Some(offset);
            n_lines += 1;
            n_tables += usize::from(text.starts_with("table "));
            let words = text.split([' ', ',']);
            let is_label = |word: &&str| {
                word.strip_prefix('L').is_some_and(|number| number.parse::<u32>().is_ok())
            };
            used.extend(words.filter(is_label));
        }
        assert_eq!(used, defined, "{code}");
    }
    assert!(n_lines > 1000 && n_tables > 2, "{n_lines} lines, {n_tables} tables");
}

/// Recursion that is no loop is a function of its own, which is called by its name.
#[test]
fn routines_are_listed_before_what_calls_them() {
    let scene = "\
{ /self /x x 0.1 lessf { 1.0 } { x 0.5 mulf self self apply x mulf } if } /f
{ /v /u /face u f f apply /g g g g point 1.0 0.0 1.0 } /s
1.0 1.0 1.0 point [] s sphere 0 90.0 2 2 \"a.ppm\" render
";
    let sandbox = Sandbox::new();
    let ended = sandbox.run_with(&["disasm", "-", "--emit", "clif,asm"], scene.as_bytes());
    let labels: Vec<&str> = ended.text().lines().map(str::trim).collect();
    let places = |label: &str| -> Vec<usize> {
        let here = |(place, line): (usize, &&str)| (*line == label).then_some(place);
        labels.iter().enumerate().filter_map(here).collect()
    };
    let (routine, shader) = (places("routine0:"), places("shader:"));
    assert_eq!((routine.len(), shader.len()), (2, 2), "{}", ended.text());
    assert!(routine[0] < shader[0] && shader[0] < routine[1] && routine[1] < shader[1]);
    if cfg!(target_arch = "x86_64") {
        assert_eq!(ended.text().matches("mov rax, routine0").count(), 2, "{}", ended.text());
    }
}

#[test]
fn listings_are_of_what_is_asked_for() {
    let sandbox = sandbox();
    let surface = show(&sandbox, &["--surface", "2"]);
    for part in ["\nfunction 6 `picked`, 3:1:\n", "\nclif:\n", "\nasm:\n"] {
        assert!(surface.contains(part), "{part:?} in {surface}");
    }
    assert!(!surface.contains("main program"), "{surface}");
    let bytecode = show(&sandbox, &["--surface", "2", "--emit", "bytecode"]);
    assert!(surface.starts_with(bytecode.trim_end()) && bytecode.len() < surface.len());
    let by_name = show(&sandbox, &["--function", "picked", "--emit", "bytecode,clif,asm"]);
    assert_eq!(by_name, surface);
    let all = show(&sandbox, &["--emit", "tokens,bytecode,clif,asm"]);
    assert!(all.contains("binder         /share") && all.contains(&surface), "{all}");
    let args = ["disasm", "-", "--emit", "tokens,bytecode,clif,asm"];
    let from_stdin = sandbox.run_with(&args, SCENE.as_bytes());
    assert_eq!(from_stdin.text().replace("<stdin>", "s.gml"), all);
    for args in [&["--surface", "6"][..], &["--function", "none"], &["--function", "99"]] {
        let ended = sandbox.run(&[&["disasm", "s.gml"], args].concat());
        assert_eq!(ended.code, 2, "{args:?}");
        assert!(ended.stderr.contains("there is no "), "{}", ended.stderr);
    }
}

/// `run -v` numbers surfaces as `--surface` does, through all images.
#[test]
fn run_names_the_same_numbers() {
    let sandbox = sandbox();
    let ended = sandbox.run(&["-v", "s.gml", "--engine", "jit"]);
    let lines: Vec<_> = ended.stderr.lines().filter(|line| line.starts_with("surface")).collect();
    assert_eq!(lines.len(), 4, "{lines:?}");
    assert!(lines[0].starts_with("surfaces 0-1 at s.gml:2:17: native, "), "{lines:?}");
    assert_eq!(lines[2], "surfaces 3, 5 at s.gml:4:1: constant");
    assert!(lines[3].starts_with("surface 4 at s.gml:6:1: interpreted: "), "{lines:?}");
}

#[test]
fn pages_are_written_whole_or_not_at_all() {
    let sandbox = sandbox();
    let ended = sandbox.run(&["disasm", "s.gml", "--html", "-", "--surface", "2"]);
    assert!(ended.code == 0 && ended.text().starts_with("<!doctype html>"), "{}", ended.stderr);
    assert!(ended.text().contains("surface 2: ") && !ended.text().contains("surface 3: "));
    for (args, code) in [
        (&["--html", "a.html", "--surface", "6"][..], 2),
        (&["--html", "a.html", "--emit", "asm"], 2),
        (&["--html", "a.html", "--fuel", "10"], 4),
        (&["--html", "s.gml/a.html"], 3),
    ] {
        let ended = sandbox.run(&[&["disasm", "s.gml"], args].concat());
        assert_eq!((ended.code, ended.text()), (code, ""), "{args:?}: {}", ended.stderr);
    }
    assert_eq!(sandbox.files(), ["s.gml"]);
    sandbox.file("a.html", "before");
    show(&sandbox, &["--html", "a.html"]);
    assert!(sandbox.read("a.html").starts_with(b"<!doctype html>"));
}

#[test]
fn what_programs_do_wrong_is_reported() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", format!("{SCENE} 1 2.0 addi"));
    let ended = sandbox.run(&["disasm", "s.gml", "--emit", "asm"]);
    assert_eq!(ended.code, 1);
    assert!(ended.text().contains("surface 5: "), "{}", ended.text());
    assert!(ended.stderr.contains("E02"), "{}", ended.stderr);
    let ended = sandbox.run(&["disasm", "s.gml", "--surface", "0", "--fuel", "10"]);
    assert_eq!(ended.code, 4, "{}", ended.stderr);
}
