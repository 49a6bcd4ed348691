//! Subscripts and tables.
//!
//! A subscript is mostly the whole part of a real (`u 3.0 mulf floor get`). In general that is a
//! conversion with two comparisons before it and more within. Here one addition does it, and the check
//! that the subscript is in range also tells whether the addition was exact.

use std::collections::HashSet;

use compiler::op::Operator;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::{self, InstBuilder, MemFlagsData, types};

use crate::lower::{Lowering, clif_type};
use crate::sir::{Body, Inst, Term, Val};

/// Half way from 2^52 to 2^53, where reals are the integers and have consecutive bits: `SHIFT + i` has the
/// bits of `SHIFT` but for the last 51, which are those of i, for 0 <= i < 2^51.
const SHIFT: f64 = 6_755_399_441_055_744.0;

/// Which values are whole parts of reals that are used for nothing but subscripts, by value. One of the
/// checks is in the same block, so that whoever finds the whole part also comes to a check.
pub(super) fn subscripts(body: &Body) -> Vec<bool> {
    let mut are = vec![false; body.types.len()];
    for block in &body.blocks {
        let mut floors = HashSet::new();
        for (val, inst, _) in &block.insts {
            match inst {
                Inst::Scalar(Operator::Floor, _) => _ = floors.insert(*val),
                Inst::Checked { index, .. } => are[index.0 as usize] |= floors.contains(index),
                _ => {}
            }
        }
    }
    let mut is_used = |val: Val| are[val.0 as usize] = false;
    let insts = body.blocks.iter().flat_map(|block| &block.insts).map(|(_, inst, _)| inst);
    for inst in insts.filter(|inst| !matches!(inst, Inst::Checked { .. })) {
        inst.operands().into_iter().flatten().for_each(&mut is_used);
    }
    for (term, _) in body.blocks.iter().filter_map(|block| block.term.as_ref()) {
        match term {
            Term::Jump(_, vals) | Term::Return(vals) | Term::Call(_, vals, _) => {
                vals.iter().copied().for_each(&mut is_used);
            }
            Term::Branch(val, _) | Term::Switch(val, _) => is_used(*val),
            Term::Leave => {}
        }
    }
    are
}

impl Lowering<'_, '_> {
    /// A subscript that is yet to be checked, as the real that it is.
    pub(super) fn whole_part(&mut self, floor: &Inst) -> ir::Value {
        let [Some(real), _] = floor.operands() else { unreachable!("it has an operand") };
        let real = self.value(real);
        self.builder.ins().floor(real)
    }

    pub(super) fn checked(&mut self, index: Val, length: u32) -> ir::Value {
        let value = self.value(index);
        let index = if self.are_subscripts[index.0 as usize] { self.shifted(value) } else { value };
        // Unsigned, negative indices are the largest.
        let is_out = self.builder.ins().icmp_imm_s(
            IntCC::UnsignedGreaterThanOrEqual,
            index,
            i64::from(length),
        );
        self.leave_if(is_out);
        index
    }

    /// A whole real as an integer; what is not from 0 to 2^51 becomes something else that is not.
    ///
    /// If the result is such an i, then the sum is `SHIFT + i`, between 2^52 and 2^53. There reals are 1
    /// apart, so that the exact sum is within 1/2 of it; and since the real is whole, it is i. NaN has
    /// other bits.
    fn shifted(&mut self, whole: ir::Value) -> ir::Value {
        let shift = self.builder.ins().f64const(SHIFT);
        let sum = self.builder.ins().fadd(whole, shift);
        let bits = self.in_register(shift);
        let difference = self.builder.ins().bxor(sum, bits);
        self.builder.ins().bitcast(types::I64, MemFlagsData::new(), difference)
    }

    pub(super) fn offset(&mut self, offset: Val, index: Val, stride: u32) -> ir::Value {
        let (offset, index) = (self.value(offset), self.value(index));
        let scaled = self.builder.ins().imul_imm_s(index, i64::from(stride));
        self.builder.ins().iadd(offset, scaled)
    }

    pub(super) fn entry_of_table(&mut self, table: u32, start: Val, column: u32) -> ir::Value {
        let rows = &self.around.shader.tables[table as usize];
        if !rows.holds_points || column == 0 {
            return self.load(clif_type(rows.ty), table, start, column);
        }
        // The other two come as one, which is how results are stored.
        let numbers = match self.point {
            Some((last, at, numbers)) if (last, at) == (table, start) => numbers,
            _ => self.load(types::F64X2, table, start, 1),
        };
        self.point = Some((table, start, numbers));
        self.builder.ins().extractlane(numbers, column as u8 - 1)
    }

    /// What lies so many numbers behind one of a table. All tables are read from one address, and lie one
    /// after the other.
    fn load(&mut self, ty: ir::Type, table: u32, start: Val, column: u32) -> ir::Value {
        let before = &self.around.shader.tables[..table as usize];
        let n_before: usize = before.iter().map(|table| table.entries().len()).sum();
        let base = self.builder.ins().iconst(self.pointer, self.around.tables as i64);
        let start = self.value(start);
        let bytes = self.builder.ins().ishl_imm_s(start, 3);
        let address = self.builder.ins().iadd(base, bytes);
        // Two numbers are aligned each by itself.
        let flags = MemFlagsData::new().with_notrap().with_readonly();
        self.builder.ins().load(ty, flags, address, (n_before as i32 + column as i32) * 8)
    }
}
