//! A program ready to run: the bytecode, with its constants as the machine holds values.

use std::collections::HashMap;
use std::slice;
use std::sync::Arc;

use compiler::bytecode::{Constant, ConstantArray, Function, Program};
use compiler::scalar::Operands;

use crate::heap::Heap;
use crate::step::{self, Step};
use crate::value::Value;
use crate::word::{Tag, Word};

/// Bytecode and what the interpreter makes of it, shared by all threads that run it.
pub struct LoadedProgram {
    /// The bytecode.
    pub bytecode: Program,
    pub(crate) functions: Vec<LoadedFunction>,
    /// What every machine's heap begins with: the constants that do not fit into words.
    pub(crate) heap: Heap,
}

/// A function as the interpreter runs it.
pub(crate) struct LoadedFunction {
    pub(crate) steps: Vec<Step>,
    /// Where a further round begins, if the function calls itself in its place.
    n_first: usize,
    pub(crate) constants: Vec<Word>,
    /// Number of registers, and of registers and spill slots.
    pub(crate) n_registers: usize,
    pub(crate) n_used: usize,
}

impl LoadedFunction {
    /// The steps of a further round.
    #[inline(always)]
    pub(crate) fn round(&self) -> slice::Iter<'_, Step> {
        self.steps[self.n_first..].iter()
    }
}

impl LoadedProgram {
    /// Turns the constants into words; what is shared stays shared.
    #[must_use]
    pub fn new(bytecode: Program) -> Self {
        let mut loader = Loader::default();
        let functions =
            bytecode.functions.iter().map(|function| loader.function(function)).collect();
        LoadedProgram { bytecode, functions, heap: loader.heap }
    }
}

#[derive(Default)]
struct Loader {
    heap: Heap,
    arrays: HashMap<*const ConstantArray, Word>,
    functions: HashMap<u32, Word>,
}

impl Loader {
    fn function(&mut self, function: &Function) -> LoadedFunction {
        let constants: Vec<Word> = function.constants.iter().map(|k| self.word(k)).collect();
        let n_registers = function.n_registers as usize;
        let (steps, n_first) = step::translate(&function.code, &constants);
        LoadedFunction {
            steps,
            n_first,
            constants,
            n_registers,
            n_used: n_registers + function.n_slots as usize,
        }
    }

    /// The recursion is bounded: constant arrays nest a few levels only.
    fn word(&mut self, constant: &Constant) -> Word {
        match constant {
            Constant::Bool(value) => Word::from_bool(*value),
            Constant::Int(value) => Word::from_int(*value),
            Constant::Real(value) => Word::from_real(*value),
            Constant::Point(point) => Word::from_point(*point),
            Constant::Str(text) => self.heap.adopt(Tag::Str, Value::Str(text.clone()), 0),
            Constant::Function(function) => {
                *self.functions.entry(*function).or_insert_with(|| self.heap.closure(*function, 0))
            }
            Constant::Array(array) => {
                let address = Arc::as_ptr(array);
                if let Some(loaded) = self.arrays.get(&address) {
                    return *loaded;
                }
                let items: Vec<Word> = array.items().iter().map(|item| self.word(item)).collect();
                let loaded = self.heap.array(items.len());
                self.heap.items_mut(loaded.address()).copy_from_slice(&items);
                self.arrays.insert(address, loaded);
                loaded
            }
        }
    }
}
