//! The places where a run's outputs go, as its command line names them.

use std::path::{Component, Path, PathBuf};

use crate::args::RunArgs;
use crate::load::is_stdio;

impl RunArgs {
    /// The directories that a run writes in, and the devices it writes to.
    pub(crate) fn writable(&self) -> Vec<PathBuf> {
        let below_out = |name: &PathBuf| self.out_dir.join(name);
        let images = self.output.iter().map(below_out);
        let marks = self.mark_uncertain.iter().cloned();
        let named = images.chain(marks).chain(self.stats.iter().cloned());
        let files = named.filter(|path| !is_stdio(path)).map(|path| place(&path));
        let map = self.perf_map.then(|| PathBuf::from("/tmp"));
        let parts = self.parts.parts.clone();
        std::iter::once(self.out_dir.clone()).chain(files).chain(map).chain(parts).collect()
    }
}

/// The device of this name, or the directory that the file is in or will be in: above whatever depends
/// on the image.
fn place(file: &Path) -> PathBuf {
    let file = file.canonicalize().unwrap_or_else(|_| file.to_owned());
    if file.exists() && !file.is_file() {
        return file;
    }
    let is_fixed = |part: &Component<'_>| !part.as_os_str().to_string_lossy().contains('{');
    let parent = file.parent().unwrap_or(Path::new(""));
    let directory: PathBuf = parent.components().take_while(is_fixed).collect();
    if directory.as_os_str().is_empty() { PathBuf::from(".") } else { directory }
}
