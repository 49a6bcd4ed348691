//! The dispatch loop.
//!
//! Arms for scalar operators derive from the operator table and only fetch operands and store
//! results; what they compute stands in `compiler::scalar`.

use compiler::bytecode::{CaptureSource, Format};
use compiler::op::{Operator, Type};
use compiler::scalar::{self, Fault, Operands};
use compiler::{for_each_scalar, scalar_operand, scalar_result};

use crate::decision::decision;
use crate::display;
use crate::error::Problem;
use crate::host::Host;
use crate::machine::{Frame, Limits, MIN_GROWTH, Machine};
use crate::ops;
use crate::program::LoadedFunction;
use crate::registers::WINDOW;
use crate::step::{Op, for_each_further};
use crate::value::Value;
use crate::word::{Tag, Word};

/// The match on a step: the given arms, and one for each form of each scalar operator. The macros
/// of the loop fetch operands (`r` from a register, `k` from the step, `acc` from the accumulator)
/// and say what becomes of results.
macro_rules! dispatch {
    ([[$op:expr, { $($control:tt)* }]
      unary { $($(#[$ud:meta])+ $u:ident $us:literal $uf:ident($ut:ident) -> $ur:ident;)* }
      binary { $($(#[$bd:meta])+ $b:ident $bk:ident $bs:literal $bf:ident($bt:ident, $bt2:ident) -> $br:ident;)* }
      compare { $($(#[$cd:meta])+ $c:ident $ck:ident $cj:ident $cjk:ident $cs:literal $cf:ident($ct:ident, $ct2:ident) -> $cr:ident;)* }
      ternary { $($(#[$td:meta])+ $t:ident $ts:literal $tf:ident($tt:ident, $tt2:ident, $tt3:ident) -> $tr:ident;)* }]
      unary { $($xu:ident $xua:ident $xuf:ident -> $xur:ident;)* }
      binary { $($xb:ident $xbk:ident $xbf:ident $ra:ident $ar:ident $aa:ident $ak:ident $kr:ident $ka:ident $rc:ident $ac:ident $rm:ident;)* }
      jump { $($xj:ident $xjk:ident $xjf:ident $jra:ident $jar:ident $jak:ident;)* }) => {
        match $op {
            $($control)*
            $(Op::$u => store!($ur a, scalar::$uf(r!($ut b))),)*
            $(Op::$b => store!($br a, scalar::$bf(r!($bt b), r!($bt2 c))),
              Op::$bk => store!($br a, scalar::$bf(r!($bt b), k!($bt2))),)*
            $(Op::$c => store!($cr a, scalar::$cf(r!($ct b), r!($ct2 c))),
              Op::$ck => store!($cr a, scalar::$cf(r!($ct b), k!($ct2))),
              Op::$cj => jump_unless!(scalar::$cf(r!($ct a), r!($ct2 b))),
              Op::$cjk => jump_unless!(scalar::$cf(r!($ct a), k!($ct2))),)*
            $(Op::$t => store!($tr imm, scalar::$tf(r!($tt a), r!($tt2 b), r!($tt3 c))),)*
            $(Op::$xua => store!($xur a, scalar::$xuf(acc!())),)*
            $(Op::$ra => store!(Real a, scalar::$xbf(r!(Real b), acc!())),
              Op::$ar => store!(Real a, scalar::$xbf(acc!(), r!(Real c))),
              Op::$aa => store!(Real a, scalar::$xbf(acc!(), acc!())),
              Op::$ak => store!(Real a, scalar::$xbf(acc!(), k!(Real))),
              Op::$kr => {
                  load!();
                  store!(Real a, scalar::$xbf(k!(Real), r!(Real c)))
              }
              Op::$ka => {
                  load!();
                  store!(Real a, scalar::$xbf(k!(Real), acc!()))
              }
              Op::$rc => {
                  let captured = capture!();
                  store!(Real a, scalar::$xbf(r!(Real b), captured))
              }
              Op::$ac => {
                  let captured = capture!();
                  store!(Real a, scalar::$xbf(acc!(), captured))
              }
              Op::$rm => {
                  multiply!();
                  store!(Real imm, scalar::$xbf(r!(Real c), acc!()))
              })*
            $(Op::$jra => jump_unless!(scalar::$xjf(r!(Real a), acc!())),
              Op::$jar => jump_unless!(scalar::$xjf(acc!(), r!(Real b))),
              Op::$jak => jump_unless!(scalar::$xjf(acc!(), k!(Real))),)*
        }
    };
}

macro_rules! with_further {
    ($($rows:tt)*) => { for_each_further!(dispatch, [$($rows)*]) };
}

#[cold]
#[inline(never)]
fn mismatch(op: Operator, operands: &[Word]) -> Problem {
    Problem::Mismatch(op, operands.iter().map(|operand| operand.type_of()).collect())
}

impl Machine<'_> {
    /// Runs `self.closure` until it returns. When something goes wrong, it is the closure that was
    /// running then, and `frames` and `stopped_at` tell the rest. Its decisions are added to the
    /// signature if it is to be SIGNED.
    pub(crate) fn execute<const SIGNED: bool>(
        &mut self,
        mut host: Option<&mut dyn Host>,
    ) -> Result<(), Box<Problem>> {
        let program = self.program;
        let functions = &program.functions[..];
        let mut base = 0;
        let mut accumulator = 0.0;
        self.stopped_at = 0;
        if self.stack.n_bytes() + self.heap.n_bytes() > self.room {
            return Err(Box::new(Problem::MemoryLimit(self.limits.max_memory)));
        }
        self.mark = self.heap.n_cells();
        let mut index = self.heap.function(self.closure) as usize;
        let mut function = &functions[index];
        self.enter(function, base)?;
        let mut rest = &function.steps[..];
        let mut frame = self.registers.window(base);

        // The position behind the current step.
        macro_rules! pc {
            () => {
                function.steps.len() - rest.len()
            };
        }
        macro_rules! skip {
            ($n_steps:expr) => {
                rest = &rest[$n_steps..]
            };
        }

        macro_rules! trap {
            ($problem:expr) => {{
                let problem = Box::new($problem);
                self.stopped_at = pc!() - 1;
                return Err(problem);
            }};
        }
        macro_rules! check {
            ($result:expr) => {
                match $result {
                    Ok(value) => value,
                    Err(problem) => {
                        self.stopped_at = pc!() - 1;
                        return Err(problem);
                    }
                }
            };
        }
        // A scalar operator has got operands of the wrong types or, with a fault, values.
        macro_rules! trap_scalar {
            ($fault:expr) => {{
                self.stopped_at = pc!() - 1;
                return Err(self.scalar_problem(index, base, $fault));
            }};
        }
        // Continues in function `index` from a position on, with the frame at `base`.
        macro_rules! resume {
            ($pc:expr) => {
                function = &functions[index];
                rest = &function.steps[$pc..];
                frame = self.registers.window(base);
            };
        }
        // Whether more memory is in use than may be.
        macro_rules! is_full {
            () => {{
                let waiting = (self.frames.len() * size_of::<Frame>()) as u64;
                self.stack.n_bytes() + self.heap.n_bytes() + waiting > self.room
            }};
        }
        // Whether the running call has made the heap grow so much that cutting it may pay.
        macro_rules! is_heap_due {
            () => {
                self.heap.n_cells() - self.mark >= MIN_GROWTH
            };
        }
        macro_rules! check_memory {
            () => {
                if is_full!() {
                    trap!(Problem::MemoryLimit(self.limits.max_memory))
                }
            };
        }
        // Adds a decision to the signature, if that is asked for.
        macro_rules! sign {
            ($decision:expr) => {
                if SIGNED {
                    self.signature = self.signature.with($decision);
                }
            };
        }
        // The closure in a register, to be called.
        macro_rules! callee {
            ($register:expr) => {{
                if frame.tag($register) != Tag::Closure {
                    trap!(mismatch(Operator::Apply, &[frame.get($register)]))
                }
                check_memory!();
                frame.get($register).address()
            }};
        }

        loop {
            let [step, behind @ ..] = rest else {
                unreachable!("functions end with a return or call")
            };
            rest = behind;
            if SIGNED && let Some(decision) = decision(step, &frame, accumulator) {
                sign!(decision);
            }

            macro_rules! register {
                (imm) => {
                    step.imm as u8
                };
                ($field:ident) => {
                    step.$field
                };
            }
            macro_rules! r {
                ($type:ident $field:ident) => {
                    match scalar_operand!($type, &frame.get(register!($field))) {
                        Some(operand) => operand,
                        None => trap_scalar!(None),
                    }
                };
            }
            macro_rules! k {
                (Int) => {
                    step.k as i64
                };
                (Real) => {
                    f64::from_bits(step.k)
                };
            }
            macro_rules! acc {
                () => {
                    accumulator
                };
            }
            macro_rules! store {
                (Real $field:ident, $result:expr) => {
                    match $result {
                        Ok(result) => {
                            accumulator = result;
                            frame.set_real(register!($field), result);
                        }
                        Err(fault) => trap_scalar!(Some(fault)),
                    }
                };
                ($type:ident $field:ident, $result:expr) => {
                    match $result {
                        Ok(result) => frame.set(register!($field), scalar_result!($type, result)),
                        Err(fault) => trap_scalar!(Some(fault)),
                    }
                };
            }
            macro_rules! jump_unless {
                ($result:expr) => {
                    match $result {
                        Ok(true) => sign!(1),
                        Ok(false) => {
                            sign!(0);
                            skip!(step.imm as usize)
                        }
                        Err(fault) => trap_scalar!(Some(fault)),
                    }
                };
            }
            // Whether a call is of the running closure, and takes no look at memory.
            macro_rules! is_again {
                () => {{
                    let closure = frame.get(step.k as u8);
                    !is_heap_due!()
                        && closure.tag == Tag::Closure
                        && closure.address() == self.closure
                }};
            }
            // Calls the running closure in place of itself, behind a few pushes. The values go from
            // their registers to those that the function's first steps pop them to.
            macro_rules! again {
                ($n_pushes:expr, $registers:expr) => {
                    skip!($n_pushes);
                    check!(pay(&mut self.fuel, &self.limits, function));
                    let words = $registers.map(|register| frame.get(register));
                    frame.set_all((step.k >> 8) as u8, words);
                    rest = &function.steps[$n_pushes..];
                };
            }

            // The first halves of other fused steps.
            macro_rules! load {
                () => {
                    frame.set_real(step.b, k!(Real));
                    skip!(1);
                };
            }
            macro_rules! capture {
                () => {{
                    let captured = self.heap.capture(self.closure, step.imm);
                    frame.set(step.c, captured);
                    skip!(1);
                    match captured.as_real() {
                        Some(operand) => operand,
                        None => trap_scalar!(None),
                    }
                }};
            }
            macro_rules! multiply {
                () => {
                    store!(Real a, scalar::mul_f(r!(Real b), k!(Real)));
                    skip!(1);
                };
            }

            for_each_scalar!(with_further, [step.op, {
                Op::Load => frame.set(step.a, function.constants[step.imm as usize]),
                Op::Capture => {
                    frame.set(step.a, self.heap.capture(self.closure, step.imm));
                }
                Op::Move => {
                    let word = frame.get(step.b);
                    frame.set(step.a, word);
                }
                Op::Spill => {
                    let word = frame.get(step.a);
                    self.registers.set(slot(function, base, step.imm), word);
                    frame = self.registers.window(base);
                }
                Op::Unspill => {
                    let word = self.registers.get(slot(function, base, step.imm));
                    frame = self.registers.window(base);
                    frame.set(step.a, word);
                }
                Op::Again2 if is_again!() => {
                    again!(1, [step.b, step.a]);
                }
                Op::Again3 if is_again!() => {
                    again!(1, [step.c, step.b, step.a]);
                }
                Op::Again4 if is_again!() => {
                    again!(2, [step.imm as u8, step.c, step.b, step.a]);
                }
                Op::Push => self.stack.push([frame.get(step.a)]),
                Op::Push2 | Op::Again2 => self.stack.push([frame.get(step.a), frame.get(step.b)]),
                Op::Push3 | Op::Again3 => {
                    self.stack.push([step.a, step.b, step.c].map(|r| frame.get(r)));
                }
                Op::Push4 | Op::Again4 => {
                    self.stack.push([step.a, step.b, step.c, step.imm as u8].map(|r| frame.get(r)));
                    skip!(1);
                }
                Op::PushConstant => self.stack.push([function.constants[step.imm as usize]]),
                Op::PushConstants => {
                    let indices = [step.imm, step.k as u32, (step.k >> 32) as u32];
                    self.stack.push(indices.map(|index| function.constants[index as usize]));
                    skip!(2);
                }
                Op::Pop3 if self.stack.len() - self.floor >= 3 => {
                    let words = self.stack.pop::<3>();
                    frame.set_all(step.a, words);
                }
                Op::Pop4 if self.stack.len() - self.floor >= 4 => {
                    let words = self.stack.pop::<4>();
                    frame.set_all(step.a, words);
                    skip!(1);
                }
                Op::Pop | Op::Pop3 | Op::Pop4 => {
                    let n_found = self.stack.len() - self.floor;
                    if n_found < step.b as usize {
                        let wanted_by = Operator::ALL.get((step.c as usize).wrapping_sub(1));
                        trap!(Problem::Underflow(wanted_by.copied(), n_found))
                    }
                    for offset in 0..step.b {
                        let [word] = self.stack.pop();
                        frame.set(step.a.wrapping_add(offset), word);
                    }
                }
                Op::MakeClosure => {
                    let sources = &program.bytecode.functions[step.imm as usize].captures;
                    let made = self.heap.closure(step.imm, sources.len());
                    for (idx, source) in sources.iter().enumerate() {
                        let word = match *source {
                            CaptureSource::Register(register) => frame.get(register),
                            CaptureSource::Capture(index) => self.heap.capture(self.closure, index),
                            CaptureSource::Slot(index) => {
                                let word = self.registers.get(slot(function, base, index));
                                frame = self.registers.window(base);
                                word
                            }
                        };
                        self.heap.items_mut(made.address())[idx].set(word);
                    }
                    frame.set(step.a, made);
                }
                Op::BeginArray => {
                    self.floors.push(self.floor);
                    self.floor = self.stack.len();
                }
                Op::EndArray => {
                    let array = self.collect_array(self.floor);
                    self.floor = self.floors.pop().unwrap_or(0);
                    frame = self.registers.window(base);
                    frame.set(step.a, array);
                    check_memory!();
                }
                Op::MakeArray => {
                    let array = self.collect_array(self.stack.len() - step.imm as usize);
                    frame = self.registers.window(base);
                    frame.set(step.a, array);
                }
                Op::Get => {
                    let operands = [frame.get(step.b), frame.get(step.c)];
                    let (Tag::Array, Some(index)) = (operands[0].tag, operands[1].as_int()) else {
                        trap!(mismatch(Operator::Get, &operands))
                    };
                    let array = operands[0].address();
                    let Some(item) = self.heap.item(array, index) else {
                        trap!(Problem::Subscript(index, self.heap.length(array)))
                    };
                    frame.set(step.a, item);
                }
                Op::Length => {
                    let array = frame.get(step.b);
                    if array.tag != Tag::Array {
                        trap!(mismatch(Operator::Length, &[array]))
                    }
                    frame.set(step.a, Word::from_int(self.heap.length(array.address()) as i64));
                }
                Op::Apply => {
                    let callee = callee!(step.a);
                    if self.frames.len() >= self.limits.max_depth {
                        trap!(Problem::DepthLimit(self.limits.max_depth))
                    }
                    let callee_base = base + function.n_used;
                    let callee_index = self.heap.function(callee) as usize;
                    check!(self.enter(&functions[callee_index], callee_base));
                    let mark = self.mark;
                    self.frames.push(Frame { closure: self.closure, pc: pc!(), base, mark });
                    self.mark = self.heap.n_cells();
                    (self.closure, index, base) = (callee, callee_index, callee_base);
                    resume!(0);
                }
                Op::TailApply => {
                    let callee = callee!(step.a);
                    if is_heap_due!() {
                        self.cut_heap(callee);
                        frame = self.registers.window(base);
                    }
                    if callee == self.closure {
                        check!(pay(&mut self.fuel, &self.limits, function));
                        rest = &function.steps;
                        continue;
                    }
                    let callee_index = self.heap.function(callee) as usize;
                    check!(self.enter(&functions[callee_index], base));
                    (self.closure, index) = (callee, callee_index);
                    resume!(0);
                }
                Op::Return => {
                    let Some(caller) = self.frames.pop() else { return Ok(()) };
                    (self.closure, base, self.mark) = (caller.closure, caller.base, caller.mark);
                    index = self.heap.function(self.closure) as usize;
                    resume!(caller.pc);
                }
                Op::Choose => {
                    let operands = [frame.get(step.a), frame.get(step.b), frame.get(step.c)];
                    let (Some(condition), Tag::Closure, Tag::Closure) =
                        (operands[0].as_bool(), operands[1].tag, operands[2].tag)
                    else {
                        trap!(mismatch(Operator::If, &operands))
                    };
                    frame.set(step.imm as u8, operands[if condition { 1 } else { 2 }]);
                }
                Op::Jump => skip!(step.imm as usize),
                Op::JumpUnless => match frame.get(step.a).as_bool() {
                    Some(true) => {}
                    Some(false) => skip!(step.imm as usize),
                    None => trap!(Problem::Mismatch(
                        Operator::If,
                        vec![frame.get(step.a).type_of(), Type::Closure, Type::Closure],
                    )),
                },
                Op::Unbound => {
                    let name = function.constants[step.imm as usize];
                    let Value::Str(name) = self.heap.foreign(name) else {
                        unreachable!("the compiler gives a name")
                    };
                    trap!(Problem::Unbound(name.clone()))
                }
                Op::Operate => {
                    let op = Operator::ALL[step.b as usize];
                    let origin = program.bytecode.functions[index].origins[pc!() - 1];
                    let result = check!(ops::operate(op, self, origin, &mut host));
                    frame = self.registers.window(base);
                    if let Some(word) = result {
                        frame.set(step.a, word);
                    }
                }
                Op::Mistyped => trap_scalar!(None),
            }])
        }
    }

    /// Pays for a call and makes room for its frame.
    #[inline(always)]
    fn enter(&mut self, callee: &LoadedFunction, base: usize) -> Result<(), Box<Problem>> {
        pay(&mut self.fuel, &self.limits, callee)?;
        let needed = base + WINDOW + callee.n_used;
        if self.registers.len() < needed {
            self.grow_registers(needed);
        }
        Ok(())
    }

    /// What is wrong with the operands of the scalar operator at which the machine has stopped.
    #[cold]
    #[inline(never)]
    fn scalar_problem(&self, function: usize, base: usize, fault: Option<Fault>) -> Box<Problem> {
        let insn = self.program.bytecode.functions[function].code[self.stopped_at];
        let r = |register: u8| self.registers.get(base + register as usize);
        let k = |index: u32| self.program.functions[function].constants[index as usize];
        let operands = match insn.op.format() {
            Format::AB => vec![r(insn.b)],
            Format::ABC => vec![r(insn.b), r(insn.c)],
            Format::ABConstant => vec![r(insn.b), k(insn.imm)],
            Format::ABJump => vec![r(insn.a), r(insn.b)],
            Format::AKJump => vec![r(insn.a), k(u32::from(insn.b))],
            _ => vec![r(insn.a), r(insn.b), r(insn.c)],
        };
        let op = insn.op.operator().expect("only scalar operators have such problems");
        Box::new(match fault {
            None => mismatch(op, &operands),
            Some(fault) => {
                let scalars = operands.iter().filter_map(|operand| operand.to_scalar());
                Problem::Fault(op, fault, scalars.map(|scalar| display::to_text(&scalar)).collect())
            }
        })
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

/// Pays for a call.
#[inline(always)]
fn pay(fuel: &mut u64, limits: &Limits, callee: &LoadedFunction) -> Result<(), Box<Problem>> {
    let Some(left) = fuel.checked_sub(callee.steps.len() as u64) else {
        return Err(Box::new(Problem::FuelLimit(limits.fuel)));
    };
    *fuel = left;
    Ok(())
}

/// Where a spill slot is.
fn slot(function: &LoadedFunction, base: usize, index: u32) -> usize {
    base + function.n_registers + index as usize
}
