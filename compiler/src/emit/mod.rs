//! The tree to bytecode: names to places, constants folded, literal functions inlined.
//!
//! The operand stack is simulated while compiling. An operand stays where it is (a constant, a
//! register, a captured value) until an instruction needs it, and is pushed on the real stack only
//! before a call. Every binder makes a new variable that never changes, so using a name emits
//! nothing. `{ ... } apply` and `b { ... } { ... } if` become code in place; all other functions
//! become closures that capture exactly the bindings they use, as they are at that point.
//!
//! Unbound names, type errors and faults compile to instructions that report them, since a program
//! is only wrong if it gets there.

mod branch;
mod function;
mod registers;
mod rounds;

use std::sync::Arc;

use crate::ast::{Body, Term, TermKind};
use crate::bytecode::{CaptureSource, Constant, ConstantArray, Function, Opcode, Origin, Program};
use crate::diagnostic::{Code, Diagnostic};
use crate::emit::function::{Entry, FunctionBuilder, Operand, Region};
use crate::op::Operator;
use crate::scalar;
use crate::source::Span;

/// The most functions, and the most instructions, slots or constants of one function.
const MAX_TABLE: usize = 1 << 24;

/// The functions of a program may capture so many values, and [`CAPTURES_PER_WORD`] more for each of its
/// words. A function captures what those within it use, so that without a bound a program would take
/// time and memory with the product of its length and its depth.
const MAX_CAPTURES: usize = 1 << 16;

/// Most functions capture far fewer values than they have words.
const CAPTURES_PER_WORD: usize = 2;

/// Constant arrays nest at most this deep; deeper ones are made at run time. It bounds the native
/// recursion of whoever walks a constant.
const MAX_CONSTANT_NESTING: usize = 64;

/// Compiles a program, with `bindings` made before it starts.
///
/// # Errors
/// A diagnostic when the program is larger than the bytecode can express.
pub fn emit(
    program: &Body,
    bindings: &[(Arc<str>, Constant)],
    span: Span,
) -> Result<Program, Box<Diagnostic>> {
    let max_captures = MAX_CAPTURES + CAPTURES_PER_WORD * n_words(program);
    let mut emitter =
        Emitter { functions: Vec::new(), builders: Vec::new(), n_captures: 0, max_captures };
    emitter.builders.push(FunctionBuilder::new(None, span));
    for (name, constant) in bindings {
        let operand = Operand::Constant(constant.clone());
        emitter.here().bind(name, Entry { operand, span: Span::NONE });
    }
    emitter.finish_body(program, span);
    let too_large = emitter.captures_too_much()
        || emitter.functions.len() > MAX_TABLE
        || emitter.functions.iter().any(|function| {
            function.code.len().max(function.constants.len()).max(function.n_slots as usize)
                > MAX_TABLE
        });
    if too_large {
        let message = "the program is too large";
        return Err(Box::new(Diagnostic::new(Code::ProgramTooLarge, Span::NONE, message)));
    }
    Ok(Program { functions: emitter.functions })
}

/// Whether code goes on behind what has been compiled.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Flow {
    Continues,
    Ended,
}

struct Emitter {
    functions: Vec<Function>,
    /// The function being compiled is last, behind those around it.
    builders: Vec<FunctionBuilder>,
    n_captures: usize,
    max_captures: usize,
}

impl Emitter {
    /// Whether the program is too large: what is compiled then is no longer of use.
    fn captures_too_much(&self) -> bool {
        self.n_captures > self.max_captures
    }

    fn here(&mut self) -> &mut FunctionBuilder {
        self.builders.last_mut().expect("the main program is there until the end")
    }

    /// Compiles the body of the innermost function and files it; returns its index.
    fn finish_body(&mut self, body: &[Term], span: Span) -> u32 {
        if self.terms(body, true) == Flow::Continues {
            // That is the closing bracket; the main program, which has none, ends behind its last word.
            let end = if self.builders.len() > 1 {
                Span { start: span.end - 1, end: span.end }
            } else {
                let end = body.last().map_or(span.start, |term| term.span.end);
                Span { start: end, end }
            };
            self.here().emit_return(end);
        }
        let builder = self.builders.pop().expect("the function was begun by the caller");
        let mut function = builder.finish();
        if !self.captures_too_much() {
            rounds::shorten(&self.functions, &mut function);
        }
        self.functions.push(function);
        self.functions.len() as u32 - 1
    }

    /// Compiles a sequence; with `tail`, nothing follows it in its function.
    fn terms(&mut self, terms: &[Term], tail: bool) -> Flow {
        let mut rest = terms;
        while let [first, after @ ..] = rest {
            let (flow, next) = match (&first.kind, after) {
                (TermKind::Function(body), [next, after @ ..]) if is(next, Operator::Apply) => {
                    (self.inline(body, tail && after.is_empty()), after)
                }
                (
                    TermKind::Function(yes),
                    [Term { kind: TermKind::Function(no), .. }, third, after @ ..],
                ) if is(third, Operator::If) => {
                    (self.literal_if(yes, no, third.span, tail && after.is_empty()), after)
                }
                (TermKind::Operator(Operator::Apply), _) => {
                    (self.apply(first.span, tail && after.is_empty()), after)
                }
                (TermKind::Operator(Operator::If), _) => {
                    (self.closure_if(first.span, tail && after.is_empty()), after)
                }
                _ => {
                    self.term(first, after.first());
                    (Flow::Continues, after)
                }
            };
            if flow == Flow::Ended || self.captures_too_much() {
                return Flow::Ended;
            }
            rest = next;
        }
        Flow::Continues
    }

    /// Compiles a term that transfers no control; `next` is the term behind it.
    fn term(&mut self, term: &Term, next: Option<&Term>) {
        let span = term.span;
        let constant = match &term.kind {
            TermKind::Bool(value) => Constant::Bool(*value),
            TermKind::Int(value) => Constant::Int(*value),
            TermKind::Real(value) => Constant::Real(*value),
            TermKind::Str(text) => Constant::Str(text.clone()),
            TermKind::Name(name) => return self.name(name, span),
            TermKind::Binder(name) => {
                let entry = self.here().pop(None, span);
                return self.here().bind(name, entry);
            }
            TermKind::Function(body) => {
                let name = match next.map(|next| &next.kind) {
                    Some(TermKind::Binder(name)) => Some(name.clone()),
                    _ => None,
                };
                return self.function(body, name, span);
            }
            TermKind::Array(body) => return self.array(body, span),
            TermKind::Operator(op) => return self.operator(*op, span),
        };
        self.here().push_constant(constant, span);
    }

    /// Refers to a binding, of this function or of one around it.
    fn name(&mut self, name: &Arc<str>, span: Span) {
        let Some(level) = self.level(name) else {
            let here = self.here();
            let index = here.constant(&Constant::Str(name.clone()));
            here.emit(Opcode::Unbound, [0; 3], index, Origin { span, ..Origin::default() });
            // Never reached; a stand-in keeps the simulated stack as the program has it.
            return here.push_constant(Constant::Bool(false), span);
        };
        let mut operand = self.builders[level].lookup(name).expect("found above").clone();
        for builder in &mut self.builders[level + 1..] {
            let source = match operand {
                Operand::Constant(_) => break,
                Operand::Register(register) => CaptureSource::Register(register),
                Operand::Slot(slot) => CaptureSource::Slot(slot),
                Operand::Capture(index) => CaptureSource::Capture(index),
            };
            let n_before = builder.n_captures();
            operand = builder.capture(name, source);
            self.n_captures += builder.n_captures() - n_before;
        }
        self.here().push_bound(name, operand, span);
    }

    /// Where among the builders a name is bound.
    fn level(&mut self, name: &Arc<str>) -> Option<usize> {
        let (here, around) = self.builders.split_last_mut()?;
        if here.lookup(name).is_some() {
            return Some(around.len());
        }
        if let Some(known) = here.outside.get(name) {
            return *known;
        }
        let level = around.iter().rposition(|builder| builder.lookup(name).is_some());
        let bound = level.and_then(|level| around[level].lookup(name));
        // All others are captured, and then bound here.
        if matches!(bound, None | Some(Operand::Constant(_))) {
            here.outside.insert(name.clone(), level);
        }
        level
    }

    /// A literal function that becomes a closure.
    fn function(&mut self, body: &[Term], name: Option<Arc<str>>, span: Span) {
        self.builders.push(FunctionBuilder::new(name, span));
        let index = self.finish_body(body, span);
        if self.functions[index as usize].captures.is_empty() {
            return self.here().push_constant(Constant::Function(index), span);
        }
        let here = self.here();
        let register = here.allocate();
        here.emit(
            Opcode::MakeClosure,
            [register, 0, 0],
            index,
            Origin { span, ..Origin::default() },
        );
        here.push_register(register, span);
    }

    /// `{ body } apply`, in place.
    fn inline(&mut self, body: &[Term], tail: bool) -> Flow {
        let mark = self.here().enter_scope();
        let flow = self.terms(body, tail);
        self.here().leave_scope(mark);
        flow
    }

    fn array(&mut self, body: &[Term], span: Span) {
        let here = self.here();
        if here.registers.is_crowded() {
            here.flush();
        }
        let outer_entries = std::mem::take(&mut here.entries);
        let outer_region = std::mem::replace(&mut here.region, Region::new());
        let outer_code = std::mem::take(&mut here.code);
        self.inline(body, false);
        let here = self.here();
        let folded = constant_items(here);
        if folded.is_none() {
            here.flush();
        }
        let inner_code = std::mem::replace(&mut here.code, outer_code);
        here.entries = outer_entries;
        let region = std::mem::replace(&mut here.region, outer_region);
        let origin = Origin { span, ..Origin::default() };
        let needs_floor = region.needs_floor || region.height.is_none();
        if needs_floor {
            here.emit(Opcode::BeginArray, [0; 3], 0, origin);
        }
        here.code.append(inner_code);
        if let Some(array) = folded {
            return here.push_constant(Constant::Array(array), span);
        }
        let register = here.allocate();
        match region.height {
            Some(n_items) if !needs_floor => {
                here.emit(Opcode::MakeArray, [register, 0, 0], n_items as u32, origin);
            }
            _ => here.emit(Opcode::EndArray, [register, 0, 0], 0, origin),
        }
        here.push_register(register, span);
    }

    fn operator(&mut self, op: Operator, span: Span) {
        let here = self.here();
        match op {
            Operator::Render => {
                // It takes eight operands or nine: only the machine can tell.
                here.flush();
                here.emit(
                    Opcode::Operate,
                    [0, op as u8, 0],
                    0,
                    Origin { span, ..Origin::default() },
                );
                here.region.forget();
            }
            Operator::Get => self.on_registers(Opcode::Get, op, span),
            Operator::Length => self.on_registers(Opcode::Length, op, span),
            _ => match Opcode::on_registers(op) {
                Some(opcode) => self.on_registers(opcode, op, span),
                None => self.on_stack(op, span),
            },
        }
    }

    /// An operator on objects and lights: operands go over the stack.
    fn on_stack(&mut self, op: Operator, span: Span) {
        let here = self.here();
        let n_operands = op.operands().len();
        // Later, room would be made by pushing what is below the operands on top of them.
        here.make_room();
        let split = here.entries.len().saturating_sub(n_operands);
        let operands = here.entries.split_off(split);
        for entry in &operands {
            here.push_to_stack(entry);
        }
        here.region.change(-(n_operands as i64));
        let register = here.allocate();
        here.emit(
            Opcode::Operate,
            [register, op as u8, 0],
            0,
            Origin { span, ..Origin::default() },
        );
        here.push_register(register, span);
    }

    /// An operator whose operands and result are in registers.
    fn on_registers(&mut self, opcode: Opcode, op: Operator, span: Span) {
        let here = self.here();
        let n_operands = op.operands().len();
        let mut operands: Vec<Entry> = (0..n_operands).map(|_| here.pop(Some(op), span)).collect();
        operands.reverse();
        if let Some(constant) = fold(op, &operands) {
            return here.push_constant(constant, span);
        }
        let mut origin = Origin { span, ..Origin::default() };
        for (slot, operand) in origin.operands.iter_mut().zip(&operands) {
            *slot = operand.span;
        }
        let (opcode, imm) = match (opcode.with_constant(), &operands[..]) {
            (Some(with_constant), [_, Entry { operand: Operand::Constant(constant), .. }]) => {
                let index = here.constant(constant);
                operands.pop();
                (with_constant, Some(index))
            }
            _ => (opcode, None),
        };
        let mut registers = [0; 3];
        for (register, operand) in registers.iter_mut().zip(&operands) {
            *register = here.in_register(operand);
        }
        for &register in &registers[..operands.len()] {
            here.registers.release(register);
        }
        let result = here.allocate();
        let [b, c, third] = registers;
        if opcode == Opcode::Point {
            // Three operands and a result: the result goes into the wide field.
            here.emit(opcode, [b, c, third], u32::from(result), origin);
        } else {
            here.emit(opcode, [result, b, c], imm.unwrap_or(0), origin);
        }
        here.push_register(result, span);
    }

    /// `apply` on a closure that is not written here.
    fn apply(&mut self, span: Span, tail: bool) -> Flow {
        let here = self.here();
        let closure = here.pop(Some(Operator::Apply), span);
        let register = here.in_register(&closure);
        here.registers.release(register);
        let origin = Origin { span, operands: [closure.span, Span::NONE, Span::NONE] };
        self.call(register, origin, tail)
    }

    /// Calls the closure in a register, which may be reused at once.
    fn call(&mut self, register: u8, origin: Origin, tail: bool) -> Flow {
        let here = self.here();
        // The closure's register is kept from being reused by what flushing loads.
        here.registers.retain(register);
        here.flush();
        here.registers.release(register);
        here.region.forget();
        let (opcode, flow) =
            if tail { (Opcode::TailApply, Flow::Ended) } else { (Opcode::Apply, Flow::Continues) };
        here.emit(opcode, [register, 0, 0], 0, origin);
        flow
    }
}

/// The words of a program, its brackets included.
fn n_words(program: &Body) -> usize {
    let mut n_words = 0;
    let mut bodies = vec![program];
    while let Some(body) = bodies.pop() {
        n_words += body.len();
        for term in body {
            if let TermKind::Function(inner) | TermKind::Array(inner) = &term.kind {
                n_words += 1;
                bodies.push(inner);
            }
        }
    }
    n_words
}

fn is(term: &Term, op: Operator) -> bool {
    term.kind == TermKind::Operator(op)
}

/// The items of an array literal if all are known and none is on the stack.
fn constant_items(here: &FunctionBuilder) -> Option<Arc<ConstantArray>> {
    if here.region.height != Some(0) || here.region.needs_floor {
        return None;
    }
    let items: Option<Vec<Constant>> = here
        .entries
        .iter()
        .map(|entry| match &entry.operand {
            Operand::Constant(constant) => Some(constant.clone()),
            _ => None,
        })
        .collect();
    let items =
        items.filter(|items| items.iter().all(|item| item.nesting() < MAX_CONSTANT_NESTING))?;
    Some(Arc::new(ConstantArray::new(items)))
}

/// The result of an operator on constants; none if it must be left to the machine, faults included.
fn fold(op: Operator, operands: &[Entry]) -> Option<Constant> {
    let mut constants = Vec::with_capacity(operands.len());
    for entry in operands {
        let Operand::Constant(constant) = &entry.operand else { return None };
        constants.push(constant.clone());
    }
    match (op, &constants[..]) {
        (Operator::Length, [Constant::Array(array)]) => {
            Some(Constant::Int(array.items().len() as i64))
        }
        (Operator::Get, [Constant::Array(array), Constant::Int(index)]) => {
            array.items().get(usize::try_from(*index).ok()?).cloned()
        }
        _ => scalar::evaluate(op, &constants)?.ok(),
    }
}

#[cfg(test)]
mod tests;
