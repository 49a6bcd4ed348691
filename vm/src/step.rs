//! Steps: the form in which the interpreter runs bytecode.
//!
//! A function has as many steps as instructions, one at each position, so that jumps, origins and
//! fuel are those of the bytecode. Most steps are the instruction itself. The others find an operand
//! where it is faster to reach than in a register: constants stand in the step, and what the last
//! operator with a real result has left is still in the accumulator, a register of the CPU. A fused
//! step does what a few instructions in a row do and goes on behind them; those have their own steps
//! too, where jumps may land.

use compiler::bytecode::{Format, Insn, Opcode};
use compiler::flow::jump_targets;
use compiler::op::{Operator, Type};
use compiler::{for_each_control, for_each_scalar};

use crate::word::{Tag, Word};

/// Calls `$then!` with the scalar operators that have further steps, and those, behind any tokens
/// given in `[ ]`. Letters say where operands are: `R` in a register, `A` in the accumulator, `K` in
/// the step. Fused are `Load` and an operator whose first operand it loads (`K` first), `Capture` and
/// an operator whose second operand it fetches (`C`), and two operators of which the second takes the
/// result of the first (`pair`).
macro_rules! for_each_further {
    ($then:ident, [$($extra:tt)*]) => {
        $then! {
            [$($extra)*]
            unary {
                NegF NegA neg_f -> Real;
                Floor FloorA floor -> Int;
                Frac FracA frac -> Real;
                ClampF ClampA clamp_f -> Real;
                Sqrt SqrtA sqrt -> Real;
                Sin SinA sin -> Real;
                Cos CosA cos -> Real;
            }
            binary {
                AddF AddFK add_f AddRA AddAR AddAA AddAK AddKR AddKA AddRC AddAC;
                SubF SubFK sub_f SubRA SubAR SubAA SubAK SubKR SubKA SubRC SubAC;
                MulF MulFK mul_f MulRA MulAR MulAA MulAK MulKR MulKA MulRC MulAC;
                DivF DivFK div_f DivRA DivAR DivAA DivAK DivKR DivKA DivRC DivAC;
            }
            jump {
                JumpUnlessLessF JumpUnlessLessFK less_f JumpUnlessLessRA JumpUnlessLessAR JumpUnlessLessAK;
            }
            pair {
                AddF add_f r AddF AddFK add_f AddAddRA AddAddAR AddAddAK;
                AddF add_f r SubF SubFK sub_f AddSubRA AddSubAR AddSubAK;
                AddF add_f r MulF MulFK mul_f AddMulRA AddMulAR AddMulAK;
                SubF sub_f r AddF AddFK add_f SubAddRA SubAddAR SubAddAK;
                SubF sub_f r SubF SubFK sub_f SubSubRA SubSubAR SubSubAK;
                SubF sub_f r MulF MulFK mul_f SubMulRA SubMulAR SubMulAK;
                MulF mul_f r AddF AddFK add_f MulAddRA MulAddAR MulAddAK;
                MulF mul_f r SubF SubFK sub_f MulSubRA MulSubAR MulSubAK;
                MulF mul_f r MulF MulFK mul_f MulMulRA MulMulAR MulMulAK;
                MulFK mul_f k AddF AddFK add_f MulKAddRA MulKAddAR MulKAddAK;
                MulFK mul_f k SubF SubFK sub_f MulKSubRA MulKSubAR MulKSubAK;
                MulFK mul_f k MulF MulFK mul_f MulKMulRA MulKMulAR MulKMulAK;
            }
        }
    };
}
pub(crate) use for_each_further;

macro_rules! op_enum {
    ([[control { $($(#[$kd:meta])+ $k:ident $kf:ident;)* }]
      unary { $($(#[$ud:meta])+ $u:ident $us:literal $uf:ident($ut:ident) -> $ur:ident;)* }
      binary { $($(#[$bd:meta])+ $b:ident $bk:ident $bs:literal $bf:ident($bt:ident, $bt2:ident) -> $br:ident;)* }
      compare { $($(#[$cd:meta])+ $c:ident $ck:ident $cj:ident $cjk:ident $cs:literal $cf:ident($ct:ident, $ct2:ident) -> $cr:ident;)* }
      ternary { $($(#[$td:meta])+ $t:ident $ts:literal $tf:ident($tt:ident, $tt2:ident, $tt3:ident) -> $tr:ident;)* }]
      unary { $($xu:ident $xua:ident $xuf:ident -> $xur:ident;)* }
      binary { $($xb:ident $xbk:ident $xbf:ident $ra:ident $ar:ident $aa:ident $ak:ident $kr:ident $ka:ident $rc:ident $ac:ident;)* }
      jump { $($xj:ident $xjk:ident $xjf:ident $jra:ident $jar:ident $jak:ident;)* }
      pair { $($p:ident $pf:ident $pc:ident $q:ident $qk:ident $qf:ident $pra:ident $par:ident $pak:ident;)* }) => {
        /// What a step does.
        #[derive(Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub(crate) enum Op {
            $($k,)* $($u,)* $($b, $bk,)* $($c, $ck, $cj, $cjk,)* $($t,)*
            $($xua,)* $($ra, $ar, $aa, $ak, $kr, $ka, $rc, $ac,)* $($jra, $jar, $jak,)*
            $($pra, $par, $pak,)*
            /// `Push3` and `Push`: the fourth register is in `imm`.
            Push4,
            /// `Pop` of three values.
            Pop3,
            /// `Pop` of three values and of a fourth.
            Pop4,
            /// The products of two pairs of registers and their sum.
            SumOfProducts,
            /// The same and a jump unless the sum is less than a constant.
            SumOfProductsTest,
            /// The products of two registers with constants and their sum.
            SumOfMultiples,
            /// Up to four pushes and `TailApply`, most likely of the running closure, with a value to
            /// move for each that the next round wants elsewhere than it is. The registers to push are
            /// in `a`, `b`, `c` and the lowest byte of `imm`; the others are the register of the
            /// closure, and the number of pushes and, in the upper half, of moves. Of `k`, each two
            /// bytes are the registers of a move.
            Again,
            /// `AddIK` and `Again`.
            AddAgain,
            /// `SubIK` and `Again`.
            SubAgain,
            /// Three times `PushConstant`: the second and third index are in `k`.
            PushConstants,
            /// An instruction that finds a constant of the wrong type.
            Mistyped,
        }

        impl Op {
            fn of(op: Opcode) -> Op {
                match op {
                    $(Opcode::$k => Op::$k,)* $(Opcode::$u => Op::$u,)*
                    $(Opcode::$b => Op::$b, Opcode::$bk => Op::$bk,)*
                    $(Opcode::$c => Op::$c, Opcode::$ck => Op::$ck, Opcode::$cj => Op::$cj, Opcode::$cjk => Op::$cjk,)*
                    $(Opcode::$t => Op::$t,)*
                }
            }

            /// The same with the first operand, or the only one, in the accumulator.
            fn with_first_accumulated(self) -> Option<Op> {
                Some(match self {
                    $(Op::$xu => Op::$xua,)* $(Op::$xb => Op::$ar, Op::$xbk => Op::$ak,)*
                    $(Op::$xj => Op::$jar, Op::$xjk => Op::$jak,)*
                    $(Op::$ra => Op::$aa, Op::$rc => Op::$ac,)*
                    _ => return None,
                })
            }

            /// The same with the second operand in the accumulator.
            fn with_second_accumulated(self) -> Option<Op> {
                Some(match self {
                    $(Op::$xb => Op::$ra, Op::$kr => Op::$ka,)* $(Op::$xj => Op::$jra,)*
                    _ => return None,
                })
            }

            /// Fused with the `Load` of the first operand.
            fn with_first_loaded(self) -> Option<Op> {
                Some(match self { $(Op::$xb => Op::$kr,)* _ => return None })
            }

            /// Fused with the `Capture` of the second operand.
            fn with_second_captured(self) -> Option<Op> {
                Some(match self { $(Op::$xb => Op::$rc,)* _ => return None })
            }

            /// Two operators with real results, the first on registers or with a constant, the second
            /// with the result of the first as its first or second operand.
            fn pair(first: Op, second: Op, is_result_first: bool) -> Option<Op> {
                Some(match (first, second, is_result_first) {
                    $((Op::$p, Op::$q, true) => Op::$par, (Op::$p, Op::$q, false) => Op::$pra,
                      (Op::$p, Op::$qk, true) => Op::$pak,)*
                    _ => return None,
                })
            }
        }
    };
}

macro_rules! with_scalars {
    ([] $($control:tt)*) => { for_each_scalar!(with_further, [$($control)*]); };
}

macro_rules! with_further {
    ($($scalar:tt)*) => { for_each_further!(op_enum, [$($scalar)*]); };
}

for_each_control!(with_scalars, []);

/// One step. Registers and other small numbers are in the fields of the instruction that it comes
/// from, if not said otherwise.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    pub(crate) op: Op,
    pub(crate) a: u8,
    pub(crate) b: u8,
    pub(crate) c: u8,
    pub(crate) imm: u32,
    /// The payload of the constant operand.
    pub(crate) k: u64,
}

/// The steps of a function with these constants, and where a further round begins that is called in
/// its place.
pub(crate) fn translate(code: &[Insn], constants: &[Word]) -> (Vec<Step>, usize) {
    let mut translation = Translation { constants, entry: Entry::new(code), accumulated: None };
    let is_target = jump_targets(code);
    let mut steps = Vec::with_capacity(code.len());
    for (pc, insn) in code.iter().enumerate() {
        if is_target[pc] {
            translation.accumulated = None;
        }
        let fused = translation.fused(&code[pc..]);
        steps.push(fused.unwrap_or_else(|| translation.single(insn)));
        translation.update(insn);
    }
    (steps, translation.entry.n_first)
}

/// How a function begins.
struct Entry {
    /// The registers that its first pops fill, topmost value first.
    parameters: Vec<u8>,
    /// Number of instructions that a further round can leave out: the pops, and captures behind them
    /// into registers that nothing else writes.
    n_first: usize,
}

impl Entry {
    fn new(code: &[Insn]) -> Entry {
        let pops = code.iter().take_while(|insn| insn.op == Opcode::Pop);
        let (n_pops, parameters) = (
            pops.clone().count(),
            pops.flat_map(|pop| (0..pop.b).map(|offset| pop.a.wrapping_add(offset))).collect(),
        );
        let is_kept = |capture: &&Insn| {
            capture.op == Opcode::Capture
                && code.iter().filter(|insn| insn.is_writing(capture.a)).count() == 1
        };
        // A few captures are enough; the limit bounds the time that this takes.
        let n_captures = code[n_pops..].iter().take(MAX_KEPT).take_while(is_kept).count();
        Entry { parameters, n_first: n_pops + n_captures }
    }
}

/// The most captured values that stay in their registers for further rounds.
const MAX_KEPT: usize = 16;

fn pops_four(first: &Insn, second: &Insn) -> bool {
    (first.op, first.b, second.op, second.b) == (Opcode::Pop, 3, Opcode::Pop, 1)
        && second.a == first.a.wrapping_add(3)
}

struct Translation<'f> {
    constants: &'f [Word],
    entry: Entry,
    /// The register whose value is in the accumulator too.
    accumulated: Option<u8>,
}

impl Translation<'_> {
    /// The step of the first instruction alone.
    fn single(&self, insn: &Insn) -> Step {
        let Insn { a, b, c, imm, .. } = *insn;
        let step = Step { op: Op::of(insn.op), a, b, c, imm, k: 0 };
        match insn.op.format() {
            Format::AB => self.accumulate(step, b, None),
            Format::ABC => self.accumulate(step, b, Some(c)),
            Format::ABConstant => self.accumulate(self.with_constant(step, insn, imm), b, None),
            Format::ABJump => self.accumulate(step, a, Some(b)),
            Format::AKJump => {
                self.accumulate(self.with_constant(step, insn, u32::from(b)), a, None)
            }
            _ => step,
        }
    }

    /// Takes the constant operand into the step.
    fn with_constant(&self, step: Step, insn: &Insn, index: u32) -> Step {
        let constant = self.constants[index as usize];
        let is_wanted = insn.op.operator().is_some_and(|op| op.operands()[1] == constant.type_of());
        if is_wanted { Step { k: constant.x, ..step } } else { Step { op: Op::Mistyped, ..step } }
    }

    /// Takes an operand that is there from the accumulator.
    fn accumulate(&self, step: Step, first: u8, second: Option<u8>) -> Step {
        let mut op = step.op;
        if second.is_some() && second == self.accumulated {
            op = op.with_second_accumulated().unwrap_or(op);
        }
        if Some(first) == self.accumulated {
            op = op.with_first_accumulated().unwrap_or(op);
        }
        Step { op, ..step }
    }

    /// The step of the first few instructions together. Those behind the first are carried out as
    /// their own steps say.
    fn fused(&self, code: &[Insn]) -> Option<Step> {
        let [insn, next, ..] = code else { return None };
        let first = self.single(insn);
        match (insn.op, next.op) {
            (Opcode::Load, _) if next.b == insn.a && next.c != insn.a => {
                let op = Op::of(next.op).with_first_loaded()?;
                let step = Step { op, k: self.real(insn.imm)?, ..first };
                Some(self.accumulate(step, insn.a, Some(next.c)))
            }
            (Opcode::Capture, _) if next.c == insn.a && next.b != insn.a => {
                let op = Op::of(next.op).with_second_captured()?;
                Some(self.accumulate(Step { op, ..first }, next.b, None))
            }
            (Opcode::Push | Opcode::Push2 | Opcode::Push3, Opcode::TailApply) => {
                self.again(first, &code[..1], next)
            }
            (Opcode::Push3, Opcode::Push) => {
                let push = Step { op: Op::Push4, imm: u32::from(next.a), ..first };
                let call = code.get(2).filter(|call| call.op == Opcode::TailApply);
                call.and_then(|call| self.again(push, &code[..2], call)).or(Some(push))
            }
            (Opcode::Pop, _) if pops_four(insn, next) => Some(Step { op: Op::Pop4, ..first }),
            (Opcode::Pop, _) if insn.b == 3 => Some(Step { op: Op::Pop3, ..first }),
            (Opcode::PushConstant, Opcode::PushConstant) => {
                let third = code.get(2).filter(|third| third.op == Opcode::PushConstant)?;
                let k = u64::from(next.imm) | u64::from(third.imm) << 32;
                Some(Step { op: Op::PushConstants, k, ..first })
            }
            (Opcode::AddIK | Opcode::SubIK, Opcode::Push | Opcode::Push2 | Opcode::Push3) => {
                let op = match first.op {
                    Op::AddIK => Op::AddAgain,
                    Op::SubIK => Op::SubAgain,
                    _ => return None,
                };
                let is_again = self.fused(&code[1..]).is_some_and(|step| step.op == Op::Again);
                is_again.then_some(Step { op, ..first })
            }
            _ if first.op == Op::Mistyped || self.single(next).op == Op::Mistyped => None,
            _ => {
                let op = self.sum(code).or_else(|| pair(insn, next))?;
                Some(Step { op, ..first })
            }
        }
    }

    /// Two products, the second not of the first, and their sum.
    fn sum(&self, code: &[Insn]) -> Option<Op> {
        let [one, other, sum, ..] = code else { return None };
        let op = match (one.op, other.op, sum.op) {
            (Opcode::MulF, Opcode::MulF, Opcode::AddF) => Op::SumOfProducts,
            (Opcode::MulFK, Opcode::MulFK, Opcode::AddF) => Op::SumOfMultiples,
            _ => return None,
        };
        let is_sum = (sum.b, sum.c) == (one.a, other.a) && one.a != other.a;
        if !is_sum {
            return None;
        }
        let is_test = code.get(3).is_some_and(|test| {
            let test_step = self.single(test);
            op == Op::SumOfProducts && test_step.op == Op::JumpUnlessLessFK && test.a == sum.a
        });
        Some(if is_test { Op::SumOfProductsTest } else { op })
    }

    /// A call behind pushes, which may be of the running closure.
    fn again(&self, push: Step, pushes: &[Insn], call: &Insn) -> Option<Step> {
        let pushed = pushes.iter().flat_map(|insn| {
            let fields = [insn.a, insn.b, insn.c].into_iter().zip(insn.reads());
            fields.filter(|field| field.1).map(|field| field.0)
        });
        let arguments: Vec<u8> = pushed.collect();
        if arguments.len() != self.entry.parameters.len() {
            return None;
        }
        let moves = arguments.iter().rev().copied().zip(self.entry.parameters.iter().copied());
        let moves = in_order(moves.filter(|(from, to)| from != to).collect())?;
        let fourth = arguments.get(3).copied().unwrap_or(0);
        let counts = arguments.len() | moves.len() << 4;
        let imm = [fourth, call.a, counts as u8, 0];
        let mut k = [0; 8];
        for (bytes, (from, to)) in k.chunks_exact_mut(2).zip(moves) {
            bytes.copy_from_slice(&[from, to]);
        }
        let (imm, k) = (u32::from_le_bytes(imm), u64::from_le_bytes(k));
        Some(Step { op: Op::Again, imm, k, ..push })
    }

    /// The payload of a constant that is a real.
    fn real(&self, index: u32) -> Option<u64> {
        let constant = self.constants[index as usize];
        (constant.tag == Tag::Real).then_some(constant.x)
    }

    /// Follows what the accumulator holds.
    fn update(&mut self, insn: &Insn) {
        let is_real = |op: Operator| op.results() == [Type::Real];
        if insn.op.operator().is_some_and(is_real) {
            self.accumulated = Some(insn.a);
        } else if insn.op == Opcode::Apply || self.accumulated.is_some_and(|r| insn.is_writing(r)) {
            self.accumulated = None;
        }
    }
}

/// Moves from registers to others in such an order that none overwrites what a later one reads; none
/// if there is no such order.
fn in_order(mut moves: Vec<(u8, u8)>) -> Option<Vec<(u8, u8)>> {
    let mut ordered = Vec::with_capacity(moves.len());
    while !moves.is_empty() {
        let is_last_use = |at: &usize| !moves.iter().any(|(from, _)| *from == moves[*at].1);
        let next = (0..moves.len()).find(is_last_use)?;
        ordered.push(moves.swap_remove(next));
    }
    Some(ordered)
}

/// Two operators with real results of which the second takes that of the first, once.
fn pair(first: &Insn, second: &Insn) -> Option<Op> {
    let is_constant = second.op.format() == Format::ABConstant;
    let is_result_first = second.b == first.a;
    if !is_constant && is_result_first == (second.c == first.a) {
        return None;
    }
    Op::pair(Op::of(first.op), Op::of(second.op), is_result_first)
}
