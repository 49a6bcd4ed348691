//! `gmlvm disasm`: the forms that a program takes in the compiler, as text.

use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

use compiler::ast::{Body, Term, TermKind};
use compiler::bytecode::Program;
use compiler::diagnostic::Diagnostic;
use compiler::lexer::{Token, TokenKind};
use compiler::preprocess;
use compiler::source::{SourceMap, Span};
use vm::host::RenderJob;
use vm::program::LoadedProgram;

use crate::args::{DisasmArgs, Stage};
use crate::clean::{clean, clean_lines, shortened};
use crate::console;
use crate::driver::accept::run_visited;
use crate::failure::Failure;
use crate::listing::html::{MAX_ROWS, Page};
use crate::listing::{self, Selection, Surfaces, Walk};
use crate::load::{Source, is_stdio};
use crate::output::Target;
use crate::report::Reporter;

/// What there is to show.
enum Listing {
    Tokens(Vec<Token>),
    Tree(Body),
    /// These functions.
    Bytecode(Program, Vec<u32>),
    /// These stages of each surface function.
    Surfaces(Arc<LoadedProgram>, Selection, Vec<Stage>),
}

pub(super) fn disasm(args: &DisasmArgs, reporter: &Reporter) -> Result<u8, Failure> {
    if let Some(path) = &args.html {
        page(args, path, reporter)?;
        return Ok(0);
    }
    let scene = Source::read(&args.scene, &args.inputs, reporter)?;
    let mut listings = Vec::new();
    for (stage, of_surfaces) in stages(args) {
        // Each stage adds the files that it includes.
        let mut source = scene.afresh();
        let listing = match stage {
            _ if !of_surfaces.is_empty() => {
                let (program, selection) = program(args, &mut source, reporter)?;
                Listing::Surfaces(program, selection, of_surfaces)
            }
            Stage::Tokens | Stage::Ast => listing(stage, &mut source, reporter)?,
            _ => {
                let program = source.compile(reporter)?;
                let functions = selected(args, &program)?;
                let all = (0..program.functions.len() as u32).rev().collect();
                Listing::Bytecode(program, functions.unwrap_or(all))
            }
        };
        listings.push((listing, source));
    }
    let mut outcome = Ok(());
    console::data(|out| {
        for (idx, (listing, source)) in listings.iter().enumerate() {
            if idx > 0 {
                writeln!(out)?;
            }
            if let Listing::Surfaces(program, selection, stages) = listing {
                let mut walk = Walk::new(selection.clone(), args.limits.machine());
                let mut is_first = true;
                outcome = walk_surfaces(&mut walk, args, source, program, reporter, &mut |shown| {
                    if !std::mem::replace(&mut is_first, false) {
                        writeln!(out)?;
                    }
                    listing::text::write(shown, stages, &program.bytecode, &source.sources, out)
                });
                if outcome.is_err() {
                    break;
                }
            } else {
                show(listing, &source.sources, out)?;
            }
        }
        Ok(())
    })?;
    outcome.map(|()| 0)
}

/// The stages asked for. Those that are shown surface by surface come last, and together.
fn stages(args: &DisasmArgs) -> Vec<(Stage, Vec<Stage>)> {
    let all = match (&args.emit[..], args.surface) {
        ([], Some(_)) => &[Stage::Bytecode, Stage::Clif, Stage::Asm],
        ([], None) => &[Stage::Bytecode][..],
        (emit, _) => emit,
    };
    let is_by_surface = args.surface.is_some() || all.iter().any(|stage| *stage > Stage::Bytecode);
    if !is_by_surface {
        return all.iter().map(|stage| (*stage, Vec::new())).collect();
    }
    let (of_program, of_surfaces): (Vec<Stage>, Vec<Stage>) =
        all.iter().partition(|stage| **stage < Stage::Bytecode);
    let mut stages: Vec<_> = of_program.into_iter().map(|stage| (stage, Vec::new())).collect();
    stages.extend(of_surfaces.first().map(|first| (*first, of_surfaces.clone())));
    stages
}

/// The compiled program, and which of its surfaces are wanted.
fn program(
    args: &DisasmArgs,
    source: &mut Source<'_>,
    reporter: &Reporter,
) -> Result<(Arc<LoadedProgram>, Selection), Failure> {
    let program = source.compile(reporter)?;
    let functions = selected(args, &program)?;
    let selection = Selection { surface: args.surface, functions };
    Ok((Arc::new(LoadedProgram::new(program)), selection))
}

/// The functions that `--function` selects, if it is given.
fn selected(args: &DisasmArgs, program: &Program) -> Result<Option<Vec<u32>>, Failure> {
    let Some(word) = &args.function else { return Ok(None) };
    let functions = listing::functions_named(program, word);
    if functions.is_empty() {
        let message = format!(
            "there is no function {}; the main program is function {}",
            clean(&shortened(word)),
            program.main()
        );
        return Err(Failure::Usage(message));
    }
    Ok(Some(functions))
}

/// Runs the program and shows its surfaces.
fn walk_surfaces(
    walk: &mut Walk,
    args: &DisasmArgs,
    source: &Source<'_>,
    program: &Arc<LoadedProgram>,
    reporter: &Reporter,
    show: &mut dyn FnMut(&Surfaces) -> io::Result<()>,
) -> Result<(), Failure> {
    let visit = &mut |job: &RenderJob<'_>| walk.visit(job, show);
    run_visited(source, program, args.limits, reporter, visit)?;
    match args.surface {
        Some(surface) if surface >= walk.n_surfaces => Err(Failure::Usage(format!(
            "there is no surface {surface}; the program renders {} of them, counted from 0",
            walk.n_surfaces
        ))),
        _ => Ok(()),
    }
}

/// Writes all surfaces as a page.
fn page(args: &DisasmArgs, path: &Path, reporter: &Reporter) -> Result<(), Failure> {
    let mut source = Source::read(&args.scene, &args.inputs, reporter)?;
    let (program, selection) = program(args, &mut source, reporter)?;
    let mut page = Page::new(&program.bytecode, &source.sources, MAX_ROWS);
    let mut walk = Walk::new(selection, args.limits.machine());
    walk_surfaces(&mut walk, args, &source, &program, reporter, &mut |shown| {
        page.add(shown);
        Ok(())
    })?;
    let title = args.scene.display().to_string();
    if is_stdio(path) {
        return console::data(|out| page.write(&title, out));
    }
    Target::path(path.to_owned()).write_plain(&mut |out| page.write(&title, out))
}

fn listing(stage: Stage, source: &mut Source<'_>, reporter: &Reporter) -> Result<Listing, Failure> {
    let mut includes = source.includes();
    let (sources, root) = (&mut source.sources, source.root);
    let listing: Result<Listing, Vec<Diagnostic>> = match stage {
        Stage::Tokens => preprocess::tokens(sources, root, &mut includes).map(Listing::Tokens),
        _ => compiler::parse(sources, root, &mut includes).map(Listing::Tree),
    };
    listing.map_err(|diagnostics| reporter.diagnostics(&diagnostics, &source.sources, None))
}

fn show(listing: &Listing, sources: &SourceMap, out: &mut dyn Write) -> io::Result<()> {
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
        Listing::Bytecode(program, functions) => {
            let text = compiler::disasm::functions(program, functions, sources);
            out.write_all(clean_lines(&text).as_bytes())
        }
        // Found by running the program.
        Listing::Surfaces(..) => Ok(()),
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
