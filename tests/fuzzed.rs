//! The properties of the fuzz targets for lexer, parser and compiler, on programs that are nearly those
//! of `scenes/` and `tests/lang`, and on what fuzzing has found (`fuzz/finds`).
//!
//! `GMLVM_FUZZ_INPUTS` says how many inputs each property is tried with, `GMLVM_FUZZ_SEED` which.

use std::path::Path;

use support::finds::{self, files};
use support::generator::Random;
use support::sources::{compiles, lexes, parses};

#[allow(unreachable_pub, reason = "shared with the fuzz targets, where it is public")]
mod support {
    pub(crate) mod finds;
    #[allow(dead_code, reason = "it serves several test programs")]
    pub(crate) mod generator;
    pub(crate) mod sources;
}

/// The longest piece of a scene that is changed: short ones are changed more in the same time.
const MAX_PIECE: u64 = 2000;

/// Pieces of text that mean something, and bytes that mean trouble.
const WORDS: [&str; 44] = [
    "{",
    "}",
    "[",
    "]",
    "/",
    "/x",
    "x",
    "\"",
    "\"a\"",
    "%",
    "#",
    "\n#if ",
    "\n#ifdef x\n",
    "\n#else\n",
    "\n#endif\n",
    "\n#include \"a\"\n",
    "\n#define x\n",
    "\n",
    "\r",
    "\t",
    "\0",
    "\u{ff}",
    "\u{2028}",
    "9223372036854775807",
    "-9223372036854775808",
    "99999999999999999999",
    "1e999",
    "-0.0",
    "1.",
    ".5",
    "1e",
    "true",
    "if",
    "apply",
    "get",
    "render",
    "union",
    "sphere",
    "addi",
    "divi",
    "point",
    "length",
    "real",
    "light",
];

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// A piece of a scene with some changes.
fn changed(seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let piece = |random: &mut Random| {
        let seed = &seeds[random.below(seeds.len() as u64) as usize];
        let from = random.below(seed.len() as u64 + 1) as usize;
        let to = from + random.below(MAX_PIECE.min((seed.len() - from) as u64) + 1) as usize;
        seed[from..to].to_vec()
    };
    let mut bytes = piece(random);
    for _ in 0..random.below(8) {
        let from = random.below(bytes.len() as u64 + 1) as usize;
        let to = from + random.below(30.min((bytes.len() - from) as u64) + 1) as usize;
        let new = match random.below(4) {
            0 => Vec::new(),
            1 => vec![random.below(256) as u8],
            2 => WORDS[random.below(WORDS.len() as u64) as usize].as_bytes().to_vec(),
            _ => bytes[from..to].repeat(2),
        };
        bytes.splice(from..to, new);
    }
    bytes
}

fn hold(property: fn(&[u8]), target: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let seeds = ["scenes", "tests/lang"].map(|folder| files(&root.join(folder))).concat();
    assert!(seeds.len() > 20, "there are scenes");
    let check = |bytes: &[u8]| {
        let held = std::panic::catch_unwind(|| property(bytes));
        assert!(held.is_ok(), "it does not hold for {:?}", String::from_utf8_lossy(bytes));
    };
    seeds.iter().chain(&finds::of(target)).for_each(|seed| check(seed));
    let mut random = Random::new(number("GMLVM_FUZZ_SEED", 1));
    for _ in 0..number("GMLVM_FUZZ_INPUTS", 3000) {
        check(&changed(&seeds, &mut random));
    }
}

#[test]
fn tokens_alone_are_the_same_tokens() {
    hold(lexes, "lexer");
}

#[test]
fn trees_are_their_tokens() {
    hold(parses, "parser");
}

#[test]
fn programs_compile_and_run_or_say_why_not() {
    hold(compiles, "compiler");
}

/// Finds elsewhere than in the directory of a target would be tried by nobody.
#[test]
fn finds_are_those_of_targets() {
    let names = std::fs::read_dir(finds::directory()).expect("a directory");
    for name in names.map(|entry| entry.expect("readable").file_name()) {
        let tried = ["lexer", "parser", "compiler", "engines", "parts", "paths"];
        assert!(tried.iter().any(|target| name == *target), "no test tries those of {name:?}");
    }
}
