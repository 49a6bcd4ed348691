//! What the kernel keeps a run with an untrusted scene from (Landlock, Linux 5.13 and later).
//!
//! gmlvm writes images below the output directory and nowhere else, and connects to nothing, by its own
//! rules. This is the second line, for the case that a scene gets it to break them.

use std::fs;
use std::path::{Path, PathBuf};

use landlock::{
    ABI, Access, AccessFs, AccessNet, BitFlags, PathBeneath, PathFd, Ruleset, RulesetAttr,
    RulesetCreatedAttr, RulesetError, RulesetStatus, Scope, make_bitflags,
};

/// How much of it the kernel does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Confinement {
    Full,
    /// The kernel is too old for some of it.
    Part,
    None,
}

impl Confinement {
    /// A line that says it.
    pub(crate) fn line(self) -> &'static str {
        match self {
            Confinement::Full => "confined: the kernel refuses other writes, and connections",
            Confinement::Part => "confined in part: this kernel's Landlock cannot refuse all of it",
            Confinement::None => "not confined: there is no Landlock in this kernel",
        }
    }
}

/// From now on lets this thread, and those that it starts, write only in these directories and to
/// these devices, and connect to nothing. Directories are made, since nobody could do it later.
pub(crate) fn confine(writable: &[PathBuf]) -> Confinement {
    match restrict(writable) {
        Ok(RulesetStatus::FullyEnforced) => Confinement::Full,
        Ok(RulesetStatus::PartiallyEnforced) => Confinement::Part,
        Ok(RulesetStatus::NotEnforced) | Err(_) => Confinement::None,
    }
}

fn restrict(writable: &[PathBuf]) -> Result<RulesetStatus, RulesetError> {
    /// With the rights that later kernels know (6.12); earlier ones take those that they do.
    const KNOWN: ABI = ABI::V6;
    let mut rules = Ruleset::default()
        .handle_access(AccessFs::from_write(KNOWN))?
        .handle_access(AccessNet::from_all(KNOWN))?
        .scope(Scope::from_all(KNOWN))?
        .create()?;
    for path in writable {
        // What cannot be made or opened cannot be written either, of which the user hears then.
        let _ = fs::create_dir_all(path);
        if let Ok(handle) = PathFd::new(path) {
            rules = rules.add_rule(PathBeneath::new(handle, rights(path)))?;
        }
    }
    Ok(rules.restrict_self()?.ruleset)
}

/// What writing files takes.
fn rights(path: &Path) -> BitFlags<AccessFs> {
    let in_file = make_bitflags!(AccessFs::{WriteFile | Truncate});
    let in_directory = make_bitflags!(AccessFs::{MakeReg | MakeDir | RemoveFile | RemoveDir});
    if path.is_dir() { in_file | in_directory } else { in_file }
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind;
    use std::net::TcpListener;
    use std::thread;

    use super::*;

    /// The rules are those of a thread, and so is this test.
    #[test]
    fn nothing_else_can_be_written() {
        let sandbox = tempfile::tempdir().expect("a directory");
        let path = |name: &str| sandbox.path().join(name);
        fs::write(path("mine"), "precious").expect("written");
        let confined = thread::scope(|scope| {
            let work = || {
                let confinement = confine(&[path("out/below"), "/dev/null".into()]);
                if confinement == Confinement::None {
                    return confinement;
                }
                fs::create_dir(path("out/below/d")).expect("a directory");
                fs::write(path("out/below/d/a"), "1").expect("written");
                fs::rename(path("out/below/d/a"), path("out/below/d/b")).expect("renamed");
                fs::write("/dev/null", "1").expect("written");
                assert_eq!(fs::read(path("mine")).expect("read"), b"precious");
                for refused in [
                    fs::write(path("mine"), "worthless"),
                    fs::write(path("new"), ""),
                    fs::write(path("out/new"), ""),
                    fs::create_dir(path("d")),
                    fs::remove_file(path("mine")),
                    fs::write("/dev/full", ""),
                ] {
                    assert_eq!(refused.map_err(|e| e.kind()), Err(ErrorKind::PermissionDenied));
                }
                if confinement == Confinement::Full {
                    let refused = TcpListener::bind("127.0.0.1:0").expect_err("no network");
                    assert_eq!(refused.kind(), ErrorKind::PermissionDenied);
                }
                confinement
            };
            scope.spawn(work).join().expect("no panic")
        });
        if confined == Confinement::None {
            eprintln!("skipped: no Landlock here");
        }
        assert_eq!(fs::read(path("mine")).expect("read"), b"precious");
    }
}
