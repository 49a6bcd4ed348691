//! How large images and scenes may be.

use compiler::diagnostic::{Code, Diagnostic};
use renderer::certify::CertainScene;
use renderer::numeric::dd::Dd;
use renderer::scene::Scene;
use vm::host::RenderJob;
use vm::machine::Limits;

use crate::args::{LimitArgs, Precision};
use compiler::diagnostic::grouped;

/// What a run has asked for so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Used {
    pub(crate) images: u64,
    /// Pixels of all images together.
    pub(crate) pixels: u64,
}

impl Used {
    /// There is one more image.
    pub(crate) fn add(&mut self, width: u32, height: u32) {
        self.images += 1;
        self.pixels = self.pixels.saturating_add(u64::from(width) * u64::from(height));
    }
}

impl LimitArgs {
    /// The limits of the machine.
    pub(crate) fn machine(self) -> Limits {
        let LimitArgs { fuel, max_depth, max_memory, .. } = self;
        Limits { fuel, max_depth, max_memory }
    }

    /// Fails if the job, the last that has been added to what is `used`, is beyond a limit at this size.
    ///
    /// # Errors
    /// Says which limit.
    pub(crate) fn check(
        self,
        job: &RenderJob<'_>,
        used: Used,
        width: u32,
        height: u32,
        precision: Precision,
    ) -> Result<(), Box<Diagnostic>> {
        let n_pixels = u64::from(width) * u64::from(height);
        let bytes_per_shape = match precision {
            Precision::F64 => Scene::<f64>::BYTES_PER_SHAPE,
            Precision::Dd => Scene::<Dd>::BYTES_PER_SHAPE,
            Precision::Certified => CertainScene::BYTES_PER_SHAPE,
        };
        let (message, option) = if used.images > self.max_images {
            (
                format!("the limit of {} images is reached", grouped(self.max_images)),
                "--max-images N",
            )
        } else if n_pixels > self.max_pixels {
            let (shown, limit) = (grouped(n_pixels), grouped(self.max_pixels));
            let message =
                format!("the image has {width} x {height} = {shown} pixels; the limit is {limit}");
            (message, "--max-pixels N")
        } else if let Some(limit) = self.max_total_pixels.filter(|limit| used.pixels > *limit) {
            let (shown, limit) = (grouped(used.pixels), grouped(limit));
            let message =
                format!("with this image the run has {shown} pixels; the limit is {limit}");
            (message, "--max-total-pixels N")
        } else if job.depth > self.max_reflections {
            let (shown, limit) =
                (grouped(u64::from(job.depth)), grouped(u64::from(self.max_reflections)));
            let message = format!("the reflection depth is {shown}; the limit is {limit}");
            (message, "--max-reflections N")
        } else if job.object.n_shapes().saturating_mul(bytes_per_shape) > self.max_memory {
            let room = grouped(self.max_memory / bytes_per_shape);
            let n_shapes = shape_count(job.object.n_shapes());
            let message = format!("the scene has {n_shapes}; the memory limit allows for {room}");
            (message, "--max-memory SIZE")
        } else {
            return Ok(());
        };
        Err(Box::new(
            Diagnostic::new(Code::SizeLimit, job.origin.span, message)
                .help(format!("raise the limit with `{option}`")),
        ))
    }
}

/// Number of shapes in words; those that stand in a scene repeatedly count each time.
fn shape_count(n_shapes: u64) -> String {
    match n_shapes {
        u64::MAX => "more solids than can be counted".to_owned(),
        n => format!("{} solids", grouped(n)),
    }
}
