//! Contenders that take turns, and their times.

use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

use rustix::time::{ClockId, clock_gettime};

/// Passes are repeated until one sample takes this long.
const SAMPLE_TIME: Duration = Duration::from_millis(15);

const LUA: [(&str, &[&str]); 3] =
    [("lua5.4", &["lua5.4"]), ("luajit-joff", &["luajit", "-joff"]), ("luajit", &["luajit"])];

/// One implementation of a kernel.
pub(crate) struct Contender<'a> {
    pub(crate) name: &'static str,
    /// So many passes: the sum of all answers, or nothing of interest, and the processor time.
    passes: Box<dyn FnMut(u64) -> (f64, Duration) + 'a>,
}

impl<'a> Contender<'a> {
    pub(crate) fn new(name: &'static str, mut pass: impl FnMut() -> f64 + 'a) -> Self {
        let passes = move |n| {
            let start = thread_time();
            let sum = (0..n).map(|_| black_box(pass())).sum();
            (sum, thread_time().saturating_sub(start))
        };
        Contender { name, passes: Box::new(passes) }
    }

    /// The Lua interpreters that are installed; says which are not.
    pub(crate) fn in_lua(kernel: &str, grid: u32) -> impl Iterator<Item = Self> {
        LUA.iter().filter_map(move |(name, command)| {
            let Some(mut lua) = Lua::start(command, kernel, grid) else {
                eprintln!("{kernel}: {name} is not installed");
                return None;
            };
            Some(Contender { name, passes: Box::new(move |n| lua.passes(n)) })
        })
    }

    /// The sum of one pass.
    pub(crate) fn sum(&mut self) -> f64 {
        (self.passes)(1).0
    }

    /// Nanoseconds a pass.
    fn time(&mut self, n_passes: u64) -> f64 {
        (self.passes)(n_passes).1.as_nanos() as f64 / n_passes as f64
    }

    /// So many passes that timing them is accurate; doubling warms up what needs it.
    fn passes_of_a_sample(&mut self) -> u64 {
        let mut n_passes = 1;
        while (self.passes)(n_passes).1 < SAMPLE_TIME {
            n_passes *= 2;
        }
        n_passes
    }
}

/// Processor time of this thread.
fn thread_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec as u32)
}

/// A Lua process that runs passes on demand.
struct Lua {
    process: Child,
    requests: ChildStdin,
    replies: BufReader<ChildStdout>,
}

impl Lua {
    /// None if the interpreter is not installed.
    fn start(command: &[&str], kernel: &str, grid: u32) -> Option<Lua> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/kernels");
        let mut process = Command::new(command[0])
            .args(&command[1..])
            .arg(format!("{folder}/driver.lua"))
            .arg(format!("{folder}/{kernel}.lua"))
            .arg(grid.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .ok()?;
        let requests = process.stdin.take().expect("asked for");
        let replies = BufReader::new(process.stdout.take().expect("asked for"));
        Some(Lua { process, requests, replies })
    }

    fn passes(&mut self, n: u64) -> (f64, Duration) {
        writeln!(self.requests, "{n}").expect("Lua listens");
        let mut reply = String::new();
        self.replies.read_line(&mut reply).expect("Lua answers");
        let (sum, seconds) = reply.trim().split_once(' ').expect("a sum and a time");
        let seconds = seconds.parse().expect("a number");
        (sum.parse().expect("a number"), Duration::from_secs_f64(seconds))
    }
}

impl Drop for Lua {
    fn drop(&mut self) {
        // It may have ended by itself, after an error that it has reported.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Nanoseconds of each sample, round by round.
pub(crate) struct Times {
    pub(crate) name: &'static str,
    pub(crate) rounds: Vec<f64>,
}

/// Times all contenders in turn, in nanoseconds a pass. Who begins moves on from round to round.
pub(crate) fn race(mut contenders: Vec<Contender<'_>>, n_rounds: usize) -> Vec<Times> {
    let n_passes: Vec<u64> = contenders.iter_mut().map(Contender::passes_of_a_sample).collect();
    let mut times: Vec<_> =
        contenders.iter().map(|c| Times { name: c.name, rounds: Vec::new() }).collect();
    for round in 0..n_rounds {
        for turn in 0..contenders.len() {
            let index = (round + turn) % contenders.len();
            times[index].rounds.push(contenders[index].time(n_passes[index]));
        }
    }
    times
}
