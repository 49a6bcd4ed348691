//! Routines: functions that call themselves so often as data says, and not in tail position.
//!
//! A routine has as parameters the scalars of what its function captured and takes off the stack,
//! and as results those of what it leaves there; the rest of these values, their shape, is known and
//! belongs to the routine. How many values a function takes off the stack turns out while it runs:
//! if they are too few, it is run again with one more. What it leaves is found by a first run in
//! which its calls of itself lead nowhere; a second one must find the same shape.

use std::collections::HashMap;

use crate::sir::{Body, Routine, Term, Type, Val};
use crate::specialize::join::{Scalar, sym_of};
use crate::specialize::shape::{Constants, MAX_PARTS, Part, Walk, taken_apart};
use crate::specialize::{Abort, MAX_RESTARTS, Run, STEP_VALUES, Specializer, State, Stop, Work};
use crate::sym::{Captures, Sym};

const MAX_ROUTINES: usize = 32;
/// So many routines of one function may be in the making at once, one called by the other.
const MAX_VARIANTS: usize = 3;
const MAX_ARGUMENTS: usize = 32;
/// A routine has at most so many parameters.
const MAX_SCALARS: usize = 64;
/// And so many results, for which there are registers: eight of each kind, but fuel and signature take two.
const MAX_REALS: usize = 8;
const MAX_OTHERS: usize = 6;

/// What is known of a routine.
pub(super) struct Record {
    key: Key,
    results: Results,
    /// Whether it has called itself before its results were known.
    is_recursive: bool,
    /// None while it is being made.
    routine: Option<Routine>,
}

/// What a routine is made for: a function, how many arguments it takes, and the shape of those and
/// of what it captured.
#[derive(Clone, PartialEq, Eq)]
struct Key {
    function: u32,
    n_arguments: usize,
    shape: Vec<Part>,
}

#[derive(Clone)]
enum Results {
    Unknown,
    /// It does not return.
    Never,
    Values(Vec<Part>, Vec<Sym>),
}

/// A call of a routine.
struct Call {
    key: Key,
    constants: Constants,
    captures: Captures,
    arguments: Vec<Sym>,
    scalars: Vec<Scalar>,
}

impl Record {
    pub(super) fn size(&self) -> usize {
        self.routine.as_ref().map_or(0, |routine| routine.body.size())
    }

    pub(super) fn finish(self) -> Routine {
        self.routine.expect("routines are made before what calls them is")
    }
}

impl Specializer<'_> {
    /// Calls a function by a routine.
    pub(super) fn call_routine(
        &mut self,
        mut state: State,
        function: u32,
        captures: &Captures,
    ) -> Run<Option<State>> {
        let (number, call) = loop {
            let n_arguments = self.arities.get(&function).copied().unwrap_or(0);
            if state.stack.len() - state.floor < n_arguments {
                return self.underflow(&state);
            }
            let arguments = state.stack[state.stack.len() - n_arguments..].to_vec();
            let call = self.routine_call(function, captures.clone(), arguments)?;
            if let Some(number) = self.routine(&call, &state)? {
                break (number, call);
            }
        };
        state.stack.truncate(state.stack.len() - call.arguments.len());
        let record = &mut self.routines[number];
        let results = match record.results.clone() {
            Results::Values(_, results) => results,
            Results::Unknown => {
                record.is_recursive = true;
                return self.leave();
            }
            Results::Never => return self.leave(),
        };
        let block = self.new_block();
        let args = call.scalars.iter().map(|scalar| self.materialize(*scalar)).collect();
        self.end(self.work.block, Term::Call(number as u32, args, block));
        self.work.block = block;
        let mut param = |scalar: Scalar| sym_of(scalar.ty(), self.param(block, scalar.ty()));
        let mut walk = Walk { parts: Vec::new(), replace: &mut param };
        let results = results.iter().map(|sym| walk.value(sym, Constants::Forget));
        state.stack.extend(results);
        Ok(Some(state))
    }

    /// A value is missing on the stack.
    pub(super) fn underflow(&mut self, state: &State) -> Run<Option<State>> {
        if self.work.is_routine && state.floors.is_empty() {
            return Err(Abort::MoreArguments);
        }
        self.leave()
    }

    /// The call that a routine is wanted for. Constants that were captured stay constant, unless
    /// this would lead from one routine of a function to the next.
    fn routine_call(
        &mut self,
        function: u32,
        captures: Captures,
        arguments: Vec<Sym>,
    ) -> Run<Call> {
        let mut call = Call {
            key: Key { function, n_arguments: arguments.len(), shape: Vec::new() },
            constants: Constants::KeepWithin,
            captures,
            arguments,
            scalars: Vec::new(),
        };
        self.take_apart(&mut call)?;
        let is_known = self.routines.iter().any(|record| record.key == call.key);
        if !is_known && self.n_in_the_making(function) > 0 {
            call.constants = Constants::Forget;
            self.take_apart(&mut call)?;
        }
        Ok(call)
    }

    fn take_apart(&mut self, call: &mut Call) -> Run<()> {
        let (parts, scalars) = taken_apart(|walk| {
            call.walk(walk);
        });
        self.take_steps(parts.len() / STEP_VALUES)?;
        if parts.len() > MAX_PARTS || scalars.len() > MAX_SCALARS {
            return self.decline("its recursion takes too many values along");
        }
        (call.key.shape, call.scalars) = (parts, scalars);
        Ok(())
    }

    fn n_in_the_making(&self, function: u32) -> usize {
        let of_function = |record: &&Record| record.key.function == function;
        let records = self.routines.iter().filter(of_function);
        records.filter(|record| record.routine.is_none()).count()
    }

    /// The number of the routine for a call, which is made if there is none; `None` if it takes more
    /// arguments.
    fn routine(&mut self, call: &Call, state: &State) -> Run<Option<usize>> {
        if let Some(number) = self.routines.iter().position(|record| record.key == call.key) {
            return Ok(Some(number));
        }
        if self.n_in_the_making(call.key.function) >= MAX_VARIANTS {
            return self.decline("its recursion changes the shape or the code of a value");
        }
        if self.routines.len() >= MAX_ROUTINES {
            return self.exhausted("it has too many recursions");
        }
        let number = self.routines.len();
        self.routines.push(Record {
            key: call.key.clone(),
            results: Results::Unknown,
            is_recursive: false,
            routine: None,
        });
        let site = self.site;
        let mut loops = HashMap::new();
        for _ in 0..MAX_RESTARTS {
            let work = Work::new(call.scalars.iter().map(|s| s.ty()).collect(), loops, true);
            let outer = std::mem::replace(&mut self.work, work);
            let results = self.run_routine(call, state.forks + 1);
            let Work { body, loops: found, .. } = std::mem::replace(&mut self.work, outer);
            loops = found;
            self.site = site;
            match results {
                Ok(results) => {
                    if self.is_made(number, body, results)? {
                        return Ok(Some(number));
                    }
                    // Entries have other numbers now, and what relies on the results is void.
                    loops.clear();
                    self.routines.truncate(number + 1);
                }
                Err(Abort::Restart) => {}
                Err(Abort::MoreArguments) => {
                    self.routines.truncate(number);
                    return self.take_more(call).map(|()| None);
                }
                Err(abort) => return Err(abort),
            }
        }
        self.decline("its loops change too many values")
    }

    fn take_more(&mut self, call: &Call) -> Run<()> {
        let n_arguments = call.key.n_arguments + 1;
        if n_arguments > MAX_ARGUMENTS {
            return self.decline("its recursion takes too many values along");
        }
        let arity = self.arities.entry(call.key.function).or_default();
        *arity = n_arguments.max(*arity);
        Ok(())
    }

    /// Runs a function with parameters in place of the scalars.
    fn run_routine(&mut self, call: &Call, forks: u32) -> Run<Results> {
        self.work.block = self.new_block();
        let mut params = (0..).map(Val);
        let mut param = |scalar: Scalar| sym_of(scalar.ty(), params.next().expect("one for each"));
        let (captures, stack) = call.walk(&mut Walk { parts: Vec::new(), replace: &mut param });
        let mut state = State { frames: Vec::new(), stack, floor: 0, floors: Vec::new(), forks };
        self.enter(&mut state, call.key.function, captures, Vec::new())?;
        let Some(state) = self.run(state, Stop { depth: 0, pc: None })? else {
            return Ok(Results::Never);
        };
        let (parts, scalars) = results_apart(&state.stack);
        let n_reals = scalars.iter().filter(|scalar| scalar.ty() == Type::Real).count();
        let n_others = scalars.len() - n_reals;
        if parts.len() > MAX_PARTS || n_reals > MAX_REALS || n_others > MAX_OTHERS {
            return self.decline("its recursion leaves too many values");
        }
        let vals = scalars.into_iter().map(|scalar| self.materialize(scalar)).collect();
        self.end(self.work.block, Term::Return(vals));
        Ok(Results::Values(parts, state.stack))
    }

    /// Takes in what running a routine gave; whether it is the last word.
    fn is_made(&mut self, number: usize, body: Body, found: Results) -> Run<bool> {
        let record = &mut self.routines[number];
        let is_final = match (&record.results, &found) {
            (Results::Unknown, Results::Values(..)) => !record.is_recursive,
            (Results::Unknown, _) => true,
            (Results::Values(assumed, _), Results::Values(parts, _)) if assumed == parts => true,
            _ => {
                return self.decline("its recursion leaves values of different types or shapes");
            }
        };
        if is_final {
            let results = match &found {
                Results::Values(_, syms) => results_apart(syms).1,
                _ => Vec::new(),
            };
            let results = results.into_iter().map(Scalar::ty).collect();
            record.routine = Some(Routine { body, results });
        }
        record.results = found;
        Ok(is_final)
    }
}

impl Call {
    /// What was captured and the arguments, with their scalars replaced.
    fn walk(&self, walk: &mut Walk<'_>) -> (Captures, Vec<Sym>) {
        let within = match self.constants {
            Constants::Forget => Constants::Forget,
            _ => Constants::Keep,
        };
        let captures = match &self.captures {
            Captures::Known(_) => {
                let closure = Sym::Closure(self.key.function, self.captures.clone());
                walk.value(&closure, within);
                self.captures.clone()
            }
            Captures::Parts(parts) => {
                Captures::Parts(parts.iter().map(|sym| walk.value(sym, within)).collect())
            }
        };
        let stack = self.arguments.iter().map(|sym| walk.value(sym, self.constants)).collect();
        (captures, stack)
    }
}

/// The shape of results, and their scalars.
fn results_apart(results: &[Sym]) -> (Vec<Part>, Vec<Scalar>) {
    taken_apart(|walk| {
        for sym in results {
            walk.value(sym, Constants::Forget);
        }
    })
}
