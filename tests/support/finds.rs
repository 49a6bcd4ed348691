//! What fuzzing has found, in `fuzz/finds/TARGET`; tests try it again for ever.

use std::fs;
use std::path::{Path, PathBuf};

/// The directory of all finds.
pub(crate) fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/finds")
}

/// The finds of a fuzz target, of which there may be none.
pub(crate) fn of(target: &str) -> Vec<Vec<u8>> {
    let directory = directory().join(target);
    if directory.exists() { files(&directory) } else { Vec::new() }
}

/// What the files in a directory hold, by name.
pub(crate) fn files(directory: &Path) -> Vec<Vec<u8>> {
    let entries =
        fs::read_dir(directory).unwrap_or_else(|error| panic!("{}: {error}", directory.display()));
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.sort();
    paths.iter().filter(|path| path.is_file()).map(|path| fs::read(path).expect("read")).collect()
}
