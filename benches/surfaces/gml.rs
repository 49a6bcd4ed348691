//! Runs GML programs and finds surface functions in them.

use std::path::Path;
use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use compiler::source::SourceMap;
use renderer::surface::{
    Bounded, BoundedPoint, BoundedSample, LocateBounded, Needs, SurfaceEval, SurfaceId,
    SurfacePoint, SurfaceSample,
};
use vm::host::{Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;
use vm::surfaces;
use vm::value::{Closure, Value};

use crate::twins::Answer;
use beside::Beside;

#[path = "../../tests/support/beside.rs"]
mod beside;

pub(crate) const LIMITS: Limits = Limits { fuel: u64::MAX, max_depth: 10_000, max_memory: 1 << 30 };

/// A host that keeps the surface functions of all images.
#[derive(Default)]
struct Keeps(Vec<Arc<Closure>>);

impl Host for Keeps {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        self.0.extend(surfaces::scene::<f64>(&job.object).1);
        Ok(())
    }
}

/// A program that has run, and the functions that it leaves or gives to solids.
pub(crate) struct Ran {
    pub(crate) program: Arc<LoadedProgram>,
    pub(crate) functions: Vec<Arc<Closure>>,
}

/// Runs a file below the project's root.
pub(crate) fn run(file: &str) -> Ran {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let text = std::fs::read(&path).unwrap_or_else(|error| panic!("{file}: {error}"));
    let mut sources = SourceMap::default();
    let root = sources.add(&path.display().to_string(), text).expect("short");
    let bytecode = compiler::compile(&mut sources, root, &mut Beside, &[])
        .unwrap_or_else(|diagnostics| panic!("{file}: {}", diagnostics[0].message));
    let program = Arc::new(LoadedProgram::new(bytecode));
    let mut host = Keeps::default();
    let stack = Machine::new(&program, LIMITS)
        .run(&mut host)
        .unwrap_or_else(|error| panic!("{file}: {}", error.into_diagnostic().message));
    let left = stack.into_iter().filter_map(|value| match value {
        Value::Closure(closure) => Some(closure),
        _ => None,
    });
    Ran { program, functions: left.chain(host.0).collect() }
}

impl Ran {
    /// The function of this name; without one, the first.
    pub(crate) fn function(&self, name: Option<&str>) -> &Arc<Closure> {
        let name_of = |closure: &Arc<Closure>| {
            self.program.bytecode.functions[closure.function as usize].name.as_deref()
        };
        let is_wanted = |closure: &&Arc<Closure>| name.is_none() || name_of(closure) == name;
        self.functions.iter().find(is_wanted).unwrap_or_else(|| panic!("no function {name:?}"))
    }
}

/// Calls the only surface of an evaluator.
#[inline(always)]
pub(crate) fn call<E: SurfaceEval>(evaluator: &mut E, face: u8, u: f64, v: f64) -> Answer {
    let Ok(sample) = evaluator.eval(SurfaceId(0), &SurfacePoint { face, u, v }) else {
        fails(face, u, v)
    };
    numbers(&sample)
}

/// Takes values, so that those of calls that do not fail stay in registers.
#[cold]
fn fails(face: u8, u: f64, v: f64) -> ! {
    panic!("the surface function fails at face {face}, u {u}, v {v}")
}

/// What a surface function leaves, in order.
#[inline(always)]
pub(crate) fn numbers(sample: &SurfaceSample) -> Answer {
    let [red, green, blue] = sample.color.to_array();
    [red, green, blue, sample.kd, sample.ks, sample.phong_exp]
}

/// A point that is known up to what a tracer of doubles is off by.
struct Around(SurfacePoint);

impl LocateBounded for Around {
    fn locate_bounded(&self, _: Needs) -> BoundedPoint {
        let SurfacePoint { face, u, v } = self.0;
        let [u, v] = [u, v].map(|value| Bounded { value, error: 1e-15 });
        BoundedPoint { face, u, v }
    }
}

/// The centres of bounds of the only surface; where there are none, what it answers.
#[inline(always)]
pub(crate) fn call_bounded<E: SurfaceEval>(evaluator: &mut E, face: u8, u: f64, v: f64) -> Answer {
    let at = Around(SurfacePoint { face, u, v });
    let Some(sample) = evaluator.eval_bounded(SurfaceId(0), &at) else {
        return call(evaluator, face, u, v);
    };
    let BoundedSample { color: [red, green, blue], kd, ks, phong_exp } = sample;
    [red, green, blue, kd, ks, phong_exp].map(|bounded| bounded.value)
}
