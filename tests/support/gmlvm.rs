//! Runs the binary in a directory of its own.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// How a run ended.
#[derive(Debug)]
pub(crate) struct Ended {
    /// Exit code; -1 for death by a signal.
    pub(crate) code: i32,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: String,
}

impl Ended {
    /// The standard output as text.
    pub(crate) fn text(&self) -> &str {
        std::str::from_utf8(&self.stdout).expect("text")
    }
}

/// An empty directory, in which the binary runs.
pub(crate) struct Sandbox(TempDir);

impl Sandbox {
    pub(crate) fn new() -> Self {
        Sandbox(TempDir::new().expect("a temporary directory"))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file, and the directories above it.
    pub(crate) fn file(&self, name: &str, contents: impl AsRef<[u8]>) -> &Self {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("below the sandbox")).expect("a directory");
        fs::write(path, contents).expect("a file");
        self
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// All files below the directory, sorted, `/` at the end of directories.
    pub(crate) fn files(&self) -> Vec<String> {
        let mut found = Vec::new();
        list(self.0.path(), "", &mut found);
        found.sort();
        found
    }

    pub(crate) fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gmlvm"));
        command.args(args).current_dir(self.0.path()).stdin(Stdio::null());
        for name in ["NO_COLOR", "CLICOLOR_FORCE", "RAYON_NUM_THREADS"] {
            command.env_remove(name);
        }
        command
    }

    pub(crate) fn run(&self, args: &[&str]) -> Ended {
        self.run_with(args, b"")
    }

    /// Runs what a shell makes of `args`, with a small stack, one gigabyte of memory and half a minute.
    /// Returns the exit code, if the process was not killed, and the standard error.
    pub(crate) fn confined(&self, args: &str) -> (Option<i32>, String) {
        let binary = env!("CARGO_BIN_EXE_gmlvm");
        let script = format!(
            "ulimit -c 0; ulimit -s 1024; ulimit -v 1048576; exec timeout 30 {binary} {args}"
        );
        let mut shell = Command::new("sh");
        shell.args(["-c", &script]).current_dir(self.0.path()).stdin(Stdio::null());
        let output = shell.output().expect("sh runs");
        let stderr = String::from_utf8(output.stderr).expect("messages are text");
        (output.status.code(), stderr)
    }

    /// Runs a script of the shell as the root of a namespace of its own, where it may mount; it ends with
    /// 99 where it cannot. None, and a message, if that is not to be had here.
    pub(crate) fn mounting(&self, script: &str) -> Option<Output> {
        let mut unshare = Command::new("unshare");
        unshare.args(["-Urm", "sh", "-c", script]).current_dir(self.0.path());
        let Ok(output) = unshare.output() else {
            eprintln!("skipped: no unshare here");
            return None;
        };
        let stderr = String::from_utf8_lossy(&output.stderr);
        if output.status.code() == Some(99) || stderr.starts_with("unshare:") {
            eprintln!("skipped: no mounting here: {stderr}");
            return None;
        }
        Some(output)
    }

    /// Runs with this text on the standard input.
    pub(crate) fn run_with(&self, args: &[&str], input: &[u8]) -> Ended {
        let mut command = self.command(args);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the binary runs");
        let mut stdin = child.stdin.take().expect("piped");
        // It may end without reading; that is its business.
        let _ = stdin.write_all(input);
        drop(stdin);
        let output = child.wait_with_output().expect("it ends");
        Ended {
            code: output.status.code().unwrap_or(-1),
            stdout: output.stdout,
            stderr: String::from_utf8(output.stderr).expect("messages are text"),
        }
    }
}

/// A scene with one image of this name; a white ball that fills half the picture.
pub(crate) fn ball(name: &str) -> String {
    format!(
        "0.5 0.5 0.5 point [] {{ /v /u /face 1.0 1.0 1.0 point 1.0 0.0 1.0 }} sphere 0.0 0.0 2.0 \
         translate 0 90.0 8 6 \"{name}\" render\n"
    )
}

/// How the file of a [`ball`] starts.
pub(crate) const PPM_HEADER: &[u8] = b"P6\n# gmlvm\n8 6\n255\n";

fn list(directory: &Path, prefix: &str, found: &mut Vec<String>) {
    for entry in fs::read_dir(directory).expect("a directory") {
        let entry = entry.expect("an entry");
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.file_type().expect("a type").is_dir() {
            list(&entry.path(), &format!("{name}/"), found);
            found.push(name + "/");
        } else {
            found.push(name);
        }
    }
}
