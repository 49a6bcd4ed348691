//! What can be said of an error by looking at the source text again: what may be meant by a name that
//! is not bound, and where a file name was written.

use std::sync::Arc;

use compiler::ast::{Body, Term, TermKind};
use compiler::diagnostic::{Code, Diagnostic};
use compiler::op::Operator;
use compiler::source::{SourceMap, Span};
use compiler::suggest::similar_binder;

/// Shorter names are too much alike for "did you mean".
const MIN_NAME: usize = 3;

/// Looks for a name like the one that `diagnostic` says is not bound. Labels where it is bound, and
/// returns it unless it is the same name.
///
/// `tree` is asked for only if the diagnostic is of this kind.
pub(crate) fn add_meant(
    diagnostic: &mut Diagnostic,
    sources: &SourceMap,
    tree: impl FnOnce() -> Option<Body>,
) -> Option<String> {
    if diagnostic.code != Code::Unbound {
        return None;
    }
    add_similar(diagnostic, sources, &tree()?)
}

/// The same for a name that is known not to be bound, and a tree that is there.
pub(crate) fn add_similar(
    diagnostic: &mut Diagnostic,
    sources: &SourceMap,
    tree: &Body,
) -> Option<String> {
    let name = sources.text(diagnostic.primary.span);
    if let Some((similar, span)) = similar_binder(tree, name) {
        if similar == name {
            let text = "bound here, but not where it is used";
            diagnostic.secondary.push(label(span, text));
            return None;
        }
        if name.len() < MIN_NAME {
            return None;
        }
        diagnostic.secondary.push(label(span, "a similar name is bound here"));
        return Some(similar.to_owned());
    }
    let is_long = name.len() >= MIN_NAME;
    similar_binder(&operators(), name).filter(|_| is_long).map(|(operator, _)| operator.to_owned())
}

/// Labels the file name of an image that is not written, where it stands right before `render` and
/// is the one in question: the command line may have given another.
pub(crate) fn add_file_name(diagnostic: &mut Diagnostic, sources: &SourceMap) {
    if !matches!(diagnostic.code, Code::RefusedPath | Code::CannotWrite) {
        return;
    }
    let span = diagnostic.primary.span;
    let Some(file) = sources.file_of(span) else { return };
    let before = file.text[..file.range(span).start].trim_end();
    if let Some(rest) = before.strip_suffix('"')
        && let Some(start) = rest.rfind('"')
        && diagnostic.message.contains(&rest[start + 1..])
    {
        diagnostic.secondary.push(label(file.span(start, before.len()), "this name"));
    }
}

fn label(span: Span, text: &str) -> compiler::diagnostic::Label {
    compiler::diagnostic::Label { span, text: text.to_owned() }
}

/// The operators, as if a program bound them.
fn operators() -> Body {
    let term = |op: &Operator| {
        let kind = TermKind::Binder(Arc::from(op.spelling()));
        Term { kind, span: Span::NONE }
    };
    Operator::ALL.iter().map(term).collect()
}
