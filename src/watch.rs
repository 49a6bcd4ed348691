//! `gmlvm run --watch`: the same run again, whenever a file that it reads changes.
//!
//! Each run is a process of its own: so one that is overtaken by the next change can be ended wherever it
//! is, and whatever a scene does, watching goes on. Images are replaced when they are complete, so
//! errors leave the last good one. Changes are found by looking, which works for all editors and file
//! systems, and costs a few system calls a second for each file.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, SystemTime};

use rustix::process::{Pid, Signal, kill_process};

use crate::args::{Inputs, RunArgs};
use crate::console;
use crate::failure::Failure;
use crate::load::{self, is_stdio};
use crate::report::Reporter;

/// How often is looked for changes: little of the 300 ms after which a saved scene is to be seen, and still
/// next to no work.
const PERIOD: Duration = Duration::from_millis(20);

/// The run that is under way, for whoever ends the process.
static RUN: Mutex<Option<Child>> = Mutex::new(None);

/// What tells a state of a file from another; none if there is no such file.
type Stamp = Option<(u64, SystemTime)>;

/// Runs a scene again and again, with the arguments `line` but without `--watch`, until a signal ends it.
///
/// # Errors
/// When the scene is the standard input, or no process can be started.
pub(crate) fn watch(args: &RunArgs, line: &[OsString], reporter: &Reporter) -> Result<u8, Failure> {
    if is_stdio(&args.scene) {
        return Err(Failure::Usage("the standard input cannot be watched".to_owned()));
    }
    args.outputs.check_watched()?;
    let failed =
        |error| Failure::Usage(format!("cannot start a run to watch: {}", console::reason(&error)));
    let program = std::env::current_exe().map_err(failed)?;
    loop {
        let before = Watched::now(&args.scene, &args.inputs);
        {
            // Whoever ends the process waits until the run is known.
            let mut run = run_under_way();
            *run = Some(Command::new(&program).args(line).spawn().map_err(failed)?);
        }
        reporter.detail(&format!("watching {} files and directories", before.0.len()));
        // An ended run is not left as a zombie.
        before.await_change(&|| {
            let _ = run_under_way().as_mut().map(Child::try_wait);
        });
        abandon();
    }
}

/// Whether there is a run to be ended.
pub(crate) fn is_running() -> bool {
    run_under_way().is_some()
}

/// Ends the run that may be under way, and waits for its end.
pub(crate) fn abandon() {
    let Some(mut child) = run_under_way().take() else { return };
    if matches!(child.try_wait(), Ok(None)) {
        let process = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
        let _ = process.map(|process| kill_process(process, Signal::TERM));
        let _ = child.wait();
    }
}

fn run_under_way() -> MutexGuard<'static, Option<Child>> {
    RUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The files that a scene reads, as they were at a time. Where one is not found, the directories in
/// which it may appear are watched too.
pub(crate) struct Watched(BTreeMap<PathBuf, Stamp>);

impl Watched {
    /// The files as they are now.
    pub(crate) fn now(scene: &Path, inputs: &Inputs) -> Self {
        let (found, is_complete) = load::files(scene, inputs);
        let mut paths = vec![scene.to_owned()];
        paths.extend(found);
        if !is_complete {
            let beside = scene.parent().unwrap_or(Path::new(""));
            paths.push(if beside == Path::new("") {
                PathBuf::from(".")
            } else {
                beside.to_owned()
            });
            paths.extend(inputs.include_dirs.iter().cloned());
        }
        Watched(stamps(&paths))
    }

    /// Returns when a file is not what it was, and is not being changed any more, with the paths of
    /// those that are not. `tick` is called whenever they are looked at.
    pub(crate) fn await_change(&self, tick: &dyn Fn()) -> Vec<PathBuf> {
        let now = || self.0.keys().map(|path| (path.clone(), stamp(path))).collect();
        loop {
            thread::sleep(PERIOD);
            tick();
            let mut changed: BTreeMap<_, _> = now();
            if changed == self.0 {
                continue;
            }
            loop {
                thread::sleep(PERIOD);
                let settled = now();
                if settled == changed {
                    let differs = |(path, stamp): &(PathBuf, Stamp)| self.0[path] != *stamp;
                    return changed.into_iter().filter(differs).map(|(path, _)| path).collect();
                }
                changed = settled;
            }
        }
    }
}

fn stamps(paths: &[PathBuf]) -> BTreeMap<PathBuf, Stamp> {
    paths.iter().map(|path| (path.clone(), stamp(path))).collect()
}

fn stamp(path: &Path) -> Stamp {
    let metadata = path.metadata().ok()?;
    Some((metadata.len(), metadata.modified().ok()?))
}
