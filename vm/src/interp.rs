//! The dispatch loop.
//!
//! What scalar operators compute stands in `compiler::scalar`; the macros here fetch their operands
//! (`r` from a register, `k` from the step, `acc` from the accumulator) and say what becomes of
//! their results.

use compiler::bytecode::CaptureSource;
use compiler::op::{Operator, Type};
use compiler::scalar::{self, Operands};
use compiler::{for_each_scalar, scalar_operand, scalar_result};

use crate::decision::decision;
use crate::dispatch::dispatch;
use crate::error::Problem;
use crate::host::Host;
use crate::machine::{Frame, Limits, MIN_GROWTH, Machine};
use crate::ops;
use crate::program::LoadedFunction;
use crate::registers::WINDOW;
use crate::step::{Op, for_each_further};
use crate::value::Value;
use crate::word::{Tag, Word};

macro_rules! with_further {
    ($($rows:tt)*) => { for_each_further!(dispatch, [$($rows)*]) };
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
        // What further rounds run, and the steps behind the current one.
        let mut round = function.round();
        let mut rest = function.steps.iter();
        let mut n_steps = function.steps.len();
        let mut frame = self.registers.window(base);

        // The position behind the current step.
        macro_rules! pc {
            () => {
                n_steps - rest.len()
            };
        }
        macro_rules! skip {
            ($n_steps:expr) => {
                if $n_steps != 0 {
                    rest.nth($n_steps - 1);
                }
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
                round = function.round();
                rest = function.steps.iter();
                n_steps = function.steps.len();
                skip!($pc);
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
                    trap!(Problem::mismatch(Operator::Apply, &[frame.get($register)]))
                }
                check_memory!();
                frame.get($register).address()
            }};
        }

        loop {
            let mut step;
            macro_rules! advance {
                () => {
                    step = rest.next().expect("functions end with a return or call");
                };
            }
            advance!();
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
            // Whether a call is of the running closure, and too little was made since the last look at
            // memory to take another.
            macro_rules! is_again {
                ($step:expr) => {{
                    let [_, register, ..] = $step.imm.to_le_bytes();
                    self.heap.n_cells() - self.mark + self.stack.len() < MIN_GROWTH
                        && frame.tag(register) == Tag::Closure
                        && frame.x(register) == self.closure as u64
                }};
            }
            // Calls the running closure in place of itself, behind pushes. The values are moved from
            // their registers to those that the function's first steps pop them to.
            macro_rules! again {
                () => {{
                    let [_, _, counts, _] = step.imm.to_le_bytes();
                    if self.fuel < n_steps as u64 {
                        skip!(usize::from(counts & 15 == 4) + 1);
                        trap!(Problem::FuelLimit(self.limits.fuel))
                    }
                    self.fuel -= n_steps as u64;
                    let mut moves = step.k;
                    for _ in 0..counts >> 4 {
                        let [from, to, ..] = moves.to_le_bytes();
                        frame.copy(from, to);
                        moves >>= 16;
                    }
                    rest = round.clone();
                    // Most rounds begin by testing a counter.
                    let next = rest.as_slice().first().map(|next| next.op);
                    if next == Some(Op::JumpUnlessLessIK) {
                        advance!();
                        jump_unless!(scalar::less_i(r!(Int a), k!(Int)))
                    } else if next == Some(Op::JumpUnlessEqIK) {
                        advance!();
                        jump_unless!(scalar::eq_i(r!(Int a), k!(Int)))
                    }
                }};
            }

            // The first parts of other fused steps, up to where the step behind is the current one.
            macro_rules! load {
                () => {{
                    let loaded = k!(Real);
                    frame.set_real(step.a, loaded);
                    advance!();
                    loaded
                }};
            }
            macro_rules! capture {
                () => {{
                    let captured = self.heap.capture(self.closure, step.imm);
                    frame.load(step.a, captured);
                    advance!();
                    match captured.as_real() {
                        Some(operand) => operand,
                        None => trap_scalar!(None),
                    }
                }};
            }
            macro_rules! first {
                (scalar::$function:ident r) => {
                    store!(Real a, scalar::$function(r!(Real b), r!(Real c)));
                    advance!();
                };
                (scalar::$function:ident k) => {
                    store!(Real a, scalar::$function(r!(Real b), k!(Real)));
                    advance!();
                };
            }

            for_each_scalar!(with_further, [step.op, {
                Op::Load => frame.load(step.a, &function.constants[step.imm as usize]),
                Op::Capture => frame.load(step.a, self.heap.capture(self.closure, step.imm)),
                Op::Move => frame.copy(step.b, step.a),
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
                Op::SumOfProducts => {
                    first!(scalar::mul_f r);
                    let product = acc!();
                    first!(scalar::mul_f r);
                    store!(Real a, scalar::add_f(product, acc!()))
                }
                Op::SumOfProductsTest => {
                    first!(scalar::mul_f r);
                    let product = acc!();
                    first!(scalar::mul_f r);
                    store!(Real a, scalar::add_f(product, acc!()));
                    advance!();
                    jump_unless!(scalar::less_f(acc!(), k!(Real)))
                }
                Op::SumOfMultiples => {
                    first!(scalar::mul_f k);
                    let product = acc!();
                    first!(scalar::mul_f k);
                    store!(Real a, scalar::add_f(product, acc!()))
                }
                Op::AddAgain => {
                    store!(Int a, scalar::add_i(r!(Int b), k!(Int)));
                    if rest.as_slice().first().is_some_and(|next| is_again!(next)) {
                        advance!();
                        again!()
                    }
                }
                Op::SubAgain => {
                    store!(Int a, scalar::sub_i(r!(Int b), k!(Int)));
                    if rest.as_slice().first().is_some_and(|next| is_again!(next)) {
                        advance!();
                        again!()
                    }
                }
                Op::Again if is_again!(step) => again!(),
                Op::Again => {
                    let [fourth, _, counts, _] = step.imm.to_le_bytes();
                    let registers = [step.a, step.b, step.c, fourth];
                    let n_pushes = usize::from(counts & 15);
                    for register in &registers[..n_pushes] {
                        frame.push([*register], &mut self.stack);
                    }
                    skip!(usize::from(n_pushes == 4));
                }
                Op::Push => frame.push([step.a], &mut self.stack),
                Op::Push2 => frame.push([step.a, step.b], &mut self.stack),
                Op::Push3 => frame.push([step.a, step.b, step.c], &mut self.stack),
                Op::Push4 => {
                    frame.push([step.a, step.b, step.c, step.imm as u8], &mut self.stack);
                    skip!(1);
                }
                Op::PushConstant => {
                    let [slot] = self.stack.push();
                    slot.set(&function.constants[step.imm as usize]);
                }
                Op::PushConstants => {
                    let [first, second, third] = self.stack.push();
                    first.set(&function.constants[step.imm as usize]);
                    second.set(&function.constants[step.k as u32 as usize]);
                    third.set(&function.constants[(step.k >> 32) as usize]);
                    skip!(2);
                }
                Op::Pop3 if self.stack.len() - self.floor >= 3 => {
                    let [third, second, first] = self.stack.pop();
                    frame.load(step.a, first);
                    frame.load(step.a.wrapping_add(1), second);
                    frame.load(step.a.wrapping_add(2), third);
                }
                Op::Pop4 if self.stack.len() - self.floor >= 4 => {
                    let [fourth, third, second, first] = self.stack.pop();
                    frame.load(step.a, first);
                    frame.load(step.a.wrapping_add(1), second);
                    frame.load(step.a.wrapping_add(2), third);
                    frame.load(step.a.wrapping_add(3), fourth);
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
                        frame.load(step.a.wrapping_add(offset), word);
                    }
                }
                Op::MakeClosure => {
                    let sources = &program.bytecode.functions[step.imm as usize].captures;
                    check!(pay(&mut self.fuel, &self.limits, sources.len()));
                    let made = self.heap.begin_closure(step.imm, sources.len());
                    for source in sources {
                        let word = match *source {
                            CaptureSource::Register(register) => frame.get(register),
                            CaptureSource::Capture(index) => *self.heap.capture(self.closure, index),
                            CaptureSource::Slot(index) => {
                                let word = self.registers.get(slot(function, base, index));
                                frame = self.registers.window(base);
                                word
                            }
                        };
                        self.heap.add_capture(word);
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
                    if frame.tag(step.b) != Tag::Array || frame.tag(step.c) != Tag::Int {
                        trap!(Problem::mismatch(Operator::Get, &[frame.get(step.b), frame.get(step.c)]))
                    }
                    let (array, index) = (frame.x(step.b) as usize, frame.x(step.c) as i64);
                    let Some(item) = self.heap.item(array, index) else {
                        trap!(Problem::Subscript(index, self.heap.length(array)))
                    };
                    frame.load(step.a, item);
                }
                Op::Length => {
                    let array = frame.get(step.b);
                    if array.tag != Tag::Array {
                        trap!(Problem::mismatch(Operator::Length, &[array]))
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
                        check!(pay(&mut self.fuel, &self.limits, n_steps));
                        rest = function.steps.iter();
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
                        trap!(Problem::mismatch(Operator::If, &operands))
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
        pay(&mut self.fuel, &self.limits, callee.steps.len())?;
        let needed = base + WINDOW + callee.n_used;
        if self.registers.len() < needed {
            self.grow_registers(needed);
        }
        Ok(())
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

/// Pays for the steps of a call, or for captured values.
#[inline(always)]
fn pay(fuel: &mut u64, limits: &Limits, n_steps: usize) -> Result<(), Box<Problem>> {
    let Some(left) = fuel.checked_sub(n_steps as u64) else {
        return Err(Box::new(Problem::FuelLimit(limits.fuel)));
    };
    *fuel = left;
    Ok(())
}

/// Where a spill slot is.
fn slot(function: &LoadedFunction, base: usize, index: u32) -> usize {
    base + function.n_registers + index as usize
}
