//! Who runs when: all in turn, round by round.

use std::time::{Duration, Instant};

use crate::run::progress::{self, Bar};

/// When the rounds of one scene end if no time is given for them.
const MAX_ROUNDS: u32 = 100_000;

/// How many rounds there are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounds {
    warmup: u32,
    runs: u32,
    time: Option<Duration>,
}

impl Rounds {
    /// So many after `warmup` that do not count; with a time, as many as begin in it instead.
    pub(crate) fn new(warmup: u32, runs: u32, time: Option<Duration>) -> Self {
        let runs = if time.is_some() { MAX_ROUNDS } else { runs };
        Rounds { warmup, runs, time }
    }

    /// A bar that shows how far they are.
    pub(crate) fn bar(self, name: &str, n_contenders: usize, is_quiet: bool) -> Bar {
        let n_rounds = u64::from(self.warmup) + u64::from(self.runs);
        let length = self.time.is_none().then_some(n_rounds * n_contenders as u64);
        progress::run_bar(name, length, is_quiet)
    }

    /// In each round lets each of `n` contenders run once. The one who begins moves on from round to
    /// round. `run` gets a contender's number and whether the round counts.
    ///
    /// # Errors
    /// The first of `run`, which ends all.
    pub(crate) fn each<E>(
        self,
        n: usize,
        mut run: impl FnMut(usize, bool) -> Result<(), E>,
    ) -> Result<(), E> {
        let turns = |round: u32| (0..n).map(move |turn| (turn + round as usize) % n);
        for round in 0..self.warmup {
            turns(round).try_for_each(|contender| run(contender, false))?;
        }
        let start = Instant::now();
        for round in 0..self.runs {
            turns(round).try_for_each(|contender| run(contender, true))?;
            if self.time.is_some_and(|time| start.elapsed() >= time) {
                break;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_run_in_every_round_and_each_begins_in_turn() {
        let rounds = Rounds { warmup: 1, runs: 4, time: None };
        let mut log = Vec::new();
        let done: Result<(), ()> = rounds.each(3, |contender, counts| {
            log.push((contender, counts));
            Ok(())
        });
        assert_eq!(done, Ok(()));
        let order: Vec<_> = log.iter().map(|(contender, _)| *contender).collect();
        assert_eq!(order, [0, 1, 2, 0, 1, 2, 1, 2, 0, 2, 0, 1, 0, 1, 2]);
        assert!(log.iter().enumerate().all(|(at, (_, counts))| *counts == (at >= 3)));
    }

    #[test]
    fn a_round_is_run_to_its_end_and_a_failure_ends_all() {
        let rounds = Rounds { warmup: 0, runs: 9, time: Some(Duration::from_nanos(1)) };
        let mut n_runs = 0;
        let mut run = |contender, _| {
            n_runs += 1;
            if n_runs > 5 { Err(contender) } else { Ok(()) }
        };
        assert_eq!(rounds.each(4, &mut run), Ok(()));
        assert_eq!(rounds.each(4, &mut run), Err(1));
        assert_eq!(n_runs, 6);
    }
}
