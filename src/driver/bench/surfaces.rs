//! Surface functions alone: calls of each, interpreted and native, at fixed points.
//!
//! One thread calls them, and its processor time is what is measured: a call is so short that
//! sharing a processor with others would drown it.

use std::collections::HashMap;
use std::hint::black_box;
use std::path::Path;
use std::rc::Rc;
use std::slice;
use std::sync::Arc;
use std::time::{Duration, Instant};

use compiler::diagnostic::Diagnostic;
use compiler::source::Span;
use jit::shaders::{CompileTimes, Evaluation, NativeSurfaces, Shaders, Tiering};
use renderer::object::ShapeKind;
use renderer::scene::Scene;
use renderer::surface::{SurfaceEval, SurfaceId, SurfacePoint, SurfaceSample};
use vm::host::{Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;
use vm::surfaces::{self, InterpSurfaces};
use vm::value::Closure;

use crate::args::{BenchArgs, LimitArgs, Precision};
use crate::clean::clean;
use crate::driver::bench::export::{Compared, Details, Entry, SurfaceDetails};
use crate::driver::bench::points;
use crate::failure::Failure;
use crate::load::Source;
use crate::measure::machine::{ProcessorTime, thread_time};
use crate::measure::rounds::Rounds;
use crate::measure::statistics::{median, paired_ratio};
use crate::report::Reporter;
use crate::run::limits::Used;

/// Passes over the points are repeated until one sample takes this long.
const SAMPLE_TIME: Duration = Duration::from_millis(2);

/// No further points are tried once trying those before has taken this long.
const TRYING_TIME: Duration = Duration::from_secs(1);

/// The one surface of each evaluator here.
const SURFACE: SurfaceId = SurfaceId(0);

/// Times the surface functions of all images of a scene.
///
/// # Errors
/// What is wrong with the scene, or that interpreter and native code differ.
pub(super) fn measure(
    scene: &Path,
    args: &BenchArgs,
    reporter: &Reporter,
) -> Result<Vec<Entry>, Failure> {
    let mut source = Source::read(scene, &args.inputs, reporter)?;
    let program = Arc::new(LoadedProgram::new(source.compile(reporter)?));
    let limits = args.limits.machine();
    let mut collector = Collector::new(args.limits);
    Machine::new(&program, limits)
        .run(&mut collector)
        .map_err(|error| source.stopped(error.into_diagnostic(), reporter))?;
    let bench = Bench { program: &program, limits, source: &source, args, reporter };
    let groups = bench.groups(collector.found);
    let shaders: Vec<_> = groups.iter().map(|group| bench.shaders(group)).collect();
    let mut contenders = Vec::new();
    for (group, shaders) in groups.iter().zip(&shaders) {
        contenders.extend(bench.contenders(group, shaders)?);
    }
    let rounds = Rounds::new(args.warmup, args.runs, args.time);
    let shown = scene.display().to_string();
    let bar = rounds.bar(&clean(&shown), contenders.len(), reporter.quiet);
    let done: Result<(), Failure> = rounds.each(contenders.len(), |index, counts| {
        let contender = &mut contenders[index];
        let time = contender.sample();
        // Compiling takes its turns with the rest.
        let compile_times = bench.shaders(contender.group).times();
        if counts {
            contender.times.push(time);
            contender.compile_times.push(compile_times);
        }
        bar.inc(1);
        Ok(())
    });
    bar.finish();
    done?;
    Ok(bench.entries(&contenders))
}

/// A host that renders nothing, but remembers what would be called.
struct Collector {
    limits: LimitArgs,
    used: Used,
    found: Vec<Found>,
    /// Places in `found`.
    by_closure: HashMap<*const Closure, usize>,
}

/// A surface function and the solids that have it.
struct Found {
    closure: Arc<Closure>,
    kinds: Vec<ShapeKind>,
}

impl Collector {
    fn new(limits: LimitArgs) -> Self {
        Collector { limits, used: Used::default(), found: Vec::new(), by_closure: HashMap::new() }
    }
}

impl Host for Collector {
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        self.used.add(job.width, job.height);
        self.limits.check(&job, self.used, job.width, job.height, Precision::F64)?;
        let (scene, closures): (Scene, _) = surfaces::scene(&job.object);
        for (kind, surface) in scene.shapes() {
            let closure = &closures[surface.0 as usize];
            let index = *self.by_closure.entry(Arc::as_ptr(closure)).or_insert_with(|| {
                self.found.push(Found { closure: closure.clone(), kinds: Vec::new() });
                self.found.len() - 1
            });
            add_kinds(&mut self.found[index].kinds, &[kind]);
        }
        Ok(())
    }
}

fn add_kinds(kinds: &mut Vec<ShapeKind>, others: &[ShapeKind]) {
    let new = others.iter().filter(|kind| !kinds.contains(kind)).copied().collect::<Vec<_>>();
    kinds.extend(new);
}

/// Closures of one function that are evaluated alike; the first stands for all.
struct Group {
    closure: Arc<Closure>,
    kinds: Vec<ShapeKind>,
    n_closures: usize,
    span: Span,
    evaluation: Evaluation,
}

/// One way to evaluate a group.
struct Contender<'b> {
    group: &'b Group,
    evaluator: Evaluator<'b>,
    points: Rc<[SurfacePoint]>,
    n_failing: usize,
    n_passes: u32,
    n_calls: usize,
    times: Vec<f64>,
    compile_times: Vec<CompileTimes>,
    processor_time: ProcessorTime,
}

enum Evaluator<'b> {
    Interpreter(InterpSurfaces<'b>),
    Native(NativeSurfaces<'b>),
}

impl<'b> Contender<'b> {
    fn new(
        group: &'b Group,
        evaluator: Evaluator<'b>,
        points: Rc<[SurfacePoint]>,
        n_failing: usize,
    ) -> Self {
        let mut contender = Contender {
            group,
            evaluator,
            points,
            n_failing,
            n_passes: 1,
            n_calls: 0,
            times: Vec::new(),
            compile_times: Vec::new(),
            processor_time: ProcessorTime::default(),
        };
        while contender.passes() < SAMPLE_TIME {
            contender.n_passes *= 2;
        }
        contender
    }

    fn passes(&mut self) -> Duration {
        let start = thread_time();
        for _ in 0..self.n_passes {
            match &mut self.evaluator {
                Evaluator::Interpreter(interpreter) => pass(interpreter, &self.points),
                Evaluator::Native(native) => pass(native, &self.points),
            }
        }
        thread_time().saturating_sub(start)
    }

    /// Seconds a call.
    fn sample(&mut self) -> f64 {
        let start = ProcessorTime::now();
        let time = self.passes();
        self.processor_time.add_since(start);
        let n_calls = self.n_passes as usize * self.points.len();
        self.n_calls += n_calls;
        time.as_secs_f64() / n_calls as f64
    }

    fn name(&self) -> &'static str {
        match self.evaluator {
            Evaluator::Interpreter(_) => "interp",
            Evaluator::Native(_) => "native",
        }
    }
}

#[inline(never)]
fn pass<E: SurfaceEval>(evaluator: &mut E, points: &[SurfacePoint]) {
    for at in points {
        // It has been called at all points, and never fails there.
        let _ = black_box(evaluator.eval(SURFACE, at));
    }
}

/// What all surface functions of a scene have in common.
struct Bench<'b> {
    program: &'b Arc<LoadedProgram>,
    limits: Limits,
    source: &'b Source<'b>,
    args: &'b BenchArgs,
    reporter: &'b Reporter,
}

impl<'b> Bench<'b> {
    fn groups(&self, found: Vec<Found>) -> Vec<Group> {
        let closures: Vec<_> = found.iter().map(|found| found.closure.clone()).collect();
        let reports = Shaders::new(self.program, &closures, self.limits, Tiering::Eager).report();
        let mut groups: Vec<Group> = Vec::new();
        let mut by_evaluation = HashMap::new();
        for (Found { closure, kinds }, report) in found.into_iter().zip(reports) {
            let key = (closure.function, format!("{:?}", report.evaluation));
            let index = *by_evaluation.entry(key).or_insert(groups.len());
            if index == groups.len() {
                let (span, evaluation) = (report.span, report.evaluation);
                groups.push(Group { closure, kinds, n_closures: 1, span, evaluation });
            } else {
                add_kinds(&mut groups[index].kinds, &kinds);
                groups[index].n_closures += 1;
            }
        }
        groups
    }

    /// Compiles the group's function.
    fn shaders<'s>(&'s self, group: &'s Group) -> Shaders<'s> {
        let closures = slice::from_ref(&group.closure);
        Shaders::new(self.program, closures, self.limits, Tiering::Eager)
    }

    /// The ways to evaluate a group. A function that fails everywhere is told about, and not timed.
    fn contenders<'s>(
        &'s self,
        group: &'s Group,
        shaders: &'s Shaders<'s>,
    ) -> Result<Vec<Contender<'s>>, Failure> {
        let closures = slice::from_ref(&group.closure);
        let mut interpreter = InterpSurfaces::new(self.program, closures, self.limits);
        let mut native = shaders.worker();
        let (mut points, mut n_failing) = (Vec::new(), 0);
        let start = Instant::now();
        for at in points::spread(&group.kinds) {
            if start.elapsed() > TRYING_TIME {
                break;
            }
            match (interpreter.eval(SURFACE, &at), native.eval(SURFACE, &at)) {
                (Ok(a), Ok(b)) if same_bits(a, b) => points.push(at),
                (Err(_), Err(_)) => n_failing += 1,
                _ => return Err(self.unequal(group, at)),
            }
        }
        if points.is_empty() {
            let place = self.source.place(group.span);
            self.reporter
                .note(&format!("the surface function at {place} fails wherever it is called"));
            return Ok(Vec::new());
        }
        let mut evaluators = vec![Evaluator::Interpreter(interpreter)];
        if let Evaluation::Native { .. } = group.evaluation {
            evaluators.push(Evaluator::Native(native));
        }
        let points = Rc::from(points);
        let contender = |evaluator| Contender::new(group, evaluator, Rc::clone(&points), n_failing);
        Ok(evaluators.into_iter().map(contender).collect())
    }

    fn unequal(&self, group: &Group, at: SurfacePoint) -> Failure {
        let place = self.source.place(group.span);
        let SurfacePoint { face, u, v } = at;
        Failure::Unequal(format!(
            "interpreter and native code differ: the surface function at {place}, for face {face}, \
             u {u:?}, v {v:?}; this is a bug in gmlvm"
        ))
    }

    fn entries(&self, contenders: &[Contender<'_>]) -> Vec<Entry> {
        let mut n_of_name: HashMap<String, usize> = HashMap::new();
        let mut interpreted: &[f64] = &[];
        let mut entries = Vec::new();
        for contender in contenders {
            let ratio = match contender.evaluator {
                Evaluator::Interpreter(_) => {
                    interpreted = &contender.times;
                    None
                }
                Evaluator::Native(_) => Some(paired_ratio(interpreted, &contender.times)),
            };
            let details = self.details(contender, ratio.map(Compared::from));
            let name = self.name(&details);
            let n = n_of_name.entry(name.clone()).or_default();
            *n += 1;
            let name = if *n == 1 { name } else { format!("{name} ({n})") };
            let of_each = contender.processor_time.of_each(contender.n_calls);
            entries.push(Entry::new(
                name,
                contender.times.clone(),
                of_each,
                Details::Surface(details),
            ));
        }
        entries
    }

    /// What stands in the place of a command, with all that the function may depend on.
    fn name(&self, details: &SurfaceDetails) -> String {
        let mut name = format!("{} {}", details.surface, details.engine);
        for define in &self.args.inputs.defines {
            name += " -D ";
            name += &define.text;
        }
        name
    }

    fn details(&self, contender: &Contender<'_>, ratio: Option<Compared>) -> SurfaceDetails {
        let group = contender.group;
        let (mut reason, mut code_bytes, mut uniforms) = (None, None, None);
        let evaluation = match &group.evaluation {
            Evaluation::Constant => "constant",
            Evaluation::Native { n_bytes, n_uniforms, .. } => {
                (code_bytes, uniforms) = (Some(*n_bytes), Some(*n_uniforms));
                "native"
            }
            Evaluation::Declined(why) => {
                reason = Some(format!("{} at {}", why.reason, self.source.place(why.span)));
                "declined"
            }
            Evaluation::Cold => "cold",
        };
        let median_time = |of: fn(&CompileTimes) -> Duration| {
            let times = contender.compile_times.iter().map(|times| of(times).as_secs_f64());
            median(&times.collect::<Vec<_>>())
        };
        SurfaceDetails {
            surface: self.source.place(group.span),
            closures: group.n_closures,
            engine: contender.name(),
            evaluation,
            reason,
            points: contender.points.len(),
            failing_points: contender.n_failing,
            code_bytes,
            uniforms,
            specialize: median_time(|times| times.specialize),
            generate: median_time(|times| times.generate),
            ratio_to_first: ratio,
        }
    }
}

/// Whether two samples are the same, NaN payloads aside.
fn same_bits(a: SurfaceSample, b: SurfaceSample) -> bool {
    let numbers = |sample: SurfaceSample| {
        let [red, green, blue] = sample.color.to_array();
        [red, green, blue, sample.kd, sample.ks, sample.phong_exp]
    };
    let same = |(a, b): (f64, f64)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
    numbers(a).into_iter().zip(numbers(b)).all(same)
}
