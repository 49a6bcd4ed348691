//! A machine: the state of a running program, its limits, and the ways to start it.

use std::sync::Arc;

use compiler::bytecode::Origin;
use compiler::diagnostic::TraceEntry;
use renderer::signature::Signature;

use crate::error::{Error, Problem};
use crate::exchange::Imports;
use crate::heap::Heap;
use crate::host::Host;
use crate::program::LoadedProgram;
use crate::registers::Registers;
use crate::stack::OperandStack;
use crate::value::{Closure, Value};
use crate::word::{Tag, Word};

/// What a program may use up.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Instructions, counted as the length of each called function, and values that closures capture.
    pub fuel: u64,
    /// Calls active at once.
    pub max_depth: usize,
    /// Bytes of values: of the program's, or those that a call of a surface function makes.
    pub max_memory: u64,
}

/// The heap is not cut before a call has made it grow by so many cells: about what a core's own
/// caches hold.
pub(crate) const MIN_GROWTH: usize = 8192;

/// A call that waits for another to return.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) closure: usize,
    pub(crate) pc: usize,
    pub(crate) base: usize,
    pub(crate) mark: usize,
}

/// The state of one thread of execution.
pub struct Machine<'p> {
    pub(crate) program: &'p Arc<LoadedProgram>,
    pub(crate) limits: Limits,
    pub(crate) heap: Heap,
    /// What has come from outside into the heap.
    pub(crate) imports: Imports,
    /// Number of cells that stay for good: constants, and what has come from outside.
    settled: usize,
    /// Surface functions: closures in the heap.
    pub(crate) surfaces: Vec<Word>,
    /// Operands that cross calls.
    pub(crate) stack: OperandStack,
    /// Frames of all active calls; values above the running one's are dead.
    pub(crate) registers: Registers,
    pub(crate) frames: Vec<Frame>,
    /// Where in the heap the running closure is.
    pub(crate) closure: usize,
    /// Number of cells when the running call began: callers have in their registers only what was
    /// there then. Calls in tail position keep it, but what such a call finds in use counts as there.
    pub(crate) mark: usize,
    /// Words looked at so far to find out what is in use.
    n_looked_at: u64,
    /// What lies below on the operand stack is out of reach.
    pub(crate) floor: usize,
    /// Floors of the array literals around the current one.
    pub(crate) floors: Vec<usize>,
    pub(crate) fuel: u64,
    /// Bytes that stack, heap and waiting calls may use: what has settled in the heap for surface
    /// functions, and what the registers do not take of the limit.
    pub(crate) room: u64,
    /// The instruction last begun, written when something goes wrong.
    pub(crate) stopped_at: usize,
    /// What has been decided so far, where that is asked for.
    pub(crate) signature: Signature,
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
            settled: program.heap.n_cells(),
            surfaces: Vec::new(),
            stack: OperandStack::new(limits.max_memory),
            registers: Registers::default(),
            frames: Vec::new(),
            closure: 0,
            mark: 0,
            n_looked_at: 0,
            floor: 0,
            floors: Vec::new(),
            fuel: limits.fuel,
            room: limits.max_memory,
            stopped_at: 0,
            signature: Signature::NONE,
        }
    }

    /// Runs the main program and returns what it leaves on the stack, bottom first.
    ///
    /// # Errors
    /// The first run-time error.
    pub fn run(mut self, host: &mut dyn Host) -> Result<Vec<Value>, Box<Error>> {
        let main = self.heap.closure(self.program.bytecode.main(), 0);
        self.call::<false>(main, Some(host))?;
        Ok(self.take_values(0))
    }

    /// Calls a closure on the stack as it is; adds its decisions to the signature if it is to be SIGNED.
    pub(crate) fn call<const SIGNED: bool>(
        &mut self,
        closure: Word,
        host: Option<&mut dyn Host>,
    ) -> Result<(), Box<Error>> {
        self.closure = closure.address();
        self.execute::<SIGNED>(host).map_err(|problem| self.error(*problem))
    }

    /// Takes all values from index `from` on off the stack, bottom first.
    pub(crate) fn take_values(&mut self, from: usize) -> Vec<Value> {
        let taken = &self.stack.as_slice()[from..];
        let values = taken.iter().map(|word| self.heap.export(*word)).collect();
        self.stack.truncate(from);
        values
    }

    /// Forgets all that a former call has left, but keeps the memory. What the next call may use does not
    /// depend on which were before, nor on what has come from outside for them.
    pub(crate) fn reset(&mut self) {
        self.heap.reset(self.settled);
        self.n_looked_at = self.heap.n_made();
        self.registers.shrink();
        let room = self.limits.max_memory.saturating_add(self.heap.n_bytes());
        self.room = room.saturating_sub(self.registers.n_bytes());
        self.stack.truncate(0);
        self.frames.clear();
        self.floors.clear();
        self.floor = 0;
        self.fuel = self.limits.fuel;
    }

    /// Brings a closure into the heap for good; forgets what a former call has left.
    pub(crate) fn import(&mut self, closure: &Arc<Closure>) -> Word {
        self.reset();
        let word = self.imports.import(closure, &mut self.heap);
        self.settled = self.heap.n_cells();
        word
    }

    /// Makes room for so many registers.
    #[cold]
    #[inline(never)]
    pub(crate) fn grow_registers(&mut self, len: usize) {
        let n_before = self.registers.n_bytes();
        self.registers.grow(len);
        self.room = self.room.saturating_sub(self.registers.n_bytes() - n_before);
    }

    /// Cuts the heap when the running call calls another in its place. What it has made is in use
    /// only if it is on the stack or held by what is, or is the other closure; its own is needed to
    /// tell of errors. Looking at the stack must have been paid for by what was made.
    #[cold]
    #[inline(never)]
    pub(crate) fn cut_heap(&mut self, callee: usize) {
        let n_words = self.stack.len() as u64;
        if self.heap.n_made() - self.n_looked_at >= n_words {
            self.n_looked_at += n_words;
            let closures = [callee, self.closure].map(|at| Word::new(Tag::Closure, at as u64));
            let in_use = self.stack.as_slice().iter().chain(&closures);
            let in_place = in_use.filter(|word| !word.is_foreign());
            let end = in_place.map(|word| self.heap.end(*word)).fold(self.mark, usize::max);
            self.heap.cut_around(end, self.stack.as_mut_slice());
        }
        self.mark = self.heap.n_cells();
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
