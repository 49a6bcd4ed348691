//! Places in texts as editors count them: lines from 0, columns in units of UTF-16 from 0.

use compiler::source::{SourceFile, Span};

use crate::lsp::types::{Position, Range};

/// Where the lines of a text start. A line ends with LF, CR LF or CR.
#[derive(Debug)]
pub(super) struct Lines {
    starts: Vec<usize>,
}

impl Lines {
    pub(super) fn of(text: &str) -> Self {
        let bytes = text.as_bytes();
        let ends = |&(at, byte): &(usize, &u8)| {
            *byte == b'\n' || (*byte == b'\r' && bytes.get(at + 1) != Some(&b'\n'))
        };
        let behind = bytes.iter().enumerate().filter(ends).map(|(at, _)| at + 1);
        Lines { starts: std::iter::once(0).chain(behind).collect() }
    }

    /// The place of a byte of the text that the lines are of.
    pub(super) fn position(&self, text: &str, byte: usize) -> Position {
        let byte = text.floor_char_boundary(byte.min(text.len()));
        let line = self.starts.partition_point(|&start| start <= byte) - 1;
        let column: usize = text[self.starts[line]..byte].chars().map(char::len_utf16).sum();
        Position { line: line as u32, character: column as u32 }
    }

    /// The byte at a place. What lies behind the end of a line, or of the text, is that end.
    pub(super) fn byte(&self, text: &str, place: Position) -> usize {
        let Some(&start) = self.starts.get(place.line as usize) else { return text.len() };
        let end = self.starts.get(place.line as usize + 1).map_or(text.len(), |&next| {
            let line = &text[start..next];
            start + line.trim_end_matches(['\r', '\n']).len()
        });
        let mut left = place.character as usize;
        for (at, c) in text[start..end].char_indices() {
            if left < c.len_utf16() {
                return start + at;
            }
            left -= c.len_utf16();
        }
        end
    }

    /// The places of a span of a file, whose lines these are.
    pub(super) fn range(&self, file: &SourceFile, span: Span) -> Range {
        let bytes = file.range(span);
        Range {
            start: self.position(&file.text, bytes.start),
            end: self.position(&file.text, bytes.end),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_units_of_utf_16_and_lines_end_in_three_ways() {
        let text = "a\u{e9}\u{1f98a}b\r\nc\rd\n\ne";
        let lines = Lines::of(text);
        let at = |needle: char| {
            let place = lines.position(text, text.find(needle).expect("in the text"));
            (place.line, place.character)
        };
        assert_eq!(
            ['\u{e9}', '\u{1f98a}', 'b', 'c', 'd', 'e'].map(at),
            [(0, 1), (0, 2), (0, 4), (1, 0), (2, 0), (4, 0)]
        );
        for (byte, c) in text.char_indices().filter(|(_, c)| !c.is_control()) {
            assert_eq!(lines.byte(text, lines.position(text, byte)), byte, "{c}");
        }
        let byte = |line, character| lines.byte(text, Position { line, character });
        // Within the fox, behind the end of a line, and of the text.
        assert_eq!([byte(0, 3), byte(0, 99), byte(3, 5), byte(9, 0)], [3, 8, 14, text.len()]);
    }
}
