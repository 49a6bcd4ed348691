//! The machine that times are taken on, and the processor time that this process has used.

use std::fs;
use std::time::{Duration, SystemTime};

use rustix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Serialize};

use crate::clean::clean;

/// Facts without which times say little.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Machine {
    pub(crate) cpu: String,
    pub(crate) cores: usize,
    /// How many processes wanted a processor during the last minute, on average; where the system
    /// tells.
    pub(crate) load: Option<f64>,
}

impl Machine {
    /// The machine at this moment.
    pub(crate) fn here() -> Machine {
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

/// The date in UTC, as in 2026-11-29.
pub(crate) fn today() -> String {
    const SECONDS_A_DAY: u64 = 86_400;
    let time = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let (year, month, day) = date(time.as_secs() / SECONDS_A_DAY);
    format!("{year}-{month:02}-{day:02}")
}

/// The date so many days after 1970-01-01 (Hinnant, "chrono-Compatible Low-Level Date Algorithms",
/// `civil_from_days`). Years begin with March, so that leap days end them.
fn date(days: u64) -> (u64, u64, u64) {
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let is_next_year = month >= 10;
    let month = if is_next_year { month - 9 } else { month + 3 };
    (era * 400 + year + u64::from(is_next_year), month, day)
}

/// The time, from any moment on.
pub(crate) fn time() -> Duration {
    clock(ClockId::Monotonic)
}

/// Processor time that this thread has used so far.
pub(crate) fn thread_time() -> Duration {
    clock(ClockId::ThreadCPUTime)
}

/// Processor time that all threads of this process have used so far.
pub(crate) fn process_time() -> Duration {
    clock(ClockId::ProcessCPUTime)
}

fn clock(id: ClockId) -> Duration {
    let time = clock_gettime(id);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec as u32)
}

/// Processor time of all threads of this process, in seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ProcessorTime {
    total: f64,
    system: f64,
}

impl ProcessorTime {
    /// What has been used so far.
    pub(crate) fn now() -> Self {
        let total = process_time().as_secs_f64();
        ProcessorTime { total, system: system_time().unwrap_or(0.0) }
    }

    /// Adds what has been used since `start`; returns how much that is.
    pub(crate) fn add_since(&mut self, start: ProcessorTime) -> f64 {
        let now = ProcessorTime::now();
        self.total += now.total - start.total;
        self.system += now.system - start.system;
        now.total - start.total
    }

    /// Mean user and system time of `n` runs. The system tells its part in steps of 10 ms, which
    /// leave a mean as it is but may make a single run's larger than all of its time.
    pub(crate) fn of_each(self, n: usize) -> (f64, f64) {
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
    fn dates() {
        let table = [
            (0, (1970, 1, 1)),
            (59, (1970, 3, 1)),
            (11_016, (2000, 2, 29)),
            (11_017, (2000, 3, 1)),
            (20_786, (2026, 11, 29)),
            (47_541, (2100, 3, 1)),
        ];
        for (days, expected) in table {
            assert_eq!(date(days), expected, "{days}");
        }
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
