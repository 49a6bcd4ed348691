//! Bytecode as text, beside the source lines it came from.

use std::fmt::Write;

use crate::bytecode::{CaptureSource, Constant, Format, Function, Insn, Program};
use crate::op::Operator;
use crate::source::{SourceFile, SourceMap, Span};

/// Arrays in listings show this many items.
const SHOWN_ITEMS: usize = 8;

/// Source lines in listings show this many characters.
const SHOWN_CHARS: usize = 400;

/// The listing of one function.
#[must_use]
pub fn function(program: &Program, index: u32, sources: &SourceMap) -> String {
    let function = &program.functions[index as usize];
    let mut text = heading(program, index, sources);
    let mut lines = SourceLines::new(sources);
    for (pc, origin) in function.origins.iter().enumerate() {
        if let Some(line) = lines.before(origin.span) {
            let _ = writeln!(text, "  {line}");
        }
        let listed = format!("    {pc:04}  {}", instruction(program, index, pc));
        let _ = writeln!(text, "{listed:<56} ; {}", place(sources, origin.span));
    }
    text
}

/// One instruction of a function.
#[must_use]
pub fn instruction(program: &Program, index: u32, pc: usize) -> String {
    let function = &program.functions[index as usize];
    let insn = &function.code[pc];
    let fields = fields(program, function, pc, insn);
    format!("{:<17} {fields}", insn.op.mnemonic()).trim_end().to_owned()
}

/// The listings of all functions, the main program first.
#[must_use]
pub fn program(program: &Program, sources: &SourceMap) -> String {
    let all: Vec<u32> = (0..program.functions.len() as u32).rev().collect();
    functions(program, &all, sources)
}

/// The listings of some functions.
#[must_use]
pub fn functions(program: &Program, indices: &[u32], sources: &SourceMap) -> String {
    let listings: Vec<_> = indices.iter().map(|index| function(program, *index, sources)).collect();
    listings.join("\n")
}

/// The name under which listings and messages speak of a function.
#[must_use]
pub fn title(program: &Program, index: u32) -> String {
    match &program.functions[index as usize].name {
        Some(name) => format!("function {index} `{name}`"),
        None if index == program.main() => format!("function {index}, the main program"),
        None => format!("function {index}"),
    }
}

fn heading(program: &Program, index: u32, sources: &SourceMap) -> String {
    let function = &program.functions[index as usize];
    let mut text = format!("{}, {}:\n", title(program, index), place(sources, function.span));
    let _ = writeln!(text, "  {} registers, {} slots", function.n_registers, function.n_slots);
    for (idx, (source, name)) in function.captures.iter().zip(&function.capture_names).enumerate() {
        let from = match source {
            CaptureSource::Register(register) => format!("r{register}"),
            CaptureSource::Slot(slot) => format!("slot {slot}"),
            CaptureSource::Capture(outer) => format!("captured {outer}"),
        };
        let _ = writeln!(text, "  captured {idx}: `{name}`, from its creator's {from}");
    }
    text
}

/// The source lines that stand above what came from them.
pub struct SourceLines<'s> {
    sources: &'s SourceMap,
    /// File and number of the last.
    last: Option<(&'s SourceFile, usize)>,
}

impl<'s> SourceLines<'s> {
    /// Before the first line.
    #[must_use]
    pub fn new(sources: &'s SourceMap) -> Self {
        SourceLines { sources, last: None }
    }

    /// The line where a span starts, behind its number and cut if it is long; none where there is no
    /// source, and if it is the last one again.
    pub fn before(&mut self, span: Span) -> Option<String> {
        let file = self.sources.file_of(span)?;
        let number = file.line_column(span).line;
        if self.last.is_some_and(|(last, n)| std::ptr::eq(last, file) && n == number) {
            return None;
        }
        self.last = Some((file, number));
        let line = file.line(number)?.trim_end();
        let end = line.char_indices().nth(SHOWN_CHARS).map_or(line.len(), |(end, _)| end);
        let dots = if end < line.len() { "..." } else { "" };
        Some(format!("{number:>4} | {}{dots}", &line[..end]))
    }
}

fn place(sources: &SourceMap, span: Span) -> String {
    sources.file_of(span).map_or(String::new(), |file| file.line_column(span).to_string())
}

fn fields(program: &Program, function: &Function, pc: usize, insn: &Insn) -> String {
    let Insn { a, b, c, imm, .. } = *insn;
    let constant = |index: u32| {
        function.constants.get(index as usize).map_or(String::new(), |k| constant_text(program, k))
    };
    let target = || format!("-> {:04}", pc + 1 + imm as usize);
    match insn.op.format() {
        Format::None => String::new(),
        Format::A => format!("r{a}"),
        Format::AB => format!("r{a} r{b}"),
        Format::ABC => format!("r{a} r{b} r{c}"),
        Format::ABCRegister => format!("r{imm} <- r{a} r{b} r{c}"),
        Format::AConstant => format!("r{a} {}", constant(imm)),
        Format::Constant => constant(imm),
        Format::ABConstant => format!("r{a} r{b} {}", constant(imm)),
        Format::ACapture => {
            let name = function.capture_names.get(imm as usize).map_or("", |name| name);
            format!("r{a} captured {imm} `{name}`")
        }
        Format::ASlot => format!("r{a} slot {imm}"),
        Format::AFunction => format!("r{a} {}", title(program, imm)),
        Format::ACount => format!("r{a} {imm}"),
        Format::Range => {
            let registers: Vec<_> =
                (0..b).map(|offset| format!("r{}", a.wrapping_add(offset))).collect();
            registers.join(" ")
        }
        Format::Jump => target(),
        Format::AJump => format!("r{a} {}", target()),
        Format::ABJump => format!("r{a} r{b} {}", target()),
        Format::AKJump => format!("r{a} {} {}", constant(u32::from(b)), target()),
        Format::AOperator => {
            format!("r{a} {}", Operator::ALL.get(b as usize).map_or("?", |op| op.spelling()))
        }
    }
}

/// A constant in GML syntax, long arrays cut.
#[must_use]
pub fn constant_text(program: &Program, constant: &Constant) -> String {
    match constant {
        Constant::Bool(value) => value.to_string(),
        Constant::Int(value) => value.to_string(),
        Constant::Real(value) => format!("{value:?}"),
        Constant::Str(text) => format!("\"{text}\""),
        Constant::Point([x, y, z]) => format!("({x:?} {y:?} {z:?})"),
        Constant::Function(index) => title(program, *index),
        Constant::Array(array) => {
            let shown = array.items().iter().take(SHOWN_ITEMS).map(|item| match item {
                Constant::Array(inner) => format!("[{} items]", inner.items().len()),
                other => constant_text(program, other),
            });
            let mut items: Vec<_> = shown.collect();
            if array.items().len() > SHOWN_ITEMS {
                items.push(format!("... {} items", array.items().len()));
            }
            format!("[ {} ]", items.join(" "))
        }
    }
}
