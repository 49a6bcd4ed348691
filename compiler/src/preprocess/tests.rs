//! Conditions, included files, circles and limits.

use super::testing::{errors, place, preprocess, show_errors, show_files, show_tokens};

#[test]
fn conditions_select_text() {
    let cases = [
        ("#ifdef A\n1\n#else\n2\n#endif\n3", "int 2, int 3"),
        ("#ifndef A\n1\n#else\n2\n#endif\n3", "int 1, int 3"),
        ("#define A\n#ifdef A\n1\n#else\n2\n#endif", "int 1"),
        ("#define A 1 + 2\n#undef A\n#ifdef A\n1\n#endif", ""),
        ("#define A(x) it's @ \\\n @ more\n1", "int 1"),
        ("#define A \\\r\n @\r\n1", "int 1"),
        (" \t# define  A /* x */\n#ifdef/**/A\n1\n#endif A", "int 1"),
        ("#define A /* over\nlines */\n#ifdef A % x\n1\n#endif /* A */", "int 1"),
        ("/* x */ #define A\n#ifdef A\n1\n#endif", "int 1"),
        ("#ifdef A\n#ifdef B\n1\n#else\n2\n#endif\n3\n#else\n4\n#endif", "int 4"),
        ("#ifndef A\n#ifdef B\n1\n#else\n2\n#endif\n3\n#else\n4\n#endif", "int 2, int 3"),
        ("#ifdef A\r\n1\r\n#endif\r\n2", "int 2"),
        ("1\r#ifdef A\r2\r#endif", "int 1"),
    ];
    for (text, expected) in cases {
        assert_eq!(show_tokens(text), expected, "{text:?}");
    }
}

#[test]
fn skipped_text_is_not_lexed() {
    let cases = [
        ("#ifdef A\n\u{1b} 1. 'x \" @ 99999999999999999999\n#endif\n1", "int 1"),
        ("#ifdef A\n/*\n#endif\n*/\n#endif\n1", "int 1"),
        ("#ifdef A\n% /*\n#endif\n1", "int 1"),
        ("#ifdef A\n\"/*\"\n#endif\n1", "int 1"),
        ("#ifdef A\n1 #endif\n#endif\n2", "int 2"),
        ("#ifdef A\n#nonsense\n#include \"none\"\n#if 1\n#elif 2\n#endif\n#endif\n1", "int 1"),
        ("#ifdef A\n\u{e9}\u{df}\n#endif\n1", "int 1"),
        (
            "#ifdef A\n/*",
            "E0012 2:1 `/*` comment is never closed\nE0009 1:1 `#ifdef` has no `#endif`",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(show_tokens(text), expected, "{text:?}");
    }
}

#[test]
fn marks_are_ignored() {
    let text = "# 12 \"f\" 2\n#line 3\n#7\n#\n# % c\n1";
    assert_eq!(show_tokens(text), "E0009 5:1 `#` is not a preprocessor line");
    assert_eq!(show_tokens("# 12 \"f\" 2\n#line 3\n#7\n#\n1"), "int 1");
    // Inside a comment that spans lines, `#` is no directive; behind a token neither.
    assert_eq!(show_tokens("/*\n#bad\n*/ 1"), "int 1");
    assert_eq!(show_tokens("1 /*\n*/ #bad"), "E0001 2:4 unexpected character `#`");
}

#[test]
fn bad_lines_are_reported() {
    let cases = [
        ("1\n  # this is it", "E0009 2:3 `#this` is not a preprocessor line"),
        ("#ifdef\n#endif", "E0009 1:1 `#ifdef` without a name"),
        ("#define 3", "E0009 1:1 `#define` without a name"),
        ("#else", "E0009 1:1 `#else` without a condition before it"),
        ("1\n#endif", "E0009 2:1 `#endif` without a condition before it"),
        ("#ifndef A\n1", "E0009 1:1 `#ifndef` has no `#endif`"),
        ("#ifdef A\n#else\n#else\n@\n#endif", "E0009 3:1 second `#else` of one condition"),
        (
            "#if 1\n@\n#else\n@\n#endif\n#endif",
            "E0009 1:1 `#if` is not known\nE0009 6:1 `#endif` without a condition before it",
        ),
        ("#ifdef A\n#elif B\n@\n#else\n@\n#endif", "E0009 2:1 `#elif` is not known"),
        ("#include", "E0009 1:1 `#include` without a file name in quotes"),
        ("#include \"\"", "E0009 1:1 `#include` without a file name in quotes"),
        ("#include <x>", "E0009 1:1 `#include` without a file name in quotes"),
        ("#include \"x", "E0009 1:1 `#include` without a file name in quotes"),
        ("#include \"x\" 1", "E0009 1:1 `#include` with more than a file name"),
    ];
    for (text, expected) in cases {
        assert_eq!(show_tokens(text), expected, "{text:?}");
    }
}

#[test]
fn an_unclosed_condition_shows_both_ends() {
    let (sources, diagnostics) = errors("1\n#ifdef A\n2\n");
    let [end] = &diagnostics[0].secondary[..] else { panic!("{diagnostics:?}") };
    assert_eq!(diagnostics[0].primary.text, "opened here");
    assert_eq!(
        (place(&sources, end.span).as_str(), end.text.as_str()),
        ("4:1", "the file ends here")
    );
}

#[test]
fn files_are_included_in_place() {
    let guarded = "#ifndef B\n#define B\n2\n#include \"b\"\n#endif";
    let cases: [(&[(&str, &str)], &str); 6] = [
        (&[("a", "1\n#include \"b\"\n3"), ("b", "2")], "int 1, int 2, int 3"),
        (&[("a", "#include \"b\" % x\n#include \"b\" /* y */"), ("b", "2")], "int 2, int 2"),
        (&[("a", "#include \"b\"\n#include \"b\"\n3"), ("b", guarded)], "int 2, int 3"),
        (&[("a", "{\n#include \"b\"\n1"), ("b", "}")], "{, }, int 1"),
        (
            &[("a", "#include \"b\"\n@"), ("b", "\n @")],
            "E0001 b:2:2 unexpected character `@`\nE0001 2:1 unexpected character `@`",
        ),
        (
            &[("a", "#include \"b\"\n#endif"), ("b", "#ifndef A")],
            "E0009 b:1:1 `#ifndef` has no `#endif`\nE0009 2:1 `#endif` without a condition before it",
        ),
    ];
    for (files, expected) in cases {
        assert_eq!(show_files(files), expected, "{files:?}");
    }
}

#[test]
fn names_that_lead_outside_or_nowhere_are_refused() {
    let cases = [
        ("none", "`none` cannot be read"),
        ("/etc/passwd", "`/etc/passwd` is absolute, but must be relative and stay below"),
        ("\\x", "`\\x` is absolute, but must be relative and stay below"),
        ("C:x", "`C:x` is absolute, but must be relative and stay below"),
        ("../x", "`../x` contains `..`, but must be relative and stay below"),
        ("b/../x", "`b/../x` contains `..`, but must be relative and stay below"),
        ("\u{1b}x", "`\\u{1b}x` cannot be read"),
        ("a..b", "`a..b` cannot be read"),
    ];
    for (name, expected) in cases {
        let text = format!("1\n#include \"{name}\"");
        assert_eq!(show_tokens(&text), format!("E0010 2:10 {expected}"), "{name:?}");
    }
}

#[test]
fn circles_are_shown() {
    let (sources, result) =
        preprocess(&[("a", "#include \"b\""), ("b", "\n#include \"c\""), ("c", "#include \"b\"")]);
    let diagnostics = result.unwrap_err();
    assert_eq!(show_errors(&sources, &diagnostics), "E0011 c:1:10 `b` includes itself");
    assert_eq!(diagnostics[0].notes, ["`b` includes `c` includes `b`"]);
    let [via] = &diagnostics[0].secondary[..] else { panic!("{diagnostics:?}") };
    assert_eq!(
        (place(&sources, via.span), via.text.as_str()),
        ("b:2:10".to_owned(), "`c` is included here")
    );
}

#[test]
fn includes_are_limited() {
    // Macros change for ever, so that only the depth stops it.
    let toggling = "#ifdef A\n#undef A\n#else\n#define A\n#endif\n#include \"a\"";
    assert_eq!(show_files(&[("a", toggling)]).split_once(' ').map(|(code, _)| code), Some("E0013"));
    let names: Vec<_> = (0..70).map(|n| format!("f{n}")).collect();
    let texts: Vec<_> = (1..71).map(|n| format!("#include \"f{n}\"\n").repeat(2)).collect();
    let pairs = |n: usize| -> Vec<(&str, &str)> {
        let named = names.iter().zip(&texts).take(n).map(|(n, t)| (n.as_str(), t.as_str()));
        named.chain([("f64", "1")]).collect()
    };
    assert_eq!(
        show_files(&pairs(70)),
        "E0013 f64:1:10 files include one another more than 64 deep"
    );
    let doubling = show_files(&pairs(64));
    assert!(doubling.ends_with("more than 10000 files are included"), "{doubling}");
    assert_eq!(doubling.lines().count(), 1);
}

#[test]
fn included_text_is_limited() {
    let large = " ".repeat(20 << 20);
    let root = "#include \"b\"\n".repeat(4);
    assert_eq!(
        show_files(&[("a", &root), ("b", &large)]),
        "E0013 4:10 with `b` the program is too long"
    );
}
