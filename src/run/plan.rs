//! How a job is rendered: as the scene says, but for what the command line overrides.

use renderer::camera::View;
use renderer::shade::Illumination;
use vm::host::RenderJob;

use crate::args::{Dialect, PictureArgs};
use crate::failure::Failure;
use crate::values::{Region, Size};

/// How to render one image.
#[derive(Debug)]
pub(crate) struct Plan {
    /// Size, field of view, and the pixels wanted.
    pub(crate) view: View,
    /// Light, and the rules of shading.
    pub(crate) illumination: Illumination,
}

impl Plan {
    /// The plan for a job.
    ///
    /// # Errors
    /// When the region asked for has no pixels in this image.
    pub(crate) fn new(job: &RenderJob<'_>, args: &PictureArgs) -> Result<Self, Failure> {
        let Size { width, height } = size(job, args);
        let mut view = View::whole(width, height, job.fov_deg);
        if let Some(region) = args.region {
            let Some(Region { x, y, width, height }) = region.clipped(width, height) else {
                return Err(Failure::Usage(format!(
                    "no pixel of the {width}x{height} image lies in the region {region}"
                )));
            };
            view.region = renderer::camera::Region { x, y, width, height };
        }
        let illumination = job.illumination(match args.dialect {
            Dialect::Auto => vm::host::Dialect::Auto,
            Dialect::Icfp => vm::host::Dialect::Icfp,
            Dialect::Chicago => vm::host::Dialect::Chicago,
        });
        Ok(Plan { view, illumination })
    }

    /// Number of pixels that are traced.
    pub(crate) fn n_pixels(&self) -> u64 {
        u64::from(self.view.region.width) * u64::from(self.view.region.height)
    }

    /// The dialect, in a word.
    pub(crate) fn dialect(&self) -> &'static str {
        if self.illumination.tint_specular { "icfp" } else { "chicago" }
    }
}

/// Size of a job's image.
pub(crate) fn size(job: &RenderJob<'_>, args: &PictureArgs) -> Size {
    args.size.unwrap_or(Size { width: job.width, height: job.height })
}
