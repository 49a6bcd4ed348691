//! The options of `gmlvm stability`.

use crate::args::{Engine, Precision};

/// `gmlvm stability`.
#[derive(Debug, clap::Args)]
pub(crate) struct StabilityArgs {
    /// Engines, each of which is held to the bounds
    #[arg(long, value_name = "ENGINE,...", value_delimiter = ',', default_value = "interp,jit")]
    pub(crate) engines: Vec<Engine>,
    /// Precisions, in each of which the engines are held to the bounds
    #[arg(long, value_name = "PRECISION,...", value_delimiter = ',', default_value = "f64,dd")]
    pub(crate) precisions: Vec<Precision>,
    /// Threads for tracing, at most 1024 [default: one per processor]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), env = "RAYON_NUM_THREADS", hide_env_values = true)]
    pub(crate) threads: Option<u16>,
    /// Print the table as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) const STABILITY_ABOUT: &str = "\
Render scenes made to break ray tracers, and count wrong pixels.

What must hold of each scene's images is known: every pixel, an outline, a symmetry, or that several \
images are the same. A line of the table has the number of pixels for which that fails, in images \
of a renderer as textbooks have it, without care (naive), and in ours, by engine and precision. For scenes in \
which nothing may be in shadow, blocked rays toward lights count as well. The scenes are part of \
the program. Exits with 1 if a number of ours is beyond its bound.";
