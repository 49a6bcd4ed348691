//! A surface function by the interpreter and as native code: the same values to the last bit (any NaN
//! is any other), or the same error at the same place.

use std::cell::Cell;
use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use compiler::preprocess::NoIncludes;
use compiler::source::SourceMap;
use jit::shaders::{Evaluation, NativeSurfaces, Shaders, Tiering};
use renderer::signature::Signature;
use renderer::surface::{
    Locate, MAX_BATCH, Needs, SurfaceEval, SurfaceId, SurfacePoint, SurfaceSample,
};
use vm::error::Error;
use vm::host::{Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;
use vm::surfaces::InterpSurfaces;
use vm::value::{Closure, Value};

/// What a call gives, NaNs made alike; of an error what and where.
pub type Told = Result<[u64; 6], String>;

struct NoRender;

impl Host for NoRender {
    fn render(&mut self, _: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        unreachable!("these programs do not render")
    }
}

/// The program and the function that it leaves; none if it fails before.
pub fn load(text: &str, limits: Limits) -> Option<(Arc<LoadedProgram>, Arc<Closure>)> {
    let mut sources = SourceMap::default();
    let file = sources.add("case.gml", text.as_bytes().to_vec()).expect("short");
    let bytecode =
        compiler::compile(&mut sources, file, &mut NoIncludes, &[]).expect("well formed");
    let program = Arc::new(LoadedProgram::new(bytecode));
    let stack = Machine::new(&program, limits).run(&mut NoRender).ok()?;
    let Some(Value::Closure(closure)) = stack.last() else { return None };
    Some((program.clone(), closure.clone()))
}

/// The result of a call, for comparing.
pub fn told(result: Result<SurfaceSample, Box<Error>>) -> Told {
    match result {
        Ok(SurfaceSample { color, kd, ks, phong_exp }) => {
            let bits = |x: f64| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() };
            Ok([color.x, color.y, color.z, kd, ks, phong_exp].map(bits))
        }
        Err(error) => Err(format!("{:?} at {:?}", error.problem, error.origin.span)),
    }
}

/// The same with the signature, where there is a result.
fn told_signed(
    result: Result<(SurfaceSample, Signature), Box<Error>>,
) -> (Told, Option<Signature>) {
    let signature = result.as_ref().ok().map(|(_, signature)| *signature);
    (told(result.map(|(sample, _)| sample)), signature)
}

/// A place that tells what it was asked for, and lies about the rest.
pub struct Place {
    at: SurfacePoint,
    /// What it was last asked for.
    pub asked: Cell<Option<Needs>>,
}

impl Place {
    /// Nobody has asked yet.
    pub fn new(at: SurfacePoint) -> Self {
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

/// What both engines say of a surface function.
#[allow(dead_code, reason = "each test reads its part")]
pub struct Agreed {
    /// How it was evaluated.
    pub evaluation: Evaluation,
    /// What the calls gave.
    pub results: Vec<Told>,
    /// At how many of the points there was an answer when it was asked at many at once.
    pub in_batches: usize,
}

/// Calls the surface function that a program leaves at some points, by both engines, and at
/// many of them at once; none if the program fails before.
///
/// # Panics
/// If the engines differ.
pub fn agree(
    text: &str,
    limits: Limits,
    points: impl Iterator<Item = SurfacePoint>,
) -> Option<Agreed> {
    let (program, closure) = load(text, limits)?;
    let surfaces = [closure];
    let shaders = Shaders::new(&program, &surfaces, limits, Tiering::Eager);
    let evaluation = shaders.report()[0].evaluation.clone();
    let mut native = shaders.worker();
    let mut interpreted = InterpSurfaces::new(&program, &surfaces, limits);
    let points: Vec<SurfacePoint> = points.collect();
    let told_at = |&at: &SurfacePoint| {
        let expected = told(interpreted.eval(SurfaceId(0), &at));
        let found = told(native.eval(SurfaceId(0), &Place::new(at)));
        assert_eq!(found, expected, "at {at:?}:\n{text}");
        // With a signature too; and decisions are the same whoever makes them.
        let found = told_signed(native.eval_signed(SurfaceId(0), &Place::new(at)));
        let (also, decisions) = told_signed(interpreted.eval_signed(SurfaceId(0), &at));
        assert_eq!(also, expected, "at {at:?}:\n{text}");
        assert_eq!(found, (also, decisions), "at {at:?}:\n{text}");
        expected
    };
    let results: Vec<Told> = points.iter().map(told_at).collect();
    let in_batches = agree_in_batches(&mut native, &points, &results, text);
    Some(Agreed { evaluation, results, in_batches })
}

/// Asks at many points at once, in batches of different sizes. There is the same answer, or none: where
/// there is an error, where native code leaves too, or anywhere if the function is too much for batches.
fn agree_in_batches(
    native: &mut NativeSurfaces<'_>,
    points: &[SurfacePoint],
    results: &[Told],
    text: &str,
) -> usize {
    let mut n_answers = 0;
    let mut rest = points.iter().copied().zip(results).collect::<Vec<_>>();
    let sizes = [1, 7, MAX_BATCH, 20, 8, 33].into_iter().cycle();
    for size in sizes {
        if rest.is_empty() {
            break;
        }
        let batch: Vec<_> = rest.drain(..size.min(rest.len())).collect();
        let points: Vec<SurfacePoint> = batch.iter().map(|(at, _)| *at).collect();
        let mut samples = Vec::new();
        native.eval_batch(SurfaceId(0), &points, &mut samples);
        assert_eq!(samples.len(), batch.len());
        for ((at, expected), sample) in batch.into_iter().zip(samples) {
            let Some(sample) = sample else { continue };
            assert_eq!(&told(Ok(sample)), expected, "in a batch, at {at:?}:\n{text}");
            n_answers += 1;
        }
    }
    n_answers
}
