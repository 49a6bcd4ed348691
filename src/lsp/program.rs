//! A document as requests look at it: its files, words and names.

use std::collections::BTreeMap;
use std::sync::Arc;

use compiler::bytecode::Constant;
use compiler::lexer::{Token, TokenKind};
use compiler::names::{Binding, Names};
use compiler::op::{Operator, Type};
use compiler::preprocess;
use compiler::source::{FileId, SourceFile, SourceMap, Span};

use crate::args::Inputs;
use crate::lsp::documents::{Document, OpenIncludes, uri_of};
use crate::lsp::text::Lines;
use crate::lsp::types::{Location, Position, Range};

/// A document, read as far as it can be.
pub(super) struct Program {
    pub(super) sources: SourceMap,
    pub(super) root: FileId,
    pub(super) tokens: Vec<Token>,
    pub(super) names: Names,
    pub(super) predefined: Vec<(Arc<str>, Type)>,
    /// Of the document itself.
    pub(super) lines: Lines,
}

impl Program {
    /// Reads a document and what it includes; `None` if it is too long.
    pub(super) fn read(
        document: &Document,
        inputs: &Inputs,
        open: &BTreeMap<String, Document>,
    ) -> Option<Self> {
        let mut sources = SourceMap::with_max_words(inputs.max_words);
        let root = sources.add(&document.name(), document.text.as_bytes().to_vec()).ok()?;
        let mut includes = OpenIncludes::new(document, inputs, open);
        let (tokens, _) = preprocess::tokens_and_errors(&mut sources, root, &mut includes);
        let predefined = predefined(inputs);
        let names = Names::of(&tokens, &predefined);
        let lines = Lines::of(&document.text);
        Some(Program { sources, root, tokens, names, predefined, lines })
    }

    pub(super) fn file(&self) -> &SourceFile {
        self.sources.file(self.root)
    }

    /// The span that is empty at a place in the document.
    pub(super) fn span_at(&self, place: Position) -> Span {
        let byte = self.lines.byte(&self.file().text, place);
        self.file().span(byte, byte)
    }

    /// The operator at a place, and where it stands.
    pub(super) fn operator_at(&self, place: Position) -> Option<(Operator, Span)> {
        let at = self.span_at(place).start;
        self.tokens.iter().find_map(|token| match token.kind {
            TokenKind::Operator(op) if (token.span.start..=token.span.end).contains(&at) => {
                Some((op, token.span))
            }
            _ => None,
        })
    }

    /// The binding that the word at a place belongs to, and where the word stands.
    pub(super) fn binding_at(&self, place: Position) -> Option<(usize, Span)> {
        self.names.at(self.span_at(place).start)
    }

    /// The bindings in sight at a place.
    pub(super) fn in_sight(&self, place: Position) -> Vec<Binding> {
        let at = self.span_at(place).start;
        let end = self.file().span(0, self.file().text.len()).end;
        // Tokens of included files have addresses behind those of the document.
        Names::in_sight(&self.tokens, &self.predefined, |span| (at..=end).contains(&span.start))
    }

    /// Whether a span lies in the document itself, and not in what it includes.
    pub(super) fn is_here(&self, span: Span) -> bool {
        self.sources.file_of(span).is_some_and(|file| std::ptr::eq(file, self.file()))
    }

    /// Whether a span that is some text stands right before another, with only white space between.
    pub(super) fn is_before(&self, first: Span, second: Span) -> bool {
        let between = Span { start: first.end, end: second.start };
        !first.is_none()
            && first.end <= second.start
            && self.sources.text(between).trim().is_empty()
    }

    /// The range of a span of the document itself.
    pub(super) fn range(&self, span: Span) -> Range {
        self.lines.range(self.file(), span)
    }

    /// Where a span of any file is.
    pub(super) fn location(
        &self,
        span: Span,
        open: &BTreeMap<String, Document>,
    ) -> Option<Location> {
        let file = self.sources.file_of(span)?;
        let uri = uri_of(&file.name, open)?;
        let range = if self.is_here(span) {
            self.range(span)
        } else {
            Lines::of(&file.text).range(file, span)
        };
        Some(Location { uri, range })
    }
}

/// The name in a binder, without its `/`.
pub(super) fn without_slash(binder: Span) -> Span {
    Span { start: (binder.start + 1).min(binder.end), ..binder }
}

/// The names that the command line binds.
pub(super) fn predefined(inputs: &Inputs) -> Vec<(Arc<str>, Type)> {
    let type_of = |value: &Constant| match value {
        Constant::Bool(_) => Type::Bool,
        Constant::Int(_) => Type::Int,
        Constant::Real(_) => Type::Real,
        Constant::Str(_) => Type::Str,
        _ => Type::Any,
    };
    inputs.defines.iter().map(|d| (Arc::clone(&d.name), type_of(&d.value))).collect()
}
