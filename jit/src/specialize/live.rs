//! Which registers are still to be read.

use std::rc::Rc;

use compiler::bytecode::{CaptureSource, Format, Function, Insn, Opcode, Program};

use crate::specialize::Specializer;

/// A set of registers, by bit.
type Set = [u64; 4];

impl Specializer<'_> {
    /// For each instruction of a function, the registers that may be read from there on before they
    /// are written. Jumps go forward, so one pass from the end is exact.
    pub(super) fn live_registers(&mut self, function: u32) -> Rc<Vec<Set>> {
        if let Some(known) = self.live_registers.get(&function) {
            return known.clone();
        }
        let live = Rc::new(live(self.program, self.function(function)));
        self.live_registers.insert(function, live.clone());
        live
    }
}

fn live(program: &Program, function: &Function) -> Vec<Set> {
    let mut live = vec![[0; 4]; function.code.len() + 1];
    for (pc, insn) in function.code.iter().enumerate().rev() {
        let mut set = match insn.op {
            Opcode::Return | Opcode::TailApply | Opcode::Unbound => [0; 4],
            Opcode::Jump => live[pc + 1 + insn.imm as usize],
            _ => live[pc + 1],
        };
        if matches!(insn.op.format(), Format::AJump | Format::ABJump | Format::AKJump) {
            let target = live[pc + 1 + insn.imm as usize];
            set = std::array::from_fn(|i| set[i] | target[i]);
        }
        let (reads, writes) = effects(program, insn);
        for register in writes {
            set[register as usize / 64] &= !(1 << (register % 64));
        }
        for register in reads {
            set[register as usize / 64] |= 1 << (register % 64);
        }
        live[pc] = set;
    }
    live
}

/// The registers that an instruction reads and those that it writes.
fn effects(program: &Program, insn: &Insn) -> (Vec<u8>, Vec<u8>) {
    let Insn { op, a, b, c, imm } = *insn;
    match (op, op.format()) {
        (Opcode::Push | Opcode::Apply | Opcode::TailApply | Opcode::Spill, _) => (vec![a], vec![]),
        (Opcode::Push2, _) | (_, Format::ABJump) => (vec![a, b], vec![]),
        (Opcode::Push3, _) => (vec![a, b, c], vec![]),
        (Opcode::MakeClosure, _) => {
            let captured = program.functions[imm as usize].captures.iter();
            let reads = captured.filter_map(|source| match source {
                CaptureSource::Register(register) => Some(*register),
                _ => None,
            });
            (reads.collect(), vec![a])
        }
        (_, Format::Range) => (vec![], (0..b).map(|offset| a.wrapping_add(offset)).collect()),
        (_, Format::AJump | Format::AKJump) => (vec![a], vec![]),
        (_, Format::AB | Format::ABConstant) => (vec![b], vec![a]),
        (_, Format::ABC) => (vec![b, c], vec![a]),
        (_, Format::ABCRegister) => (vec![a, b, c], vec![imm as u8]),
        (_, Format::None | Format::Constant | Format::Jump) => (vec![], vec![]),
        (
            _,
            Format::A
            | Format::AConstant
            | Format::ACapture
            | Format::ASlot
            | Format::AFunction
            | Format::ACount
            | Format::AOperator,
        ) => (vec![], vec![a]),
    }
}
