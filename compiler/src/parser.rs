//! Tokens to the tree: who belongs between which brackets.
//!
//! Brackets are all the syntax there is. The parser keeps its own stack, so that no input can
//! exhaust the machine's, and bounds the depth, so that whoever walks the tree may recurse.

use crate::ast::{Body, Term, TermKind};
use crate::diagnostic::{Code, Diagnostic};
use crate::lexer::{MAX_DIAGNOSTICS, Token, TokenKind};
use crate::source::{SourceMap, Span};

/// How deep functions and arrays may nest in the text.
pub const MAX_NESTING: usize = 500;

/// The tree of a program, whose tokens are from files of `sources`.
///
/// # Errors
/// Brackets that do not match, are not closed, or nest deeper than [`MAX_NESTING`].
pub fn parse(sources: &SourceMap, tokens: Vec<Token>) -> Result<Body, Vec<Diagnostic>> {
    let mut parser = Parser {
        sources,
        tokens: &tokens,
        body: Body::new(),
        open: Vec::new(),
        indent: 0,
        is_lost: false,
        misplaced: None,
        diagnostics: Vec::new(),
    };
    for idx in 0..tokens.len() {
        parser.token(idx);
        if parser.diagnostics.len() == MAX_DIAGNOSTICS || parser.open.len() > MAX_NESTING {
            return Err(parser.diagnostics);
        }
    }
    parser.finish()
}

struct Parser<'a> {
    sources: &'a SourceMap,
    tokens: &'a [Token],
    /// The terms since the last bracket that is open, or since the start.
    body: Body,
    open: Vec<Open>,
    /// Of the line that we are in.
    indent: u16,
    /// Brackets did not match a moment ago: what they seem to say now is not to be trusted.
    is_lost: bool,
    /// The first opener whose closer stands further to the left than its line.
    misplaced: Option<usize>,
    diagnostics: Vec<Diagnostic>,
}

/// A bracket that waits for its closer.
struct Open {
    /// Index of its token.
    opener: usize,
    /// Of its line.
    indent: u16,
    /// The terms before it.
    outer: Body,
}

impl Parser<'_> {
    fn token(&mut self, idx: usize) {
        let token = &self.tokens[idx];
        if let Some(indent) = token.indent {
            self.indent = indent;
            // With nothing open and a new line that closes nothing, we know again where we are.
            self.is_lost &= !self.open.is_empty() || is_closer(&token.kind);
        }
        let kind = match &token.kind {
            TokenKind::OpenFunction | TokenKind::OpenArray => return self.open(idx),
            TokenKind::CloseFunction | TokenKind::CloseArray => return self.close(idx),
            TokenKind::Bool(value) => TermKind::Bool(*value),
            TokenKind::Int(value) => TermKind::Int(*value),
            TokenKind::Real(value) => TermKind::Real(*value),
            TokenKind::Str(text) => TermKind::Str(text.clone()),
            TokenKind::Operator(op) => TermKind::Operator(*op),
            TokenKind::Name(name) => TermKind::Name(name.clone()),
            TokenKind::Binder(name) => TermKind::Binder(name.clone()),
        };
        self.body.push(Term { kind, span: token.span });
    }

    fn open(&mut self, opener: usize) {
        let outer = std::mem::take(&mut self.body);
        self.open.push(Open { opener, indent: self.indent, outer });
        if self.open.len() > MAX_NESTING {
            let message = format!("brackets nest more than {MAX_NESTING} deep");
            let span = self.tokens[opener].span;
            self.diagnostics.push(Diagnostic::new(Code::NestingTooDeep, span, message));
        }
    }

    fn close(&mut self, closer: usize) {
        let token = &self.tokens[closer];
        let Some(open) = self.open.pop() else {
            return self.stray(token);
        };
        let opener = &self.tokens[open.opener];
        if closer_of(&opener.kind) != spelling(&token.kind) {
            return self.mismatch(open, token);
        }
        if token.indent.is_some_and(|indent| indent < open.indent) {
            self.misplaced.get_or_insert(open.opener);
        }
        let inner = std::mem::replace(&mut self.body, open.outer);
        let kind = match opener.kind {
            TokenKind::OpenFunction => TermKind::Function(inner),
            _ => TermKind::Array(inner),
        };
        self.body.push(Term { kind, span: self.bracketed(opener.span, token.span) });
    }

    /// The text between brackets, with them; of brackets in two files, which no text is between, the first.
    fn bracketed(&self, opener: Span, closer: Span) -> Span {
        let file = |span| self.sources.file_of(span).map(std::ptr::from_ref);
        if file(opener) == file(closer) { opener.to(closer) } else { opener }
    }

    fn stray(&mut self, token: &Token) {
        let closer = spelling(&token.kind);
        let message = format!("`{closer}` closes nothing");
        let label = format!("no `{}` is open here", if closer == "}" { "{" } else { "[" });
        self.report(Diagnostic::new(Code::BracketMismatch, token.span, message).label(label));
    }

    fn mismatch(&mut self, open: Open, token: &Token) {
        let opener = &self.tokens[open.opener];
        let (wanted, found) = (closer_of(&opener.kind), spelling(&token.kind));
        let fits = |outer: &Open| closer_of(&self.tokens[outer.opener].kind) == found;
        let outer = self.open.iter().rposition(fits);
        let label = match outer {
            Some(_) => format!("`{wanted}` is missing before this"),
            None => format!("this must be `{wanted}`"),
        };
        let message = format!("`{}` is closed by `{found}`", spelling(&opener.kind));
        let diagnostic = Diagnostic::new(Code::BracketMismatch, token.span, message)
            .label(label)
            .also(opener.span, "opened here");
        self.open.truncate(outer.unwrap_or(self.open.len()));
        self.report(diagnostic);
    }

    fn finish(mut self) -> Result<Body, Vec<Diagnostic>> {
        if let Some(open) = self.open.pop() {
            let diagnostic = self.unclosed(&open);
            self.report(diagnostic);
        }
        if self.diagnostics.is_empty() { Ok(self.body) } else { Err(self.diagnostics) }
    }

    /// Says where the innermost open bracket was opened, and where its closer may be missing.
    fn unclosed(&self, open: &Open) -> Diagnostic {
        let opener = &self.tokens[open.opener];
        let message = format!("`{}` is never closed", spelling(&opener.kind));
        let mut diagnostic =
            Diagnostic::new(Code::BracketUnclosed, opener.span, message).label("opened here");
        // A bracket inside that took a closer from further left may have taken this one's.
        let culprit = self.misplaced.filter(|&inner| inner > open.opener).unwrap_or(open.opener);
        if let Some(line) = self.dedent_behind(culprit) {
            let closer = closer_of(&self.tokens[culprit].kind);
            let text = format!("perhaps `{closer}` is missing before this line");
            diagnostic = diagnostic.also(line, text);
        }
        if let Some(last) = self.tokens.last() {
            let end = Span { start: last.span.end, end: last.span.end };
            diagnostic = diagnostic.also(end, "the program ends here");
        }
        if !self.open.is_empty() {
            diagnostic = diagnostic.note(format!("{} brackets are open", self.open.len() + 1));
        }
        diagnostic
    }

    /// The first line behind a bracket that is not indented more than the bracket's own line.
    fn dedent_behind(&self, opener: usize) -> Option<Span> {
        let margin = self.tokens[..=opener].iter().rev().find_map(|token| token.indent)?;
        let mut behind = self.tokens[opener + 1..].iter();
        let starts_line = |token: &&Token| token.indent.is_some_and(|indent| indent <= margin);
        behind.find(|token| starts_line(token) && !is_closer(&token.kind)).map(|token| token.span)
    }

    /// Keeps the diagnostic, unless it may well be a consequence of another.
    fn report(&mut self, diagnostic: Diagnostic) {
        if !self.is_lost {
            self.diagnostics.push(diagnostic);
        }
        self.is_lost = true;
    }
}

fn is_closer(kind: &TokenKind) -> bool {
    matches!(kind, TokenKind::CloseFunction | TokenKind::CloseArray)
}

fn spelling(bracket: &TokenKind) -> &'static str {
    match bracket {
        TokenKind::OpenFunction => "{",
        TokenKind::CloseFunction => "}",
        TokenKind::OpenArray => "[",
        _ => "]",
    }
}

fn closer_of(opener: &TokenKind) -> &'static str {
    if *opener == TokenKind::OpenFunction { "}" } else { "]" }
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::*;
    use crate::preprocess::testing::{place, preprocess, show_errors, tokens_of};
    use crate::preprocess::{Includes, tokens};

    fn diagnostics(text: &str) -> (SourceMap, Vec<Diagnostic>) {
        let (sources, tokens) = tokens_of(text);
        let found = parse(&sources, tokens).unwrap_err();
        (sources, found)
    }

    /// The labels, primary first, as `place text`.
    fn labels(text: &str) -> Vec<String> {
        let (sources, found) = diagnostics(text);
        let all = std::iter::once(&found[0].primary).chain(&found[0].secondary);
        all.map(|label| format!("{} {}", place(&sources, label.span), label.text)).collect()
    }

    fn show(sources: &SourceMap, body: &Body) -> String {
        let term = |term: &Term| match &term.kind {
            TermKind::Function(inner) => {
                format!("fn<{}>({})", sources.text(term.span), show(sources, inner))
            }
            TermKind::Array(inner) => {
                format!("arr<{}>({})", sources.text(term.span), show(sources, inner))
            }
            kind => format!("{kind:?}<{}>", sources.text(term.span)),
        };
        body.iter().map(term).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn trees_and_their_spans() {
        let cases = [
            ("", ""),
            ("[]{}", "arr<[]>() fn<{}>()"),
            ("1 true \"s\"", "Int(1)<1> Bool(true)<true> Str(\"s\")<\"s\">"),
            (
                "{ /x [x] 2.0 }addi",
                "fn<{ /x [x] 2.0 }>(Binder(\"x\")</x> arr<[x]>(Name(\"x\")<x>) Real(2.0)<2.0>) \
                 Operator(AddI)<addi>",
            ),
        ];
        for (text, expected) in cases {
            let (sources, tokens) = tokens_of(text);
            assert_eq!(show(&sources, &parse(&sources, tokens).unwrap()), expected, "{text:?}");
        }
    }

    #[test]
    fn brackets_in_two_files() {
        let cases = [("#include \"b\"\n1 }", "2 {"), ("2 { 1\n#include \"b\"\n1", "3 }")];
        for (root, included) in cases {
            let (sources, tokens) = preprocess(&[("a", root), ("b", included)]);
            let body = parse(&sources, tokens.unwrap()).unwrap();
            assert_eq!(sources.text(body[1].span), "{", "{root:?}");
        }
    }

    #[test]
    fn bracket_errors() {
        let cases = [
            ("[ [ { ] } ]", "E0006 1:7 `{` is closed by `]`"),
            ("{ [ 1 }", "E0006 1:7 `[` is closed by `}`"),
            ("[ 1 }", "E0006 1:5 `[` is closed by `}`"),
            ("1 ]", "E0006 1:3 `]` closes nothing"),
            ("} } ]\n}", "E0006 1:1 `}` closes nothing"),
            ("1 { /x x { /y y } apply", "E0007 1:3 `{` is never closed"),
            ("{ [ ", "E0007 1:3 `[` is never closed"),
            // What is wrong elsewhere is found too, unless it follows from the first.
            (
                "]\n1\n[ 1 }\n2\n{",
                "E0006 1:1 `]` closes nothing\nE0006 3:5 `[` is closed by `}`\nE0007 5:1 `{` is never closed",
            ),
            ("{ ", "E0007 1:1 `{` is never closed"),
            ("{ { ] }", "E0006 1:5 `{` is closed by `]`"),
        ];
        for (text, expected) in cases {
            let (sources, found) = diagnostics(text);
            assert_eq!(show_errors(&sources, &found), expected, "{text:?}");
        }
    }

    #[test]
    fn both_ends_are_labelled() {
        let cases: [(&str, &[&str]); 7] = [
            ("{ [ 1 }", &["1:7 `]` is missing before this", "1:3 opened here"]),
            ("\n[ 1 }", &["2:5 this must be `]`", "2:1 opened here"]),
            ("}", &["1:1 no `{` is open here"]),
            ("]", &["1:1 no `[` is open here"]),
            ("1 {\n  2 % x\n", &["1:3 opened here", "2:4 the program ends here"]),
            (
                "  { /x\n    x\n  /f\n1",
                &[
                    "1:3 opened here",
                    "3:3 perhaps `}` is missing before this line",
                    "4:2 the program ends here",
                ],
            ),
            // The outer bracket is not closed, but the inner one is to blame.
            (
                "{ /x\n  [ 1\n    2\n  x\n] /f\n1",
                &[
                    "1:1 opened here",
                    "4:3 perhaps `]` is missing before this line",
                    "6:2 the program ends here",
                ],
            ),
        ];
        for (text, expected) in cases {
            assert_eq!(labels(text), expected, "{text:?}");
        }
    }

    #[test]
    fn nesting_is_limited() {
        let nested = |n: usize| {
            let (sources, tokens) = tokens_of(&format!("{}{}", "[".repeat(n), "]".repeat(n)));
            parse(&sources, tokens)
        };
        assert_eq!(nested(MAX_NESTING).map(|body| body.len()), Ok(1));
        assert_eq!(nested(MAX_NESTING + 1).map_err(|found| found.len()), Err(1));
        for bracket in ["{", "[", "{ ["] {
            let (sources, found) = diagnostics(&bracket.repeat(1_000_000));
            let column = if bracket.len() == 1 { 501 } else { 1001 - 250 };
            let expected = format!("E0008 1:{column} brackets nest more than 500 deep");
            assert_eq!(show_errors(&sources, &found), expected, "{bracket}");
        }
    }

    #[test]
    fn many_errors_are_cut_and_many_tokens_are_not() {
        let (_, found) = diagnostics(&"]\n1\n".repeat(100_000));
        assert_eq!(found.len(), MAX_DIAGNOSTICS);
        let (sources, tokens) = tokens_of(&"{ [ 1 ] }\n".repeat(200_000));
        assert_eq!(parse(&sources, tokens).map(|body| body.len()), Ok(200_000));
    }

    /// Reads files beside the including one.
    struct Beside;

    impl Includes for Beside {
        fn load(&mut self, from: &str, name: &str) -> Option<(String, Vec<u8>)> {
            let path = Path::new(from).with_file_name(name);
            Some((path.display().to_string(), std::fs::read(&path).ok()?))
        }
    }

    fn scenes() -> PathBuf {
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/scenes")).to_path_buf()
    }

    fn parse_file(path: &Path) -> Result<usize, String> {
        let mut sources = SourceMap::default();
        let root = sources.add(&path.display().to_string(), std::fs::read(path).unwrap()).unwrap();
        let result = tokens(&mut sources, root, &mut Beside);
        let result = result.and_then(|tokens| parse(&sources, tokens));
        result.map(|body| body.len()).map_err(|found| show_errors(&sources, &found))
    }

    #[test]
    fn scenes_of_the_contest_and_the_course_parse() {
        let names = ["contest", "chicago"].map(|name| scenes().join(name));
        for directory in names {
            let Ok(entries) = std::fs::read_dir(&directory) else {
                println!("skipped: there is no {}", directory.display());
                continue;
            };
            let is_source = |path: &PathBuf| {
                path.extension().is_some_and(|suffix| suffix == "gml" || suffix == "ins")
            };
            let paths: Vec<_> = entries.map(|e| e.unwrap().path()).filter(is_source).collect();
            assert!(paths.len() > 4, "{}", directory.display());
            for path in paths {
                let n_terms = parse_file(&path).unwrap();
                assert!(n_terms > 0, "{}", path.display());
            }
        }
    }

    #[test]
    fn bad_scenes_give_their_errors() {
        let cases = [
            ("syntax1.gml", "E0006", ":5:7 `{` is closed by `]`"),
            ("syntax2.gml", "E0007", ":5:3 `{` is never closed"),
            ("unclosed.gml", "E0007", ":2:1 `{` is never closed"),
        ];
        for (name, code, message) in cases {
            let path = scenes().join("bad").join(name);
            if !path.exists() {
                println!("skipped: there is no {}", path.display());
                continue;
            }
            let expected = format!("{code} {}{message}", path.display());
            assert_eq!(parse_file(&path), Err(expected));
        }
    }
}
