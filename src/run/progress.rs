//! The progress bar: on a terminal, while an image is traced.

use std::fmt::Write;
use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// The bar is drawn so many times a second.
const HZ: u8 = 10;

const TEMPLATE: &str = "{msg}  [{bar:30}] {percent:>3} %  {rate}  {eta} left";

/// A bar for an image of `n_pixels`; one that is never seen if nobody watches.
pub(crate) fn bar(name: &str, n_pixels: u64, is_quiet: bool) -> ProgressBar {
    if is_quiet || !io::stderr().is_terminal() {
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
