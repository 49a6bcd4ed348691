//! Includes beside the including file.

use std::path::Path;

use compiler::preprocess::Includes;

/// Finds files where the one is that includes them.
pub(crate) struct Beside;

impl Includes for Beside {
    fn load(&mut self, from: &str, name: &str) -> Option<(String, Vec<u8>)> {
        let path = Path::new(from).with_file_name(name);
        Some((path.display().to_string(), std::fs::read(&path).ok()?))
    }
}
