//! Source files and the positions in them.
//!
//! All files of a program (the scene and what it includes) lie one behind the other in one address
//! space, so that a position is a single number and a [`Span`] names its file as well.

use std::fmt;

use crate::lexer::MAX_TOKENS;

/// The most bytes of source text that a program may have, included files counted each time.
pub const MAX_SOURCE_BYTES: usize = 64 << 20;

/// A byte range in the address space of a [`SourceMap`]; empty at 0 when there is no source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// Address of the first byte.
    pub start: u32,
    /// Address behind the last byte.
    pub end: u32,
}

impl Span {
    /// The span that stands for "no source text".
    pub const NONE: Span = Span { start: 0, end: 0 };

    /// The smallest span that covers both.
    #[must_use]
    pub fn to(self, other: Span) -> Span {
        if self.is_none() {
            return other;
        }
        if other.is_none() {
            return self;
        }
        Span { start: self.start.min(other.start), end: self.end.max(other.end) }
    }

    /// Whether this span stands for "no source text".
    #[must_use]
    pub fn is_none(self) -> bool {
        self == Span::NONE
    }
}

/// Index of a file in its [`SourceMap`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FileId(u32);

/// One file: its name as shown to the user, its text, and where its lines start.
#[derive(Debug)]
pub struct SourceFile {
    /// The name shown in diagnostics; also what relative includes are resolved against.
    pub name: String,
    /// The text. Bytes that are not UTF-8 are read as Latin-1, as in old scenes.
    pub text: String,
    start: u32,
    /// What stands before each block of the text, and before its end.
    before: Vec<Before>,
}

/// Of what stands before a place in a text, the characters and the ends of lines.
#[derive(Clone, Copy, Debug, Default)]
struct Before {
    chars: u32,
    lines: u32,
}

/// Characters and lines are counted ahead for blocks of so many bytes, so that no line is too long to find a
/// column in it.
const BLOCK: usize = 1 << 10;

/// A place in a file, counted from 1; columns count characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineColumn {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl fmt::Display for LineColumn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}

/// The program's text would be longer than [`MAX_SOURCE_BYTES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SourceTooLarge;

/// The text of a file: UTF-8, or else Latin-1, which any bytes are.
#[must_use]
pub fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes)
        .unwrap_or_else(|error| error.into_bytes().iter().copied().map(char::from).collect())
}

/// All files of one program.
#[derive(Debug)]
pub struct SourceMap {
    files: Vec<SourceFile>,
    max_words: usize,
}

impl Default for SourceMap {
    /// No files, of a program that may have [`MAX_TOKENS`] words.
    fn default() -> Self {
        SourceMap::with_max_words(MAX_TOKENS)
    }
}

impl SourceMap {
    /// No files, of a program that may have so many words, but not more than [`MAX_TOKENS`].
    #[must_use]
    pub fn with_max_words(max_words: usize) -> Self {
        SourceMap { files: Vec::new(), max_words: max_words.min(MAX_TOKENS) }
    }

    /// The most words that the program may have.
    #[must_use]
    pub fn max_words(&self) -> usize {
        self.max_words
    }

    /// Adds a file and gives it the next free addresses.
    ///
    /// # Errors
    /// When the program's text would be longer than [`MAX_SOURCE_BYTES`].
    pub fn add(&mut self, name: &str, bytes: Vec<u8>) -> Result<FileId, SourceTooLarge> {
        let text = text(bytes);
        // Address 0 is kept for `Span::NONE`; the gap of one keeps the ends of files apart.
        let start = self.files.last().map_or(1, |last| last.start as usize + last.text.len() + 1);
        if start + text.len() > MAX_SOURCE_BYTES {
            return Err(SourceTooLarge);
        }
        let mut before = vec![Before::default()];
        before.extend(text.as_bytes().chunks(BLOCK).scan(Before::default(), |before, block| {
            before.chars += char_starts(block) as u32;
            before.lines += line_ends(block) as u32;
            Some(*before)
        }));
        self.files.push(SourceFile { name: name.to_owned(), text, start: start as u32, before });
        Ok(FileId(self.files.len() as u32 - 1))
    }

    /// The file with this index.
    #[must_use]
    pub fn file(&self, id: FileId) -> &SourceFile {
        &self.files[id.0 as usize]
    }

    /// All files, in the order in which they were added.
    pub fn files(&self) -> impl Iterator<Item = &SourceFile> {
        self.files.iter()
    }

    /// The file that holds `span`, unless it is [`Span::NONE`].
    #[must_use]
    pub fn file_of(&self, span: Span) -> Option<&SourceFile> {
        if span.is_none() {
            return None;
        }
        let next = self.files.partition_point(|file| file.start <= span.start);
        next.checked_sub(1).map(|idx| &self.files[idx])
    }

    /// The text that `span` covers, empty for [`Span::NONE`].
    #[must_use]
    pub fn text(&self, span: Span) -> &str {
        self.file_of(span).map_or("", |file| &file.text[file.range(span)])
    }
}

impl SourceFile {
    /// The span of the bytes `start..end` of this file.
    #[must_use]
    pub fn span(&self, start: usize, end: usize) -> Span {
        Span { start: self.start + start as u32, end: self.start + end as u32 }
    }

    /// The byte range of `span` in this file's text, cut at the file's end.
    #[must_use]
    pub fn range(&self, span: Span) -> std::ops::Range<usize> {
        let at = |address: u32| (address.saturating_sub(self.start) as usize).min(self.text.len());
        at(span.start)..at(span.end)
    }

    /// Line and column where `span` starts.
    #[must_use]
    pub fn line_column(&self, span: Span) -> LineColumn {
        let start = self.range(span).start;
        let block = start / BLOCK;
        let n_ends = self.before[block].lines as usize
            + line_ends(&self.text.as_bytes()[block * BLOCK..start]);
        let line_start = self.behind_line_end(n_ends).unwrap_or(start);
        let column = self.chars_before(start) - self.chars_before(line_start) + 1;
        LineColumn { line: n_ends + 1, column }
    }

    /// Where the line begins that has so many line ends before it; `None` behind the last line.
    fn behind_line_end(&self, number: usize) -> Option<usize> {
        if number == 0 {
            return Some(0);
        }
        // The line end is in the last block that has not as many before it.
        let block = self.before.partition_point(|before| (before.lines as usize) < number) - 1;
        let start = block * BLOCK;
        let bytes = self.text.as_bytes().get(start..)?;
        let ends = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
        let (at, _) = { ends }.nth(number - 1 - self.before[block].lines as usize)?;
        Some(start + at + 1)
    }

    /// Number of characters that start before a byte of the text.
    fn chars_before(&self, byte: usize) -> usize {
        let block = byte / BLOCK;
        self.before[block].chars as usize + char_starts(&self.text.as_bytes()[block * BLOCK..byte])
    }

    /// The text of line `line` (from 1), without its line end; `None` behind the last line.
    #[must_use]
    pub fn line(&self, line: usize) -> Option<&str> {
        let start = self.behind_line_end(line.checked_sub(1)?)?;
        let end = self.behind_line_end(line).unwrap_or(self.text.len());
        Some(self.text[start..end].trim_end_matches(['\n', '\r']))
    }
}

/// Number of line ends in a piece of text.
fn line_ends(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte == b'\n').count()
}

/// Number of characters that start in a piece of UTF-8.
fn char_starts(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte & 0xc0 != 0x80).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters() {
        let text = format!("{}\n\u{e9}x\n{}y", "\u{20ac}ab".repeat(700), "\u{1f98a}".repeat(1000));
        let mut sources = SourceMap::default();
        sources.add("a", b"1 2".to_vec()).expect("short");
        let id = sources.add("b", text.clone().into_bytes()).expect("short");
        let file = sources.file(id);
        let (mut line, mut column) = (1, 1);
        for (at, c) in text.char_indices() {
            assert_eq!(file.line_column(file.span(at, at)), LineColumn { line, column }, "{at}");
            (line, column) = if c == '\n' { (line + 1, 1) } else { (line, column + 1) };
        }
        let end = file.span(text.len(), text.len());
        assert_eq!(file.line_column(end), LineColumn { line, column });
    }

    /// Wherever lines end between the blocks that are counted ahead.
    #[test]
    fn lines_are_those_of_the_text() {
        for (n, length) in [(0, 0), (1, 0), (3, BLOCK - 1), (3, BLOCK), (2, 3 * BLOCK), (5000, 1)] {
            for end in ["", "\n", "\n\n", "z\r\n"] {
                let text = format!("{}\n", "x".repeat(length)).repeat(n) + end;
                let mut sources = SourceMap::default();
                let id = sources.add("a", text.clone().into_bytes()).expect("short");
                let file = sources.file(id);
                let lines: Vec<_> = text.split('\n').map(|line| line.trim_end()).collect();
                let found: Vec<_> = (1..=lines.len()).map(|n| file.line(n)).collect();
                assert_eq!(
                    found,
                    lines.iter().copied().map(Some).collect::<Vec<_>>(),
                    "{n} {length}"
                );
                assert_eq!((file.line(0), file.line(lines.len() + 1)), (None, None));
            }
        }
    }
}
