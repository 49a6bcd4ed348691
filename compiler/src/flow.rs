//! Which registers instructions read and write, and which are still to be read.

use crate::bytecode::{CaptureSource, Format, Function, Insn, Opcode};
use crate::op::Operator;

/// A set of registers, by bit.
pub type Set = [u64; 4];

/// Whether a register is in a set.
#[must_use]
pub fn contains(set: &Set, register: u8) -> bool {
    set[register as usize / 64] >> (register % 64) & 1 == 1
}

impl Insn {
    /// Whether the fields `a`, `b` and `c` name registers that are read. What `MakeClosure` captures
    /// is not in its fields.
    #[must_use]
    pub fn reads(&self) -> [bool; 3] {
        let fields = match (self.op, self.op.format()) {
            (Opcode::Push | Opcode::Apply | Opcode::TailApply | Opcode::Spill, _) => 0b001,
            (_, Format::AJump | Format::AKJump) => 0b001,
            (Opcode::Push2, _) | (_, Format::ABJump) => 0b011,
            (Opcode::Push3, _) | (_, Format::ABCRegister) => 0b111,
            (_, Format::AB | Format::ABConstant) => 0b010,
            (_, Format::ABC) => 0b110,
            _ => 0b000,
        };
        [0, 1, 2].map(|field| fields >> field & 1 == 1)
    }

    /// The fields that name registers that are read, to be changed.
    pub fn read_fields_mut(&mut self) -> impl Iterator<Item = &mut u8> {
        let reads = self.reads();
        [&mut self.a, &mut self.b, &mut self.c].into_iter().zip(reads).filter(|f| f.1).map(|f| f.0)
    }

    /// The registers that it writes: the first, and how many there are.
    #[must_use]
    pub fn writes(&self) -> (u8, u8) {
        match self.op.format() {
            Format::Range => (self.a, self.b),
            Format::ABCRegister => (self.imm as u8, 1),
            Format::None | Format::Constant | Format::Jump | Format::AJump => (0, 0),
            Format::ABJump | Format::AKJump => (0, 0),
            Format::AOperator if Operator::ALL[self.b as usize].results().is_empty() => (0, 0),
            _ if self.reads()[0] => (0, 0),
            _ => (self.a, 1),
        }
    }

    /// Whether it writes a register.
    #[must_use]
    pub fn is_writing(&self, register: u8) -> bool {
        let (first, n_registers) = self.writes();
        register.wrapping_sub(first) < n_registers
    }

    /// The distance that it may jump.
    #[must_use]
    pub fn jump(&self) -> Option<usize> {
        let format = self.op.format();
        let jumps =
            matches!(format, Format::Jump | Format::AJump | Format::ABJump | Format::AKJump);
        jumps.then_some(self.imm as usize)
    }
}

/// Whether jumps end at an instruction, for all of them and the place behind.
#[must_use]
pub fn jump_targets(code: &[Insn]) -> Vec<bool> {
    let mut is_target = vec![false; code.len() + 1];
    for (pc, insn) in code.iter().enumerate() {
        if let Some(distance) = insn.jump() {
            is_target[pc + 1 + distance] = true;
        }
    }
    is_target
}

/// The registers of its creator that a function captures.
pub fn captured_registers(function: &Function) -> impl Iterator<Item = u8> {
    function.captures.iter().filter_map(|source| match source {
        CaptureSource::Register(register) => Some(*register),
        _ => None,
    })
}

/// For each instruction of a function, the registers that may be read from there on before they are
/// written. Jumps go forward, so one pass from the end is exact. `functions` has those that the
/// function creates.
#[must_use]
pub fn live_registers(functions: &[Function], function: &Function) -> Vec<Set> {
    let mut live = vec![[0; 4]; function.code.len() + 1];
    for (pc, insn) in function.code.iter().enumerate().rev() {
        let mut set = match insn.op {
            Opcode::Return | Opcode::TailApply | Opcode::Unbound | Opcode::Jump => [0; 4],
            _ => live[pc + 1],
        };
        if let Some(distance) = insn.jump() {
            let target = live[pc + 1 + distance];
            set = std::array::from_fn(|i| set[i] | target[i]);
        }
        let (first, n_written) = insn.writes();
        for register in (0..n_written).map(|offset| first.wrapping_add(offset)) {
            set[register as usize / 64] &= !(1 << (register % 64));
        }
        let mut read = |register: u8| set[register as usize / 64] |= 1 << (register % 64);
        let fields = [insn.a, insn.b, insn.c].into_iter().zip(insn.reads());
        fields.filter(|field| field.1).for_each(|field| read(field.0));
        if insn.op == Opcode::MakeClosure {
            captured_registers(&functions[insn.imm as usize]).for_each(read);
        }
        live[pc] = set;
    }
    live
}
