//! Surface functions interpreted and as machine code, in nanoseconds of processor time a call, beside
//! the same functions in Rust and, where installed, in Lua; and the interpreter on a counting loop.
//!
//! All contenders for one function take turns within one run, so that whatever else the machine does
//! falls on all of them alike: the ratios mean more than the times. Interpreter, machine code and
//! Rust must give the same bits. Lua counts in radians and must give the same sum up to rounding; it
//! has a loop where GML has recursion. Machine code is called as the renderer calls it.
//!
//! A line has median and least time, and the median ratio to Rust's time in the same round. The line
//! `batch` is about asking at many points at once, where the renderer would do so. The line `bounded`
//! is about machine code that gives bounds besides, for points known up to 1e-15. The lines
//! `specialize`, `generate` and `bound` are about compiling the function once: from bytecode to SSA,
//! from there to machine code, and to machine code with bounds. Names on the command line select
//! functions. Without `--bench`, which cargo gives, all is checked but nothing timed.

use std::hint::black_box;
use std::slice;

use jit::shaders::{Evaluation, Shaders, Tiering};
use renderer::surface::{MAX_BATCH, SurfaceEval, SurfaceId, SurfacePoint};
use vm::surfaces::InterpSurfaces;

use crate::gml::{LIMITS, call, call_bounded, numbers};
use crate::race::{Contender, Times, race};
use crate::twins::{Answer, Twin};

mod gml;
mod race;
mod twins;

/// Points along each side of the grid on which a surface function is called.
const GRID: u32 = 64;
const ROUNDS: usize = 25;

/// Operators that one iteration of the counting loop evaluates, and its iterations.
const COUNT_OPERATORS: f64 = 4.0 * 2e6;

/// A surface function and its twin in Rust.
struct Function {
    name: &'static str,
    /// Of a kernel, which is there in Lua too, or a scene.
    file: &'static str,
    /// The name in the program; a kernel leaves its only function.
    binding: Option<&'static str>,
    n_faces: u8,
    /// Where u and v begin and end. Planes have more than the unit square.
    domain: [f64; 2],
    twin: Twin,
}

const fn kernel(name: &'static str, file: &'static str, twin: Twin) -> Function {
    Function { name, file, binding: None, n_faces: 1, domain: [0.0, 1.0], twin }
}

const fn scene(
    name: &'static str,
    file: &'static str,
    binding: &'static str,
    domain: [f64; 2],
    twin: Twin,
) -> Function {
    Function { name, file, binding: Some(binding), n_faces: 1, domain, twin }
}

const UNIT: [f64; 2] = [0.0, 1.0];
const PLANE: [f64; 2] = [-4.0, 4.0];

const FUNCTIONS: [Function; 15] = [
    kernel("empty", "benches/kernels/empty.gml", twins::empty),
    kernel("checker", "benches/kernels/checker.gml", twins::checker),
    kernel("marble", "benches/kernels/marble.gml", twins::marble),
    kernel("mandelbrot", "benches/kernels/mandelbrot.gml", twins::mandelbrot),
    Function {
        n_faces: 6,
        ..scene(
            "faces/chart",
            "scenes/texture-faces.gml",
            "chart",
            UNIT,
            twins::texture_faces_chart,
        )
    },
    scene("faces/plan", "scenes/texture-faces.gml", "plan", PLANE, twins::texture_faces_plan),
    scene("showpiece/copper", "scenes/showpiece.gml", "copper", UNIT, twins::showpiece_copper),
    scene("showpiece/leaves", "scenes/showpiece.gml", "leaves", UNIT, twins::showpiece_leaves),
    scene("showpiece/water", "scenes/showpiece.gml", "water", PLANE, twins::showpiece_water),
    scene("kaleidoscope/opal", "scenes/kaleidoscope.gml", "opal", PLANE, twins::kaleidoscope_opal),
    scene(
        "carpet/fractal",
        "scenes/mandelbrot.gml",
        "fractal",
        [-1.6, 0.8],
        twins::mandelbrot_fractal,
    ),
    scene("dominoes/planks", "scenes/dominoes.gml", "planks", PLANE, twins::dominoes_planks),
    scene("flake/sky", "scenes/flake.gml", "sky", UNIT, twins::flake_sky),
    scene("gears/plate", "scenes/csg-gears.gml", "plate", UNIT, twins::csg_gears_plate),
    scene("marble/tiles", "scenes/marble.gml", "tiles", PLANE, twins::marble_tiles),
];

fn main() {
    let (options, names): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|arg| arg.starts_with('-'));
    let n_rounds = if options.iter().any(|option| option == "--bench") { ROUNDS } else { 0 };
    let is_wanted = |name: &str| names.is_empty() || names.iter().any(|wanted| wanted == name);
    println!(
        "{:<18} {:<12} {:>10} {:>10} {:>8}",
        "function", "engine", "median ns", "min ns", "of rust"
    );
    for function in FUNCTIONS.iter().filter(|function| is_wanted(function.name)) {
        bench_function(function, n_rounds);
    }
    if is_wanted("count") {
        bench_count(n_rounds);
    }
}

fn bench_function(function: &Function, n_rounds: usize) {
    let ran = gml::run(function.file);
    let closures = slice::from_ref(ran.function(function.binding));
    let mut interpreter = InterpSurfaces::new(&ran.program, closures, LIMITS);
    let compiled = || Shaders::new(&ran.program, closures, LIMITS, Tiering::Eager);
    let shaders = compiled();
    let evaluation = &shaders.report()[0].evaluation;
    assert!(
        matches!(evaluation, Evaluation::Native { .. }),
        "{} is not compiled: {evaluation:?}",
        function.name
    );
    let mut native = shaders.worker();
    let mut bounding = shaders.worker();
    let mut batching = shaders.worker();
    let expected = function.sum_over_grid(|face, u, v| {
        let expected = (function.twin)(face, u, v);
        let others = [call(&mut interpreter, face, u, v), call(&mut native, face, u, v)];
        assert_eq!(
            others.map(|answer| answer.map(f64::to_bits)),
            [expected.map(f64::to_bits); 2],
            "{} at face {face}, u {u}, v {v}: {others:?}, in Rust {expected:?}",
            function.name
        );
        expected
    });
    let mut contenders = vec![
        Contender::new("interp", || {
            function.sum_over_grid(|face, u, v| call(&mut interpreter, face, u, v))
        }),
        Contender::new("native", || {
            function.sum_over_grid(|face, u, v| call(&mut native, face, u, v))
        }),
        Contender::new("bounded", || {
            function.sum_over_grid(|face, u, v| call_bounded(&mut bounding, face, u, v))
        }),
        Contender::new("rust", || function.sum_over_grid(black_box(function.twin))),
    ];
    if batching.batch_needs(SurfaceId(0)).is_some() {
        contenders.insert(2, Contender::new("batch", || function.sum_over_rows(&mut batching)));
    }
    if function.binding.is_none() {
        contenders.extend(Contender::in_lua(function.name, GRID));
    }
    for contender in &mut contenders {
        let sum = contender.sum();
        assert!((sum / expected - 1.0).abs() < 1e-9, "{} differs: {sum}", contender.name);
    }
    report(function.name, f64::from(GRID * GRID), &race(contenders, n_rounds));
    let times: Vec<_> = (0..n_rounds)
        .map(|_| {
            let shaders = compiled();
            let plain = shaders.times();
            // The bounded version is made when it is first asked for.
            call_bounded(&mut shaders.worker(), 0, 0.3, 0.7);
            [plain.specialize, plain.generate, shaders.times().generate - plain.generate]
        })
        .collect();
    let times = ["specialize", "generate", "bound"].into_iter().enumerate().map(|(part, name)| {
        let rounds = times.iter().map(|parts| parts[part].as_nanos() as f64);
        Times { name, rounds: rounds.collect() }
    });
    let times: Vec<_> = times.collect();
    report(function.name, 1.0, &times);
}

fn bench_count(n_rounds: usize) {
    let count = || {
        gml::run("benches/kernels/count.gml");
        0.0
    };
    let mut contenders = vec![Contender::new("interp", count)];
    contenders.extend(Contender::in_lua("count", 0));
    report("count", COUNT_OPERATORS, &race(contenders, n_rounds));
}

impl Function {
    /// The same sum by an evaluator that is asked at the points of a row at once.
    fn sum_over_rows<E: SurfaceEval>(&self, surfaces: &mut E) -> f64 {
        let (mut points, mut samples) = (Vec::new(), Vec::new());
        let mut sum = 0.0;
        self.sum_over_grid(|face, u, v| {
            points.push(SurfacePoint { face, u, v });
            if points.len() == MAX_BATCH {
                surfaces.eval_batch(SurfaceId(0), &points, &mut samples);
                for sample in samples.drain(..).flatten() {
                    sum += numbers(&sample).iter().sum::<f64>();
                }
                points.clear();
            }
            [0.0; 6]
        });
        sum
    }

    /// The sum of all answers on the grid; faces change from row to row.
    fn sum_over_grid(&self, mut surface: impl FnMut(u8, f64, f64) -> Answer) -> f64 {
        let [begin, end] = self.domain;
        let step = (end - begin) / f64::from(GRID);
        let coordinate = |idx: u32| (f64::from(idx) + 0.5) * step + begin;
        let mut sum = 0.0;
        for row in 0..GRID {
            let face = (row % u32::from(self.n_faces)) as u8;
            let v = coordinate(row);
            for column in 0..GRID {
                sum += surface(face, coordinate(column), v).iter().sum::<f64>();
            }
        }
        sum
    }
}

/// Prints a line for each contender, of so many calls or operators a pass.
fn report(function: &str, n_units: f64, results: &[Times]) {
    let rust = results.iter().find(|times| times.name == "rust");
    for Times { name, rounds } in results.iter().filter(|times| !times.rounds.is_empty()) {
        let least = rounds.iter().copied().fold(f64::INFINITY, f64::min);
        let ratio = rust.map(|rust| {
            let ratios = rounds.iter().zip(&rust.rounds).map(|(time, rust)| time / rust);
            format!("{:.3}", median(ratios.collect()))
        });
        println!(
            "{function:<18} {name:<12} {:>10.2} {:>10.2} {:>8}",
            median(rounds.clone()) / n_units,
            least / n_units,
            ratio.unwrap_or("-".to_owned()),
        );
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
