//! Loops: the heads where their rounds start, and the jumps back to them.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use crate::sir::{Block, Term, Val};
use crate::specialize::join::{Scalar, Shell, common_shell, part, scalar, sym_of};
use crate::specialize::path::{CAPTURES, Path, STACK, any_within};
use crate::specialize::{Abort, Entry, Head, Run, STEP_VALUES, Specializer, State};
use crate::sym::{Captures, MAX_COMPARED, Sym};

/// A round's values may differ from those before in so many parts.
const MAX_DIFFERENT: usize = 1024;

/// So many parts of all values of a round are compared, which counts as a hundredth of all steps.
const MAX_COMPARED_OF_ROUND: usize = 16 * MAX_COMPARED;

/// What a loop's head is made with, or what a round brings along.
struct Round<'l> {
    varying: &'l BTreeSet<Path>,
    values: BTreeMap<Path, Scalar>,
    newly_varying: Vec<Path>,
    has_other_shape: bool,
    n_different: usize,
    /// So many parts are left to be compared.
    left: usize,
}

impl Specializer<'_> {
    /// Starts a loop here if the entry with this number is known to be one's head. Returns the
    /// captured values as the loop sees them.
    pub(super) fn loop_head(
        &mut self,
        state: &mut State,
        captures: Captures,
        ordinal: usize,
    ) -> Run<(Captures, Rc<Head>)> {
        self.take_steps((state.stack.len() + captures.len()) / STEP_VALUES)?;
        let mut known: Vec<Sym> = (0..captures.len()).map(|index| captures.get(index)).collect();
        let Some(varying) = self.work.loops.get(&ordinal).cloned() else {
            let head = Head {
                block: None,
                params: Vec::new(),
                stack: state.stack.clone(),
                captures: known,
            };
            return Ok((captures, Rc::new(head)));
        };
        let block = self.new_block();
        self.work.body.blocks[block.0 as usize].is_loop = true;
        let mut params = Vec::new();
        let mut args = Vec::new();
        for (root, syms) in [(STACK, &mut state.stack), (CAPTURES, &mut known)] {
            for (index, sym) in syms.iter_mut().enumerate() {
                let mut path = vec![root, index as u32];
                *sym = self.generalized(sym, &mut path, &varying, block, &mut params, &mut args);
            }
        }
        let args = args.into_iter().map(|scalar| self.materialize(scalar)).collect();
        self.end(self.work.block, Term::Jump(block, args));
        self.work.block = block;
        let head = Head {
            block: Some(block),
            params,
            stack: state.stack.clone(),
            captures: known.clone(),
        };
        Ok((Captures::Parts(known.into()), Rc::new(head)))
    }

    /// A value with parameters in place of the scalars that vary.
    fn generalized(
        &mut self,
        sym: &Sym,
        path: &mut Path,
        varying: &BTreeSet<Path>,
        block: Block,
        params: &mut Vec<(Path, Val)>,
        args: &mut Vec<Scalar>,
    ) -> Sym {
        if !any_within(varying, path) {
            return sym.clone();
        }
        if let Some(scalar) = scalar(sym) {
            let param = self.param(block, scalar.ty());
            params.push((path.clone(), param));
            args.push(scalar);
            return sym_of(scalar.ty(), param);
        }
        let mut of_part = |specializer: &mut Self, index: usize, part: &Sym| {
            path.push(index as u32);
            let general = specializer.generalized(part, path, varying, block, params, args);
            path.pop();
            general
        };
        if let Sym::Point(point) = sym {
            let parts =
                [0, 1, 2].map(|index| match of_part(self, index, &Sym::Real(point[index])) {
                    Sym::Real(num) => num,
                    _ => point[index],
                });
            return Sym::Point(parts);
        }
        let Some((shell, n_parts)) = Shell::of(sym) else { return sym.clone() };
        let parts: Vec<Sym> =
            (0..n_parts).map(|index| of_part(self, index, &part(sym, index))).collect();
        shell.with(parts.into())
    }

    /// Ends this way with a jump back to where `entry` was entered, for a further round.
    pub(super) fn next_round(
        &mut self,
        state: &State,
        entry: &Entry,
        captures: &Captures,
    ) -> Run<Option<State>> {
        let head = entry.head.clone();
        if state.stack.len() != head.stack.len() || captures.len() != head.captures.len() {
            return self.decline("its loop leaves more or fewer values with each round");
        }
        let varying = self.work.loops.get(&entry.ordinal).cloned().unwrap_or_default();
        let mut round = Round {
            varying: &varying,
            values: BTreeMap::new(),
            newly_varying: Vec::new(),
            has_other_shape: false,
            n_different: 0,
            left: MAX_COMPARED_OF_ROUND,
        };
        for (index, (old, new)) in head.stack.iter().zip(&state.stack).enumerate() {
            round.compare(old, new, &mut vec![STACK, index as u32]);
        }
        for (index, old) in head.captures.iter().enumerate() {
            round.compare(old, &captures.get(index), &mut vec![CAPTURES, index as u32]);
        }
        let Round { values, newly_varying, has_other_shape, n_different, left, .. } = round;
        self.take_steps((MAX_COMPARED_OF_ROUND - left + n_different) / STEP_VALUES)?;
        if has_other_shape {
            return self.decline("its loop changes the shape or the code of a value");
        }
        if !newly_varying.is_empty() {
            // What was found for later entries may not fit the next run.
            self.work.loops.retain(|ordinal, _| *ordinal <= entry.ordinal);
            self.work.loops.entry(entry.ordinal).or_default().extend(newly_varying);
            return Err(Abort::Restart);
        }
        let Some(block) = head.block else {
            // Nothing changes: it never ends, and the interpreter says so.
            return self.leave();
        };
        let scalars: Option<Vec<Scalar>> =
            head.params.iter().map(|(path, _)| values.get(path).copied()).collect();
        let Some(scalars) = scalars else {
            return self.decline("its loop changes the shape of a value");
        };
        let args = scalars.into_iter().map(|scalar| self.materialize(scalar)).collect();
        self.end(self.work.block, Term::Jump(block, args));
        Ok(None)
    }
}

impl Round<'_> {
    /// Compares a value with that of the first round: scalars at varying places are noted, all
    /// others must be the same.
    fn compare(&mut self, old: &Sym, new: &Sym, path: &mut Path) {
        if self.has_other_shape || !any_within(self.varying, path) && self.is_same(old, new) {
            return;
        }
        self.n_different += 1;
        if self.n_different > MAX_DIFFERENT {
            self.has_other_shape = true;
            return;
        }
        if let (Some(before), Some(now)) = (scalar(old), scalar(new)) {
            if std::mem::discriminant(&before) != std::mem::discriminant(&now) {
                self.has_other_shape = true;
            } else if self.varying.contains(path) {
                self.values.insert(path.clone(), now);
            } else {
                self.newly_varying.push(path.clone());
            }
            return;
        }
        if let (Sym::Point(a), Sym::Point(b)) = (old, new) {
            let parts = |index: usize| (Sym::Real(a[index]), Sym::Real(b[index]));
            self.compare_parts(3, parts, path);
        } else if let Some((_, n_parts)) = common_shell(&[old, new]) {
            self.compare_parts(n_parts, |index| (part(old, index), part(new, index)), path);
        } else {
            self.has_other_shape = true;
        }
    }

    fn compare_parts(
        &mut self,
        n_parts: usize,
        parts: impl Fn(usize) -> (Sym, Sym),
        path: &mut Path,
    ) {
        for index in 0..n_parts {
            if self.has_other_shape {
                return;
            }
            let (old, new) = parts(index);
            path.push(index as u32);
            self.compare(&old, &new, path);
            path.pop();
        }
    }

    /// Whether both are the same for sure; values that take long to compare are different.
    fn is_same(&mut self, old: &Sym, new: &Sym) -> bool {
        let most = MAX_COMPARED.min(self.left);
        let left = Cell::new(most);
        let is_same = old.is_same_within(new, &left);
        self.left -= most - left.get();
        is_same
    }
}
