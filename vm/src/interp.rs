//! The dispatch loop.
//!
//! Arms for scalar operators derive from the operator table and only fetch operands and store
//! results; what they compute stands in `compiler::scalar`. A frame is a window of 256 registers,
//! so that a register number needs no bounds check.

use compiler::bytecode::{CaptureSource, Function, Opcode};
use compiler::op::{Operator, Type};
use compiler::scalar::{self, Operands};
use compiler::{for_each_scalar, scalar_operand, scalar_result};

use crate::display;
use crate::error::Problem;
use crate::host::Host;
use crate::machine::{Frame, Machine, WINDOW};
use crate::ops;
use crate::value::Value;
use crate::word::{Tag, Word};

fn window(registers: &mut [Word], base: usize) -> &mut [Word; WINDOW] {
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
fn mismatch(op: Operator, operands: &[&Word]) -> Problem {
    Problem::Mismatch(op, operands.iter().map(|operand| operand.type_of()).collect())
}

#[cold]
#[inline(never)]
fn faulted(op: Operator, fault: scalar::Fault, operands: &[&Word]) -> Problem {
    let scalars = operands.iter().filter_map(|operand| operand.to_scalar());
    Problem::Fault(op, fault, scalars.map(|scalar| display::to_text(&scalar)).collect())
}

impl Machine<'_> {
    /// Runs `self.closure` until it returns. When something goes wrong, it is the closure that was
    /// running then, and `frames` and `stopped_at` tell the rest.
    pub(crate) fn execute(&mut self, mut host: Option<&mut dyn Host>) -> Result<(), Box<Problem>> {
        let program = self.program;
        let functions = &program.bytecode.functions[..];
        let mut base = 0;
        let mut pc = 0;
        self.stopped_at = 0;
        self.make_room(0)?;
        let mut index = self.heap.function(self.closure) as usize;
        self.enter(index, base)?;
        let mut function = &functions[index];
        let mut code = &function.code[..];
        let mut constants = &program.constants[index][..];
        let mut frame = window(&mut self.registers, base);

        macro_rules! trap {
            ($problem:expr) => {{
                let problem = Box::new($problem);
                self.stopped_at = pc - 1;
                return Err(problem);
            }};
        }
        macro_rules! check {
            ($result:expr) => {
                match $result {
                    Ok(value) => value,
                    Err(problem) => {
                        self.stopped_at = pc - 1;
                        return Err(problem);
                    }
                }
            };
        }
        // Continues in function `index` at `pc`, with the frame at `base`.
        macro_rules! resume {
            () => {
                function = &functions[index];
                code = &function.code;
                constants = &program.constants[index];
                frame = window(&mut self.registers, base);
            };
        }
        // The closure in a register, after room has been made for its call.
        macro_rules! callee {
            ($register:expr) => {{
                let register = $register as usize;
                if frame[register].tag != Tag::Closure {
                    trap!(mismatch(Operator::Apply, &[&frame[register]]))
                }
                check!(self.make_room(base + n_used(function)));
                self.registers[base + register].address()
            }};
        }

        loop {
            let insn = code[pc];
            pc += 1;
            for_each_scalar!(dispatch, [insn frame constants pc trap {
                Opcode::Load => frame[insn.a as usize].set(constants[insn.imm as usize]),
                Opcode::Capture => {
                    frame[insn.a as usize].set(self.heap.capture(self.closure, insn.imm));
                }
                Opcode::Move => {
                    let word = frame[insn.b as usize];
                    frame[insn.a as usize].set(word);
                }
                Opcode::Spill => {
                    let word = frame[insn.a as usize];
                    self.registers[slot(function, base, insn.imm)] = word;
                    frame = window(&mut self.registers, base);
                }
                Opcode::Unspill => {
                    let word = self.registers[slot(function, base, insn.imm)];
                    frame = window(&mut self.registers, base);
                    frame[insn.a as usize] = word;
                }
                Opcode::Push => self.stack.push(frame[insn.a as usize]),
                Opcode::Push2 => {
                    self.stack.push(frame[insn.a as usize]);
                    self.stack.push(frame[insn.b as usize]);
                }
                Opcode::Push3 => {
                    self.stack.push(frame[insn.a as usize]);
                    self.stack.push(frame[insn.b as usize]);
                    self.stack.push(frame[insn.c as usize]);
                }
                Opcode::PushConstant => self.stack.push(constants[insn.imm as usize]),
                Opcode::Pop => {
                    for offset in 0..insn.b {
                        if self.stack.len() <= self.floor {
                            let wanted_by = Operator::ALL.get((insn.c as usize).wrapping_sub(1));
                            trap!(Problem::Underflow(wanted_by.copied(), offset as usize))
                        }
                        self.stack.pop_to(&mut frame[insn.a.wrapping_add(offset) as usize]);
                    }
                }
                Opcode::MakeClosure => {
                    let sources = &functions[insn.imm as usize].captures;
                    let made = self.heap.closure(insn.imm, sources.len());
                    for (idx, source) in sources.iter().enumerate() {
                        let word = match *source {
                            CaptureSource::Register(register) => frame[register as usize],
                            CaptureSource::Capture(index) => self.heap.capture(self.closure, index),
                            CaptureSource::Slot(index) => {
                                let word = self.registers[slot(function, base, index)];
                                frame = window(&mut self.registers, base);
                                word
                            }
                        };
                        self.heap.items_mut(made.address())[idx].set(word);
                    }
                    frame[insn.a as usize].set(made);
                }
                Opcode::BeginArray => {
                    self.floors.push(self.floor);
                    self.floor = self.stack.len();
                }
                Opcode::EndArray => {
                    let array = self.collect_array(self.floor);
                    self.floor = self.floors.pop().unwrap_or(0);
                    frame = window(&mut self.registers, base);
                    frame[insn.a as usize].set(array);
                    check!(self.make_room(base + n_used(function)));
                    frame = window(&mut self.registers, base);
                }
                Opcode::MakeArray => {
                    let array = self.collect_array(self.stack.len() - insn.imm as usize);
                    frame = window(&mut self.registers, base);
                    frame[insn.a as usize].set(array);
                }
                Opcode::Get => {
                    let operands = [&frame[insn.b as usize], &frame[insn.c as usize]];
                    let (Tag::Array, Some(index)) = (operands[0].tag, operands[1].as_int()) else {
                        trap!(mismatch(Operator::Get, &operands))
                    };
                    let array = operands[0].address();
                    let Some(item) = self.heap.item(array, index) else {
                        trap!(Problem::Subscript(index, self.heap.length(array)))
                    };
                    frame[insn.a as usize].set(item);
                }
                Opcode::Length => {
                    let array = &frame[insn.b as usize];
                    if array.tag != Tag::Array {
                        trap!(mismatch(Operator::Length, &[array]))
                    }
                    let length = self.heap.length(array.address());
                    frame[insn.a as usize].set(Word::from_int(length as i64));
                }
                Opcode::Apply => {
                    let callee = callee!(insn.a);
                    if self.frames.len() >= self.limits.max_depth {
                        trap!(Problem::DepthLimit(self.limits.max_depth))
                    }
                    let callee_base = base + n_used(function);
                    index = self.heap.function(callee) as usize;
                    check!(self.enter(index, callee_base));
                    self.frames.push(Frame { closure: self.closure, pc, base });
                    (self.closure, base, pc) = (callee, callee_base, 0);
                    resume!();
                }
                Opcode::TailApply => {
                    let callee = callee!(insn.a);
                    index = self.heap.function(callee) as usize;
                    check!(self.enter(index, base));
                    (self.closure, pc) = (callee, 0);
                    resume!();
                }
                Opcode::Return => {
                    let Some(caller) = self.frames.pop() else { return Ok(()) };
                    (self.closure, base, pc) = (caller.closure, caller.base, caller.pc);
                    index = self.heap.function(self.closure) as usize;
                    resume!();
                }
                Opcode::Choose => {
                    let operands = [&frame[insn.a as usize], &frame[insn.b as usize], &frame[insn.c as usize]];
                    let (Some(condition), Tag::Closure, Tag::Closure) =
                        (operands[0].as_bool(), operands[1].tag, operands[2].tag)
                    else {
                        trap!(mismatch(Operator::If, &operands))
                    };
                    let chosen = *operands[if condition { 1 } else { 2 }];
                    frame[insn.imm as u8 as usize].set(chosen);
                }
                Opcode::Jump => pc += insn.imm as usize,
                Opcode::JumpUnless => match frame[insn.a as usize].as_bool() {
                    Some(true) => {}
                    Some(false) => pc += insn.imm as usize,
                    None => trap!(Problem::Mismatch(
                        Operator::If,
                        vec![frame[insn.a as usize].type_of(), Type::Closure, Type::Closure],
                    )),
                },
                Opcode::Unbound => {
                    let Value::Str(name) = self.heap.foreign(constants[insn.imm as usize]) else {
                        unreachable!("the compiler gives a name")
                    };
                    trap!(Problem::Unbound(name.clone()))
                }
                Opcode::Operate => {
                    let op = Operator::ALL[insn.b as usize];
                    let origin = function.origins[pc - 1];
                    let result = check!(ops::operate(op, self, origin, &mut host));
                    frame = window(&mut self.registers, base);
                    if let Some(word) = result {
                        frame[insn.a as usize].set(word);
                    }
                }
            }])
        }
    }

    /// Pays for a call and makes room for its frame.
    #[inline(always)]
    fn enter(&mut self, callee: usize, base: usize) -> Result<(), Box<Problem>> {
        let function = &self.program.bytecode.functions[callee];
        let cost = function.code.len() as u64;
        if self.fuel < cost {
            return Err(Box::new(Problem::FuelLimit(self.limits.fuel)));
        }
        self.fuel -= cost;
        let needed = base + WINDOW + function.n_slots as usize;
        if self.registers.len() < needed {
            self.grow(needed);
        }
        Ok(())
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self, n_registers: usize) {
        self.registers.resize(n_registers.next_multiple_of(WINDOW * 4), Word::NOTHING);
    }

    /// An array of what is on the stack from index `from` on.
    fn collect_array(&mut self, from: usize) -> Word {
        let items = &self.stack.as_slice()[from..];
        let array = self.heap.array(items.len());
        self.heap.items_mut(array.address()).copy_from_slice(items);
        self.stack.truncate(from);
        array
    }
}

/// Registers and slots of a function.
fn n_used(function: &Function) -> usize {
    (function.n_registers + function.n_slots) as usize
}

/// Where a spill slot is.
fn slot(function: &Function, base: usize, index: u32) -> usize {
    base + (function.n_registers + index) as usize
}
