//! Shaders between bytecode and machine code: typed SSA on scalars alone.
//!
//! Points, arrays and closures are gone at this stage. Blocks take parameters; a value is used only
//! where its definition dominates. Whatever the interpreter would report as an error leads to
//! [`Term::Leave`]. A recursion that is neither a loop nor of known depth is a [`Routine`], which
//! the shader and routines call.

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
/// Number of further arguments of a bounded shader, behind the uniforms: the radii of u and v.
pub(crate) const N_RADII: u32 = 2;

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
        offset: Val,
        index: Val,
        stride: u32,
    },
    /// An entry of a constant table: `column` numbers behind the one at an index in range.
    Entry {
        table: u32,
        start: Val,
        column: u32,
    },
    /// The size of a real.
    Abs(Val),
    /// The first real itself, checked to be so related to the second; leaves otherwise.
    Require(Relation, [Val; 2]),
    /// The value itself, which is decided here: a boolean or an integer, or the whole part of a real.
    Decided(Val),
}

/// What a shader computes besides its results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Version {
    /// Nothing.
    Plain,
    /// How far off they may be: it takes the radii of u and v behind the uniforms, and returns those
    /// of its results.
    Bounded,
    /// The signature of its decisions.
    Signed,
}

/// How two reals may be related; NaN is not related to anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    Less,
    AtMost,
}

/// How a block ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Term {
    Jump(Block, Vec<Val>),
    /// To the first block if true.
    Branch(Val, [Block; 2]),
    /// By an integer in range.
    Switch(Val, Vec<Block>),
    /// Of a shader: red, green, blue, kd, ks, n, and if it is a bounded one their radii. Of a routine:
    /// its results.
    Return(Vec<Val>),
    /// Calls the routine of that number; goes on in the block, whose parameters are the results.
    Call(u32, Vec<Val>, Block),
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

/// Numbers of one type, or points, that a shader looks up by index.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table {
    pub(crate) ty: Type,
    /// Whether it holds points: those take a row each, numbers one place of a row.
    pub(crate) holds_points: bool,
    /// Bits of the numbers; what is left of the last row are zeros.
    pub(crate) rows: Vec<[u64; ROW_LEN]>,
}

/// Numbers of a row. The fourth of a point is not used: so a row is a power of two of bytes, which indices
/// are multiplied by in no time.
pub(crate) const ROW_LEN: usize = 4;

impl Table {
    pub(crate) fn entries(&self) -> &[u64] {
        self.rows.as_flattened()
    }
}

/// A specialized surface function.
#[derive(Clone, Debug)]
pub(crate) struct Shader {
    /// Its parameters are the arguments and the uniforms.
    pub(crate) main: Body,
    pub(crate) routines: Vec<Routine>,
    pub(crate) tables: Vec<Table>,
    pub(crate) n_uniforms: u32,
    /// The functions that were run.
    pub(crate) functions: BTreeSet<u32>,
    pub(crate) version: Version,
}

impl Shader {
    /// The code of the shader and of its routines.
    pub(crate) fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.routines.iter().map(|routine| &routine.body).chain([&self.main])
    }

    /// The radii of u and v, if it takes them.
    pub(crate) fn radii(&self) -> impl Iterator<Item = Val> + use<> {
        let first = N_ARGUMENTS + self.n_uniforms;
        (first..first + if self.version == Version::Bounded { N_RADII } else { 0 }).map(Val)
    }
}

/// Code that calls itself, or others that call it.
#[derive(Clone, Debug)]
pub(crate) struct Routine {
    pub(crate) body: Body,
    pub(crate) results: Vec<Type>,
}

/// The code of a shader or routine; it starts with the first block.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    /// Of the values; the first are the parameters.
    pub(crate) types: Vec<Type>,
    pub(crate) n_params: usize,
    pub(crate) blocks: Vec<BlockData>,
    pub(crate) costs: Costs,
}

/// What the interpreter needs for what a body does.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Costs {
    /// The most fuel for one pass through the code.
    pub(crate) fuel: u64,
    /// The most calls that are active at once.
    pub(crate) depth: usize,
    /// The most bytes of values that one pass through the code makes.
    pub(crate) memory: u64,
    /// The most arrays and closures that it makes: those may stay when it is done.
    pub(crate) n_holders: u64,
}

impl Body {
    pub(crate) fn new(params: Vec<Type>) -> Self {
        let n_params = params.len();
        Body { types: params, n_params, blocks: Vec::new(), costs: Costs::default() }
    }

    /// Its number of values and blocks.
    pub(crate) fn size(&self) -> usize {
        self.types.len() + self.blocks.len()
    }

    /// Its number of instructions.
    pub(crate) fn n_insts(&self) -> usize {
        self.blocks.iter().map(|block| block.insts.len()).sum()
    }

    /// Whether it calls routines.
    pub(crate) fn has_calls(&self) -> bool {
        self.blocks.iter().any(|block| matches!(block.term, Some((Term::Call(..), _))))
    }

    pub(crate) fn type_of(&self, val: Val) -> Type {
        self.types[val.0 as usize]
    }

    /// Which values the results, the control flow, decisions or the chance to leave depend on.
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
            Some((Term::Return(vals) | Term::Call(_, vals, _), _)) => {
                vals.iter().copied().for_each(wake);
            }
            Some((Term::Leave, _)) | None => {}
        }
        for (val, inst, _) in block.insts.iter().rev() {
            if inst.may_leave() || matches!(inst, Inst::Decided(_)) || live[val.0 as usize] {
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
            Inst::IntOfBool(a) | Inst::Abs(a) | Inst::Decided(a) => [Some(a), None],
            Inst::Scalar(_, [a, b]) | Inst::Require(_, [a, b]) => [Some(a), Some(b)],
            Inst::Checked { index, .. } => [Some(index), None],
            Inst::Entry { start, .. } => [Some(start), None],
            Inst::Offset { offset, index, .. } => [Some(offset), Some(index)],
        }
    }

    /// Whether it has no result for some operands.
    pub(crate) fn may_leave(&self) -> bool {
        match self {
            Inst::Checked { .. } | Inst::Require(..) => true,
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
