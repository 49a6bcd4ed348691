//! What a run took, as `--stats` writes it.

use std::path::Path;
use std::time::Duration;

use renderer::shade::RayCounts;
use serde::Serialize;

use crate::console;
use crate::failure::Failure;
use crate::output::{Existing, Target};
use crate::run::certainty::Known;

/// Times and counts of a run.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Stats {
    pub(crate) version: &'static str,
    pub(crate) scene: String,
    pub(crate) engine: &'static str,
    pub(crate) precision: &'static str,
    /// Which points make a pixel.
    pub(crate) sampling: String,
    pub(crate) threads: usize,
    /// Seconds from reading the scene to the end of its last image.
    pub(crate) total: f64,
    pub(crate) phases: Phases,
    pub(crate) counts: Counts,
    pub(crate) rays: Rays,
    pub(crate) images: Vec<ImageStats>,
}

/// Seconds of each phase, of all images together.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Phases {
    pub(crate) read: f64,
    pub(crate) compile: f64,
    /// The program itself, without its images.
    pub(crate) run: f64,
    pub(crate) build: f64,
    /// Compiling surface functions, summed over threads. What is compiled while tracing counts
    /// there as well.
    pub(crate) jit: f64,
    pub(crate) trace: f64,
    pub(crate) write: f64,
}

/// How much there was.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Counts {
    pub(crate) functions: usize,
    pub(crate) instructions: usize,
    pub(crate) images: usize,
    pub(crate) pixels: u64,
}

/// Rays of an image, or of all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Rays {
    pub(crate) primary: u64,
    pub(crate) reflected: u64,
    pub(crate) shadow: u64,
    pub(crate) shadow_blocked: u64,
    pub(crate) surface_calls: u64,
}

/// Times and counts of one image.
#[derive(Debug, Serialize)]
pub(crate) struct ImageStats {
    /// None on the standard output.
    pub(crate) file: Option<String>,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) dialect: &'static str,
    pub(crate) max_bounces: u32,
    pub(crate) shapes: usize,
    pub(crate) surfaces: usize,
    pub(crate) lights: usize,
    pub(crate) pixels: u64,
    pub(crate) rays: Rays,
    /// How its pixels are known, with `--certify`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) certainty: Option<Known>,
    pub(crate) build: f64,
    pub(crate) jit: f64,
    pub(crate) trace: f64,
    pub(crate) write: f64,
}

impl From<RayCounts> for Rays {
    fn from(counts: RayCounts) -> Self {
        let RayCounts { primary, reflected, shadow, blocked, surface_calls } = counts;
        Rays { primary, reflected, shadow, shadow_blocked: blocked, surface_calls }
    }
}

impl Stats {
    /// Adds what an image took.
    pub(crate) fn add(&mut self, image: ImageStats) {
        self.phases.build += image.build;
        self.phases.jit += image.jit;
        self.phases.trace += image.trace;
        self.phases.write += image.write;
        self.counts.images += 1;
        self.counts.pixels += image.pixels;
        self.rays.primary += image.rays.primary;
        self.rays.reflected += image.rays.reflected;
        self.rays.shadow += image.rays.shadow;
        self.rays.shadow_blocked += image.rays.shadow_blocked;
        self.rays.surface_calls += image.rays.surface_calls;
        self.images.push(image);
    }

    /// Writes all of it to a file, or to the standard output for `-`.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(crate) fn write(&self, path: &Path, existing: Existing) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self)
            .map_err(|error| Failure::Output(format!("could not write the statistics: {error}")))?;
        if path.as_os_str() == "-" {
            return console::data(|out| writeln!(out, "{text}"));
        }
        let target = Target::path(path.to_owned());
        let written = target.write(existing, &mut |out| writeln!(out, "{text}"));
        written.map_err(|problem| target.failure(problem))
    }

    /// The phases in one line.
    pub(crate) fn phases_line(&self) -> String {
        let Phases { read, compile, run, build, jit, trace, write } = self.phases;
        format!(
            "read {read:.4} s, compile {compile:.4} s, run {run:.4} s, build {build:.4} s, \
             jit {jit:.4} s, trace {trace:.4} s, write {write:.4} s"
        )
    }
}

/// A duration in seconds, to a microsecond.
pub(crate) fn seconds(duration: Duration) -> f64 {
    (duration.as_secs_f64() * 1e6).round() / 1e6
}
