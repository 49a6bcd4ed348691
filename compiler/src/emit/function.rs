//! The function being compiled: its code so far, its names, and where its operands are.

use std::collections::HashMap;
use std::sync::Arc;

use crate::bytecode::{CaptureSource, Constant, ConstantArray, Function, Insn, Opcode, Origin};
use crate::emit::registers::Registers;
use crate::op::Operator;
use crate::source::Span;

/// Where a value is.
#[derive(Clone, Debug)]
pub(super) enum Operand {
    Constant(Constant),
    Register(u8),
    Slot(u32),
    Capture(u32),
}

impl Operand {
    /// Whether both are the same place, or the same constant.
    pub(super) fn is_same(&self, other: &Operand) -> bool {
        match (self, other) {
            (Operand::Register(a), Operand::Register(b)) => a == b,
            (Operand::Slot(a), Operand::Slot(b)) | (Operand::Capture(a), Operand::Capture(b)) => {
                a == b
            }
            (Operand::Constant(a), Operand::Constant(b)) => {
                ConstantKey::new(a) == ConstantKey::new(b)
            }
            _ => false,
        }
    }
}

/// An entry of the operand stack that has not been pushed, and the text that put it there.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) operand: Operand,
    pub(super) span: Span,
}

/// Instructions with their origins.
#[derive(Debug, Default)]
pub(super) struct Code {
    pub(super) insns: Vec<Insn>,
    pub(super) origins: Vec<Origin>,
    /// Instructions before this index are not to be merged with later ones: jumps may end here.
    pub(super) sealed: usize,
}

impl Code {
    pub(super) fn push(&mut self, insn: Insn, origin: Origin) {
        self.insns.push(insn);
        self.origins.push(origin);
    }

    pub(super) fn append(&mut self, mut other: Code) {
        self.insns.append(&mut other.insns);
        self.origins.append(&mut other.origins);
        self.sealed = self.insns.len();
    }

    /// The last instruction, if it may still be changed.
    pub(super) fn last_mut(&mut self) -> Option<(&mut Insn, &mut Origin)> {
        if self.insns.len() <= self.sealed {
            return None;
        }
        Some((self.insns.last_mut()?, self.origins.last_mut()?))
    }
}

/// The part of the operand stack that code since some point has made: the whole function, or `[ ]`.
#[derive(Clone, Debug)]
pub(super) struct Region {
    /// Values pushed less values popped since the region began; unknown after a call.
    pub(super) height: Option<i64>,
    /// Whether only a floor at run time can keep code from what lies below the region.
    pub(super) needs_floor: bool,
}

impl Region {
    pub(super) fn new() -> Self {
        Region { height: Some(0), needs_floor: false }
    }

    /// A call may do anything to the stack.
    pub(super) fn forget(&mut self) {
        self.height = None;
        self.needs_floor = true;
    }

    pub(super) fn change(&mut self, by: i64) {
        self.height = self.height.map(|height| height + by);
        self.needs_floor |= self.height.is_none_or(|height| height < 0);
    }
}

/// What identifies a constant in a table of constants.
#[derive(PartialEq, Eq, Hash)]
enum ConstantKey {
    Bool(bool),
    Int(i64),
    Real(u64),
    Str(Arc<str>),
    Point([u64; 3]),
    Function(u32),
    Array(*const ConstantArray),
}

impl ConstantKey {
    fn new(constant: &Constant) -> Self {
        match constant {
            Constant::Bool(value) => ConstantKey::Bool(*value),
            Constant::Int(value) => ConstantKey::Int(*value),
            Constant::Real(value) => ConstantKey::Real(value.to_bits()),
            Constant::Str(text) => ConstantKey::Str(text.clone()),
            Constant::Point(point) => ConstantKey::Point(point.map(f64::to_bits)),
            Constant::Function(index) => ConstantKey::Function(*index),
            Constant::Array(array) => ConstantKey::Array(Arc::as_ptr(array)),
        }
    }
}

/// A function under construction.
pub(super) struct FunctionBuilder {
    function: Function,
    constants: HashMap<ConstantKey, u32>,
    capture_indices: HashMap<CaptureSource, u32>,
    names: HashMap<Arc<str>, Operand>,
    /// What each binding has hidden, for the end of its scope.
    hidden: Vec<(Arc<str>, Option<Operand>)>,
    /// Where among the functions around this one a name is bound to a constant, or that it is not: nothing
    /// is bound in those meanwhile.
    pub(super) outside: HashMap<Arc<str>, Option<usize>>,
    pub(super) code: Code,
    pub(super) registers: Registers,
    pub(super) entries: Vec<Entry>,
    pub(super) region: Region,
}

impl FunctionBuilder {
    pub(super) fn new(name: Option<Arc<str>>, span: Span) -> Self {
        FunctionBuilder {
            function: Function { name, span, ..Function::default() },
            constants: HashMap::new(),
            capture_indices: HashMap::new(),
            names: HashMap::new(),
            hidden: Vec::new(),
            outside: HashMap::new(),
            code: Code::default(),
            registers: Registers::new(),
            entries: Vec::new(),
            region: Region::new(),
        }
    }

    pub(super) fn finish(mut self) -> Function {
        self.function.code = self.code.insns;
        self.function.origins = self.code.origins;
        self.function
    }

    // Instructions.

    pub(super) fn emit(&mut self, op: Opcode, [a, b, c]: [u8; 3], imm: u32, origin: Origin) {
        self.code.push(Insn { op, a, b, c, imm }, origin);
    }

    pub(super) fn constant(&mut self, constant: &Constant) -> u32 {
        let constants = &mut self.function.constants;
        *self.constants.entry(ConstantKey::new(constant)).or_insert_with(|| {
            constants.push(constant.clone());
            constants.len() as u32 - 1
        })
    }

    /// Puts the pending operands on the operand stack if few registers are left.
    pub(super) fn make_room(&mut self) {
        if self.registers.is_crowded() {
            self.flush();
        }
    }

    /// A free register with one reference; pending operands make room where need be.
    pub(super) fn allocate(&mut self) -> u8 {
        self.make_room();
        let register =
            self.registers.allocate().expect("flushing leaves the registers of bindings only");
        self.use_register(register);
        register
    }

    /// Makes the frame large enough for a register.
    pub(super) fn use_register(&mut self, register: u8) {
        self.function.n_registers = self.function.n_registers.max(u32::from(register) + 1);
    }

    /// Brings a value into a register and hands over one reference to it.
    pub(super) fn in_register(&mut self, entry: &Entry) -> u8 {
        if let Operand::Register(register) = entry.operand {
            return register;
        }
        let register = self.allocate();
        self.load(register, entry);
        register
    }

    /// Emits the copy of a value into `register`.
    pub(super) fn load(&mut self, register: u8, entry: &Entry) {
        let (op, b, imm) = match &entry.operand {
            Operand::Constant(constant) => (Opcode::Load, 0, self.constant(constant)),
            Operand::Register(from) => (Opcode::Move, *from, 0),
            Operand::Slot(slot) => (Opcode::Unspill, 0, *slot),
            Operand::Capture(index) => (Opcode::Capture, 0, *index),
        };
        self.emit(op, [register, b, 0], imm, Origin { span: entry.span, ..Origin::default() });
    }

    pub(super) fn release(&mut self, entry: &Entry) {
        if let Operand::Register(register) = entry.operand {
            self.registers.release(register);
        }
    }

    // The operand stack.

    pub(super) fn push_constant(&mut self, constant: Constant, span: Span) {
        self.entries.push(Entry { operand: Operand::Constant(constant), span });
    }

    pub(super) fn push_register(&mut self, register: u8, span: Span) {
        self.entries.push(Entry { operand: Operand::Register(register), span });
    }

    /// The topmost operand, wanted by `wanted_by` (a binder if none) at `span`.
    pub(super) fn pop(&mut self, wanted_by: Option<Operator>, span: Span) -> Entry {
        if let Some(entry) = self.entries.pop() {
            return entry;
        }
        let register = self.allocate();
        self.region.change(-1);
        let wanted_by = wanted_by.map_or(0, |op| op as u8 + 1);
        match self.code.last_mut() {
            Some((Insn { op: Opcode::Pop, a, b, c, .. }, origin))
                if *b < 3
                    && *c == wanted_by
                    && u16::from(*a) + u16::from(*b) == u16::from(register) =>
            {
                origin.operands[*b as usize] = span;
                *b += 1;
            }
            _ => {
                let origin = Origin { span, operands: [span, Span::NONE, Span::NONE] };
                self.emit(Opcode::Pop, [register, 1, wanted_by], 0, origin);
            }
        }
        // What the register holds was written elsewhere: there is no text to point at.
        Entry { operand: Operand::Register(register), span: Span::NONE }
    }

    /// Puts all pending operands on the operand stack.
    pub(super) fn flush(&mut self) {
        let entries = std::mem::take(&mut self.entries);
        for entry in entries {
            self.push_to_stack(&entry);
        }
    }

    /// Ends the function with what is on the stack.
    pub(super) fn emit_return(&mut self, span: Span) {
        self.flush();
        self.emit(Opcode::Return, [0; 3], 0, Origin { span, ..Origin::default() });
    }

    /// Puts one operand on the operand stack and gives up the reference to it.
    pub(super) fn push_to_stack(&mut self, entry: &Entry) {
        self.region.change(1);
        let origin = Origin { span: entry.span, ..Origin::default() };
        if let Operand::Constant(constant) = &entry.operand {
            let index = self.constant(constant);
            self.emit(Opcode::PushConstant, [0; 3], index, origin);
            return;
        }
        let register = self.in_register(entry);
        self.registers.release(register);
        match self.code.last_mut() {
            Some((insn @ Insn { op: Opcode::Push, .. }, _)) => {
                (insn.op, insn.b) = (Opcode::Push2, register);
            }
            Some((insn @ Insn { op: Opcode::Push2, .. }, _)) => {
                (insn.op, insn.c) = (Opcode::Push3, register);
            }
            _ => self.emit(Opcode::Push, [register, 0, 0], 0, origin),
        }
    }

    // Names.

    /// A mark for [`leave_scope`](Self::leave_scope).
    pub(super) fn enter_scope(&self) -> usize {
        self.hidden.len()
    }

    /// Undoes all bindings since the mark.
    pub(super) fn leave_scope(&mut self, mark: usize) {
        for (name, hidden) in self.hidden.split_off(mark).into_iter().rev() {
            let ended = match hidden {
                Some(operand) => self.names.insert(name, operand),
                None => self.names.remove(&name),
            };
            if let Some(Operand::Register(register)) = ended {
                self.registers.release(register);
            }
        }
    }

    /// Binds a name to a value, whose reference passes to the binding.
    pub(super) fn bind(&mut self, name: &Arc<str>, entry: Entry) {
        let operand = match entry.operand {
            Operand::Register(register) if self.registers.is_crowded() => {
                let slot = self.function.n_slots;
                self.function.n_slots += 1;
                self.emit(
                    Opcode::Spill,
                    [register, 0, 0],
                    slot,
                    Origin { span: entry.span, ..Origin::default() },
                );
                self.registers.release(register);
                Operand::Slot(slot)
            }
            operand => operand,
        };
        let hidden = self.names.insert(name.clone(), operand);
        self.hidden.push((name.clone(), hidden));
    }

    pub(super) fn lookup(&self, name: &str) -> Option<&Operand> {
        self.names.get(name)
    }

    /// Refers to the value of a binding of this function, as a new pending operand.
    pub(super) fn push_bound(&mut self, name: &Arc<str>, operand: Operand, span: Span) {
        let entry = Entry { operand, span };
        match entry.operand {
            Operand::Register(register) => self.registers.retain(register),
            // Later uses in this scope find the value in its register.
            Operand::Capture(_) if !self.registers.is_crowded() => {
                let register = self.in_register(&entry);
                self.bind(name, Entry { operand: Operand::Register(register), span });
                self.registers.retain(register);
                return self.push_register(register, span);
            }
            _ => {}
        }
        self.entries.push(entry);
    }

    /// Number of values that the function captures.
    pub(super) fn n_captures(&self) -> usize {
        self.function.captures.len()
    }

    /// Captures a value of the function around this one.
    pub(super) fn capture(&mut self, name: &Arc<str>, source: CaptureSource) -> Operand {
        let function = &mut self.function;
        let index = *self.capture_indices.entry(source).or_insert_with(|| {
            function.captures.push(source);
            function.capture_names.push(name.clone());
            function.captures.len() as u32 - 1
        });
        let operand = Operand::Capture(index);
        self.bind(name, Entry { operand: operand.clone(), span: Span::NONE });
        operand
    }
}
