//! The `gmlvm` binary; what it does is in the library.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    gmlvm::run_command_line()
}
