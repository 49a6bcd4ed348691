//! A machine: the state of a running program, its limits, and the ways to start it.

use std::sync::Arc;

use compiler::bytecode::Origin;
use compiler::diagnostic::TraceEntry;

use crate::error::{Error, Problem};
use crate::exchange::Imports;
use crate::heap::{Collection, Heap};
use crate::host::Host;
use crate::program::LoadedProgram;
use crate::registers::Registers;
use crate::stack::OperandStack;
use crate::value::Value;
use crate::word::Word;

/// What a program may use up.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Instructions, counted as the length of each called function.
    pub fuel: u64,
    /// Calls active at once.
    pub max_depth: usize,
    /// Bytes of values.
    pub max_memory: u64,
}

/// Less than this is never worth collecting: about what a core's own caches hold.
const MIN_ROOM: u64 = 256 << 10;

/// A call that waits for another to return.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) closure: usize,
    pub(crate) pc: usize,
    pub(crate) base: usize,
}

/// The state of one thread of execution.
pub struct Machine<'p> {
    pub(crate) program: &'p Arc<LoadedProgram>,
    pub(crate) limits: Limits,
    pub(crate) heap: Heap,
    /// What has come from outside into the heap.
    pub(crate) imports: Imports,
    /// Surface functions: closures in the heap.
    pub(crate) surfaces: Vec<Word>,
    /// Operands that cross calls.
    pub(crate) stack: OperandStack,
    /// Frames of all active calls; values above the running one's are dead.
    pub(crate) registers: Registers,
    pub(crate) frames: Vec<Frame>,
    /// Where in the heap the running closure is.
    pub(crate) closure: usize,
    /// What lies below on the operand stack is out of reach.
    pub(crate) floor: usize,
    /// Floors of the array literals around the current one.
    pub(crate) floors: Vec<usize>,
    pub(crate) fuel: u64,
    /// When stack and heap use so many bytes, what is out of reach is to be forgotten.
    pub(crate) room: u64,
    /// The instruction last begun, written when something goes wrong.
    pub(crate) stopped_at: usize,
}

impl<'p> Machine<'p> {
    /// A machine with an empty stack.
    #[must_use]
    pub fn new(program: &'p Arc<LoadedProgram>, limits: Limits) -> Self {
        Machine {
            program,
            limits,
            heap: program.heap.clone(),
            imports: Imports::default(),
            surfaces: Vec::new(),
            stack: OperandStack::default(),
            registers: Registers::default(),
            frames: Vec::new(),
            closure: 0,
            floor: 0,
            floors: Vec::new(),
            fuel: limits.fuel,
            room: limits.max_memory.min(MIN_ROOM),
            stopped_at: 0,
        }
    }

    /// Runs the main program and returns what it leaves on the stack, bottom first.
    ///
    /// # Errors
    /// The first run-time error.
    pub fn run(mut self, host: &mut dyn Host) -> Result<Vec<Value>, Box<Error>> {
        let main = self.heap.closure(self.program.bytecode.main(), 0);
        self.call(main, Some(host))?;
        Ok(self.take_values(0))
    }

    /// Calls a closure on the stack as it is.
    pub(crate) fn call(
        &mut self,
        closure: Word,
        host: Option<&mut dyn Host>,
    ) -> Result<(), Box<Error>> {
        self.closure = closure.address();
        self.execute(host).map_err(|problem| self.error(*problem))
    }

    /// Takes all values from index `from` on off the stack, bottom first.
    pub(crate) fn take_values(&mut self, from: usize) -> Vec<Value> {
        let taken = &self.stack.as_slice()[from..];
        let values = taken.iter().map(|word| self.heap.export(*word)).collect();
        self.stack.truncate(from);
        values
    }

    /// Forgets all that a former call has left, but keeps the memory.
    pub(crate) fn reset(&mut self) {
        self.stack.truncate(0);
        self.frames.clear();
        self.floors.clear();
        self.floor = 0;
        self.fuel = self.limits.fuel;
    }

    /// Makes room for so many registers.
    #[cold]
    #[inline(never)]
    pub(crate) fn grow_registers(&mut self, len: usize) {
        let n_before = self.registers.n_bytes();
        self.registers.grow(len);
        self.room = self.room.saturating_sub(self.registers.n_bytes() - n_before);
    }

    /// Forgets what is out of reach; fails if the limit is as good as reached all the same. Values
    /// may move; registers from `top` on are dead.
    #[cold]
    #[inline(never)]
    pub(crate) fn collect(&mut self, top: usize) -> Result<(), Box<Problem>> {
        let mut collection = Collection::begin(&mut self.heap);
        self.registers.update(top, |word| collection.keep(word));
        let outside = self.imports.words_mut().chain(&mut self.surfaces);
        for word in self.stack.as_mut_slice().iter_mut().chain(outside) {
            collection.keep(word);
        }
        for frame in &mut self.frames {
            frame.closure = collection.moved(frame.closure);
        }
        self.closure = collection.moved(self.closure);
        collection.finish();
        let in_registers = self.registers.n_bytes();
        let in_use = in_registers + self.stack.n_bytes() + self.heap.n_bytes();
        let waiting = (self.frames.len() * size_of::<Frame>()) as u64;
        let limit = self.limits.max_memory;
        if in_use + waiting > limit / 16 * 15 {
            return Err(Box::new(Problem::MemoryLimit(limit)));
        }
        self.room = (2 * in_use).max(MIN_ROOM).min(limit) - in_registers;
        Ok(())
    }

    pub(crate) fn error(&self, problem: Problem) -> Box<Error> {
        let functions = &self.program.bytecode.functions;
        let function = &functions[self.heap.function(self.closure) as usize];
        let mut origin = function.origins.get(self.stopped_at).copied().unwrap_or_default();
        match problem {
            Problem::SurfaceResult(_) => {
                origin = Origin { span: function.span, ..Origin::default() };
            }
            Problem::Underflow(_, n_taken) if !origin.operands[n_taken].is_none() => {
                origin.span = origin.operands[n_taken];
            }
            _ => {}
        }
        let mut trace: Vec<TraceEntry> = Vec::new();
        for frame in &self.frames {
            let index = self.heap.function(frame.closure);
            let span = functions[index as usize].origins[frame.pc - 1].span;
            match trace.last_mut() {
                Some(last) if last.span == span => last.repeats += 1,
                _ => trace.push(TraceEntry { span, within: self.title(index), repeats: 1 }),
            }
        }
        Box::new(Error { problem, origin, trace })
    }

    fn title(&self, function: u32) -> String {
        let bytecode = &self.program.bytecode;
        match &bytecode.functions[function as usize].name {
            Some(name) => format!("`{name}`"),
            None if function == bytecode.main() => "the main program".to_owned(),
            None => "a function".to_owned(),
        }
    }
}
