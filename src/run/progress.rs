//! The progress bar: on a terminal, while an image is traced.

use std::fmt::Write;
use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// The bar is drawn so many times a second.
const HZ: u8 = 10;

const TEMPLATE: &str = "{msg}  [{bar:30}] {percent:>3} %  {rate}  {eta} left";

/// For runs of a benchmark.
const RUN_TEMPLATE: &str = "{msg}  [{bar:30}] {pos} of {len} runs  {eta} left";
const ENDLESS_TEMPLATE: &str = "{msg}  {spinner} {pos} runs  {elapsed}";

/// A bar for an image of `n_pixels`; one that is never seen if nobody watches.
pub(crate) fn bar(name: &str, n_pixels: u64, is_quiet: bool) -> ProgressBar {
    if is_hidden(is_quiet) {
        return ProgressBar::hidden();
    }
    let rate = |state: &ProgressState, out: &mut dyn Write| {
        let _ = write!(out, "{:.0} kpixel/s", state.per_sec() / 1e3);
    };
    let style = ProgressStyle::with_template(TEMPLATE)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ")
        .with_key("rate", rate);
    ProgressBar::with_draw_target(Some(n_pixels), ProgressDrawTarget::stderr_with_hz(HZ))
        .with_style(style)
        .with_message(name.to_owned())
}

/// A bar for a number of runs, or for as many as there will be.
pub(crate) fn run_bar(name: &str, n_runs: Option<u64>, is_quiet: bool) -> ProgressBar {
    if is_hidden(is_quiet) {
        return ProgressBar::hidden();
    }
    let template = if n_runs.is_some() { RUN_TEMPLATE } else { ENDLESS_TEMPLATE };
    let style = ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("=> ");
    ProgressBar::with_draw_target(n_runs, ProgressDrawTarget::stderr_with_hz(HZ))
        .with_style(style)
        .with_message(name.to_owned())
}

fn is_hidden(is_quiet: bool) -> bool {
    is_quiet || !io::stderr().is_terminal()
}
