//! The directory that a name from a scene leads to.
//!
//! Every component is one plain name, opened relative to the handle of the directory before it,
//! without following a link. So nobody can lead us out of the output directory, not even by moving
//! directories around meanwhile.

use std::fs::{self, File};
use std::io::Read;
use std::os::fd::OwnedFd;
use std::path::Path;

use rustix::fs::{AtFlags, FileType, Mode, OFlags, mkdirat, openat, statat, unlinkat};
use rustix::io::Errno;

use crate::formats;
use crate::output::Problem;

/// What is said of a directory where a file should be.
pub(super) const DIRECTORY_IN_PLACE: &str = "a directory is in its place";

/// The directory that a file goes to, and the file's name in it.
#[derive(Debug)]
pub(super) struct Place {
    pub(super) directory: OwnedFd,
    pub(super) name: String,
    /// The directories made on the way, each with the handle of its parent.
    made: Vec<(OwnedFd, String)>,
}

/// Looks whether a file could be written, as far as that can be seen without making directories.
pub(super) fn inspect(root: &Path, components: &[String]) -> Result<(), Problem> {
    let Ok(root) = File::open(root) else { return Ok(()) };
    let mut directory = OwnedFd::from(root);
    let (name, parents) = split(components);
    for parent in parents {
        match descend(&directory, parent) {
            Ok(next) => directory = next,
            Err(Errno::NOENT) => return Ok(()),
            Err(error) => return Err(blocked(&directory, parent, error)),
        }
    }
    check(&directory, name)
}

/// Opens the directory of a file, and makes what is missing of it.
pub(super) fn open(root: &Path, components: &[String]) -> Result<Place, Problem> {
    fs::create_dir_all(root)?;
    let (name, parents) = split(components);
    let directory = OwnedFd::from(File::open(root)?);
    let mut place = Place { directory, name: name.to_owned(), made: Vec::new() };
    for parent in parents {
        if let Err(problem) = place.enter(parent) {
            place.remove_new_directories();
            return Err(problem);
        }
    }
    Ok(place)
}

impl Place {
    /// Fails if something that is no file has the file's name.
    pub(super) fn check(&self) -> Result<(), Problem> {
        check(&self.directory, &self.name)
    }

    /// Removes the directories made on the way; those that others use meanwhile stay.
    pub(super) fn remove_new_directories(&self) {
        for (parent, name) in self.made.iter().rev() {
            let _ = unlinkat(parent, name, AtFlags::REMOVEDIR);
        }
    }

    fn enter(&mut self, component: &str) -> Result<(), Problem> {
        match mkdirat(&self.directory, component, Mode::from_raw_mode(0o777)) {
            Ok(()) => {
                let parent = self.directory.try_clone()?;
                self.made.push((parent, component.to_owned()));
            }
            Err(Errno::EXIST) => {}
            Err(error) => return Err(error.into()),
        }
        self.directory = descend(&self.directory, component)
            .map_err(|error| blocked(&self.directory, component, error))?;
        Ok(())
    }
}

fn split(components: &[String]) -> (&str, &[String]) {
    components.split_last().map_or(("", &[]), |(name, parents)| (name, parents))
}

fn descend(directory: &OwnedFd, component: &str) -> Result<OwnedFd, Errno> {
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    openat(directory, component, flags, Mode::empty())
}

/// Why a component could not be entered.
fn blocked(directory: &OwnedFd, component: &str, error: Errno) -> Problem {
    match file_type(directory, component) {
        Ok(FileType::Symlink) => Problem::Refused(format!("leads through the link `{component}`")),
        Ok(FileType::Directory) | Err(_) => error.into(),
        Ok(_) => Problem::Failed(format!("`{component}` is not a directory")),
    }
}

fn check(directory: &OwnedFd, name: &str) -> Result<(), Problem> {
    match file_type(directory, name) {
        Err(Errno::NOENT) => Ok(()),
        Ok(FileType::RegularFile) if may_be_replaced(directory, name) => Ok(()),
        Ok(FileType::RegularFile) => {
            Err(Problem::Refused("is that of a file that is no image".to_owned()))
        }
        Ok(FileType::Symlink) => Err(Problem::Refused("is that of a symbolic link".to_owned())),
        Ok(FileType::Directory) => Err(Problem::Failed(DIRECTORY_IN_PLACE.to_owned())),
        Ok(_) => Err(Problem::Failed("something that is no file is in its place".to_owned())),
        Err(error) => Err(error.into()),
    }
}

/// Whether a file is there to be replaced: it is called an image, is one, or is empty. What else the
/// user keeps below the output directory, a scene's own text for one, is none of the scene's business.
fn may_be_replaced(directory: &OwnedFd, name: &str) -> bool {
    let start = || {
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let file = File::from(openat(directory, name, flags, Mode::empty()).ok()?);
        let mut bytes = Vec::new();
        file.take(2).read_to_end(&mut bytes).ok()?;
        Some(bytes)
    };
    formats::of_name(Path::new(name)).is_some()
        || start().is_some_and(|bytes| bytes.is_empty() || formats::of_start(&bytes).is_some())
}

fn file_type(directory: &OwnedFd, name: &str) -> Result<FileType, Errno> {
    let status = statat(directory, name, AtFlags::SYMLINK_NOFOLLOW)?;
    Ok(FileType::from_raw_mode(status.st_mode))
}
