//! Executable memory, and the calls into it: all the `unsafe` code of the project.
//!
//! Code is written to memory that is writable, which then becomes executable and never writable
//! again. It lives as long as the [`Code`] that owns it.
#![expect(unsafe_code, reason = "owns executable memory and calls into it")]

use std::mem::{ManuallyDrop, MaybeUninit};
use std::sync::{Arc, OnceLock};

use cranelift_codegen::Context;
use cranelift_codegen::isa::OwnedTargetIsa;
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::FunctionBuilderContext;
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{Module, default_libcall_names};
use glam::DVec3;
use renderer::surface::SurfaceSample;

use crate::abi::{DONE, SurfaceFn, SurfaceOut};
use crate::lower;
use crate::sir::Shader;
use crate::text::{self, Names, Text};

/// The machine code of one shader, and its tables.
pub(crate) struct Code {
    entry: SurfaceFn,
    /// What the code reads by address.
    _tables: Vec<Box<[u64]>>,
    _memory: Memory,
    pub(crate) n_bytes: usize,
}

/// A module that gives its memory back.
struct Memory(ManuallyDrop<JITModule>);

// SAFETY: `JITModule` is `Send`; nothing here gives out references to it, and its memory does not
// change once the definitions are finalized.
unsafe impl Sync for Memory {}

impl Drop for Memory {
    fn drop(&mut self) {
        // SAFETY: the module is taken once, here. Its code runs only in `Code::call`, which borrows
        // the `Code` that owns this memory, so that no call is active and none can follow.
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

impl Code {
    /// Compiles a shader; `text` is filled with the forms that it takes on the way.
    ///
    /// # Errors
    /// Cranelift's words for what it cannot do.
    pub(crate) fn compile(
        shader: &Shader,
        isa: &OwnedTargetIsa,
        text: Option<&mut Text>,
    ) -> Result<Code, String> {
        let tables: Vec<Box<[u64]>> =
            shader.tables.iter().map(|table| table.entries.clone().into_boxed_slice()).collect();
        let addresses: Vec<*const u64> = tables.iter().map(|table| table.as_ptr()).collect();
        let builder = JITBuilder::with_isa(isa.clone(), default_libcall_names());
        let mut memory = Memory(ManuallyDrop::new(JITModule::new(builder)));
        let module = &mut memory.0;
        let mut context = Context::new();
        let config = module.target_config();
        context.func.signature = lower::signature(config.default_call_conv, config.pointer_type());
        let id = module
            .declare_anonymous_function(&context.func.signature)
            .map_err(|e| e.to_string())?;
        let sites = lower::lower(
            shader,
            &addresses,
            &mut context.func,
            &mut FunctionBuilderContext::new(),
            config,
        );
        let mut text = text.map(|text| (text, Names::new(&addresses)));
        if let Some((text, names)) = &mut text {
            text.clif = text::clif(&context.func, &sites, names);
            context.set_disasm(text::NEEDS_VCODE);
        }
        module.define_function(id, &mut context).map_err(|e| e.to_string())?;
        let compiled = context.compiled_code().ok_or("there is no code")?;
        if let Some((text, names)) = text {
            text.asm = text::asm(compiled, &sites, names);
        }
        let n_bytes = compiled.code_buffer().len();
        module.finalize_definitions().map_err(|e| e.to_string())?;
        let address = module.get_finalized_function(id);
        // SAFETY: the address is that of the function just defined, which `lower` gave the
        // signature of `SurfaceFn`; it stays valid while `memory` lives.
        let entry = unsafe { std::mem::transmute::<*const u8, SurfaceFn>(address) };
        Ok(Code { entry, _tables: tables, _memory: memory, n_bytes })
    }

    /// Where the code starts.
    pub(crate) fn address(&self) -> usize {
        self.entry as usize
    }

    /// Calls the shader; none if the interpreter must do it. `uniforms` are as many as the shader
    /// was compiled for.
    #[inline(always)]
    pub(crate) fn call(
        &self,
        uniforms: &[u64],
        face: u8,
        u: f64,
        v: f64,
        fuel: i64,
    ) -> Option<SurfaceSample> {
        let mut out = MaybeUninit::uninit();
        // SAFETY: `entry` is finalized code of this signature in memory that `self` owns. It reads
        // uniforms within the number that it was compiled for, which `Native` passes, and tables
        // that `self` owns, at checked indices; and it writes nothing but `out`. It does not unwind:
        // the functions that it calls do not panic.
        let status = unsafe {
            (self.entry)(uniforms.as_ptr(), i64::from(face), u, v, fuel, out.as_mut_ptr())
        };
        if status != DONE {
            return None;
        }
        // SAFETY: code that returns `DONE` has written all results.
        Some(sample(unsafe { out.assume_init_ref() }))
    }
}

/// What a shader has left. Each number is loaded by itself, as the shader has stored it: the
/// compiler would load two or four at once, and wait until those stores have reached the cache.
#[inline(always)]
fn sample(out: &SurfaceOut) -> SurfaceSample {
    // SAFETY: a reference is valid for reading.
    let load = |number: &f64| unsafe { std::ptr::from_ref(number).read_volatile() };
    let [red, green, blue] = &out.color;
    SurfaceSample {
        color: DVec3::new(load(red), load(green), load(blue)),
        kd: load(&out.kd),
        ks: load(&out.ks),
        phong_exp: load(&out.phong_exp),
    }
}

/// A shader with the uniforms of one closure.
#[derive(Clone)]
pub(crate) struct Native {
    pub(crate) code: Arc<Code>,
    uniforms: Box<[u64]>,
}

impl Native {
    /// `n_uniforms` is what the code was compiled for.
    pub(crate) fn new(code: Arc<Code>, n_uniforms: u32, uniforms: Vec<u64>) -> Self {
        assert_eq!(uniforms.len(), n_uniforms as usize, "a shader and its uniforms fit");
        Native { code, uniforms: uniforms.into_boxed_slice() }
    }

    pub(crate) fn n_uniforms(&self) -> u32 {
        self.uniforms.len() as u32
    }

    #[inline(always)]
    pub(crate) fn call(&self, face: u8, u: f64, v: f64, fuel: i64) -> Option<SurfaceSample> {
        self.code.call(&self.uniforms, face, u, v, fuel)
    }
}
