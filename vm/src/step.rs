//! Steps: the form in which the interpreter runs bytecode.
//!
//! A function has as many steps as instructions, one at each position, so that jumps, origins and
//! fuel are those of the bytecode. Most steps are the instruction itself. The others find an operand
//! where it is faster to reach than in a register: constants stand in the step, and what the last
//! operator with a real result has left is still in the accumulator, a register of the CPU. A fused
//! step does what a few instructions in a row do and goes on behind them; those have their own steps
//! too, where jumps may land.

use compiler::bytecode::{Format, Insn, Opcode};
use compiler::op::{Operator, Type};
use compiler::{for_each_control, for_each_scalar};

use crate::word::{Tag, Word};

/// Calls `$then!` with the scalar operators that have further steps, and those, behind any tokens
/// given in `[ ]`. Letters say where operands are: `R` in a register, `A` in the accumulator, `K` in
/// the step. Fused are `Load` and an operator whose first operand it loads (`K` first), `Capture` and
/// an operator whose second operand it fetches (`C`), and `MulFK` and an operator whose second
/// operand it computes (`M`).
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
                AddF AddFK add_f AddRA AddAR AddAA AddAK AddKR AddKA AddRC AddAC AddRM;
                SubF SubFK sub_f SubRA SubAR SubAA SubAK SubKR SubKA SubRC SubAC SubRM;
                MulF MulFK mul_f MulRA MulAR MulAA MulAK MulKR MulKA MulRC MulAC MulRM;
                DivF DivFK div_f DivRA DivAR DivAA DivAK DivKR DivKA DivRC DivAC DivRM;
            }
            jump {
                JumpUnlessLessF JumpUnlessLessFK less_f JumpUnlessLessRA JumpUnlessLessAR JumpUnlessLessAK;
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
      binary { $($xb:ident $xbk:ident $xbf:ident $ra:ident $ar:ident $aa:ident $ak:ident $kr:ident $ka:ident $rc:ident $ac:ident $rm:ident;)* }
      jump { $($xj:ident $xjk:ident $xjf:ident $jra:ident $jar:ident $jak:ident;)* }) => {
        /// What a step does.
        #[derive(Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub(crate) enum Op {
            $($k,)* $($u,)* $($b, $bk,)* $($c, $ck, $cj, $cjk,)* $($t,)*
            $($xua,)* $($ra, $ar, $aa, $ak, $kr, $ka, $rc, $ac, $rm,)* $($jra, $jar, $jak,)*
            /// `Push3` and `Push`: the fourth register is in `imm`.
            Push4,
            /// `Pop` of three values.
            Pop3,
            /// `Pop` of three values and of a fourth.
            Pop4,
            /// `Push2` and `TailApply` where the function begins with a `Pop` of as many values. Of
            /// `k`, the first byte is the register of the closure, the second the first one popped to.
            Again2,
            /// The same with `Push3`.
            Again3,
            /// The same with `Push4` and `Pop4`.
            Again4,
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

            /// Fused with the `MulFK` of the second operand.
            fn with_second_multiplied(self) -> Option<Op> {
                Some(match self { $(Op::$xb => Op::$rm,)* _ => return None })
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

/// The steps of a function with these constants.
pub(crate) fn translate(code: &[Insn], constants: &[Word]) -> Vec<Step> {
    let mut translation = Translation { constants, entry: entry(code), accumulated: None };
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
    steps
}

fn jump_targets(code: &[Insn]) -> Vec<bool> {
    let mut is_target = vec![false; code.len()];
    for (pc, insn) in code.iter().enumerate() {
        if let Format::Jump | Format::AJump | Format::ABJump | Format::AKJump = insn.op.format() {
            is_target[pc + 1 + insn.imm as usize] = true;
        }
    }
    is_target
}

/// Where the first step pops to, and how many values.
fn entry(code: &[Insn]) -> (u8, u8) {
    match code {
        [first, second, ..] if pops_four(first, second) => (first.a, 4),
        [Insn { op: Opcode::Pop, a, b, .. }, ..] => (*a, *b),
        _ => (0, 0),
    }
}

fn pops_four(first: &Insn, second: &Insn) -> bool {
    (first.op, first.b, second.op, second.b) == (Opcode::Pop, 3, Opcode::Pop, 1)
        && second.a == first.a.wrapping_add(3)
}

struct Translation<'f> {
    constants: &'f [Word],
    entry: (u8, u8),
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

    /// The step of the first few instructions together.
    fn fused(&self, code: &[Insn]) -> Option<Step> {
        let [insn, next, ..] = code else { return None };
        let Insn { op, a, b, c, imm } = *insn;
        match (op, next.op) {
            (Opcode::Load, _) if next.b == a && next.c != a => {
                let op = Op::of(next.op).with_first_loaded()?;
                let step = Step { op, a: next.a, b: a, c: next.c, imm: 0, k: self.real(imm)? };
                Some(self.accumulate(step, a, Some(next.c)))
            }
            (Opcode::Capture, _) if next.c == a && next.b != a => {
                let op = Op::of(next.op).with_second_captured()?;
                let step = Step { op, a: next.a, b: next.b, c: a, imm, k: 0 };
                Some(self.accumulate(step, next.b, None))
            }
            (Opcode::MulFK, _) if next.c == a && next.b != a => {
                let op = Op::of(next.op).with_second_multiplied()?;
                Some(Step { op, a, b, c: next.b, imm: u32::from(next.a), k: self.real(imm)? })
            }
            (Opcode::Push2, Opcode::TailApply) => {
                Some(Step { op: Op::Again2, a, b, c, imm, k: self.again(2, next)? })
            }
            (Opcode::Push3, Opcode::TailApply) => {
                Some(Step { op: Op::Again3, a, b, c, imm, k: self.again(3, next)? })
            }
            (Opcode::Push3, Opcode::Push) => {
                let imm = u32::from(next.a);
                match code.get(2).and_then(|call| self.again(4, call)) {
                    Some(k) => Some(Step { op: Op::Again4, a, b, c, imm, k }),
                    None => Some(Step { op: Op::Push4, a, b, c, imm, k: 0 }),
                }
            }
            (Opcode::Pop, _) if pops_four(insn, next) => {
                Some(Step { op: Op::Pop4, a, b, c, imm, k: 0 })
            }
            (Opcode::Pop, _) if b == 3 => Some(Step { op: Op::Pop3, a, b, c, imm, k: 0 }),
            (Opcode::PushConstant, Opcode::PushConstant) => {
                let third = code.get(2).filter(|third| third.op == Opcode::PushConstant)?;
                let k = u64::from(next.imm) | u64::from(third.imm) << 32;
                Some(Step { op: Op::PushConstants, a, b, c, imm, k })
            }
            _ => None,
        }
    }

    /// The field `k` of a call with so many arguments, which may be of the running closure.
    fn again(&self, n_arguments: u8, call: &Insn) -> Option<u64> {
        let (first, n_popped) = self.entry;
        let is_wanted = call.op == Opcode::TailApply && n_popped == n_arguments;
        is_wanted.then_some(u64::from(first) << 8 | u64::from(call.a))
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
        } else if insn.op == Opcode::Apply || self.accumulated.is_some_and(|r| writes(insn, r)) {
            self.accumulated = None;
        }
    }
}

/// Whether an instruction without a real result may change a register.
fn writes(insn: &Insn, register: u8) -> bool {
    match insn.op.format() {
        Format::Range => register.wrapping_sub(insn.a) < insn.b,
        Format::ABCRegister => u32::from(register) == insn.imm,
        Format::None | Format::Constant | Format::Jump | Format::AJump => false,
        Format::ABJump | Format::AKJump => false,
        _ => register == insn.a,
    }
}
