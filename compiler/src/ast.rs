//! The tree of a program, as written.
//!
//! GML's syntax is flat but for `{ }` and `[ ]`; names are not yet resolved.

use std::sync::Arc;

use crate::op::Operator;
use crate::source::Span;

/// A sequence of terms: the program itself, or what stands between brackets.
pub type Body = Vec<Term>;

/// One term and its place; a bracketed term's span covers both brackets.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// What it is.
    pub kind: TermKind,
    /// Where it stands.
    pub span: Span,
}

/// The kinds of term.
#[derive(Clone, Debug, PartialEq)]
pub enum TermKind {
    /// `true` or `false`.
    Bool(bool),
    /// An integer literal.
    Int(i64),
    /// A real literal.
    Real(f64),
    /// A string literal, without its quotes.
    Str(Arc<str>),
    /// One of the reserved operator names.
    Operator(Operator),
    /// `x`.
    Name(Arc<str>),
    /// `/x`.
    Binder(Arc<str>),
    /// `{ ... }`.
    Function(Body),
    /// `[ ... ]`.
    Array(Body),
}
