//! `gmlvm disasm`: the forms that a program takes in the compiler, as text.

use std::io::{self, Write};

use compiler::ast::{Body, Term, TermKind};
use compiler::bytecode::Program;
use compiler::diagnostic::Diagnostic;
use compiler::lexer::{Token, TokenKind};
use compiler::preprocess;
use compiler::source::{SourceMap, Span};

use crate::args::{DisasmArgs, Stage};
use crate::clean::clean_lines;
use crate::console;
use crate::failure::Failure;
use crate::load::Source;
use crate::report::Reporter;

/// What there is to show of one stage.
enum Listing {
    Tokens(Vec<Token>),
    Tree(Body),
    Bytecode(Program),
}

pub(super) fn disasm(args: &DisasmArgs, reporter: &Reporter) -> Result<u8, Failure> {
    let mut listings = Vec::new();
    for stage in &args.emit {
        let mut source = Source::read(&args.scene, &args.inputs, reporter)?;
        let listing = listing(*stage, &mut source, reporter)?;
        if let (Listing::Bytecode(program), Some(index)) = (&listing, args.function)
            && index as usize >= program.functions.len()
        {
            return Err(Failure::Usage(format!(
                "there is no function {index}; the main program is function {}",
                program.main()
            )));
        }
        listings.push((listing, source.sources));
    }
    console::data(|out| {
        for (idx, (listing, sources)) in listings.iter().enumerate() {
            if idx > 0 {
                writeln!(out)?;
            }
            show(listing, sources, args.function, out)?;
        }
        Ok(())
    })?;
    Ok(0)
}

fn listing(stage: Stage, source: &mut Source<'_>, reporter: &Reporter) -> Result<Listing, Failure> {
    let mut includes = source.includes();
    let (sources, root) = (&mut source.sources, source.root);
    let listing: Result<Listing, Vec<Diagnostic>> = match stage {
        Stage::Tokens => preprocess::tokens(sources, root, &mut includes).map(Listing::Tokens),
        Stage::Ast => compiler::parse(sources, root, &mut includes).map(Listing::Tree),
        Stage::Bytecode => return source.compile(reporter).map(Listing::Bytecode),
    };
    listing.map_err(|diagnostics| reporter.diagnostics(&diagnostics, &source.sources, None))
}

fn show(
    listing: &Listing,
    sources: &SourceMap,
    function: Option<u32>,
    out: &mut dyn Write,
) -> io::Result<()> {
    match listing {
        Listing::Tokens(tokens) => tokens.iter().try_for_each(|token| {
            let kind = token_kind(&token.kind);
            writeln!(
                out,
                "{:<9} {kind:<14} {}",
                place(sources, token.span),
                sources.text(token.span)
            )
        }),
        Listing::Tree(tree) => show_tree(tree, sources, out),
        Listing::Bytecode(program) => {
            let text = match function {
                Some(index) => compiler::disasm::function(program, index, sources),
                None => compiler::disasm::program(program, sources),
            };
            out.write_all(clean_lines(&text).as_bytes())
        }
    }
}

/// Terms one a line, what is between brackets indented. Brackets nest a few hundred levels at most,
/// but a stack of our own costs nothing.
fn show_tree(tree: &Body, sources: &SourceMap, out: &mut dyn Write) -> io::Result<()> {
    let mut levels = vec![tree.iter()];
    while let Some(level) = levels.last_mut() {
        let Some(Term { kind, span }) = level.next() else {
            levels.pop();
            continue;
        };
        let indent = 2 * (levels.len() - 1);
        let (name, inner) = match kind {
            TermKind::Function(body) => ("function", Some(body)),
            TermKind::Array(body) => ("array", Some(body)),
            other => (term_kind(other), None),
        };
        let text = if inner.is_some() { "" } else { sources.text(*span) };
        let line = format!("{:<9} {:indent$}{name} {text}", place(sources, *span), "");
        writeln!(out, "{}", line.trim_end())?;
        levels.extend(inner.map(|body| body.iter()));
    }
    Ok(())
}

fn place(sources: &SourceMap, span: Span) -> String {
    sources.file_of(span).map_or(String::new(), |file| file.line_column(span).to_string())
}

fn term_kind(kind: &TermKind) -> &'static str {
    match kind {
        TermKind::Bool(_) => "boolean",
        TermKind::Int(_) => "integer",
        TermKind::Real(_) => "real",
        TermKind::Str(_) => "string",
        TermKind::Operator(_) => "operator",
        TermKind::Name(_) => "name",
        TermKind::Binder(_) => "binder",
        TermKind::Function(_) => "function",
        TermKind::Array(_) => "array",
    }
}

fn token_kind(kind: &TokenKind) -> &'static str {
    match kind {
        TokenKind::Bool(_) => "boolean",
        TokenKind::Int(_) => "integer",
        TokenKind::Real(_) => "real",
        TokenKind::Str(_) => "string",
        TokenKind::Operator(_) => "operator",
        TokenKind::Name(_) => "name",
        TokenKind::Binder(_) => "binder",
        TokenKind::OpenFunction => "open function",
        TokenKind::CloseFunction => "close function",
        TokenKind::OpenArray => "open array",
        TokenKind::CloseArray => "close array",
    }
}
