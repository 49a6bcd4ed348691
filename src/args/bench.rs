//! The options of `gmlvm bench`.

use std::path::PathBuf;
use std::time::Duration;

use crate::args::sampling::SamplingArgs;
use crate::args::{Engine, Inputs, LimitArgs, PictureArgs, Precision};
use crate::values;

/// `gmlvm bench`.
#[derive(Debug, clap::Args)]
pub(crate) struct BenchArgs {
    /// The programs
    #[arg(required = true, value_name = "SCENE")]
    pub(crate) scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) inputs: Inputs,

    /// Engines; the same twice shows the noise
    #[arg(
        long,
        value_name = "ENGINE,...",
        value_delimiter = ',',
        default_value = "interp,jit,auto",
        help_heading = "Measurement"
    )]
    pub(crate) engines: Vec<Engine>,
    /// The numbers that rays are traced with, in each of which the engines run
    #[arg(
        long,
        value_name = "NUMBERS,...",
        value_delimiter = ',',
        default_value = "f64",
        help_heading = "Measurement"
    )]
    pub(crate) precision: Vec<Precision>,
    /// Numbers of threads, each at most 1024
    #[arg(short = 'j', long, value_name = "N,...", value_delimiter = ',', default_value = "1", value_parser = clap::value_parser!(u16).range(1..=1024), help_heading = "Measurement")]
    pub(crate) threads: Vec<u16>,
    /// Rounds that count; in each, every variant runs once
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = "Measurement")]
    pub(crate) runs: u32,
    /// Begin rounds for so long for each scene, in place of a fixed number: 10s, 500ms
    #[arg(long, value_name = "T", conflicts_with = "runs", value_parser = values::duration, help_heading = "Measurement")]
    pub(crate) time: Option<Duration>,
    /// Rounds before these, which do not count
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..=100_000), help_heading = "Measurement")]
    pub(crate) warmup: u32,
    /// Time each surface function alone, interpreted and as machine code
    #[arg(long, conflicts_with_all = ["engines", "threads", "size", "region", "depth", "dialect", "precision", "samples", "adaptive"], help_heading = "Measurement")]
    pub(crate) surfaces: bool,

    /// Write the results as JSON, in the shape of hyperfine's; - is the standard output
    ///
    /// Then no tables are printed there.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) export: Option<PathBuf>,
    /// Compare with results exported before, by gmlvm or by hyperfine, of equal commands
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) compare: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    #[command(flatten)]
    pub(crate) sampling: SamplingArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

pub(super) const BENCH_ABOUT: &str = "\
Time engines, precisions and numbers of threads against one another; write no images.

Every engine in every precision with every number of threads is a variant. Variants run in turn, once in each round, \
and who begins moves on from round to round, so that whatever else the machine does falls on all \
alike. A run takes from reading the scene to encoding its images in memory, and starts cold: \
nothing compiled by an earlier run is used again. All variants of one precision must give the same \
images, to the last byte; if not, that is an error.

Printed are the median, its spread (the median of the absolute deviations from it), and the median \
ratio to the first variant's time in the same round. The interval holds the true median ratio with \
a confidence of at least 95 %, whatever the distribution: it is that of the sign test, from order \
statistics (Hollander, Wolfe and Chicken, Nonparametric Statistical Methods, 3.6), and takes 6 \
rounds or more. With --compare it is that of the rank sum test (there 4.3), about the ratio of new \
times to old; that the machine has changed meanwhile it cannot know. A difference is called one \
only if the interval leaves out 1.

Processor time is that of all threads. Phases are medians of their own, and rates those of \
tracing. With auto, compiling (jit) is part of tracing as well, and is summed over threads.

With --surfaces each surface function is called alone, at a fixed spread of points on the faces of \
the solids that have it: alike ones, with equal machine code, once for all. There the times of \
calls are processor times.";

pub(super) const BENCH_EXAMPLES: &str = "\
Examples:
  gmlvm bench scene.gml                            the three engines on one thread
  gmlvm bench scene.gml --engines auto -j 1,2      what a second thread gains
  gmlvm bench scene.gml --precision f64,dd         what twice the digits cost
  gmlvm bench scenes/*.gml --time 5s --export old.json
  gmlvm bench scenes/*.gml --time 5s --compare old.json
  gmlvm bench scene.gml --engines auto,auto        how much is noise
  gmlvm bench scene.gml --surfaces                 each surface function alone";
