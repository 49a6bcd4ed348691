//! From the words of a command line to what they mean.

use std::ffi::{OsStr, OsString};

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};

use crate::args::{Args, Command, contradictions, response};
use crate::clean::clean;

/// Names of the commands, for telling them from scenes.
const COMMANDS: [&str; 15] = [
    "run",
    "check",
    "lsp",
    "disasm",
    "eval",
    "diff",
    "bench",
    "chart",
    "stability",
    "merge",
    "view",
    "explain",
    "completions",
    "man",
    "help",
];

/// What makes a `view` render in place of serving a page; no option for users.
const WORKER: &str = "--worker";

/// What says, as the first word, that response files are in place already; no option for users.
const EXPANDED: &str = "--expanded";

/// Reads the command line; on an error says so and ends the process, with exit code 2.
pub(crate) fn parse() -> Args {
    let mut args: Vec<_> = std::env::args_os().collect();
    if args.get(1).is_some_and(|word| word == EXPANDED) {
        args.remove(1);
    } else {
        args = response::expanded(args)
            .unwrap_or_else(|message| Args::command().error(ErrorKind::Io, clean(&message)).exit());
    }
    let mut args = untrusting(with_command(args));
    let is_worker = take_worker(&mut args);
    let mut parsed = Args::try_parse_from(&args).unwrap_or_else(|error| {
        // The message quotes what is wrong. A file's name, say, that a shell has put there may hold
        // commands for the terminal, so it is that about the cleaned line, which is as wrong.
        let cleaned = args.iter().map(|argument| clean(&argument.to_string_lossy()).into_owned());
        Args::try_parse_from(cleaned).err().unwrap_or(error).exit()
    });
    contradictions::refuse(&parsed.command);
    if let Command::View(view) = &mut parsed.command {
        view.worker = is_worker;
    }
    parsed.line = again(args);
    parsed
}

/// The arguments by which a process starts the same again, but without `--watch`.
fn again(args: Vec<OsString>) -> Vec<OsString> {
    let rest = args.into_iter().skip(1).filter(|argument| argument != "--watch");
    std::iter::once(EXPANDED.into()).chain(rest).collect()
}

/// Has `view` not trust its scene, which a page may have changed.
fn untrusting(mut args: Vec<OsString>) -> Vec<OsString> {
    let at = command_at(&args);
    let mut options = args.iter().take_while(|argument| *argument != "--");
    if args.get(at).is_some_and(|word| word == "view")
        && !options.any(|option| option == "--untrusted")
    {
        args.insert(at + 1, "--untrusted".into());
    }
    args
}

/// Whether `view` is to be a worker, which its first word says.
fn take_worker(args: &mut Vec<OsString>) -> bool {
    let at = command_at(args);
    let is_worker = args.get(at).is_some_and(|word| word == "view")
        && args.get(at + 1).is_some_and(|word| word == WORKER);
    if is_worker {
        args.remove(at + 1);
    }
    is_worker
}

/// Makes the arguments by which a `view` starts again those of its worker.
pub(crate) fn of_worker(mut args: Vec<OsString>) -> Vec<OsString> {
    args.insert(command_at(&args) + 1, WORKER.into());
    args
}

/// Puts `run` in front of a scene that stands where the command would.
fn with_command(mut args: Vec<OsString>) -> Vec<OsString> {
    let at = command_at(&args);
    if args.get(at).is_some_and(|argument| !names_command(argument)) {
        args.insert(at, "run".into());
    }
    args
}

/// Where the command stands, behind the options of all commands, or whatever is in its place.
fn command_at(args: &[OsString]) -> usize {
    let mut at = 1;
    while let Some(argument) = args.get(at) {
        at += match argument.to_str() {
            Some("-q" | "--quiet" | "-v" | "--verbose") => 1,
            Some("--color" | "--message-format") => 2,
            Some(other) if other.starts_with("--color=") => 1,
            Some(other) if other.starts_with("--message-format=") => 1,
            _ => break,
        };
    }
    at
}

/// Whether an argument is for us, and not a scene or an option of `run`.
fn names_command(argument: &OsStr) -> bool {
    let Some(text) = argument.to_str() else { return false };
    if matches!(text, "-h" | "--help" | "-V" | "--version") || COMMANDS.contains(&text) {
        return true;
    }
    // A plain word that is no file is more likely a mistyped command, and clap knows which.
    let is_word = !text.is_empty() && text.bytes().all(|b| b.is_ascii_lowercase());
    is_word && !std::path::Path::new(text).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Args::command().debug_assert();
        let names: Vec<_> =
            Args::command().get_subcommands().map(|c| c.get_name().to_owned()).collect();
        assert_eq!(names, COMMANDS[..14]);
    }

    /// In texts of help clap takes `{n}` for the end of a line.
    #[test]
    fn help_has_no_placeholder_that_ends_a_line() {
        for command in Args::command().get_subcommands() {
            for argument in command.get_arguments() {
                for text in [argument.get_help(), argument.get_long_help()].into_iter().flatten() {
                    let text = text.to_string();
                    assert!(
                        !text.contains("{n}"),
                        "{} {}: {text}",
                        command.get_name(),
                        argument.get_id()
                    );
                }
            }
        }
    }

    #[test]
    fn a_scene_in_place_of_a_command_is_run() {
        let expand = |line: &str| {
            let args = format!("gmlvm {line}").split(' ').map(OsString::from).collect();
            let args: Vec<_> =
                with_command(args).into_iter().map(|a| a.into_string().expect("text")).collect();
            args[1..].join(" ")
        };
        assert_eq!(expand("a.gml"), "run a.gml");
        assert_eq!(expand("-"), "run -");
        assert_eq!(expand("-o out a.gml"), "run -o out a.gml");
        assert_eq!(expand("-q --color never a.gml"), "-q --color never run a.gml");
        assert_eq!(expand("-q eval a.gml"), "-q eval a.gml");
        assert_eq!(expand("run a.gml"), "run a.gml");
        assert_eq!(expand("--help"), "--help");
        assert_eq!(expand("dissasm a.gml"), "dissasm a.gml");
    }
}
