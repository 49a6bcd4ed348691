//! Words, numbers, strings and comments; and what is none.

use super::*;
use crate::preprocess;
use crate::preprocess::testing::{errors, show_errors, show_tokens, tokens_of};

#[test]
fn tokens_are_the_longest_that_fit() {
    let cases = [
        ("", ""),
        ("x-1", "x-1"),
        ("1-1", "int 1, int -1"),
        ("-1-1", "int -1, int -1"),
        ("3x", "int 3, x"),
        ("123e", "int 123, e"),
        ("123e-", "int 123, e-"),
        ("1e3", "real 1000.0"),
        ("1E-2", "real 0.01"),
        ("-1.5e2", "real -150.0"),
        ("1.5e", "real 1.5, e"),
        ("1.5e2.5", "E0001 1:6 unexpected character `.`"),
        ("-0", "int 0"),
        ("-0.0", "real -0.0"),
        ("007", "int 7"),
        ("true false True", "true, false, True"),
        ("/true-ish/x", "/true-ish, /x"),
        ("addi Addi addi2 add", "op addi, Addi, addi2, add"),
        ("a_b-c9_-", "a_b-c9_-"),
        ("[1]{x}", "[, int 1, ], {, x, }"),
        ("1\"a\"2", "int 1, \"a\", int 2"),
        ("1\t2\r3\n4\x0b5\x0c6", "int 1, int 2, int 3, int 4, int 5, int 6"),
    ];
    for (text, expected) in cases {
        assert_eq!(show_tokens(text), expected, "{text:?}");
    }
}

#[test]
fn comments_are_white_space() {
    let cases = [
        ("1%2", "int 1"),
        ("1%2\n3", "int 1, int 3"),
        ("1%2\r3", "int 1, int 3"),
        ("1%2\x0b3", "int 1, int 3"),
        ("1%2\x0c3", "int 1"),
        ("1/* 2 */3", "int 1, int 3"),
        ("x/**/y", "x, y"),
        ("1 /* 2\n\" */ 3", "int 1, int 3"),
        ("1 % /* 2\n3", "int 1, int 3"),
        ("1 /* % */ 3", "int 1, int 3"),
        ("\"/*\" 1 \"*/\"", "\"/*\", int 1, \"*/\""),
        ("\"a%b\\\" 1", "\"a%b\\\", int 1"),
        ("1 /*/ 2", "E0012 1:3 `/*` comment is never closed"),
    ];
    for (text, expected) in cases {
        assert_eq!(show_tokens(text), expected, "{text:?}");
    }
}

#[test]
fn literals_keep_to_their_range() {
    let cases = [
        ("9223372036854775807", "int 9223372036854775807"),
        ("-9223372036854775808", "int -9223372036854775808"),
        ("9223372036854775808", "E0003 1:1 `9223372036854775808` does not fit in a 64-bit integer"),
        ("1 -1e309", "E0003 1:3 `-1e309` is beyond the range of reals"),
        (
            "1e99999999999999999999",
            "E0003 1:1 `1e99999999999999999999` is beyond the range of reals",
        ),
        ("1.7976931348623157e308", "real 1.7976931348623157e308"),
        ("1e-400 4.9e-324", "real 0.0, real 5e-324"),
        ("0.1", "real 0.1"),
        // Halfway between two doubles but for the last digit: only correct rounding gets it.
        ("9007199254740993.0", "real 9007199254740992.0"),
        ("9007199254740993.00000000000000000000000001", "real 9007199254740994.0"),
    ];
    for (text, expected) in cases {
        assert_eq!(show_tokens(text), expected, "{text:?}");
    }
}

#[test]
fn strings_are_printable_ascii_on_one_line() {
    let cases = [
        ("\"\"", "\"\""),
        ("\" ~!\"", "\" ~!\""),
        ("1 \"ab\n2", "E0002 1:3 string is not closed at the end of the line"),
        ("\"ab\r2\"", "E0002 1:1 string is not closed at the end of the line"),
        ("\"a\tb\" 1", "E0002 1:3 string holds the character `\\u{9}`"),
        ("\"a\x1b[2J\"", "E0002 1:3 string holds the character `\\u{1b}`"),
        ("\"\x7f\"", "E0002 1:2 string holds the character `\\u{7f}`"),
        ("\"caf\u{e9}\"", "E0002 1:5 string holds the character `\u{e9}`"),
    ];
    for (text, expected) in cases {
        assert_eq!(show_tokens(text).lines().next(), Some(expected), "{text:?}");
    }
}

#[test]
fn binders_need_an_identifier_that_is_not_reserved() {
    let cases = [
        ("/ x", "E0004 1:1 `/` binds no identifier"),
        ("1 /", "E0004 1:3 `/` binds no identifier"),
        ("/{", "E0004 1:1 `/` binds no identifier"),
        ("/2x 3", "E0004 1:1 `/2x` binds no identifier"),
        ("/_x", "E0004 1:1 `/_x` binds no identifier"),
        ("1 // it's, so", "E0004 1:3 `//` is not GML"),
        ("/addi", "E0005 1:1 `addi` is an operator and cannot be bound"),
        ("{ /true }", "E0005 1:3 `true` is a boolean and cannot be bound"),
    ];
    for (text, expected) in cases {
        assert_eq!(show_tokens(text), expected, "{text:?}");
    }
}

#[test]
fn a_run_of_bad_characters_is_one_error() {
    let cases = [
        ("1.", "E0001 1:2 unexpected character `.`"),
        (".5", "E0001 1:1 unexpected character `.`"),
        ("1e+5", "E0001 1:3 unexpected character `+`"),
        ("-", "E0001 1:1 unexpected character `-`"),
        ("--1", "E0001 1:1 unexpected character `-`"),
        ("x @@@ y", "E0001 1:3 unexpected characters `@@@`"),
        ("gr\u{f6}\u{df}e", "E0001 1:3 unexpected characters `\u{f6}\u{df}`"),
        ("\x1b", "E0001 1:1 unexpected character `\\u{1b}`"),
        ("\0", "E0001 1:1 unexpected character `\\u{0}`"),
        ("\u{202e}", "E0001 1:1 unexpected character `\\u{202e}`"),
        ("1 # 2", "E0001 1:3 unexpected character `#`"),
        ("\n 1 */ 2", "E0001 2:4 unexpected characters `*/`"),
        ("?,?", "E0001 1:1 unexpected characters `?,?`"),
        ("1 ; 2 ;", "E0001 1:3 unexpected character `;`\nE0001 1:7 unexpected character `;`"),
    ];
    for (text, expected) in cases {
        assert_eq!(show_tokens(text), expected, "{text:?}");
    }
}

#[test]
fn advice_fits_the_mistake() {
    let cases = [
        (".25", "a real number has a digit on both sides of its point: write `0.25`"),
        ("-.25", "a real number has a digit on both sides of its point: write `-0.25`"),
        ("12.", "a real number has a digit on both sides of its point: write `12.0`"),
        ("1.2.3", "a real number has a digit on both sides of its point"),
        ("1e+5", "an exponent has no `+` sign: write `1e5`"),
        ("+5", "a number has no `+` sign; `addi` adds integers, `addf` reals"),
        ("1 #", "a preprocessor line has `#` at its start; comments start with `%`"),
        ("'", "a string stands between two `\"`"),
        (",", "white space is all that separates values"),
        (";", "white space is all that separates values"),
        ("//", "a comment starts with `%`, or stands between `/*` and `*/`"),
        ("/ x", "no blank may stand between `/` and the name"),
        ("_x", "an identifier starts with a letter"),
        ("*/", "no `/*` comment is open here"),
        ("/addi", "only the exact name is reserved: `/my-addi` is fine"),
        ("\u{feff}1", "save the file without a byte order mark"),
    ];
    for (text, expected) in cases {
        let (_, diagnostics) = errors(text);
        assert_eq!(diagnostics[0].helps, [expected], "{text:?}");
    }
}

#[test]
fn words_are_limited() {
    let as_many = "1 ".repeat(MAX_TOKENS);
    assert_eq!(tokens_of(&as_many).1.len(), MAX_TOKENS);
    let column = 2 * MAX_TOKENS + 1;
    let (sources, found) = errors(&format!("{as_many}1 1 1"));
    let expected = format!("E0013 1:{column} the program has more than {MAX_TOKENS} words");
    assert_eq!(show_errors(&sources, &found), expected);
}

#[test]
fn fewer_words_may_be_allowed() {
    let mut sources = crate::source::SourceMap::with_max_words(3);
    let file = sources.add("a.gml", b"1 2 3 { 5".to_vec()).expect("short");
    let (tokens, errors) =
        preprocess::tokens_and_errors(&mut sources, file, &mut preprocess::NoIncludes);
    assert_eq!(tokens.len(), 3);
    assert_eq!(show_errors(&sources, &errors), "E0013 a.gml:1:7 the program has more than 3 words");
    assert_eq!(errors[0].helps, ["raise the limit with `--max-words N`"]);
}

#[test]
fn lexing_stops_after_twenty_errors() {
    let (_, exactly) = errors(&"@ ".repeat(20));
    assert_eq!((exactly.len(), exactly[19].notes.len()), (20, 0));
    let (_, more) = errors(&"@ ".repeat(1_000_000));
    assert_eq!(more.len(), 20);
    assert_eq!(more[19].notes, ["there are more errors, which are not shown"]);
}

#[test]
fn long_literals_are_shown_in_part() {
    let (_, diagnostics) = errors(&"9".repeat(1000));
    let expected = format!("`{}...` does not fit in a 64-bit integer", "9".repeat(40));
    assert_eq!(diagnostics[0].message, expected);
}

#[test]
fn spans_and_indents_are_exact() {
    let (sources, tokens) = tokens_of("\t/ab\n  \"c\" -1.5 {\n\n]");
    let shown: Vec<_> =
        tokens.iter().map(|token| (sources.text(token.span), token.indent)).collect();
    assert_eq!(
        shown,
        [("/ab", Some(8)), ("\"c\"", Some(2)), ("-1.5", None), ("{", None), ("]", Some(0))]
    );
}

#[test]
fn equal_names_share_their_text() {
    let (_, tokens) = tokens_of("x /x");
    let [TokenKind::Name(name), TokenKind::Binder(binder)] = [&tokens[0].kind, &tokens[1].kind]
    else {
        panic!("{tokens:?}");
    };
    assert!(Arc::ptr_eq(name, binder));
}
