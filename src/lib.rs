//! What the program `gmlvm` is made of: reads the command line, runs one command, and turns how it ended
//! into an exit code. What the commands do is in [`driver`]; only this crate touches files and streams.
//!
//! It is a library for the sake of the fuzz targets, which need `fuzzed` of it.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use crate::args::Command;
use crate::report::Reporter;

mod args;
mod chart;
mod clean;
#[cfg(target_os = "linux")]
mod confine;
mod console;
mod crash;
mod driver;
mod failure;
mod formats;
mod frames;
#[cfg(any(test, feature = "fuzzed"))]
pub mod fuzzed;
mod listing;
mod load;
mod lsp;
mod measure;
mod output;
mod parts;
mod perf;
mod preview;
mod report;
mod run;
mod stability;
mod trace;
mod values;
mod view;
mod watch;
mod watchdog;

/// Does what the command line says; returns the exit code.
pub fn run_command_line() -> ExitCode {
    let args = args::parse();
    let reporter = match &args.command {
        Command::View(view) if view.worker => Reporter::for_programs(),
        _ => Reporter::new(&args.common),
    };
    let ended = crash::guarded(|| {
        watchdog::start(args.command.timeout(), reporter)?;
        crash::require_cpu()?;
        driver::execute(&args, &reporter)
    });
    match ended {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            if let Some(message) = failure.message() {
                reporter.message(message);
            }
            ExitCode::from(failure.exit_code())
        }
    }
}
