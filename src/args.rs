//! The command line, typed.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Parser, Subcommand, ValueEnum};
use compiler::lexer::MAX_TOKENS;
use serde::{Deserialize, Serialize};

use crate::frames::{self, Frames};
use crate::values::{self, Definition, Region, Size};

pub(crate) use bench::BenchArgs;
use bench::{BENCH_ABOUT, BENCH_EXAMPLES};
pub(crate) use chart::ChartArgs;
use chart::{CHART_ABOUT, CHART_EXAMPLES};
use diff::DIFF_ABOUT;
pub(crate) use diff::{DiffArgs, Metric};
use disasm::{DISASM_ABOUT, DISASM_EXAMPLES};
pub(crate) use disasm::{DisasmArgs, Stage};
pub(crate) use economy::EconomyArgs;
pub(crate) use limits::{LimitArgs, TimeArgs};
pub(crate) use line::{of_worker, parse};
use manual::COMPLETIONS_EXAMPLES;
pub(crate) use manual::{CompletionsArgs, ManArgs};
pub(crate) use outputs::OutputsArgs;
use parts::{MERGE_ABOUT, MERGE_EXAMPLES};
pub(crate) use parts::{MergeArgs, PartsArgs};
use sampling::SamplingArgs;
use stability::STABILITY_ABOUT;
pub(crate) use stability::StabilityArgs;
pub(crate) use view::ViewArgs;
use view::{VIEW_ABOUT, VIEW_EXAMPLES};

mod bench;
mod chart;
mod contradictions;
mod diff;
mod disasm;
mod economy;
mod limits;
mod line;
pub(crate) mod lsp;
mod manual;
mod outputs;
mod parts;
mod response;
pub(crate) mod sampling;
mod stability;
mod view;

/// Compile, run, inspect and measure GML scenes.
///
/// GML is the stack language of the ICFP 2000 programming contest, whose programs describe solids
/// and lights and render them. `gmlvm SCENE` is short for `gmlvm run SCENE`. An argument `@FILE` stands
/// for the arguments in FILE, one on each line.
#[derive(Debug, Parser)]
#[command(name = "gmlvm", version, arg_required_else_help = true, after_help = EXIT_CODES)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) common: Common,
    #[command(subcommand)]
    pub(crate) command: Command,
    /// All arguments, for starting the same again, but without `--watch`; `view` is untrusted.
    #[arg(skip)]
    pub(crate) line: Vec<OsString>,
}

const EXIT_CODES: &str = "\
Exit codes:
  0   done (diff: the images are the same)
  1   the GML program is wrong (diff: the images differ; bench: those of two engines;
      stability: a case is beyond its bound)
  2   wrong command line, or an input cannot be read
  3   an output could not be written
  4   a limit was reached
  5   refused: a file name outside the output directory
  70  a bug in gmlvm
  130, 143, 129  ended by SIGINT, SIGTERM, SIGHUP
  141 whoever read the standard output has closed it";

/// What all commands have in common.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Common {
    /// Report errors only
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// Tell more: phases, times and decisions
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// Colour messages; by itself on a terminal, unless NO_COLOR is set (CLICOLOR_FORCE: anywhere)
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    pub(crate) color: ColorChoice,
    /// How errors are reported: with source text, on one line each, or as one JSON object a line
    #[arg(long, global = true, value_name = "FORMAT", default_value = "human")]
    pub(crate) message_format: MessageFormat,
}

/// When to colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ColorChoice {
    Auto,
    Always,
    Never,
}

/// How diagnostics are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum MessageFormat {
    Human,
    Short,
    Json,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a scene and write its images
    #[command(long_about = RUN_ABOUT, after_long_help = RUN_EXAMPLES)]
    Run(RunArgs),
    /// Report what is wrong with scenes; write nothing
    #[command(long_about = CHECK_ABOUT)]
    Check(CheckArgs),
    /// Tell editors what is wrong with open scenes, what words mean and where they stand
    #[command(long_about = lsp::LSP_ABOUT)]
    Lsp(lsp::LspArgs),
    /// Show a scene's tokens, tree, bytecode or machine code
    #[command(long_about = DISASM_ABOUT, after_long_help = DISASM_EXAMPLES)]
    Disasm(DisasmArgs),
    /// Run a program and print the stack it leaves
    #[command(long_about = EVAL_ABOUT)]
    Eval(EvalArgs),
    /// Compare two images
    #[command(long_about = DIFF_ABOUT)]
    Diff(DiffArgs),
    /// Time engines, precisions and numbers of threads against one another
    #[command(long_about = BENCH_ABOUT, after_long_help = BENCH_EXAMPLES)]
    Bench(BenchArgs),
    /// Chart methods by what a picture costs and how far it is from the exact one
    #[command(long_about = CHART_ABOUT, after_long_help = CHART_EXAMPLES)]
    Chart(ChartArgs),
    /// Render scenes made to break ray tracers, and count wrong pixels
    #[command(long_about = STABILITY_ABOUT)]
    Stability(StabilityArgs),
    /// Join part files into images
    #[command(long_about = MERGE_ABOUT, after_long_help = MERGE_EXAMPLES)]
    Merge(MergeArgs),
    /// Show a scene as a live page in a browser
    #[command(long_about = VIEW_ABOUT, after_long_help = VIEW_EXAMPLES)]
    View(ViewArgs),
    /// Explain the code of an error
    Explain(ExplainArgs),
    /// Print a script by which a shell completes command lines
    #[command(after_long_help = COMPLETIONS_EXAMPLES)]
    Completions(CompletionsArgs),
    /// Write manual pages, for man
    Man(ManArgs),
}

impl Command {
    /// What the command's time is limited to.
    pub(crate) fn timeout(&self) -> Option<Duration> {
        match self {
            // That of each run is its own process's.
            Command::Run(args) if args.watch => None,
            Command::Run(args) => args.time.timeout,
            Command::Check(args) => args.time.timeout,
            Command::Eval(args) => args.time.timeout,
            Command::Disasm(args) => args.time.timeout,
            _ => None,
        }
    }
}

/// What goes into a program besides its text.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Inputs {
    /// Bind NAME before the program starts
    ///
    /// VALUE is an integer, a real, `true`, `false` or a "string", written as in GML; anything else
    /// is taken as the text of a string.
    #[arg(short = 'D', long = "define", value_name = "NAME=VALUE", value_parser = values::definition)]
    pub(crate) defines: Vec<Definition>,
    /// Look for included files here too, after the including file's own directory
    #[arg(short = 'I', long = "include", value_name = "DIR")]
    pub(crate) include_dirs: Vec<PathBuf>,
    /// Run a scene that may mean harm: tight limits, and no links to other places
    ///
    /// Limits that are not given become: --max-words 262144, --fuel 1000000000, --max-depth 10000, --max-memory 512M,
    /// --max-pixels 16777216, --max-total-pixels 67108864, --max-images 16, --max-reflections 1000 and
    /// --timeout 60s, each where the command has that option; and `run` gets --no-clobber. Included files must lie in the scene's own directory, or one of `-I`, and are not reached through links;
    /// a scene from the standard input has no directory. On Linux the kernel is asked to refuse `run`
    /// all writing but where its outputs go, and all connections (Landlock).
    #[arg(long, help_heading = "Limits")]
    pub(crate) untrusted: bool,
    /// Words of the program, at most 4194304, included files counted each time
    #[arg(
        long,
        value_name = "N",
        default_value_t = MAX_TOKENS,
        default_value_if("untrusted", "true", "262144"),
        help_heading = "Limits"
    )]
    pub(crate) max_words: usize,
}

impl Inputs {
    /// The words that a program may have with `--untrusted`.
    pub(crate) const STRICT_WORDS: usize = 262_144;
}

/// What the command line changes in a picture.
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(next_help_heading = "Picture")]
pub(crate) struct PictureArgs {
    /// The rules of shading: of 2000, of 2003, or by whether `render` gets an attenuation point
    #[arg(long, value_name = "DIALECT", default_value = "auto")]
    pub(crate) dialect: Dialect,
    /// Render all images in this size
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    pub(crate) size: Option<Size>,
    /// Render all images with this reflection depth
    #[arg(long, value_name = "N")]
    pub(crate) depth: Option<u32>,
    /// Render only these pixels; the rest of the image is black
    #[arg(long, value_name = "X,Y,W,H", value_parser = values::region)]
    pub(crate) region: Option<Region>,
}

/// The numbers that rays are traced with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Precision {
    /// Doubles, of 53 bits
    F64,
    /// Pairs of doubles, of 106 bits: the same formulas several times as slow, to check images by
    Dd,
    /// Numbers with bounds of their errors, of doubles and then of pairs, as far as pixels need them
    Certified,
}

impl Precision {
    /// The word for it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Precision::F64 => "f64",
            Precision::Dd => "dd",
            Precision::Certified => "certified",
        }
    }
}

/// `gmlvm run`.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct RunArgs {
    /// The program; - is the standard input
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) inputs: Inputs,

    /// Images go below DIR, which is made if need be
    #[arg(short, long, value_name = "DIR", default_value = ".", help_heading = "Output")]
    pub(crate) out_dir: PathBuf,
    /// Write to NAME instead of the name that the scene gives; - is the standard output
    ///
    /// {name} stands for the scene's name for the image, without directory and extension; n in the
    /// same braces for the number of the image in this run, from 1. A relative NAME is below the
    /// output directory. It is an error if two images would go to one file.
    #[arg(long, value_name = "NAME", help_heading = "Output")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) outputs: OutputsArgs,
    /// Run the program once for each frame, from A to B, with `frame` and `clock` bound
    ///
    /// `frame` is the number of the frame, an integer, and `clock` a real, 0.0 in the first frame and
    /// 1.0 in the last. {frame} in the names of outputs stands for the number; the scene's own names get
    /// it at their ends, as in ball-0007.ppm.
    #[arg(long, value_name = "A..B", value_parser = frames::read, conflicts_with = "parts", help_heading = "Output")]
    pub(crate) frames: Option<Frames>,
    /// File format; without it the name's extension decides, and PPM is the default
    ///
    /// With this option the extension of another format that the scene gives is replaced.
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub(crate) format: Option<ImageFormat>,
    /// Write times and counts as JSON; - is the standard output
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) stats: Option<PathBuf>,
    /// Write an image of how each pixel is known, as PNG; with `--certify` or `--precision certified`
    ///
    /// Black is certain by bounds in doubles, grey in twice their digits. What hangs on the rules for
    /// ties has the colour of what is undecided first: red for which boundary a ray meets, yellow for
    /// whether light arrives, blue for what the surface function does, white for the colour as bytes.
    /// FILE can have the placeholders that the NAME of `--output` can.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) mark_uncertain: Option<PathBuf>,

    /// Threads for tracing, at most 1024 [default: one per processor]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), env = "RAYON_NUM_THREADS", hide_env_values = true, help_heading = "Engine")]
    pub(crate) threads: Option<u16>,
    /// How surface functions are evaluated
    #[arg(long, value_name = "ENGINE", default_value = "auto", help_heading = "Engine")]
    pub(crate) engine: Engine,
    /// Write /tmp/perf-PID.map, by which the profiler `perf` names machine code
    #[arg(long, help_heading = "Engine")]
    pub(crate) perf_map: bool,
    #[command(flatten)]
    pub(crate) economy: EconomyArgs,

    /// Run again whenever the scene, or a file that it includes, changes; errors leave the last image
    #[arg(long, help_heading = "Engine")]
    pub(crate) watch: bool,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// The numbers that rays are traced with; surface functions compute in doubles with either
    #[arg(long, value_name = "NUMBERS", default_value = "f64", help_heading = "Picture")]
    pub(crate) precision: Precision,
    /// Find out for each pixel whether it is certain: short for `--precision certified`
    ///
    /// Each number comes with a bound of its error. A pixel that hangs on more than doubles can tell is
    /// traced again with twice their digits. What those leave open is an exact tie, or very near to
    /// one, which is decided by the language's rules. How many pixels there were of each kind is
    /// said, and is in the statistics.
    #[arg(long, conflicts_with = "precision", help_heading = "Picture")]
    pub(crate) certify: bool,
    #[command(flatten)]
    pub(crate) sampling: SamplingArgs,
    #[command(flatten)]
    pub(crate) parts: PartsArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
    #[command(flatten)]
    pub(crate) time: TimeArgs,
}

impl RunArgs {
    /// The numbers that rays are traced with.
    pub(crate) fn precision(&self) -> Precision {
        if self.certify { Precision::Certified } else { self.precision }
    }
}

const RUN_ABOUT: &str = "\
Run a scene and write its images.

Each `render` writes one image below the output directory, under the name that the scene gives. \
Scenes are not trusted: a name is refused if it leads out of the directory, through a symbolic \
link, to a hidden file or to a file that is no image. An image appears complete or not at all, and replaces one of the same name. For each \
image one line with its name, size and time goes to the standard error.";

const RUN_EXAMPLES: &str = "\
Examples:
  gmlvm scene.gml                     write the images under the scene's own names
  gmlvm run scene.gml -o out          the same, below out/
  gmlvm scene.gml --format png        as PNG files, also where the scene says .ppm
  gmlvm scene.gml --size 80x60        a quick draft
  gmlvm scene.gml --output '{name}-draft.png'
  gmlvm scene.gml --output - >a.ppm   to the standard output
  gmlvm - -D n=5 -D file=a.ppm        from the standard input, with two names bound
  gmlvm scene.gml --region 112,40,1,1 one pixel, to look into an error there
  gmlvm scene.gml --frames 1..50      fifty images of a scene that uses `clock`
  gmlvm scene.gml --watch             again after each change
  gmlvm scene.gml --watch --preview   with the images in the terminal
  gmlvm scene.gml @final.args         with the options in a file, one on each line";

/// An image file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ImageFormat {
    /// Binary PPM (P6), a byte per channel
    Ppm,
    /// PNG, a byte per channel
    Png,
    /// PFM: linear light as 32-bit floating point numbers, not clamped, with one zero and one NaN
    Pfm,
}

/// How surface functions are evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Engine {
    /// The fastest that works
    Auto,
    /// By interpretation
    Interp,
    /// As machine code
    Jit,
}

impl Engine {
    /// The word for it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Engine::Auto => "auto",
            Engine::Interp => "interp",
            Engine::Jit => "jit",
        }
    }

    /// The engine in a precision, as tables name the two together: doubles go without saying.
    pub(crate) fn in_precision(self, precision: Precision) -> String {
        match precision {
            Precision::F64 => self.name().to_owned(),
            other => format!("{} {}", self.name(), other.name()),
        }
    }
}

/// The rules of shading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Dialect {
    /// Chicago if `render` gets an attenuation point, ICFP otherwise
    Auto,
    /// ICFP 2000: highlights and reflections take the surface's colour
    Icfp,
    /// Chicago 2003: they do not, and the primary ray counts for the depth
    Chicago,
}

const CHECK_ABOUT: &str = "\
Report what is wrong with scenes; write nothing.

Each scene is compiled and run, and its `render` operands are checked, but nothing is traced: what \
a surface function does wrong shows only in `gmlvm run`. Exits with the code of the first scene \
that fails.";

/// `gmlvm check`.
#[derive(Debug, clap::Args)]
pub(crate) struct CheckArgs {
    /// The programs; - is the standard input
    #[arg(required = true, value_name = "SCENE")]
    pub(crate) scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) inputs: Inputs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
    #[command(flatten)]
    pub(crate) time: TimeArgs,
}

const EVAL_ABOUT: &str = "\
Run a program and print the stack it leaves, bottom first, one value a line, in GML syntax.

Functions print as {...}, objects as <object>, lights as <light>. `render` takes its operands and \
checks them, but renders nothing.";

/// `gmlvm eval`.
#[derive(Debug, clap::Args)]
pub(crate) struct EvalArgs {
    /// The program; - is the standard input
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) inputs: Inputs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
    #[command(flatten)]
    pub(crate) time: TimeArgs,
}

/// `gmlvm explain`.
#[derive(Debug, clap::Args)]
pub(crate) struct ExplainArgs {
    /// The code, such as E0201
    pub(crate) code: String,
}
