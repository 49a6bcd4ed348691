//! `if`: conditional jumps, and the joining of what both sides leave behind.

use crate::ast::Term;
use crate::bytecode::{Constant, Insn, Opcode, Origin};
use crate::emit::function::{Code, Entry, FunctionBuilder, Operand, Region};
use crate::emit::registers::Registers;
use crate::emit::{Emitter, Flow};
use crate::op::Operator;
use crate::source::Span;

/// If more operands wait, they go to the operand stack before the sides part: each side has a list of its
/// own, and one that ends the function pushes all of it. A condition costs at least five words, so that it is
/// some six instructions for each.
const MAX_PENDING: usize = 32;

/// One side of an `if`, compiled, and the state it leaves.
struct Arm {
    code: Code,
    entries: Vec<Entry>,
    registers: Registers,
    region: Region,
}

impl Emitter {
    /// `b { yes } { no } if`
    pub(super) fn literal_if(&mut self, yes: &[Term], no: &[Term], span: Span, tail: bool) -> Flow {
        let condition = self.here().pop(Some(Operator::If), span);
        if let Operand::Constant(Constant::Bool(value)) = condition.operand {
            return self.inline(if value { yes } else { no }, tail);
        }
        let here = self.here();
        if here.entries.len() > MAX_PENDING {
            here.flush();
        }
        let jump = jump_unless(here, &condition, span);
        let before = (here.entries.clone(), here.registers.clone(), here.region.clone());
        let outer_code = std::mem::take(&mut here.code);
        let first = self.arm(yes, tail);
        let here = self.here();
        (here.entries, here.registers, here.region) = before;
        let second = self.arm(no, tail);
        let here = self.here();
        here.code = outer_code;
        join(here, jump, first, second, tail, span)
    }

    fn arm(&mut self, body: &[Term], tail: bool) -> Arm {
        let flow = self.inline(body, tail);
        let here = self.here();
        if tail && flow == Flow::Continues {
            let span = body.last().map_or(Span::NONE, |last| last.span);
            here.emit_return(span);
        }
        Arm {
            code: std::mem::take(&mut here.code),
            entries: std::mem::take(&mut here.entries),
            registers: here.registers.clone(),
            region: here.region.clone(),
        }
    }

    /// `if` on closures that are not both written here.
    pub(super) fn closure_if(&mut self, span: Span, tail: bool) -> Flow {
        let here = self.here();
        let no = here.pop(Some(Operator::If), span);
        let yes = here.pop(Some(Operator::If), span);
        let condition = here.pop(Some(Operator::If), span);
        let entries = [condition, yes, no];
        let registers = [0, 1, 2].map(|i| here.in_register(&entries[i]));
        for register in registers {
            here.registers.release(register);
        }
        let chosen = here.allocate();
        let origin = Origin { span, operands: entries.map(|entry| entry.span) };
        here.emit(Opcode::Choose, registers, u32::from(chosen), origin);
        here.registers.release(chosen);
        self.call(chosen, Origin { span, ..Origin::default() }, tail)
    }
}

/// Emits the jump to the second side, its distance open, and gives up the condition. A comparison
/// just made becomes one with the jump.
fn jump_unless(here: &mut FunctionBuilder, condition: &Entry, span: Span) -> usize {
    if let Operand::Register(register) = condition.operand
        && here.registers.is_temporary(register)
        && let Some((insn, _)) = here.code.last_mut()
        && insn.a == register
        && let Some(fused) = insn.op.fused_with_jump()
    {
        let with_constant =
            Opcode::on_registers(insn.op.operator().expect("a comparison")) != Some(insn.op);
        // The field for a constant in a fused jump has eight bits.
        let second = if with_constant { u8::try_from(insn.imm).ok() } else { Some(insn.c) };
        if let Some(second) = second {
            *insn = Insn { op: fused, a: insn.b, b: second, c: 0, imm: 0 };
            here.registers.release(register);
            return here.code.insns.len() - 1;
        }
    }
    let register = here.in_register(condition);
    here.registers.release(register);
    let origin = Origin { span, operands: [condition.span, Span::NONE, Span::NONE] };
    here.emit(Opcode::JumpUnless, [register, 0, 0], 0, origin);
    here.code.insns.len() - 1
}

/// Lays out both sides behind the jump; unless they end the function, makes their pending operands
/// agree.
fn join(
    here: &mut FunctionBuilder,
    jump: usize,
    mut first: Arm,
    mut second: Arm,
    ended: bool,
    span: Span,
) -> Flow {
    if !ended {
        unify(here, &mut first, &mut second);
        let distance = second.code.insns.len() as u32;
        first.code.push(
            Insn { op: Opcode::Jump, a: 0, b: 0, c: 0, imm: distance },
            Origin { span, ..Origin::default() },
        );
    }
    here.code.insns[jump].imm = first.code.insns.len() as u32;
    here.code.append(first.code);
    here.code.append(second.code);
    (here.entries, here.registers, here.region) = (second.entries, second.registers, second.region);
    if ended { Flow::Ended } else { Flow::Continues }
}

/// Brings the topmost operands of both sides to the same places and all others to the operand
/// stack. Afterwards both have the same entries.
fn unify(here: &mut FunctionBuilder, first: &mut Arm, second: &mut Arm) {
    let mut n_kept = first.entries.len().min(second.entries.len());
    let free = (0..=u8::MAX).filter(|&r| first.registers.is_free(r) && second.registers.is_free(r));
    // One more is left for what the others are loaded into on their way to the operand stack.
    if free.count() <= n_kept {
        n_kept = 0;
    }
    let split = |arm: &mut Arm| arm.entries.split_off(arm.entries.len() - n_kept);
    let (top_first, top_second) = (split(first), split(second));
    let joined: Vec<Entry> = top_first
        .iter()
        .zip(&top_second)
        .map(|(a, b)| Entry { operand: meeting_place(first, second, a, b), span: a.span })
        .collect();
    settle(here, first, &top_first, &joined);
    settle(here, second, &top_second, &joined);
    second.region.needs_floor |= first.region.needs_floor;
    if first.region.height != second.region.height {
        second.region.forget();
    }
}

/// Where a value can be that is at `a` on one side and at `b` on the other. A register that only
/// one side occupies so far is reserved on the other.
fn meeting_place(first: &mut Arm, second: &mut Arm, a: &Entry, b: &Entry) -> Operand {
    if a.operand.is_same(&b.operand) {
        return a.operand.clone();
    }
    if let Operand::Register(register) = a.operand
        && first.registers.is_temporary(register)
        && second.registers.is_free(register)
    {
        second.registers.retain(register);
        return a.operand.clone();
    }
    if let Operand::Register(register) = b.operand
        && second.registers.is_temporary(register)
        && first.registers.is_free(register)
    {
        first.registers.retain(register);
        return b.operand.clone();
    }
    let register = (0..=u8::MAX)
        .find(|&r| first.registers.is_free(r) && second.registers.is_free(r))
        .expect("counted before");
    first.registers.retain(register);
    second.registers.retain(register);
    Operand::Register(register)
}

/// Emits, at the end of one side, the pushes of its lower entries and the copies of `top` to where
/// `joined` has them. No copy overwrites the source of another: a target is either that value's
/// own place or was free.
fn settle(here: &mut FunctionBuilder, arm: &mut Arm, top: &[Entry], joined: &[Entry]) {
    std::mem::swap(&mut here.code, &mut arm.code);
    std::mem::swap(&mut here.registers, &mut arm.registers);
    std::mem::swap(&mut here.region, &mut arm.region);
    for entry in arm.entries.drain(..) {
        here.push_to_stack(&entry);
    }
    for (from, to) in top.iter().zip(joined) {
        if let Operand::Register(register) = to.operand
            && !from.operand.is_same(&to.operand)
        {
            here.use_register(register);
            here.load(register, from);
            here.release(from);
        }
    }
    std::mem::swap(&mut here.code, &mut arm.code);
    std::mem::swap(&mut here.registers, &mut arm.registers);
    std::mem::swap(&mut here.region, &mut arm.region);
    arm.entries.extend_from_slice(joined);
}
