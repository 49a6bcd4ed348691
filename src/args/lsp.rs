//! The options of `gmlvm lsp`.

use crate::args::Inputs;

pub(super) const LSP_ABOUT: &str = "\
Tell editors what is wrong with open scenes, what words mean and where they stand.

This is a language server, which editors start by themselves: it talks the language server protocol \
over the standard input and output. Scenes are checked whenever they change, as `check` does, but \
always within the limits that `--untrusted` sets, and for ten seconds at most. A file of another extension than .gml is taken for \
one to be included: its words and brackets are checked, and it is not run.";

/// `gmlvm lsp`.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct LspArgs {
    #[command(flatten)]
    pub(crate) inputs: Inputs,
    /// What some editors say to servers; there is no other way of talking
    #[arg(long, hide = true)]
    pub(crate) stdio: bool,
}
