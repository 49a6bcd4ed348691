//! The options that say what a program may use up: each with a default, and a stricter one with
//! `--untrusted`.

use std::time::Duration;

use clap::Parser;

use crate::values;

/// What a program may use up.
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(next_help_heading = "Limits")]
pub(crate) struct LimitArgs {
    /// Instructions of the program, and of each call of a surface function
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10_000_000_000,
        default_value_if("untrusted", "true", "1000000000")
    )]
    pub(crate) fuel: u64,
    /// Calls active at once; calls in tail position do not count
    #[arg(
        long,
        value_name = "N",
        default_value_t = 100_000,
        default_value_if("untrusted", "true", "10000")
    )]
    pub(crate) max_depth: usize,
    /// Memory for the program's values, and for those of each thread's surface calls; k, M and G are powers of 1024
    #[arg(long, value_name = "SIZE", default_value = "4G", default_value_if("untrusted", "true", "512M"), value_parser = values::bytes)]
    pub(crate) max_memory: u64,
    /// Pixels of one image
    #[arg(long, value_name = "N", default_value_t = 1 << 28, default_value_if("untrusted", "true", "16777216"))]
    pub(crate) max_pixels: u64,
    /// Pixels of all images of one run together [default: none]
    #[arg(long, value_name = "N", default_value_if("untrusted", "true", "67108864"))]
    pub(crate) max_total_pixels: Option<u64>,
    /// Images of one run
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10_000,
        default_value_if("untrusted", "true", "16")
    )]
    pub(crate) max_images: u64,
    /// Reflection depth of one image
    #[arg(
        long,
        value_name = "N",
        default_value_t = 100_000,
        default_value_if("untrusted", "true", "1000")
    )]
    pub(crate) max_reflections: u32,
}

impl LimitArgs {
    /// What `--untrusted` limits a program to.
    pub(crate) fn strict() -> Self {
        #[derive(Parser)]
        struct Untrusted {
            #[arg(long)]
            untrusted: bool,
            #[command(flatten)]
            limits: LimitArgs,
        }
        let Untrusted { untrusted, limits } = Untrusted::parse_from(["gmlvm", "--untrusted"]);
        debug_assert!(untrusted);
        limits
    }
}

/// How long a command may take.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
#[command(next_help_heading = "Limits")]
pub(crate) struct TimeArgs {
    /// Time from start to end, with everything: in seconds, or as 2.5s or 500ms [default: none]
    #[arg(long, value_name = "SECONDS", default_value_if("untrusted", "true", "60s"), value_parser = values::duration)]
    pub(crate) timeout: Option<Duration>,
}

#[cfg(test)]
mod tests {
    use compiler::diagnostic::grouped;

    use super::*;
    use crate::args::{Args, Command, Inputs, RunArgs};

    fn run(options: &[&str]) -> RunArgs {
        let line = ["gmlvm", "run", "s.gml"].iter().chain(options);
        match Args::try_parse_from(line).expect("well formed").command {
            Command::Run(args) => args,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn untrusted_scenes_get_less_unless_told_otherwise() {
        let (trusted, untrusted) = (run(&[]), run(&["--untrusted"]));
        let LimitArgs { fuel, max_depth, max_memory, .. } = untrusted.limits;
        let LimitArgs { max_pixels, max_total_pixels, max_images, max_reflections, .. } =
            untrusted.limits;
        assert_eq!((fuel, max_depth, max_memory), (1_000_000_000, 10_000, 512 << 20));
        assert_eq!((max_pixels, max_images, max_reflections), (1 << 24, 16, 1000));
        assert_eq!((max_total_pixels, trusted.limits.max_total_pixels), (Some(1 << 26), None));
        assert_eq!(untrusted.inputs.max_words, Inputs::STRICT_WORDS);
        assert_eq!(untrusted.time.timeout, Some(Duration::from_secs(60)));
        assert_eq!(trusted.time.timeout, None);
        assert!(fuel < trusted.limits.fuel && max_depth < trusted.limits.max_depth);
        assert!(max_memory < trusted.limits.max_memory && max_pixels < trusted.limits.max_pixels);
        assert!(max_images < trusted.limits.max_images);
        assert!(max_reflections < trusted.limits.max_reflections);
        let mixed = run(&["--fuel", "7", "--untrusted", "--timeout", "90", "--max-images", "20"]);
        assert_eq!((mixed.limits.fuel, mixed.limits.max_images), (7, 20));
        assert_eq!(mixed.limits.max_depth, 10_000);
        assert_eq!(mixed.time.timeout, Some(Duration::from_secs(90)));
    }

    /// The documentation has the same numbers.
    #[test]
    fn the_limits_are_those_of_the_documentation() {
        let text = include_str!("../../docs/untrusted.md");
        let [usual, strict] = [&[][..], &["--untrusted"]].map(|options| {
            let RunArgs { limits, time, inputs, .. } = run(options);
            let number = grouped;
            [
                ("--max-words", number(inputs.max_words as u64)),
                ("--fuel", number(limits.fuel)),
                ("--max-depth", number(limits.max_depth as u64)),
                ("--max-memory", format!("{}M", limits.max_memory >> 20).replace("4096M", "4G")),
                ("--max-pixels", number(limits.max_pixels)),
                ("--max-total-pixels", limits.max_total_pixels.map_or("none".to_owned(), number)),
                ("--max-images", number(limits.max_images)),
                ("--max-reflections", number(limits.max_reflections.into())),
                (
                    "--timeout",
                    time.timeout.map_or("none".to_owned(), |t| format!("{}s", t.as_secs())),
                ),
            ]
        });
        for ((option, usual), (_, strict)) in usual.into_iter().zip(strict) {
            let row = format!("| `{option}` | {usual} | {strict} |");
            assert!(text.contains(&row), "{row}");
        }
    }
}
