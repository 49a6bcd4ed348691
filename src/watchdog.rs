//! The watchdog: ends the process from beside the work, when a signal says so or the time is up.
//!
//! The work may be anywhere then: in machine code, deep in a library, or waiting for a pipe that
//! nobody reads. So it is not asked to stop, which takes time and places to look; the process ends under
//! it. Nothing is torn by that: files have no name before they are complete, and the few names that
//! stand for one meanwhile are removed.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread;
use std::time::Duration;

use compiler::diagnostic::{Code, Diagnostic};
use compiler::source::{SourceMap, Span};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;

use crate::console;
use crate::failure::Failure;
use crate::output;
use crate::report::Reporter;
use crate::run::progress;
use crate::watch;

/// Removing temporary names and clearing the terminal take no time, unless a disk or a terminal hangs;
/// so long is waited for them.
const GRACE: Duration = Duration::from_millis(80);

/// Shells show so much more than its number for a process that a signal has ended.
const EXIT_SIGNALLED: i32 = 128;

/// Watches for signals and, if there is a limit, over the time from now on.
///
/// # Errors
/// When the system refuses a handler or a thread.
pub(crate) fn start(timeout: Option<Duration>, reporter: Reporter) -> Result<(), Failure> {
    let failed = |error| {
        Failure::Usage(format!("cannot watch over signals and time: {}", console::reason(&error)))
    };
    // With a handler, writing more than the shell's limit for files is an error like any other.
    signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false))).map_err(failed)?;
    let ignored = ignored_signals();
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|n| ignored >> (n - 1) & 1 == 0);
    let mut signals = Signals::new(wanted).map_err(failed)?;
    let watch = thread::Builder::new().name("signals".to_owned());
    let on_signal = move || {
        if let Some(signal) = signals.forever().next() {
            end(EXIT_SIGNALLED + signal, None::<fn(Option<String>)>);
        }
    };
    watch.spawn(on_signal).map_err(failed)?;
    if let Some(timeout) = timeout {
        let watch = thread::Builder::new().name("timeout".to_owned());
        let on_timeout = move || {
            thread::sleep(timeout);
            let code = Failure::Shown(Code::TimeLimit.class()).exit_code();
            let tell = move |interrupted| {
                let diagnostic = out_of_time(timeout, interrupted);
                reporter.diagnostics(&[diagnostic], &SourceMap::default(), None);
            };
            end(code.into(), Some(tell));
        };
        watch.spawn(on_timeout).map_err(failed)?;
    }
    Ok(())
}

/// Ends the process with this code. `tell` has a word with the user, and is told what has been
/// interrupted.
fn end(code: i32, tell: Option<impl FnOnce(Option<String>) + Send + 'static>) -> ! {
    /// Only one can end it; whoever comes second waits here until it has.
    static ENDING: Mutex<()> = Mutex::new(());
    let _ending = ENDING.lock().unwrap_or_else(PoisonError::into_inner);
    output::abandon(GRACE);
    // Whatever may wait for others is the business of another thread. Where there is nothing of it none is
    // started, since on a busy machine each change of threads takes its time.
    if tell.is_some() || progress::is_shown() || watch::is_running() {
        let (finished, wait) = mpsc::channel();
        thread::spawn(move || {
            watch::abandon();
            let interrupted = progress::abandon();
            if let Some(tell) = tell {
                tell(interrupted);
            }
            let _ = finished.send(());
        });
        let _ = wait.recv_timeout(GRACE);
    }
    std::process::exit(code)
}

/// The error that tells that the time is up, with what it interrupted.
pub(crate) fn out_of_time(timeout: Duration, interrupted: Option<String>) -> Diagnostic {
    let message = format!("the time limit of {} s is reached", timeout.as_secs_f64());
    let diagnostic = Diagnostic::new(Code::TimeLimit, Span::NONE, message);
    let diagnostic = match interrupted {
        Some(image) => diagnostic.note(image),
        None => diagnostic,
    };
    diagnostic.help("raise the limit with `--timeout SECONDS`")
}

/// The signals that whoever started the process wants ignored, as a set of bits: `nohup` does that,
/// and shells that run a job in the background. Where the system does not tell, none.
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok()).unwrap_or(0)
}
