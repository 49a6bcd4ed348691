//! Diagnostics for people: message, source text with carets, calls, notes and advice.

use annotate_snippets::renderer::DEFAULT_TERM_WIDTH;
use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Patch, Renderer, Snippet};
use compiler::diagnostic::{Diagnostic, TraceEntry, grouped};
use compiler::source::{LineColumn, SourceMap, Span};

use crate::clean::{clean, clean_lines, shortened};
use crate::report::excerpt::{Excerpt, excerpts};

/// Of a long trace, this many entries are shown at each end.
const TRACE_ENDS: usize = 8;

/// Characters of source text beside an entry of a trace.
const TRACE_TEXT: usize = 32;

/// An error without a place.
pub(crate) fn plain(message: &str, color: bool) -> String {
    let group = Group::with_title(Level::ERROR.primary_title(message));
    format!("{}\n", renderer(color).render(&[group]))
}

/// The text of a diagnostic; `replacement` is what may be meant by its primary place.
pub(crate) fn render(
    diagnostic: &Diagnostic,
    sources: &SourceMap,
    replacement: Option<&str>,
    color: bool,
) -> String {
    let title = Level::ERROR
        .primary_title(clean(&shortened(&diagnostic.message)).into_owned())
        .id(diagnostic.code.as_str());
    let mut group = Group::with_title(title);
    let mut corrections = Vec::new();
    for excerpt in excerpts(diagnostic, sources) {
        corrections.extend(correction(&excerpt));
        group = group.element(snippet(excerpt));
    }
    if !diagnostic.trace.is_empty() {
        let calls = Level::NOTE.with_name("trace");
        group = group.element(calls.message(trace_text(&diagnostic.trace, sources)));
    }
    for note in &diagnostic.notes {
        group = group.element(Level::NOTE.message(clean_lines(note)));
    }
    for help in &diagnostic.helps {
        group = group.element(Level::HELP.message(clean_lines(help)));
    }
    let patch = replacement.and_then(|name| suggestion(diagnostic.primary.span, name, sources));
    let groups: Vec<_> = std::iter::once(group).chain(patch).collect();
    let text = renderer(color).render(&groups);
    corrections.iter().fold(text, |text, (shown, meant)| text.replacen(shown, meant, 1))
}

fn renderer(color: bool) -> Renderer {
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    renderer.term_width(DEFAULT_TERM_WIDTH)
}

/// Where the place of an excerpt is given by the line as shown, which may be cut: that text, and
/// what it must be.
fn correction(excerpt: &Excerpt<'_>) -> Option<(String, String)> {
    let LineColumn { line, column } = excerpt.place;
    let at = |column| format!("{}:{line}:{column}", clean(&excerpt.file.name));
    (column != excerpt.shown_column).then(|| (at(excerpt.shown_column), at(column)))
}

fn snippet<'a>(excerpt: Excerpt<'a>) -> Snippet<'a, Annotation<'a>> {
    let annotations = excerpt.marks.into_iter().map(|mark| {
        let kind = if mark.is_primary { AnnotationKind::Primary } else { AnnotationKind::Context };
        let annotation = kind.span(mark.range);
        if mark.label.is_empty() { annotation } else { annotation.label(clean(mark.label)) }
    });
    Snippet::source(excerpt.text)
        .path(clean(&excerpt.file.name))
        .line_start(excerpt.first_line)
        .annotations(annotations)
}

/// The line of `place` with another name in it; not for lines that are shown cut or changed.
fn suggestion<'a>(place: Span, name: &str, sources: &'a SourceMap) -> Option<Group<'a>> {
    const MAX_LINE: usize = 100;
    let file = sources.file_of(place)?;
    let at = file.line_column(place);
    let line = file.line(at.line).filter(|line| line.len() <= MAX_LINE)?;
    let is_plain = line.bytes().all(|b| matches!(b, b' '..=b'~'));
    let length = sources.text(place).len();
    let start = at.column - 1;
    if !is_plain || start + length > line.len() {
        return None;
    }
    let patch = Patch::new(start..start + length, name.to_owned());
    let title = Level::HELP.secondary_title(format!("did you mean `{name}`?"));
    Some(title.element(Snippet::source(line).line_start(at.line).patch(patch)))
}

fn trace_text(trace: &[TraceEntry], sources: &SourceMap) -> String {
    let rows: Vec<[String; 2]> = trace.iter().map(|entry| row(entry, sources)).collect();
    let is_shown = |idx: usize| idx < TRACE_ENDS || idx + TRACE_ENDS >= rows.len();
    let shown = || rows.iter().enumerate().filter(|(idx, _)| is_shown(*idx));
    let width = |column: usize| {
        shown().map(|(_, row)| row[column].chars().count()).max().unwrap_or_default()
    };
    let (place_width, text_width) = (width(0), width(1));
    let mut text = "calls, outermost first".to_owned();
    for (idx, [place, source]) in shown() {
        let within = shortened(&trace[idx].within);
        let within = clean(&within);
        text += &format!("\n{place:<place_width$}  {source:<text_width$}  in {within}");
        match trace[idx].repeats {
            0 | 1 => {}
            2 => text += "\n... the line above repeats once",
            n => text += &format!("\n... the line above repeats {} times", grouped(n as u64 - 1)),
        }
        if idx + 1 == TRACE_ENDS && rows.len() > 2 * TRACE_ENDS {
            let n_hidden = rows.len() - 2 * TRACE_ENDS;
            text += &format!("\n... {} more lines, not shown", grouped(n_hidden as u64));
        }
    }
    text
}

/// Place of a call, and the source text that leads up to it.
fn row(entry: &TraceEntry, sources: &SourceMap) -> [String; 2] {
    let Some(file) = sources.file_of(entry.span) else { return [String::new(), String::new()] };
    let at = file.line_column(entry.span);
    let place = format!("{}:{at}", clean(&file.name));
    let end = file.range(entry.span).end;
    let start = file.text[..end].rfind('\n').map_or(0, |at| at + 1);
    let window = file.text.floor_char_boundary(end.saturating_sub(4 * TRACE_TEXT)).max(start);
    let line = file.text[window..end].trim_start();
    let chars: Vec<char> = line.chars().collect();
    let last: String = chars[chars.len().saturating_sub(TRACE_TEXT)..].iter().collect();
    let is_cut = window > start || chars.len() > TRACE_TEXT;
    let dots = if is_cut { "..." } else { "" };
    [place, format!("{dots}{}", clean(&last))]
}

#[cfg(test)]
mod tests {
    use compiler::diagnostic::Code;

    use super::*;

    /// It takes gigabytes to provoke this one, so it is not among the tests of the command line.
    #[test]
    fn the_largest_programs_are_refused() {
        let text = "the program is too large";
        let diagnostic = Diagnostic::new(Code::ProgramTooLarge, Span::NONE, text);
        let shown = render(&diagnostic, &SourceMap::default(), None, false);
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/diagnostics/E0014.txt");
        if std::env::var_os("GMLVM_BLESS").is_some() {
            std::fs::write(path, format!("{shown}\n")).expect("a golden file");
        }
        let expected = std::fs::read_to_string(path).expect("part of the project");
        assert_eq!(format!("{shown}\n"), expected);
    }
}
