//! Animations: one scene run for a range of frames.

use std::sync::Arc;

use compiler::bytecode::Constant;

use crate::args::RunArgs;
use crate::failure::Failure;
use crate::load::is_stdio;
use crate::parts::shard::Shard;
use crate::values::Definition;

/// The frames from the first to the last, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Frames {
    first: u32,
    last: u32,
}

/// Reads `A..B`.
pub(crate) fn read(text: &str) -> Result<Frames, String> {
    let numbers = text.split_once("..").and_then(|(a, b)| a.parse().ok().zip(b.parse().ok()));
    match numbers {
        Some((first, last)) if first <= last => Ok(Frames { first, last }),
        _ => Err("write A..B with whole numbers A up to B, as in 1..50".to_owned()),
    }
}

impl Frames {
    /// The frames of a shard; all of them without.
    pub(crate) fn of(self, shard: Option<Shard>) -> impl Iterator<Item = u32> {
        let numbered = (self.first..=self.last).enumerate();
        let mine = numbered.filter(move |(idx, _)| shard.is_none_or(|shard| shard.has(0, *idx)));
        mine.map(|(_, frame)| frame)
    }

    /// What a program is told of a frame. The clock is by the whole range, so that it does not matter who
    /// renders which frame.
    pub(crate) fn definitions(self, frame: u32) -> [Definition; 2] {
        let n_steps = f64::from(self.last - self.first).max(1.0);
        let clock = f64::from(frame - self.first) / n_steps;
        let define = |name: &str, value, text: String| {
            let text = format!("{name}={text}");
            Definition { name: Arc::from(name), value, text }
        };
        [
            define("frame", Constant::Int(frame.into()), frame.to_string()),
            define("clock", Constant::Real(clock), format!("{clock:?}")),
        ]
    }
}

/// Whether the options of a run go together with frames, if it has any.
///
/// # Errors
/// When frames would overwrite one another, or the scene cannot be read again.
pub(crate) fn check(args: &RunArgs) -> Result<(), Failure> {
    if args.frames.is_none() {
        return match &args.parts.shard {
            Some(_) if args.parts.parts.is_none() => Err(Failure::Usage(
                "`--shard` goes with `--parts DIR` or `--frames A..B`".to_owned(),
            )),
            _ => Ok(()),
        };
    }
    if is_stdio(&args.scene) {
        let message = "the standard input can be read once only; `--frames` needs a file";
        return Err(Failure::Usage(message.to_owned()));
    }
    let outputs = [("--output", &args.output), ("--mark-uncertain", &args.mark_uncertain)];
    for (option, name) in outputs {
        let Some(text) = name.as_ref().map(|name| name.to_string_lossy()) else { continue };
        if text.contains("{frame}") {
            continue;
        }
        let why = match args.parts.shard {
            None if text.contains("{n}") => continue,
            None => "all frames would go to one file",
            // {n} counts the images of one process.
            Some(_) => "frames of several shards would go to one file",
        };
        return Err(Failure::Usage(format!("{why}; use {{frame}} in `{option}`")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_both_ends() {
        let frames = read("3..7").expect("a range");
        assert_eq!(frames.of(None).collect::<Vec<_>>(), [3, 4, 5, 6, 7]);
        let clocks = |frames: Frames| {
            let clock = |frame| frames.definitions(frame)[1].text.clone();
            frames.of(None).map(clock).collect::<Vec<_>>()
        };
        assert_eq!(
            clocks(frames),
            ["clock=0.0", "clock=0.25", "clock=0.5", "clock=0.75", "clock=1.0"]
        );
        assert_eq!(clocks(read("5..5").expect("a range")), ["clock=0.0"]);
        for bad in ["", "3", "..", "3..", "..3", "7..3", "-1..3", "a..b", "1...3", "0..4294967296"]
        {
            assert!(read(bad).is_err(), "{bad}");
        }
        let all: usize =
            (0..3).map(|index| frames.of(Some(Shard { index, count: 3 })).count()).sum();
        assert_eq!(all, 5);
    }
}
