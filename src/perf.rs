//! The map by which the profiler `perf` names machine code that no file holds.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Write};
use std::sync::{Mutex, PoisonError};

use compiler::bytecode::Program;
use compiler::source::{SourceMap, Span};
use jit::shaders::Region;
use rustix::fs::{AtFlags, CWD, Mode, OFlags, openat, unlinkat};

use crate::clean::shortened;
use crate::console;
use crate::failure::Failure;
use crate::load::place;

/// A map in the making. It stays where it is, since `perf report` reads it when we are gone.
pub(crate) struct PerfMap {
    path: String,
    /// The names of shaders by the source text of their functions.
    names: HashMap<Span, String>,
    file: Mutex<io::Result<File>>,
}

impl PerfMap {
    /// Starts the map of this process, where `perf` looks for it.
    ///
    /// # Errors
    /// When it cannot be made.
    pub(crate) fn create() -> Result<PerfMap, Failure> {
        let path = format!("/tmp/perf-{}.map", std::process::id());
        // Everybody can write to the directory. What has the name already, perhaps a link, is not
        // opened: it goes, or is in the way.
        let _ = unlinkat(CWD, &path, AtFlags::empty());
        let flags =
            OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        match openat(CWD, &path, flags, Mode::from_raw_mode(0o600)) {
            Ok(file) => {
                Ok(PerfMap { path, names: HashMap::new(), file: Mutex::new(Ok(file.into())) })
            }
            Err(error) => Err(unwritable(&path, &error.into())),
        }
    }

    /// The shaders to come are those of a program; they get the places of their functions as names.
    pub(crate) fn name_shaders(&mut self, program: &Program, sources: &SourceMap) {
        let spans = program.functions.iter().map(|function| function.span);
        self.names = spans.map(|span| (span, name(sources, span))).collect();
    }

    /// Adds a shader. What goes wrong is kept for [`PerfMap::finish`].
    pub(crate) fn add(&self, region: Region) {
        let Region { span, address, n_bytes } = region;
        let name = self.names.get(&span).map_or("gmlvm::shader", String::as_str);
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        // All at once: the process may end at any time.
        let line = format!("{address:x} {n_bytes:x} {name}\n");
        let written = file.as_mut().map_or(Ok(()), |file| file.write_all(line.as_bytes()));
        if let Err(error) = written {
            *file = Err(error);
        }
    }

    /// Ends the map.
    ///
    /// # Errors
    /// When something could not be written.
    pub(crate) fn finish(self) -> Result<(), Failure> {
        let file = self.file.into_inner().unwrap_or_else(PoisonError::into_inner);
        file.map(drop).map_err(|error| unwritable(&self.path, &error))
    }
}

fn name(sources: &SourceMap, span: Span) -> String {
    format!("gmlvm::{}", shortened(&place(sources, span)))
}

fn unwritable(path: &str, error: &io::Error) -> Failure {
    Failure::Output(format!("could not write `{path}`: {}", console::reason(error)))
}
