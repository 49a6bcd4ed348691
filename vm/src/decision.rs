//! Decisions of surface functions, which signatures are made of.

use compiler::scalar::{self, Operands};

use crate::registers::Window;
use crate::step::{Op, Step};

/// What a step is about to decide, if that can be told from its operands alone: the condition of an
/// `if`, the result of `floor`, the whole part in `frac`, the index of `get`. The outcomes of comparisons
/// that jump are known when they have been made. Where operands are of the wrong types, the function
/// fails.
pub(crate) fn decision(step: &Step, frame: &Window<'_>, accumulator: f64) -> Option<u64> {
    match step.op {
        Op::JumpUnless | Op::Choose => frame.get(step.a).as_bool().map(u64::from),
        Op::Get => frame.get(step.c).as_int().map(|index| index as u64),
        Op::Floor => frame.get(step.b).as_real().and_then(whole),
        Op::FloorA => whole(accumulator),
        Op::Frac => frame.get(step.b).as_real().map(whole_part),
        Op::FracA => Some(whole_part(accumulator)),
        _ => None,
    }
}

fn whole(x: f64) -> Option<u64> {
    scalar::floor(x).ok().map(|whole| whole as u64)
}

/// Toward 0, and the nearest integer of the machine where it is none.
fn whole_part(x: f64) -> u64 {
    x as i64 as u64
}
