//! Reading programs: the scene, what it includes, and what the command line adds.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use compiler::ast::Body;
use compiler::bytecode::Program;
use compiler::diagnostic::{Code, Diagnostic};
use compiler::preprocess;
use compiler::source::{FileId, MAX_SOURCE_BYTES, SourceMap, Span};

use crate::args::Inputs;
use crate::clean::clean;
use crate::console;
use crate::failure::Failure;
use crate::report::{Reporter, hint};

pub(crate) use includes::FileIncludes;

mod includes;

/// How the standard input is named in messages.
const STDIN_NAME: &str = "<stdin>";

/// A scene's text, before anything is done with it.
pub(crate) struct Source<'a> {
    /// All files read so far.
    pub(crate) sources: SourceMap,
    /// The scene itself.
    pub(crate) root: FileId,
    /// How long reading took.
    pub(crate) read_time: Duration,
    path: &'a Path,
    inputs: &'a Inputs,
}

impl<'a> Source<'a> {
    /// Reads a scene; `-` is the standard input.
    ///
    /// # Errors
    /// When it cannot be read, or is too long.
    pub(crate) fn read(
        path: &'a Path,
        inputs: &'a Inputs,
        reporter: &Reporter,
    ) -> Result<Self, Failure> {
        let start = Instant::now();
        let bytes = if is_stdio(path) { at_most(io::stdin().lock()) } else { read_file(path) };
        let bytes = bytes.map_err(|error| {
            let name = path.display().to_string();
            Failure::Usage(format!("cannot read `{}`: {}", clean(&name), console::reason(&error)))
        })?;
        Source::of_bytes(bytes, path, inputs, start, reporter)
    }

    /// A scene whose text somebody else has read since `start`, in place of that at the path.
    ///
    /// # Errors
    /// When it is too long.
    pub(crate) fn of_bytes(
        bytes: Vec<u8>,
        path: &'a Path,
        inputs: &'a Inputs,
        start: Instant,
        reporter: &Reporter,
    ) -> Result<Self, Failure> {
        let mut sources = SourceMap::with_max_words(inputs.max_words);
        let root = sources.add(&shown_name(path), bytes).map_err(|_| {
            let message = format!("`{}` is too long", clean(&shown_name(path)));
            let limit = format!("the limit is {} MiB", MAX_SOURCE_BYTES >> 20);
            let diagnostic = Diagnostic::new(Code::SourceTooLarge, Span::NONE, message).note(limit);
            reporter.diagnostics(&[diagnostic], &SourceMap::default(), None)
        })?;
        Ok(Source { sources, root, read_time: start.elapsed(), path, inputs })
    }

    /// The same scene, as it is before anything is done with it.
    pub(crate) fn afresh(&self) -> Source<'a> {
        let root = self.sources.file(self.root);
        let mut sources = SourceMap::with_max_words(self.inputs.max_words);
        let file = sources.add(&root.name, root.text.clone().into_bytes());
        let root = file.expect("it was not too long before");
        Source { sources, root, ..*self }
    }

    /// Compiles the scene.
    ///
    /// # Errors
    /// When it is wrong; the user has been told.
    pub(crate) fn compile(&mut self, reporter: &Reporter) -> Result<Program, Failure> {
        let defines = &self.inputs.defines;
        let bindings: Vec<_> = defines.iter().map(|d| (d.name.clone(), d.value.clone())).collect();
        let mut includes = self.includes();
        compiler::compile(&mut self.sources, self.root, &mut includes, &bindings)
            .map_err(|diagnostics| reporter.diagnostics(&diagnostics, &self.sources, None))
    }

    /// Shows what stopped the running program, with what may be meant by a name that is not bound.
    pub(crate) fn stopped(&self, mut diagnostic: Diagnostic, reporter: &Reporter) -> Failure {
        hint::add_file_name(&mut diagnostic, &self.sources);
        let replacement = hint::add_meant(&mut diagnostic, &self.sources, || self.tree_again());
        reporter.diagnostics(&[diagnostic], &self.sources, replacement.as_deref())
    }

    /// File, line and column of a span, as messages show them.
    pub(crate) fn place(&self, span: Span) -> String {
        place(&self.sources, span)
    }

    /// What finds the files that this scene includes.
    pub(crate) fn includes(&self) -> FileIncludes<'a> {
        let directory = if is_stdio(self.path) { None } else { self.path.parent() };
        FileIncludes::new(shown_name(self.path), directory, self.inputs)
    }

    /// The tree, read anew: while a program runs it is not kept. Its files take the same addresses,
    /// so its spans are good for the first reading too.
    fn tree_again(&self) -> Option<Body> {
        let Source { mut sources, root, .. } = self.afresh();
        compiler::parse(&mut sources, root, &mut self.includes()).ok()
    }
}

/// File, line and column of a span, as messages show them.
pub(crate) fn place(sources: &SourceMap, span: Span) -> String {
    sources.file_of(span).map_or_else(String::new, |file| {
        format!("{}:{}", clean(&file.name), file.line_column(span))
    })
}

/// The files that a scene consists of, by the names shown, as far as they are found, and whether all are.
pub(crate) fn files(path: &Path, inputs: &Inputs) -> (Vec<PathBuf>, bool) {
    let mut sources = SourceMap::with_max_words(inputs.max_words);
    let mut includes = FileIncludes::new(shown_name(path), path.parent(), inputs);
    let bytes = read_file(path).ok();
    let root = bytes.and_then(|bytes| sources.add(&shown_name(path), bytes).ok());
    let is_complete = root.is_some_and(|root| {
        let errors = preprocess::tokens(&mut sources, root, &mut includes).err();
        !errors.into_iter().flatten().any(|error| error.code == Code::IncludeNotFound)
    });
    (sources.files().map(|file| PathBuf::from(&file.name)).collect(), is_complete)
}

/// Whether a path on the command line stands for a standard stream.
pub(crate) fn is_stdio(path: &Path) -> bool {
    path.as_os_str() == "-"
}

fn shown_name(path: &Path) -> String {
    if is_stdio(path) { STDIN_NAME.to_owned() } else { path.display().to_string() }
}

/// The whole file; of a file that is too long, enough to tell.
pub(crate) fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    if fs::metadata(path)?.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    at_most(File::open(path)?)
}

fn at_most(reader: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(MAX_SOURCE_BYTES as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}
