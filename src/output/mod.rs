//! Writing files: where a name may lead, and that a file appears complete or not at all.
//!
//! Names from scenes are not trusted. They are taken apart by [`name`], and followed below the
//! output directory by [`place`], one component at a time, each opened relative to the handle of
//! the one before and never through a link. Names from the command line are the user's own, as far as
//! nothing in them stands for what a scene gives.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::console;
use crate::failure::Failure;

mod atomic;
mod name;
mod place;
mod written;

pub(crate) use written::{Contents, Written};

/// Why a file is not written.
#[derive(Debug)]
pub(crate) enum Problem {
    /// The name is not allowed; says why, as in "the name *is absolute*".
    Refused(String),
    /// It cannot be done; says why.
    Failed(String),
}

impl Problem {
    /// There is such a file, which is to stay.
    fn exists() -> Self {
        Problem::Failed(
            "it exists already; remove it, or allow replacing with `--clobber`".to_owned(),
        )
    }
}

/// What becomes of a file that has the name of one to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Existing {
    Replace,
    /// As [`Existing::Replace`], and the new file has its permissions.
    Succeed,
    /// It stays, and writing fails.
    Keep,
}

impl From<io::Error> for Problem {
    fn from(error: io::Error) -> Self {
        Problem::Failed(console::reason(&error))
    }
}

impl From<rustix::io::Errno> for Problem {
    fn from(error: rustix::io::Errno) -> Self {
        io::Error::from(error).into()
    }
}

/// Fills a file that is being written.
type Fill<'f> = &'f mut dyn FnMut(&mut dyn Write) -> io::Result<()>;

/// A file to be written, whose name has been found good.
#[derive(Debug)]
pub(crate) enum Target {
    /// Named by a scene, wholly or in part: components below a directory.
    Below { root: PathBuf, components: Vec<String> },
    /// Named by the user.
    Path(PathBuf),
}

impl Target {
    /// The file that a scene calls `name`, below `root`.
    ///
    /// # Errors
    /// When the name is not allowed, or something that is no file is in its place already.
    pub(crate) fn below(root: &Path, name: &str) -> Result<Target, Problem> {
        let components: Vec<_> =
            name::components(name).map_err(Problem::Refused)?.map(str::to_owned).collect();
        place::inspect(root, &components)?;
        Ok(Target::Below { root: root.to_owned(), components })
    }

    /// The file that the user calls `path`.
    pub(crate) fn path(path: PathBuf) -> Target {
        Target::Path(path)
    }

    /// The path, for showing.
    pub(crate) fn shown(&self) -> PathBuf {
        match self {
            Target::Path(path) => path.clone(),
            Target::Below { root, components } if root == Path::new(".") => {
                components.iter().collect()
            }
            Target::Below { root, components } => {
                std::iter::once(root.as_path()).chain(components.iter().map(Path::new)).collect()
            }
        }
    }

    /// Looks whether something that is to stay has the name already. Devices and pipes are written to,
    /// not replaced.
    ///
    /// # Errors
    /// When it has.
    pub(crate) fn check(&self, existing: Existing) -> Result<(), Problem> {
        let path = self.shown();
        let is_there = match fs::metadata(&path) {
            Ok(metadata) => metadata.is_file(),
            // A link that leads nowhere is something too.
            Err(_) => fs::symlink_metadata(&path).is_ok(),
        };
        if existing == Existing::Keep && is_there { Err(Problem::exists()) } else { Ok(()) }
    }

    /// Writes the file, with the directories above it as far as they are missing.
    ///
    /// # Errors
    /// When it cannot be done; what was in its place before is untouched then.
    pub(crate) fn write(&self, existing: Existing, fill: Fill<'_>) -> Result<(), Problem> {
        match self {
            Target::Below { root, components } => {
                let place = place::open(root, components)?;
                let written = place
                    .check()
                    .and_then(|()| atomic::write(&place.directory, &place.name, existing, fill));
                if written.is_err() {
                    place.remove_new_directories();
                }
                written
            }
            Target::Path(path) => write_trusted(path, existing, fill),
        }
    }

    /// As [`Target::write`], for files that no scene has asked for; one that exists is replaced.
    ///
    /// # Errors
    /// When it cannot be done.
    pub(crate) fn write_plain(&self, fill: Fill<'_>) -> Result<(), Failure> {
        self.write(Existing::Replace, fill).map_err(|problem| self.failure(problem))
    }

    /// The failure that says why a file is not written that no scene has asked for.
    pub(crate) fn failure(&self, problem: Problem) -> Failure {
        let (Problem::Refused(reason) | Problem::Failed(reason)) = problem;
        Failure::Output(format!("could not write `{}`: {reason}", self.shown().display()))
    }
}

/// Removes what stands for files that are being written: the process is about to end. Waits only so long
/// for a change that is under way.
pub(crate) fn abandon(patience: Duration) {
    atomic::abandon(patience);
}

/// A name without directory and extension, if it is one that could stand in a path.
///
/// # Errors
/// Says what is wrong with it.
pub(crate) fn stem(name: &str) -> Result<&str, String> {
    let last = name::components(name)?.next_back().unwrap_or_default();
    Ok(last.rsplit_once('.').map_or(last, |(stem, _)| stem))
}

fn write_trusted(path: &Path, existing: Existing, fill: Fill<'_>) -> Result<(), Problem> {
    // The user may well have named a link, which is then followed, or a device.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if let Ok(metadata) = fs::metadata(&path) {
        if metadata.is_dir() {
            return Err(Problem::Failed(place::DIRECTORY_IN_PLACE.to_owned()));
        }
        if !metadata.is_file() {
            let mut device = io::BufWriter::new(OpenOptions::new().write(true).open(&path)?);
            return Ok(fill(&mut device).and_then(|()| device.flush())?);
        }
    }
    let Some(name) = path.file_name() else {
        return Err(Problem::Failed("the name ends in no file name".to_owned()));
    };
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(directory).map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => io::ErrorKind::NotADirectory.into(),
        _ => error,
    })?;
    atomic::write(&File::open(directory)?, name, existing, fill)
}
