//! Bounded shaders enclose what surface functions give, and answer where they can.
//!
//! `GMLVM_FUZZ_PROGRAMS` sets how many random programs, `GMLVM_FUZZ_SEED` where to start.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use compiler::source::SourceMap;
use renderer::surface::{Bounded, BoundedPoint, SurfacePoint};
use support::beside::Beside;
use support::enclosure::{Tally, check_function, check_program};
use support::generator::{LIMITS, Random, points, program};
use vm::host::{Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;
use vm::surfaces;
use vm::value::{Closure, Value};

#[allow(dead_code, unreachable_pub, reason = "shared with the fuzz targets, where it is public")]
mod support {
    pub(crate) mod agreement;
    pub(crate) mod beside;
    pub(crate) mod enclosure;
    pub(crate) mod generator;
}

/// Limits for expressions.
const FEW: Limits = Limits { fuel: 1000, max_depth: 10, max_memory: 1 << 30 };

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// The point with radii from 1e-16 to 1e-3; now and then a coordinate is exact. Two in three are moved
/// off the lattice of the generator's points, on which decisions are close.
fn around(at: SurfacePoint, k: usize) -> BoundedPoint {
    let radius = |k: usize| if k % 16 == 15 { 0.0 } else { 10f64.powi(-16 + (k % 14) as i32) };
    let coordinate = |x: f64| if k.is_multiple_of(3) { x } else { 0.1 + 0.731_058_5 * x };
    BoundedPoint {
        face: at.face,
        u: Bounded { value: coordinate(at.u), error: radius(k) },
        v: Bounded { value: coordinate(at.v), error: radius(k.wrapping_mul(7) / 16) },
    }
}

#[test]
fn random_functions_stay_within_bounds() {
    let first = number("GMLVM_FUZZ_SEED", 1);
    let n_programs = number("GMLVM_FUZZ_PROGRAMS", 1000);
    let mut tally = Tally::default();
    let mut n_native = 0;
    for seed in first..first + n_programs {
        let text = program(&mut Random::new(seed));
        let points = points(&mut Random::new(!seed)).into_iter().enumerate();
        let points = points.map(|(k, at)| around(at, seed as usize * 5 + k));
        n_native += u64::from(check_program(&text, LIMITS, points, 4, &mut tally) == Some(true));
    }
    let (part, tightness) = (tally.part_answered(), tally.median_tightness());
    println!(
        "{n_native} native, {} requests, {part:.3} answered, {} calls, bounds {tightness:.2} wide",
        tally.asked, tally.calls
    );
    assert!(n_native * 2 > n_programs && part > 0.5, "{part} of {} answered", tally.asked);
}

/// Positive numbers from a range, evenly by their logarithms.
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    fn at(&self, part: f64) -> f64 {
        (self.low.ln() + (self.high.ln() - self.low.ln()) * part).exp()
    }
}

/// All sizes of doubles.
const ALL: Range = Range { low: 1e-320, high: 1e308 };
const USUAL: Range = Range { low: 1e-6, high: 1e3 };
/// Where neither sine nor cosine is flat.
const DEGREES: Range = Range { low: 20.0, high: 1e3 };
const UNIT: Range = Range { low: 1e-9, high: 1.0 };

/// Asks for bounds of an expression of u and v at `n` points in a range, of either sign, with relative
/// radii from less than a unit in the last place to 2^-12: at first all doubles within are tried.
fn check_expression(expression: &str, range: &Range, n: u32) -> Tally {
    let points = (0..n).map(|k| {
        // Multiples of irrational numbers, modulo 1, are spread evenly (Weyl).
        let part = |factor: f64| (f64::from(k) * factor).fract();
        let coordinate = |part: f64, bits: u32| {
            let sign = if bits & 1 == 0 { 1.0 } else { -1.0 };
            let value = sign * range.at(part);
            Bounded { value, error: value.abs() * 2f64.powi(-53 + (bits / 2 % 42) as i32) * 1.5 }
        };
        let u = coordinate(part(0.618_033_988_7), k);
        let v = coordinate(part(0.414_213_562_4), k / 3);
        [u, v]
    });
    let mut tally = check_at(expression, &points.collect::<Vec<_>>());
    let tightness = tally.median_tightness();
    println!("{expression}: {:.3} answered, {tightness:.2} wide", tally.part_answered());
    tally
}

#[test]
fn each_operator_stays_within_bounds() {
    // How much is answered at least, and how wide bounds are at most. Of functions of two numbers, the
    // farthest corner is seldom among the points that are tried.
    for (expression, range, part, tightness) in [
        ("u v addf", USUAL, 1.0, 2.0),
        ("u v subf", USUAL, 1.0, 2.0),
        ("u v mulf", USUAL, 1.0, 2.0),
        ("u v divf", USUAL, 1.0, 2.0),
        ("u 0.1 addf", USUAL, 1.0, 2.0),
        ("u 0.7 mulf", USUAL, 1.0, 2.0),
        ("u 0.7 divf", USUAL, 1.0, 2.0),
        ("0.7 u divf", USUAL, 1.0, 2.0),
        ("u negf", USUAL, 1.0, 1.5),
        ("u clampf", USUAL, 1.0, 1.5),
        ("u frac", USUAL, 0.95, 1.5),
        ("u floor real u mulf", USUAL, 0.95, 2.0),
        // Half of the numbers are negative.
        ("u sqrt", USUAL, 1.0, 2.0),
        ("u sin", DEGREES, 1.0, 4.0),
        ("u cos", DEGREES, 1.0, 4.0),
        ("u asin", UNIT, 0.95, 4.0),
        ("u acos", UNIT, 0.95, 4.0),
        ("u v lessf { u } { v } if", USUAL, 0.95, 1.5),
        ("u v eqf { u } { v } if", USUAL, 0.95, 1.5),
    ] {
        let mut tally = check_expression(expression, &range, 800);
        assert!(tally.asked >= 390, "{expression}: {tally:?}");
        assert!(tally.part_answered() >= part, "{expression}: {}", tally.part_answered());
        assert!(
            tally.median_tightness() <= tightness,
            "{expression}: {}",
            tally.median_tightness()
        );
    }
}

/// Numbers that overflow and underflow are not taken for others.
#[test]
fn bounds_hold_for_numbers_of_all_sizes() {
    for expression in [
        "u v addf",
        "u v subf",
        "u v mulf",
        "u v divf",
        "1.0 u v mulf divf",
        "u v mulf clampf",
        "u v divf clampf",
        "u v mulf v divf",
        "u 1.0e300 mulf 1.0e-300 mulf",
        "u u mulf sqrt",
        "u v addf 2.0 mulf 1.0 v divf mulf",
        "u sin",
        "u cos v mulf",
        "u v mulf asin",
        "u v divf acos",
        "u frac",
        "u floor real",
        "u v mulf frac",
        "1.0 u divf 1.0 v divf addf",
        "u v mulf 1.0 lessf { u } { v } if",
        "u v divf 0.0 eqf { u } { v } if",
        "u 0.0 divf",
        "0.0 u divf",
        "u 1.0e308 10.0 mulf divf",
        "1.0e308 10.0 mulf u lessf { u } { v } if",
    ] {
        check_expression(expression, &ALL, 600);
    }
}

/// Asks for bounds of an expression of u and v at some points.
fn check_at(expression: &str, points: &[[Bounded; 2]]) -> Tally {
    let text = format!("{{ /v /u /face {expression} /x 0.0 0.0 0.0 point 1.0 1.0 x }}");
    let mut tally = Tally::default();
    let points = points.iter().map(|&[u, v]| BoundedPoint { face: 0, u, v });
    assert_eq!(check_program(&text, FEW, points, 12, &mut tally), Some(true), "{expression}");
    tally
}

/// The greatest double, reached from where the next number is not.
#[test]
fn results_that_overflow_somewhere_have_no_bounds() {
    // A number halfway to what would follow the greatest double overflows.
    let half = (f64::MAX - f64::MAX.next_down()) / 2.0;
    let near = |value: f64| Bounded { value: 0.999 * value, error: 0.01 * value };
    check_at("u v addf", &[[Bounded::exact(f64::MAX), near(half)]]);
    check_at("1.0 u v addf divf", &[[Bounded::exact(f64::MAX), near(half)]]);
    let root = 2f64.powi(512);
    let below = Bounded { value: root.next_down(), error: root * f64::EPSILON };
    check_at("u v mulf", &[[below, Bounded { value: root.next_down(), error: 0.0 }], [below; 2]]);
    check_at("0.0 u u mulf 1.0e300 subf divf", &[[below; 2]]);
    check_at("u 1.0e-308 divf", &[[Bounded { value: 1.797_693_134_862_315_6, error: 1e-12 }; 2]]);
}

/// Around 0, where nothing but the spread counts: what it loses by rounding is made up for.
#[test]
fn bounds_are_rounded_outwards() {
    let points: Vec<[Bounded; 2]> = (1..3000)
        .map(|k| {
            let error = f64::from(k) * 1.1e-15;
            [Bounded { value: 0.0, error }, Bounded { value: 0.0, error: 0.7 * error }]
        })
        .collect();
    for expression in ["u sin", "u asin", "u v addf 0.3 mulf 0.7 divf sin", "u 1.0 v addf mulf"] {
        check_at(expression, &points);
    }
}

/// Where decisions are close: whole numbers and ties, a few doubles away and nearer.
#[test]
fn close_decisions_are_left_open_and_others_are_taken() {
    for expression in [
        "u floor real",
        "u frac",
        "u negf frac",
        "u negf floor real",
        "u v lessf { 1.0 } { 2.0 } if",
        "u v eqf { 1.0 } { 2.0 } if",
        "u v subf 0.0 lessf { 1.0 } { 2.0 } if",
        "u v subf sqrt",
        "u 0.5 mulf floor real",
    ] {
        let text = format!("{{ /v /u /face {expression} /x 0.0 0.0 0.0 point 1.0 1.0 x }}");
        let mut near = Tally::default();
        let mut far = Tally::default();
        for whole in [0.0, 1.0, 2.0, 3.0, 1000.0, 4e15, 9e15] {
            let unit = f64::max(whole, 0.1) * f64::EPSILON;
            let point = |k: i32, quarters: i32| BoundedPoint {
                face: 0,
                u: Bounded {
                    value: whole + unit * f64::from(k),
                    error: unit * f64::from(quarters) / 4.0,
                },
                v: Bounded { value: whole, error: 0.1 * unit },
            };
            let points = (-12..=12).flat_map(|k| (1..40).map(move |q| point(k, q)));
            check_program(&text, FEW, points, 40, &mut near);
            let points = (4..=12).map(|k| point(k, 1));
            if whole < 1e15 {
                check_program(&text, FEW, points, 4, &mut far);
            }
        }
        println!(
            "{expression}: {:.3} answered near, {:.3} far",
            near.part_answered(),
            far.part_answered()
        );
        let part = near.part_answered();
        assert!((0.05..0.95).contains(&part) && far.part_answered() > 0.7, "{expression}: {part}");
    }
}

/// Keeps the surface functions of all images.
#[derive(Default)]
struct Keeps(Vec<Arc<Closure>>);

impl Host for Keeps {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        self.0.extend(surfaces::scene::<f64>(&job.object).1);
        Ok(())
    }
}

/// The surface functions that a file leaves or gives to solids, one for each function of the program.
fn functions(path: &Path) -> (Arc<LoadedProgram>, Vec<Arc<Closure>>) {
    let text = std::fs::read(path).expect("readable");
    let mut sources = SourceMap::default();
    let root = sources.add(&path.display().to_string(), text).expect("short");
    let bytecode = compiler::compile(&mut sources, root, &mut Beside, &[]).expect("well formed");
    let program = Arc::new(LoadedProgram::new(bytecode));
    let mut host = Keeps::default();
    let limits = Limits { fuel: 1_000_000_000, ..LIMITS };
    let Ok(stack) = Machine::new(&program, limits).run(&mut host) else {
        panic!("{} fails", path.display())
    };
    let left = stack.into_iter().filter_map(|value| match value {
        Value::Closure(closure) => Some(closure),
        _ => None,
    });
    let mut functions: Vec<_> = left.chain(host.0).collect();
    functions.sort_by_key(|closure| closure.function);
    functions.dedup_by_key(|closure| closure.function);
    (program, functions)
}

fn gml_files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "gml"));
    paths.sort();
    paths
}

/// Nearly all points of real scenes are answered, with radii as a tracer of doubles has them.
#[test]
fn kernels_and_scenes_are_answered_nearly_everywhere() {
    const LIMITS: Limits = Limits { fuel: 10_000_000, max_depth: 1000, max_memory: 1 << 30 };
    let mut n_native = 0;
    let mut all = Tally::default();
    for path in gml_files("benches/kernels").iter().chain(&gml_files("scenes")) {
        let (program, closures) = functions(path);
        for closure in closures {
            let mut tally = Tally::default();
            let points = (0..900u32).map(|k| {
                // Off the lines of textures, which have few digits.
                let coordinate = |k: u32| {
                    let value = (f64::from(k) + 0.371_9) / 30.0;
                    Bounded { value, error: 1e-15 }
                };
                BoundedPoint { face: (k % 6) as u8, u: coordinate(k % 30), v: coordinate(k / 30) }
            });
            let context = path.display().to_string();
            let is_native =
                check_function((&program, &closure), LIMITS, points, 2, &context, &mut tally);
            if is_native {
                n_native += 1;
                let name = program.bytecode.functions[closure.function as usize].name.as_deref();
                println!(
                    "{} {}: {:.4} answered, {:.1} wide",
                    path.file_name().expect("a name").display(),
                    name.unwrap_or_default(),
                    tally.part_answered(),
                    tally.median_tightness()
                );
                assert!(tally.part_answered() > 0.9, "{context} {name:?}");
            }
            all.asked += tally.asked;
            all.answered += tally.answered;
            all.tightness.extend(tally.tightness);
        }
    }
    let (part, tightness) = (all.part_answered(), all.median_tightness());
    println!(
        "{n_native} functions, {} requests, {part:.5} answered, {tightness:.1} wide",
        all.asked
    );
    assert!(n_native > 20 && part > 0.99 && tightness < 20.0, "{n_native}, {part}, {tightness}");
}
