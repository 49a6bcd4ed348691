//! Real constants, in the forms that x86-64 has in a register or in memory soonest.
//!
//! Cranelift makes a real that an instruction cannot read from memory of 64 bits of code, which go
//! through an integer register: 15 bytes of code. As part of a vector it is one load, 8 bytes of code and
//! 16 beside it.

use cranelift_codegen::ir::immediates::Ieee64;
use cranelift_codegen::ir::{
    self, ConstantData, InstBuilder, InstructionData, MemFlagsData, types,
};

use crate::lower::Lowering;

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

    /// Stores values in a row, two constants at once.
    pub(super) fn store_all(&mut self, values: &[ir::Value], to: ir::Value) {
        let mut index = 0;
        while index < values.len() {
            let constant = |index: usize| self.constant(*values.get(index)?);
            let (value, n_stored) = match (constant(index), constant(index + 1)) {
                (Some(a), Some(b)) if AS_VECTORS => (self.vector([a, b]), 2),
                _ => (self.in_register(values[index]), 1),
            };
            // The results are aligned for doubles, not for vectors.
            let flags = MemFlagsData::new().with_notrap();
            self.builder.ins().store(flags, value, to, index as i32 * 8);
            index += n_stored;
        }
    }

    fn constant(&self, value: ir::Value) -> Option<Ieee64> {
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
