//! Why a surface function stays with the interpreter.

use compiler::source::Span;

/// The compiler declines a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unsupported {
    /// Where the reason lies.
    pub span: Span,
    /// The reason: lower case, no full stop.
    pub reason: String,
}
