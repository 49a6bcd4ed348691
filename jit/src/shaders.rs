//! The shaders of one render job: which surfaces are constant, native or interpreted, and when that
//! is decided.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use compiler::source::Span;
use renderer::surface::{SurfaceEval, SurfaceId, SurfacePoint, SurfaceSample};
use vm::error::Error;
use vm::machine::Limits;
use vm::program::LoadedProgram;
use vm::surfaces::InterpSurfaces;
use vm::value::Closure;

use crate::code::{Code, Native, isa};
use crate::outline::{KeyItem, Outline, outline};
use crate::sir::{FACE, Needs, Shader, U, V};
use crate::specialize::specialize;
use crate::unsupported::Unsupported;

/// When surface functions are compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tiering {
    /// All at once.
    Eager,
    /// Each when it has been called so often that compiling it pays.
    Hot,
}

/// Calls of one function by interpretation before it is compiled. Compiling takes about as long as
/// a thousand such calls; twice that keeps what an image that ends here has lost to a few percent.
const HOT_CALLS: u32 = 2048;

/// Functions specialized in more ways than this on captured integers take those as uniforms.
const MAX_VARIANTS: usize = 16;

/// Less memory than this may be a limit that a surface function runs into.
const MIN_MEMORY: u64 = 64 << 20;

/// How a surface function is evaluated.
enum Tier {
    Constant(SurfaceSample),
    Native(Native),
    Interpreted(Unsupported),
}

/// How a surface function is evaluated, for reports.
#[derive(Clone, Debug, PartialEq)]
pub enum Evaluation {
    /// It ignores where it is asked.
    Constant,
    /// By machine code of so many bytes, with so many numbers that other surfaces may have
    /// different.
    Native {
        /// Bytes of code.
        n_bytes: usize,
        /// Uniforms.
        n_uniforms: u32,
    },
    /// By the interpreter, since it cannot be compiled.
    Declined(Unsupported),
    /// By the interpreter, since it has not been called often.
    Cold,
}

/// One surface function of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceReport {
    /// The function's source text.
    pub span: Span,
    /// How it is evaluated.
    pub evaluation: Evaluation,
}

/// The shaders of one render job, shared by its threads.
pub struct Shaders<'p> {
    program: &'p Arc<LoadedProgram>,
    surfaces: &'p [Arc<Closure>],
    limits: Limits,
    tiers: Vec<OnceLock<Tier>>,
    /// Calls by interpretation, by function.
    calls: Vec<AtomicU32>,
    cache: Mutex<Cache>,
}

#[derive(Default)]
struct Cache {
    by_key: HashMap<Vec<KeyItem>, Arc<OnceLock<Result<Compiled, Unsupported>>>>,
    n_variants: HashMap<u32, usize>,
}

/// What specializing a closure gave.
enum Compiled {
    /// Its results depend on uniforms at most.
    Constant,
    Native {
        code: Arc<Code>,
        n_uniforms: u32,
        needs: Needs,
    },
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
        let shaders = Shaders {
            program,
            surfaces,
            limits,
            tiers: surfaces.iter().map(|_| OnceLock::new()).collect(),
            calls: program.bytecode.functions.iter().map(|_| AtomicU32::new(0)).collect(),
            cache: Mutex::default(),
        };
        if tiering == Tiering::Eager {
            let mut interpreter = InterpSurfaces::new(program, surfaces, limits);
            for index in 0..surfaces.len() {
                shaders.tier(index, &mut interpreter);
            }
        }
        shaders
    }

    /// What one thread evaluates surfaces with.
    #[must_use]
    pub fn worker(&self) -> NativeSurfaces<'_> {
        NativeSurfaces {
            shaders: self,
            interpreter: InterpSurfaces::new(self.program, self.surfaces, self.limits),
        }
    }

    /// How each surface is evaluated by now.
    #[must_use]
    pub fn report(&self) -> Vec<SurfaceReport> {
        let of = |(closure, tier): (&Arc<Closure>, &OnceLock<Tier>)| {
            let span = self.program.bytecode.functions[closure.function as usize].span;
            let evaluation = match tier.get() {
                None => Evaluation::Cold,
                Some(Tier::Constant(_)) => Evaluation::Constant,
                Some(Tier::Native(native)) => Evaluation::Native {
                    n_bytes: native.code.n_bytes,
                    n_uniforms: native.n_uniforms(),
                },
                Some(Tier::Interpreted(unsupported)) => Evaluation::Declined(unsupported.clone()),
            };
            SurfaceReport { span, evaluation }
        };
        self.surfaces.iter().zip(&self.tiers).map(of).collect()
    }

    /// The tier of a surface, decided now if it was not.
    fn tier(&self, index: usize, interpreter: &mut InterpSurfaces<'_>) -> &Tier {
        self.tiers[index]
            .get_or_init(|| self.decide(index, interpreter).unwrap_or_else(Tier::Interpreted))
    }

    fn decide(
        &self,
        index: usize,
        interpreter: &mut InterpSurfaces<'_>,
    ) -> Result<Tier, Unsupported> {
        let closure = &self.surfaces[index];
        let (outline, cell) = self.cell(closure);
        let compiled = cell.get_or_init(|| self.compile(&outline));
        match compiled.as_ref().map_err(Clone::clone)? {
            Compiled::Constant => {
                let anywhere = SurfacePoint { face: 0, u: 0.0, v: 0.0 };
                match interpreter.eval(SurfaceId(index as u32), anywhere) {
                    Ok(sample) => Ok(Tier::Constant(sample)),
                    Err(_) => Err(self.declined(&outline, "it always fails")),
                }
            }
            Compiled::Native { needs, .. }
                if self.limits.fuel < needs.fuel
                    || self.limits.max_depth < needs.depth
                    || self.limits.max_memory < MIN_MEMORY =>
            {
                Err(self.declined(&outline, "the limits on it are tight"))
            }
            Compiled::Native { code, n_uniforms, .. } => {
                Ok(Tier::Native(Native::new(code.clone(), *n_uniforms, outline.uniforms)))
            }
        }
    }

    /// The outline of a closure and the place for what it compiles to.
    fn cell(
        &self,
        closure: &Arc<Closure>,
    ) -> (Outline, Arc<OnceLock<Result<Compiled, Unsupported>>>) {
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

    fn compile(&self, outline: &Outline) -> Result<Compiled, Unsupported> {
        let shader = specialize(&self.program.bytecode, outline)?;
        if is_constant(&shader) {
            return Ok(Compiled::Constant);
        }
        let Some(isa) = isa() else {
            return Err(self.declined(outline, "there is no code generator for this processor"));
        };
        let code = Code::compile(&shader, self.max_calls(&shader), &isa)
            .map_err(|error| self.declined(outline, &error))?;
        Ok(Compiled::Native {
            code: Arc::new(code),
            n_uniforms: shader.n_uniforms,
            needs: shader.main.needs,
        })
    }

    fn declined(&self, outline: &Outline, reason: &str) -> Unsupported {
        let span = self.program.bytecode.functions[outline.function as usize].span;
        Unsupported { span, reason: reason.to_owned() }
    }

    /// How many calls of a shader's routines the interpreter can have active at once for sure.
    fn max_calls(&self, shader: &Shader) -> u64 {
        let bodies = || shader.routines.iter().map(|routine| routine.body.needs);
        let depth = self.limits.max_depth.saturating_sub(shader.main.needs.depth);
        let depth_of_call = bodies().map(|needs| needs.depth).max().unwrap_or(0).max(1);
        let memory_of_call = bodies().map(|needs| needs.memory).max().unwrap_or(0).max(1);
        // Half of the memory is left to the main body, and to what the collector lets lie.
        let by_memory = self.limits.max_memory / 2 / memory_of_call;
        by_memory.min((depth / depth_of_call) as u64)
    }

    /// Fuel for rounds of loops; what runs once has been checked.
    fn loop_fuel(&self) -> i64 {
        i64::try_from(self.limits.fuel).unwrap_or(i64::MAX)
    }
}

/// Whether a shader's results, and that it has results, do not depend on where it is asked.
fn is_constant(shader: &Shader) -> bool {
    let live = shader.main.live();
    ![FACE, U, V].iter().any(|argument| live[argument.0 as usize])
}

/// Evaluates surfaces for one thread.
pub struct NativeSurfaces<'s> {
    shaders: &'s Shaders<'s>,
    interpreter: InterpSurfaces<'s>,
}

impl SurfaceEval for NativeSurfaces<'_> {
    type Error = Box<Error>;

    #[inline]
    fn eval(&mut self, surface: SurfaceId, at: SurfacePoint) -> Result<SurfaceSample, Box<Error>> {
        let index = surface.0 as usize;
        match self.shaders.tiers[index].get() {
            Some(Tier::Native(native)) => {
                match native.call(at.face, at.u, at.v, self.shaders.loop_fuel()) {
                    Some(out) => Ok(out.sample()),
                    None => self.interpreter.eval(surface, at),
                }
            }
            Some(Tier::Constant(sample)) => Ok(*sample),
            Some(Tier::Interpreted(_)) => self.interpreter.eval(surface, at),
            None => self.eval_cold(index, surface, at),
        }
    }
}

impl NativeSurfaces<'_> {
    #[cold]
    fn eval_cold(
        &mut self,
        index: usize,
        surface: SurfaceId,
        at: SurfacePoint,
    ) -> Result<SurfaceSample, Box<Error>> {
        let function = self.shaders.surfaces[index].function as usize;
        let calls = self.shaders.calls[function].fetch_add(1, Ordering::Relaxed);
        if calls >= HOT_CALLS {
            self.shaders.tier(index, &mut self.interpreter);
        }
        self.interpreter.eval(surface, at)
    }
}
