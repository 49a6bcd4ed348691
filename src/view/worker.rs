//! The process behind one state of a page: renders a scene once, tells what there is to know of it, and
//! then answers what pixels are about, until it is ended or its server is gone.
//!
//! It is a process of its own so that it can be ended wherever it is, that nothing which a scene does
//! harms the server, and that the kernel can keep it from writing anything.

use std::io::{self, BufRead, Read};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use compiler::source::{MAX_SOURCE_BYTES, SourceMap};
use serde_json::json;
use vm::machine::Machine;
use vm::program::LoadedProgram;

use crate::args::{ViewArgs, sampling};
use crate::driver;
use crate::failure::Failure;
use crate::load::Source;
use crate::report::Reporter;
use crate::run::stats::{Counts, Phases, Stats, seconds};
use crate::view::extras;
use crate::view::kept::Kept;
use crate::view::live::Live;
use crate::view::maps;
use crate::view::protocol::{About, Method, Out, Question, Task};
use crate::watchdog;

/// The images so far, for whoever looks at pixels.
pub(super) type Images = Mutex<Vec<Arc<Kept>>>;

/// Does what the standard input says.
///
/// # Errors
/// When something is wrong with the scene; the server has been told.
pub(super) fn work(args: &ViewArgs, reporter: &Reporter) -> Result<u8, Failure> {
    #[cfg(target_os = "linux")]
    crate::confine::confine(&[]);
    let mut input = io::stdin().lock();
    let (task, text) = read_task(&mut input).ok_or_else(broken)?;
    drop(input);
    let method = task.choice.method().ok_or_else(broken)?;
    let is_rendered = Arc::new(AtomicBool::new(false));
    let is_told = Arc::new(AtomicBool::new(false));
    limit_time(args.time.timeout, [is_rendered.clone(), is_told.clone()], *reporter);
    // What lives as long as the process.
    let args: &'static ViewArgs = Box::leak(Box::new(args.clone()));
    let out: &'static Out = Box::leak(Box::new(Out::new()));
    let images: &'static Images = Box::leak(Box::default());
    let start = Instant::now();
    let mut source = Source::of_bytes(text, &args.scene, &args.inputs, start, reporter)?;
    let compile_start = Instant::now();
    let program = Arc::new(LoadedProgram::new(source.compile(reporter)?));
    let compile = seconds(compile_start.elapsed());
    let source: &'static Source<'_> = Box::leak(Box::new(source));
    thread::spawn(move || answer(images, &source.sources, args, out));
    let threads = driver::threads(args.threads.map_or(0, usize::from))?;
    let mut live = Live::new(args, method, &threads, out, images);
    let run_start = Instant::now();
    let outcome = Machine::new(&program, args.limits.machine()).run(&mut live);
    let run = seconds(run_start.elapsed().saturating_sub(live.busy));
    outcome.map_err(|error| match live.stopped_by.take() {
        Some(failure) => failure,
        None => source.stopped(error.into_diagnostic(), reporter),
    })?;
    is_rendered.store(true, Ordering::Relaxed);
    let functions = &program.bytecode.functions;
    let read = seconds(source.read_time);
    let stats = Stats {
        version: env!("CARGO_PKG_VERSION"),
        scene: args.scene.display().to_string(),
        engine: method.engine.name(),
        precision: method.precision.name(),
        sampling: sampling::name(method.sampling),
        threads: threads.current_num_threads(),
        total: seconds(start.elapsed()),
        phases: Phases { read, compile, run, ..live.stats.phases },
        counts: Counts {
            functions: functions.len(),
            instructions: functions.iter().map(|function| function.code.len()).sum(),
            ..live.stats.counts
        },
        ..live.stats
    };
    out.send(json!({ "event": "stats", "stats": stats }));
    out.send(json!({ "event": "ended", "ok": true, "n": stats.counts.images }));
    extras::tell(args, method, source, &program, images, &threads, out);
    is_told.store(true, Ordering::Relaxed);
    // The thread that answers ends the process.
    loop {
        thread::park();
    }
}

fn broken() -> Failure {
    Failure::Usage("expected a task on the standard input".to_owned())
}

fn read_task(input: &mut impl BufRead) -> Option<(Task, Vec<u8>)> {
    let mut line = String::new();
    input.take(1 << 12).read_line(&mut line).ok()?;
    let task: Task = serde_json::from_str(&line).ok()?;
    if task.n_bytes > MAX_SOURCE_BYTES {
        return None;
    }
    let mut text = vec![0; task.n_bytes];
    input.read_exact(&mut text).ok()?;
    Some((task, text))
}

/// Ends the process if the images take longer than this, or what is told afterwards. That is not worth a
/// word: pixels cannot be asked about any more, but nothing is wrong.
fn limit_time(
    limit: Option<Duration>,
    [is_rendered, is_told]: [Arc<AtomicBool>; 2],
    reporter: Reporter,
) {
    let Some(limit) = limit else { return };
    thread::spawn(move || {
        thread::sleep(limit);
        if !is_rendered.load(Ordering::Relaxed) {
            let diagnostic = watchdog::out_of_time(limit, None);
            let failure = reporter.diagnostics(&[diagnostic], &SourceMap::default(), None);
            std::process::exit(failure.exit_code().into());
        }
        thread::sleep(limit);
        if !is_told.load(Ordering::Relaxed) {
            std::process::exit(0);
        }
    });
}

/// Answers what is asked on the standard input; ends the process when that ends.
fn answer(images: &Images, sources: &SourceMap, args: &'static ViewArgs, out: &'static Out) {
    for line in io::stdin().lock().lines() {
        let Ok(line) = line else { break };
        let Ok(question) = serde_json::from_str::<Question>(&line) else { break };
        let Question { id, image, about } = question;
        let image = {
            let images = images.lock().unwrap_or_else(PoisonError::into_inner);
            images.get(image).cloned()
        };
        match about {
            About::Pixel { x, y } => {
                let pixel = image.and_then(|image| image.pixel(x, y, sources, args.limits));
                out.send(json!({ "event": "answer", "id": id, "answer": pixel }));
            }
            About::Map(map) => maps::answer(id, image, map, args, out),
        }
    }
    std::process::exit(0);
}

impl Method {
    /// The settings of a tracer.
    pub(super) fn settings<'s>(
        self,
        args: &ViewArgs,
        threads: &'s rayon::ThreadPool,
    ) -> crate::trace::Settings<'s> {
        crate::trace::Settings {
            threads,
            engine: self.engine,
            precision: self.precision,
            omissions: renderer::plan::Omissions::ALL,
            sampling: self.sampling,
            limits: args.limits.machine(),
            perf_map: None,
            clock: crate::measure::machine::time,
        }
    }
}
