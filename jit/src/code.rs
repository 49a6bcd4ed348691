//! Executable memory, the calls into it, and how their results are loaded: all the `unsafe` code of the
//! project.
//!
//! Code is written to memory that is writable, which then becomes executable and never writable
//! again. It lives as long as the [`Code`] that owns it.
#![expect(unsafe_code, reason = "owns executable memory and calls into it")]

use std::mem::{ManuallyDrop, MaybeUninit};
use std::sync::{Arc, OnceLock};

use cranelift_codegen::Context;
use cranelift_codegen::ir::Signature;
use cranelift_codegen::isa::OwnedTargetIsa;
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::FunctionBuilderContext;
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Module, default_libcall_names};
use glam::DVec3;
use renderer::signature::Signature as Decisions;
use renderer::surface::{Bounded, BoundedSample, SurfaceSample};
use vm::surfaces;

use crate::abi::{BoundedFn, BoundedOut, DONE, SignedFn, SignedOut, SurfaceFn, SurfaceOut};
use crate::lower::{self, Surroundings};
use crate::sir::{ROW_LEN, Shader, Version};
use crate::text::{self, Names, Text};

/// What a call may take of the native stack, with the routines that it calls. Threads have 2 MiB, unless
/// told otherwise.
const STACK_BYTES: u64 = 256 << 10;

/// What one frame may take of it.
const MAX_FRAME: u64 = STACK_BYTES / 4;

/// The part of a frame that is not below its frame pointer: that and the return address.
const FRAME_EDGE: u64 = 16;

/// The machine code of one shader, which is called as `F`, and its tables.
pub(crate) struct Code<F = SurfaceFn> {
    entry: F,
    /// Addresses and sizes of the functions that it consists of.
    parts: Vec<(usize, usize)>,
    /// What the code reads by address: its tables, one after the other.
    _tables: Box<[Aligned]>,
    _memory: Memory,
    n_uniforms: u32,
    pub(crate) n_bytes: usize,
}

/// Entries of a table, such that a point, or two numbers of it, lie in one line of the cache.
#[repr(align(32))]
struct Aligned(#[expect(dead_code, reason = "read by machine code")] [u64; ROW_LEN]);

/// A module that gives its memory back.
struct Memory(ManuallyDrop<JITModule>);

// SAFETY: `JITModule` is `Send`; nothing here gives out references to it, and its memory does not
// change once the definitions are finalized.
unsafe impl Sync for Memory {}

impl Drop for Memory {
    fn drop(&mut self) {
        // SAFETY: the module is taken once, here. Its code runs only in methods of `Code`, which borrow
        // the `Code` that owns this memory, and of `Native`, which borrow a share of it: so no call is
        // active and none can follow.
        unsafe { ManuallyDrop::take(&mut self.0).free_memory() }
    }
}

/// The instruction set of this machine; none where there is no code generator for it.
pub(crate) fn isa() -> Option<OwnedTargetIsa> {
    static ISA: OnceLock<Option<OwnedTargetIsa>> = OnceLock::new();
    let make = || {
        let mut flags = settings::builder();
        let options = [
            ("opt_level", "speed"),
            ("is_pic", "false"),
            ("use_colocated_libcalls", "false"),
            ("unwind_info", "false"),
            ("enable_probestack", "false"),
            // Programs are not trusted: what is wrong with the code is found before it is compiled.
            ("enable_verifier", "true"),
        ];
        for (name, value) in options {
            flags.set(name, value).ok()?;
        }
        cranelift_native::builder().ok()?.finish(settings::Flags::new(flags)).ok()
    };
    ISA.get_or_init(make).clone()
}

impl<F> Code<F> {
    /// Compiles a shader; `entry` makes what is called of the address of a function with the
    /// signature that `lower` gives the shader.
    fn make(
        shader: &Shader,
        max_calls: u64,
        isa: &OwnedTargetIsa,
        text: Option<&mut Text>,
        entry: impl FnOnce(*const u8) -> F,
    ) -> Result<Self, String> {
        let tables: Box<[Aligned]> =
            shader.tables.iter().flat_map(|table| &table.rows).copied().map(Aligned).collect();
        let address = tables.as_ptr().cast::<u64>();
        let builder = JITBuilder::with_isa(isa.clone(), default_libcall_names());
        let mut memory = Memory(ManuallyDrop::new(JITModule::new(builder)));
        let mut making = Making {
            module: &mut memory.0,
            shader,
            tables: address,
            context: Context::new(),
            builder: FunctionBuilderContext::new(),
            max_frame: 0,
            text: text.map(|text| (text, Names::new(address))),
        };
        let made = making.make(max_calls)?;
        memory.0.finalize_definitions().map_err(words)?;
        let address_of = |id| memory.0.get_finalized_function(id);
        let parts = made.iter().map(|(id, n_bytes)| (address_of(*id) as usize, *n_bytes)).collect();
        let n_bytes = made.iter().map(|(_, n_bytes)| n_bytes).sum();
        let entry = entry(address_of(made[0].0));
        let n_uniforms = shader.n_uniforms;
        Ok(Code { entry, parts, _tables: tables, _memory: memory, n_uniforms, n_bytes })
    }

    /// Numbers of an environment: fuel, and the uniforms.
    fn environment_len(&self) -> usize {
        1 + self.n_uniforms as usize
    }

    /// The addresses and sizes of its functions.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (usize, usize)> {
        self.parts.iter().copied()
    }
}

impl Code {
    /// Compiles a shader, at most `max_calls` calls of whose routines may be active at once; `text` is
    /// filled with the forms that it takes on the way.
    ///
    /// # Errors
    /// Cranelift's words for what it cannot do.
    pub(crate) fn compile(
        shader: &Shader,
        max_calls: u64,
        isa: &OwnedTargetIsa,
        text: Option<&mut Text>,
    ) -> Result<Self, String> {
        assert_eq!(shader.version, Version::Plain);
        Code::make(shader, max_calls, isa, text, |address| {
            // SAFETY: the address is that of the function just defined, to which `lower` gives the
            // signature of `SurfaceFn`, as the shader is plain; it stays valid while the memory lives,
            // which the `Code` owns.
            unsafe { std::mem::transmute::<*const u8, SurfaceFn>(address) }
        })
    }
}

/// What a shader has returned and left.
#[inline(always)]
fn sample(red: f64, out: &SurfaceOut) -> SurfaceSample {
    let SurfaceOut { green, blue, kd, ks, phong_exp } = out;
    let [green, blue, kd, ks, phong_exp] = [green, blue, kd, ks, phong_exp].map(load);
    SurfaceSample { color: DVec3::new(red, green, blue), kd, ks, phong_exp }
}

/// The same sample, in registers as what native code has left: where several ways of evaluation meet,
/// the compiler would pack the numbers of all of them into vectors, and unpack those.
#[inline(always)]
pub(crate) fn in_registers(sample: &SurfaceSample) -> SurfaceSample {
    let SurfaceSample { color: DVec3 { x, y, z }, kd, ks, phong_exp } = sample;
    let [x, y, z, kd, ks, phong_exp] = [x, y, z, kd, ks, phong_exp].map(load);
    SurfaceSample { color: DVec3::new(x, y, z), kd, ks, phong_exp }
}

/// Loads a number by itself, so that it lies within a single store: the compiler would load two or four
/// at once, which span several stores, and wait until those have reached the cache.
#[inline(always)]
fn load(number: &f64) -> f64 {
    // SAFETY: a reference is valid for reading.
    unsafe { std::ptr::from_ref(number).read_volatile() }
}

impl Code<BoundedFn> {
    /// Compiles a bounded shader, at most `max_calls` calls of whose routines may be active at once.
    ///
    /// # Errors
    /// Cranelift's words for what it cannot do.
    pub(crate) fn compile_bounded(
        shader: &Shader,
        max_calls: u64,
        isa: &OwnedTargetIsa,
    ) -> Result<Self, String> {
        assert_eq!(shader.version, Version::Bounded);
        Code::make(shader, max_calls, isa, None, |address| {
            // SAFETY: the address is that of the function just defined, to which `lower` gives the
            // signature of `BoundedFn`, as the shader is bounded; it stays valid while the memory
            // lives, which the `Code` owns.
            unsafe { std::mem::transmute::<*const u8, BoundedFn>(address) }
        })
    }

    /// Calls the bounded shader; none if it has left.
    #[inline(always)]
    fn call(&self, environment: &[u64], face: u8, u: Bounded, v: Bounded) -> Option<BoundedSample> {
        assert_eq!(environment.len(), self.environment_len(), "a shader and its uniforms fit");
        let (environment, face) = (environment.as_ptr(), i64::from(face));
        let mut out = MaybeUninit::<BoundedOut>::uninit();
        // SAFETY: as for plain shaders: `entry` is finalized code of this signature in memory that
        // `self` owns. It reads fuel and as many uniforms as it was compiled for, which has been
        // checked, and tables that `self` owns, at checked indices; it writes nothing but `out`, does
        // not unwind, and takes no more of the stack than `STACK_BYTES`.
        let status = unsafe {
            (self.entry)(environment, face, u.value, v.value, u.error, v.error, out.as_mut_ptr())
        };
        if status != DONE {
            return None;
        }
        // SAFETY: code that returns `DONE` has written all results.
        let BoundedOut { values, errors } = unsafe { out.assume_init_ref() };
        let [red, green, blue, kd, ks, phong_exp] = std::array::from_fn(|index| {
            surfaces::bounded(load(&values[index]), load(&errors[index]))
        });
        Some(BoundedSample { color: [red, green, blue], kd, ks, phong_exp })
    }
}

impl Code<SignedFn> {
    /// Compiles a signed shader, at most `max_calls` calls of whose routines may be active at once.
    ///
    /// # Errors
    /// Cranelift's words for what it cannot do.
    pub(crate) fn compile_signed(
        shader: &Shader,
        max_calls: u64,
        isa: &OwnedTargetIsa,
    ) -> Result<Self, String> {
        assert_eq!(shader.version, Version::Signed);
        Code::make(shader, max_calls, isa, None, |address| {
            // SAFETY: the address is that of the function just defined, to which `lower` gives the
            // signature of `SignedFn`, as the shader is signed; it stays valid while the memory lives,
            // which the `Code` owns.
            unsafe { std::mem::transmute::<*const u8, SignedFn>(address) }
        })
    }

    /// Calls the signed shader; none if it has left. The environment is of the length that it was
    /// compiled for.
    #[inline]
    fn call(
        &self,
        environment: &[u64],
        face: u8,
        u: f64,
        v: f64,
    ) -> Option<(SurfaceSample, Decisions)> {
        let mut out = MaybeUninit::<SignedOut>::uninit();
        // SAFETY: as for plain shaders: `entry` is finalized code of this signature in memory that
        // `self` owns. It reads an environment of the length that it was compiled for, which `Native`
        // passes, and tables that `self` owns, at checked indices; it writes nothing but `out`, does
        // not unwind, and takes no more of the stack than `STACK_BYTES`.
        let status =
            unsafe { (self.entry)(environment.as_ptr(), i64::from(face), u, v, out.as_mut_ptr()) };
        if status != DONE {
            return None;
        }
        // SAFETY: code that returns `DONE` has written all results.
        let out = unsafe { out.assume_init_ref() };
        Some((sample(out.red, &out.sample), Decisions(out.decisions)))
    }
}

/// The making of a shader's code.
struct Making<'m> {
    module: &'m mut JITModule,
    shader: &'m Shader,
    tables: *const u64,
    context: Context,
    builder: FunctionBuilderContext,
    /// Bytes of the largest frame so far.
    max_frame: u64,
    text: Option<(&'m mut Text, Names)>,
}

impl Making<'_> {
    /// Defines the routines, then the main body. Returns the functions with their sizes in bytes, the
    /// main body's first.
    fn make(&mut self, max_calls: u64) -> Result<Vec<(FuncId, usize)>, String> {
        let routines = &self.shader.routines;
        let signatures: Vec<Signature> = routines
            .iter()
            .map(|routine| lower::routine_signature(routine, self.shader.version))
            .collect();
        let ids = signatures
            .iter()
            .map(|signature| self.declare(signature))
            .collect::<Result<Vec<FuncId>, String>>()?;
        let mut made = Vec::new();
        for (number, (id, signature)) in ids.iter().zip(signatures).enumerate() {
            made.push((*id, self.define(*id, signature, &ids, Some(number), 0)?));
        }
        let config = self.module.target_config();
        let signature =
            lower::signature(self.shader, config.default_call_conv, config.pointer_type());
        let main = self.declare(&signature)?;
        // A call that finds none left has a frame, too.
        let n_frames = (STACK_BYTES - MAX_FRAME) / self.max_frame.max(1);
        let max_calls = max_calls.min(n_frames.saturating_sub(1));
        made.insert(0, (main, self.define(main, signature, &ids, None, max_calls as i64)?));
        Ok(made)
    }

    fn declare(&mut self, signature: &Signature) -> Result<FuncId, String> {
        self.module.declare_anonymous_function(signature).map_err(words)
    }

    /// Returns the size of the code.
    fn define(
        &mut self,
        id: FuncId,
        signature: Signature,
        routines: &[FuncId],
        number: Option<usize>,
        max_calls: i64,
    ) -> Result<usize, String> {
        self.context.clear();
        let function = &mut self.context.func;
        function.signature = signature;
        let routines = routines.iter().map(|id| {
            let routine = self.module.declare_func_in_func(*id, function);
            // Called by its absolute address: however far away its code lies, it is in reach.
            function.dfg.ext_funcs[routine].colocated = false;
            routine
        });
        let around = Surroundings {
            shader: self.shader,
            tables: self.tables,
            routines: routines.collect(),
            max_calls,
            config: self.module.target_config(),
        };
        let sites = lower::lower(&around, number, &mut self.context.func, &mut self.builder);
        if let Some((text, names)) = &mut self.text {
            if !self.shader.routines.is_empty() {
                let name = number.map_or("shader".to_owned(), |n| text::routine(n as u32));
                text.clif.push(text::label(format!("{name}:")));
                text.asm.push(text::label(format!("{name}:")));
            }
            text.clif.extend(text::clif(&self.context.func, &sites, names));
            self.context.set_disasm(text::NEEDS_VCODE);
        }
        self.module.define_function(id, &mut self.context).map_err(words)?;
        let compiled = self.context.compiled_code().expect("just compiled");
        if let Some((text, names)) = &mut self.text {
            text.asm.extend(text::asm(&self.context.func, compiled, &sites, names));
        }
        let frame =
            compiled.buffer.frame_layout().map_or(u32::MAX, |frame| frame.frame_to_fp_offset);
        self.max_frame = self.max_frame.max(u64::from(frame) + FRAME_EDGE);
        if self.max_frame > MAX_FRAME {
            return Err("it needs too much of the stack".to_owned());
        }
        Ok(compiled.code_buffer().len())
    }
}

fn words(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// A shader with the uniforms of one closure.
#[derive(Clone)]
pub(crate) struct Native<F = SurfaceFn> {
    /// That of the code, here so that a call need not look there.
    entry: F,
    /// What a call may use up in loops and routines, and the uniforms.
    environment: Box<[u64]>,
    pub(crate) code: Arc<Code<F>>,
}

impl<F: Copy> Native<F> {
    pub(crate) fn new(code: Arc<Code<F>>, uniforms: &[u64], fuel: i64) -> Self {
        let environment: Box<[u64]> =
            [fuel as u64].into_iter().chain(uniforms.iter().copied()).collect();
        assert_eq!(environment.len(), code.environment_len(), "a shader and its uniforms fit");
        Native { entry: code.entry, environment, code }
    }
}

impl Native<SignedFn> {
    /// Calls the signed shader; none if it has left.
    #[inline]
    pub(crate) fn call(&self, face: u8, u: f64, v: f64) -> Option<(SurfaceSample, Decisions)> {
        self.code.call(&self.environment, face, u, v)
    }
}

impl Native {
    pub(crate) fn n_uniforms(&self) -> u32 {
        self.code.n_uniforms
    }

    /// Calls the shader; none if the interpreter must do it.
    #[inline(always)]
    pub(crate) fn call(&self, face: u8, u: f64, v: f64) -> Option<SurfaceSample> {
        let Native { entry, environment, code: _ } = self;
        let mut out = MaybeUninit::uninit();
        // SAFETY: `entry` is finalized code of this signature, in memory of `code`, which `self` owns a
        // share of. It reads an environment of the length that it was compiled for, which `new` has
        // checked, and tables of `code`, at checked indices; and it writes nothing but `out`. It does
        // not unwind: the functions that it calls do not panic. What it takes of the stack is bounded by
        // `STACK_BYTES`.
        let red = unsafe { entry(environment.as_ptr(), i64::from(face), u, v, out.as_mut_ptr()) };
        if red.is_nan() {
            return None;
        }
        // SAFETY: code that returns a number has written all other results.
        Some(sample(red, unsafe { out.assume_init_ref() }))
    }

    /// Calls the bounded version of the shader; none if it has left.
    #[inline(always)]
    pub(crate) fn call_bounded(
        &self,
        code: &Code<BoundedFn>,
        face: u8,
        u: Bounded,
        v: Bounded,
    ) -> Option<BoundedSample> {
        code.call(&self.environment, face, u, v)
    }
}
