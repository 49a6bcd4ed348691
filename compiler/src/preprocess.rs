//! Preprocessor lines: included files and conditions.
//!
//! The scenes of 2000 were fed through the C preprocessor; this is the part of it that they use.
//! Macros are names that are defined or not, and are never expanded.

use std::collections::HashSet;

use crate::diagnostic::{Code, Diagnostic};
use crate::lexer::{Cursor, DirectiveLine, Lexer, Output, Token, shown};
use crate::source::{FileId, SourceMap, Span};

/// The most files that may be open at once, each included by the one before.
pub const MAX_INCLUDE_DEPTH: usize = 64;

/// The most `#include` lines that a program may follow: files that include others twice grow
/// exponentially in number while hardly in size.
pub const MAX_INCLUDES: usize = 10_000;

/// Gives access to the files that a program may include.
pub trait Includes {
    /// Resolves `name` as written in file `from`; returns the name to show and the bytes.
    fn load(&mut self, from: &str, name: &str) -> Option<(String, Vec<u8>)>;
}

/// No file can be included.
#[derive(Clone, Copy, Debug)]
pub struct NoIncludes;

impl Includes for NoIncludes {
    fn load(&mut self, _from: &str, _name: &str) -> Option<(String, Vec<u8>)> {
        None
    }
}

/// The tokens of a program: of the file `root`, with those of the files it includes in place.
///
/// # Errors
/// Everything that is wrong with its characters, words and preprocessor lines, but for brackets.
pub fn tokens(
    sources: &mut SourceMap,
    root: FileId,
    includes: &mut dyn Includes,
) -> Result<Vec<Token>, Vec<Diagnostic>> {
    let (tokens, diagnostics) = tokens_and_errors(sources, root, includes);
    if diagnostics.is_empty() { Ok(tokens) } else { Err(diagnostics) }
}

/// The tokens as far as there are any, and everything that is wrong: for tools that have to do with
/// programs which are just being written.
pub fn tokens_and_errors(
    sources: &mut SourceMap,
    root: FileId,
    includes: &mut dyn Includes,
) -> (Vec<Token>, Vec<Diagnostic>) {
    let mut preprocessor = Preprocessor {
        out: Output::new(sources.max_words()),
        sources,
        includes,
        files: vec![OpenFile::new(root, Span::NONE, 0)],
        macros: HashSet::new(),
        n_macro_changes: 0,
        n_includes: 0,
    };
    preprocessor.run();
    let Output { tokens, diagnostics, .. } = preprocessor.out;
    (tokens, diagnostics)
}

struct Preprocessor<'a> {
    sources: &'a mut SourceMap,
    includes: &'a mut dyn Includes,
    out: Output,
    /// The files being read, each included by the one before; the last is where we are.
    files: Vec<OpenFile>,
    macros: HashSet<String>,
    n_macro_changes: usize,
    n_includes: usize,
}

struct OpenFile {
    id: FileId,
    cursor: Cursor,
    conditions: Vec<Condition>,
    /// The file name in the `#include` line that led here.
    included_at: Span,
    /// How often the set of macros had changed when the file was opened.
    n_macro_changes: usize,
}

impl OpenFile {
    fn new(id: FileId, included_at: Span, n_macro_changes: usize) -> Self {
        let cursor = Cursor::new();
        OpenFile { id, cursor, conditions: Vec::new(), included_at, n_macro_changes }
    }

    fn is_active(&self) -> bool {
        self.conditions.last().is_none_or(|condition| condition.active)
    }
}

/// An `#ifdef` or `#ifndef` that waits for its `#endif`.
struct Condition {
    opener: Span,
    /// The text around it is part of the program.
    enclosing: bool,
    /// The text behind it is part of the program.
    active: bool,
    else_at: Option<Span>,
}

/// A preprocessor line, taken apart.
struct Directive {
    /// `#` and the word.
    span: Span,
    word: String,
    /// What follows the word, from its first character that is not blank.
    rest: String,
    /// Byte position of `rest` in the file.
    rest_at: usize,
}

impl Preprocessor<'_> {
    fn run(&mut self) {
        while let Some(file) = self.files.last_mut().filter(|_| !self.out.stopped) {
            let is_active = file.is_active();
            let text = self.sources.file(file.id);
            let mut lexer = Lexer::new(text, &mut file.cursor, &mut self.out);
            match if is_active { lexer.tokens() } else { lexer.skip_group() } {
                Some(line) => self.directive(line),
                None => self.close_file(),
            }
        }
    }

    fn close_file(&mut self) {
        let Some(file) = self.files.pop() else { return };
        if let Some(condition) = file.conditions.last().filter(|_| !self.out.stopped) {
            let text = self.sources.file(file.id);
            let end = text.span(text.text.len(), text.text.len());
            let opener = self.sources.text(condition.opener);
            let message = format!("`{opener}` has no `#endif`");
            self.out.report(
                Diagnostic::new(Code::BadDirective, condition.opener, message)
                    .label("opened here")
                    .also(end, "the file ends here"),
            );
        }
    }

    fn directive(&mut self, line: DirectiveLine) {
        let directive = self.take_apart(line);
        let is_active = self.file().is_active();
        match directive.word.as_str() {
            "ifdef" | "ifndef" => self.open_condition(&directive),
            "else" => self.else_branch(&directive),
            "endif" => self.close_condition(&directive),
            "if" | "elif" => self.unknown_condition(&directive),
            _ if !is_active => {}
            "include" => self.include(&directive),
            "define" | "undef" => self.define(&directive),
            "line" => {}
            word if word.starts_with(|c: char| c.is_ascii_digit()) => {}
            "" if directive.rest.is_empty() => {}
            word => {
                let message = format!("`#{}` is not a preprocessor line", shown(word));
                self.bad_directive(&directive, message, "comments start with `%`");
            }
        }
    }

    fn take_apart(&mut self, line: DirectiveLine) -> Directive {
        let text = line.text.as_str();
        let word_at = text.len() - text.trim_start().len();
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let word_end = text[word_at..].find(|c| !is_word(c)).map_or(text.len(), |n| word_at + n);
        let rest = text[word_end..].trim_start();
        let rest_at = text.len() - rest.len();
        let id = self.file().id;
        let file = self.sources.file(id);
        let span_end = if word_at == word_end { 0 } else { word_end };
        Directive {
            span: file.span(line.at - 1, line.at + span_end),
            word: text[word_at..word_end].to_owned(),
            rest: rest.trim_end().to_owned(),
            rest_at: line.at + rest_at,
        }
    }

    fn open_condition(&mut self, directive: &Directive) {
        let enclosing = self.file().is_active();
        // In text that is skipped only the nesting counts.
        let name = if enclosing { self.macro_name(directive) } else { None };
        let wanted = directive.word == "ifdef";
        let active = name.is_some_and(|name| self.macros.contains(&name) == wanted);
        let condition = Condition { opener: directive.span, enclosing, active, else_at: None };
        self.file().conditions.push(condition);
    }

    fn else_branch(&mut self, directive: &Directive) {
        let Some(condition) = self.file().conditions.last_mut() else {
            return self.unopened(directive);
        };
        if let Some(first) = condition.else_at {
            let opener = condition.opener;
            condition.active = false;
            let message = "second `#else` of one condition";
            self.out.report(
                Diagnostic::new(Code::BadDirective, directive.span, message)
                    .also(opener, "opened here")
                    .also(first, "the first `#else`"),
            );
            return;
        }
        condition.active = condition.enclosing && !condition.active;
        condition.else_at = Some(directive.span);
    }

    fn close_condition(&mut self, directive: &Directive) {
        if self.file().conditions.pop().is_none() {
            self.unopened(directive);
        }
    }

    /// `#if` and `#elif` are beyond us; what they govern is skipped, so that it adds no errors.
    fn unknown_condition(&mut self, directive: &Directive) {
        let enclosing = self.file().is_active();
        let is_elif = directive.word == "elif";
        let governed = if is_elif {
            let Some(condition) = self.file().conditions.last_mut() else {
                return self.unopened(directive);
            };
            condition.active = false;
            std::mem::replace(&mut condition.enclosing, false)
        } else {
            let opener = directive.span;
            let skipped = Condition { opener, enclosing: false, active: false, else_at: None };
            self.file().conditions.push(skipped);
            enclosing
        };
        if governed {
            let message = format!("`#{}` is not known", directive.word);
            let help = "conditions are `#ifdef NAME` and `#ifndef NAME`, with `#else`";
            self.bad_directive(directive, message, help);
        }
    }

    fn unopened(&mut self, directive: &Directive) {
        let message = format!("`#{}` without a condition before it", directive.word);
        self.bad_directive(
            directive,
            message,
            "`#ifdef NAME` or `#ifndef NAME` starts a condition",
        );
    }

    fn define(&mut self, directive: &Directive) {
        let Some(name) = self.macro_name(directive) else { return };
        let is_change = match directive.word.as_str() {
            "define" => self.macros.insert(name),
            _ => self.macros.remove(&name),
        };
        self.n_macro_changes += usize::from(is_change);
    }

    fn macro_name(&mut self, directive: &Directive) -> Option<String> {
        let rest = directive.rest.as_str();
        let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        let name = &rest[..end.unwrap_or(rest.len())];
        if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
            let message = format!("`#{}` without a name", directive.word);
            let help = "a name has letters, digits and `_`, and does not start with a digit";
            self.bad_directive(directive, message, help);
            return None;
        }
        Some(name.to_owned())
    }

    fn bad_directive(&mut self, directive: &Directive, message: String, help: &str) {
        self.out.report(Diagnostic::new(Code::BadDirective, directive.span, message).help(help));
    }

    fn include(&mut self, directive: &Directive) {
        let quoted = directive.rest.strip_prefix('"').and_then(|rest| rest.split_once('"'));
        let Some((name, behind)) = quoted.filter(|(name, _)| !name.is_empty()) else {
            let message = "`#include` without a file name in quotes".to_owned();
            return self.bad_directive(directive, message, "write `#include \"file\"`");
        };
        if !behind.is_empty() && !behind.trim_start().starts_with('%') {
            let message = "`#include` with more than a file name".to_owned();
            return self.bad_directive(directive, message, "continue on a line of its own");
        }
        let id = self.file().id;
        let file = self.sources.file(id);
        let span = file.span(directive.rest_at, directive.rest_at + name.len() + 2);
        if let Some(problem) = forbidden(name) {
            let message =
                format!("`{}` {problem}, but must be relative and stay below", shown(name));
            self.out.report(
                Diagnostic::new(Code::IncludeNotFound, span, message)
                    .help("name other directories with `-I`"),
            );
            return;
        }
        self.load(name, span);
    }

    fn load(&mut self, name: &str, span: Span) {
        self.n_includes += 1;
        if self.n_includes > MAX_INCLUDES {
            let message = format!("more than {MAX_INCLUDES} files are included");
            return self.out.abort(Diagnostic::new(Code::SourceTooLarge, span, message));
        }
        let id = self.file().id;
        let from = self.sources.file(id).name.clone();
        let Some((resolved, bytes)) = self.includes.load(&from, name) else {
            let message = format!("`{}` cannot be read", shown(name));
            let note =
                format!("it is looked for beside `{}`, then in the `-I` directories", shown(&from));
            self.out.report(Diagnostic::new(Code::IncludeNotFound, span, message).note(note));
            return;
        };
        if let Some(cycle) = self.cycle(&resolved, span) {
            return self.out.report(cycle);
        }
        if self.files.len() > MAX_INCLUDE_DEPTH {
            let message = format!("files include one another more than {MAX_INCLUDE_DEPTH} deep");
            return self.out.abort(Diagnostic::new(Code::SourceTooLarge, span, message));
        }
        match self.sources.add(&resolved, bytes) {
            Ok(id) => self.files.push(OpenFile::new(id, span, self.n_macro_changes)),
            Err(_) => {
                let message = format!("with `{}` the program is too long", shown(&resolved));
                self.out.abort(Diagnostic::new(Code::SourceTooLarge, span, message));
            }
        }
    }

    /// The error, if the file would be read for ever.
    ///
    /// A file may include itself under a guard. But if no macro has changed since it was opened,
    /// the second reading goes as the first did, and so will the third.
    fn cycle(&self, name: &str, span: Span) -> Option<Diagnostic> {
        let is_same = |file: &OpenFile| {
            let opened = self.sources.file(file.id);
            opened.name == name && file.n_macro_changes == self.n_macro_changes
        };
        let first = self.files.iter().position(is_same)?;
        let circle = &self.files[first..];
        let mut chain: Vec<_> = circle.iter().map(|file| self.shown_name(file)).collect();
        chain.push(format!("`{}`", shown(name)));
        let message = format!("`{}` includes itself", shown(name));
        let mut diagnostic = Diagnostic::new(Code::IncludeCycle, span, message)
            .label("closes the circle")
            .note(chain.join(" includes "))
            .help("put its text between `#ifndef NAME`, `#define NAME` and `#endif`");
        for file in &circle[1..] {
            let text = format!("{} is included here", self.shown_name(file));
            diagnostic = diagnostic.also(file.included_at, text);
        }
        Some(diagnostic)
    }

    fn shown_name(&self, file: &OpenFile) -> String {
        format!("`{}`", shown(&self.sources.file(file.id).name))
    }

    fn file(&mut self) -> &mut OpenFile {
        self.files.last_mut().expect("a directive stands in a file")
    }
}

/// Why an included file may not have this name, if so.
fn forbidden(name: &str) -> Option<&'static str> {
    let is_absolute = name.starts_with(['/', '\\']) || name.as_bytes().get(1) == Some(&b':');
    if is_absolute {
        return Some("is absolute");
    }
    name.split(['/', '\\']).any(|part| part == "..").then_some("contains `..`")
}

/// What the tests of lexer, preprocessor and parser share.
#[cfg(test)]
pub(crate) mod testing {
    use super::*;
    use crate::lexer::TokenKind;

    /// Files by name.
    pub(crate) struct Files<'a>(pub(crate) &'a [(&'a str, &'a str)]);

    impl Includes for Files<'_> {
        fn load(&mut self, _from: &str, name: &str) -> Option<(String, Vec<u8>)> {
            let (name, text) = self.0.iter().find(|file| file.0 == name)?;
            Some(((*name).to_owned(), text.as_bytes().to_vec()))
        }
    }

    /// The tokens of the first file, which may include the others.
    pub(crate) fn preprocess(
        files: &[(&str, &str)],
    ) -> (SourceMap, Result<Vec<Token>, Vec<Diagnostic>>) {
        let mut sources = SourceMap::default();
        let root = sources.add(files[0].0, files[0].1.as_bytes().to_vec()).unwrap();
        let result = tokens(&mut sources, root, &mut Files(files));
        (sources, result)
    }

    pub(crate) fn tokens_of(text: &str) -> (SourceMap, Vec<Token>) {
        let (sources, result) = preprocess(&[("a", text)]);
        (sources, result.unwrap())
    }

    pub(crate) fn errors(text: &str) -> (SourceMap, Vec<Diagnostic>) {
        let (sources, result) = preprocess(&[("a", text)]);
        (sources, result.unwrap_err())
    }

    /// `line:column`, with the file's name before it unless that is `a`.
    pub(crate) fn place(sources: &SourceMap, span: Span) -> String {
        let file = sources.file_of(span).unwrap();
        let prefix = if file.name == "a" { String::new() } else { format!("{}:", file.name) };
        format!("{prefix}{}", file.line_column(span))
    }

    /// A line `code place message` for each.
    pub(crate) fn show_errors(sources: &SourceMap, diagnostics: &[Diagnostic]) -> String {
        let line = |d: &Diagnostic| {
            format!("{} {} {}", d.code.as_str(), place(sources, d.primary.span), d.message)
        };
        diagnostics.iter().map(line).collect::<Vec<_>>().join("\n")
    }

    /// The tokens in words, or the errors.
    pub(crate) fn show_files(files: &[(&str, &str)]) -> String {
        let (sources, result) = preprocess(files);
        match result {
            Ok(tokens) => tokens.iter().map(show_token).collect::<Vec<_>>().join(", "),
            Err(diagnostics) => show_errors(&sources, &diagnostics),
        }
    }

    pub(crate) fn show_tokens(text: &str) -> String {
        show_files(&[("a", text)])
    }

    fn show_token(token: &Token) -> String {
        match &token.kind {
            TokenKind::Bool(value) => value.to_string(),
            TokenKind::Int(value) => format!("int {value}"),
            TokenKind::Real(value) => format!("real {value:?}"),
            TokenKind::Str(text) => format!("\"{text}\""),
            TokenKind::Operator(op) => format!("op {}", op.spelling()),
            TokenKind::Name(name) => name.to_string(),
            TokenKind::Binder(name) => format!("/{name}"),
            TokenKind::OpenFunction => "{".to_owned(),
            TokenKind::CloseFunction => "}".to_owned(),
            TokenKind::OpenArray => "[".to_owned(),
            TokenKind::CloseArray => "]".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests;
