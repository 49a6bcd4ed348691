//! `gmlvm lsp`: a language server over the standard input and output.
//!
//! One thread reads messages ([`transport`]), one checks scenes ([`check`]), and this one answers: it
//! alone knows which documents are open, and writes. Positions are in units of UTF-16, which all
//! editors know.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread;

use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::args::Inputs;
use crate::args::lsp::LspArgs;
use crate::console;
use crate::failure::Failure;
use crate::lsp::check::{Job, Queue, Report};
use crate::lsp::documents::{Document, Open};
use crate::lsp::message::{ErrorCode, Message, Notification, Request, ResponseError};
use crate::lsp::program::Program;
use crate::lsp::transport::Received;
use crate::lsp::types::{Diagnostic, DidChangeParams, DidOpenParams, DocumentParams};

mod answers;
mod check;
mod documents;
mod message;
mod program;
mod requests;
mod text;
mod timed;
mod transport;
mod types;

/// Stack of the thread that checks; nesting of the text is limited to what fits in many times.
const STACK_BYTES: usize = 64 << 20;

/// The most messages that wait to be answered; a client that sends more has to wait.
const MAX_WAITING: usize = 64;

/// The exit code that the protocol wants of a server that ends without `shutdown`.
const EXIT_UNASKED: u8 = 1;

/// What the answering thread waits for.
enum Event {
    Received(Received),
    /// The client has gone, or talks in a way that cannot be followed.
    Ended(io::Result<()>),
    Checked(Report),
    /// The checking thread has panicked.
    Crashed(Box<dyn std::any::Any + Send>),
}

/// Answers until the client says `exit` or goes away.
///
/// # Errors
/// When the standard input is no protocol, or the output cannot be written.
pub(crate) fn serve(args: &LspArgs) -> Result<u8, Failure> {
    let mut inputs = args.inputs.clone();
    inputs.max_words = inputs.max_words.min(Inputs::STRICT_WORDS);
    // Files have absolute names here, as editors give them.
    for directory in &mut inputs.include_dirs {
        *directory = std::path::absolute(&*directory).unwrap_or_else(|_| directory.clone());
    }
    let (events, incoming) = mpsc::sync_channel(MAX_WAITING);
    let queue = Arc::new(Queue::default());
    let jobs = Arc::clone(&queue);
    let checked = events.clone();
    let failed =
        |error| Failure::Usage(format!("cannot start a thread: {}", console::reason(&error)));
    let checker = thread::Builder::new().name("check".to_owned()).stack_size(STACK_BYTES);
    checker.spawn(move || check::work(&jobs, &checked)).map_err(failed)?;
    let reader = thread::Builder::new().name("read".to_owned());
    reader.spawn(move || read(&events)).map_err(failed)?;
    let mut server = Server {
        inputs: Arc::new(inputs),
        queue,
        open: Open::default(),
        programs: BTreeMap::new(),
        reports: BTreeMap::new(),
        phase: Phase::Fresh,
    };
    server.run(&incoming)
}

fn read(events: &SyncSender<Event>) {
    let mut stream = io::stdin().lock();
    loop {
        let event = match transport::read(&mut stream) {
            Ok(Some(received)) => Event::Received(received),
            Ok(None) => Event::Ended(Ok(())),
            Err(error) => Event::Ended(Err(error)),
        };
        let is_last = matches!(event, Event::Ended(_));
        if events.send(event).is_err() || is_last {
            return;
        }
    }
}

/// How far client and server have come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Fresh,
    Initialized,
    ShutDown,
}

/// The state of the answering thread.
struct Server {
    inputs: Arc<Inputs>,
    queue: Arc<Queue>,
    open: Open,
    /// Documents as requests look at them, by name, as long as no text changes.
    programs: BTreeMap<String, Arc<Program>>,
    /// The last report on each open document, by name.
    reports: BTreeMap<String, Report>,
    phase: Phase,
}

impl Server {
    fn run(&mut self, incoming: &Receiver<Event>) -> Result<u8, Failure> {
        while let Ok(event) = incoming.recv() {
            match event {
                Event::Received(Received::Broken(answer)) => send(&answer)?,
                Event::Received(Received::Message(Message::Notification(notification))) => {
                    if notification.method == "exit" {
                        return Ok(if self.phase == Phase::ShutDown { 0 } else { EXIT_UNASKED });
                    }
                    self.notified(notification)?;
                }
                Event::Received(Received::Message(Message::Request(request))) => {
                    send(&self.respond(request))?;
                }
                // We ask for nothing.
                Event::Received(Received::Message(Message::Response { .. })) => {}
                Event::Checked(report) => self.publish(report)?,
                Event::Ended(Ok(())) => break,
                Event::Ended(Err(error)) => {
                    let reason = console::reason(&error);
                    let message = format!("the standard input is no language client: {reason}");
                    return Err(Failure::Usage(message));
                }
                Event::Crashed(panic) => std::panic::resume_unwind(panic),
            }
        }
        Ok(if self.phase == Phase::ShutDown { 0 } else { EXIT_UNASKED })
    }

    fn respond(&mut self, request: Request) -> Value {
        let Request { id, method, params } = request;
        let result = match (self.phase, method.as_str()) {
            (Phase::Fresh, "initialize") => {
                self.phase = Phase::Initialized;
                Ok(requests::capabilities())
            }
            (Phase::Fresh, _) => {
                Err(ResponseError::new(ErrorCode::ServerNotInitialized, "`initialize` comes first"))
            }
            (Phase::ShutDown, _) => {
                Err(ResponseError::new(ErrorCode::InvalidRequest, "the server is shut down"))
            }
            (Phase::Initialized, "shutdown") => {
                self.phase = Phase::ShutDown;
                Ok(Value::Null)
            }
            (Phase::Initialized, _) => self.request(&method, params),
        };
        message::response(&id, &result)
    }

    /// A notification that cannot be understood is passed over: it has no answer.
    fn notified(&mut self, notification: Notification) -> Result<(), Failure> {
        if self.phase != Phase::Initialized {
            return Ok(());
        }
        let Notification { method, params } = notification;
        match method.as_str() {
            "textDocument/didOpen" => {
                let Some(params) = typed::<DidOpenParams>(params) else { return Ok(()) };
                let item = params.text_document;
                let (uri, version) = (item.uri, item.version);
                self.put(Document { uri, version, text: item.text.into() });
            }
            "textDocument/didChange" => {
                let Some(params) = typed::<DidChangeParams>(params) else { return Ok(()) };
                let Some(mut document) = self.document(&params.text_document.uri).cloned() else {
                    return Ok(());
                };
                params.content_changes.iter().for_each(|change| document.change(change));
                document.version = params.text_document.version;
                self.put(document);
            }
            "textDocument/didClose" => {
                let Some(params) = typed::<DocumentParams>(params) else { return Ok(()) };
                return self.close(&params.text_document.uri);
            }
            // Files on the disk may be others now.
            "textDocument/didSave" | "workspace/didChangeWatchedFiles" => self.check_all(),
            _ => {}
        }
        Ok(())
    }

    fn document(&self, uri: &str) -> Option<&Document> {
        self.open.values().find(|document| document.uri == uri)
    }

    /// Opens a document, or replaces what was known of it.
    fn put(&mut self, document: Document) {
        let name = document.name();
        Arc::make_mut(&mut self.open).insert(name.clone(), document);
        self.programs.clear();
        self.check(&name);
        self.check_including(&name);
    }

    /// Checks the other documents that include this one.
    fn check_including(&self, name: &String) {
        let includes_it = |report: &&Report| report.name != *name && report.files.contains(name);
        for report in self.reports.values().filter(includes_it) {
            self.check(&report.name);
        }
    }

    fn check_all(&mut self) {
        self.programs.clear();
        let names: Vec<_> = self.open.keys().cloned().collect();
        names.iter().for_each(|name| self.check(name));
    }

    fn check(&self, name: &str) {
        let (open, inputs) = (Arc::clone(&self.open), Arc::clone(&self.inputs));
        if let Some(document) = self.open.get(name).cloned() {
            self.queue.put(Job { document, open, inputs });
        }
    }

    fn close(&mut self, uri: &str) -> Result<(), Failure> {
        let Some(name) = self.document(uri).map(Document::name) else { return Ok(()) };
        Arc::make_mut(&mut self.open).remove(&name);
        self.programs.clear();
        let gone = self.reports.remove(&name);
        self.check_including(&name);
        self.tell(gone.iter().flat_map(Report::uris))
    }

    fn publish(&mut self, report: Report) -> Result<(), Failure> {
        // It may have been closed or changed meanwhile; of a change another report follows.
        let Some(document) = self.open.get(&report.name) else { return Ok(()) };
        if document.version != report.version {
            return Ok(());
        }
        let uris: Vec<_> = report.uris().chain([document.uri.clone()]).collect();
        let before = self.reports.insert(report.name.clone(), report);
        self.tell(before.iter().flat_map(Report::uris).chain(uris))
    }

    /// Says what is wrong in these files, by all reports on them.
    fn tell(&self, uris: impl Iterator<Item = String>) -> Result<(), Failure> {
        let mut uris: Vec<_> = uris.collect();
        uris.sort();
        uris.dedup();
        for uri in uris {
            let mut diagnostics: Vec<&Diagnostic> = Vec::new();
            let all = self.reports.values().flat_map(|report| &report.diagnostics);
            for (_, diagnostic) in all.filter(|(about, _)| *about == uri) {
                // Two scenes may include one file.
                if !diagnostics.contains(&diagnostic) {
                    diagnostics.push(diagnostic);
                }
            }
            let mut params = json!({ "uri": uri, "diagnostics": diagnostics });
            if let Some(document) = self.document(&uri) {
                params["version"] = document.version.into();
            }
            send(&message::notification("textDocument/publishDiagnostics", &params))?;
        }
        Ok(())
    }

    /// A document as requests look at it.
    fn program(&mut self, uri: &str) -> Option<Arc<Program>> {
        let document = self.document(uri)?;
        let name = document.name();
        if let Some(program) = self.programs.get(&name) {
            return Some(Arc::clone(program));
        }
        let program = Arc::new(Program::read(document, &self.inputs, &self.open)?);
        self.programs.insert(name, Arc::clone(&program));
        Some(program)
    }
}

/// The parameters of a notification, if they are such.
fn typed<P: DeserializeOwned>(params: Value) -> Option<P> {
    serde_json::from_value(params).ok()
}

fn send(message: &Value) -> Result<(), Failure> {
    transport::write(&mut io::stdout().lock(), message).map_err(|error| Failure::stdout(&error))
}
