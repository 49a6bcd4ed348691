//! A machine: the state of a running program, its limits, and the ways to start it.

use std::sync::Arc;

use compiler::bytecode::{Function, Origin};
use compiler::diagnostic::TraceEntry;

use crate::error::{Error, Problem};
use crate::host::Host;
use crate::memory;
use crate::program::LoadedProgram;
use crate::stack::OperandStack;
use crate::value::{Closure, Value};

/// Registers that an instruction can name. The frame of the running call is a window of so many,
/// of which the function uses its first few; the callee's window starts behind those.
pub(crate) const WINDOW: usize = 256;

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

/// A call that waits for another to return.
pub(crate) struct Frame {
    pub(crate) closure: Arc<Closure>,
    pub(crate) pc: usize,
    pub(crate) base: usize,
}

/// The state of one thread of execution.
pub struct Machine<'p> {
    pub(crate) program: &'p Arc<LoadedProgram>,
    pub(crate) limits: Limits,
    /// Operands that cross calls.
    pub(crate) stack: OperandStack,
    /// Frames of all active calls; values above the running one's are dead.
    pub(crate) registers: Vec<Value>,
    pub(crate) frames: Vec<Frame>,
    /// What lies below on the operand stack is out of reach.
    pub(crate) floor: usize,
    /// Floors of the array literals around the current one.
    pub(crate) floors: Vec<usize>,
    pub(crate) fuel: u64,
    /// Upper bound of the bytes in use by heap values.
    pub(crate) allocated: u64,
    /// Function and instruction last begun, written when something goes wrong.
    pub(crate) stopped_at: (u32, usize),
}

impl<'p> Machine<'p> {
    /// A machine with an empty stack.
    #[must_use]
    pub fn new(program: &'p Arc<LoadedProgram>, limits: Limits) -> Self {
        Machine {
            program,
            limits,
            stack: OperandStack::default(),
            registers: Vec::new(),
            frames: Vec::new(),
            floor: 0,
            floors: Vec::new(),
            fuel: limits.fuel,
            allocated: 0,
            stopped_at: (0, 0),
        }
    }

    /// Runs the main program and returns what it leaves on the stack, bottom first.
    ///
    /// # Errors
    /// The first run-time error.
    pub fn run(mut self, host: &mut dyn Host) -> Result<Vec<Value>, Box<Error>> {
        let main = Arc::new(Closure::new(self.program.bytecode.main(), Vec::new()));
        self.call(main, Some(host))?;
        Ok(self.stack.split_off(0))
    }

    /// Calls a closure on the stack as it is.
    pub(crate) fn call(
        &mut self,
        closure: Arc<Closure>,
        host: Option<&mut dyn Host>,
    ) -> Result<(), Box<Error>> {
        self.execute(closure, host).map_err(|problem| self.error(*problem))
    }

    /// Forgets all that a former call has left, but keeps the memory.
    pub(crate) fn reset(&mut self) {
        self.stack.clear();
        self.frames.clear();
        self.floors.clear();
        self.floor = 0;
        self.fuel = self.limits.fuel;
    }

    /// Counts the memory in use exactly; fails if the limit is as good as reached.
    #[cold]
    pub(crate) fn recount(&mut self) -> Result<(), Box<Problem>> {
        let closures = self.frames.iter().flat_map(|frame| frame.closure.captures());
        let live =
            memory::count(self.stack.as_slice().iter().chain(&self.registers).chain(closures));
        let waiting = (self.frames.len() * size_of::<Frame>()) as u64;
        let limit = self.limits.max_memory;
        if live + waiting > limit / 16 * 15 {
            return Err(Box::new(Problem::MemoryLimit(limit)));
        }
        self.allocated = live.saturating_sub(
            ((self.stack.len() + self.registers.len()) * size_of::<Value>()) as u64,
        );
        Ok(())
    }

    pub(crate) fn error(&self, problem: Problem) -> Box<Error> {
        let functions = &self.program.bytecode.functions;
        let (function, pc) = self.stopped_at;
        let mut origin = functions[function as usize].origins.get(pc).copied().unwrap_or_default();
        if let Problem::SurfaceResult(_) = problem {
            origin = Origin { span: functions[function as usize].span, ..Origin::default() };
        }
        let mut trace: Vec<TraceEntry> = Vec::new();
        for frame in &self.frames {
            let function = &functions[frame.closure.function as usize];
            let span = function.origins[frame.pc - 1].span;
            match trace.last_mut() {
                Some(last) if last.span == span => last.repeats += 1,
                _ => {
                    trace.push(TraceEntry { span, within: self.title(function, frame), repeats: 1 })
                }
            }
        }
        Box::new(Error { problem, origin, trace })
    }

    fn title(&self, function: &Function, frame: &Frame) -> String {
        match &function.name {
            Some(name) => format!("`{name}`"),
            None if frame.closure.function == self.program.bytecode.main() => {
                "the main program".to_owned()
            }
            None => "a function".to_owned(),
        }
    }
}
