//! The text of one file to tokens.
//!
//! A [`Lexer`] runs until it meets a preprocessor line, which it hands to
//! [`preprocess`](crate::preprocess), or the end of the file. After an error it goes on behind the
//! offending text, so that one run finds all the mistakes of this kind.

use std::collections::HashSet;
use std::sync::Arc;

use crate::diagnostic::{Code, Diagnostic};
use crate::op::Operator;
use crate::source::{SourceFile, Span};

/// Lexing stops after so many errors.
pub const MAX_DIAGNOSTICS: usize = 20;

/// The most words of a program, included files counted each time. A hundred thousand solids written
/// out one by one take about a quarter of it. Of the programs tried, as many words in empty functions
/// take the most to compile: 1.6 GB.
pub const MAX_TOKENS: usize = 1 << 22;

/// One word of a program, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// Where it stands.
    pub span: Span,
    /// For the first token of a line, the columns before it (tab stops are 8 apart).
    pub indent: Option<u16>,
}

/// The kinds of token.
#[derive(Clone, Debug, PartialEq)]
pub enum TokenKind {
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
    /// `{`.
    OpenFunction,
    /// `}`.
    CloseFunction,
    /// `[`.
    OpenArray,
    /// `]`.
    CloseArray,
}

/// What the files of a program amount to so far.
#[derive(Debug, Default)]
pub(crate) struct Output {
    pub(crate) tokens: Vec<Token>,
    pub(crate) diagnostics: Vec<Diagnostic>,
    pub(crate) stopped: bool,
    /// There may be so many.
    max_tokens: usize,
    // Equal names share their text: a large program is mostly repetition.
    names: HashSet<Arc<str>>,
}

impl Output {
    pub(crate) fn new(max_tokens: usize) -> Self {
        Output { max_tokens, ..Output::default() }
    }

    /// Keeps the diagnostic, or stops everything when there are too many.
    pub(crate) fn report(&mut self, diagnostic: Diagnostic) {
        if self.diagnostics.len() < MAX_DIAGNOSTICS {
            self.diagnostics.push(diagnostic);
        } else if let Some(last) = self.diagnostics.last_mut().filter(|_| !self.stopped) {
            last.notes.push("there are more errors, which are not shown".to_owned());
            self.stopped = true;
        }
    }

    /// Keeps the diagnostic and stops everything.
    pub(crate) fn abort(&mut self, diagnostic: Diagnostic) {
        self.report(diagnostic);
        self.stopped = true;
    }

    fn intern(&mut self, text: &str) -> Arc<str> {
        if let Some(name) = self.names.get(text) {
            return Arc::clone(name);
        }
        let name: Arc<str> = text.into();
        self.names.insert(Arc::clone(&name));
        name
    }
}

/// How far a file has been read.
#[derive(Debug)]
pub(crate) struct Cursor {
    at: usize,
    line_start: usize,
    /// Nothing but white space stands between the line's start and here.
    fresh: bool,
}

impl Cursor {
    pub(crate) fn new() -> Self {
        Cursor { at: 0, line_start: 0, fresh: true }
    }
}

/// A preprocessor line.
#[derive(Debug)]
pub(crate) struct DirectiveLine {
    /// Byte position of the text.
    pub(crate) at: usize,
    /// What follows the `#`, with blanks in place of comments.
    pub(crate) text: String,
}

/// Reads one file from where its cursor stands.
pub(crate) struct Lexer<'a> {
    file: &'a SourceFile,
    bytes: &'a [u8],
    cursor: &'a mut Cursor,
    out: &'a mut Output,
}

impl<'a> Lexer<'a> {
    pub(crate) fn new(file: &'a SourceFile, cursor: &'a mut Cursor, out: &'a mut Output) -> Self {
        Lexer { file, bytes: file.text.as_bytes(), cursor, out }
    }

    /// Reads tokens up to the next preprocessor line; `None` at the end of the file.
    pub(crate) fn tokens(&mut self) -> Option<DirectiveLine> {
        while !self.out.stopped {
            self.skip_blanks();
            let byte = self.peek(0)?;
            if byte == b'#' && self.cursor.fresh {
                return Some(self.directive_line());
            }
            self.token(byte);
        }
        None
    }

    /// Skips everything up to the next preprocessor line; `None` at the end of the file.
    pub(crate) fn skip_group(&mut self) -> Option<DirectiveLine> {
        loop {
            self.skip_blanks();
            let byte = self.peek(0)?;
            if byte == b'#' && self.cursor.fresh {
                return Some(self.directive_line());
            }
            self.cursor.fresh = false;
            self.cursor.at += 1;
            if byte == b'"' {
                self.skip_while(|b| b != b'"' && !is_line_end(b));
                self.cursor.at += usize::from(self.peek(0) == Some(b'"'));
            }
        }
    }

    fn directive_line(&mut self) -> DirectiveLine {
        let at = self.cursor.at + 1;
        let mut text = Vec::new();
        let mut in_quotes = false;
        self.cursor.at = at;
        while let Some(byte) = self.peek(0).filter(|&b| !is_line_end(b)) {
            in_quotes ^= byte == b'"';
            if byte == b'/' && self.peek(1) == Some(b'*') && !in_quotes {
                self.skip_comment();
            } else if byte == b'\\' && self.peek(1).is_some_and(is_line_end) {
                // A backslash continues the line, so that no macro body is taken for GML.
                let is_crlf = self.bytes[self.cursor.at + 1..].starts_with(b"\r\n");
                self.cursor.at += if is_crlf { 3 } else { 2 };
            } else {
                text.push(byte);
                self.cursor.at += 1;
            }
            text.resize(self.cursor.at - at, b' ');
        }
        let text = String::from_utf8(text).expect("only whole comments were replaced");
        DirectiveLine { at, text }
    }

    fn skip_blanks(&mut self) {
        while let Some(byte) = self.peek(0) {
            match byte {
                b' ' | b'\t' | b'\x0c' => self.cursor.at += 1,
                _ if is_line_end(byte) => {
                    self.cursor.at += 1;
                    self.cursor.line_start = self.cursor.at;
                    self.cursor.fresh = true;
                }
                b'%' => self.skip_while(|b| !is_line_end(b)),
                b'/' if self.peek(1) == Some(b'*') => self.skip_comment(),
                _ => break,
            }
        }
    }

    /// Skips a `/* */` comment. As in C, line ends inside it do not start a new line.
    fn skip_comment(&mut self) {
        let start = self.cursor.at;
        let end = self.file.text[start + 2..].find("*/").map(|length| start + 2 + length + 2);
        if end.is_none() {
            let span = self.file.span(start, start + 2);
            self.out.report(
                Diagnostic::new(Code::CommentUnclosed, span, "`/*` comment is never closed")
                    .label("opened here"),
            );
        }
        self.cursor.at = end.unwrap_or(self.bytes.len());
        let comment = &self.bytes[start..self.cursor.at];
        if let Some(last) = comment.iter().rposition(|&b| is_line_end(b)) {
            self.cursor.line_start = start + last + 1;
        }
    }

    fn token(&mut self, first: u8) {
        let start = self.cursor.at;
        let indent = self.cursor.fresh.then(|| indent(&self.bytes[self.cursor.line_start..start]));
        self.cursor.fresh = false;
        let kind = match first {
            b'{' => self.bracket(TokenKind::OpenFunction),
            b'}' => self.bracket(TokenKind::CloseFunction),
            b'[' => self.bracket(TokenKind::OpenArray),
            b']' => self.bracket(TokenKind::CloseArray),
            b'"' => self.string(),
            b'/' => self.binder(),
            _ if first.is_ascii_alphabetic() => Some(self.identifier()),
            _ if self.is_number(start) => self.number(),
            _ => self.bad_characters(),
        };
        let Some(kind) = kind else { return };
        let span = self.since(start);
        let limit = self.out.max_tokens;
        if self.out.tokens.len() == limit {
            let message = format!("the program has more than {limit} words");
            let diagnostic = Diagnostic::new(Code::SourceTooLarge, span, message);
            return self.out.abort(match limit {
                MAX_TOKENS.. => diagnostic,
                _ => diagnostic.help("raise the limit with `--max-words N`"),
            });
        }
        self.out.tokens.push(Token { kind, span, indent });
    }

    fn bracket(&mut self, kind: TokenKind) -> Option<TokenKind> {
        self.cursor.at += 1;
        Some(kind)
    }

    fn identifier(&mut self) -> TokenKind {
        let start = self.cursor.at;
        self.skip_while(is_identifier_tail);
        match self.text(start) {
            "true" => TokenKind::Bool(true),
            "false" => TokenKind::Bool(false),
            name => match Operator::from_spelling(name) {
                Some(op) => TokenKind::Operator(op),
                None => TokenKind::Name(self.out.intern(name)),
            },
        }
    }

    fn binder(&mut self) -> Option<TokenKind> {
        let start = self.cursor.at;
        self.cursor.at += 1;
        if !self.peek(0).is_some_and(|b| b.is_ascii_alphabetic()) {
            self.bad_binder(start);
            return None;
        }
        let name = match self.identifier() {
            TokenKind::Name(name) => return Some(TokenKind::Binder(name)),
            TokenKind::Bool(_) => "a boolean",
            _ => "an operator",
        };
        let word = self.text(start + 1);
        let message = format!("`{word}` is {name} and cannot be bound");
        let help = format!("only the exact name is reserved: `/my-{word}` is fine");
        self.error(Code::ReservedBinder, start, message, Some(help));
        None
    }

    fn bad_binder(&mut self, start: usize) {
        let (message, help) = match self.peek(0) {
            // Whoever writes `//` means the rest of the line to be a comment.
            Some(b'/') => {
                self.cursor.at += 1;
                (
                    "`//` is not GML",
                    Some("a comment starts with `%`, or stands between `/*` and `*/`"),
                )
            }
            Some(byte) if is_identifier_tail(byte) => {
                self.skip_while(is_identifier_tail);
                let message = format!("`{}` binds no identifier", shown(self.text(start)));
                let help = Some("an identifier starts with a letter".to_owned());
                return self.error(Code::BadBinder, start, message, help);
            }
            Some(b' ' | b'\t') => {
                ("`/` binds no identifier", Some("no blank may stand between `/` and the name"))
            }
            _ => ("`/` binds no identifier", None),
        };
        self.error(Code::BadBinder, start, message.to_owned(), help.map(str::to_owned));
        if self.bytes[start + 1..].starts_with(b"/") {
            self.skip_while(|b| !is_line_end(b));
        }
    }

    fn string(&mut self) -> Option<TokenKind> {
        let start = self.cursor.at;
        self.cursor.at += 1;
        self.skip_while(|b| !matches!(b, b'"' | b'\n' | b'\r'));
        if self.peek(0) != Some(b'"') {
            let message = "string is not closed at the end of the line".to_owned();
            let help = "a string ends at the next `\"`, on the same line".to_owned();
            self.error(Code::BadString, start, message, Some(help));
            return None;
        }
        self.cursor.at += 1;
        let content = &self.file.text[start + 1..self.cursor.at - 1];
        let bad = content.char_indices().find(|(_, c)| !matches!(c, ' '..='~'));
        let Some((offset, c)) = bad else {
            return Some(TokenKind::Str(self.out.intern(content)));
        };
        let at = start + 1 + offset;
        let message = format!("string holds the character `{}`", shown(c.encode_utf8(&mut [0; 4])));
        self.out.report(
            Diagnostic::new(Code::BadString, self.file.span(at, at + c.len_utf8()), message)
                .label("not printable ASCII"),
        );
        None
    }

    /// Reads the longest number: the `.` of `1.` and the `e` of `1e` are left for what follows.
    fn number(&mut self) -> Option<TokenKind> {
        let start = self.cursor.at;
        let mut is_real = false;
        self.cursor.at += 1;
        self.skip_while(|b| b.is_ascii_digit());
        if self.peek(0) == Some(b'.') && self.peek(1).is_some_and(|b| b.is_ascii_digit()) {
            is_real = true;
            self.cursor.at += 1;
            self.skip_while(|b| b.is_ascii_digit());
        }
        if matches!(self.peek(0), Some(b'e' | b'E')) && self.is_number(self.cursor.at + 1) {
            is_real = true;
            self.cursor.at += 2;
            self.skip_while(|b| b.is_ascii_digit());
        }
        if is_real { self.real(start) } else { self.integer(start) }
    }

    fn integer(&mut self, start: usize) -> Option<TokenKind> {
        let digits = self.text(start);
        if let Ok(value) = digits.parse() {
            return Some(TokenKind::Int(value));
        }
        let message = format!("`{}` does not fit in a 64-bit integer", shown(digits));
        let help = format!("integers run from {} to {}; a real has a point", i64::MIN, i64::MAX);
        self.error(Code::BadNumber, start, message, Some(help));
        None
    }

    fn real(&mut self, start: usize) -> Option<TokenKind> {
        let digits = self.text(start);
        if let Some(value) = digits.parse().ok().filter(|value: &f64| value.is_finite()) {
            return Some(TokenKind::Real(value));
        }
        let message = format!("`{}` is beyond the range of reals", shown(digits));
        let help = "reals run up to about 1.8e308 in magnitude".to_owned();
        self.error(Code::BadNumber, start, message, Some(help));
        None
    }

    fn bad_characters(&mut self) -> Option<TokenKind> {
        let start = self.cursor.at;
        while let Some(byte) = self.peek(0).filter(|_| !self.starts_token(self.cursor.at)) {
            self.cursor.at += 1;
            if byte == b'*' && self.peek(0) == Some(b'/') {
                self.cursor.at += 1;
                break;
            }
        }
        let run = self.text(start);
        let s = if run.chars().nth(1).is_some() { "s" } else { "" };
        let message = format!("unexpected character{s} `{}`", shown(run));
        let help = self.advice(start, run);
        self.error(Code::BadCharacter, start, message, help);
        None
    }

    /// What someone who wrote these characters may have meant.
    fn advice(&self, start: usize, run: &str) -> Option<String> {
        let text = match run.chars().next()? {
            '.' => return Some(self.point_advice(start, "", start + 1)),
            '-' if run == "-." => return Some(self.point_advice(start, "-", start + 2)),
            '-' => {
                "a number's `-` has a digit behind it; `subi` and `subf` subtract, `negi` and `negf` negate"
            }
            '+' if self.file.text[..start].ends_with(['e', 'E']) => {
                "an exponent has no `+` sign: write `1e5`"
            }
            '+' => "a number has no `+` sign; `addi` adds integers, `addf` reals",
            '#' => "a preprocessor line has `#` at its start; comments start with `%`",
            '\'' | '\u{2018}'..='\u{201f}' => "a string stands between two `\"`",
            ',' | ';' => "white space is all that separates values",
            '(' | ')' => {
                "operands stand before their operator, as in `1 2 addi`, without parentheses"
            }
            '*' if run.ends_with("*/") => "no `/*` comment is open here",
            '_' => "an identifier starts with a letter",
            '\u{feff}' => "save the file without a byte order mark",
            _ => return None,
        };
        Some(text.to_owned())
    }

    /// For a point that lacks a digit on one side: how to write that real.
    fn point_advice(&self, start: usize, sign: &str, behind: usize) -> String {
        let before = &self.file.text[..start];
        let whole = &before[before.trim_end_matches(|c: char| c.is_ascii_digit()).len()..];
        let after = &self.file.text[behind..];
        let n_digits = after.bytes().take_while(u8::is_ascii_digit).count();
        let fraction = &after[..n_digits];
        let rule = "a real number has a digit on both sides of its point";
        match (whole, fraction) {
            ("", "") => rule.to_owned(),
            ("", _) => format!("{rule}: write `{sign}0.{}`", shown(fraction)),
            (_, "") => format!("{rule}: write `{}.0`", shown(whole)),
            _ => rule.to_owned(),
        }
    }

    fn starts_token(&self, at: usize) -> bool {
        let byte = self.bytes[at];
        byte.is_ascii_alphabetic()
            || matches!(byte, b' ' | b'\t' | b'\x0c' | b'%' | b'/' | b'"')
            || matches!(byte, b'{' | b'}' | b'[' | b']')
            || is_line_end(byte)
            || self.is_number(at)
    }

    /// Whether digits, perhaps behind a `-`, stand here.
    fn is_number(&self, at: usize) -> bool {
        let at = at + usize::from(self.bytes.get(at) == Some(&b'-'));
        self.bytes.get(at).is_some_and(u8::is_ascii_digit)
    }

    fn error(&mut self, code: Code, start: usize, message: String, help: Option<String>) {
        let mut diagnostic = Diagnostic::new(code, self.since(start), message);
        diagnostic.helps.extend(help);
        self.out.report(diagnostic);
    }

    fn skip_while(&mut self, condition: impl Fn(u8) -> bool) {
        let rest = &self.bytes[self.cursor.at..];
        self.cursor.at += rest.iter().position(|&b| !condition(b)).unwrap_or(rest.len());
    }

    fn peek(&self, offset: usize) -> Option<u8> {
        self.bytes.get(self.cursor.at + offset).copied()
    }

    fn text(&self, start: usize) -> &'a str {
        &self.file.text[start..self.cursor.at]
    }

    fn since(&self, start: usize) -> Span {
        self.file.span(start, self.cursor.at)
    }
}

/// Text of the user's as part of a message: harmless on a terminal, and not too long.
pub(crate) fn shown(text: &str) -> String {
    const MAX_CHARS: usize = 40;
    let mut shown = String::new();
    for c in text.chars().take(MAX_CHARS) {
        // `escape_debug` knows what is printable, but would escape quotes too.
        if matches!(c, ' '..='~') || c.escape_debug().len() == 1 {
            shown.push(c);
        } else {
            shown.extend(c.escape_unicode());
        }
    }
    if text.chars().nth(MAX_CHARS).is_some() {
        shown.push_str("...");
    }
    shown
}

fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r' | b'\x0b')
}

/// Whether a text is one identifier; it may be a reserved one.
pub(crate) fn is_identifier(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.bytes().all(is_identifier_tail)
}

fn is_identifier_tail(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_')
}

fn indent(margin: &[u8]) -> u16 {
    let column = |column: usize, byte: &u8| match byte {
        b'\t' => (column / 8 + 1) * 8,
        _ => column + 1,
    };
    u16::try_from(margin.iter().fold(0, column)).unwrap_or(u16::MAX)
}

#[cfg(test)]
mod tests;
