//! Shaders between bytecode and machine code: typed SSA on scalars alone.
//!
//! Points, arrays and closures are gone at this stage. Blocks take parameters; a value is used only
//! where its definition dominates. Whatever the interpreter would report as an error leads to
//! [`Term::Leave`].

use std::collections::BTreeSet;

use compiler::op::Operator;

/// The types of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    Real,
    Int,
    Bool,
}

/// A value; the first are the arguments and the uniforms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Val(pub(crate) u32);

/// A block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Block(pub(crate) u32);

/// The arguments of a surface function, as the values that they are.
pub(crate) const FACE: Val = Val(0);
pub(crate) const U: Val = Val(1);
pub(crate) const V: Val = Val(2);
/// Number of arguments; value `N_ARGUMENTS + i` is uniform i.
pub(crate) const N_ARGUMENTS: u32 = 3;

/// What defines a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Inst {
    Real(f64),
    Int(i64),
    Bool(bool),
    /// 1 for true, 0 for false.
    IntOfBool(Val),
    /// A scalar operator; a unary one has its operand twice. Leaves where it has no result.
    Scalar(Operator, [Val; 2]),
    /// The index itself, checked to be at least 0 and below the length; leaves otherwise.
    Checked {
        index: Val,
        length: u32,
    },
    /// `offset + index * stride`, without overflow by construction.
    Offset {
        offset: Option<Val>,
        index: Val,
        stride: u32,
    },
    /// An entry of a constant table, at an index in range.
    Entry {
        table: u32,
        index: Val,
    },
}

/// How a block ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Term {
    Jump(Block, Vec<Val>),
    /// To the first block if true.
    Branch(Val, [Block; 2]),
    /// By an integer in range.
    Switch(Val, Vec<Block>),
    /// Red, green, blue, kd, ks, n.
    Return([Val; 6]),
    /// The interpreter must have a look.
    Leave,
}

/// A bytecode instruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Site {
    /// The function.
    pub function: u32,
    /// Index of the instruction in it.
    pub pc: u32,
}

/// A block's contents.
#[derive(Clone, Debug)]
pub(crate) struct BlockData {
    pub(crate) params: Vec<Val>,
    pub(crate) insts: Vec<(Val, Inst, Site)>,
    pub(crate) term: Option<(Term, Site)>,
    /// What it was begun for.
    pub(crate) site: Site,
    /// The head of a loop, where fuel is taken.
    pub(crate) is_loop: bool,
}

/// Numbers that a shader looks up by index, as their bits.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    pub(crate) ty: Type,
    pub(crate) entries: Vec<u64>,
}

/// A specialized surface function.
#[derive(Clone, Debug)]
pub(crate) struct Shader {
    pub(crate) types: Vec<Type>,
    pub(crate) blocks: Vec<BlockData>,
    pub(crate) tables: Vec<Table>,
    pub(crate) n_uniforms: u32,
    /// The functions that were run.
    pub(crate) functions: BTreeSet<u32>,
    /// The most that one pass through the code costs in the interpreter's fuel.
    pub(crate) cost: u64,
    /// The most calls that are active at once in the interpreter.
    pub(crate) depth: usize,
}

impl Shader {
    pub(crate) fn type_of(&self, val: Val) -> Type {
        self.types[val.0 as usize]
    }

    /// Which values the results, the control flow or the chance to leave depend on.
    pub(crate) fn live(&self) -> Vec<bool> {
        let mut live = vec![false; self.types.len()];
        // Uses come after definitions but for loops, whose arguments may wake earlier values.
        loop {
            let before = live.iter().filter(|&&l| l).count();
            for block in self.blocks.iter().rev() {
                self.mark(block, &mut live);
            }
            if live.iter().filter(|&&l| l).count() == before {
                return live;
            }
        }
    }

    fn mark(&self, block: &BlockData, live: &mut [bool]) {
        let mut wake = |val: Val| live[val.0 as usize] = true;
        match &block.term {
            Some((Term::Jump(target, args), _)) => {
                let params = &self.blocks[target.0 as usize].params;
                for (param, arg) in params.iter().zip(args) {
                    if live[param.0 as usize] {
                        live[arg.0 as usize] = true;
                    }
                }
            }
            Some((Term::Branch(val, _) | Term::Switch(val, _), _)) => wake(*val),
            Some((Term::Return(vals), _)) => vals.iter().copied().for_each(wake),
            Some((Term::Leave, _)) | None => {}
        }
        for (val, inst, _) in block.insts.iter().rev() {
            if inst.may_leave() || live[val.0 as usize] {
                live[val.0 as usize] = true;
                for operand in inst.operands().into_iter().flatten() {
                    live[operand.0 as usize] = true;
                }
            }
        }
    }
}

impl Inst {
    /// The values that it uses.
    pub(crate) fn operands(&self) -> [Option<Val>; 2] {
        match *self {
            Inst::Real(_) | Inst::Int(_) | Inst::Bool(_) => [None, None],
            Inst::IntOfBool(a) => [Some(a), None],
            Inst::Scalar(_, [a, b]) => [Some(a), Some(b)],
            Inst::Checked { index, .. } | Inst::Entry { index, .. } => [Some(index), None],
            Inst::Offset { offset, index, .. } => [offset, Some(index)],
        }
    }

    /// Whether it has no result for some operands.
    pub(crate) fn may_leave(&self) -> bool {
        match self {
            Inst::Checked { .. } => true,
            Inst::Scalar(op, _) => matches!(
                op,
                Operator::AddI
                    | Operator::SubI
                    | Operator::MulI
                    | Operator::DivI
                    | Operator::ModI
                    | Operator::NegI
                    | Operator::Floor
                    | Operator::Sqrt
            ),
            _ => false,
        }
    }
}
