//! GML source text to bytecode.
//!
//! This crate owns syntax, names, operators, spans and diagnostics; it knows no geometry, performs
//! no input or output, and depends on no other crate of the workspace. The stages, in order:
//! [`preprocess`] and [`lexer`] (text to tokens), [`parser`] (tokens to tree), [`emit`] (tree to
//! bytecode), [`disasm`] (bytecode to text).
#![forbid(unsafe_code)]

use std::sync::Arc;

use crate::ast::Body;
use crate::bytecode::{Constant, Program};
use crate::diagnostic::Diagnostic;
use crate::preprocess::Includes;
use crate::source::{FileId, SourceMap};

pub mod ast;
pub mod bytecode;
pub mod degrees;
pub mod diagnostic;
pub mod disasm;
pub mod emit;
pub mod flow;
pub mod lexer;
pub mod names;
pub mod op;
pub mod parser;
pub mod preprocess;
pub mod scalar;
pub mod source;
pub mod suggest;

/// Reads a file of `sources`, and what it includes, into a tree.
///
/// # Errors
/// All lexical and syntax errors that could be told apart.
pub fn parse(
    sources: &mut SourceMap,
    root: FileId,
    includes: &mut dyn Includes,
) -> Result<Body, Vec<Diagnostic>> {
    let tokens = preprocess::tokens(sources, root, includes)?;
    parser::parse(sources, tokens)
}

/// Compiles a file, with `bindings` made before the program starts.
///
/// # Errors
/// As [`parse`], and when the program is too large for the bytecode.
pub fn compile(
    sources: &mut SourceMap,
    root: FileId,
    includes: &mut dyn Includes,
    bindings: &[(Arc<str>, Constant)],
) -> Result<Program, Vec<Diagnostic>> {
    let tree = parse(sources, root, includes)?;
    let file = sources.file(root);
    let span = file.span(0, file.text.len());
    emit::emit(&tree, bindings, span).map_err(|diagnostic| vec![*diagnostic])
}
