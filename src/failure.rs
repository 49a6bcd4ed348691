//! Why a command ended early, and the exit code that tells the caller.

use std::io;

use compiler::diagnostic::Class;

use crate::console;

const EXIT_BUG: u8 = 70;

/// The reader of the standard output went away; shells show the same for a death by SIGPIPE.
const EXIT_CLOSED_PIPE: u8 = 141;

/// Why a command ended early.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Diagnostics of this class, which the user has seen.
    Shown(Class),
    /// The command line asks for something impossible, or an input cannot be read.
    Usage(String),
    /// Two engines gave different results.
    Unequal(String),
    /// gmlvm itself is wrong: a panic was caught.
    Bug(String),
    /// A limit is reached, and not by a program.
    Limit(String),
    /// Something other than an image could not be written.
    Output(String),
    /// Whoever read the standard output wants no more: nothing to report.
    ClosedPipe,
}

impl Failure {
    /// The exit code.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Failure::Shown(class) => class_exit_code(*class),
            Failure::Unequal(_) => class_exit_code(Class::Program),
            Failure::Usage(_) => class_exit_code(Class::Usage),
            Failure::Limit(_) => class_exit_code(Class::Limit),
            Failure::Output(_) => class_exit_code(Class::Output),
            Failure::Bug(_) => EXIT_BUG,
            Failure::ClosedPipe => EXIT_CLOSED_PIPE,
        }
    }

    /// What the user has not been told yet.
    pub(crate) fn message(&self) -> Option<&str> {
        match self {
            Failure::Usage(message)
            | Failure::Unequal(message)
            | Failure::Bug(message)
            | Failure::Limit(message)
            | Failure::Output(message) => Some(message),
            Failure::Shown(_) | Failure::ClosedPipe => None,
        }
    }

    /// The failure to write to the standard output.
    pub(crate) fn stdout(error: &io::Error) -> Failure {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Failure::ClosedPipe,
            _ => Failure::Output(format!(
                "could not write to the standard output: {}",
                console::reason(error)
            )),
        }
    }
}

fn class_exit_code(class: Class) -> u8 {
    match class {
        Class::Program => 1,
        Class::Usage => 2,
        Class::Output => 3,
        Class::Limit => 4,
        Class::Policy => 5,
    }
}
