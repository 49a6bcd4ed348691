//! The options that say which samples make a pixel.

use clap::value_parser;
use renderer::sampling::Sampling;

/// The depth of `--adaptive` by itself: as many samples as 8 x 8 where all look different.
const DEPTH: &str = "3";

/// How pixels are sampled.
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(next_help_heading = "Picture")]
pub(crate) struct SamplingArgs {
    /// Make each pixel the mean of N x N samples, at most 64 x 64; without it there is one, at the
    /// centre
    ///
    /// The samples are at the centres of equal cells. What each shows is clamped as a pixel would be,
    /// but for PFM, and the mean is taken in linear light.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(Sampling::MAX_GRID)))]
    samples: Option<u32>,
    /// Make each pixel the mean of samples at its corners, and of more where those look different
    ///
    /// Two samples look different if they meet different faces, by themselves or in reflections, if a
    /// lamp reaches one and not the other, or if their surface functions decide differently (`if`,
    /// `floor`, `frac`, `get`). A square with corners that do is cut into quarters, DEPTH times at most
    /// (3 without it, 6 at most). What lies between the corners of a pixel is not found.
    #[arg(long, value_name = "DEPTH", num_args = 0..=1, require_equals = true, default_missing_value = DEPTH, value_parser = value_parser!(u32).range(1..=i64::from(Sampling::MAX_DEPTH)), conflicts_with = "samples")]
    adaptive: Option<u32>,
}

impl SamplingArgs {
    /// Which points make a pixel.
    pub(crate) fn sampling(self) -> Sampling {
        match (self.samples, self.adaptive) {
            (None | Some(1), None) => Sampling::Centre,
            (Some(n), None) => Sampling::Grid(n),
            (_, Some(depth)) => Sampling::Adaptive(depth),
        }
    }

    /// The option that asks for it, if there is one.
    pub(crate) fn option(self) -> Option<String> {
        let samples = self.samples.map(|n| format!("--samples={n}"));
        samples.or(self.adaptive.map(|depth| format!("--adaptive={depth}")))
    }
}

/// The sampling that a page names, as [`name`] does.
pub(crate) fn named(text: &str) -> Option<Sampling> {
    let number = |text: &str, max| text.parse().ok().filter(|n| (1..=max).contains(n));
    match text.split_once(' ') {
        None if text == "centre" => Some(Sampling::Centre),
        Some(("grid", n)) => number(n, Sampling::MAX_GRID).map(Sampling::Grid),
        Some(("adaptive", depth)) => number(depth, Sampling::MAX_DEPTH).map(Sampling::Adaptive),
        _ => None,
    }
}

/// The same in a word.
pub(crate) fn name(sampling: Sampling) -> String {
    match sampling {
        Sampling::Centre => "centre".to_owned(),
        Sampling::Grid(n) => format!("grid {n}"),
        Sampling::Adaptive(depth) => format!("adaptive {depth}"),
    }
}
