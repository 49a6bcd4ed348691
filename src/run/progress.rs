//! The progress bar: on a terminal, while an image is traced or a benchmark runs.

use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::console;

/// From one drawing to the next.
const PERIOD: Duration = Duration::from_millis(100);

/// Characters between the brackets.
const WIDTH: u64 = 30;

/// Empties the line, at whose start the cursor is then.
const CLEAR: &str = "\r\u{1b}[2K";

/// The bar made last, for whoever ends the process.
static LAST: Mutex<Option<Bar>> = Mutex::new(None);

/// How far something is, on the terminal unless nobody watches.
#[derive(Clone)]
pub(crate) struct Bar(Arc<State>);

struct State {
    name: String,
    counted: Counted,
    n_done: AtomicU64,
    start: Instant,
    is_shown: bool,
    /// When it was drawn last; `None` once it is over. Who draws or clears holds it.
    drawn: Mutex<Option<Instant>>,
}

#[derive(Clone, Copy)]
enum Counted {
    /// Of so many.
    Pixels(u64),
    /// Of so many, or of as many as there will be.
    Runs(Option<u64>),
}

/// Whether there may be a bar on the terminal. (One that is drawn on a terminal that hangs would not
/// answer.)
pub(crate) fn is_shown() -> bool {
    LAST.lock().unwrap_or_else(PoisonError::into_inner).as_ref().is_some_and(|bar| bar.0.is_shown)
}

/// A bar for an image of `n_pixels`.
pub(crate) fn bar(name: &str, n_pixels: u64, is_quiet: bool) -> Bar {
    Bar::new(name, Counted::Pixels(n_pixels), is_quiet)
}

/// A bar for a number of runs, or for as many as there will be.
pub(crate) fn run_bar(name: &str, n_runs: Option<u64>, is_quiet: bool) -> Bar {
    Bar::new(name, Counted::Runs(n_runs), is_quiet)
}

/// Clears the bar that may be on the terminal. Returns how far the image was that is being traced.
pub(crate) fn abandon() -> Option<String> {
    let bar = LAST.lock().unwrap_or_else(PoisonError::into_inner).take()?;
    if !bar.end() {
        return None;
    }
    let Counted::Pixels(n_pixels @ 1..) = bar.0.counted else { return None };
    let percent = bar.n_done().min(n_pixels) as f64 / n_pixels as f64 * 100.0;
    Some(format!("`{}` was being rendered, {percent:.0} % of it done", bar.0.name))
}

impl Bar {
    fn new(name: &str, counted: Counted, is_quiet: bool) -> Bar {
        let is_dumb = std::env::var_os("TERM").is_none_or(|term| term == "dumb");
        let bar = Bar(Arc::new(State {
            name: name.to_owned(),
            counted,
            n_done: AtomicU64::new(0),
            start: Instant::now(),
            is_shown: !is_quiet && !is_dumb && io::stderr().is_terminal(),
            drawn: Mutex::new(Some(Instant::now())),
        }));
        bar.draw();
        *LAST.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.clone());
        bar
    }

    /// So many more are done.
    pub(crate) fn inc(&self, n: u64) {
        self.0.n_done.fetch_add(n, Ordering::Relaxed);
        // Whoever does not get the lock leaves it to another thread to draw.
        let Ok(mut drawn) = self.0.drawn.try_lock() else { return };
        if drawn.is_some_and(|last| last.elapsed() >= PERIOD) {
            *drawn = Some(Instant::now());
            self.draw();
        }
    }

    /// It is over, and off the terminal.
    pub(crate) fn finish(&self) {
        self.end();
    }

    /// Whether it was not over before.
    fn end(&self) -> bool {
        let mut drawn = self.0.drawn.lock().unwrap_or_else(PoisonError::into_inner);
        let is_first = drawn.take().is_some();
        if is_first && self.0.is_shown {
            console::say(CLEAR);
        }
        is_first
    }

    fn n_done(&self) -> u64 {
        self.0.n_done.load(Ordering::Relaxed)
    }

    fn draw(&self) {
        if self.0.is_shown {
            let line = line(&self.0.name, self.0.counted, self.n_done(), self.0.start.elapsed());
            // What is wider than the terminal is cut there, since only one line is cleared.
            console::say(&format!("{CLEAR}\u{1b}[?7l{line}\u{1b}[?7h"));
        }
    }
}

fn line(name: &str, counted: Counted, n_done: u64, elapsed: Duration) -> String {
    let seconds = elapsed.as_secs_f64().max(f64::MIN_POSITIVE);
    let (Counted::Pixels(length) | Counted::Runs(Some(length))) = counted else {
        return format!("{name}  {n_done} runs  {seconds:.0} s");
    };
    let n_done = n_done.min(length);
    let done = (n_done * WIDTH).checked_div(length).unwrap_or(0) as usize;
    let head = if n_done < length { ">" } else { "" };
    let bar = format!("[{:<1$}]", "=".repeat(done) + head, WIDTH as usize);
    let so_far = match counted {
        Counted::Pixels(_) => {
            let percent = (n_done * 100).checked_div(length).unwrap_or(0);
            format!("{percent:>3} %  {:.0} kpixel/s", n_done as f64 / seconds / 1e3)
        }
        Counted::Runs(_) => format!("{n_done} of {length} runs"),
    };
    let left = match n_done {
        0 => "?".to_owned(),
        _ => format!("{:.0} s", seconds / n_done as f64 * (length - n_done) as f64),
    };
    format!("{name}  {bar} {so_far}  {left} left")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_say_how_far_it_is() {
        let after =
            |seconds, counted, n_done| line("a.ppm", counted, n_done, Duration::from_secs(seconds));
        let pixels = Counted::Pixels(400_000);
        for (line, expected) in [
            (
                after(0, pixels, 0),
                "a.ppm  [>                             ]   0 %  0 kpixel/s  ? left",
            ),
            (
                after(2, pixels, 100_000),
                "a.ppm  [=======>                      ]  25 %  50 kpixel/s  6 s left",
            ),
            (
                after(4, pixels, 400_000),
                "a.ppm  [==============================] 100 %  100 kpixel/s  0 s left",
            ),
            (
                after(9, Counted::Runs(Some(60)), 58),
                "a.ppm  [=============================>] 58 of 60 runs  0 s left",
            ),
            (after(7, Counted::Runs(None), 3), "a.ppm  3 runs  7 s"),
            (after(1, Counted::Pixels(0), 0), "a.ppm  [                              ]   0 %"),
        ] {
            assert!(line.starts_with(expected), "{line:?} is not {expected:?}");
        }
    }
}
