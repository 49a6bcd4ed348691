//! The commands, one function each.

use crate::args::{Args, Command};
use crate::failure::Failure;
use crate::lsp;
use crate::report::Reporter;
use crate::{view, watch};

pub(crate) use accept::run_to_the_end;

mod accept;
mod bench;
mod chart;
mod check;
mod diff;
mod disasm;
mod eval;
mod explain;
mod manual;
mod merge;
mod run;
mod stability;

pub(crate) use run::threads;

/// Runs the command and returns the exit code.
///
/// # Errors
/// Why it ended early.
pub(crate) fn execute(args: &Args, reporter: &Reporter) -> Result<u8, Failure> {
    match &args.command {
        Command::Run(run) if run.watch => watch::watch(run, &args.line, reporter),
        Command::Run(args) => run::run(args, reporter),
        Command::Check(args) => check::check(args, reporter),
        Command::Lsp(args) => lsp::serve(args),
        Command::Disasm(args) => disasm::disasm(args, reporter),
        Command::Eval(args) => eval::eval(args, reporter),
        Command::Diff(args) => diff::diff(args),
        Command::Bench(args) => bench::bench(args, reporter),
        Command::Chart(args) => chart::chart(args, reporter),
        Command::Stability(args) => stability::stability(args, reporter),
        Command::Merge(args) => merge::merge(args, reporter),
        Command::View(view) => view::view(view, &args.line, reporter),
        Command::Explain(args) => explain::explain(args),
        Command::Completions(args) => manual::completions(args),
        Command::Man(args) => manual::man(args),
    }
}
