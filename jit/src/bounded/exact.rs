//! Which values depend on the point.
//!
//! All are taken to be the same at all points until they are found to be computed from one that is
//! not; loops and routines are gone through until nothing new is found. Only reals can depend on the
//! point: where an integer or boolean would, the bounded shader leaves. Values that nobody uses are
//! of no interest.

use crate::sir::{Body, Inst, Shader, Term, Type, U, V, Val};

/// The values of a shader that depend on the point; its bodies are numbered as
/// [`Shader::bodies`] gives them.
pub(super) struct Inexact {
    /// By body.
    pub(super) values: Vec<Vec<bool>>,
    /// Of what routines return, by routine.
    pub(super) results: Vec<Vec<bool>>,
    live: Vec<Vec<bool>>,
    has_changed: bool,
}

impl Inexact {
    pub(super) fn new(shader: &Shader, is_unknown: [bool; 2]) -> Self {
        let mut inexact = Inexact {
            values: shader.bodies().map(|body| vec![false; body.types.len()]).collect(),
            results: shader.routines.iter().map(|r| vec![false; r.results.len()]).collect(),
            live: shader.bodies().map(Body::live).collect(),
            has_changed: false,
        };
        for (argument, is_unknown) in [U, V].into_iter().zip(is_unknown) {
            inexact.mark_if(is_unknown, shader.routines.len(), argument);
        }
        loop {
            inexact.has_changed = false;
            for (number, body) in shader.bodies().enumerate() {
                inexact.pass(number, body);
            }
            if !inexact.has_changed {
                return inexact;
            }
        }
    }

    fn mark_if(&mut self, condition: bool, number: usize, val: Val) {
        let index = val.0 as usize;
        if condition && self.live[number][index] && !self.values[number][index] {
            self.values[number][index] = true;
            self.has_changed = true;
        }
    }

    fn pass(&mut self, number: usize, body: &Body) {
        let is_inexact = |this: &Self, val: Val| this.values[number][val.0 as usize];
        for block in &body.blocks {
            for (val, inst, _) in &block.insts {
                if let (Type::Real, Inst::Scalar(_, operands)) = (body.type_of(*val), inst) {
                    let depends = operands.iter().any(|operand| is_inexact(self, *operand));
                    self.mark_if(depends, number, *val);
                }
            }
            match &block.term {
                Some((Term::Jump(target, args), _)) => {
                    let params = &body.blocks[target.0 as usize].params;
                    for (&param, &arg) in params.iter().zip(args) {
                        self.mark_if(is_inexact(self, arg), number, param);
                    }
                }
                Some((Term::Call(routine, args, next), _)) => {
                    let routine = *routine as usize;
                    for (index, &arg) in args.iter().enumerate() {
                        self.mark_if(is_inexact(self, arg), routine, Val(index as u32));
                    }
                    // Each result has its parameter, used or not, with or without a radius.
                    let params = &body.blocks[next.0 as usize].params;
                    for (index, param) in params.iter().enumerate() {
                        self.values[number][param.0 as usize] |= self.results[routine][index];
                    }
                }
                // The main body has no results here: those of a shader all have a radius.
                Some((Term::Return(vals), _)) if number < self.results.len() => {
                    for (index, &val) in vals.iter().enumerate() {
                        let was = self.results[number][index];
                        self.results[number][index] |= is_inexact(self, val);
                        self.has_changed |= self.results[number][index] != was;
                    }
                }
                _ => {}
            }
        }
    }
}
