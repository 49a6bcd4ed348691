//! The language corpus: `tests/lang/*.gml`, one program a line, with the stack it leaves or the
//! error it ends with. A line is `PROGRAM %! STACK` or `PROGRAM %! error CODE at COLUMN`; lines
//! that start with `%` are comments.

#[path = "support/lang.rs"]
mod support;

use support::outcome;

#[track_caller]
fn check_corpus(file: &str, min_cases: usize) {
    let path = format!("{}/tests/lang/{file}", env!("CARGO_MANIFEST_DIR"));
    let corpus = std::fs::read_to_string(&path).expect("the corpus is part of the project");
    let mut failures = Vec::new();
    let mut n_cases = 0;
    for (idx, line) in corpus.lines().enumerate() {
        if line.starts_with('%') || line.trim().is_empty() {
            continue;
        }
        let (program, expected) = line.split_once("%!").expect("every case says what it expects");
        n_cases += 1;
        let got = outcome(program.trim_end());
        if got != expected.trim() {
            failures.push(format!(
                "{file}:{}: {program}\n  expected {expected}\n  got       {got}",
                idx + 1
            ));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(n_cases >= min_cases, "only {n_cases} cases in {file}");
}

#[test]
fn arithmetic() {
    check_corpus("arithmetic.gml", 80);
}

#[test]
fn rounds() {
    check_corpus("rounds.gml", 12);
}

#[test]
fn functions() {
    check_corpus("functions.gml", 70);
}

#[test]
fn memory() {
    check_corpus("memory.gml", 10);
}

#[test]
fn data() {
    check_corpus("data.gml", 75);
}

#[test]
fn operands() {
    check_corpus("operands.gml", 144);
}

#[test]
fn lexical_rules() {
    check_corpus("lexical.gml", 60);
}

/// Code beyond what registers hold: hundreds of bindings, pending operands and nested arrays.
#[test]
fn crowded_functions_spill() {
    let names: Vec<String> = (0..600).map(|n| format!("n{}", letters(n))).collect();
    let bind: String =
        names.iter().enumerate().map(|(n, name)| format!("{n} x addi /{name} ")).collect();
    let uses = names.join(" ");
    let sums = "addi ".repeat(599);
    let expected: i64 = (0..600).map(|n| n + 1).sum();
    assert_eq!(
        outcome(&format!("{{ /x {bind} {uses} {sums} }} /f 1 f apply")),
        expected.to_string()
    );
    let array =
        format!("{{ /x {bind} [ {uses} [ {uses} ] ] }} /f 1 f apply /a a length a 600 get 599 get");
    assert_eq!(outcome(&array), "601 600");
    let capture = format!("{{ /x {bind} {{ {uses} {sums} }} }} /f 1 f apply apply");
    assert_eq!(outcome(&capture), expected.to_string());
    let branch = format!(
        "{{ /c /x {bind} x c {{ {uses} {sums} }} {{ 7 }} if }} /f 1 true f apply 1 false f apply"
    );
    assert_eq!(outcome(&branch), format!("1 {expected} 1 7"));
}

/// A binding is used as often as a program has words.
#[test]
fn uses_beyond_sixteen_bits() {
    let n = 1 << 16;
    let uses = "x ".repeat(n - 1);
    let program = format!("{{ /x {uses} x 1 addi /y x }} /f [ 7 f apply ] /a a length a 0 get");
    assert_eq!(outcome(&program), format!("{n} 7"));
}

/// What both sides of a condition leave finds places beside any number of bindings.
#[test]
fn sides_meet_beside_many_bindings() {
    for n in 180..256 {
        let names: Vec<String> = (0..n).map(|n| format!("p{n}")).collect();
        let binders: String = names.iter().rev().map(|name| format!("/{name} ")).collect();
        let values =
            |range: std::ops::Range<u32>| -> String { range.map(|n| format!("{n} ")).collect() };
        let (yes, no) = (values(0..64), values(1..65));
        let (arguments, uses) = (values(0..n), names.join(" "));
        for (a, b) in [(&yes, &no), (&no, &yes)] {
            let program = format!(
                "{{ {binders} p0 1 addi /s p1 p2 lessi {{ {a} }} {{ s s {b} }} if addi {uses} s }} /f \
                 [ {arguments} f apply ] /r r length r 0 get r 61 get r 62 get"
            );
            let expected = a.split_whitespace().collect::<Vec<_>>();
            let sum: u32 = expected[62..].iter().map(|n| n.parse::<u32>().expect("a number")).sum();
            assert_eq!(
                outcome(&program),
                format!("{} {} {} {sum}", 63 + n + 1, expected[0], expected[61]),
                "{n}"
            );
        }
    }
}

/// Captured values count as instructions when a closure is made: they take as long.
#[test]
fn captured_values_take_fuel() {
    let names: Vec<String> = (0..1000).map(|n| format!("a{n}")).collect();
    let binders: String = names.iter().map(|name| format!("/{name} ")).collect();
    let (ones, uses) = ("1 ".repeat(1000), names.join(" "));
    // Each round has some ten instructions, but makes a closure of a thousand values.
    let program = format!(
        "{{ {binders} {{ /self /n n 0 eqi {{ }} {{ {{ {uses} }} /g n 1 subi self self apply }} if }} }} /f \
         {ones} f apply /loop"
    );
    assert_eq!(outcome(&format!("{program} 1000 loop loop apply")), "");
    let ended = outcome(&format!("{program} 60000 loop loop apply"));
    assert!(ended.starts_with("error E0401"), "{ended}");
}

fn letters(mut n: usize) -> String {
    let mut name = String::new();
    loop {
        name.push(char::from(b'a' + (n % 26) as u8));
        n /= 26;
        if n == 0 {
            return name;
        }
    }
}

/// What a program may use up is limited, and each limit is an error of its own.
#[test]
fn limits_are_errors() {
    let cases = [
        ("{ /self self self apply } /loop loop loop apply", "error E0401 at 19"),
        ("{ /self /n n 1 addi self self apply } /count 1 count count apply", "error E0401 at 31"),
        (
            "{ /self /a /b /c a b c self self apply } /turn 1 2 3 turn turn apply",
            "error E0401 at 34",
        ),
        ("{ /self self self apply 1 } /loop loop loop apply", "error E0402 at 19"),
        (
            "{ /self /a [ a a a a a a a a ] self self apply } /grow 1 grow grow apply",
            "error E0403 at 42",
        ),
        ("{ /self 1 2 3 4 5 6 7 8 9 self self apply } /push push push apply", "error E0403 at 37"),
        ("{ /self /a 1 a self self apply } /grow 0 grow grow apply", "error E0403 at 26"),
        ("{ /self /n n n self self apply } /deep 1 deep deep apply", "error E0403 at 26"),
    ];
    for (program, expected) in cases {
        assert_eq!(outcome(program), expected, "{program}");
    }
}

/// Deep data is built, printed and dropped without native recursion.
#[test]
fn deep_data_needs_no_native_stack() {
    let run = || {
        let deep = "{ /self /n /a n 0 eqi { a length } { [ a ] n 1 subi self self apply } if } /f [] 1000000 f f apply";
        assert_eq!(outcome(deep), "1");
        let deep = "{ /self /n /o n 0 eqi { o } { o { /v /u /face o } sphere union n 1 subi self self apply } if } /f \
                    { } sphere 300000 f f apply";
        assert_eq!(outcome(deep), "<object>");
    };
    let thread = std::thread::Builder::new().stack_size(512 << 10).spawn(run);
    thread.expect("a thread").join().expect("no overflow");
}
