//! The options that spread an image over runs and machines, and those of `gmlvm merge`.

use std::path::PathBuf;

use crate::args::ImageFormat;
use crate::output::Existing;
use crate::parts::shard::{self, ShardChoice};

/// Where parts of images are kept, and which of them are this run's business.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Parts")]
pub(crate) struct PartsArgs {
    /// Keep each band of rows as a file in DIR when it is done, and render only what is not there yet
    ///
    /// A run that was interrupted goes on where it was when it is started again. Files that are damaged
    /// are rendered again; those of another scene or with other settings are refused.
    #[arg(long, value_name = "DIR")]
    pub(crate) parts: Option<PathBuf>,
    /// Render only the Kth of N shares of the bands, and write no images: `gmlvm merge` does, from the
    /// parts of all; with `--frames`, in place of bands, frames, with their images
    ///
    /// With auto, K and N are those of the job: of a Slurm job array or step, or of Open MPI. GNU parallel
    /// and indexed jobs of Kubernetes do not tell N, which is then taken from GMLVM_SHARDS.
    #[arg(long, value_name = "K/N|auto", value_parser = shard::choice)]
    pub(crate) shard: Option<ShardChoice>,
}

/// `gmlvm merge`.
#[derive(Debug, clap::Args)]
pub(crate) struct MergeArgs {
    /// Directories of `--parts`, or part files
    #[arg(required = true, value_name = "DIR|PART")]
    pub(crate) inputs: Vec<PathBuf>,
    /// Images go below DIR, which is made if need be
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub(crate) out_dir: PathBuf,
    /// Write to NAME instead of the name that the scene gives, as with `run`; - is the standard output
    #[arg(long, value_name = "NAME")]
    pub(crate) output: Option<PathBuf>,
    /// File format; without it that of the runs that made the parts
    #[arg(long, value_name = "FORMAT")]
    pub(crate) format: Option<ImageFormat>,
    /// Fail if an image exists already: no file is replaced
    #[arg(long, overrides_with = "clobber")]
    no_clobber: bool,
    /// Replace images that exist already, in spite of a `--no-clobber` before it
    #[arg(long, overrides_with = "no_clobber")]
    clobber: bool,
    /// Leave rows black that are not there, and take it that there are no further images
    #[arg(long)]
    pub(crate) allow_missing: bool,
    /// Pixels of one image
    #[arg(long, value_name = "N", default_value_t = 1 << 28)]
    pub(crate) max_pixels: u64,
}

impl MergeArgs {
    /// What becomes of a file that has an image's name.
    pub(crate) fn existing(&self) -> Existing {
        if self.no_clobber && !self.clobber { Existing::Keep } else { Existing::Replace }
    }
}

pub(super) const MERGE_ABOUT: &str = "\
Join the part files of `run --parts` into the images.

The images are those of a single run, to the last byte, whatever number of runs, shards and machines \
has made the parts. Parts of different scenes or settings are not joined, and neither are damaged \
ones. Rows that are missing are an error that names them, and so is a run that no shard has come to \
the end of, since there may be images that no part tells of.";

pub(super) const MERGE_EXAMPLES: &str = "\
Examples:
  gmlvm run scene.gml --parts p --shard 1/3   on one machine, 2/3 and 3/3 on others
  gmlvm merge p                               the images, under the scene's own names
  gmlvm merge p --allow-missing --output draft.png
  seq 16 | GMLVM_SHARDS=16 parallel gmlvm run scene.gml --parts p --shard auto";
