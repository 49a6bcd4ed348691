//! The interpreter on three surface functions, in nanoseconds a call, beside the same functions in
//! Rust and, where installed, in Lua; and on a counting loop.
//!
//! All contenders for one kernel take turns within one run, so that whatever else the machine does
//! falls on all of them alike: the ratios mean more than the times. Rust must give the same bits as
//! the interpreter. Lua counts in radians and must give the same sum up to rounding; it has a loop
//! where GML has recursion. Names of kernels on the command line select those. Without `--bench`,
//! which cargo gives, all is checked but nothing timed.

use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use compiler::diagnostic::Diagnostic;
use compiler::preprocess::NoIncludes;
use compiler::source::SourceMap;
use compiler::{degrees, scalar};
use renderer::surface::{SurfaceEval, SurfaceId, SurfacePoint, SurfaceSample};
use vm::host::{Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;
use vm::surfaces::InterpSurfaces;
use vm::value::Value;

/// Points along each side of the grid on which a surface function is called.
const GRID: u32 = 64;
const REPEATS: usize = 25;
/// Passes are repeated until one sample takes this long.
const SAMPLE_TIME: Duration = Duration::from_millis(15);

const LIMITS: Limits = Limits { fuel: u64::MAX, max_depth: 10_000, max_memory: 1 << 30 };
/// Operators that one iteration of the counting loop evaluates, and its iterations.
const COUNT_OPERATORS: f64 = 4.0 * 2e6;

const LUA: [(&str, &[&str]); 3] =
    [("lua5.4", &["lua5.4"]), ("luajit -joff", &["luajit", "-joff"]), ("luajit", &["luajit"])];

/// What a surface function leaves: red, green, blue, kd, ks, n.
type Answer = [f64; 6];

struct Kernel {
    name: &'static str,
    gml: &'static str,
    twin: fn(f64, f64) -> Answer,
}

const KERNELS: [Kernel; 3] = [
    Kernel { name: "checker", gml: include_str!("kernels/checker.gml"), twin: checker },
    Kernel { name: "marble", gml: include_str!("kernels/marble.gml"), twin: marble },
    Kernel { name: "mandelbrot", gml: include_str!("kernels/mandelbrot.gml"), twin: mandelbrot },
];

fn main() {
    let (options, names): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|arg| arg.starts_with('-'));
    let repeats = if options.iter().any(|option| option == "--bench") { REPEATS } else { 0 };
    let is_wanted = |name: &str| names.is_empty() || names.iter().any(|wanted| wanted == name);
    println!("kernel       engine          median ns     min ns");
    for kernel in KERNELS.iter().filter(|kernel| is_wanted(kernel.name)) {
        bench_surface(kernel, repeats);
    }
    if is_wanted("count") {
        bench_count(repeats);
    }
}

fn bench_surface(kernel: &Kernel, repeats: usize) {
    let (program, stack) = run(kernel.gml);
    let [Value::Closure(surface)] = &stack[..] else { panic!("a kernel leaves one function") };
    let mut surfaces = InterpSurfaces::new(&program, std::slice::from_ref(surface), LIMITS);
    let expected = assert_same_bits(&mut surfaces, kernel);
    let mut contenders = vec![
        Contender::new("gmlvm", move || sum_over_grid(|u, v| answer(call(&mut surfaces, u, v)))),
        Contender::new("rust", || sum_over_grid(black_box(kernel.twin))),
    ];
    contenders.extend(Contender::in_lua(kernel.name, GRID));
    for contender in &mut contenders {
        let sum = contender.run(1);
        assert!((sum / expected - 1.0).abs() < 1e-9, "{} differs: {sum}", contender.name);
    }
    let n_calls = f64::from(GRID * GRID);
    report(kernel.name, "calls", n_calls, &race(contenders, repeats));
}

fn bench_count(repeats: usize) {
    let count = || {
        run(include_str!("kernels/count.gml"));
        0.0
    };
    let mut contenders = vec![Contender::new("gmlvm", count)];
    contenders.extend(Contender::in_lua("count", 0));
    report("count", "operators", COUNT_OPERATORS, &race(contenders, repeats));
}

// Running GML.

struct NoRender;

impl Host for NoRender {
    fn render(&mut self, _: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        unreachable!("kernels render nothing")
    }
}

/// A program and the stack it leaves.
fn run(gml: &str) -> (Arc<LoadedProgram>, Vec<Value>) {
    let mut sources = SourceMap::default();
    let file = sources.add("kernel.gml", gml.as_bytes().to_vec()).expect("short");
    let bytecode = compiler::compile(&mut sources, file, &mut NoIncludes, &[]).expect("correct");
    let program = Arc::new(LoadedProgram::new(bytecode));
    let stack = match Machine::new(&program, LIMITS).run(&mut NoRender) {
        Ok(stack) => stack,
        Err(error) => panic!("{}", error.into_diagnostic().message),
    };
    (program, stack)
}

fn call(surfaces: &mut InterpSurfaces<'_>, u: f64, v: f64) -> SurfaceSample {
    match surfaces.eval(SurfaceId(0), &SurfacePoint { face: 0, u, v }) {
        Ok(sample) => sample,
        Err(error) => panic!("{}", error.into_diagnostic().message),
    }
}

fn answer(sample: SurfaceSample) -> Answer {
    let [red, green, blue] = sample.color.to_array();
    [red, green, blue, sample.kd, sample.ks, sample.phong_exp]
}

/// Compares interpreter and twin on the whole grid; returns the sum of all answers.
fn assert_same_bits(surfaces: &mut InterpSurfaces<'_>, kernel: &Kernel) -> f64 {
    sum_over_grid(|u, v| {
        let got = answer(call(surfaces, u, v));
        let expected = (kernel.twin)(u, v);
        assert_eq!(
            got.map(f64::to_bits),
            expected.map(f64::to_bits),
            "{} at ({u}, {v}): {got:?}, in Rust {expected:?}",
            kernel.name
        );
        got
    })
}

fn sum_over_grid(mut surface: impl FnMut(f64, f64) -> Answer) -> f64 {
    let coordinate = |idx: u32| (f64::from(idx) + 0.5) / f64::from(GRID);
    let mut sum = 0.0;
    for row in 0..GRID {
        let v = coordinate(row);
        for column in 0..GRID {
            sum += surface(coordinate(column), v).iter().sum::<f64>();
        }
    }
    sum
}

// The kernels in Rust, operation by operation.

fn checker(u: f64, v: f64) -> Answer {
    const LIGHT: [f64; 3] = [0.9, 0.8, 0.6];
    const DARK: [f64; 3] = [0.2, 0.1, 0.1];
    static TILES: [[[f64; 3]; 3]; 3] =
        [[LIGHT, DARK, LIGHT], [DARK, LIGHT, DARK], [LIGHT, DARK, LIGHT]];
    let third = |x: f64| scalar::floor(x * 3.0).expect("small") as usize;
    let [red, green, blue] = TILES[third(v)][third(u)];
    [red, green, blue, 0.8, 0.2, 6.0]
}

fn marble(u: f64, v: f64) -> Answer {
    let (x, y) = (u * 6.0, v * 4.0);
    let coarse = degrees::sin(x * 67.0 + y * 31.0);
    let fine = degrees::cos(y * 113.0 - x * 47.0 + coarse * 40.0);
    let wave = degrees::sin((x + y) * 90.0 + coarse * 75.0 + fine * 25.0);
    let calm = 1.0 - wave * wave;
    let square = calm * calm;
    let vein = square * square;
    let cloud = degrees::cos((x - y) * 130.0 + fine * 60.0) * 0.5 + 0.5;
    let soft = cloud * cloud * (3.0 - cloud * 2.0);
    let t = (vein * 0.7 + soft * 0.3).clamp(0.0, 1.0);
    let rest = 1.0 - t;
    [
        t * 0.92 + rest * 0.20,
        t * 0.88 + rest * 0.16,
        t * 0.80 + rest * 0.24,
        t * 0.35 + 0.55,
        0.45 - t * 0.25,
        t * 18.0 + 6.0,
    ]
}

fn mandelbrot(u: f64, v: f64) -> Answer {
    let (cr, ci) = (u * 3.0 - 2.2, v * 2.4 - 1.2);
    let (mut re, mut im, mut n) = (0.0, 0.0, 0);
    while n < 30 {
        let (rr, ii) = (re * re, im * im);
        if rr + ii >= 4.0 {
            break;
        }
        (re, im) = (rr - ii + cr, re * im * 2.0 + ci);
        n += 1;
    }
    let t = f64::from(n) / 30.0;
    [t, t * t, 1.0 - t, 0.9, 0.1, 10.0]
}

// Timing.

/// One implementation of a kernel. A pass gives the sum of all answers, or nothing of interest.
struct Contender<'a> {
    name: &'static str,
    passes: Box<dyn FnMut(u64) -> f64 + 'a>,
}

impl<'a> Contender<'a> {
    fn new(name: &'static str, mut pass: impl FnMut() -> f64 + 'a) -> Self {
        let passes = move |n| (0..n).map(|_| black_box(pass())).sum();
        Contender { name, passes: Box::new(passes) }
    }

    /// The Lua interpreters that are installed.
    fn in_lua(kernel: &str, grid: u32) -> impl Iterator<Item = Self> {
        LUA.iter().filter_map(move |(name, command)| {
            let mut lua = Lua::start(command, kernel, grid)?;
            Some(Contender { name, passes: Box::new(move |n| lua.passes(n)) })
        })
    }

    fn run(&mut self, n_passes: u64) -> f64 {
        (self.passes)(n_passes)
    }

    fn time(&mut self, n_passes: u64) -> Duration {
        let start = Instant::now();
        self.run(n_passes);
        start.elapsed()
    }
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

    /// The mean result of some passes.
    fn passes(&mut self, n: u64) -> f64 {
        writeln!(self.requests, "{n}").expect("Lua listens");
        let mut reply = String::new();
        self.replies.read_line(&mut reply).expect("Lua answers");
        reply.trim().parse().expect("a number")
    }
}

impl Drop for Lua {
    fn drop(&mut self) {
        // It may have ended by itself, after an error that it has reported.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The times of one pass, sorted.
type Times = Vec<f64>;

/// Times all contenders in turn, in nanoseconds a pass.
fn race(mut contenders: Vec<Contender<'_>>, repeats: usize) -> Vec<(&'static str, Times)> {
    let n_passes: Vec<u64> = contenders.iter_mut().map(passes_of_a_sample).collect();
    let mut times = vec![Times::new(); contenders.len()];
    for _ in 0..repeats {
        for ((contender, &n_passes), times) in contenders.iter_mut().zip(&n_passes).zip(&mut times)
        {
            times.push(contender.time(n_passes).as_nanos() as f64 / n_passes as f64);
        }
    }
    for times in &mut times {
        times.sort_by(f64::total_cmp);
    }
    contenders.iter().map(|contender| contender.name).zip(times).collect()
}

/// So many passes that timing them is accurate; doubling warms up what needs it.
fn passes_of_a_sample(contender: &mut Contender<'_>) -> u64 {
    let mut n_passes = 1;
    while contender.time(n_passes) < SAMPLE_TIME {
        n_passes *= 2;
    }
    n_passes
}

/// Prints a line for each contender. The first is the one that the ratios are about.
fn report(kernel: &str, unit: &str, n_units: f64, results: &[(&str, Times)]) {
    let Some(ours) = results[0].1.get(results[0].1.len() / 2) else { return };
    for (name, times) in results {
        let median = times[times.len() / 2];
        println!(
            "{kernel:<12} {name:<14} {:>10.2} {:>10.2} {:>8.2} x gmlvm {:>8.1} M {unit}/s",
            median / n_units,
            times[0] / n_units,
            median / ours,
            1e3 * n_units / median,
        );
    }
}
