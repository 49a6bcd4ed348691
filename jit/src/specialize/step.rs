//! One instruction, on values that are partly known.

use std::rc::Rc;

use compiler::bytecode::{CaptureSource, Constant, Format, Insn, Opcode};
use compiler::op::{Operator, Type as GmlType};
use compiler::scalar;

use crate::sir::{Inst, Term, Type, Val};
use crate::specialize::{Frame, Run, STEP_VALUES, Specializer, State, Stop};
use crate::sym::{Captures, Elements, Num, Sym};

impl Specializer<'_> {
    /// Performs the next instruction; `None` if this way ends with it.
    pub(super) fn step(&mut self, mut state: State) -> Run<Option<State>> {
        let Insn { op, a, b, c, imm } = self.insn(state.top());
        state.top_mut().pc += 1;
        match op {
            Opcode::Load => {
                let constant = self.constant_at(&state, imm);
                state.set(a, constant);
            }
            Opcode::Capture => {
                let value = state.top().captures.get(imm as usize);
                state.set(a, value);
            }
            Opcode::Move => {
                let value = state.get(b);
                state.set(a, value);
            }
            Opcode::Spill => {
                let (value, slot) = (state.get(a), self.slot(&state, imm));
                state.top_mut().registers[slot] = value;
            }
            Opcode::Unspill => {
                let slot = self.slot(&state, imm);
                let value = state.top().registers[slot].clone();
                state.set(a, value);
            }
            Opcode::Push => state.push(&[a]),
            Opcode::Push2 => state.push(&[a, b]),
            Opcode::Push3 => state.push(&[a, b, c]),
            Opcode::PushConstant => {
                let constant = self.constant_at(&state, imm);
                state.stack.push(constant);
            }
            Opcode::Pop => {
                for offset in 0..b {
                    if state.stack.len() <= state.floor {
                        return self.underflow(&state);
                    }
                    let value = state.stack.pop().expect("above the floor");
                    state.set(a.wrapping_add(offset), value);
                }
            }
            Opcode::MakeClosure => {
                let closure = self.closure(&state, imm)?;
                state.set(a, closure);
            }
            Opcode::BeginArray => {
                state.floors.push(state.floor);
                state.floor = state.stack.len();
            }
            Opcode::EndArray => {
                let items = state.stack.split_off(state.floor);
                self.count_nested(&items)?;
                state.floor = state.floors.pop().unwrap_or(0);
                state.set(a, Sym::Array(Elements::Parts(items.into())));
            }
            Opcode::MakeArray => {
                let items = state.stack.split_off(state.stack.len() - imm as usize);
                self.count_nested(&items)?;
                state.set(a, Sym::Array(Elements::Parts(items.into())));
            }
            Opcode::Get => return self.get(state, a, b, c),
            Opcode::Length => return self.length(state, a, b),
            Opcode::Apply => return self.apply(state, a),
            Opcode::TailApply => return self.tail_apply(state, a),
            Opcode::Return => return self.return_(state),
            Opcode::Choose => return self.choose(state, [a, b, c], imm as u8),
            Opcode::Jump => state.top_mut().pc += imm as usize,
            Opcode::JumpUnless => {
                let condition = state.get(a);
                return match condition {
                    Sym::Bool(condition) => self.branch(state, condition, imm),
                    Sym::Choice(..) => self.settle(state, a, Some(imm)),
                    _ => self.leave(),
                };
            }
            Opcode::Unbound | Opcode::Operate => return self.leave(),
            _ => return self.scalar(state, Insn { op, a, b, c, imm }),
        }
        Ok(Some(state))
    }

    fn constant_at(&self, state: &State, index: u32) -> Sym {
        Sym::of_constant(self.constant_ref(state, index))
    }

    fn constant_ref(&self, state: &State, index: u32) -> &Constant {
        &self.function(state.top().function).constants[index as usize]
    }

    fn slot(&self, state: &State, slot: u32) -> usize {
        self.function(state.top().function).n_registers as usize + slot as usize
    }

    fn closure(&mut self, state: &State, function: u32) -> Run<Sym> {
        self.take_steps(self.function(function).captures.len() / STEP_VALUES)?;
        let frame = state.top();
        let captured = |source: &CaptureSource| match *source {
            CaptureSource::Register(register) => frame.registers[register as usize].clone(),
            CaptureSource::Slot(slot) => frame.registers[self.slot(state, slot)].clone(),
            CaptureSource::Capture(index) => frame.captures.get(index as usize),
        };
        let parts: Rc<[Sym]> = self.function(function).captures.iter().map(captured).collect();
        self.count_nested(&parts)?;
        Ok(Sym::Closure(function, Captures::Parts(parts)))
    }

    fn return_(&mut self, mut state: State) -> Run<Option<State>> {
        state.frames.pop();
        if !state.frames.is_empty() || self.work.is_routine {
            return Ok(Some(state));
        }
        self.return_results(&state.stack)
    }

    /// Returns from the shader, if the stack holds what it should.
    fn return_results(&mut self, stack: &[Sym]) -> Run<Option<State>> {
        if let [Sym::Point([r, g, b]), Sym::Real(kd), Sym::Real(ks), Sym::Real(n)] = stack {
            let vals = [r, g, b, kd, ks, n].map(|num| self.real(*num));
            self.end(self.work.block, Term::Return(vals.to_vec()));
            return Ok(None);
        }
        let is_choice = |sym: &Sym| matches!(sym, Sym::Choice(..));
        let Some(index) = stack.iter().position(is_choice).filter(|_| stack.len() == 4) else {
            return self.leave();
        };
        let Sym::Choice(tag, alternatives) = &stack[index] else { return self.leave() };
        let blocks: Vec<_> = alternatives.iter().map(|_| self.new_block()).collect();
        self.check_size()?;
        self.end(self.work.block, Term::Switch(*tag, blocks.clone()));
        for (block, alternative) in blocks.into_iter().zip(alternatives.iter()) {
            self.work.block = block;
            let mut settled = stack.to_vec();
            settled[index] = alternative.clone();
            self.return_results(&settled)?;
        }
        Ok(None)
    }

    // Calls.

    fn apply(&mut self, mut state: State, register: u8) -> Run<Option<State>> {
        match state.get(register) {
            Sym::Closure(function, captures) if self.recursive.contains(&function) => {
                self.call_routine(state, function, &captures)
            }
            Sym::Closure(function, captures) => {
                self.call(&mut state, function, captures)?;
                Ok(Some(state))
            }
            Sym::Choice(tag, alternatives) => {
                let stop = Stop { depth: state.frames.len(), pc: Some(state.top().pc) };
                self.each(state, register, tag, &alternatives, stop)
            }
            _ => self.leave(),
        }
    }

    fn tail_apply(&mut self, mut state: State, register: u8) -> Run<Option<State>> {
        let (function, captures) = match state.get(register) {
            Sym::Closure(function, captures) => (function, captures),
            Sym::Choice(tag, alternatives) => {
                let stop = Stop { depth: state.frames.len(), pc: None };
                return self.each(state, register, tag, &alternatives, stop);
            }
            _ => return self.leave(),
        };
        let entries = &state.top().entries;
        let running = entries.iter().rev().find(|entry| entry.function == function);
        if let Some(entry) = running.filter(|entry| entry.forks < state.forks).cloned() {
            return self.next_round(&state, &entry, &captures);
        }
        if self.recursive.contains(&function) {
            // As a call and a return.
            return match self.call_routine(state, function, &captures)? {
                Some(state) => self.return_(state),
                None => Ok(None),
            };
        }
        // An older entry of the function will not be looked for any more.
        let entries = entries.iter().filter(|entry| entry.function != function).cloned().collect();
        state.frames.pop();
        self.enter(&mut state, function, captures, entries)?;
        Ok(Some(state))
    }

    /// Repeats the instruction just begun for each alternative of the choice in a register.
    pub(super) fn each(
        &mut self,
        mut state: State,
        register: u8,
        tag: Val,
        alternatives: &[Sym],
        stop: Stop,
    ) -> Run<Option<State>> {
        state.top_mut().pc -= 1;
        self.with_each(state, register, tag, alternatives, stop)
    }

    /// Repeats the instruction just begun for each alternative of the choice in a register, up to
    /// where its ways meet if it jumps, and otherwise to the next instruction.
    fn settle(&mut self, state: State, register: u8, distance: Option<u32>) -> Run<Option<State>> {
        let Sym::Choice(tag, alternatives) = state.get(register) else { return self.leave() };
        let (depth, pc) = (state.frames.len(), state.top().pc);
        let stop = match distance {
            Some(distance) => self.meeting_point(state.top(), depth, pc + distance as usize),
            None => Stop { depth, pc: Some(pc) },
        };
        self.each(state, register, tag, &alternatives, stop)
    }

    /// Goes on with each alternative in a register, up to `stop`.
    pub(super) fn with_each(
        &mut self,
        state: State,
        register: u8,
        tag: Val,
        alternatives: &[Sym],
        stop: Stop,
    ) -> Run<Option<State>> {
        let blocks: Vec<_> = alternatives.iter().map(|_| self.new_block()).collect();
        self.end(self.work.block, Term::Switch(tag, blocks.clone()));
        let ways = blocks.into_iter().zip(alternatives).map(|(block, alternative)| {
            let mut way = state.clone();
            way.set(register, alternative.clone());
            (block, way)
        });
        self.fork(ways.collect(), stop)
    }

    // Conditions.

    fn branch(
        &mut self,
        mut state: State,
        condition: Num<bool>,
        distance: u32,
    ) -> Run<Option<State>> {
        self.decided(&Sym::Bool(condition));
        let target = state.top().pc + distance as usize;
        let condition = match condition {
            Num::Const(true) => return Ok(Some(state)),
            Num::Const(false) => {
                state.top_mut().pc = target;
                return Ok(Some(state));
            }
            Num::Ssa(val) => val,
        };
        let stop = self.meeting_point(state.top(), state.frames.len(), target);
        let (yes, no) = (self.new_block(), self.new_block());
        self.end(self.work.block, Term::Branch(condition, [yes, no]));
        let mut other = state.clone();
        other.top_mut().pc = target;
        self.fork(vec![(yes, state), (no, other)], stop)
    }

    fn choose(&mut self, mut state: State, [a, b, c]: [u8; 3], target: u8) -> Run<Option<State>> {
        let operands = [state.get(a), state.get(b), state.get(c)];
        let is_closure = |sym: &Sym| match sym {
            Sym::Choice(_, alternatives) => {
                alternatives.iter().all(|sym| sym.type_of() == Some(GmlType::Closure))
            }
            _ => sym.type_of() == Some(GmlType::Closure),
        };
        let [Sym::Bool(condition), yes, no] = &operands else {
            if matches!(operands[0], Sym::Choice(..)) {
                return self.settle(state, a, None);
            }
            return self.leave();
        };
        if !is_closure(yes) || !is_closure(no) {
            if [yes, no].iter().any(|sym| matches!(sym, Sym::Choice(..))) {
                return self.decline("a side of a condition may be of several types");
            }
            return self.leave();
        }
        self.decided(&operands[0]);
        let chosen = match condition {
            Num::Const(condition) => if *condition { yes } else { no }.clone(),
            _ if self.is_same(yes, no)? => yes.clone(),
            Num::Ssa(_) if [yes, no].iter().any(|sym| matches!(sym, Sym::Choice(..))) => {
                return self.decline("a condition chooses among choices");
            }
            Num::Ssa(condition) => {
                let tag = self.emit(Type::Int, Inst::IntOfBool(*condition));
                Sym::Choice(tag, Rc::new([no.clone(), yes.clone()]))
            }
        };
        state.set(target, chosen);
        Ok(Some(state))
    }

    // Scalar operators.

    fn scalar(&mut self, mut state: State, insn: Insn) -> Run<Option<State>> {
        let Some(op) = insn.op.operator() else { return self.decline("an instruction is unknown") };
        let (registers, constant) = operand_places(insn);
        let is_fused = matches!(insn.op.format(), Format::ABJump | Format::AKJump);
        if let Some(&register) =
            registers.iter().find(|register| matches!(state.get(**register), Sym::Choice(..)))
        {
            return self.settle(state, register, is_fused.then_some(insn.imm));
        }
        let mut operands: Vec<Sym> =
            registers.iter().map(|register| state.get(*register)).collect();
        operands.extend(constant.map(|index| self.constant_at(&state, index)));
        let Some(result) = self.operate(op, &operands) else { return self.leave() };
        match op {
            Operator::Floor => self.decided(&result),
            Operator::Frac => self.decided(&operands[0]),
            _ => {}
        }
        if is_fused {
            let Sym::Bool(condition) = result else { return self.leave() };
            return self.branch(state, condition, insn.imm);
        }
        let target = if op == Operator::Point { insn.imm as u8 } else { insn.a };
        state.set(target, result);
        Ok(Some(state))
    }

    /// Applies a scalar operator; `None` where the interpreter reports an error.
    fn operate(&mut self, op: Operator, operands: &[Sym]) -> Option<Sym> {
        let types = op.operands();
        if operands.iter().zip(types).any(|(sym, ty)| sym.type_of() != Some(*ty)) {
            return None;
        }
        let constants: Option<Vec<Constant>> = operands.iter().map(Sym::as_constant).collect();
        if let Some(constants) = constants {
            let result = scalar::evaluate(op, &constants)?.ok()?;
            return Some(Sym::of_constant(&result));
        }
        match (op, operands) {
            (Operator::GetX, [Sym::Point([x, ..])]) => return Some(Sym::Real(*x)),
            (Operator::GetY, [Sym::Point([_, y, _])]) => return Some(Sym::Real(*y)),
            (Operator::GetZ, [Sym::Point([.., z])]) => return Some(Sym::Real(*z)),
            (Operator::Point, [Sym::Real(x), Sym::Real(y), Sym::Real(z)]) => {
                return Some(Sym::Point([*x, *y, *z]));
            }
            _ => {}
        }
        let mut vals = operands.iter().map(|sym| self.val(sym));
        let first = vals.next()??;
        let second = vals.next().unwrap_or(Some(first))?;
        let ty = match op.results() {
            [GmlType::Real] => Type::Real,
            [GmlType::Int] => Type::Int,
            _ => Type::Bool,
        };
        let val = self.emit(ty, Inst::Scalar(op, [first, second]));
        Some(match ty {
            Type::Real => Sym::Real(Num::Ssa(val)),
            Type::Int => Sym::Int(Num::Ssa(val)),
            Type::Bool => Sym::Bool(Num::Ssa(val)),
        })
    }

    /// The value of a scalar.
    pub(super) fn val(&mut self, sym: &Sym) -> Option<Val> {
        match sym {
            Sym::Real(num) => Some(self.real(*num)),
            Sym::Int(num) => Some(self.int(*num)),
            Sym::Bool(num) => Some(self.bool(*num)),
            _ => None,
        }
    }
}

/// The registers that hold the operands of a scalar instruction, and the constant that is the last.
fn operand_places(insn: Insn) -> (Vec<u8>, Option<u32>) {
    let Insn { a, b, c, imm, .. } = insn;
    match insn.op.format() {
        Format::AB => (vec![b], None),
        Format::ABC => (vec![b, c], None),
        Format::ABConstant => (vec![b], Some(imm)),
        Format::ABJump => (vec![a, b], None),
        Format::AKJump => (vec![a], Some(u32::from(b))),
        _ => (vec![a, b, c], None),
    }
}

impl State {
    pub(super) fn top(&self) -> &Frame {
        self.frames.last().expect("a call is active")
    }

    pub(super) fn top_mut(&mut self) -> &mut Frame {
        Rc::make_mut(self.frames.last_mut().expect("a call is active"))
    }

    pub(super) fn get(&self, register: u8) -> Sym {
        self.top().registers[register as usize].clone()
    }

    pub(super) fn set(&mut self, register: u8, value: Sym) {
        self.top_mut().registers[register as usize] = value;
    }

    fn push(&mut self, registers: &[u8]) {
        for &register in registers {
            let value = self.get(register);
            self.stack.push(value);
        }
    }
}
