//! Names against what the compiler makes of them, and in words.

use super::*;
use crate::bytecode::{Constant, Opcode};
use crate::preprocess::testing::tokens_of;
use crate::preprocess::{NoIncludes, tokens_and_errors};
use crate::source::SourceMap;

/// Tokens of any text, and the map that holds it.
fn read(text: &str) -> (SourceMap, Vec<Token>) {
    let mut sources = SourceMap::default();
    let root = sources.add("a", text.as_bytes().to_vec()).unwrap();
    let (tokens, _) = tokens_and_errors(&mut sources, root, &mut NoIncludes);
    (sources, tokens)
}

fn column(sources: &SourceMap, span: Span) -> usize {
    sources.file_of(span).map_or(0, |file| file.line_column(span).column)
}

/// Each use as `name column->column of its binder`.
fn uses(text: &str) -> String {
    let (sources, tokens) = read(text);
    let names = Names::of(&tokens, &[]);
    let show = |used: &Use| {
        let binder = used.binding.map(|idx| column(&sources, names.bindings[idx].span));
        let binder = binder.map_or("none".to_owned(), |column| column.to_string());
        format!("{}{}->{binder}", used.name, column(&sources, used.span))
    };
    names.uses.iter().map(show).collect::<Vec<_>>().join(" ")
}

/// Each binding as `name type`, with `*` for arguments of surface functions.
fn types(text: &str) -> String {
    let (_, tokens) = read(text);
    let show = |binding: &Binding| {
        let ty = binding.ty.map_or("?", Type::name);
        let mark = if binding.is_surface_argument { "*" } else { "" };
        format!("{} {ty}{mark}", binding.name)
    };
    Names::of(&tokens, &[]).bindings.iter().map(show).collect::<Vec<_>>().join(", ")
}

#[test]
fn a_name_means_the_nearest_binder_before_it() {
    let cases = [
        ("1 /x x 2 /x x", "x6->3 x13->10"),
        ("1 /x { 2 /x x } apply x", "x13->10 x23->3"),
        ("x 1 /x [ x 2 /y y ] y", "x1->none x10->5 y17->14 y21->none"),
        ("{ f } /f f", "f3->none f10->7"),
        // Of brackets that do not match, each closes one.
        ("1 /x { /y [ x } y", "x13->3 y17->8"),
        ("} 1 /x ] x { x", "x10->5 x14->5"),
    ];
    for (text, expected) in cases {
        assert_eq!(uses(text), expected, "{text}");
    }
}

#[test]
fn types_are_known_as_far_as_literals_and_operators_lead() {
    let cases = [
        (
            "1 /a 2.0 /b a real b addf /c \"s\" /d true /e",
            "a integer, b real, c real, d string, e boolean",
        ),
        ("{ } /f [ 1 ] /l l 0 get /x f apply /y", "f function, l array, x ?, y ?"),
        ("1 2 { /b /a a b } apply /c 3 /d", "b ?, a ?, c ?, d integer"),
        ("{ /v /u /face 1.0 } sphere /s", "v real*, u real*, face integer*, s object"),
        ("{ /v v /w 1 } /f f cube /c", "v real*, w real, f function, c object"),
        ("1.0 2.0 3.0 point dup /p", "p ?"),
        ("1.0 2.0 3.0 point /p", "p point"),
        ("true { 2 } { 3 } if /x", "x integer"),
        ("true { 2 } { 3.0 } if /x true { 2 } { 2 3 } if /y", "x ?, y ?"),
        ("7 /a true { 1 } { } if /x a /b", "a integer, x ?, b integer"),
        ("{ /x x 1 addi } /f 2 f apply /y", "x ?, f function, y integer"),
        ("1.5 2 { /b 3.5 } apply /x /a", "b ?, x real, a real"),
        (
            "{ /c { /v v c } } /plain 1 plain apply cube /o",
            "c ?, v real*, plain function, o object",
        ),
        ("{ f apply } /g 1 g apply /x", "g function, x ?"),
        ("{ /f f apply } /g 1 { } g apply /x", "f ?, g function, x ?"),
    ];
    for (text, expected) in cases {
        assert_eq!(types(text), expected, "{text}");
    }
}

#[test]
fn effects_of_functions() {
    let effect = |text: &str| {
        let (_, tokens) = read(text);
        let names = Names::of(&tokens, &[]);
        names.bindings.last().expect("one").effect.as_ref().map(Effect::to_string)
    };
    let cases = [
        ("{ /a a sphere } /f", Some("value → object")),
        ("{ } /f", Some("→")),
        ("{ addi 1.5 } /f", Some("value value → integer real")),
        ("{ /c { c } } /plain", Some("value → function")),
        ("{ apply } /f", None),
        ("1 /x", None),
    ];
    for (text, expected) in cases {
        assert_eq!(effect(text).as_deref(), expected, "{text}");
    }
}

#[test]
fn effects_that_double_are_given_up() {
    let doubling = |n: usize| format!("{{ f{} apply f{0} apply }} /f{n} ", n - 1);
    let text = format!("{{ 1 }} /f0 {} f60 apply /x", (1..=60).map(doubling).collect::<String>());
    assert!(types(&text).ends_with("x ?"));
    assert!(
        types("{ 1 } /f0 { f0 apply f0 apply } /f1 f1 apply /x /y")
            .ends_with("x integer, y integer")
    );
}

#[test]
fn what_is_in_sight_ends_with_its_brackets() {
    let text = "1 /x { 2 /y } { 3 /x 4 /z z } 5 /w";
    let (sources, tokens) = read(text);
    let in_sight = |at: usize| {
        let file = sources.files().next().unwrap();
        let place = file.span(at, at);
        let found = Names::in_sight(&tokens, &[], |span| span.start >= place.start);
        found
            .iter()
            .map(|b| format!("{}{}", b.name, column(&sources, b.span)))
            .collect::<Vec<_>>()
            .join(" ")
    };
    assert_eq!(in_sight(0), "");
    assert_eq!(in_sight(12), "x3 y10");
    assert_eq!(in_sight(26), "x19 z24");
    assert_eq!(in_sight(text.len()), "w33 x3");
}

/// Whether the binding at a column may be called `new`.
fn rename(text: &str, at: u32, new: &str) -> Result<(), String> {
    let (sources, tokens) = read(text);
    let names = Names::of(&tokens, &[]);
    // Addresses start at 1, as columns do.
    let (binding, _) = names.at(at).expect("a name stands there");
    names.check_renaming(&tokens, &[], binding, new).map_err(|clash| match clash {
        Clash::NoName(reason) => reason,
        Clash::Captured(used, binder) => {
            format!("{}->{:?}", column(&sources, used), binder.map(|span| column(&sources, span)))
        }
    })
}

#[test]
fn renaming_keeps_what_names_mean() {
    let text = "1 /x { 2 /y x y } apply x";
    assert_eq!(rename(text, 3, "z"), Ok(()));
    assert_eq!(rename(text, 13, "z-2"), Ok(()));
    // The use of x inside would mean the binder of y, ...
    assert_eq!(rename(text, 3, "y"), Err("13->Some(10)".to_owned()));
    // ... and so it would if that were called x.
    assert_eq!(rename(text, 10, "x"), Err("13->Some(10)".to_owned()));
    assert_eq!(rename("1 /x y", 3, "y"), Err("6->Some(3)".to_owned()));
    for word in ["addi", "true", "2x", "", "a b", "x/", "\u{e9}"] {
        assert!(rename(text, 3, word).is_err(), "{word}");
    }
    assert_eq!(rename(text, 3, "Sphere"), Ok(()));
}

/// The places of names that the compiler takes for unbound.
fn unbound_in_bytecode(text: &str) -> Vec<Span> {
    let mut sources = SourceMap::default();
    let root = sources.add("a", text.as_bytes().to_vec()).unwrap();
    let bindings = [("given".into(), Constant::Int(1))];
    let program = crate::compile(&mut sources, root, &mut NoIncludes, &bindings).unwrap();
    let code = program.functions.iter().flat_map(|function| {
        function.code.iter().zip(&function.origins).map(|(insn, origin)| (insn.op, origin.span))
    });
    let mut spans: Vec<_> =
        code.filter(|(op, _)| *op == Opcode::Unbound).map(|(_, span)| span).collect();
    spans.sort();
    spans
}

#[test]
fn the_compiler_finds_the_same_names_unbound() {
    let cases = [
        "given x { /x x given y } [ z 1 /z z ] z { { x } { 2 /x x } if x }",
        "1 /a { 2 /b { a b c } } apply b { /c a c } /d d c",
        "{ 1 /x } apply x { /c c { 1 /y y } { y } if y } { x 1 /x { x } } sphere",
    ];
    for text in cases {
        assert!(!unbound(text).is_empty());
        assert_eq!(unbound(text), unbound_in_bytecode(text), "{text}");
    }
}

fn unbound(text: &str) -> Vec<Span> {
    let (_, tokens) = tokens_of(text);
    let names = Names::of(&tokens, &[("given".into(), Type::Int)]);
    names.uses.iter().filter(|used| used.binding.is_none()).map(|used| used.span).collect()
}

/// A sequence of words with balanced brackets, by a linear congruential generator (Knuth's MMIX).
fn random_program(seed: u64) -> String {
    let words = ["a", "b", "given", "/a", "/b", "/given", "1", "apply", "{", "[", "close", "close"];
    let (mut state, mut text, mut open) = (seed, String::new(), Vec::new());
    for _ in 0..40 {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = match words[(state >> 33) as usize % words.len()] {
            "close" => open.pop().unwrap_or("2"),
            word => word,
        };
        open.extend(match word {
            "{" => Some("}"),
            "[" => Some("]"),
            _ => None,
        });
        text += word;
        text.push(' ');
    }
    open.iter().rev().for_each(|closer| text += closer);
    text
}

#[test]
fn so_it_does_in_random_programs() {
    let mut n_unbound = 0;
    for seed in 0..2000 {
        let text = random_program(seed);
        let found = unbound(&text);
        assert_eq!(found, unbound_in_bytecode(&text), "{text}");
        n_unbound += found.len();
    }
    assert!(n_unbound > 2000, "only {n_unbound} names");
}
