//! The options of `gmlvm completions` and `gmlvm man`.

use std::path::PathBuf;

use clap_complete::Shell;

/// `gmlvm completions`.
#[derive(Debug, clap::Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    pub(crate) shell: Shell,
}

/// `gmlvm man`.
#[derive(Debug, clap::Args)]
pub(crate) struct ManArgs {
    /// Where the pages go, gmlvm.1 and one for each command; the directory is made if need be
    pub(crate) dir: PathBuf,
}

pub(super) const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  gmlvm completions bash >~/.local/share/bash-completion/completions/gmlvm
  gmlvm completions zsh >~/.zfunc/_gmlvm    with `fpath+=~/.zfunc` before compinit in ~/.zshrc
  gmlvm completions fish >~/.config/fish/completions/gmlvm.fish";
