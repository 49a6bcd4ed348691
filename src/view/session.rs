//! What a page shows: the scene's text, the run that is under way, and what has been told of it.
//!
//! Events are kept until they are overtaken, so that a page which is opened, or has lost its connection,
//! is told what the others know: those of the last run that succeeded, and of the current one.

use std::collections::HashMap;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};

use crate::args::{ViewArgs, of_worker};
use crate::clean::clean;
use crate::console;
use crate::failure::Failure;
use crate::load;
use crate::output::{Existing, Target};
use crate::report::plain_json;
use crate::view::http::Status;
use crate::view::protocol::{About, Choice, Map, Question, Task};

/// A message of a worker has a head and bytes of at most these lengths; it would have to be broken
/// to send more.
const MAX_MESSAGE: u64 = 8 << 20;
const MAX_BYTES: u64 = 256 << 20;

/// The files of a run that are kept take so many bytes together at most.
const MAX_KEPT: usize = 256 << 20;

/// So much of what is wrong with a scene is read.
const MAX_DIAGNOSTICS: u64 = 1 << 20;

/// Pixels that may be asked for at once, and how long an answer may take.
const MAX_LOOKS: usize = 8;
const LOOK_TIME: Duration = Duration::from_secs(5);

/// Maps that may be asked for at once; how long one may take is the worker's business.
const MAX_MAPS: usize = 2;

/// Something that a page is told.
pub(super) struct Event {
    /// Its number: ascending, and the name of its file.
    pub(super) number: u64,
    run: u64,
    kind: String,
    image: Option<u64>,
    /// As JSON.
    pub(super) text: String,
    /// What belongs to it.
    pub(super) file: Option<File>,
}

/// Bytes, and what they are.
pub(super) struct File {
    pub(super) media_type: String,
    pub(super) bytes: Vec<u8>,
}

/// A process that renders.
struct Worker {
    child: Child,
    /// Where pixels are asked for, once it has its task.
    input: Option<ChildStdin>,
}

/// Somebody who has asked a question.
struct Waiting {
    about: About,
    answer: Sender<Answer>,
}

/// What a worker answers: in JSON, and with a file, if that says it.
type Answer = (Value, Option<File>);

struct State {
    /// The number of the last event.
    number: u64,
    events: Vec<Arc<Event>>,
    /// The number of the current run, and of the last one that succeeded.
    run: u64,
    good: Option<u64>,
    worker: Option<Worker>,
    /// Who waits for an answer of the worker.
    waiting: HashMap<u64, Waiting>,
    n_questions: u64,
    /// What is rendered, and how.
    text: Arc<str>,
    choice: Choice,
    /// What is on the disk, if that is text, and how often it has changed.
    on_disk: Option<Arc<str>>,
    revision: u64,
}

/// What all threads of the server share.
pub(super) struct Session {
    args: ViewArgs,
    program: PathBuf,
    line: Vec<OsString>,
    state: Mutex<State>,
    changed: Condvar,
}

impl Session {
    /// A session without a run.
    ///
    /// # Errors
    /// When this program cannot be found.
    pub(super) fn new(args: &ViewArgs, line: &[OsString]) -> io::Result<Self> {
        let line = of_worker(line.to_owned());
        let state = State {
            number: 0,
            events: Vec::new(),
            run: 0,
            good: None,
            worker: None,
            waiting: HashMap::new(),
            n_questions: 0,
            text: "".into(),
            choice: Choice::of(args),
            on_disk: None,
            revision: 0,
        };
        Ok(Session {
            args: args.clone(),
            program: std::env::current_exe()?,
            line,
            state: Mutex::new(state),
            changed: Condvar::new(),
        })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes notice of the scene's file, of which these paths have changed. What is in it is rendered,
    /// unless it is what is rendered already, and no other file has changed.
    ///
    /// # Errors
    /// When it cannot be read; the page has been told.
    pub(super) fn take_from_disk(self: &Arc<Self>, changed: &[PathBuf]) -> io::Result<()> {
        let read = load::read_file(&self.args.scene);
        let mut state = self.state();
        let bytes = match read {
            Ok(bytes) => bytes,
            Err(error) => {
                let message = format!("the file cannot be read: {}", console::reason(&error));
                // Whatever is there next is news.
                state.on_disk = None;
                state.tell(0, json!({ "event": "disk", "error": message }), None);
                self.changed.notify_all();
                return Err(error);
            }
        };
        let text: Arc<str> = compiler::source::text(bytes.clone()).into();
        let on_disk = (text.as_bytes() == bytes).then(|| text.clone());
        let is_new = state.revision == 0 || state.on_disk != on_disk || on_disk.is_none();
        let is_other = changed.iter().any(|path| *path != self.args.scene);
        state.on_disk = on_disk;
        if is_new {
            state.revision += 1;
            self.tell_source(&mut state, &text);
        }
        if is_new && state.text != text || state.run == 0 {
            state.text = text;
            self.start(&mut state);
        } else if is_other {
            self.start(&mut state);
        }
        Ok(())
    }

    fn tell_source(&self, state: &mut State, text: &str) {
        let is_editable = self.args.edit && state.on_disk.is_some();
        let message = json!({
            "event": "source",
            "name": clean(&self.args.scene.display().to_string()),
            "text": text,
            "revision": state.revision,
            "edit": is_editable,
        });
        state.tell(0, message, None);
        self.changed.notify_all();
    }

    /// Renders a text; returns the number of the run.
    ///
    /// # Errors
    /// When the choice stands for nothing.
    pub(super) fn run(self: &Arc<Self>, text: &str, choice: Choice) -> Result<u64, Status> {
        if choice.method().is_none() {
            return Err(Status::BadRequest);
        }
        let mut state = self.state();
        state.text = text.into();
        state.choice = choice;
        self.start(&mut state);
        Ok(state.run)
    }

    /// Writes a text to the scene's file, which must be as it was at a revision. Returns the new one.
    ///
    /// # Errors
    /// Why it is not written.
    pub(super) fn save(&self, text: &str, revision: u64) -> Result<u64, (Status, String)> {
        let refuse = |status, why: &str| Err((status, why.to_owned()));
        if !self.args.edit {
            return refuse(Status::Forbidden, "started without --edit");
        }
        let mut state = self.state();
        let is_known = load::read_file(&self.args.scene).is_ok_and(|bytes| {
            state.on_disk.as_ref().is_some_and(|known| known.as_bytes() == bytes)
        });
        if !is_known || revision != state.revision {
            return refuse(Status::Conflict, "the file has been changed by somebody else");
        }
        let target = Target::path(self.args.scene.clone());
        let mut fill = |out: &mut dyn Write| out.write_all(text.as_bytes());
        if let Err(problem) = target.write(Existing::Succeed, &mut fill) {
            return refuse(Status::Failed, target.failure(problem).message().unwrap_or_default());
        }
        state.on_disk = Some(text.into());
        state.revision += 1;
        self.tell_source(&mut state, text);
        Ok(state.revision)
    }

    /// Ends the run that is under way, and begins another.
    fn start(self: &Arc<Self>, state: &mut State) {
        state.end_worker();
        state.run += 1;
        let (run, good) = (state.run, state.good);
        state.events.retain(|event| event.run == 0 || Some(event.run) == good);
        let mut started = json!({ "event": "started", "choice": state.choice });
        if state.on_disk.as_ref() != Some(&state.text) {
            // A page that is opened now shows it, too.
            started["text"] = json!(&*state.text);
        }
        state.tell(run, started, None);
        let mut command = Command::new(&self.program);
        command
            .args(&self.line)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        match command.spawn() {
            Ok(child) => {
                state.worker = Some(Worker { child, input: None });
                let (session, text, choice) =
                    (self.clone(), state.text.clone(), state.choice.clone());
                let attended =
                    thread::Builder::new().spawn(move || session.attend(run, &text, choice));
                if attended.is_err() {
                    state.end_worker();
                }
            }
            Err(error) => {
                let message = format!("cannot start a run: {}", console::reason(&error));
                state.tell(run, failed(&plain_json(&message)), None);
            }
        }
        self.changed.notify_all();
    }

    /// Gives a worker its task, passes on what it tells, and notices its end.
    fn attend(self: &Arc<Self>, run: u64, text: &str, choice: Choice) {
        let Some((input, output, errors)) = self.state().streams(run) else { return };
        let errors = thread::spawn(move || {
            let mut text = Vec::new();
            let _ = errors.take(MAX_DIAGNOSTICS).read_to_end(&mut text);
            String::from_utf8_lossy(&text).into_owned()
        });
        if let Some(input) = give_task(input, text, choice)
            && let Some(worker) = self.state().worker_of(run)
        {
            worker.input = Some(input);
        }
        let mut output = BufReader::new(output);
        while let Some((message, file)) = read_message(&mut output) {
            self.pass_on(run, message, file);
        }
        let errors = errors.join().unwrap_or_default();
        let mut state = self.state();
        if state.worker_of(run).is_none() {
            return;
        }
        state.end_worker();
        if state.good != Some(run) {
            state.tell(run, failed(&errors), None);
            self.changed.notify_all();
        }
    }

    fn pass_on(&self, run: u64, message: Value, file: Option<File>) {
        let mut state = self.state();
        if state.worker_of(run).is_none() {
            return;
        }
        if message["event"] == "answer" {
            let waiting = message["id"].as_u64().and_then(|id| state.waiting.remove(&id));
            let _ = waiting.map(|waiting| waiting.answer.send((message["answer"].clone(), file)));
            return;
        }
        let n_kept: usize = state.files_of(run).map(|file| file.bytes.len()).sum();
        if n_kept + file.as_ref().map_or(0, |file| file.bytes.len()) > MAX_KEPT {
            if state.good != Some(run) {
                state.end_worker();
                let line = plain_json(&format!("the images take more than {} MiB", MAX_KEPT >> 20));
                state.tell(run, failed(&line), None);
                self.changed.notify_all();
            }
            return;
        }
        if message["event"] == "ended" {
            state.good = Some(run);
            state.events.retain(|event| event.run == 0 || event.run == run);
        }
        state.tell(run, message, file);
        self.changed.notify_all();
    }

    /// What there is to know of a pixel; null if it is not to be had.
    pub(super) fn pixel(&self, run: u64, image: usize, x: u32, y: u32) -> Value {
        let Some((id, answer)) = self.ask(run, image, About::Pixel { x, y }) else {
            return Value::Null;
        };
        let answer = answer.recv_timeout(LOOK_TIME);
        self.state().waiting.remove(&id);
        answer.map_or(Value::Null, |(answer, _)| answer)
    }

    /// What there is to know of all pixels of an image, or in JSON why it is not to be had; nothing if
    /// the run is not the current one, or has been asked for too much already.
    pub(super) fn map(&self, run: u64, image: usize, map: Map) -> Option<Answer> {
        let (_, answer) = self.ask(run, image, About::Map(map))?;
        // The worker answers, or is gone in time.
        answer.recv().ok()
    }

    /// Asks the worker of a run; returns the question's number and where the answer comes.
    fn ask(&self, run: u64, image: usize, about: About) -> Option<(u64, Receiver<Answer>)> {
        let is_map = |about: &About| matches!(about, About::Map(_));
        let max = if is_map(&about) { MAX_MAPS } else { MAX_LOOKS };
        let mut state = self.state();
        let alike = state.waiting.values().filter(|other| is_map(&other.about) == is_map(&about));
        if alike.count() >= max {
            return None;
        }
        state.n_questions += 1;
        let id = state.n_questions;
        let input = state.worker_of(run)?.input.as_mut()?;
        writeln!(input, "{}", json!(Question { id, image, about })).ok()?;
        let (sender, answer) = mpsc::channel();
        state.waiting.insert(id, Waiting { about, answer: sender });
        Some((id, answer))
    }

    /// The events after one, once there are any; none if there are none for this time.
    pub(super) fn events_after(&self, number: u64, patience: Duration) -> Vec<Arc<Event>> {
        let state = self.state();
        let is_idle = |state: &mut State| state.number <= number;
        let waited = self.changed.wait_timeout_while(state, patience, is_idle);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let is_new = |event: &&Arc<Event>| event.number > number;
        let mut events: Vec<_> = state.events.iter().filter(is_new).cloned().collect();
        if number == 0 {
            // Whatever else there is refers to it.
            events.sort_by_key(|event| event.kind != "source");
        }
        events
    }

    /// The event of a number, if it is still kept.
    pub(super) fn event(&self, number: u64) -> Option<Arc<Event>> {
        self.state().events.iter().find(|event| event.number == number).cloned()
    }
}

impl State {
    /// Adds an event; those that it overtakes are forgotten.
    fn tell(&mut self, run: u64, mut message: Value, file: Option<File>) {
        self.number += 1;
        message["run"] = json!(run);
        message["number"] = json!(self.number);
        let kind = message["event"].as_str().unwrap_or_default().to_owned();
        let image = message["image"].as_u64();
        self.events.retain(|event| {
            let is_draft = matches!(event.kind.as_str(), "coarse" | "band");
            let is_overtaken = match kind.as_str() {
                "picture" => is_draft && event.image == image,
                "source" => matches!(event.kind.as_str(), "source" | "disk"),
                "disk" => event.kind == kind,
                "plan" => event.kind == kind && event.image == image,
                _ => false,
            };
            !(is_overtaken && event.run == run)
        });
        let event =
            Event { number: self.number, run, kind, image, text: message.to_string(), file };
        self.events.push(Arc::new(event));
    }

    fn files_of(&self, run: u64) -> impl Iterator<Item = &File> {
        let is_of = move |event: &&Arc<Event>| event.run == run;
        self.events.iter().filter(is_of).filter_map(|event| event.file.as_ref())
    }

    fn worker_of(&mut self, run: u64) -> Option<&mut Worker> {
        self.worker.as_mut().filter(|_| self.run == run)
    }

    fn streams(
        &mut self,
        run: u64,
    ) -> Option<(ChildStdin, std::process::ChildStdout, std::process::ChildStderr)> {
        let child = &mut self.worker_of(run)?.child;
        Some((child.stdin.take()?, child.stdout.take()?, child.stderr.take()?))
    }

    /// Ends the worker, if there is one, and waits for its end.
    fn end_worker(&mut self) {
        self.waiting.clear();
        if let Some(mut worker) = self.worker.take() {
            let _ = worker.child.kill();
            let _ = worker.child.wait();
        }
    }
}

/// Hands over what is to be rendered; returns the stream, unless the worker is gone.
fn give_task(mut input: ChildStdin, text: &str, choice: Choice) -> Option<ChildStdin> {
    let task = Task { n_bytes: text.len(), choice };
    writeln!(input, "{}", json!(task)).ok()?;
    input.write_all(text.as_bytes()).ok()?;
    input.flush().ok()?;
    Some(input)
}

/// The next message of a worker, and its file; none at the end.
fn read_message(output: &mut impl BufRead) -> Option<(Value, Option<File>)> {
    let mut line = Vec::new();
    output.take(MAX_MESSAGE).read_until(b'\n', &mut line).ok()?;
    let message: Value = serde_json::from_slice(&line).ok()?;
    let Some(n_bytes) = message["bytes"].as_u64() else { return Some((message, None)) };
    if n_bytes > MAX_BYTES {
        return None;
    }
    let mut bytes = vec![0; n_bytes as usize];
    output.read_exact(&mut bytes).ok()?;
    let media_type = message["type"].as_str().unwrap_or_default().to_owned();
    Some((message, Some(File { media_type, bytes })))
}

/// The message that a run has failed, with the diagnostics that it wrote, a line of JSON each.
fn failed(errors: &str) -> Value {
    let mut diagnostics: Vec<Value> =
        errors.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    if diagnostics.is_empty() {
        let line = plain_json("the run has ended without a word; there may be no memory for it");
        diagnostics.extend(serde_json::from_str::<Value>(&line));
    }
    json!({ "event": "ended", "ok": false, "diagnostics": diagnostics })
}

/// The failure to begin at all.
pub(super) fn cannot(what: &str, error: &io::Error) -> Failure {
    Failure::Usage(format!("cannot {what}: {}", console::reason(error)))
}
