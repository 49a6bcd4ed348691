//! A program ready to run: the bytecode, with its constants as values.

use std::collections::HashMap;
use std::sync::Arc;

use compiler::bytecode::{Constant, ConstantArray, Program};

use crate::value::{Array, Closure, Value};

/// Bytecode and its constants, shared by all threads that run it.
pub struct LoadedProgram {
    /// The bytecode.
    pub bytecode: Program,
    pub(crate) constants: Vec<Vec<Value>>,
}

impl LoadedProgram {
    /// Turns the constants into values; what is shared stays shared.
    #[must_use]
    pub fn new(bytecode: Program) -> Self {
        let mut loader = Loader { arrays: HashMap::new() };
        let load = |constants: &Vec<Constant>| constants.iter().map(|c| loader.value(c)).collect();
        let constants =
            bytecode.functions.iter().map(|function| &function.constants).map(load).collect();
        LoadedProgram { bytecode, constants }
    }
}

struct Loader {
    arrays: HashMap<*const ConstantArray, Arc<Array>>,
}

impl Loader {
    /// The recursion is bounded: constant arrays nest a few levels only.
    fn value(&mut self, constant: &Constant) -> Value {
        match constant {
            Constant::Bool(value) => Value::Bool(*value),
            Constant::Int(value) => Value::Int(*value),
            Constant::Real(value) => Value::Real(*value),
            Constant::Str(text) => Value::Str(text.clone()),
            Constant::Point(point) => Value::Point(*point),
            Constant::Function(function) => {
                Value::Closure(Arc::new(Closure::new(*function, Vec::new())))
            }
            Constant::Array(array) => {
                let address = Arc::as_ptr(array);
                if let Some(loaded) = self.arrays.get(&address) {
                    return Value::Array(loaded.clone());
                }
                let items = array.items().iter().map(|item| self.value(item)).collect();
                let loaded = Arc::new(Array::new(items));
                self.arrays.insert(address, loaded.clone());
                Value::Array(loaded)
            }
        }
    }
}
