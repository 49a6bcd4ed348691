//! Response files: `@FILE` stands for the arguments in `FILE`, one on each line.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read};

use crate::console;

/// More than any command line takes.
const MAX_BYTES: u64 = 1 << 20;

/// The arguments with those of response files in place. In such a file an empty line is none, white
/// space around an argument does not count, and `@` has no meaning: files name no further files.
///
/// # Errors
/// When a file cannot be read; says which and why.
pub(super) fn expanded(args: Vec<OsString>) -> Result<Vec<OsString>, String> {
    let mut all = Vec::with_capacity(args.len());
    for argument in args {
        match argument.to_str().and_then(|text| text.strip_prefix('@')) {
            Some(file) => all.extend(
                lines(file)?.lines().map(str::trim).filter(|l| !l.is_empty()).map(OsString::from),
            ),
            None => all.push(argument),
        }
    }
    Ok(all)
}

fn lines(file: &str) -> Result<String, String> {
    let read = || -> io::Result<String> {
        let mut text = String::new();
        File::open(file)?.take(MAX_BYTES + 1).read_to_string(&mut text)?;
        Ok(text)
    };
    match read() {
        Ok(text) if text.len() as u64 > MAX_BYTES => {
            Err(format!("`@{file}`: the file is too long"))
        }
        Ok(text) => Ok(text),
        Err(error) => Err(format!("`@{file}`: {}", console::reason(&error))),
    }
}
