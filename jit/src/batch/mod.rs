//! Shaders over many points at once.
//!
//! A [`Batch`] is the SSA of a shader without loops and routines, in a row: each [`Step`] is done for all
//! points before the next, by a loop that the compiler makes vector instructions of. Blocks become
//! masks: what a block computes counts at the points that reach it, and where none does it is skipped.
//! At a point where the interpreter must have a look there is no answer.
//!
//! Each step does what `compiler::scalar` says, in the order of the shader: the bits are those of native
//! code.

use compiler::op::Operator;
use renderer::surface::MAX_BATCH;

mod build;
mod run;

pub(crate) use build::build;
pub(crate) use run::Lanes;

/// The most points at once.
const WIDTH: usize = MAX_BATCH;

/// Registers that take so much room (16 KiB) stay in the first-level cache.
const MAX_REGISTERS: usize = 32;

/// A shader as steps over many points.
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    steps: Vec<Step>,
    n_registers: usize,
    /// The registers of red, green, blue, kd, ks, n.
    results: [u32; 6],
    /// Whether it is quicker than many calls of native code.
    pub(crate) pays: bool,
}

/// What a step reads: 64 bits for each point. Booleans are masks: all bits are 1 for true, or 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operand {
    Register(u32),
    /// The same at all points.
    Same(u64),
    /// The same at all points: that of a closure.
    Uniform(u32),
}

/// True at all points.
const ALL: Operand = Operand::Same(!0);

/// The registers that the arguments are in at first: face, u, v.
const ARGUMENTS: [u32; 3] = [0, 1, 2];

/// One operation at all points.
#[derive(Clone, Copy, Debug)]
struct Step {
    action: Action,
    /// The register of the result.
    to: u32,
    a: Operand,
    b: Operand,
    /// Where it counts.
    mask: Operand,
}

/// What a step does with its operands.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Action {
    /// There is no answer where the operator has no result.
    Scalar(Operator),
    Copy,
    /// The first operand where the mask holds; elsewhere the result stays as it was.
    Blend,
    And,
    /// The first, where the second does not hold.
    AndNot,
    Or,
    IntOfBool,
    /// The first; there is no answer where it is negative or not below the length.
    Checked(u32),
    /// `b + a * stride`.
    Offset(u32),
    /// Of this table, in the row that starts at the first.
    Entry {
        table: u32,
        column: u32,
    },
    /// There is no answer.
    Leave,
    /// Passes over so many steps if the mask holds nowhere.
    Skip(u32),
}
