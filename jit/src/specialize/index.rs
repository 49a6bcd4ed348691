//! `get` and `length`: indices that are known, and those that are not.

use crate::sir::{Inst, ROW_LEN, Table, Type, Val};
use crate::specialize::join::MAX_ALTERNATIVES;
use crate::specialize::{Run, STEP_VALUES, Specializer, State, Stop};
use crate::sym::{Elements, Num, Sym, TableView};

/// The tables of a shader have at most so many entries.
const MAX_TABLE: usize = 1 << 20;

impl Specializer<'_> {
    /// `r[target] = r[array] at r[index]`
    pub(super) fn get(
        &mut self,
        mut state: State,
        target: u8,
        array: u8,
        index: u8,
    ) -> Run<Option<State>> {
        if let Sym::Choice(tag, alternatives) = state.get(array) {
            let stop = Stop { depth: state.frames.len(), pc: Some(state.top().pc) };
            return self.each(state, array, tag, &alternatives, stop);
        }
        let index_sym = state.get(index);
        self.decided(&index_sym);
        let found = match (state.get(array), &index_sym) {
            (Sym::Array(elements), Sym::Int(Num::Const(index))) => {
                match usize::try_from(*index).ok().filter(|index| *index < elements.len()) {
                    Some(index) => elements.get(index),
                    None => return self.leave(),
                }
            }
            (Sym::Array(elements), Sym::Int(Num::Ssa(index))) => {
                return self.get_element(state, target, &elements, *index);
            }
            (Sym::Table(view), Sym::Int(index)) => {
                let index = self.int(*index);
                self.index_view(&view, index)
            }
            (_, Sym::Choice(..)) => return self.decline("an index may be of several types"),
            _ => return self.leave(),
        };
        state.set(target, found);
        Ok(Some(state))
    }

    /// An element by an index that is only known at run time.
    fn get_element(
        &mut self,
        mut state: State,
        target: u8,
        elements: &Elements,
        index: Val,
    ) -> Run<Option<State>> {
        if elements.len() == 0 {
            return self.leave();
        }
        if let Some(view) = self.table(elements)? {
            let found = self.index_view(&view, index);
            state.set(target, found);
            return Ok(Some(state));
        }
        if elements.len() > MAX_ALTERNATIVES {
            return self.decline(
                "it picks from a long array whose elements are not all numbers, or points",
            );
        }
        let tag = self.emit(Type::Int, Inst::Checked { index, length: elements.len() as u32 });
        let parts: Vec<Sym> = (0..elements.len()).map(|i| elements.get(i)).collect();
        let is_structure =
            |sym: &Sym| matches!(sym, Sym::Closure(..) | Sym::Array(_) | Sym::Table(_));
        if parts.iter().all(is_structure) {
            state.set(target, Sym::Choice(tag, parts.into()));
            return Ok(Some(state));
        }
        // Numbers that are not constant: a way for each, joined at once.
        let stop = Stop { depth: state.frames.len(), pc: Some(state.top().pc) };
        self.with_each(state, target, tag, &parts, stop)
    }

    /// The element of a view: a part of it, or a number or point.
    fn index_view(&mut self, view: &TableView, index: Val) -> Sym {
        let (length, inner) = view.lengths.split_first().expect("a view has an index to come");
        let index = self.emit(Type::Int, Inst::Checked { index, length: *length });
        let Table { ty, holds_points, .. } = self.tables[view.table as usize];
        let n_inner: u32 = inner.iter().product();
        let stride = if holds_points { n_inner * ROW_LEN as u32 } else { n_inner };
        let start = self.emit(Type::Int, Inst::Offset { offset: view.offset, index, stride });
        if !inner.is_empty() {
            return Sym::Table(TableView {
                table: view.table,
                lengths: inner.into(),
                offset: start,
            });
        }
        let mut entry = |column| self.emit(ty, Inst::Entry { table: view.table, start, column });
        match ty {
            Type::Real if holds_points => Sym::Point([0, 1, 2].map(|c| Num::Ssa(entry(c)))),
            Type::Real => Sym::Real(Num::Ssa(entry(0))),
            Type::Int => Sym::Int(Num::Ssa(entry(0))),
            Type::Bool => Sym::Bool(Num::Ssa(entry(0))),
        }
    }

    /// The whole of an array as a view, if it holds constant numbers or points of one type, or
    /// arrays of such that are equally long.
    fn table(&mut self, elements: &Elements) -> Run<Option<TableView>> {
        let offset = self.int(Num::Const(0));
        // The address of an array that stays where it is.
        let address = match elements {
            Elements::Known(array) => Some(std::sync::Arc::as_ptr(&array.0) as usize),
            Elements::Constant(array) => Some(std::sync::Arc::as_ptr(array) as usize),
            Elements::Parts(_) => None,
        };
        if let Some(view) = address.and_then(|address| self.views.get(&address)) {
            return Ok(Some(TableView { offset, ..view.clone() }));
        }
        let Some((lengths, leaves)) = self.flattened(elements)? else { return Ok(None) };
        let Some(table) = table(&leaves) else { return Ok(None) };
        let n_entries: usize = self.tables.iter().map(|table| table.entries().len()).sum();
        if n_entries + table.entries().len() > MAX_TABLE {
            return self.decline("its tables are too large");
        }
        let table = self.table_number(table);
        let view = TableView { table, lengths: lengths.into(), offset };
        if let Some(address) = address {
            self.views.insert(address, view.clone());
        }
        Ok(Some(view))
    }

    /// The lengths of arrays of arrays, and what is innermost, in order; `None` if arrays side by side
    /// differ in length, or are empty.
    fn flattened(&mut self, elements: &Elements) -> Run<Option<(Vec<u32>, Vec<Sym>)>> {
        let mut lengths = Vec::new();
        let mut level: Vec<Sym> = vec![Sym::Array(elements.clone())];
        while let Some(Sym::Array(first)) = level.first() {
            let length = first.len();
            let n_inner = length.saturating_mul(level.len());
            if length == 0 || n_inner > MAX_TABLE {
                return Ok(None);
            }
            self.take_steps(n_inner / STEP_VALUES)?;
            lengths.push(length as u32);
            let mut inner = Vec::with_capacity(n_inner);
            for sym in &level {
                let Sym::Array(elements) = sym else { return Ok(None) };
                if elements.len() != length {
                    return Ok(None);
                }
                inner.extend((0..length).map(|index| elements.get(index)));
            }
            level = inner;
        }
        Ok(Some((lengths, level)))
    }

    /// The number of a table; tables with the same entries share one.
    fn table_number(&mut self, table: Table) -> u32 {
        let known = self.tables.iter().position(|known| *known == table);
        let number = known.unwrap_or(self.tables.len());
        if known.is_none() {
            self.tables.push(table);
        }
        number as u32
    }

    /// `r[target] =` number of elements of `r[array]`
    pub(super) fn length(&mut self, mut state: State, target: u8, array: u8) -> Run<Option<State>> {
        let length = match state.get(array) {
            Sym::Array(elements) => elements.len(),
            Sym::Table(view) => view.lengths[0] as usize,
            Sym::Choice(tag, alternatives) => {
                let stop = Stop { depth: state.frames.len(), pc: Some(state.top().pc) };
                return self.each(state, array, tag, &alternatives, stop);
            }
            _ => return self.leave(),
        };
        state.set(target, Sym::Int(Num::Const(length as i64)));
        Ok(Some(state))
    }
}

/// Constant numbers of one type, or points, as a table.
fn table(leaves: &[Sym]) -> Option<Table> {
    let (ty, holds_points) = match leaves.first()? {
        Sym::Real(_) => (Type::Real, false),
        Sym::Int(_) => (Type::Int, false),
        Sym::Bool(_) => (Type::Bool, false),
        Sym::Point(_) => (Type::Real, true),
        _ => return None,
    };
    let number = |leaf: &Sym| match (leaf, ty) {
        (Sym::Real(Num::Const(x)), Type::Real) => Some(x.to_bits()),
        (Sym::Int(Num::Const(x)), Type::Int) => Some(*x as u64),
        (Sym::Bool(Num::Const(x)), Type::Bool) => Some(u64::from(*x)),
        _ => None,
    };
    let point = |leaf: &Sym| match leaf {
        Sym::Point([Num::Const(x), Num::Const(y), Num::Const(z)]) => {
            Some([x.to_bits(), y.to_bits(), z.to_bits(), 0])
        }
        _ => None,
    };
    let rows = if holds_points {
        leaves.iter().map(point).collect::<Option<_>>()?
    } else {
        let mut numbers: Vec<u64> = leaves.iter().map(number).collect::<Option<_>>()?;
        numbers.resize(numbers.len().next_multiple_of(ROW_LEN), 0);
        numbers.as_chunks().0.to_vec()
    };
    Some(Table { ty, holds_points, rows })
}
