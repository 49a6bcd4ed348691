//! Bytecode to SSA by abstract interpretation.
//!
//! The specializer runs a surface function on values that are partly known (`sym`). Calls of known
//! closures are entered, so that inlining is what happens by itself; a condition that is known takes
//! one side; one that is not forks the run, and the sides are joined where the bytecode joins them,
//! or where their function returns. What would be an error in the interpreter leaves the shader.
//!
//! A call in tail position of a function that is already running, with a fork in between, is a loop:
//! it jumps back to where that function was entered. Which values differ from round to round is only
//! known once the body has been seen; those become parameters of the loop's head, and the whole run
//! is repeated with this knowledge. Without a fork in between the trip count is known, and the loop
//! unrolls.
//!
//! A function that calls itself elsewhere than in tail position, with forks in between, is entered a
//! few times; if that does not end, the run is repeated with the function as a routine (`routines`).
//!
//! All jumps in bytecode go forward, so nothing else can repeat.

mod index;
mod join;
mod live;
mod path;
mod rounds;
mod routines;
mod shape;
mod step;

use std::cell::Cell;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::rc::Rc;

use compiler::bytecode::{Function, Insn, Opcode, Program};
use compiler::source::Span;

use crate::outline::Outline;
use crate::simplify::simplify;
use crate::sir::{
    Block, BlockData, Body, Inst, N_ARGUMENTS, Routine, Shader, Site, Table, Term, Type, Val,
    Version,
};
use crate::specialize::path::Path;
use crate::specialize::routines::Record;
use crate::sym::{Captures, MAX_COMPARED, Num, Sym, TableView};
use crate::unsupported::Unsupported;

/// Bounds of one specialization. A program that passes them would make a large and slow-to-compile
/// shader, which the interpreter may well outrun.
const MAX_STEPS: usize = 100_000;
const MAX_SIZE: usize = 8_000;
const MAX_DEPTH: usize = 128;
const MAX_FORKS: u32 = 64;
const MAX_RESTARTS: usize = 40;

/// So many arrays and closures may be made of others, which bounds how deeply they nest: walks through
/// them recurse.
const MAX_NESTED: usize = 4_000;

/// So many values are looked at or copied in about the time of a step.
const STEP_VALUES: usize = 16;

/// So often a function is entered within itself, with forks in between, before it is a routine.
const MAX_UNROLLED: usize = 6;

/// Specializes a closure for its outline, as a plain shader or a signed one.
///
/// # Errors
/// Why it is declined.
pub(crate) fn specialize(
    program: &Program,
    outline: &Outline,
    version: Version,
) -> Result<Shader, Unsupported> {
    let mut specializer = Specializer::new(program, outline, version);
    for _ in 0..MAX_RESTARTS {
        match specializer.run_surface(outline) {
            Ok(()) => return Ok(specializer.finish(outline)),
            Err(Abort::Exhausted(_)) if specializer.has_suspects() => {
                specializer.n_steps = 0;
                specializer.use_routines();
            }
            Err(Abort::Recursion) => specializer.use_routines(),
            Err(Abort::Declined(unsupported) | Abort::Exhausted(unsupported)) => {
                return Err(unsupported);
            }
            Err(Abort::Restart | Abort::MoreArguments) => {}
        }
    }
    let span = program.functions[outline.function as usize].span;
    Err(Unsupported { span, reason: "its loops change too many values".to_owned() })
}

/// Why a run ends early.
enum Abort {
    Declined(Unsupported),
    /// It takes too long or makes too much code.
    Exhausted(Unsupported),
    /// A loop was found to change values that it was not known to change.
    Restart,
    /// A routine was found to take more values off the stack.
    MoreArguments,
    /// A function was found that had better be a routine.
    Recursion,
}

type Run<T> = Result<T, Abort>;

/// A call that is active.
#[derive(Clone)]
struct Frame {
    function: u32,
    pc: usize,
    /// Registers, then spill slots.
    registers: Vec<Sym>,
    captures: Captures,
    /// The functions entered by this call and by the tail calls that took its place.
    entries: Vec<Entry>,
}

/// The entry of a function.
#[derive(Clone)]
struct Entry {
    function: u32,
    /// Forks around it.
    forks: u32,
    head: Rc<Head>,
    /// The number of the entry in this run, by which a repeated run knows it.
    ordinal: usize,
}

/// What a function was entered with, in case it turns out to be the head of a loop.
struct Head {
    /// Where further rounds jump to, if it is known to be a loop.
    block: Option<Block>,
    /// The parameters in place of what changes.
    params: Vec<(Path, Val)>,
    stack: Vec<Sym>,
    captures: Vec<Sym>,
}

/// The interpreter's state, as far as it is known.
#[derive(Clone)]
struct State {
    /// Callers are shared between forks, which cannot change them.
    frames: Vec<Rc<Frame>>,
    stack: Vec<Sym>,
    floor: usize,
    floors: Vec<usize>,
    forks: u32,
}

/// Where a run pauses: in the frame at this depth, at this instruction; or when that frame has
/// returned.
#[derive(Clone, Copy)]
struct Stop {
    depth: usize,
    pc: Option<usize>,
}

struct Specializer<'p> {
    program: &'p Program,
    version: Version,
    work: Work,
    site: Site,
    /// Views of arrays, by address; their offsets mean nothing.
    views: HashMap<usize, TableView>,
    tables: Vec<Table>,
    /// The functions that were run.
    functions: BTreeSet<u32>,
    /// Registers read at or behind an instruction before they are written, by function.
    live_registers: HashMap<u32, Rc<Vec<[u64; 4]>>>,
    /// Functions whose calls are calls of routines.
    recursive: HashSet<u32>,
    /// Functions that were entered within themselves, with forks in between.
    suspects: HashSet<u32>,
    routines: Vec<Record>,
    /// How many values the routines of a function take off the stack.
    arities: HashMap<u32, usize>,
    n_steps: usize,
}

/// The body that is being made.
struct Work {
    body: Body,
    /// Where instructions go.
    block: Block,
    constants: HashMap<(Block, ConstKey), Val>,
    /// What changes in the loop that starts at an entry, by the entry's number.
    loops: HashMap<usize, BTreeSet<Path>>,
    n_entries: usize,
    /// How many arrays and closures were made of others.
    n_nested: usize,
    is_routine: bool,
}

impl Work {
    fn new(params: Vec<Type>, loops: HashMap<usize, BTreeSet<Path>>, is_routine: bool) -> Self {
        let constants = HashMap::new();
        let body = Body::new(params);
        Work { body, block: Block(0), constants, loops, n_entries: 0, n_nested: 0, is_routine }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum ConstKey {
    Real(u64),
    Int(i64),
    Bool(bool),
}

impl<'p> Specializer<'p> {
    fn new(program: &'p Program, outline: &Outline, version: Version) -> Self {
        Specializer {
            program,
            version,
            work: Work::new(Vec::new(), HashMap::new(), false),
            site: Site { function: outline.function, pc: 0 },
            views: HashMap::new(),
            tables: Vec::new(),
            functions: BTreeSet::new(),
            live_registers: HashMap::new(),
            recursive: HashSet::new(),
            suspects: HashSet::new(),
            routines: Vec::new(),
            arities: HashMap::new(),
            n_steps: 0,
        }
    }

    fn finish(mut self, outline: &Outline) -> Shader {
        simplify(&mut self.work.body);
        let mut routines: Vec<Routine> = self.routines.into_iter().map(Record::finish).collect();
        routines.iter_mut().for_each(|routine| simplify(&mut routine.body));
        Shader {
            main: self.work.body,
            routines,
            tables: self.tables,
            n_uniforms: outline.uniforms.len() as u32,
            functions: self.functions,
            version: self.version,
        }
    }

    fn has_suspects(&self) -> bool {
        !self.suspects.is_subset(&self.recursive)
    }

    /// Has the suspects made routines by the next run.
    fn use_routines(&mut self) {
        self.recursive.extend(&self.suspects);
        self.routines.clear();
        self.work.loops.clear();
    }

    fn run_surface(&mut self, outline: &Outline) -> Run<()> {
        let mut types = vec![Type::Int, Type::Real, Type::Real];
        debug_assert_eq!(types.len(), N_ARGUMENTS as usize);
        types.extend_from_slice(&outline.uniform_types);
        self.work = Work::new(types, std::mem::take(&mut self.work.loops), false);
        self.work.block = self.new_block();
        let arguments = [
            Sym::Int(Num::Ssa(crate::sir::FACE)),
            Sym::Real(Num::Ssa(crate::sir::U)),
            Sym::Real(Num::Ssa(crate::sir::V)),
        ];
        let mut state = State {
            frames: Vec::new(),
            stack: arguments.to_vec(),
            floor: 0,
            floors: Vec::new(),
            forks: 0,
        };
        let captures = Captures::Parts(outline.captures.clone());
        self.call(&mut state, outline.function, captures)?;
        match self.run(state, Stop { depth: 0, pc: None })? {
            None => Ok(()),
            Some(_) => self.decline("it returns to nobody"),
        }
    }

    /// Runs until the stop; `None` if all ways end before.
    fn run(&mut self, mut state: State, stop: Stop) -> Run<Option<State>> {
        loop {
            let depth = state.frames.len();
            if depth < stop.depth {
                return Ok(Some(state));
            }
            let Some(frame) = state.frames.last() else { return Ok(Some(state)) };
            if depth == stop.depth && stop.pc == Some(frame.pc) {
                return Ok(Some(state));
            }
            self.take_steps(1)?;
            self.check_size()?;
            self.site = Site { function: frame.function, pc: frame.pc as u32 };
            match self.step(state)? {
                Some(next) => state = next,
                None => return Ok(None),
            }
        }
    }

    /// Counts work; a step is that of an instruction, or the same for so many values.
    fn take_steps(&mut self, n: usize) -> Run<()> {
        self.n_steps += n;
        if self.n_steps > MAX_STEPS {
            return self.exhausted("it takes too many steps to specialize");
        }
        Ok(())
    }

    /// Whether both are the same value for sure; comparing them counts as work.
    fn is_same(&mut self, a: &Sym, b: &Sym) -> Run<bool> {
        let left = Cell::new(MAX_COMPARED);
        let is_same = a.is_same_within(b, &left);
        self.take_steps((MAX_COMPARED - left.get()) / STEP_VALUES)?;
        Ok(is_same)
    }

    /// Runs the ways that a state may go, each in a block of its own, up to `stop`, and joins them.
    fn fork(&mut self, ways: Vec<(Block, State)>, stop: Stop) -> Run<Option<State>> {
        let n_copied = ways.iter().map(|(_, state)| state.stack.len() + state.frames.len());
        self.take_steps(n_copied.sum::<usize>() / STEP_VALUES)?;
        let first_inner = Val(self.work.body.types.len() as u32);
        let mut ends = Vec::new();
        for (block, mut state) in ways {
            state.forks += 1;
            if state.forks > MAX_FORKS {
                return self.exhausted("its conditions nest too deeply");
            }
            self.work.block = block;
            if let Some(mut end) = self.run(state, stop)? {
                end.forks -= 1;
                ends.push((self.work.block, end));
            }
        }
        self.join(ends, first_inner)
    }

    fn function(&self, index: u32) -> &'p Function {
        &self.program.functions[index as usize]
    }

    fn insn(&self, frame: &Frame) -> Insn {
        self.function(frame.function).code[frame.pc]
    }

    fn span(&self, site: Site) -> Span {
        let function = self.function(site.function);
        function.origins.get(site.pc as usize).map_or(function.span, |origin| origin.span)
    }

    fn unsupported(&self, reason: &str) -> Unsupported {
        Unsupported { span: self.span(self.site), reason: reason.to_owned() }
    }

    fn decline<T>(&self, reason: &str) -> Run<T> {
        Err(Abort::Declined(self.unsupported(reason)))
    }

    fn exhausted<T>(&self, reason: &str) -> Run<T> {
        Err(Abort::Exhausted(self.unsupported(reason)))
    }

    /// Enters a function; the caller's frame, if any, stays.
    fn call(&mut self, state: &mut State, function: u32, captures: Captures) -> Run<()> {
        if state.frames.len() >= MAX_DEPTH {
            return self.exhausted("its calls nest too deeply");
        }
        self.enter(state, function, captures, Vec::new())
    }

    fn enter(
        &mut self,
        state: &mut State,
        function: u32,
        captures: Captures,
        mut entries: Vec<Entry>,
    ) -> Run<()> {
        self.suspect(state, function)?;
        let code = self.function(function);
        self.add_costs(code);
        self.functions.insert(function);
        let ordinal = self.work.n_entries;
        self.work.n_entries += 1;
        let (captures, head) = self.loop_head(state, captures, ordinal)?;
        entries.push(Entry { function, forks: state.forks, head, ordinal });
        self.take_steps(code.n_slots as usize / STEP_VALUES)?;
        let n_registers = (code.n_registers + code.n_slots) as usize;
        let registers = vec![Sym::Dead; n_registers];
        state.frames.push(Rc::new(Frame { function, pc: 0, registers, captures, entries }));
        let costs = &mut self.work.body.costs;
        costs.depth = costs.depth.max(state.frames.len());
        Ok(())
    }

    /// Has a function that keeps being entered within itself made a routine.
    fn suspect(&mut self, state: &State, function: u32) -> Run<()> {
        let entries = state.frames.iter().flat_map(|frame| &frame.entries);
        let within = |entry: &&Entry| entry.function == function && entry.forks < state.forks;
        let n_within = entries.filter(within).count();
        if n_within > 0 {
            self.suspects.insert(function);
        }
        if n_within >= MAX_UNROLLED && !self.recursive.contains(&function) {
            return Err(Abort::Recursion);
        }
        Ok(())
    }

    fn add_costs(&mut self, code: &Function) {
        // A register, a value on the stack and one in an array or closure.
        let value = 3 * size_of::<[u64; 4]>() as u64;
        let captured = |insn: &Insn| match insn.op {
            Opcode::MakeClosure => self.program.functions[insn.imm as usize].captures.len() as u64,
            _ => 0,
        };
        let made = |insn: &Insn| match insn.op {
            Opcode::MakeClosure => captured(insn) + 1,
            Opcode::Push3 => 3,
            _ => 2,
        };
        let is_holder = |insn: &&Insn| {
            matches!(insn.op, Opcode::MakeClosure | Opcode::MakeArray | Opcode::EndArray)
        };
        let n_values =
            code.code.iter().map(made).sum::<u64>() + u64::from(code.n_registers + code.n_slots);
        let n_holders = code.code.iter().filter(is_holder).count() as u64;
        let costs = &mut self.work.body.costs;
        costs.fuel += code.code.len() as u64 + code.code.iter().map(captured).sum::<u64>();
        costs.memory += value * n_values;
        costs.n_holders += n_holders;
    }

    // Code.

    fn new_block(&mut self) -> Block {
        let data = BlockData {
            params: Vec::new(),
            insts: Vec::new(),
            term: None,
            site: self.site,
            is_loop: false,
        };
        self.work.body.blocks.push(data);
        Block(self.work.body.blocks.len() as u32 - 1)
    }

    fn new_val(&mut self, ty: Type) -> Val {
        self.work.body.types.push(ty);
        Val(self.work.body.types.len() as u32 - 1)
    }

    fn param(&mut self, block: Block, ty: Type) -> Val {
        let val = self.new_val(ty);
        self.work.body.blocks[block.0 as usize].params.push(val);
        val
    }

    fn emit(&mut self, ty: Type, inst: Inst) -> Val {
        let val = self.new_val(ty);
        let site = self.site;
        self.work.body.blocks[self.work.block.0 as usize].insts.push((val, inst, site));
        val
    }

    fn end(&mut self, block: Block, term: Term) {
        let data = &mut self.work.body.blocks[block.0 as usize];
        debug_assert!(data.term.is_none());
        data.term = Some((term, self.site));
    }

    /// Where the last instruction of a block comes from; the block itself, if it has none.
    fn last_site(&self, block: Block) -> Site {
        let data = &self.work.body.blocks[block.0 as usize];
        data.insts.last().map_or(data.site, |(_, _, site)| *site)
    }

    /// The interpreter must have a look: nothing follows.
    fn leave(&mut self) -> Run<Option<State>> {
        self.end(self.work.block, Term::Leave);
        Ok(None)
    }

    fn constant(&mut self, key: ConstKey) -> Val {
        if let Some(&val) = self.work.constants.get(&(self.work.block, key)) {
            return val;
        }
        let val = match key {
            ConstKey::Real(bits) => self.emit(Type::Real, Inst::Real(f64::from_bits(bits))),
            ConstKey::Int(value) => self.emit(Type::Int, Inst::Int(value)),
            ConstKey::Bool(value) => self.emit(Type::Bool, Inst::Bool(value)),
        };
        self.work.constants.insert((self.work.block, key), val);
        val
    }

    fn real(&mut self, num: Num<f64>) -> Val {
        match num {
            Num::Const(value) => self.constant(ConstKey::Real(value.to_bits())),
            Num::Ssa(val) => val,
        }
    }

    fn int(&mut self, num: Num<i64>) -> Val {
        match num {
            Num::Const(value) => self.constant(ConstKey::Int(value)),
            Num::Ssa(val) => val,
        }
    }

    fn bool(&mut self, num: Num<bool>) -> Val {
        match num {
            Num::Const(value) => self.constant(ConstKey::Bool(value)),
            Num::Ssa(val) => val,
        }
    }

    /// Notes a decision of the function, known or not, if it is to be signed.
    fn decided(&mut self, decision: &Sym) {
        if self.version == Version::Signed
            && let Some(val) = self.val(decision)
        {
            let ty = self.work.body.type_of(val);
            self.emit(ty, Inst::Decided(val));
        }
    }

    /// Counts a new array or closure if it is made of others.
    fn count_nested(&mut self, parts: &[Sym]) -> Run<()> {
        let is_structure =
            |sym: &Sym| matches!(sym, Sym::Array(_) | Sym::Closure(..) | Sym::Choice(..));
        self.work.n_nested += usize::from(parts.iter().any(is_structure));
        if self.work.n_nested > MAX_NESTED {
            return self.exhausted("it makes too many arrays and functions of others");
        }
        Ok(())
    }

    fn check_size(&self) -> Run<()> {
        let size_before = self.routines.iter().map(Record::size).sum::<usize>();
        if size_before + self.work.body.size() > MAX_SIZE {
            return self.exhausted("it specializes to too much code");
        }
        Ok(())
    }

    /// Where the sides of a conditional jump meet: an instruction of the same function, or the
    /// function's return.
    fn meeting_point(&self, frame: &Frame, depth: usize, target: usize) -> Stop {
        let code = &self.function(frame.function).code;
        match code[target - 1] {
            Insn { op: Opcode::Jump, imm, .. } => Stop { depth, pc: Some(target + imm as usize) },
            _ => Stop { depth, pc: None },
        }
    }
}
