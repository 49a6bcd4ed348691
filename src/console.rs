//! The standard streams: data on one, words for the user on the other.

use std::fmt::Display;
use std::io::{self, BufWriter, IsTerminal, Write};

use crate::failure::Failure;

/// Writes data to the standard output.
///
/// # Errors
/// When the output is full, broken, or closed at the other end.
pub(crate) fn data(fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    let mut out = BufWriter::new(io::stdout().lock());
    fill(&mut out).and_then(|()| out.flush()).map_err(|error| {
        // The buffer would be written again, and fail again, when dropped.
        let _ = out.into_parts();
        Failure::stdout(&error)
    })
}

/// Writes words for the user. That nobody can hear them is no reason to stop.
pub(crate) fn say(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// What the system says about an error, in the style of our messages.
pub(crate) fn reason(error: &impl Display) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or_default();
    let mut chars = text.chars();
    let first = chars.next().map(|c| c.to_ascii_lowercase());
    first.into_iter().chain(chars).collect()
}

/// Whether messages may be coloured when the user has not said.
pub(crate) fn wants_color() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if is_set("NO_COLOR") {
        return false;
    }
    if std::env::var_os("CLICOLOR_FORCE").is_some_and(|value| !value.is_empty() && value != "0") {
        return true;
    }
    io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}
