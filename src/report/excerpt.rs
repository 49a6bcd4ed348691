//! The source lines that a diagnostic shows, made fit to be shown: long lines are cut, control
//! characters made visible, and lines that nobody points at left empty.

use std::ops::Range;

use compiler::diagnostic::{Diagnostic, Label};
use compiler::source::{LineColumn, SourceFile, SourceMap};

use crate::clean;

/// A longer line is cut to about this many bytes around its first mark.
const MAX_LINE: usize = 240;

/// When a line is cut, this many bytes before its first mark are kept.
const LINE_LEAD: usize = 60;

/// A mark over more bytes covers the opening bracket only.
const MAX_MARK: usize = 160;

/// Marks further apart than this many lines are shown in excerpts of their own.
const MAX_GAP: usize = 400;

/// Consecutive lines of one file, and the marks in them.
pub(crate) struct Excerpt<'a> {
    /// The file.
    pub(crate) file: &'a SourceFile,
    /// The place that the excerpt is about.
    pub(crate) place: LineColumn,
    /// The column of the place in the line as shown, from 1.
    pub(crate) shown_column: usize,
    /// Number of the first line.
    pub(crate) first_line: usize,
    /// The lines as shown.
    pub(crate) text: String,
    /// What is marked.
    pub(crate) marks: Vec<Mark<'a>>,
}

/// A marked piece of an excerpt.
pub(crate) struct Mark<'a> {
    /// Bytes of the excerpt's text.
    pub(crate) range: Range<usize>,
    /// What to write beside it; may be empty.
    pub(crate) label: &'a str,
    /// Whether it is the place that the message is about.
    pub(crate) is_primary: bool,
}

/// A label within its line.
struct Spot<'a> {
    label: &'a Label,
    is_primary: bool,
    file: &'a SourceFile,
    line: usize,
    /// Bytes of the line.
    range: Range<usize>,
}

/// The excerpts of a diagnostic; the one with the primary place comes first.
pub(crate) fn excerpts<'a>(diagnostic: &'a Diagnostic, sources: &'a SourceMap) -> Vec<Excerpt<'a>> {
    let labels = std::iter::once(&diagnostic.primary).chain(&diagnostic.secondary);
    let mut spots: Vec<Spot<'_>> =
        labels.enumerate().filter_map(|(idx, label)| Spot::new(label, idx == 0, sources)).collect();
    spots.sort_by_key(|spot| spot.label.span);
    let is_apart = |a: &Spot<'_>, b: &Spot<'_>| {
        !std::ptr::eq(a.file, b.file) || b.line.saturating_sub(a.line) > MAX_GAP
    };
    let mut excerpts: Vec<_> = spots.chunk_by(|a, b| !is_apart(a, b)).map(Excerpt::new).collect();
    excerpts.sort_by_key(|excerpt| !excerpt.marks.iter().any(|mark| mark.is_primary));
    excerpts
}

impl<'a> Spot<'a> {
    fn new(label: &'a Label, is_primary: bool, sources: &'a SourceMap) -> Option<Self> {
        let file = sources.file_of(label.span)?;
        let line = file.line_column(label.span).line;
        let text = file.line(line)?;
        let bytes = file.range(label.span);
        let line_start = file.text[..bytes.start].rfind('\n').map_or(0, |at| at + 1);
        let start = (bytes.start - line_start).min(text.len());
        let end = bytes.end.max(bytes.start) - line_start;
        let is_long = end > text.len() || end - start > MAX_MARK;
        let end = if is_long && text[start..].starts_with(['{', '[']) {
            start + 1
        } else {
            end.min(text.len())
        };
        Some(Spot { label, is_primary, file, line, range: start..end })
    }
}

impl<'a> Excerpt<'a> {
    /// Spots are of one file, sorted, and at least one.
    fn new(spots: &[Spot<'a>]) -> Self {
        let file = spots[0].file;
        let (first_line, last_line) = (spots[0].line, spots[spots.len() - 1].line);
        let about = spots.iter().position(|spot| spot.is_primary).unwrap_or(0);
        let mut excerpt = Excerpt {
            file,
            place: file.line_column(spots[about].label.span),
            shown_column: 1,
            first_line,
            text: String::new(),
            marks: Vec::new(),
        };
        for line in first_line..=last_line {
            let here: Vec<_> = spots.iter().filter(|spot| spot.line == line).collect();
            let is_near = spots.iter().any(|spot| spot.line.abs_diff(line) <= 2);
            if is_near {
                excerpt.push_line(file.line(line).unwrap_or_default(), &here);
            }
            excerpt.text.push('\n');
        }
        // Each spot has become one mark, in the same order.
        let before = &excerpt.text[..excerpt.marks[about].range.start];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        excerpt.shown_column = before[line_start..].chars().count() + 1;
        excerpt
    }

    fn push_line(&mut self, line: &str, spots: &[&Spot<'a>]) {
        let window = window(line, spots.first().map_or(0, |spot| spot.range.start));
        if window.start > 0 {
            self.text.push_str("...");
        }
        let mut shown_at = Vec::new();
        for (at, c) in line[window.clone()].char_indices() {
            shown_at.push((window.start + at, self.text.len()));
            if c == '\t' { self.text.push(c) } else { clean::push(&mut self.text, c) }
        }
        let end = self.text.len();
        if window.end < line.len() {
            self.text.push_str("...");
        }
        let shown = |byte: usize| {
            let next = shown_at.partition_point(|&(at, _)| at < byte);
            shown_at.get(next).map_or(end, |&(_, shown)| shown)
        };
        for spot in spots {
            self.marks.push(Mark {
                range: shown(spot.range.start)..shown(spot.range.end),
                label: &spot.label.text,
                is_primary: spot.is_primary,
            });
        }
    }
}

/// The bytes of a line that are shown, when the first mark is at `mark`.
fn window(line: &str, mark: usize) -> Range<usize> {
    if line.len() <= MAX_LINE {
        return 0..line.len();
    }
    let start = line.floor_char_boundary(mark.saturating_sub(LINE_LEAD));
    let end = line.floor_char_boundary((start + MAX_LINE).min(line.len()));
    start..end
}
