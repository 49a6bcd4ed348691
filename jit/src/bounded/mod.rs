//! Bounded shaders: from a shader another one, that takes u and v with radii and returns each of its
//! six results with a radius.
//!
//! It computes what the plain shader computes at the centre of a box of points, and beside each real
//! that depends on the point a *radius*, which bounds how far the same real of the plain shader, at
//! any point of the box that doubles can name, lies from it. Integers, booleans and reals that do not
//! depend on the point have none: they are the same at all points. This is so because the bounded
//! shader leaves where a decision (a comparison, a whole part, whether a root exists) might come out
//! differently somewhere in the box: all points take the same way through the code, round by round.
//!
//! What holds of each pair at run time: if the radius is finite, then so is the centre, and the real
//! of the plain shader, at whichever point of the box, is a finite number no further from the centre
//! than the radius. If the radius is infinite or NaN, nothing is known. `operators` says how this is
//! kept up.

mod exact;
mod operators;

use std::collections::HashMap;

use crate::bounded::exact::Inexact;
use crate::sir::{
    Block, BlockData, Body, Inst, Routine, Shader, Site, Term, Type, U, V, Val, Version,
};

/// What stands for a value of the plain shader.
#[derive(Clone, Copy)]
struct Pair {
    /// The value itself, at the centre.
    centre: Val,
    /// None if it is the same at all points.
    radius: Option<Val>,
}

/// The bounded version of a shader for points of which u, v or both are not known; it ignores the
/// radius of what is known.
pub(crate) fn bounded(shader: &Shader, is_unknown: [bool; 2]) -> Shader {
    let inexact = Inexact::new(shader, is_unknown);
    let routines = shader.routines.iter().enumerate().map(|(number, routine)| {
        let mut bounding = Bounding::new(&routine.body, &inexact, number);
        for index in 0..routine.body.n_params as u32 {
            bounding.param(Val(index));
        }
        bounding.into.n_params = bounding.into.types.len();
        let results = routine.results.iter().zip(&inexact.results[number]);
        let with_radii = results.flat_map(|(ty, &is_inexact)| {
            [Some(*ty), is_inexact.then_some(Type::Real)].into_iter().flatten()
        });
        Routine { results: with_radii.collect(), body: bounding.body() }
    });
    Shader {
        routines: routines.collect(),
        main: main(shader, &inexact),
        tables: shader.tables.clone(),
        n_uniforms: shader.n_uniforms,
        functions: shader.functions.clone(),
        version: Version::Bounded,
    }
}

/// The main body: its parameters are those of the plain one, and the radii of u and v.
fn main(shader: &Shader, inexact: &Inexact) -> Body {
    let mut bounding = Bounding::new(&shader.main, inexact, shader.routines.len());
    for index in 0..shader.main.n_params as u32 {
        let centre = bounding.new_val(shader.main.type_of(Val(index)));
        bounding.pairs[index as usize] = Some(Pair { centre, radius: None });
    }
    for argument in [U, V] {
        let radius = bounding.new_val(Type::Real);
        if bounding.is_inexact(argument) {
            bounding.pairs[argument.0 as usize] =
                Some(Pair { centre: argument, radius: Some(radius) });
        }
    }
    bounding.into.n_params = bounding.into.types.len();
    bounding.body()
}

/// The making of a body.
struct Bounding<'b> {
    from: &'b Body,
    inexact: &'b Inexact,
    number: usize,
    live: Vec<bool>,
    into: Body,
    /// What stands for its values.
    pairs: Vec<Option<Pair>>,
    /// Where instructions go, and what they are for.
    block: Block,
    site: Site,
    /// The constants of this block, by their bits.
    constants: HashMap<u64, Val>,
}

impl<'b> Bounding<'b> {
    fn new(from: &'b Body, inexact: &'b Inexact, number: usize) -> Self {
        let mut into = Body::new(Vec::new());
        into.costs = from.costs;
        Bounding {
            from,
            inexact,
            number,
            live: from.live(),
            into,
            pairs: vec![None; from.types.len()],
            block: Block(0),
            site: Site::default(),
            constants: HashMap::new(),
        }
    }

    /// The new body, whose parameters are there.
    fn body(mut self) -> Body {
        for block in &self.from.blocks {
            let mut params = Vec::new();
            for &param in &block.params {
                let pair = self.param(param);
                params.extend([Some(pair.centre), pair.radius].into_iter().flatten());
            }
            let BlockData { site, is_loop, .. } = *block;
            self.into.blocks.push(BlockData {
                params,
                insts: Vec::new(),
                term: None,
                site,
                is_loop,
            });
        }
        for (index, block) in self.from.blocks.iter().enumerate() {
            self.block = Block(index as u32);
            self.constants.clear();
            for (val, inst, site) in &block.insts {
                self.site = *site;
                self.pairs[val.0 as usize] = Some(self.inst(*val, inst));
            }
            if let Some((term, site)) = &block.term {
                self.site = *site;
                let term = self.term(term);
                self.into.blocks[index].term = Some((term, *site));
            }
        }
        self.into
    }

    fn new_val(&mut self, ty: Type) -> Val {
        self.into.types.push(ty);
        Val(self.into.types.len() as u32 - 1)
    }

    /// Whether a value of the plain body depends on the point.
    fn is_inexact(&self, val: Val) -> bool {
        self.inexact.values[self.number][val.0 as usize]
    }

    /// What stands for a parameter, with a radius behind it if it needs one.
    fn param(&mut self, param: Val) -> Pair {
        let centre = self.new_val(self.from.type_of(param));
        let radius = self.is_inexact(param).then(|| self.new_val(Type::Real));
        let pair = Pair { centre, radius };
        self.pairs[param.0 as usize] = Some(pair);
        pair
    }

    fn emit(&mut self, ty: Type, inst: Inst) -> Val {
        let val = self.new_val(ty);
        let insts = &mut self.into.blocks[self.block.0 as usize].insts;
        insts.push((val, inst, self.site));
        val
    }

    fn real(&mut self, value: f64) -> Val {
        if let Some(val) = self.constants.get(&value.to_bits()) {
            return *val;
        }
        let val = self.emit(Type::Real, Inst::Real(value));
        self.constants.insert(value.to_bits(), val);
        val
    }

    fn pair(&self, val: Val) -> Pair {
        self.pairs[val.0 as usize].expect("definitions come before uses")
    }

    fn centre(&self, val: Val) -> Val {
        self.pair(val).centre
    }

    /// The radius, 0 if it has none.
    fn radius(&mut self, val: Val) -> Val {
        self.pair(val).radius.unwrap_or_else(|| self.real(0.0))
    }

    fn inst(&mut self, val: Val, inst: &Inst) -> Pair {
        let ty = self.from.type_of(val);
        let inst = match *inst {
            // What nobody uses decides nothing.
            Inst::Scalar(op, operands) if self.live[val.0 as usize] => {
                return self.scalar(op, operands.map(|operand| self.pair(operand)), ty);
            }
            Inst::Scalar(op, operands) => Inst::Scalar(op, operands.map(|val| self.centre(val))),
            Inst::IntOfBool(a) => Inst::IntOfBool(self.centre(a)),
            Inst::Checked { index, length } => Inst::Checked { index: self.centre(index), length },
            Inst::Offset { offset, index, stride } => {
                Inst::Offset { offset: self.centre(offset), index: self.centre(index), stride }
            }
            Inst::Entry { table, start, column } => {
                Inst::Entry { table, start: self.centre(start), column }
            }
            Inst::Real(_) | Inst::Int(_) | Inst::Bool(_) => *inst,
            Inst::Abs(_) | Inst::Require(..) | Inst::Decided(_) => {
                unreachable!("plain shaders have none")
            }
        };
        Pair { centre: self.emit(ty, inst), radius: None }
    }

    fn term(&mut self, term: &Term) -> Term {
        let inexact = self.inexact;
        match term {
            Term::Jump(target, args) => {
                let params = &self.from.blocks[target.0 as usize].params;
                let is_inexact: Vec<bool> =
                    params.iter().map(|param| self.is_inexact(*param)).collect();
                Term::Jump(*target, self.interleaved(args, &is_inexact))
            }
            Term::Branch(condition, ways) => Term::Branch(self.centre(*condition), *ways),
            Term::Switch(tag, ways) => Term::Switch(self.centre(*tag), ways.clone()),
            Term::Call(routine, args, next) => {
                let is_inexact = &inexact.values[*routine as usize];
                Term::Call(*routine, self.interleaved(args, is_inexact), *next)
            }
            Term::Return(vals) => Term::Return(match inexact.results.get(self.number) {
                Some(is_inexact) => self.interleaved(vals, is_inexact),
                None => {
                    let centres: Vec<Val> = vals.iter().map(|val| self.centre(*val)).collect();
                    let radii: Vec<Val> = vals.iter().map(|val| self.radius(*val)).collect();
                    [centres, radii].concat()
                }
            }),
            Term::Leave => Term::Leave,
        }
    }

    /// What is passed for values, where those that are wanted with their radius have it behind them.
    fn interleaved(&mut self, vals: &[Val], is_inexact: &[bool]) -> Vec<Val> {
        let mut passed = Vec::new();
        for (&val, &is_inexact) in vals.iter().zip(is_inexact) {
            passed.push(self.centre(val));
            if is_inexact {
                passed.push(self.radius(val));
            }
        }
        passed
    }
}
