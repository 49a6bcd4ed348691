//! The options of `gmlvm disasm`.

use std::path::PathBuf;

use clap::ValueEnum;

use crate::args::{Inputs, LimitArgs, TimeArgs};

pub(super) const DISASM_ABOUT: &str = "\
Show a scene's tokens, tree, bytecode or machine code, beside the places in the source text they \
come from.

Bytecode is listed by function, the main program first, with the source line above the \
instructions that it became. With `clif`, `asm` or `--surface` the program is run, but nothing is \
traced, and each surface function is listed: what it captured and how that reaches the code, and its \
bytecode, the input of the code generator (CLIF) and machine code, as far as `--emit` asks for them.";

pub(super) const DISASM_EXAMPLES: &str = "\
Examples:
  gmlvm disasm scene.gml                        the bytecode of the whole program
  gmlvm disasm scene.gml --function marble      that of one function
  gmlvm disasm scene.gml --emit clif,asm        what each surface function was compiled to
  gmlvm disasm scene.gml --surface 3            all about one of them, by its number in `run -v`
  gmlvm disasm scene.gml --html scene.html      the same of all, to be looked at in a browser";

/// `gmlvm disasm`.
#[derive(Debug, clap::Args)]
pub(crate) struct DisasmArgs {
    /// The program; - is the standard input
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) inputs: Inputs,
    /// What to show, in this order [default: bytecode; with --surface: bytecode,clif,asm]
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    pub(crate) emit: Vec<Stage>,
    /// Show only this function, and surfaces that are closures of it; by name or number
    #[arg(long, value_name = "NAME|N")]
    pub(crate) function: Option<String>,
    /// Show only this surface, by its number in `run -v`
    #[arg(long, value_name = "N")]
    pub(crate) surface: Option<usize>,
    /// Write source, bytecode, CLIF and machine code as one page with linked panes; - is the standard output
    #[arg(long, value_name = "FILE", conflicts_with = "emit")]
    pub(crate) html: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) limits: LimitArgs,
    #[command(flatten)]
    pub(crate) time: TimeArgs,
}

/// A form that a program takes on its way through the compilers, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub(crate) enum Stage {
    Tokens,
    Ast,
    Bytecode,
    /// What the code generator was given for each surface function
    Clif,
    /// The machine code of each surface function
    Asm,
}
