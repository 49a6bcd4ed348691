//! Real constants, in the forms that x86-64 has in a register or in memory soonest; and results, two at
//! once where they come as two.
//!
//! Cranelift makes a real that an instruction cannot read from memory of 64 bits of code, which go
//! through an integer register: 15 bytes of code. As part of a vector it is one load, 8 bytes of code and
//! 16 beside it.

use cranelift_codegen::ir::immediates::Ieee64;
use cranelift_codegen::ir::{
    self, ConstantData, InstBuilder, InstructionData, MemFlagsData, Opcode, types,
};

use crate::lower::Lowering;
use crate::sir::Val;

/// Whether constants are loaded as vectors.
const AS_VECTORS: bool = cfg!(target_arch = "x86_64");

impl Lowering<'_, '_> {
    /// The value, as what is quickest to have in a register.
    pub(super) fn in_register(&mut self, value: ir::Value) -> ir::Value {
        match self.constant(value) {
            // Zero needs no load.
            Some(real) if AS_VECTORS && real.bits() != 0 => {
                let vector = self.vector([real, Ieee64::with_bits(0)]);
                self.builder.ins().extractlane(vector, 0)
            }
            _ => value,
        }
    }

    /// The operands of what is the same either way, so that a constant may be read from memory.
    pub(super) fn constant_last(&self, [a, b]: [ir::Value; 2]) -> [ir::Value; 2] {
        if self.constant(a).is_some() { [b, a] } else { [a, b] }
    }

    /// Stores reals in a row.
    pub(super) fn store_all(&mut self, vals: &[Val], to: ir::Value) {
        let mut index = 0;
        while index < vals.len() {
            let value = self.value(vals[index]);
            let pair = vals.get(index + 1).and_then(|next| self.pair(value, self.value(*next)));
            let n_stored = if pair.is_some() { 2 } else { 1 };
            let value = pair.unwrap_or_else(|| self.in_register(value));
            // They are aligned for doubles, not for vectors.
            let flags = MemFlagsData::new().with_notrap();
            self.builder.ins().store(flags, value, to, index as i32 * 8);
            index += n_stored;
        }
    }

    /// Two reals as a vector, if they are constants or have come as one.
    fn pair(&mut self, first: ir::Value, second: ir::Value) -> Option<ir::Value> {
        match (self.constant(first), self.constant(second)) {
            (Some(first), Some(second)) if AS_VECTORS => Some(self.vector([first, second])),
            _ => {
                let (vector, lane) = self.lane(first)?;
                (lane == 0 && self.lane(second) == Some((vector, 1))).then_some(vector)
            }
        }
    }

    /// The vector that a value is part of, and which.
    fn lane(&self, value: ir::Value) -> Option<(ir::Value, u8)> {
        let dfg = &self.builder.func.dfg;
        match dfg.insts[dfg.value_def(value).inst()?] {
            InstructionData::BinaryImm8 { opcode: Opcode::Extractlane, arg, imm } => {
                Some((arg, imm))
            }
            _ => None,
        }
    }

    pub(super) fn constant(&self, value: ir::Value) -> Option<Ieee64> {
        let dfg = &self.builder.func.dfg;
        match dfg.insts[dfg.value_def(value).inst()?] {
            InstructionData::UnaryIeee64 { imm, .. } => Some(imm),
            _ => None,
        }
    }

    fn vector(&mut self, reals: [Ieee64; 2]) -> ir::Value {
        let bytes: Vec<u8> = reals.iter().flat_map(|real| real.bits().to_le_bytes()).collect();
        let constant = self.builder.func.dfg.constants.insert(ConstantData::from(bytes));
        self.builder.ins().vconst(types::F64X2, constant)
    }
}
