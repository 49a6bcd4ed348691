//! The options of `gmlvm view`.

use std::path::PathBuf;

use clap::value_parser;

use crate::args::sampling::SamplingArgs;
use crate::args::{Engine, Inputs, LimitArgs, PictureArgs, Precision, TimeArgs};

pub(super) const VIEW_ABOUT: &str = "\
Show a scene as a live page: source, image, code, plan, statistics, a chart of its methods, and what \
is wrong with it.

The address of the page is printed; open it in a browser on this machine. What is typed into the page, \
or saved by any editor, is rendered at once, coarsely at first; a new run cancels the one before, and \
errors leave the last good image. Two images can be compared, and errors, costs and certainty be seen \
pixel by pixel. Nothing is written, unless --edit allows the page to save the scene.

The page is served to this machine only, under an address that cannot be guessed, until a signal ends \
the command. Each run is a process of its own with the limits of --untrusted, which is implied; any \
of them can be raised by its own option.";

pub(super) const VIEW_EXAMPLES: &str = "\
Examples:
  gmlvm view scene.gml                  print the address of the live page
  gmlvm view scene.gml --edit           with Ctrl-S in the page, save the scene
  gmlvm view scene.gml --port 8000      at the same port every time
  gmlvm view scene.gml --size 160x120   small and quick";

/// `gmlvm view`.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ViewArgs {
    /// The program
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) inputs: Inputs,

    /// Port to listen at, on 127.0.0.1 [default: any that is free]
    #[arg(
        long,
        value_name = "PORT",
        default_value_t = 0,
        hide_default_value = true,
        help_heading = "Page"
    )]
    pub(crate) port: u16,
    /// Let the page write the scene's file
    #[arg(long, help_heading = "Page")]
    pub(crate) edit: bool,
    /// Render once, as the standard input says, for the command that serves the page; no business of
    /// users.
    #[arg(skip)]
    pub(crate) worker: bool,

    /// Threads for tracing, at most 1024 [default: one per processor]
    #[arg(short = 'j', long, value_name = "N", value_parser = value_parser!(u16).range(1..=1024), env = "RAYON_NUM_THREADS", hide_env_values = true, help_heading = "Engine")]
    pub(crate) threads: Option<u16>,
    /// How surface functions are evaluated at first; the page can change it
    #[arg(long, value_name = "ENGINE", default_value = "auto", help_heading = "Engine")]
    pub(crate) engine: Engine,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// The numbers that rays are traced with at first; the page can change them
    #[arg(long, value_name = "NUMBERS", default_value = "f64", help_heading = "Picture")]
    pub(crate) precision: Precision,
    #[command(flatten)]
    pub(crate) sampling: SamplingArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
    #[command(flatten)]
    pub(crate) time: TimeArgs,
}
