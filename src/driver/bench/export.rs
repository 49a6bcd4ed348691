//! Results as hyperfine writes them, with details of our own; and reading them again.

use std::collections::HashMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::clean::clean;
use crate::failure::Failure;
use crate::measure::json;
use crate::measure::machine::Machine;
use crate::measure::statistics::{
    Ratio, mean, median, median_absolute_deviation, standard_deviation,
};
use crate::run::stats::{Phases, Rays};

/// One command and its times, in seconds.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Entry {
    pub(super) command: String,
    mean: f64,
    stddev: Option<f64>,
    pub(super) median: f64,
    user: f64,
    system: f64,
    min: f64,
    max: f64,
    pub(super) times: Vec<f64>,
    exit_codes: Vec<i32>,
    /// The median of the absolute deviations from the median.
    pub(super) spread: f64,
    #[serde(rename = "gmlvm")]
    pub(super) details: Details,
}

/// What hyperfine does not tell.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Details {
    Scene(SceneDetails),
    Surface(SurfaceDetails),
}

/// Of a scene that is rendered. Phases are medians, and rates those of tracing.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SceneDetails {
    pub(super) scene: String,
    pub(super) engine: &'static str,
    pub(super) precision: &'static str,
    /// Engine and precision, as the table names them.
    #[serde(skip)]
    pub(super) way: String,
    pub(super) threads: usize,
    pub(super) images: usize,
    pub(super) pixels: u64,
    /// Median of the processor time of all threads.
    pub(super) processor_time: f64,
    pub(super) phases: Phases,
    pub(super) rays: Rays,
    pub(super) rays_per_second: Option<f64>,
    pub(super) surface_calls_per_second: Option<f64>,
    pub(super) ratio_to_first: Option<Compared>,
    pub(super) image_hash: String,
}

/// Of calls of one surface function; times are those of a call, in processor time.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SurfaceDetails {
    /// File, line and column.
    pub(super) surface: String,
    /// Closures that are alike.
    pub(super) closures: usize,
    /// `interp` or `native`.
    pub(super) engine: &'static str,
    /// `native`, `constant` or `declined`.
    pub(super) evaluation: &'static str,
    /// Why it was declined.
    pub(super) reason: Option<String>,
    /// Points at which it is timed.
    pub(super) points: usize,
    /// Points at which the function fails, and which are not timed.
    pub(super) failing_points: usize,
    pub(super) code_bytes: Option<usize>,
    pub(super) uniforms: Option<u32>,
    /// Seconds from bytecode to SSA.
    pub(super) specialize: f64,
    /// Seconds from SSA to machine code.
    pub(super) generate: f64,
    pub(super) ratio_to_first: Option<Compared>,
}

/// A ratio of times, and what it says.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Compared {
    pub(super) ratio: f64,
    pub(super) interval: Option<[f64; 2]>,
    pub(super) verdict: &'static str,
}

impl From<Ratio> for Compared {
    fn from(ratio: Ratio) -> Self {
        Compared {
            ratio: ratio.estimate,
            interval: ratio.interval,
            verdict: ratio.verdict().words(),
        }
    }
}

impl Entry {
    /// The figures that follow from the times.
    pub(super) fn new(
        command: String,
        times: Vec<f64>,
        (user, system): (f64, f64),
        details: Details,
    ) -> Entry {
        Entry {
            command,
            mean: mean(&times),
            stddev: standard_deviation(&times),
            median: median(&times),
            user,
            system,
            min: times.iter().copied().fold(f64::INFINITY, f64::min),
            max: times.iter().copied().fold(0.0, f64::max),
            exit_codes: vec![0; times.len()],
            spread: median_absolute_deviation(&times),
            times,
            details,
        }
    }
}

#[derive(Serialize)]
struct Results<'e> {
    results: &'e [Entry],
    gmlvm: About<'e>,
}

#[derive(Serialize)]
struct About<'e> {
    version: &'static str,
    machine: &'e Machine,
}

/// Writes results to a file, or to the standard output for `-`.
///
/// # Errors
/// When it cannot be done.
pub(super) fn write(path: &Path, machine: &Machine, entries: &[Entry]) -> Result<(), Failure> {
    let about = About { version: env!("CARGO_PKG_VERSION"), machine };
    json::write(path, &Results { results: entries, gmlvm: about })
}

/// Results of another day.
#[derive(Debug, Deserialize)]
pub(super) struct Old {
    #[serde(skip)]
    pub(super) name: String,
    results: Vec<OldEntry>,
    gmlvm: Option<OldAbout>,
}

#[derive(Debug, Deserialize)]
pub(super) struct OldEntry {
    command: String,
    times: Times,
    gmlvm: Option<OldDetails>,
}

#[derive(Debug, Deserialize)]
struct OldDetails {
    image_hash: Option<String>,
}

#[derive(Debug, Deserialize)]
struct OldAbout {
    machine: OldMachine,
}

#[derive(Debug, Deserialize)]
struct OldMachine {
    cpu: String,
    cores: usize,
}

/// Times that can be compared.
#[derive(Debug, Deserialize)]
#[serde(try_from = "Vec<f64>")]
struct Times(Vec<f64>);

impl TryFrom<Vec<f64>> for Times {
    type Error = &'static str;

    fn try_from(times: Vec<f64>) -> Result<Self, Self::Error> {
        if times.is_empty() {
            Err("expected at least one time")
        } else if times.iter().all(|time| time.is_finite() && *time > 0.0) {
            Ok(Times(times))
        } else {
            Err("expected times above zero")
        }
    }
}

impl Old {
    /// Reads a file of results.
    ///
    /// # Errors
    /// Says what is wrong, and where.
    pub(super) fn read(path: &Path) -> Result<Old, Failure> {
        let name = clean(&path.display().to_string()).into_owned();
        let old: Old = json::read(path, "results of a benchmark")?;
        Ok(Old { name, ..old })
    }

    /// The entries by their commands; of equal ones the first.
    pub(super) fn by_command(&self) -> HashMap<&str, &OldEntry> {
        self.results.iter().rev().map(|entry| (entry.command.as_str(), entry)).collect()
    }

    /// Whether it is known to come from another machine.
    pub(super) fn is_from_elsewhere(&self, here: &Machine) -> bool {
        self.gmlvm
            .as_ref()
            .is_some_and(|about| about.machine.cpu != here.cpu || about.machine.cores != here.cores)
    }
}

impl OldEntry {
    pub(super) fn times(&self) -> &[f64] {
        &self.times.0
    }

    /// Whether the images are known to be others.
    pub(super) fn has_other_images(&self, new: &Entry) -> bool {
        let old = self.gmlvm.as_ref().and_then(|details| details.image_hash.as_deref());
        match &new.details {
            Details::Scene(details) => old.is_some_and(|hash| hash != details.image_hash),
            Details::Surface(_) => false,
        }
    }
}
