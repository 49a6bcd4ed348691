//! What is wrong with an open scene, as `gmlvm check` finds it, found on a thread of its own.

use std::collections::{HashMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use compiler::bytecode::Program;
use compiler::diagnostic::{Class, Code, Diagnostic as Found, Label};
use compiler::names::{Names, Use};
use compiler::source::{FileId, SourceMap, Span};
use compiler::{parser, preprocess};
use serde_json::json;
use vm::error::Error;
use vm::program::LoadedProgram;

use crate::args::{Inputs, LimitArgs};
use crate::clean::{clean_lines, shortened};
use crate::driver;
use crate::lsp::Event;
use crate::lsp::documents::{Document, Open, OpenIncludes, uri_of};
use crate::lsp::program::predefined;
use crate::lsp::text::Lines;
use crate::lsp::timed::Timed;
use crate::lsp::types::{Diagnostic, Location, Range, RelatedInformation, Severity};
use crate::report::hint;

/// The most names in one scene that are told to be not bound.
const MAX_UNBOUND: usize = 100;

/// For so many of them a name is looked for that may be meant, each time through the whole program.
const MAX_MEANT: usize = 4;

/// The longest that is waited for a program: instructions, which are limited too, take more or less.
const MAX_TIME: Duration = Duration::from_secs(10);

/// The most other places that a diagnostic comes with.
const MAX_RELATED: usize = 16;

/// A scene to check.
#[derive(Clone, Debug)]
pub(super) struct Job {
    pub(super) document: Document,
    pub(super) open: Open,
    pub(super) inputs: Arc<Inputs>,
}

/// What has been found in a scene and what it includes.
#[derive(Debug)]
pub(super) struct Report {
    /// The scene, by the compiler's name for it.
    pub(super) name: String,
    /// The state of it that was checked.
    pub(super) version: i32,
    /// The files that it consists of, by the same names.
    pub(super) files: Vec<String>,
    /// What is wrong, by file.
    pub(super) diagnostics: Vec<(String, Diagnostic)>,
}

impl Report {
    /// The files in which something is wrong, one for each time.
    pub(super) fn uris(&self) -> impl Iterator<Item = String> {
        self.diagnostics.iter().map(|(uri, _)| uri.clone())
    }
}

/// Scenes that wait to be checked: each once, in its newest state, however fast it changes.
#[derive(Debug, Default)]
pub(super) struct Queue {
    waiting: Mutex<VecDeque<Job>>,
    is_filled: Condvar,
}

impl Queue {
    /// Adds a scene, in place of an older state of it.
    pub(super) fn put(&self, job: Job) {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.retain(|older| older.document.uri != job.document.uri);
        waiting.push_back(job);
        self.is_filled.notify_one();
    }

    /// Takes the scene that has waited longest, once there is one.
    fn take(&self) -> Job {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(job) = waiting.pop_front() {
                return job;
            }
            waiting = self.is_filled.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Checks scenes as they come, until there is nobody to tell.
pub(super) fn work(queue: &Queue, events: &SyncSender<Event>) {
    let mut runs = Timed::new();
    loop {
        let job = queue.take();
        let checked = catch_unwind(AssertUnwindSafe(|| check(&job, &mut runs)));
        let event = checked.map_or_else(Event::Crashed, Event::Checked);
        if events.send(event).is_err() {
            return;
        }
    }
}

/// How a program has ended.
type Outcome = Result<(), Box<Error>>;

fn check(job: &Job, runs: &mut Timed<Outcome>) -> Report {
    let name = job.document.name();
    let mut teller = Teller { job, lines: HashMap::new(), told: Vec::new() };
    let mut sources = SourceMap::with_max_words(job.inputs.max_words);
    let bytes = job.document.text.as_bytes().to_vec();
    let Ok(root) = sources.add(&name, bytes) else {
        let text = Code::SourceTooLarge.explanation();
        let found = Found::new(Code::SourceTooLarge, Span::NONE, text);
        teller.tell(Severity::Error, &found, &sources, None);
        return teller.report(vec![name]);
    };
    let mut includes = OpenIncludes::new(&job.document, &job.inputs, &job.open);
    let is_program = job.document.is_program();
    let defines = &job.inputs.defines;
    let bindings: Vec<_> = defines.iter().map(|d| (d.name.clone(), d.value.clone())).collect();
    match compiler::compile(&mut sources, root, &mut includes, &bindings) {
        Err(errors) => errors.iter().for_each(|e| teller.tell(Severity::Error, e, &sources, None)),
        Ok(program) if is_program => {
            let stopped_at = run(program, runs).map(|mut found| {
                let span = found.primary.span;
                // A scene may be right and only need more than an editor should spend on it.
                let is_limit = found.code.class() == Class::Limit;
                let severity = if is_limit { Severity::Warning } else { Severity::Error };
                hint::add_file_name(&mut found, &sources);
                let replacement = hint::add_meant(&mut found, &sources, || job.tree_again());
                teller.tell(severity, &found, &sources, replacement.as_deref());
                span
            });
            teller.tell_unbound(stopped_at, &sources);
        }
        Ok(_) => {}
    }
    teller.report(sources.files().map(|file| file.name.clone()).collect())
}

/// Runs a program, within limits; returns what has stopped it.
fn run(program: Program, runs: &mut Timed<Outcome>) -> Option<Found> {
    let program = Arc::new(LoadedProgram::new(program));
    let run = move || driver::run_to_the_end(&program, LimitArgs::strict()).map(drop);
    match runs.within(MAX_TIME, run) {
        Some(outcome) => outcome.err().map(|error| error.into_diagnostic()),
        None => {
            let message = format!("the time limit of {} s is reached", MAX_TIME.as_secs());
            Some(Found::new(Code::TimeLimit, Span::NONE, message))
        }
    }
}

impl Job {
    /// The scene's files, once more, at the same addresses.
    fn afresh<T>(
        &self,
        read: impl FnOnce(&mut SourceMap, FileId, &mut OpenIncludes<'_>) -> T,
    ) -> Option<T> {
        let mut sources = SourceMap::with_max_words(self.inputs.max_words);
        let bytes = self.document.text.as_bytes().to_vec();
        let root = sources.add(&self.document.name(), bytes).ok()?;
        let mut includes = OpenIncludes::new(&self.document, &self.inputs, &self.open);
        Some(read(&mut sources, root, &mut includes))
    }

    fn tree_again(&self) -> Option<compiler::ast::Body> {
        self.afresh(|sources, root, includes| compiler::parse(sources, root, includes).ok())?
    }
}

/// Puts diagnostics into the terms of the protocol.
struct Teller<'a> {
    job: &'a Job,
    /// Of the files that something has been told of.
    lines: HashMap<String, Lines>,
    told: Vec<(String, Diagnostic)>,
}

impl Teller<'_> {
    fn report(self, files: Vec<String>) -> Report {
        let Document { version, .. } = self.job.document;
        Report { name: self.job.document.name(), version, files, diagnostics: self.told }
    }

    /// Tells of a name that is not bound where it stands, whether the program gets there or not:
    /// surface functions are not called here.
    fn tell_unbound(&mut self, stopped_at: Option<Span>, sources: &SourceMap) {
        let read = |sources: &mut SourceMap, root, includes: &mut OpenIncludes<'_>| {
            preprocess::tokens_and_errors(sources, root, includes).0
        };
        let Some(tokens) = self.job.afresh(read) else { return };
        let names = Names::of(&tokens, &predefined(&self.job.inputs));
        let tree = parser::parse(sources, tokens).ok();
        let is_unbound = |used: &&Use| used.binding.is_none() && Some(used.span) != stopped_at;
        for (n_told, used) in names.uses.iter().filter(is_unbound).take(MAX_UNBOUND).enumerate() {
            let message = format!("`{}` is not bound", used.name);
            let mut found = Found::new(Code::Unbound, used.span, message)
                .label("an error if the program gets here");
            let tree = tree.as_ref().filter(|_| n_told < MAX_MEANT);
            let meant = tree.and_then(|tree| hint::add_similar(&mut found, sources, tree));
            self.tell(Severity::Warning, &found, sources, meant.as_deref());
        }
    }

    fn tell(
        &mut self,
        severity: Severity,
        found: &Found,
        sources: &SourceMap,
        replacement: Option<&str>,
    ) {
        let place = self.place(found.primary.span, sources);
        let location = place.unwrap_or_else(|| Location {
            uri: self.job.document.uri.clone(),
            range: Range::default(),
        });
        let calls = found.trace.iter().rev().map(|call| {
            let text = format!("called here, in {}", call.within);
            Label { span: call.span, text }
        });
        let labels = found.secondary.iter().cloned().chain(calls);
        let labels: Vec<_> = labels.take(MAX_RELATED).collect();
        let related = labels.iter().filter_map(|label| {
            let location = self.place(label.span, sources)?;
            Some(RelatedInformation { location, message: label.text.clone() })
        });
        let diagnostic = Diagnostic {
            range: location.range,
            severity: severity as u8,
            code: found.code.as_str(),
            source: "gmlvm",
            message: message(found, replacement),
            related_information: related.collect(),
            data: replacement.map(|name| json!({ "replacement": name })),
        };
        self.told.push((location.uri, diagnostic));
    }

    fn place(&mut self, span: Span, sources: &SourceMap) -> Option<Location> {
        let file = sources.file_of(span)?;
        let uri = uri_of(&file.name, &self.job.open)?;
        if !self.lines.contains_key(&file.name) {
            self.lines.insert(file.name.clone(), Lines::of(&file.text));
        }
        Some(Location { uri, range: self.lines[&file.name].range(file, span) })
    }
}

/// The message, what stands beside the place, notes and advice: a line each, fit to be shown.
fn message(found: &Found, replacement: Option<&str>) -> String {
    let mut lines = vec![found.message.clone()];
    lines.extend(Some(found.primary.text.clone()).filter(|text| !text.is_empty()));
    lines.extend(found.notes.iter().map(|note| format!("note: {note}")));
    lines.extend(found.helps.iter().map(|help| format!("help: {help}")));
    lines.extend(replacement.map(|name| format!("help: did you mean `{name}`?")));
    let lines = lines.iter().map(|line| clean_lines(&shortened(line)));
    lines.collect::<Vec<_>>().join("\n")
}
