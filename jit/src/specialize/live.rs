//! Which registers are still to be read.

use std::rc::Rc;

use compiler::flow::{self, Set};

use crate::specialize::Specializer;

impl Specializer<'_> {
    /// For each instruction of a function, the registers that may be read from there on before they
    /// are written.
    pub(super) fn live_registers(&mut self, function: u32) -> Rc<Vec<Set>> {
        if let Some(known) = self.live_registers.get(&function) {
            return known.clone();
        }
        let functions = &self.program.functions;
        let live = Rc::new(flow::live_registers(functions, self.function(function)));
        self.live_registers.insert(function, live.clone());
        live
    }
}
