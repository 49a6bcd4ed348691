//! The options of `gmlvm chart`.

use std::path::PathBuf;
use std::time::Duration;

use clap::builder::PossibleValuesParser;

use crate::args::{Inputs, LimitArgs, PictureArgs};
use crate::chart::methods::Method;
use crate::chart::scaling::series::{ALL, MAX_SIZE, Series};
use crate::chart::study::sets::SETS;
use crate::values;

/// `gmlvm chart`.
#[derive(Debug, clap::Args)]
pub(crate) struct ChartArgs {
    /// Programs, which are measured, and files of `--export`, whose measurements are taken as they are
    #[arg(required_unless_present_any = ["scaling", "set"], value_name = "SCENE|FILE.json")]
    pub(crate) scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) inputs: Inputs,

    /// Methods to measure: by name, or all of a diagram
    #[arg(long, value_name = "METHOD,...", value_delimiter = ',', default_value = "rounding", value_parser = PossibleValuesParser::new(Method::words()), help_heading = "Measurement")]
    pub(crate) methods: Vec<String>,
    /// Chart how the time for a ray grows, in all series of scenes or in these; files are of such charts
    #[arg(long, value_name = "SERIES,...", num_args = 0..=1, require_equals = true, value_delimiter = ',', default_missing_value = ALL, value_parser = PossibleValuesParser::new(Series::words()), conflicts_with_all = ["methods", "defines", "include_dirs", "depth"], help_heading = "Measurement")]
    pub(crate) scaling: Option<Vec<String>>,
    /// Chart one of these sets instead, which are measured in ways of their own; files are of that set
    #[arg(long, value_name = "SET", value_parser = PossibleValuesParser::new(SETS.iter().map(|set| set.name)), conflicts_with_all = ["methods", "scaling"], help_heading = "Measurement")]
    pub(crate) set: Option<String>,
    /// The largest number of solids, holes, reflections or lights
    #[arg(long, value_name = "N", default_value_t = MAX_SIZE, value_parser = clap::value_parser!(u64).range(1..), requires = "scaling", help_heading = "Measurement")]
    pub(crate) up_to: u64,
    /// Rounds that count; in each, every method runs once, or every size
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=1000), help_heading = "Measurement")]
    pub(crate) runs: u32,
    /// Rounds before these, which do not count
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..=1000), help_heading = "Measurement")]
    pub(crate) warmup: u32,
    /// Processor time of one image after which a method, or a size, is given up
    #[arg(long, value_name = "T", default_value = "60s", value_parser = values::duration, help_heading = "Measurement")]
    pub(crate) timeout: Duration,

    /// Draw the chart, in the format that the extension names
    #[arg(short, long, value_name = "FILE.svg|png|html", help_heading = "Output")]
    pub(crate) output: Option<PathBuf>,
    /// Write the measurements as JSON; - is the standard output
    ///
    /// Then no tables are printed there.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) export: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

pub(super) const CHART_ABOUT: &str = "\
Chart methods by what a picture costs and how far it is from the exact one.

A method is a way to render: an engine in a precision, or a tracer as textbooks have it (naive), in \
single or double precision and with an epsilon of its own, for comparison. All methods render all \
images of a scene in turn, round by round, on one thread, and what counts is its processor time. \
Tracing is told apart from preparing, that is building the scene and compiling surface functions, \
which does not grow with the picture.

The error is the share of pixels of which any byte is not that of the same image in double-double. \
Pixels with a byte off by more than one level, which no rounding of a colour explains, are \
counted besides, as are the largest and the mean square difference of linear light. A method is on \
the front if no other is both as fast and as exact; otherwise the fastest is named that is both. \
Methods that fail or take too long are drawn as crosses at the edge.

Methods of sampling are charted apart: the error of one ray for each pixel is many powers of ten \
above that of rounding. There it is the difference in linear light from the mean of many rays.

With --scaling, what is charted is how the time for a ray changes as there are more spheres, holes in \
a plate, reflections of each ray, or lights. The scenes are made by programs of ours; each size is \
rendered once in each round, from its program on. Rays of all kinds count. The growth that is told is \
the median of the rounds' ratios, with an interval of 95 % confidence.

With --set, it is one of these:
  distance     ways to intersect a line and a sphere, from more and more far away
  stability    wrong pixels of each case of `gmlvm stability`, by method
  certainty    how certified pixels of scenes are known, and what that costs
  bounces      how errors grow from reflection to reflection
  bounds       how far off pixels of scenes may be by their bounds, and are
  omissions    the time for a pixel, as what a scene does not need is left out step by step
  differences  where methods differ from the certified images of scenes
  threads      how much faster scenes are traced by two threads

Distance, stability and bounces are measured on what is part of the program, the others on scenes.

The tables are printed. Exits with the code of the first scene that fails; the others are charted.";

pub(super) const CHART_EXAMPLES: &str = "\
Examples:
  gmlvm chart scene.gml                              tables only
  gmlvm chart scenes/*.gml --size 160x120 -o all.svg
  gmlvm chart scene.gml --export data.json -o a.html
  gmlvm chart data.json -o a.png                     the same, without measuring again
  gmlvm chart scene.gml --methods jit-f64,jit-dd --runs 30 -o two.svg
  gmlvm chart --set certainty scenes/*.gml -o certainty.svg
  gmlvm chart --set distance --export far.json -o far.svg
  gmlvm chart --scaling --export growth.json -o growth.svg
  gmlvm chart --scaling=spheres,holes --up-to 1000 --size 80x60
  gmlvm chart --scaling growth.json -o growth.png    the same, without measuring again";
