//! Options that contradict one another, or lack one another, in ways that their definitions cannot tell.

use clap::CommandFactory;
use clap::error::ErrorKind;

use crate::args::{Args, Command, Precision};

/// Ends the process, with exit code 2, if there are such.
pub(super) fn refuse(command: &Command) {
    let (sampling, certifies) = match command {
        Command::Run(args) => (args.sampling, args.precision() == Precision::Certified),
        Command::View(args) => (args.sampling, args.precision == Precision::Certified),
        Command::Bench(args) => (args.sampling, args.precision.contains(&Precision::Certified)),
        _ => return,
    };
    if certifies && let Some(option) = sampling.option() {
        let message = format!(
            "'{option}' cannot be used with '--certify', which is about one sample at the \
             centre of each pixel"
        );
        exit(ErrorKind::ArgumentConflict, &message);
    }
    if let Command::Run(args) = command
        && args.mark_uncertain.is_some()
        && !certifies
    {
        let message = "'--mark-uncertain' asks for '--certify' or '--precision certified'";
        exit(ErrorKind::MissingRequiredArgument, message);
    }
}

fn exit(kind: ErrorKind, message: &str) -> ! {
    Args::command().error(kind, message).exit()
}
