//! What a shader became on its way to machine code, as text.
//!
//! CLIF is shown as it is handed to Cranelift, before its optimizer. Machine code is decoded from the
//! bytes that are executed; where the project has no decoder for the processor, Cranelift's own words
//! for its instructions stand in, which know no offsets and no origins.

use std::collections::HashMap;

use cranelift_codegen::CompiledCode;
use cranelift_codegen::ir::{Function, Inst, InstructionData, Opcode, SourceLoc};
use cranelift_codegen::write::write_block_header;
#[cfg(target_arch = "x86_64")]
use cranelift_codegen::{FinalizedMachReloc, FinalizedRelocTarget, ir::ExternalName};

use crate::runtime;
use crate::sir::Site;

/// Whether machine code is shown in Cranelift's words.
pub(crate) const NEEDS_VCODE: bool = cfg!(not(target_arch = "x86_64"));

/// A line of CLIF or of machine code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Where the instruction starts, in bytes from the start of the code; none for labels and CLIF.
    pub offset: Option<u32>,
    /// The text. Instructions are indented, labels are not.
    pub text: String,
    /// The bytecode instruction that it comes from; none for what serves the shader as a whole, or
    /// what the optimizer made up.
    pub site: Option<Site>,
}

/// The forms of one shader: its routines, if it has any, each under its name, and its own.
#[derive(Debug, Default)]
pub(crate) struct Text {
    pub(crate) clif: Vec<Line>,
    pub(crate) asm: Vec<Line>,
}

/// Names for addresses, which are different in each run.
#[derive(Clone)]
pub(crate) struct Names(HashMap<u64, String>);

impl Names {
    /// Names for the functions that shaders call, and for a shader's tables.
    pub(crate) fn new(tables: *const u64) -> Self {
        let functions = runtime::functions()
            .map(|(op, function)| (function as usize as u64, op.spelling().to_owned()));
        Names(functions.chain([(tables as u64, "tables".to_owned())]).collect())
    }

    pub(crate) fn get(&self, address: u64) -> Option<&str> {
        self.0.get(&address).map(String::as_str)
    }
}

/// The lines of a function before it is compiled.
pub(crate) fn clif(function: &Function, sites: &[Site], names: &Names) -> Vec<Line> {
    let mut lines = Vec::new();
    for block in function.layout.blocks() {
        let mut header = String::new();
        // The block's name starts four columns before its instructions.
        let _ = write_block_header(&mut header, function, block, 4);
        lines.push(label(header.trim_end().to_owned()));
        lines.extend(function.layout.block_insts(block).map(|inst| Line {
            offset: None,
            text: format!("    {}", instruction(function, inst, names)),
            site: site(function.srcloc(inst), sites),
        }));
    }
    lines
}

fn instruction(function: &Function, inst: Inst, names: &Names) -> String {
    let dfg = &function.dfg;
    let text = dfg.display_inst(inst).to_string();
    // Cranelift repeats the constants among the operands in a comment.
    let bare = text.split("  ; ").next().unwrap_or_default();
    match dfg.insts[inst] {
        InstructionData::UnaryImm { opcode: Opcode::Iconst, imm } => {
            match names.get(imm.bits() as u64) {
                Some(name) => format!("{} = iconst.i64 {name}", dfg.first_result(inst)),
                None => bare.to_owned(),
            }
        }
        InstructionData::UnaryIeee64 { imm, .. } => {
            // Cranelift writes reals in base 16.
            let decimal = format!("{:?}", f64::from_bits(imm.bits()));
            let is_plain = bare.ends_with(&format!(" {decimal}"));
            if is_plain { bare.to_owned() } else { format!("{bare}    ; {decimal}") }
        }
        InstructionData::UnaryConst { constant_handle, .. } => {
            let halves = dfg.constants.get(constant_handle).as_slice().chunks(8);
            let reals = halves.filter_map(|half| Some(f64::from_le_bytes(half.try_into().ok()?)));
            let reals: Vec<String> = reals.map(|real| format!("{real:?}")).collect();
            format!("{bare}    ; {}", reals.join(", "))
        }
        _ => bare.to_owned(),
    }
}

/// The lines of the compiled function.
pub(crate) fn asm(
    function: &Function,
    compiled: &CompiledCode,
    sites: &[Site],
    names: &Names,
) -> Vec<Line> {
    #[cfg(target_arch = "x86_64")]
    return crate::decode::lines(compiled, sites, names.clone(), routines(function, compiled));
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = (function, sites, names);
        let text = compiled.vcode.as_deref().unwrap_or_default();
        text.lines().map(|line| label(line.to_owned())).collect()
    }
}

/// The routines whose addresses will be in the code, by where.
#[cfg(target_arch = "x86_64")]
fn routines(function: &Function, compiled: &CompiledCode) -> HashMap<u64, String> {
    let names = function.params.user_named_funcs();
    let routine = |relocation: &FinalizedMachReloc| match relocation.target {
        FinalizedRelocTarget::ExternalName(ExternalName::User(name)) => {
            Some((u64::from(relocation.offset), routine(names[name].index)))
        }
        _ => None,
    };
    compiled.buffer.relocs().iter().filter_map(routine).collect()
}

/// What a routine is called. Routines are declared first, in their order.
pub(crate) fn routine(number: u32) -> String {
    format!("routine{number}")
}

pub(crate) fn label(text: String) -> Line {
    Line { offset: None, text, site: None }
}

/// The site that a source location stands for; the default one stands for none.
pub(crate) fn site(location: SourceLoc, sites: &[Site]) -> Option<Site> {
    sites.get(location.bits() as usize).copied()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use compiler::diagnostic::Diagnostic;
    use compiler::preprocess::NoIncludes;
    use compiler::source::SourceMap;
    use vm::host::{Host, RenderJob};
    use vm::machine::{Limits, Machine};
    use vm::program::LoadedProgram;
    use vm::value::Value;

    use super::*;
    use crate::code::{Code, isa};
    use crate::outline::outline;
    use crate::sir::{Shader, Version};
    use crate::specialize::specialize;

    /// A loop, conditions, a choice among functions, a table, calls and uniforms.
    const PROGRAM: &str = "\
[ { /x x 2.0 mulf } { sin } { /x x x mulf } ] /functions
[ 0.25 0.5 0.75 ] /table
0.5 0.25 1.0 point /color
{ /self /n /x n 9 lessi { x x mulf color gety addf n 1 addi self self apply } { x } if } /iterate
{ /v /u /face
  u 0 iterate iterate apply /a
  v 0.5 lessf { a sqrt } { a frac table face get addf } if /b
  functions face get /f b f apply /c
  c a c point b c 1.0 }
";

    struct NoRender;

    impl Host for NoRender {
        fn render(&mut self, _: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
            unreachable!("the program does not render")
        }
    }

    fn shader() -> Shader {
        let mut sources = SourceMap::default();
        let file = sources.add("case.gml", PROGRAM.as_bytes().to_vec()).expect("short");
        let bytecode =
            compiler::compile(&mut sources, file, &mut NoIncludes, &[]).expect("correct");
        let program = Arc::new(LoadedProgram::new(bytecode));
        let limits = Limits { fuel: 10_000, max_depth: 100, max_memory: 1 << 30 };
        let Ok(stack) = Machine::new(&program, limits).run(&mut NoRender) else {
            panic!("it fails")
        };
        let [Value::Closure(closure)] = &stack[..] else { panic!("no function") };
        specialize(&program.bytecode, &outline(closure, false), Version::Plain)
            .expect("it can be compiled")
    }

    fn text(shader: &Shader) -> Text {
        let mut text = Text::default();
        let isa = isa().expect("tests run where there is a code generator");
        Code::compile(shader, 100, &isa, Some(&mut text)).expect("it compiles");
        text
    }

    /// Instructions and their offsets are the same, whether or not their origins are known.
    #[test]
    fn origins_do_not_change_the_code() {
        let mut shader = shader();
        let with = text(&shader);
        for block in &mut shader.main.blocks {
            block.site = Site::default();
            block.insts.iter_mut().for_each(|(.., site)| *site = Site::default());
            block.term.iter_mut().for_each(|(_, site)| *site = Site::default());
        }
        let without = text(&shader);
        let bare = |lines: &[Line]| -> Vec<_> {
            lines.iter().map(|line| (line.offset, line.text.clone())).collect()
        };
        assert!(with.asm.len() > 80, "{} lines", with.asm.len());
        assert_eq!(bare(&with.clif), bare(&without.clif));
        assert_eq!(bare(&with.asm), bare(&without.asm));
        let sites = |lines: &[Line]| -> std::collections::HashSet<_> {
            lines.iter().filter_map(|line| line.site).collect()
        };
        assert_eq!(sites(&without.clif).len(), 1);
        assert!(sites(&with.clif).len() > 10 && (NEEDS_VCODE || sites(&with.asm).len() > 10));
    }
}
