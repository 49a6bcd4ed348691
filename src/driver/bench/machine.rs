//! The machine that times are taken on, and the processor time that this process has used.

use std::fs;

use serde::Serialize;

use crate::clean::clean;
use crate::clock;

/// Facts without which times say little.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Machine {
    pub(super) cpu: String,
    pub(super) cores: usize,
    /// How many processes wanted a processor during the last minute, on average; where the system
    /// tells.
    pub(super) load: Option<f64>,
}

impl Machine {
    /// The machine at this moment.
    pub(super) fn here() -> Machine {
        let cpuinfo = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpuinfo.lines().find_map(|line| {
            let (key, value) = line.split_once(':')?;
            (key.trim() == "model name").then(|| clean(value.trim()).into_owned())
        });
        let load = fs::read_to_string("/proc/loadavg").ok();
        Machine {
            cpu: model.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            load: load.and_then(|text| text.split(' ').next()?.parse().ok()),
        }
    }
}

/// Processor time of all threads of this process, in seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ProcessorTime {
    total: f64,
    system: f64,
}

impl ProcessorTime {
    /// What has been used so far.
    pub(super) fn now() -> Self {
        let total = clock::process_time().as_secs_f64();
        ProcessorTime { total, system: system_time().unwrap_or(0.0) }
    }

    /// Adds what has been used since `start`; returns how much that is.
    pub(super) fn add_since(&mut self, start: ProcessorTime) -> f64 {
        let now = ProcessorTime::now();
        self.total += now.total - start.total;
        self.system += now.system - start.system;
        now.total - start.total
    }

    /// Mean user and system time of `n` runs. The system tells its part in steps of 10 ms, which
    /// leave a mean as it is but may make a single run's larger than all of its time.
    pub(super) fn of_each(self, n: usize) -> (f64, f64) {
        let system = self.system.min(self.total);
        ((self.total - system) / n as f64, system / n as f64)
    }
}

/// Time in the kernel, in seconds; where there is no `/proc`, all time counts as the user's.
fn system_time() -> Option<f64> {
    /// Linux shows processor times in this unit to all programs, on all machines.
    const TICKS_PER_SECOND: f64 = 100.0;
    Some(system_ticks(&fs::read_to_string("/proc/self/stat").ok()?)? / TICKS_PER_SECOND)
}

/// The field `stime`, the 15th.
fn system_ticks(status: &str) -> Option<f64> {
    // The second field, the name of the program, stands in brackets and may hold anything.
    let (_, fields) = status.rsplit_once(')')?;
    fields.split_whitespace().nth(12)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn system_time_is_found_behind_any_name() {
        let status = "71 (a) 1 (b) R 3 4 5 6 7 8 9 10 11 12 250 17 16 17 18 19 20";
        assert_eq!((system_ticks(status), system_ticks("71 (a")), (Some(17.0), None));
    }

    #[test]
    fn work_takes_processor_time() {
        let start = ProcessorTime::now();
        let mut used = ProcessorTime::default();
        let mut sum = 0.0;
        while used.total < 0.02 {
            sum += (0..10_000).map(|i| f64::from(i).sqrt()).sum::<f64>();
            used = ProcessorTime::default();
            used.add_since(start);
        }
        let (user, system) = used.of_each(2);
        assert!(sum > 0.0 && user >= 0.0 && system >= 0.0);
        assert!((user + system - used.total / 2.0).abs() < 1e-12);
        assert!(Machine::here().cores > 0 && !Machine::here().cpu.is_empty());
    }
}
