//! The options that say what an output may replace, and whether images are shown besides.

use crate::failure::Failure;
use crate::output::Existing;

/// What becomes of images besides their names and formats.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputsArgs {
    /// Fail if an output exists already: no file is replaced
    ///
    /// That is looked for before an image is rendered, and once more when it is put in its place. Part
    /// files that are damaged are replaced all the same.
    #[arg(long, overrides_with = "clobber", default_value_if("untrusted", "true", "true"))]
    no_clobber: bool,
    /// Replace images that exist already, with `--untrusted` too
    #[arg(long, overrides_with = "no_clobber")]
    clobber: bool,
    /// Draw the images in the terminal too, on the standard error, as small as it is
    ///
    /// Each character shows two pixels, one above the other. With COLORTERM=truecolor there are all colours,
    /// otherwise those of terminals with 256. Where the standard error is no terminal, or NO_COLOR is
    /// set, nothing is drawn, unless `--color always` or CLICOLOR_FORCE says so; there the width is
    /// COLUMNS, or 80.
    #[arg(long)]
    pub(crate) preview: bool,
}

impl OutputsArgs {
    /// What becomes of a file that has an output's name.
    pub(crate) fn existing(self) -> Existing {
        if self.no_clobber && !self.clobber { Existing::Keep } else { Existing::Replace }
    }

    /// Whether the options make sense for a run that is `--watch`ed.
    ///
    /// # Errors
    /// When the second run could not write what the first has written.
    pub(crate) fn check_watched(self) -> Result<(), Failure> {
        match self.existing() {
            Existing::Replace | Existing::Succeed => Ok(()),
            Existing::Keep => Err(Failure::Usage(
                "`--watch` replaces its images, which `--no-clobber` (part of `--untrusted`) \
                 forbids; allow it with `--clobber`"
                    .to_owned(),
            )),
        }
    }
}
