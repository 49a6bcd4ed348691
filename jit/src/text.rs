//! What a shader became on its way to machine code, as text.
//!
//! CLIF is shown as it is handed to Cranelift, before its optimizer. Machine code is decoded from the
//! bytes that are executed; where the project has no decoder for the processor, Cranelift's own words
//! for its instructions stand in, which know no offsets and no origins.

use std::collections::HashMap;

use cranelift_codegen::CompiledCode;
use cranelift_codegen::ir::{Function, Inst, InstructionData, Opcode, SourceLoc};
use cranelift_codegen::write::write_block_header;

use crate::runtime;
use crate::sir::Site;

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

/// The forms of one shader.
#[derive(Debug, Default)]
pub(crate) struct Text {
    pub(crate) clif: Vec<Line>,
    pub(crate) asm: Vec<Line>,
}

/// Names for addresses, which are different in each run.
pub(crate) struct Names(HashMap<u64, String>);

impl Names {
    /// Names for the functions that shaders call, and for a shader's tables.
    pub(crate) fn new(tables: &[*const u64]) -> Self {
        let tables = tables.iter().enumerate();
        let tables = tables.map(|(idx, address)| (*address as u64, format!("table{idx}")));
        let functions = runtime::functions()
            .map(|(op, function)| (function as usize as u64, op.spelling().to_owned()));
        Names(tables.chain(functions).collect())
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
        _ => bare.to_owned(),
    }
}

/// The lines of the compiled function.
pub(crate) fn asm(compiled: &CompiledCode, sites: &[Site], names: Names) -> Vec<Line> {
    #[cfg(target_arch = "x86_64")]
    return crate::decode::lines(compiled, sites, names);
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = (sites, names);
        let text = compiled.vcode.as_deref().unwrap_or_default();
        text.lines().map(|line| label(line.to_owned())).collect()
    }
}

pub(crate) fn label(text: String) -> Line {
    Line { offset: None, text, site: None }
}

/// The site that a source location stands for; the default one stands for none.
pub(crate) fn site(location: SourceLoc, sites: &[Site]) -> Option<Site> {
    sites.get(location.bits() as usize).copied()
}
