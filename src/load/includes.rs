//! Where included files are looked for, and that a scene which is not trusted reaches no others.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::fs::File;
use std::io;
use std::path::{Component, Path, PathBuf};

use compiler::preprocess::Includes;
use rustix::fs::{CWD, Mode, OFlags, openat};

use crate::args::Inputs;
use crate::load::{at_most, read_file};

/// Finds included files: beside the including file, then in the directories of `-I`.
pub(crate) struct FileIncludes<'a> {
    /// Of each file read, by the name shown, where files beside it are.
    places: HashMap<String, Place>,
    search: &'a [PathBuf],
    /// Links are not followed, and of the standard input nothing is beside.
    is_confined: bool,
}

/// A file or directory below one that the user has named.
#[derive(Clone)]
struct Place {
    root: PathBuf,
    below: PathBuf,
}

impl Place {
    fn of(root: &Path) -> Self {
        Place { root: root.to_owned(), below: PathBuf::new() }
    }

    fn join(&self, name: &Path) -> Self {
        Place { root: self.root.clone(), below: self.below.join(name) }
    }

    fn path(&self) -> PathBuf {
        self.root.join(&self.below)
    }
}

impl<'a> FileIncludes<'a> {
    /// For a scene of this name in this directory; none for the standard input.
    pub(crate) fn new(name: String, directory: Option<&Path>, inputs: &'a Inputs) -> Self {
        let is_confined = inputs.untrusted;
        let place = match directory {
            Some(directory) => Some(Place::of(directory)),
            None => (!is_confined).then(|| Place::of(Path::new(""))),
        };
        let places = place.into_iter().map(|place| (name.clone(), place)).collect();
        FileIncludes { places, search: &inputs.include_dirs, is_confined }
    }

    fn read(&self, place: &Place) -> Option<Vec<u8>> {
        if self.is_confined {
            return open_below(&place.root, &place.below).and_then(at_most).ok();
        }
        let path = place.path();
        path.is_file().then(|| read_file(&path).ok()).flatten()
    }
}

impl Includes for FileIncludes<'_> {
    fn load(&mut self, from: &str, name: &str) -> Option<(String, Vec<u8>)> {
        // `./x` is `x`: who includes whom is seen by the names.
        let is_here = |part: &Component<'_>| *part == Component::CurDir;
        let name: PathBuf = Path::new(name).components().filter(|part| !is_here(part)).collect();
        let beside = self.places.get(from).map(|place| place.join(&name));
        let elsewhere = self.search.iter().map(|directory| Place::of(directory).join(&name));
        let (place, bytes) = beside
            .into_iter()
            .chain(elsewhere)
            .find_map(|place| self.read(&place).map(|bytes| (place, bytes)))?;
        let shown = place.path().display().to_string();
        let below = place.below.parent().unwrap_or(Path::new("")).to_owned();
        self.places.insert(shown.clone(), Place { below, ..place });
        Some((shown, bytes))
    }
}

/// Opens a plain file below a directory. Each component is opened relative to the handle of the
/// directory before it and must be no link, so that nothing leads out.
fn open_below(root: &Path, below: &Path) -> io::Result<File> {
    let flags = OFlags::RDONLY | OFlags::CLOEXEC;
    let step = flags | OFlags::NOFOLLOW;
    let root = if root == Path::new("") { Path::new(".") } else { root };
    let mut directory = openat(CWD, root, flags | OFlags::DIRECTORY, Mode::empty())?;
    let mut components = below.components();
    let last = plain(components.next_back())?;
    for component in components {
        let component = plain(Some(component))?;
        directory = openat(&directory, component, step | OFlags::DIRECTORY, Mode::empty())?;
    }
    // Whatever else it may be, a pipe for one, opening it must not wait.
    let file = File::from(openat(&directory, last, step | OFlags::NONBLOCK, Mode::empty())?);
    if file.metadata()?.is_file() { Ok(file) } else { Err(io::ErrorKind::InvalidInput.into()) }
}

fn plain(component: Option<Component<'_>>) -> io::Result<&OsStr> {
    match component {
        Some(Component::Normal(name)) => Ok(name),
        _ => Err(io::ErrorKind::InvalidInput.into()),
    }
}
