//! Options about what images leave out of the model.

use clap::ValueEnum;
use renderer::plan::Omissions;

/// What images leave out of the model.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct EconomyArgs {
    /// Say what each scene uses of the model, and what leaving out the rest saves
    ///
    /// Each image is traced again several times, with each omission undone in turn; the table has the
    /// processor time that this takes beside that of the plan. The bytes must be the same.
    #[arg(long, conflicts_with_all = ["plan", "parts"], help_heading = "Engine")]
    pub(crate) explain: bool,
    /// Whether what a scene has no use for is left out, which changes no byte: `off` is for checking
    #[arg(long, value_name = "WHETHER", default_value = "on", help_heading = "Engine")]
    pub(crate) plan: Switch,
}

impl EconomyArgs {
    /// What may be left out.
    pub(crate) fn omissions(self) -> Omissions {
        match self.plan {
            Switch::On => Omissions::ALL,
            Switch::Off => Omissions::NONE,
        }
    }
}

/// Whether something is done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Switch {
    /// It is
    #[default]
    On,
    /// It is not
    Off,
}
