//! The options of `gmlvm diff`.

use std::path::PathBuf;

use clap::ValueEnum;

use crate::values;

/// `gmlvm diff`.
#[derive(Debug, clap::Args)]
pub(crate) struct DiffArgs {
    /// The one image: PPM, PNG or PFM
    pub(crate) a: PathBuf,
    /// The other
    pub(crate) b: PathBuf,
    /// What to measure, and to hold against the tolerance
    #[arg(long, value_name = "METRIC", default_value = "count")]
    pub(crate) metric: Metric,
    /// How much is still the same; see the metrics [default: 0, for psnr: infinity]
    #[arg(long, value_name = "T", value_parser = values::tolerance)]
    pub(crate) tolerance: Option<f64>,
    /// Write a picture of the differences: black where there is none, bright where it is large
    #[arg(long, value_name = "FILE.png")]
    pub(crate) map: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) const DIFF_ABOUT: &str = "\
Compare two images of the formats PPM (P6), PNG and PFM.

Channels are compared in levels: 1/255 of full scale, whatever the format; alpha is ignored. Images \
of unequal sizes differ. Exits with 0 if the images are the same within the tolerance, with 1 if \
they differ, with 2 if they cannot be read.";

/// A measure of how much two images differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Metric {
    /// Number of pixels with a channel off by more than T levels; same if there are none
    Count,
    /// Largest difference of a channel, in levels; same if at most T
    Max,
    /// Root of the mean square of all channels' differences, in levels; same if at most T
    Rmse,
    /// Peak signal-to-noise ratio, 20 log10(255 / rmse) dB; same if at least T
    Psnr,
}
