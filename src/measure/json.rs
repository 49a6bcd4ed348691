//! Files of results: JSON, written complete or not at all, and read with care.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::clean::clean;
use crate::console;
use crate::failure::Failure;
use crate::output::Target;

/// Files of results are not longer than this: some millions of times.
const MAX_BYTES: u64 = 64 << 20;

/// Writes results to a file, or to the standard output for `-`.
///
/// # Errors
/// When it cannot be done.
pub(crate) fn write(path: &Path, results: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(results)
        .map_err(|error| Failure::Output(format!("could not write the results: {error}")))?;
    if path.as_os_str() == "-" {
        return console::data(|out| writeln!(out, "{text}"));
    }
    Target::path(path.to_owned()).write_plain(&mut |out| writeln!(out, "{text}"))
}

/// Reads a file of results, which should be `what`.
///
/// # Errors
/// Says what is wrong, and where.
pub(crate) fn read<T: DeserializeOwned>(path: &Path, what: &str) -> Result<T, Failure> {
    let name = clean(&path.display().to_string()).into_owned();
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes)).map_err(
        |error| Failure::Usage(format!("cannot read `{name}`: {}", console::reason(&error))),
    )?;
    if bytes.len() as u64 > MAX_BYTES {
        let limit = MAX_BYTES >> 20;
        return Err(Failure::Usage(format!("`{name}` is longer than {limit} MiB")));
    }
    serde_json::from_slice(&bytes).map_err(|error| {
        let text = error.to_string();
        let reason = text.rsplit_once(" at line ").map_or(text.as_str(), |(reason, _)| reason);
        let (line, column) = (error.line(), error.column());
        Failure::Usage(format!("{name}:{line}:{column}: not {what}: {}", clean(reason)))
    })
}
