//! Random surface functions, by the interpreter and as native code: the same values to the last bit
//! (any NaN is any other), or the same error at the same place.
//!
//! `GMLVM_FUZZ_PROGRAMS` sets how many programs, `GMLVM_FUZZ_SEED` where to start.

use std::cell::Cell;
use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use compiler::preprocess::NoIncludes;
use compiler::source::SourceMap;
use jit::shaders::{Evaluation, Shaders, Tiering};
use renderer::surface::{Locate, Needs, SurfaceEval, SurfaceId, SurfacePoint, SurfaceSample};
use support::generator::{Random, program};
use vm::error::Error;
use vm::host::{Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;
use vm::surfaces::InterpSurfaces;
use vm::value::{Closure, Value};

mod support {
    pub(crate) mod generator;
}

const LIMITS: Limits = Limits { fuel: 200_000, max_depth: 1000, max_memory: 64 << 20 };

struct NoRender;

impl Host for NoRender {
    fn render(&mut self, _: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        unreachable!("generated programs do not render")
    }
}

/// The program and the function that it leaves; none if it fails before.
fn load(text: &str) -> Option<(Arc<LoadedProgram>, Arc<Closure>)> {
    let mut sources = SourceMap::default();
    let file = sources.add("case.gml", text.as_bytes().to_vec()).expect("short");
    let bytecode =
        compiler::compile(&mut sources, file, &mut NoIncludes, &[]).expect("well formed");
    let program = Arc::new(LoadedProgram::new(bytecode));
    let stack = Machine::new(&program, LIMITS).run(&mut NoRender).ok()?;
    let Some(Value::Closure(closure)) = stack.last() else { return None };
    Some((program.clone(), closure.clone()))
}

/// What a call gives, NaNs made alike; of an error what and where.
fn told(result: Result<SurfaceSample, Box<Error>>) -> Result<[u64; 6], String> {
    match result {
        Ok(SurfaceSample { color, kd, ks, phong_exp }) => {
            let bits = |x: f64| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() };
            Ok([color.x, color.y, color.z, kd, ks, phong_exp].map(bits))
        }
        Err(error) => Err(format!("{:?} at {:?}", error.problem, error.origin.span)),
    }
}

/// A place that tells what it was asked for, and lies about the rest.
struct Place {
    at: SurfacePoint,
    asked: Cell<Option<Needs>>,
}

impl Place {
    fn new(at: SurfacePoint) -> Self {
        Place { at, asked: Cell::new(None) }
    }
}

impl Locate for Place {
    fn locate(&self, needs: Needs) -> SurfacePoint {
        self.asked.set(Some(needs));
        SurfacePoint {
            face: if needs.face { self.at.face } else { 99 },
            u: if needs.u { self.at.u } else { -17.5 },
            v: if needs.v { self.at.v } else { -17.5 },
        }
    }
}

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Why each program went the way it went.
#[derive(Debug, Default)]
struct Tally {
    failed_before: u64,
    native: u64,
    constant: u64,
    declined: std::collections::BTreeMap<String, u64>,
    calls: u64,
    errors: u64,
}

fn check(seed: u64, tally: &mut Tally) {
    let text = program(seed);
    let Some((loaded, closure)) = load(&text) else {
        tally.failed_before += 1;
        return;
    };
    let surfaces = [closure];
    let shaders = Shaders::new(&loaded, &surfaces, LIMITS, Tiering::Eager);
    match &shaders.report()[0].evaluation {
        Evaluation::Native { .. } => tally.native += 1,
        Evaluation::Constant => tally.constant += 1,
        Evaluation::Declined(why) => *tally.declined.entry(why.reason.clone()).or_default() += 1,
        Evaluation::Cold => unreachable!("all are compiled at once"),
    }
    let mut native = shaders.worker();
    let mut interpreted = InterpSurfaces::new(&loaded, &surfaces, LIMITS);
    let mut random = Random::new(!seed);
    let mut coordinate = || match random.below(6) {
        0 => 0.0,
        1 => 1.0,
        _ => random.below(1 << 20) as f64 / (1u64 << 20) as f64,
    };
    for k in 0..16 {
        let at = SurfacePoint { face: k % 6, u: coordinate(), v: coordinate() };
        let expected = told(interpreted.eval(SurfaceId(0), &at));
        let found = told(native.eval(SurfaceId(0), &Place::new(at)));
        assert_eq!(found, expected, "program {seed} at {at:?}:\n{text}");
        tally.calls += 1;
        tally.errors += u64::from(expected.is_err());
    }
}

#[test]
fn functions_are_told_what_they_read_and_no_more() {
    let needs = |face, u, v| Some(Needs { face, u, v });
    let cases = [
        ("{ /v /u /face 0.5 0.5 0.5 point 1.0 0.0 1.0 }", None),
        ("{ /v /u /face u u u point 1.0 0.0 1.0 }", needs(false, true, false)),
        ("{ /v /u /face v u 0.0 mulf v point 1.0 0.0 1.0 }", needs(false, true, true)),
        (
            "{ /v /u /face 0.1 0.2 0.3 point face 1 eqi { 1.0 } { 0.5 } if 0.0 1.0 }",
            needs(true, false, false),
        ),
        // Whether it fails depends on v, though no result does.
        ("{ /v /u /face v sqrt /root 0.1 0.2 0.3 point 1.0 0.0 1.0 }", needs(false, false, true)),
    ];
    for (text, expected) in cases {
        let (loaded, closure) = load(text).expect("a function");
        let surfaces = [closure];
        let shaders = Shaders::new(&loaded, &surfaces, LIMITS, Tiering::Eager);
        let place = Place::new(SurfacePoint { face: 1, u: 0.25, v: 0.75 });
        shaders.worker().eval(SurfaceId(0), &place).expect("no error");
        assert_eq!(place.asked.get(), expected, "{text}");
    }
}

#[test]
fn functions_are_compiled_when_it_pays() {
    let wavy = "{ /v /u /face u 360.0 mulf sin v v point 1.0 0.0 1.0 }";
    let constant = "{ /v /u /face 0.1 0.2 0.3 point 1.0 0.0 1.0 }";
    // How soon each is decided, in calls.
    let cases = [(wavy, 10_000..100_000), (constant, 500..10_000)];
    for (text, expected) in cases {
        let (loaded, closure) = load(text).expect("a function");
        let surfaces = [closure];
        let shaders = Shaders::new(&loaded, &surfaces, LIMITS, Tiering::Hot);
        let mut worker = shaders.worker();
        let mut n_calls = 0;
        let at = SurfacePoint { face: 0, u: 0.3, v: 0.4 };
        let first = told(worker.eval(SurfaceId(0), &at));
        while shaders.report()[0].evaluation == Evaluation::Cold {
            assert_eq!(told(worker.eval(SurfaceId(0), &at)), first, "{text}");
            n_calls += 1;
            assert!(n_calls < expected.end, "{text} is still interpreted");
        }
        assert!(n_calls >= expected.start, "{text} is decided after {n_calls} calls");
        assert_eq!(told(worker.eval(SurfaceId(0), &at)), first, "{text}");
    }
}

#[test]
fn native_code_agrees_with_the_interpreter() {
    let first = number("GMLVM_FUZZ_SEED", 1);
    let n_programs = number("GMLVM_FUZZ_PROGRAMS", 3000);
    let mut tally = Tally::default();
    for seed in first..first + n_programs {
        check(seed, &mut tally);
    }
    println!("{tally:#?}");
    // A generator whose programs all fail, or all are declined, would find nothing.
    assert!(tally.native * 2 > n_programs && tally.errors * 2 < tally.calls, "{tally:?}");
}
