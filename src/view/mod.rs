//! `gmlvm view`: a scene as a live page in a browser.
//!
//! The command serves the page and watches the files. Each run is a process of its own (`worker`), which
//! a new run ends wherever it is. What the worker tells goes to all pages that are open.

use std::ffi::OsString;
use std::sync::Arc;
use std::thread;

use crate::args::ViewArgs;
use crate::console;
use crate::failure::Failure;
use crate::load::is_stdio;
use crate::report::Reporter;
use crate::view::server::Server;
use crate::view::session::{Session, cannot};
use crate::watch::Watched;

mod extras;
mod http;
mod kept;
mod live;
mod maps;
mod page;
mod protocol;
mod server;
mod session;
mod worker;

/// Serves the page of a scene until a signal ends the process; `line` are the arguments.
///
/// # Errors
/// When the scene cannot be read, or the port not be had.
pub(crate) fn view(args: &ViewArgs, line: &[OsString], reporter: &Reporter) -> Result<u8, Failure> {
    if args.worker {
        return worker::work(args, reporter);
    }
    if is_stdio(&args.scene) {
        return Err(Failure::Usage("the standard input cannot be viewed; give a file".to_owned()));
    }
    let session = Session::new(args, line).map_err(|error| cannot("start", &error))?;
    let session = Arc::new(session);
    let mut watched = Watched::now(&args.scene, &args.inputs);
    session.take_from_disk(&[]).map_err(|error| {
        let name = args.scene.display().to_string();
        cannot(&format!("read `{}`", crate::clean::clean(&name)), &error)
    })?;
    let server = Server::new(args.port, session.clone())
        .map_err(|error| cannot("serve the page", &error))?;
    let address = server.address();
    console::data(|out| writeln!(out, "{address}"))?;
    reporter.note("Open this address in a browser on this machine; Ctrl-C ends it.");
    thread::Builder::new()
        .name("server".to_owned())
        .spawn(move || server.serve())
        .map_err(|error| cannot("serve the page", &error))?;
    loop {
        let changed = watched.await_change(&|| ());
        watched = Watched::now(&args.scene, &args.inputs);
        // That the file is gone passes, and the page says so meanwhile.
        let _ = session.take_from_disk(&changed);
    }
}
