//! Properties of lexer, parser and compiler, as functions of any bytes, which panic where one does not
//! hold. Tests and fuzz targets share them.

use std::sync::Arc;

use compiler::ast::{Body, Term, TermKind};
use compiler::bytecode::{Opcode, Program};
use compiler::diagnostic::{Diagnostic, grouped};
use compiler::lexer::{Token, TokenKind};
use compiler::names::Names;
use compiler::parser::{self, MAX_NESTING};
use compiler::preprocess::{NoIncludes, tokens_and_errors};
use compiler::source::{FileId, SourceMap, Span};
use vm::host::{Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;

/// Programs of fuzzers may run for so long.
const LIMITS: Limits = Limits { fuel: 20_000, max_depth: 200, max_memory: 1 << 20 };

fn source(bytes: &[u8]) -> (SourceMap, FileId) {
    let mut sources = SourceMap::default();
    let file = sources.add("input.gml", bytes.to_vec()).expect("inputs are short");
    (sources, file)
}

/// The text of a span, which lies in the file.
fn text(sources: &SourceMap, span: Span) -> &str {
    let file = sources.file_of(span).expect("a span in a file");
    assert!(span.start <= span.end, "{span:?} is the wrong way round");
    let whole = file.span(0, file.text.len());
    assert!(whole.start <= span.start && span.end <= whole.end, "{span:?} is not in {whole:?}");
    // Not so if it does not lie between characters.
    sources.text(span)
}

/// Errors are somewhere in the file, and there are some.
fn check_errors(sources: &SourceMap, errors: &[Diagnostic]) {
    assert!(!errors.is_empty(), "it fails without an error");
    for error in errors {
        assert!(!error.message.is_empty(), "an error says nothing");
        text(sources, error.primary.span);
        for label in &error.secondary {
            text(sources, label.span);
        }
    }
}

/// Tokens lie in the file, one behind the other; and their texts alone are the same tokens.
pub fn lexes(bytes: &[u8]) {
    let (mut sources, file) = source(bytes);
    let (tokens, errors) = tokens_and_errors(&mut sources, file, &mut NoIncludes);
    if !errors.is_empty() {
        check_errors(&sources, &errors);
    }
    let mut end = 0;
    let mut alone = String::new();
    for token in &tokens {
        assert!(token.span.start >= end, "{token:?} overlaps the one before");
        end = token.span.end;
        alone += text(&sources, token.span);
        alone.push('\n');
    }
    let (mut sources, file) = source(alone.as_bytes());
    let (again, errors) = tokens_and_errors(&mut sources, file, &mut NoIncludes);
    assert!(errors.is_empty(), "tokens of {alone:?} are none alone: {errors:?}");
    let kinds =
        |tokens: &[Token]| tokens.iter().map(|token| token.kind.clone()).collect::<Vec<_>>();
    assert_eq!(kinds(&again), kinds(&tokens), "{alone:?}");
}

/// A sequence of tokens is a program if its brackets match, and then all of it is in the tree, in order.
pub fn parses(bytes: &[u8]) {
    let (mut sources, file) = source(bytes);
    let (tokens, _) = tokens_and_errors(&mut sources, file, &mut NoIncludes);
    let is_program = brackets_match(&tokens);
    match parser::parse(&sources, tokens.clone()) {
        Ok(body) => {
            assert!(is_program, "brackets do not match");
            let mut found = Vec::new();
            walk(&sources, &body, None, &mut found);
            let words: Vec<_> = tokens.iter().map(|token| token.kind.clone()).collect();
            assert_eq!(found, words, "the tree is another program");
        }
        Err(errors) => {
            assert!(!is_program, "{errors:?}");
            check_errors(&sources, &errors);
        }
    }
}

fn brackets_match(tokens: &[Token]) -> bool {
    let mut open = Vec::new();
    for token in tokens {
        let fits = match token.kind {
            TokenKind::OpenFunction | TokenKind::OpenArray => {
                open.push(token.kind.clone());
                open.len() <= MAX_NESTING
            }
            TokenKind::CloseFunction => open.pop() == Some(TokenKind::OpenFunction),
            TokenKind::CloseArray => open.pop() == Some(TokenKind::OpenArray),
            _ => true,
        };
        if !fits {
            return false;
        }
    }
    open.is_empty()
}

/// Writes a tree as tokens; each term lies in the one around it, behind the one before.
fn walk(sources: &SourceMap, body: &Body, around: Option<Span>, found: &mut Vec<TokenKind>) {
    let mut end = around.map_or(0, |span| span.start);
    for Term { kind, span } in body {
        text(sources, *span);
        assert!(span.start >= end, "{span:?} overlaps the one before");
        assert!(around.is_none_or(|around| span.end <= around.end), "{span:?} sticks out");
        end = span.end;
        let mut inner = |body, open, close| {
            found.push(open);
            walk(sources, body, Some(*span), found);
            found.push(close);
        };
        match kind {
            TermKind::Function(body) => {
                inner(body, TokenKind::OpenFunction, TokenKind::CloseFunction);
            }
            TermKind::Array(body) => inner(body, TokenKind::OpenArray, TokenKind::CloseArray),
            TermKind::Bool(value) => found.push(TokenKind::Bool(*value)),
            TermKind::Int(value) => found.push(TokenKind::Int(*value)),
            TermKind::Real(value) => found.push(TokenKind::Real(*value)),
            TermKind::Str(value) => found.push(TokenKind::Str(value.clone())),
            TermKind::Operator(value) => found.push(TokenKind::Operator(*value)),
            TermKind::Name(value) => found.push(TokenKind::Name(value.clone())),
            TermKind::Binder(value) => found.push(TokenKind::Binder(value.clone())),
        }
    }
}

/// Any bytes compile or fail with errors that are somewhere; names are found in either case, and what the
/// compiler takes for unbound is. The program can be listed, and runs until it ends, fails or meets a
/// limit.
pub fn compiles(bytes: &[u8]) {
    let (mut sources, file) = source(bytes);
    let (tokens, _) = tokens_and_errors(&mut sources, file, &mut NoIncludes);
    let names = Names::of(&tokens, &[]);
    match compiler::compile(&mut sources, file, &mut NoIncludes, &[]) {
        Ok(program) => {
            check_program(&sources, &program, &names);
            let program = Arc::new(LoadedProgram::new(program));
            if let Err(error) = Machine::new(&program, LIMITS).run(&mut Accepts) {
                check_errors(&sources, &[error.into_diagnostic()]);
            }
        }
        Err(errors) => check_errors(&sources, &errors),
    }
}

fn check_program(sources: &SourceMap, program: &Program, names: &Names) {
    for function in &program.functions {
        assert_eq!(function.code.len(), function.origins.len(), "instructions without origins");
        for (insn, origin) in function.code.iter().zip(&function.origins) {
            // A branch without anything in it is nowhere.
            if !origin.span.is_none() {
                text(sources, origin.span);
            }
            if insn.op == Opcode::Unbound {
                let mut uses = names.uses.iter().filter(|used| used.span == origin.span);
                assert!(uses.any(|used| used.binding.is_none()), "a name has two meanings");
            }
        }
    }
}

/// Takes render jobs, and does nothing.
struct Accepts;

impl Host for Accepts {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        // The number of solids is that of a tree that may be shared a lot: counting must not walk it.
        assert!(!grouped(job.object.n_shapes()).is_empty());
        Ok(())
    }
}
