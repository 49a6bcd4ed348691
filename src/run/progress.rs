//! The progress bar: on a terminal, while an image is traced.

use std::fmt::Write;
use std::io::{self, IsTerminal};
use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// The bar is drawn so many times a second.
const HZ: u8 = 10;

const TEMPLATE: &str = "{msg}  [{bar:30}] {percent:>3} %  {rate}  {eta} left";

/// For runs of a benchmark.
const RUN_TEMPLATE: &str = "{msg}  [{bar:30}] {pos} of {len} runs  {eta} left";
const ENDLESS_TEMPLATE: &str = "{msg}  {spinner} {pos} runs  {elapsed}";

/// The bar made last, for whoever ends the process, and whether it can be seen. (A bar that is drawn on a
/// terminal that hangs would not answer.)
static LAST: Mutex<Option<(ProgressBar, bool)>> = Mutex::new(None);

fn remember(bar: &ProgressBar, is_shown: bool) {
    let last = Some((bar.clone(), is_shown));
    *LAST.lock().unwrap_or_else(PoisonError::into_inner) = last;
}

/// Whether there may be a bar on the terminal.
pub(crate) fn is_shown() -> bool {
    LAST.lock().unwrap_or_else(PoisonError::into_inner).as_ref().is_some_and(|last| last.1)
}

/// A bar for an image of `n_pixels`; one that is never seen if nobody watches.
pub(crate) fn bar(name: &str, n_pixels: u64, is_quiet: bool) -> ProgressBar {
    let bar = image_bar(name, n_pixels, is_quiet);
    remember(&bar, !is_hidden(is_quiet));
    bar
}

fn image_bar(name: &str, n_pixels: u64, is_quiet: bool) -> ProgressBar {
    if is_hidden(is_quiet) {
        let bar = ProgressBar::hidden().with_message(name.to_owned());
        bar.set_length(n_pixels);
        return bar;
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
    let bar = ProgressBar::with_draw_target(n_runs, ProgressDrawTarget::stderr_with_hz(HZ))
        .with_style(style)
        .with_message(name.to_owned());
    remember(&bar, true);
    bar
}

/// Clears the bar that may be on the terminal. Returns how far the image was that is being traced.
pub(crate) fn abandon() -> Option<String> {
    let (bar, _) = LAST.lock().unwrap_or_else(PoisonError::into_inner).take()?;
    if bar.is_finished() {
        return None;
    }
    let text = bar.length().filter(|n| *n > 0).map(|n_pixels| {
        let percent = bar.position().min(n_pixels) as f64 / n_pixels as f64 * 100.0;
        format!("`{}` was being rendered, {percent:.0} % of it done", bar.message())
    });
    bar.finish_and_clear();
    text
}

fn is_hidden(is_quiet: bool) -> bool {
    is_quiet || !io::stderr().is_terminal()
}
