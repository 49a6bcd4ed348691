//! Files that appear complete or not at all: written without a name, or under another, then renamed.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::{Duration, Instant};

#[cfg(target_os = "linux")]
use rustix::fs::RenameFlags;
use rustix::fs::{AtFlags, Mode, OFlags, fchmod, linkat, openat, renameat, statat, unlinkat};
use rustix::io::Errno;

use crate::output::{Existing, Fill, Problem};

/// Writes a file in `directory`, in place of one that may be there, or only if there is none.
///
/// # Errors
/// When it cannot be done; nothing is left behind then.
pub(super) fn write(
    directory: &impl AsFd,
    name: impl AsRef<OsStr>,
    existing: Existing,
    fill: Fill<'_>,
) -> Result<(), Problem> {
    let (temporary, file) = match nameless(directory) {
        Some(file) => (None, file),
        None => {
            let (temporary, file) = TemporaryName::take(directory, |name| {
                let flags = OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL | OFlags::CLOEXEC;
                openat(directory, name, flags, FILE_MODE)
            })?;
            (Some(temporary), File::from(file))
        }
    };
    if existing == Existing::Succeed {
        // Before there is anything to be read in it.
        match statat(directory, name.as_ref(), AtFlags::SYMLINK_NOFOLLOW) {
            Ok(old) => fchmod(&file, Mode::from_raw_mode(old.st_mode))?,
            Err(Errno::NOENT) => {}
            Err(error) => return Err(error.into()),
        }
    }
    let mut writer = BufWriter::with_capacity(1 << 16, file);
    fill(&mut writer).and_then(|()| writer.flush())?;
    let file = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
    // After a power failure the name must not stand for a file without its contents.
    file.sync_data()?;
    let temporary = match temporary {
        Some(temporary) => temporary,
        None => TemporaryName::take(directory, |name| give_name(&file, directory, name))?.0,
    };
    match (existing, temporary.rename(name.as_ref(), existing)) {
        (Existing::Keep, Err(Errno::EXIST)) => Err(Problem::exists()),
        (_, renamed) => Ok(renamed?),
    }
}

/// Removes all temporary names, and makes whoever wants to do something with one wait for ever: the
/// process is about to end. A change that is under way is waited for, but for so long only, since a
/// file system may hang.
pub(super) fn abandon(patience: Duration) {
    let begun = Instant::now();
    let names = loop {
        match TEMPORARY_NAMES.try_lock() {
            Ok(names) => break names,
            Err(TryLockError::Poisoned(poisoned)) => break poisoned.into_inner(),
            Err(TryLockError::WouldBlock) if begun.elapsed() > patience => return,
            Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(1)),
        }
    };
    for (directory, name) in names.iter() {
        let _ = unlinkat(directory, name, AtFlags::empty());
    }
    std::mem::forget(names);
}

/// The temporary names that there are, each with its directory.
static TEMPORARY_NAMES: Mutex<Vec<(OwnedFd, String)>> = Mutex::new(Vec::new());

fn temporary_names() -> MutexGuard<'static, Vec<(OwnedFd, String)>> {
    TEMPORARY_NAMES.lock().unwrap_or_else(PoisonError::into_inner)
}

const FILE_MODE: Mode = Mode::from_raw_mode(0o666);

/// A file in `directory` without a name, which is gone if the process dies; where there are such.
#[cfg(target_os = "linux")]
fn nameless(directory: &impl AsFd) -> Option<File> {
    let flags = OFlags::WRONLY | OFlags::TMPFILE | OFlags::CLOEXEC;
    let file = File::from(openat(directory, ".", flags, FILE_MODE).ok()?);
    std::path::Path::new(&descriptor_path(&file)).exists().then_some(file)
}

#[cfg(target_os = "linux")]
fn give_name(file: &File, directory: &impl AsFd, name: &str) -> Result<(), Errno> {
    linkat(rustix::fs::CWD, descriptor_path(file), directory, name, AtFlags::SYMLINK_FOLLOW)
}

#[cfg(target_os = "linux")]
fn descriptor_path(file: &File) -> String {
    use std::os::fd::AsRawFd;
    format!("/proc/self/fd/{}", file.as_raw_fd())
}

#[cfg(not(target_os = "linux"))]
fn nameless(_: &impl AsFd) -> Option<File> {
    None
}

#[cfg(not(target_os = "linux"))]
fn give_name(_: &File, _: &impl AsFd, _: &str) -> Result<(), Errno> {
    Err(Errno::NOSYS)
}

/// Renames a file unless there is one of the new name, at once. File systems that cannot rename so get a
/// link of the new name, and the old one goes with whoever has it.
fn rename_to_free(directory: &impl AsFd, from: &str, to: &OsStr) -> Result<(), Errno> {
    #[cfg(target_os = "linux")]
    match rustix::fs::renameat_with(directory, from, directory, to, RenameFlags::NOREPLACE) {
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => {}
        renamed => return renamed,
    }
    linkat(directory, from, directory, to, AtFlags::empty())
}

/// A name that stands for a file until the file gets its own; what still has it then, goes. While it
/// stands it is one of [`TEMPORARY_NAMES`], which are locked for every change.
struct TemporaryName<'d, D: AsFd> {
    directory: &'d D,
    name: String,
}

impl<'d, D: AsFd> TemporaryName<'d, D> {
    /// Finds a name that is free; `claim` fails if it is not.
    fn take<T>(
        directory: &'d D,
        claim: impl Fn(&str) -> Result<T, Errno>,
    ) -> Result<(Self, T), Errno> {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        loop {
            let number = COUNTER.fetch_add(1, Ordering::Relaxed);
            let name = format!(".gmlvm-{}-{number}.tmp", std::process::id());
            let handle = directory.as_fd().try_clone_to_owned().map_err(|error| {
                error.raw_os_error().map_or(Errno::IO, Errno::from_raw_os_error)
            })?;
            let mut names = temporary_names();
            match claim(&name) {
                Ok(claimed) => {
                    names.push((handle, name.clone()));
                    return Ok((TemporaryName { directory, name }, claimed));
                }
                // Left by a process that was killed and whose number came round again.
                Err(Errno::EXIST) => {}
                Err(error) => return Err(error),
            }
        }
    }
}

impl<D: AsFd> TemporaryName<'_, D> {
    /// Gives the file its own name.
    fn rename(self, name: &OsStr, existing: Existing) -> Result<(), Errno> {
        let _locked = temporary_names();
        match existing {
            Existing::Replace | Existing::Succeed => {
                renameat(self.directory, &self.name, self.directory, name)
            }
            Existing::Keep => rename_to_free(self.directory, &self.name, name),
        }
    }
}

impl<D: AsFd> Drop for TemporaryName<'_, D> {
    fn drop(&mut self) {
        let mut names = temporary_names();
        let _ = unlinkat(self.directory, &self.name, AtFlags::empty());
        names.retain(|(_, name)| *name != self.name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What only some may read is never to be read by others, not even while it is written.
    #[cfg(target_os = "linux")]
    #[test]
    fn permissions_come_before_contents() {
        use std::os::unix::fs::PermissionsExt;
        let sandbox = tempfile::tempdir().expect("a directory");
        let root = sandbox.path().canonicalize().expect("a directory");
        let directory = File::open(&root).expect("open");
        let mode = |path: &std::path::Path| {
            std::fs::metadata(path).expect("a file").permissions().mode() & 0o777
        };
        let secret = root.join("a");
        std::fs::write(&secret, "old").expect("written");
        std::fs::set_permissions(&secret, PermissionsExt::from_mode(0o600)).expect("set");
        let mut modes = Vec::new();
        let mut fill = |out: &mut dyn Write| {
            let open =
                std::fs::read_dir("/proc/self/fd")?.map(|entry| entry.expect("there").path());
            let is_ours = |link: &std::path::PathBuf| {
                std::fs::read_link(link).is_ok_and(|to| to.starts_with(&root) && to != root)
            };
            modes.extend(open.filter(is_ours).map(|link| mode(&link)));
            out.write_all(b"new")
        };
        write(&directory, "a", Existing::Succeed, &mut fill).expect("written");
        assert_eq!(modes, [0o600]);
        assert_eq!(mode(&secret), 0o600);
        assert_eq!(std::fs::read(&secret).expect("there"), b"new");
        write(&directory, "b", Existing::Succeed, &mut |_| Ok(())).expect("written");
    }

    /// A file that appears while another is made for its place, after all looking, stays.
    #[test]
    fn what_appears_meanwhile_is_kept() {
        let sandbox = tempfile::tempdir().expect("a directory");
        let directory = File::open(sandbox.path()).expect("open");
        let path = sandbox.path().join("a");
        let mut fill = |out: &mut dyn Write| {
            std::fs::write(&path, "theirs")?;
            out.write_all(b"ours")
        };
        let kept = write(&directory, "a", Existing::Keep, &mut fill);
        assert!(matches!(&kept, Err(Problem::Failed(why)) if why.contains("exists")), "{kept:?}");
        assert_eq!(std::fs::read(&path).expect("there"), b"theirs");
        write(&directory, "a", Existing::Replace, &mut fill).expect("written");
        assert_eq!(std::fs::read(&path).expect("there"), b"ours");
        write(&directory, "b", Existing::Keep, &mut fill).expect("written");
        assert_eq!(std::fs::read(sandbox.path().join("b")).expect("there"), b"ours");
        assert_eq!(std::fs::read_dir(sandbox.path()).expect("a directory").count(), 2);
    }
}
