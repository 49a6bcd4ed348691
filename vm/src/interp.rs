//! The dispatch loop.
//!
//! Arms for scalar operators derive from the operator table and only fetch operands and store
//! results; what they compute stands in `compiler::scalar`. A frame is a window of 256 registers,
//! so that a register number needs no bounds check.

use std::sync::Arc;

use compiler::bytecode::{CaptureSource, Opcode};
use compiler::op::Operator;
use compiler::scalar;
use compiler::{for_each_scalar, scalar_operand, scalar_result};

use crate::display;
use crate::error::Problem;
use crate::host::Host;
use crate::machine::{Frame, Machine, WINDOW};
use crate::memory;
use crate::ops;
use crate::value::{Array, Closure, Value};

fn window(registers: &mut [Value], base: usize) -> &mut [Value; WINDOW] {
    registers[base..].first_chunk_mut().expect("entering a function makes room for a window")
}

/// The match on the opcode: the given arms, and one for each form of each scalar operator.
macro_rules! dispatch {
    ([$insn:ident $frame:ident $constants:ident $pc:ident $trap:ident { $($control:tt)* }]
      unary { $($(#[$ud:meta])+ $u:ident $us:literal $uf:ident($ut:ident) -> $ur:ident;)* }
      binary { $($(#[$bd:meta])+ $b:ident $bk:ident $bs:literal $bf:ident($bt:ident, $bt2:ident) -> $br:ident;)* }
      compare { $($(#[$cd:meta])+ $c:ident $ck:ident $cj:ident $cjk:ident $cs:literal $cf:ident($ct:ident, $ct2:ident) -> $cr:ident;)* }
      ternary { $($(#[$td:meta])+ $t:ident $ts:literal $tf:ident($tt:ident, $tt2:ident, $tt3:ident) -> $tr:ident;)* }) => {
        match $insn.op {
            $($control)*
            $(Opcode::$u => {
                let operand = &$frame[$insn.b as usize];
                let Some(x) = scalar_operand!($ut, operand) else {
                    $trap!(mismatch(Operator::$u, &[operand]))
                };
                match scalar::$uf(x) {
                    Ok(result) => $frame[$insn.a as usize].set(scalar_result!($ur, result)),
                    Err(fault) => $trap!(faulted(Operator::$u, fault, &[operand])),
                }
            })*
            $(Opcode::$b => binary!($insn $frame $trap $b $bf($bt $bt2) $br, &$frame[$insn.c as usize]),
              Opcode::$bk => binary!($insn $frame $trap $b $bf($bt $bt2) $br, &$constants[$insn.imm as usize]),)*
            $(Opcode::$c => binary!($insn $frame $trap $c $cf($ct $ct2) $cr, &$frame[$insn.c as usize]),
              Opcode::$ck => binary!($insn $frame $trap $c $cf($ct $ct2) $cr, &$constants[$insn.imm as usize]),
              Opcode::$cj => compare!($insn $frame $pc $trap $c $cf($ct $ct2), &$frame[$insn.b as usize]),
              Opcode::$cjk => compare!($insn $frame $pc $trap $c $cf($ct $ct2), &$constants[$insn.b as usize]),)*
            $(Opcode::$t => {
                let operands = [&$frame[$insn.a as usize], &$frame[$insn.b as usize], &$frame[$insn.c as usize]];
                let (Some(x), Some(y), Some(z)) = (
                    scalar_operand!($tt, operands[0]),
                    scalar_operand!($tt2, operands[1]),
                    scalar_operand!($tt3, operands[2]),
                ) else {
                    $trap!(mismatch(Operator::$t, &operands))
                };
                match scalar::$tf(x, y, z) {
                    Ok(result) => $frame[$insn.imm as u8 as usize].set(scalar_result!($tr, result)),
                    Err(fault) => $trap!(faulted(Operator::$t, fault, &operands)),
                }
            })*
        }
    };
}

macro_rules! binary {
    ($insn:ident $frame:ident $trap:ident $op:ident $function:ident($x:ident $y:ident) $result:ident, $second:expr) => {{
        let (first, second) = (&$frame[$insn.b as usize], $second);
        let (Some(x), Some(y)) = (scalar_operand!($x, first), scalar_operand!($y, second)) else {
            $trap!(mismatch(Operator::$op, &[first, second]))
        };
        match scalar::$function(x, y) {
            Ok(result) => $frame[$insn.a as usize].set(scalar_result!($result, result)),
            Err(fault) => $trap!(faulted(Operator::$op, fault, &[first, second])),
        }
    }};
}

macro_rules! compare {
    ($insn:ident $frame:ident $pc:ident $trap:ident $op:ident $function:ident($x:ident $y:ident), $second:expr) => {{
        let (first, second) = (&$frame[$insn.a as usize], $second);
        let (Some(x), Some(y)) = (scalar_operand!($x, first), scalar_operand!($y, second)) else {
            $trap!(mismatch(Operator::$op, &[first, second]))
        };
        match scalar::$function(x, y) {
            Ok(true) => {}
            Ok(false) => $pc += $insn.imm as usize,
            Err(fault) => $trap!(faulted(Operator::$op, fault, &[first, second])),
        }
    }};
}

#[cold]
#[inline(never)]
fn mismatch(op: Operator, operands: &[&Value]) -> Problem {
    Problem::Mismatch(op, operands.iter().map(|operand| operand.type_of()).collect())
}

#[cold]
#[inline(never)]
fn faulted(op: Operator, fault: scalar::Fault, operands: &[&Value]) -> Problem {
    Problem::Fault(op, fault, operands.iter().map(|operand| display::to_text(operand)).collect())
}

impl Machine<'_> {
    /// Runs a closure until it returns. When something goes wrong, `frames` and `stopped_at` tell
    /// where.
    pub(crate) fn execute(
        &mut self,
        entry: Arc<Closure>,
        mut host: Option<&mut dyn Host>,
    ) -> Result<(), Box<Problem>> {
        let program = self.program;
        let functions = &program.bytecode.functions[..];
        let bottom = self.frames.len();
        let mut closure = entry;
        let mut function = &functions[closure.function as usize];
        let mut constants = &program.constants[closure.function as usize][..];
        let mut base = 0;
        let mut pc = 0;
        self.stopped_at = (closure.function, 0);
        self.enter(closure.function, base)?;
        let mut frame = window(&mut self.registers, base);

        macro_rules! trap {
            ($problem:expr) => {{
                let problem = Box::new($problem);
                self.stopped_at = (closure.function, pc - 1);
                return Err(problem);
            }};
        }
        macro_rules! check {
            ($result:expr) => {
                match $result {
                    Ok(value) => value,
                    Err(problem) => {
                        self.stopped_at = (closure.function, pc - 1);
                        return Err(problem);
                    }
                }
            };
        }
        // Continues in `closure` at `pc`, with the frame at `base`.
        macro_rules! resume {
            () => {
                function = &functions[closure.function as usize];
                constants = &program.constants[closure.function as usize];
                frame = window(&mut self.registers, base);
            };
        }

        loop {
            let insn = function.code[pc];
            pc += 1;
            for_each_scalar!(dispatch, [insn frame constants pc trap {
                Opcode::Load => frame[insn.a as usize].set_copy(&constants[insn.imm as usize]),
                Opcode::Capture => frame[insn.a as usize].set_copy(&closure.captures()[insn.imm as usize]),
                Opcode::Move => {
                    let value = frame[insn.b as usize].clone();
                    frame[insn.a as usize] = value;
                }
                Opcode::Spill => {
                    let value = frame[insn.a as usize].clone();
                    self.registers[base + function.n_registers as usize + insn.imm as usize] = value;
                    frame = window(&mut self.registers, base);
                }
                Opcode::Unspill => {
                    let slot = base + function.n_registers as usize + insn.imm as usize;
                    let value = self.registers[slot].clone();
                    frame = window(&mut self.registers, base);
                    frame[insn.a as usize] = value;
                }
                Opcode::Push => self.stack.push_copy(&frame[insn.a as usize]),
                Opcode::Push2 => {
                    self.stack.push_copy(&frame[insn.a as usize]);
                    self.stack.push_copy(&frame[insn.b as usize]);
                }
                Opcode::Push3 => {
                    self.stack.push_copy(&frame[insn.a as usize]);
                    self.stack.push_copy(&frame[insn.b as usize]);
                    self.stack.push_copy(&frame[insn.c as usize]);
                }
                Opcode::PushConstant => self.stack.push_copy(&constants[insn.imm as usize]),
                Opcode::Pop => {
                    for offset in 0..insn.b {
                        if self.stack.len() <= self.floor {
                            let wanted_by = Operator::ALL.get((insn.c as usize).wrapping_sub(1));
                            trap!(Problem::Underflow(wanted_by.copied()))
                        }
                        self.stack.pop_to(&mut frame[insn.a.wrapping_add(offset) as usize]);
                    }
                }
                Opcode::MakeClosure => {
                    let sources = &functions[insn.imm as usize].captures;
                    self.allocated += memory::bytes_for(sources.len());
                    let mut captures = Vec::with_capacity(sources.len());
                    for source in sources {
                        captures.push(match *source {
                            CaptureSource::Register(register) => frame[register as usize].clone(),
                            CaptureSource::Capture(index) => closure.captures()[index as usize].clone(),
                            CaptureSource::Slot(slot) => {
                                let value = self.registers[base + function.n_registers as usize + slot as usize].clone();
                                frame = window(&mut self.registers, base);
                                value
                            }
                        });
                    }
                    frame[insn.a as usize] = Value::Closure(Arc::new(Closure::new(insn.imm, captures)));
                }
                Opcode::BeginArray => {
                    self.floors.push(self.floor);
                    self.floor = self.stack.len();
                }
                Opcode::EndArray => {
                    let items = self.stack.split_off(self.floor);
                    self.floor = self.floors.pop().unwrap_or(0);
                    self.allocated += memory::bytes_for(items.len());
                    frame[insn.a as usize] = Value::Array(Arc::new(Array::new(items)));
                    if self.allocated > self.limits.max_memory {
                        check!(self.recount());
                        frame = window(&mut self.registers, base);
                    }
                }
                Opcode::MakeArray => {
                    let items = self.stack.split_off(self.stack.len() - insn.imm as usize);
                    self.allocated += memory::bytes_for(items.len());
                    frame[insn.a as usize] = Value::Array(Arc::new(Array::new(items)));
                }
                Opcode::Get => {
                    let operands = [&frame[insn.b as usize], &frame[insn.c as usize]];
                    let [Value::Array(array), Value::Int(index)] = operands else {
                        trap!(mismatch(Operator::Get, &operands))
                    };
                    let item = usize::try_from(*index).ok().and_then(|index| array.items().get(index));
                    let Some(item) = item.cloned() else {
                        trap!(Problem::Subscript(*index, array.items().len()))
                    };
                    frame[insn.a as usize] = item;
                }
                Opcode::Length => {
                    let Value::Array(array) = &frame[insn.b as usize] else {
                        trap!(mismatch(Operator::Length, &[&frame[insn.b as usize]]))
                    };
                    frame[insn.a as usize] = Value::Int(array.items().len() as i64);
                }
                Opcode::Apply => {
                    let Value::Closure(callee) = &frame[insn.a as usize] else {
                        trap!(mismatch(Operator::Apply, &[&frame[insn.a as usize]]))
                    };
                    let callee = callee.clone();
                    if self.frames.len() - bottom >= self.limits.max_depth {
                        trap!(Problem::DepthLimit(self.limits.max_depth))
                    }
                    let n_used = (function.n_registers + function.n_slots) as usize;
                    check!(self.enter(callee.function, base + n_used));
                    let caller = std::mem::replace(&mut closure, callee);
                    self.frames.push(Frame { closure: caller, pc, base });
                    base += n_used;
                    pc = 0;
                    resume!();
                }
                Opcode::TailApply => {
                    let Value::Closure(callee) = &frame[insn.a as usize] else {
                        trap!(mismatch(Operator::Apply, &[&frame[insn.a as usize]]))
                    };
                    let callee = callee.clone();
                    check!(self.enter(callee.function, base));
                    closure = callee;
                    pc = 0;
                    resume!();
                }
                Opcode::Return => {
                    if self.frames.len() == bottom {
                        self.stopped_at = (closure.function, pc - 1);
                        return Ok(());
                    }
                    let Some(caller) = self.frames.pop() else { return Ok(()) };
                    closure = caller.closure;
                    pc = caller.pc;
                    base = caller.base;
                    resume!();
                }
                Opcode::Choose => {
                    let operands = [&frame[insn.a as usize], &frame[insn.b as usize], &frame[insn.c as usize]];
                    let [Value::Bool(condition), Value::Closure(yes), Value::Closure(no)] = operands else {
                        trap!(mismatch(Operator::If, &operands))
                    };
                    let chosen = if *condition { yes } else { no };
                    frame[insn.imm as u8 as usize] = Value::Closure(chosen.clone());
                }
                Opcode::Jump => pc += insn.imm as usize,
                Opcode::JumpUnless => match &frame[insn.a as usize] {
                    Value::Bool(true) => {}
                    Value::Bool(false) => pc += insn.imm as usize,
                    other => trap!(Problem::Mismatch(
                        Operator::If,
                        vec![other.type_of(), compiler::op::Type::Closure, compiler::op::Type::Closure],
                    )),
                },
                Opcode::Unbound => {
                    let Value::Str(name) = &constants[insn.imm as usize] else { trap!(Problem::Unbound(Arc::from(""))) };
                    trap!(Problem::Unbound(name.clone()))
                }
                Opcode::Operate => {
                    let op = Operator::ALL[insn.b as usize];
                    let origin = function.origins[pc - 1];
                    let result = check!(ops::operate(op, self, origin, &mut host));
                    frame = window(&mut self.registers, base);
                    if let Some(value) = result {
                        frame[insn.a as usize] = value;
                    }
                }
            }])
        }
    }

    /// Pays for a call and makes room for its frame.
    #[inline]
    fn enter(&mut self, callee: u32, base: usize) -> Result<(), Box<Problem>> {
        let function = &self.program.bytecode.functions[callee as usize];
        let cost = function.code.len() as u64;
        if self.fuel < cost {
            return Err(Box::new(Problem::FuelLimit(self.limits.fuel)));
        }
        self.fuel -= cost;
        let needed = base + WINDOW + function.n_slots as usize;
        if self.registers.len() < needed {
            self.registers.resize(needed.next_multiple_of(WINDOW * 4), Value::Bool(false));
        }
        let in_vectors = ((self.stack.len() + self.registers.len()) * size_of::<Value>()) as u64;
        if self.allocated + in_vectors > self.limits.max_memory {
            self.recount()?;
        }
        Ok(())
    }
}
