//! Where the ways of a fork meet.

use std::cell::Cell;
use std::rc::Rc;

use crate::sir::{Block, Inst, Term, Type, Val};
use crate::specialize::{Frame, Run, STEP_VALUES, Specializer, State};
use crate::sym::{Captures, Elements, MAX_COMPARED, Num, Sym, TableView};

/// A choice has at most so many alternatives.
pub(super) const MAX_ALTERNATIVES: usize = 64;

/// A scalar of any type.
#[derive(Clone, Copy)]
pub(super) enum Scalar {
    Real(Num<f64>),
    Int(Num<i64>),
    Bool(Num<bool>),
}

/// A joining of several ways: the block where they meet, and what each brings along.
struct Meeting {
    block: Block,
    /// The last block of each way.
    ways: Vec<Block>,
    /// Values from this one on are defined within the ways.
    first_inner: Val,
    args: Vec<Vec<Scalar>>,
}

impl Specializer<'_> {
    /// Joins the ends of ways; `None` if there are none. Values from `first_inner` on are defined
    /// within the ways.
    pub(super) fn join(
        &mut self,
        mut ends: Vec<(Block, State)>,
        first_inner: Val,
    ) -> Run<Option<State>> {
        if ends.len() < 2 {
            return Ok(ends.pop().map(|(block, state)| {
                self.work.block = block;
                state
            }));
        }
        self.check_size()?;
        let mut meeting = Meeting {
            block: self.new_block(),
            ways: ends.iter().map(|(block, _)| *block).collect(),
            first_inner,
            args: vec![Vec::new(); ends.len()],
        };
        let joined = self.join_states(&mut meeting, &ends)?;
        for (&block, args) in meeting.ways.iter().zip(&meeting.args) {
            self.work.block = block;
            self.site = self.last_site(block);
            let args = args.iter().map(|scalar| self.materialize(*scalar)).collect();
            self.end(block, Term::Jump(meeting.block, args));
        }
        self.work.block = meeting.block;
        Ok(Some(joined))
    }

    fn join_states(&mut self, meeting: &mut Meeting, ends: &[(Block, State)]) -> Run<State> {
        let first = &ends[0].1;
        let alike = |state: &State| {
            state.stack.len() == first.stack.len()
                && state.floor == first.floor
                && state.floors == first.floors
        };
        if !ends.iter().all(|(_, state)| alike(state)) {
            return self.decline("the sides of a condition leave different numbers of values");
        }
        let mut joined = first.clone();
        for index in 0..first.stack.len() {
            let syms: Vec<&Sym> = ends.iter().map(|(_, state)| &state.stack[index]).collect();
            joined.stack[index] = self.join_syms(meeting, &syms)?;
        }
        if let Some(frame) = first.frames.last() {
            let frame = Frame {
                registers: self.join_registers(meeting, frame, ends)?,
                ..Frame::clone(frame)
            };
            *joined.frames.last_mut().expect("as many as the first has") = Rc::new(frame);
        }
        Ok(joined)
    }

    /// The registers that are still to be read. The frames below have not changed.
    fn join_registers(
        &mut self,
        meeting: &mut Meeting,
        frame: &Frame,
        ends: &[(Block, State)],
    ) -> Run<Vec<Sym>> {
        let live = self.live_registers(frame.function)[frame.pc];
        let n_registers = self.function(frame.function).n_registers as usize;
        let mut registers = vec![Sym::Dead; frame.registers.len()];
        for (index, register) in registers.iter_mut().enumerate() {
            // Spill slots lie behind the registers and may be read until the function returns.
            let is_live = index >= n_registers || live[index / 64] >> (index % 64) & 1 == 1;
            let of_ways =
                ends.iter().filter_map(|(_, state)| Some(&state.frames.last()?.registers[index]));
            if is_live {
                *register = self.join_syms(meeting, &of_ways.collect::<Vec<_>>())?;
            }
        }
        Ok(registers)
    }

    /// One value in place of those of all ways: what is the same stays, scalars become parameters,
    /// structures are joined part by part, and what is too different becomes a choice.
    fn join_syms(&mut self, meeting: &mut Meeting, syms: &[&Sym]) -> Run<Sym> {
        let first = syms[0];
        let left = Cell::new(MAX_COMPARED);
        let are_same = syms[1..].iter().all(|sym| first.is_same_within(sym, &left));
        self.take_steps(1 + (MAX_COMPARED - left.get()) / STEP_VALUES)?;
        if are_same {
            return Ok(first.clone());
        }
        if syms.iter().any(|sym| matches!(sym, Sym::Dead)) {
            return Ok(Sym::Dead);
        }
        if let Some(scalars) = all(syms, scalar) {
            let same_type = scalars
                .iter()
                .all(|s| std::mem::discriminant(s) == std::mem::discriminant(&scalars[0]));
            if same_type {
                return Ok(self.join_scalars(meeting, &scalars));
            }
        }
        if let Some(points) =
            all(syms, |sym| if let Sym::Point(point) = sym { Some(*point) } else { None })
        {
            let component = |specializer: &mut Self, meeting: &mut Meeting, i: usize| {
                let same =
                    points[1..].iter().all(|point| crate::sym::same_real(&point[i], &points[0][i]));
                if same {
                    return points[0][i];
                }
                let scalars: Vec<Scalar> =
                    points.iter().map(|point| Scalar::Real(point[i])).collect();
                match specializer.join_scalars(meeting, &scalars) {
                    Sym::Real(num) => num,
                    _ => unreachable!("reals join to a real"),
                }
            };
            let x = component(self, meeting, 0);
            let y = component(self, meeting, 1);
            let z = component(self, meeting, 2);
            return Ok(Sym::Point([x, y, z]));
        }
        if let Some((shell, n_parts)) = common_shell(syms) {
            let mut parts = Vec::with_capacity(n_parts);
            for index in 0..n_parts {
                let of_ways: Vec<Sym> = syms.iter().map(|sym| part(sym, index)).collect();
                parts.push(self.join_syms(meeting, &of_ways.iter().collect::<Vec<_>>())?);
            }
            return Ok(shell.with(parts.into()));
        }
        self.choice(meeting, syms)
    }

    fn join_scalars(&mut self, meeting: &mut Meeting, scalars: &[Scalar]) -> Sym {
        let ty = scalars[0].ty();
        let param = self.param(meeting.block, ty);
        for (args, scalar) in meeting.args.iter_mut().zip(scalars) {
            args.push(*scalar);
        }
        sym_of(ty, param)
    }

    /// The alternatives of all ways in a row, and a parameter that tells which one is meant.
    fn choice(&mut self, meeting: &mut Meeting, syms: &[&Sym]) -> Run<Sym> {
        let mut alternatives: Vec<Sym> = Vec::new();
        let mut tags = Vec::new();
        for (way, sym) in syms.iter().enumerate() {
            let base = alternatives.len() as i64;
            match sym {
                Sym::Choice(tag, of_way) => {
                    let tag = if base == 0 { *tag } else { self.shifted(meeting, way, *tag, base) };
                    tags.push(Scalar::Int(Num::Ssa(tag)));
                    let carried = of_way.iter().map(|sym| self.carried(meeting, way, sym));
                    alternatives.extend(carried.collect::<Vec<_>>());
                }
                _ => {
                    let mut known = None;
                    for (index, alternative) in alternatives.iter().enumerate() {
                        if known.is_none() && self.is_same(alternative, sym)? {
                            known = Some(index);
                        }
                    }
                    tags.push(Scalar::Int(Num::Const(known.map_or(base, |index| index as i64))));
                    if known.is_none() {
                        alternatives.push(self.carried(meeting, way, sym));
                    }
                }
            }
        }
        if alternatives.len() > MAX_ALTERNATIVES {
            return self.decline("it chooses among too many values");
        }
        let Sym::Int(Num::Ssa(tag)) = self.join_scalars(meeting, &tags) else {
            unreachable!("the joined tag is a parameter")
        };
        Ok(Sym::Choice(tag, alternatives.into()))
    }

    /// An alternative that is only meant if a certain way was taken: what it holds of values defined
    /// on that way is carried over by parameters, for which the other ways bring anything.
    fn carried(&mut self, meeting: &mut Meeting, way: usize, sym: &Sym) -> Sym {
        if self.take_steps(1).is_err() {
            // The run ends at its next step.
            return sym.clone();
        }
        match sym {
            Sym::Real(num) => Sym::Real(self.carried_real(meeting, way, *num)),
            Sym::Int(Num::Ssa(val)) => {
                Sym::Int(Num::Ssa(self.carried_val(meeting, way, Type::Int, *val)))
            }
            Sym::Bool(Num::Ssa(val)) => {
                Sym::Bool(Num::Ssa(self.carried_val(meeting, way, Type::Bool, *val)))
            }
            Sym::Point(point) => Sym::Point(point.map(|num| self.carried_real(meeting, way, num))),
            Sym::Closure(function, Captures::Parts(parts)) => {
                let parts = parts.iter().map(|part| self.carried(meeting, way, part)).collect();
                Sym::Closure(*function, Captures::Parts(parts))
            }
            Sym::Array(Elements::Parts(parts)) => {
                let parts = parts.iter().map(|part| self.carried(meeting, way, part)).collect();
                Sym::Array(Elements::Parts(parts))
            }
            Sym::Table(view) => {
                let offset = self.carried_val(meeting, way, Type::Int, view.offset);
                Sym::Table(TableView { offset, ..view.clone() })
            }
            Sym::Choice(tag, alternatives) => {
                let tag = self.carried_val(meeting, way, Type::Int, *tag);
                let alternatives =
                    alternatives.iter().map(|sym| self.carried(meeting, way, sym)).collect();
                Sym::Choice(tag, alternatives)
            }
            // Constants, what exists outside the shader, and what nobody reads.
            _ => sym.clone(),
        }
    }

    fn carried_real(&mut self, meeting: &mut Meeting, way: usize, num: Num<f64>) -> Num<f64> {
        match num {
            Num::Const(_) => num,
            Num::Ssa(val) => Num::Ssa(self.carried_val(meeting, way, Type::Real, val)),
        }
    }

    fn carried_val(&mut self, meeting: &mut Meeting, way: usize, ty: Type, val: Val) -> Val {
        if val.0 < meeting.first_inner.0 {
            return val;
        }
        let (carried, anything) = match ty {
            Type::Real => (Scalar::Real(Num::Ssa(val)), Scalar::Real(Num::Const(0.0))),
            Type::Int => (Scalar::Int(Num::Ssa(val)), Scalar::Int(Num::Const(0))),
            Type::Bool => (Scalar::Bool(Num::Ssa(val)), Scalar::Bool(Num::Const(false))),
        };
        for (of_way, args) in meeting.args.iter_mut().enumerate() {
            args.push(if of_way == way { carried } else { anything });
        }
        self.param(meeting.block, ty)
    }

    /// `tag + base`, computed at the end of a way.
    fn shifted(&mut self, meeting: &Meeting, way: usize, tag: Val, base: i64) -> Val {
        self.work.block = meeting.ways[way];
        let base = self.int(Num::Const(base));
        self.emit(Type::Int, Inst::Offset { offset: tag, index: base, stride: 1 })
    }

    pub(super) fn materialize(&mut self, scalar: Scalar) -> Val {
        match scalar {
            Scalar::Real(num) => self.real(num),
            Scalar::Int(num) => self.int(num),
            Scalar::Bool(num) => self.bool(num),
        }
    }
}

impl Scalar {
    pub(super) fn sym(self) -> Sym {
        match self {
            Scalar::Real(num) => Sym::Real(num),
            Scalar::Int(num) => Sym::Int(num),
            Scalar::Bool(num) => Sym::Bool(num),
        }
    }

    pub(super) fn ty(self) -> Type {
        match self {
            Scalar::Real(_) => Type::Real,
            Scalar::Int(_) => Type::Int,
            Scalar::Bool(_) => Type::Bool,
        }
    }
}

pub(super) fn sym_of(ty: Type, val: Val) -> Sym {
    match ty {
        Type::Real => Sym::Real(Num::Ssa(val)),
        Type::Int => Sym::Int(Num::Ssa(val)),
        Type::Bool => Sym::Bool(Num::Ssa(val)),
    }
}

pub(super) fn scalar(sym: &Sym) -> Option<Scalar> {
    match sym {
        Sym::Real(num) => Some(Scalar::Real(*num)),
        Sym::Int(num) => Some(Scalar::Int(*num)),
        Sym::Bool(num) => Some(Scalar::Bool(*num)),
        _ => None,
    }
}

fn all<T>(syms: &[&Sym], f: impl Fn(&Sym) -> Option<T>) -> Option<Vec<T>> {
    syms.iter().map(|sym| f(sym)).collect()
}

/// A structure without its parts.
pub(super) enum Shell {
    Closure(u32),
    Array,
}

impl Shell {
    pub(super) fn of(sym: &Sym) -> Option<(Shell, usize)> {
        match sym {
            Sym::Closure(function, captures) => Some((Shell::Closure(*function), captures.len())),
            Sym::Array(elements) => Some((Shell::Array, elements.len())),
            _ => None,
        }
    }

    pub(super) fn with(self, parts: Rc<[Sym]>) -> Sym {
        match self {
            Shell::Closure(function) => Sym::Closure(function, Captures::Parts(parts)),
            Shell::Array => Sym::Array(Elements::Parts(parts)),
        }
    }

    fn is_same(&self, other: &Shell) -> bool {
        match (self, other) {
            (Shell::Closure(f), Shell::Closure(g)) => f == g,
            (Shell::Array, Shell::Array) => true,
            _ => false,
        }
    }
}

/// The structure that all values have in common, if they do, and its number of parts.
pub(super) fn common_shell(syms: &[&Sym]) -> Option<(Shell, usize)> {
    let (shell, n_parts) = Shell::of(syms[0])?;
    let fits =
        |sym: &&Sym| Shell::of(sym).is_some_and(|(other, n)| shell.is_same(&other) && n == n_parts);
    // Joining long arrays part by part would make a parameter of each part.
    (n_parts <= MAX_ALTERNATIVES && syms[1..].iter().all(fits)).then_some((shell, n_parts))
}

pub(super) fn part(sym: &Sym, index: usize) -> Sym {
    match sym {
        Sym::Closure(_, captures) => captures.get(index),
        Sym::Array(elements) => elements.get(index),
        _ => Sym::Dead,
    }
}
