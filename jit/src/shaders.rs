//! The shaders of one render job: which surfaces are constant, native or interpreted, and when that
//! is decided.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use compiler::source::Span;
use renderer::signature::Signature;
use renderer::surface::{
    BoundedSample, Locate, LocateBounded, Needs, SurfaceEval, SurfaceId, SurfacePoint,
    SurfaceSample,
};
use vm::error::Error;
use vm::machine::Limits;
use vm::program::LoadedProgram;
use vm::surfaces::InterpSurfaces;
use vm::value::Closure;

use crate::batch::{self, Batch, Lanes};
use crate::certify::BoundedCode;
use crate::code::{Code, Native, in_registers, isa};
use crate::outline::{KeyItem, Outline, outline};
pub use crate::report::{CompileTimes, Evaluation, Observer, Region, SurfaceReport};
use crate::signed::{Signed, SignedVersion};
use crate::sir::{Body, FACE, Shader, U, V, Version};
use crate::specialize::specialize;
use crate::stopwatch::Stopwatch;
use crate::text::Text;
use crate::unsupported::Unsupported;

/// When surface functions are compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tiering {
    /// All at once.
    Eager,
    /// Each when it has been called so often that compiling it pays, or when its bounds are first asked
    /// for.
    Hot,
}

/// Fuel that calls of one function use up before its closures are specialized, to find out whether
/// they are constant: what the interpreter burns (a unit in about 2 ns) while one is (20 to 70 µs).
const WARM_FUEL: u64 = 20_000;

/// Fuel that the interpreter burns while a shader is compiled (about 0.2 ms, and 3 µs for each
/// instruction).
const COMPILE_FUEL: u64 = 100_000;
const COMPILE_FUEL_PER_INST: u64 = 1_500;

/// A shader is compiled when the interpreter has spent so many times what compiling takes. An image
/// that ends at this very moment, with a third of its time spent on surfaces, has lost a twelfth.
const PATIENCE: u64 = 4;

/// Functions specialized in more ways than this on captured integers take those as uniforms.
const MAX_VARIANTS: usize = 16;

/// Less memory than this may be a limit that a surface function runs into.
const MIN_MEMORY: u64 = 64 << 20;

/// How a surface function is evaluated.
pub(crate) enum Tier {
    /// By [`Slot::native`].
    Native,
    Constant(SurfaceSample),
    Interpreted(Unsupported),
}

/// The shaders of one render job, shared by its threads.
pub struct Shaders<'p> {
    pub(crate) program: &'p Arc<LoadedProgram>,
    pub(crate) surfaces: &'p [Arc<Closure>],
    limits: Limits,
    pub(crate) slots: Vec<Slot>,
    /// Fuel that calls have used up by interpretation, by function, before specializing.
    spent: Vec<AtomicU64>,
    cache: Mutex<Cache>,
    observer: Option<Observer<'p>>,
    /// Whether a surface on which it has been decided can be asked at many points at once.
    has_batches: AtomicBool,
    pub(crate) specializing: Stopwatch,
    pub(crate) generating: Stopwatch,
}

/// What is known of a surface.
#[derive(Default)]
pub(crate) struct Slot {
    pub(crate) variant: OnceLock<Result<Bound, Unsupported>>,
    /// Set once nothing more is to be decided.
    pub(crate) tier: OnceLock<Tier>,
    /// What [`Tier::Native`] has, and what of the point it needs: here, so that a call has one thing to
    /// ask.
    pub(crate) native: OnceLock<(Native, Needs)>,
    /// How it is evaluated with a signature; set after that.
    pub(crate) signed: OnceLock<Signed>,
}

impl Slot {
    /// The surface's shader over many points, if there is one, and its native code answers at each.
    pub(crate) fn batch(&self) -> Option<(&Batch, &Bound)> {
        self.native.get()?;
        let bound = self.variant.get()?.as_ref().ok()?;
        Some((bound.variant.batch.get()?.as_ref()?, bound))
    }
}

/// A variant, and what it needs besides the point to be one closure.
pub(crate) struct Bound {
    pub(crate) variant: Arc<Variant>,
    pub(crate) uniforms: Vec<u64>,
}

/// A specialized function, for all closures of the same key.
pub(crate) struct Variant {
    pub(crate) shader: Shader,
    pub(crate) needs: Needs,
    /// Fuel that calls have used up by interpretation since.
    spent: AtomicU64,
    code: OnceLock<Result<Arc<Code>, Unsupported>>,
    /// The same over many points; none if it cannot be done like that.
    batch: OnceLock<Option<Batch>>,
    /// The bounded versions, by what is not known of the point: u, v, or both.
    pub(crate) bounded: [BoundedCode; 3],
    /// The signed version; none if it cannot be compiled.
    pub(crate) signed: OnceLock<Option<SignedVersion>>,
}

impl Variant {
    fn is_constant(&self) -> bool {
        self.needs == Needs { face: false, u: false, v: false }
    }

    /// Whether the interpreter has spent so much that compiling is due, with the fuel of one more
    /// call.
    fn is_hot(&self, fuel: u64) -> bool {
        let spent = self.spent.fetch_add(fuel, Ordering::Relaxed) + fuel;
        let n_insts: usize = self.shader.bodies().map(Body::n_insts).sum();
        spent / PATIENCE > COMPILE_FUEL + COMPILE_FUEL_PER_INST * n_insts as u64
    }
}

/// The place for what a key is specialized to.
pub(crate) type Cell = OnceLock<Result<Arc<Variant>, Unsupported>>;

#[derive(Default)]
struct Cache {
    by_key: HashMap<Vec<KeyItem>, Arc<Cell>>,
    n_variants: HashMap<u32, usize>,
}

impl<'p> Shaders<'p> {
    /// The shaders of surfaces by [`SurfaceId`]; the limits are those of each call.
    #[must_use]
    pub fn new(
        program: &'p Arc<LoadedProgram>,
        surfaces: &'p [Arc<Closure>],
        limits: Limits,
        tiering: Tiering,
    ) -> Self {
        Shaders::observed(program, surfaces, limits, tiering, None)
    }

    /// As [`Shaders::new`], with somebody who is told of the code.
    #[must_use]
    pub fn observed(
        program: &'p Arc<LoadedProgram>,
        surfaces: &'p [Arc<Closure>],
        limits: Limits,
        tiering: Tiering,
        observer: Option<Observer<'p>>,
    ) -> Self {
        let shaders = Shaders {
            program,
            surfaces,
            limits,
            slots: surfaces.iter().map(|_| Slot::default()).collect(),
            spent: program.bytecode.functions.iter().map(|_| AtomicU64::new(0)).collect(),
            cache: Mutex::default(),
            observer,
            has_batches: AtomicBool::new(false),
            specializing: Stopwatch::default(),
            generating: Stopwatch::default(),
        };
        if tiering == Tiering::Eager {
            let mut interpreter = InterpSurfaces::new(program, surfaces, limits);
            for index in 0..surfaces.len() {
                shaders.decide(index, || {
                    let anywhere = SurfacePoint { face: 0, u: 0.0, v: 0.0 };
                    interpreter.eval(SurfaceId(index as u32), &anywhere).ok()
                });
            }
        }
        shaders
    }

    /// What one thread evaluates surfaces with.
    #[must_use]
    pub fn worker(&self) -> NativeSurfaces<'_> {
        NativeSurfaces {
            shaders: self,
            slots: &self.slots,
            interpreter: InterpSurfaces::new(self.program, self.surfaces, self.limits),
            lanes: Lanes::default(),
        }
    }

    /// Counts a call by interpretation, and decides how to go on when the time has come. `sample` is
    /// what the call gave.
    pub(crate) fn warm_up(&self, index: usize, fuel: u64, sample: SurfaceSample) {
        let spent = &self.spent[self.surfaces[index].function as usize];
        let is_due = match self.slots[index].variant.get() {
            Some(Ok(bound)) => bound.variant.is_hot(fuel),
            Some(Err(_)) => true,
            None if spent.fetch_add(fuel, Ordering::Relaxed) + fuel < WARM_FUEL => false,
            None => self.variant(index).as_ref().map_or(true, |bound| bound.variant.is_constant()),
        };
        if is_due {
            self.decide(index, || Some(sample));
        }
    }

    /// What a surface gives everywhere, by `sample` if it has yet to be decided that this is so.
    fn constant(
        &self,
        index: usize,
        sample: impl FnOnce() -> Option<SurfaceSample>,
    ) -> Option<SurfaceSample> {
        if self.variant(index).as_ref().is_ok_and(|bound| bound.variant.is_constant()) {
            self.decide(index, sample);
        }
        match self.slots[index].tier.get() {
            Some(Tier::Constant(sample)) => Some(*sample),
            _ => None,
        }
    }

    /// Decides how a surface is evaluated from now on. `sample` tells what it gives anywhere, if
    /// that is the same everywhere.
    pub(crate) fn decide(&self, index: usize, sample: impl FnOnce() -> Option<SurfaceSample>) {
        let decision = || match self.variant(index) {
            Err(unsupported) => Err(unsupported.clone()),
            Ok(bound) if bound.variant.is_constant() => {
                sample().map(Tier::Constant).ok_or_else(|| self.declined(index, "it always fails"))
            }
            Ok(bound) => self.native(index, bound),
        };
        self.slots[index].tier.get_or_init(|| decision().unwrap_or_else(Tier::Interpreted));
    }

    fn native(
        &self,
        index: usize,
        Bound { variant, uniforms }: &Bound,
    ) -> Result<Tier, Unsupported> {
        let shader = &variant.shader;
        if self.are_limits_tight(shader) {
            return Err(self.declined(index, "the limits on it are tight"));
        }
        let compile = || {
            let code = self.generating.measure(|| self.code(index, shader, None))?;
            self.announce(index, &code);
            Ok(Arc::new(code))
        };
        let code = variant.code.get_or_init(compile).clone()?;
        let fuel = self.fuel(shader);
        self.slots[index].native.get_or_init(|| (Native::new(code, uniforms, fuel), variant.needs));
        let batch = || self.generating.measure(|| batch::build(shader));
        if variant.batch.get_or_init(batch).as_ref().is_some_and(|batch| batch.pays) {
            self.has_batches.store(true, Ordering::Relaxed);
        }
        Ok(Tier::Native)
    }

    /// Whether the interpreter may run into limits before a shader takes fuel.
    pub(crate) fn are_limits_tight(&self, shader: &Shader) -> bool {
        self.limits.fuel < shader.main.costs.fuel
            || self.limits.max_depth < shader.main.costs.depth
            || self.limits.max_memory < MIN_MEMORY
            // Half is left to what the interpreter needs besides.
            || self.limits.max_memory / 2 < shader.main.costs.memory
    }

    /// Tells the observer of code for a surface.
    pub(crate) fn announce<F>(&self, index: usize, code: &Code<F>) {
        if let Some(observer) = self.observer {
            let span = self.span(index);
            for (address, n_bytes) in code.parts() {
                observer(Region { span, address, n_bytes });
            }
        }
    }

    /// Machine code for a surface; `text` is filled with the forms that it takes on the way.
    pub(crate) fn code(
        &self,
        index: usize,
        shader: &Shader,
        text: Option<&mut Text>,
    ) -> Result<Code, Unsupported> {
        let isa = isa().ok_or("there is no code generator for this processor".to_owned());
        isa.and_then(|isa| Code::compile(shader, self.max_calls(shader), &isa, text))
            .map_err(|reason| self.declined(index, &reason))
    }

    /// The variant of a surface, specialized now if it was not.
    pub(crate) fn variant(&self, index: usize) -> &Result<Bound, Unsupported> {
        self.slots[index].variant.get_or_init(|| {
            let (outline, cell) = self.cell(&self.surfaces[index]);
            let variant = cell.get_or_init(|| {
                let work = || specialize(&self.program.bytecode, &outline, Version::Plain);
                let shader = self.specializing.measure(work)?;
                let needs = needs(&shader);
                Ok(Arc::new(Variant {
                    shader,
                    needs,
                    spent: AtomicU64::new(0),
                    code: OnceLock::new(),
                    batch: OnceLock::new(),
                    bounded: Default::default(),
                    signed: OnceLock::new(),
                }))
            });
            variant.clone().map(|variant| Bound { variant, uniforms: outline.uniforms })
        })
    }

    /// The outline of a closure and the place for what it is specialized to.
    pub(crate) fn cell(&self, closure: &Arc<Closure>) -> (Outline, Arc<Cell>) {
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        let mut outlined = outline(closure, false);
        let n_variants = cache.n_variants.get(&closure.function).copied().unwrap_or(0);
        if n_variants >= MAX_VARIANTS && !cache.by_key.contains_key(&outlined.key) {
            outlined = outline(closure, true);
        }
        if let Some(cell) = cache.by_key.get(&outlined.key) {
            return (outlined, cell.clone());
        }
        let cell = Arc::new(OnceLock::new());
        cache.by_key.insert(outlined.key.clone(), cell.clone());
        *cache.n_variants.entry(closure.function).or_default() += 1;
        (outlined, cell)
    }

    fn declined(&self, index: usize, reason: &str) -> Unsupported {
        Unsupported { span: self.span(index), reason: reason.to_owned() }
    }

    /// Fuel for rounds of loops and calls of routines; what runs once has been checked. Each pays for
    /// all of its body, and no body makes more memory than it pays for: what passes through those with
    /// arrays or closures leave fits into a quarter of the memory.
    pub(crate) fn fuel(&self, shader: &Shader) -> i64 {
        let by_memory = shader.bodies().filter(|body| body.costs.n_holders > 0).map(|body| {
            self.limits.max_memory / 4 / body.costs.memory.max(1) * body.costs.fuel.max(1)
        });
        let fuel = by_memory.fold(self.limits.fuel, u64::min);
        i64::try_from(fuel).unwrap_or(i64::MAX)
    }

    /// How many calls of a shader's routines the interpreter can have active at once for sure.
    pub(crate) fn max_calls(&self, shader: &Shader) -> u64 {
        let bodies = || shader.routines.iter().map(|routine| routine.body.costs);
        let depth = self.limits.max_depth.saturating_sub(shader.main.costs.depth);
        let depth_of_call = bodies().map(|costs| costs.depth).max().unwrap_or(0).max(1);
        let memory_of_call = bodies().map(|costs| costs.memory).max().unwrap_or(0).max(1);
        // Half of the memory is left to what is made besides.
        let by_memory = self.limits.max_memory / 2 / memory_of_call;
        by_memory.min((depth / depth_of_call) as u64)
    }

    fn span(&self, index: usize) -> Span {
        let function = self.surfaces[index].function as usize;
        self.program.bytecode.functions[function].span
    }
}

/// What a shader's results, and that it has results, depend on.
pub(crate) fn needs(shader: &Shader) -> Needs {
    let live = shader.main.live();
    let [face, u, v] = [FACE, U, V].map(|argument| live[argument.0 as usize]);
    Needs { face, u, v }
}

/// Evaluates surfaces for one thread.
pub struct NativeSurfaces<'s> {
    pub(crate) shaders: &'s Shaders<'s>,
    /// Those of the shaders.
    slots: &'s [Slot],
    pub(crate) interpreter: InterpSurfaces<'s>,
    lanes: Lanes,
}

impl SurfaceEval for NativeSurfaces<'_> {
    type Error = Box<Error>;

    #[inline(always)]
    fn eval(&mut self, surface: SurfaceId, at: &impl Locate) -> Result<SurfaceSample, Box<Error>> {
        let slot = &self.slots[surface.0 as usize];
        if let Some((native, needs)) = slot.native.get() {
            let SurfacePoint { face, u, v } = at.locate(*needs);
            if let Some(sample) = native.call(face, u, v) {
                return Ok(sample);
            }
        } else if let Some(Tier::Constant(sample)) = slot.tier.get() {
            return Ok(in_registers(sample));
        }
        // A copy is handed on, so that the place itself may stay in registers.
        let at = at.locate(Needs::ALL);
        self.interpret(surface, &at).map(|sample| in_registers(&sample))
    }

    fn constant(&mut self, surface: SurfaceId) -> Option<SurfaceSample> {
        let anywhere = SurfacePoint { face: 0, u: 0.0, v: 0.0 };
        let NativeSurfaces { shaders, interpreter, .. } = self;
        shaders.constant(surface.0 as usize, || interpreter.eval(surface, &anywhere).ok())
    }

    fn has_batches(&self) -> bool {
        self.shaders.has_batches.load(Ordering::Relaxed)
    }

    fn batch_needs(&self, surface: SurfaceId) -> Option<Needs> {
        let slot = &self.shaders.slots[surface.0 as usize];
        slot.batch().filter(|(batch, _)| batch.pays).map(|(_, bound)| bound.variant.needs)
    }

    fn eval_batch(
        &mut self,
        surface: SurfaceId,
        points: &[SurfacePoint],
        samples: &mut Vec<Option<SurfaceSample>>,
    ) {
        match self.shaders.slots[surface.0 as usize].batch() {
            Some((batch, bound)) => {
                let tables = &bound.variant.shader.tables;
                batch.run(tables, &bound.uniforms, points, &mut self.lanes, samples);
            }
            None => samples.extend(points.iter().map(|_| None)),
        }
    }

    #[inline]
    fn eval_signed(
        &mut self,
        surface: SurfaceId,
        at: &impl Locate,
    ) -> Result<(SurfaceSample, Signature), Box<Error>> {
        self.sign(surface, at)
    }

    #[inline(always)]
    fn eval_bounded(
        &mut self,
        surface: SurfaceId,
        at: &impl LocateBounded,
    ) -> Option<BoundedSample> {
        self.bounds(surface, at)
    }
}

impl NativeSurfaces<'_> {
    /// Asks the interpreter, and sees whether that has become too slow. It counts as cold, so that the way
    /// of native code through [`SurfaceEval::eval`] is the straight one.
    #[cold]
    #[inline(never)]
    fn interpret(
        &mut self,
        surface: SurfaceId,
        at: &SurfacePoint,
    ) -> Result<SurfaceSample, Box<Error>> {
        let sample = self.interpreter.eval(surface, at)?;
        let index = surface.0 as usize;
        if self.shaders.slots[index].tier.get().is_none() {
            self.shaders.warm_up(index, self.interpreter.fuel_used(), sample);
        }
        Ok(sample)
    }
}
