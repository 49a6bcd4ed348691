//! What can go wrong while a program runs, and how it is told.

use std::sync::Arc;

use compiler::bytecode::{Format, Origin};
use compiler::diagnostic::{Code, Diagnostic, Label, TraceEntry, grouped};
use compiler::op::{Operator, Type};
use compiler::scalar::Fault;
use renderer::object::TransformError;

use crate::display;
use crate::machine::Machine;
use crate::word::Word;

/// What is wrong.
#[derive(Clone, Debug)]
pub enum Problem {
    /// An operator (or a binder, if none) found the stack empty, after its instruction had taken so
    /// many values.
    Underflow(Option<Operator>, usize),
    /// No such name.
    Unbound(Arc<str>),
    /// An operator got these types.
    Mismatch(Operator, Vec<Type>),
    /// A scalar operator has no result for these operands, shown as text.
    Fault(Operator, Fault, Vec<String>),
    /// `get` with this index, of an array of this length.
    Subscript(i64, usize),
    /// A transform that cannot be.
    Transform(Operator, TransformError),
    /// An operand of `render` is out of range: says which and why.
    Render(String),
    /// `render` while rendering.
    RenderInSurface,
    /// A surface function left these types.
    SurfaceResult(Vec<Type>),
    /// More instructions than allowed.
    FuelLimit(u64),
    /// More active calls than allowed.
    DepthLimit(usize),
    /// More memory than allowed, in bytes.
    MemoryLimit(u64),
    /// The host refused or failed.
    Host(Box<Diagnostic>),
}

/// A run-time error.
#[derive(Clone, Debug)]
pub struct Error {
    /// What is wrong.
    pub problem: Problem,
    /// Where.
    pub origin: Origin,
    /// The active calls, outermost first.
    pub trace: Vec<TraceEntry>,
}

impl Error {
    /// The error as the user sees it.
    #[must_use]
    pub fn into_diagnostic(self) -> Diagnostic {
        let Error { problem, origin, trace } = self;
        let new = |code, message: String| Diagnostic::new(code, origin.span, message);
        let mut diagnostic = match problem {
            Problem::Host(mut diagnostic) => {
                if diagnostic.primary.span.is_none() {
                    diagnostic.primary.span = origin.span;
                }
                *diagnostic
            }
            Problem::Underflow(wanted_by, _) => underflow(origin, wanted_by),
            Problem::Unbound(name) => new(Code::Unbound, format!("`{name}` is not bound"))
                .label("not bound in this function or around it"),
            Problem::Mismatch(op, found) => mismatch(origin, op, &found),
            Problem::Fault(op, fault, operands) => scalar_fault(origin, op, fault, &operands),
            Problem::Subscript(index, length) => {
                let message = format!(
                    "index {index} is outside the array, which has {}",
                    count(length, "element")
                );
                new(Code::Subscript, message).label("no such element")
            }
            Problem::Transform(op, TransformError::ZeroScale) => {
                new(Code::BadTransform, format!("a factor of `{}` is 0", op.spelling()))
                    .label("makes the object flat")
            }
            Problem::Transform(op, TransformError::NonFinite) => {
                let message = format!("`{}` leaves the range of real numbers", op.spelling());
                new(Code::BadTransform, message).label("infinite, or not a number")
            }
            Problem::Render(reason) => new(Code::BadRender, reason),
            Problem::RenderInSurface => {
                new(Code::RenderInSurface, "`render` is used in a surface function".to_owned())
            }
            Problem::SurfaceResult(found) => surface_result(origin, &found),
            Problem::FuelLimit(limit) => new(
                Code::FuelLimit,
                format!("the limit of {} instructions is reached", grouped(limit)),
            )
            .help("raise the limit with `--fuel N` if the program is meant to run this long"),
            Problem::DepthLimit(limit) => new(
                Code::DepthLimit,
                format!("the call depth limit of {} is reached", grouped(limit as u64)),
            )
            .help("raise the limit with `--max-depth N` if the recursion is meant"),
            Problem::MemoryLimit(limit) => new(
                Code::MemoryLimit,
                format!("the memory limit of {} bytes is reached", grouped(limit)),
            )
            .help("raise the limit with `--max-memory SIZE` if the program needs it"),
        };
        if diagnostic.trace.is_empty() {
            diagnostic.trace = trace;
        }
        diagnostic
    }
}

fn underflow(origin: Origin, wanted_by: Option<Operator>) -> Diagnostic {
    let message = match wanted_by {
        None => "the stack is empty, but this binder takes a value".to_owned(),
        Some(op) => {
            let operands = op.operands();
            let types: Vec<_> = operands.iter().map(|ty| ty.name()).collect();
            let n_operands = count(operands.len(), "operand");
            format!(
                "the stack has too few values: `{}` takes {n_operands} ({})",
                op.spelling(),
                types.join(", ")
            )
        }
    };
    Diagnostic::new(Code::StackUnderflow, origin.span, message).label("nothing left to take")
}

/// `an integer and a real`, `two integers`.
fn list(types: &[Type]) -> String {
    const NUMBERS: [&str; 4] = ["no", "one", "two", "three"];
    match types {
        [] => "nothing".to_owned(),
        [one] => one.with_article().to_owned(),
        [first, rest @ ..] if types.len() < NUMBERS.len() && rest.iter().all(|ty| ty == first) => {
            format!("{} {first}s", NUMBERS[types.len()])
        }
        [init @ .., last] => {
            let init: Vec<_> = init.iter().map(|ty| ty.with_article()).collect();
            format!("{} and {}", init.join(", "), last.with_article())
        }
    }
}

fn mismatch(origin: Origin, op: Operator, found: &[Type]) -> Diagnostic {
    let message =
        format!("`{}` takes {}, but got {}", op.spelling(), list(op.operands()), list(found));
    let mut diagnostic = Diagnostic::new(Code::TypeMismatch, origin.span, message);
    for (span, ty) in origin.operands.iter().zip(found) {
        if !span.is_none() && *span != origin.span {
            diagnostic.secondary.push(Label { span: *span, text: ty.name().to_owned() });
        }
    }
    match (op.operands(), found) {
        (wanted, found) if wanted.contains(&Type::Int) && found.contains(&Type::Real) => {
            diagnostic.help("`floor` turns a real into an integer; operators for reals end in `f`")
        }
        (wanted, found) if wanted.contains(&Type::Real) && found.contains(&Type::Int) => diagnostic
            .help("`real` turns an integer into a real, and a real literal has a point: `2.0`"),
        _ => diagnostic,
    }
}

fn scalar_fault(origin: Origin, op: Operator, fault: Fault, operands: &[String]) -> Diagnostic {
    let call = format!("`{} {}`", operands.join(" "), op.spelling());
    let (code, message) = match fault {
        Fault::IntegerOverflow => {
            (Code::IntegerOverflow, format!("{call} does not fit in 64 bits"))
        }
        Fault::DivisionByZero => (Code::DivisionByZero, format!("{call} divides by zero")),
        Fault::NegativeRoot => {
            (Code::NegativeRoot, format!("{call} is the root of a negative number"))
        }
        Fault::FloorRange => (Code::FloorRange, format!("{call} is not a 64-bit integer")),
    };
    Diagnostic::new(code, origin.span, message)
}

fn surface_result(origin: Origin, found: &[Type]) -> Diagnostic {
    const WANTED: [(Type, &str); 4] = [
        (Type::Point, "point"),
        (Type::Real, "real kd"),
        (Type::Real, "real ks"),
        (Type::Real, "real n"),
    ];
    let needed = WANTED.map(|(_, name)| name).join(", ");
    let found_text: Vec<_> = found.iter().map(|ty| ty.name()).collect();
    let message = if found.len() == 4 {
        format!("surface function leaves {}; needed are {needed}", found_text.join(", "))
    } else {
        format!("surface function leaves {}; 4 are needed: {needed}", count(found.len(), "value"))
    };
    let diagnostic =
        Diagnostic::new(Code::SurfaceResult, origin.span, message).label("this function");
    if found.len() == 4 || found.is_empty() {
        return diagnostic;
    }
    let is_begun = found.iter().zip(WANTED).all(|(found, (wanted, _))| *found == wanted);
    let missing = WANTED.get(found.len()..).filter(|_| is_begun).unwrap_or_default();
    let missing: Vec<_> = missing.iter().map(|(_, name)| *name).collect();
    let missing = if missing.is_empty() {
        String::new()
    } else {
        format!("; missing: {}", missing.join(", "))
    };
    diagnostic.note(format!("it leaves, bottom first: {}{missing}", found_text.join(", ")))
}

/// `1 value`, `2 values`.
fn count(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

impl Problem {
    /// An operator has got these operands.
    #[cold]
    #[inline(never)]
    pub(crate) fn mismatch(op: Operator, operands: &[Word]) -> Problem {
        Problem::Mismatch(op, operands.iter().map(|operand| operand.type_of()).collect())
    }
}

impl Machine<'_> {
    /// What is wrong with the operands of the scalar operator at which the machine has stopped.
    #[cold]
    #[inline(never)]
    pub(crate) fn scalar_problem(
        &self,
        function: usize,
        base: usize,
        fault: Option<Fault>,
    ) -> Box<Problem> {
        let insn = self.program.bytecode.functions[function].code[self.stopped_at];
        let r = |register: u8| self.registers.get(base + register as usize);
        let k = |index: u32| self.program.functions[function].constants[index as usize];
        let operands = match insn.op.format() {
            Format::AB => vec![r(insn.b)],
            Format::ABC => vec![r(insn.b), r(insn.c)],
            Format::ABConstant => vec![r(insn.b), k(insn.imm)],
            Format::ABJump => vec![r(insn.a), r(insn.b)],
            Format::AKJump => vec![r(insn.a), k(u32::from(insn.b))],
            _ => vec![r(insn.a), r(insn.b), r(insn.c)],
        };
        let op = insn.op.operator().expect("only scalar operators have such problems");
        Box::new(match fault {
            None => Problem::mismatch(op, &operands),
            Some(fault) => {
                let scalars = operands.iter().filter_map(|operand| operand.to_scalar());
                Problem::Fault(op, fault, scalars.map(|scalar| display::to_text(&scalar)).collect())
            }
        })
    }
}
