//! Diagnostics for programs: one line each, as text or as JSON.

use compiler::diagnostic::{Diagnostic, Label};
use compiler::source::{SourceFile, SourceMap, Span};
use serde::Serialize;

use crate::clean::{clean, shortened};

#[derive(Serialize)]
struct Message<'a> {
    level: &'static str,
    code: Option<&'static str>,
    message: &'a str,
    spans: Vec<Place<'a>>,
    trace: Vec<Call<'a>>,
    notes: &'a [String],
    helps: Vec<String>,
}

/// A span; lines and columns count from 1, columns in characters; the end is exclusive.
#[derive(Serialize)]
struct Place<'a> {
    file: &'a str,
    line: usize,
    column: usize,
    end_line: usize,
    end_column: usize,
    #[serde(skip_serializing_if = "str::is_empty")]
    label: &'a str,
    primary: bool,
}

#[derive(Serialize)]
struct Call<'a> {
    file: &'a str,
    line: usize,
    column: usize,
    within: &'a str,
    repeats: usize,
}

/// `path:line:col: error[E0201]: text`, with a line end.
pub(crate) fn short(diagnostic: &Diagnostic, sources: &SourceMap) -> String {
    let span = diagnostic.primary.span;
    let place = sources
        .file_of(span)
        .map(|file| format!("{}:{}: ", clean(&file.name), file.line_column(span)));
    let code = diagnostic.code.as_str();
    format!(
        "{}error[{code}]: {}\n",
        place.unwrap_or_default(),
        clean(&shortened(&diagnostic.message))
    )
}

/// A diagnostic as one line of JSON.
pub(crate) fn json(
    diagnostic: &Diagnostic,
    sources: &SourceMap,
    replacement: Option<&str>,
) -> String {
    let suggestion = replacement.map(|name| format!("did you mean `{name}`?"));
    let secondary = diagnostic.secondary.iter().map(|label| (label, false));
    let labels = std::iter::once((&diagnostic.primary, true)).chain(secondary);
    line(&Message {
        level: "error",
        code: Some(diagnostic.code.as_str()),
        message: &diagnostic.message,
        spans: labels.filter_map(|(label, primary)| place(label, primary, sources)).collect(),
        trace: calls(diagnostic, sources),
        notes: &diagnostic.notes,
        helps: diagnostic.helps.iter().cloned().chain(suggestion).collect(),
    })
}

/// An error without a place as one line of JSON.
pub(crate) fn plain_json(message: &str) -> String {
    line(&Message {
        level: "error",
        code: None,
        message,
        spans: Vec::new(),
        trace: Vec::new(),
        notes: &[],
        helps: Vec::new(),
    })
}

fn line(message: &Message<'_>) -> String {
    serde_json::to_string(message).map_or_else(|error| error.to_string(), |text| text + "\n")
}

fn place<'a>(label: &'a Label, primary: bool, sources: &'a SourceMap) -> Option<Place<'a>> {
    let file = sources.file_of(label.span)?;
    let start = file.line_column(label.span);
    let end = file.line_column(end_of(label.span, file));
    Some(Place {
        file: &file.name,
        line: start.line,
        column: start.column,
        end_line: end.line,
        end_column: end.column,
        label: &label.text,
        primary,
    })
}

fn calls<'a>(diagnostic: &'a Diagnostic, sources: &'a SourceMap) -> Vec<Call<'a>> {
    let call = |entry: &'a compiler::diagnostic::TraceEntry| {
        let file = sources.file_of(entry.span)?;
        let at = file.line_column(entry.span);
        let (within, repeats) = (entry.within.as_str(), entry.repeats);
        Some(Call { file: &file.name, line: at.line, column: at.column, within, repeats })
    };
    diagnostic.trace.iter().filter_map(call).collect()
}

/// The empty span behind `span`.
fn end_of(span: Span, file: &SourceFile) -> Span {
    let end = file.range(span).end;
    file.span(end, end)
}
