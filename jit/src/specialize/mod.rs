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
//! All jumps in bytecode go forward, so nothing else can repeat.

mod index;
mod join;
mod live;
mod path;
mod rounds;
mod step;

use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;

use compiler::bytecode::{Function, Insn, Opcode, Program};
use compiler::source::Span;

use crate::outline::Outline;
use crate::sir::{Block, BlockData, Inst, N_ARGUMENTS, Shader, Site, Term, Type, Val};
use crate::specialize::path::Path;
use crate::sym::{Captures, Num, Sym};
use crate::unsupported::Unsupported;

/// Bounds of one specialization. A program that passes them would make a large and slow-to-compile
/// shader, which the interpreter may well outrun.
const MAX_STEPS: usize = 50_000;
const MAX_INSTS: usize = 6_000;
const MAX_DEPTH: usize = 128;
const MAX_FORKS: u32 = 64;
const MAX_RESTARTS: usize = 40;

/// Specializes a closure for its outline.
///
/// # Errors
/// Why it is declined.
pub(crate) fn specialize(program: &Program, outline: &Outline) -> Result<Shader, Unsupported> {
    let mut loops = HashMap::new();
    for _ in 0..MAX_RESTARTS {
        let mut specializer = Specializer::new(program, outline, std::mem::take(&mut loops));
        match specializer.run_surface(outline) {
            Ok(()) => return Ok(specializer.finish()),
            Err(Abort::Declined(unsupported)) => return Err(unsupported),
            Err(Abort::Restart) => loops = specializer.loops,
        }
    }
    let span = program.functions[outline.function as usize].span;
    Err(Unsupported { span, reason: "its loops change too many values".to_owned() })
}

/// Why a run ends early.
enum Abort {
    Declined(Unsupported),
    /// A loop was found to change values that it was not known to change.
    Restart,
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
    shader: Shader,
    /// Where instructions go.
    block: Block,
    site: Site,
    constants: HashMap<(Block, ConstKey), Val>,
    tables: HashMap<usize, Rc<[u32]>>,
    /// Registers read at or behind an instruction before they are written, by function.
    live_registers: HashMap<u32, Rc<Vec<[u64; 4]>>>,
    /// What changes in the loop that starts at an entry, by the entry's number.
    loops: HashMap<usize, BTreeSet<Path>>,
    n_entries: usize,
    n_steps: usize,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum ConstKey {
    Real(u64),
    Int(i64),
    Bool(bool),
}

impl<'p> Specializer<'p> {
    fn new(program: &'p Program, outline: &Outline, loops: HashMap<usize, BTreeSet<Path>>) -> Self {
        let mut types = vec![Type::Int, Type::Real, Type::Real];
        debug_assert_eq!(types.len(), N_ARGUMENTS as usize);
        types.extend_from_slice(&outline.uniform_types);
        let n_uniforms = outline.uniforms.len() as u32;
        let shader = Shader {
            types,
            blocks: Vec::new(),
            tables: Vec::new(),
            n_uniforms,
            functions: BTreeSet::new(),
            cost: 0,
            depth: 0,
        };
        let mut specializer = Specializer {
            program,
            shader,
            block: Block(0),
            site: Site { function: outline.function, pc: 0 },
            constants: HashMap::new(),
            tables: HashMap::new(),
            live_registers: HashMap::new(),
            loops,
            n_entries: 0,
            n_steps: 0,
        };
        specializer.block = specializer.new_block();
        specializer
    }

    fn finish(self) -> Shader {
        self.shader
    }

    fn run_surface(&mut self, outline: &Outline) -> Run<()> {
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
            self.n_steps += 1;
            if self.n_steps > MAX_STEPS {
                return self.decline("it takes too many steps to specialize");
            }
            self.site = Site { function: frame.function, pc: frame.pc as u32 };
            match self.step(state)? {
                Some(next) => state = next,
                None => return Ok(None),
            }
        }
    }

    /// Runs the ways that a state may go, each in a block of its own, up to `stop`, and joins them.
    fn fork(&mut self, ways: Vec<(Block, State)>, stop: Stop) -> Run<Option<State>> {
        let first_inner = Val(self.shader.types.len() as u32);
        let mut ends = Vec::new();
        for (block, mut state) in ways {
            state.forks += 1;
            if state.forks > MAX_FORKS {
                return self.decline("its conditions nest too deeply");
            }
            self.block = block;
            if let Some(mut end) = self.run(state, stop)? {
                end.forks -= 1;
                ends.push((self.block, end));
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

    fn decline<T>(&self, reason: &str) -> Run<T> {
        Err(Abort::Declined(Unsupported { span: self.span(self.site), reason: reason.to_owned() }))
    }

    /// Enters a function; the caller's frame, if any, stays.
    fn call(&mut self, state: &mut State, function: u32, captures: Captures) -> Run<()> {
        if state.frames.len() >= MAX_DEPTH {
            return self.decline(
                "its calls nest too deeply, or depend on data and are not the last thing it does",
            );
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
        let code = self.function(function);
        self.shader.cost += code.code.len() as u64;
        self.shader.functions.insert(function);
        let ordinal = self.n_entries;
        self.n_entries += 1;
        let (captures, head) = self.loop_head(state, captures, ordinal)?;
        entries.push(Entry { function, forks: state.forks, head, ordinal });
        let n_registers = (code.n_registers + code.n_slots) as usize;
        let registers = vec![Sym::Dead; n_registers];
        state.frames.push(Rc::new(Frame { function, pc: 0, registers, captures, entries }));
        self.shader.depth = self.shader.depth.max(state.frames.len());
        Ok(())
    }

    // Code.

    fn new_block(&mut self) -> Block {
        self.shader.blocks.push(BlockData {
            params: Vec::new(),
            insts: Vec::new(),
            term: None,
            site: self.site,
            is_loop: false,
        });
        Block(self.shader.blocks.len() as u32 - 1)
    }

    fn new_val(&mut self, ty: Type) -> Val {
        self.shader.types.push(ty);
        Val(self.shader.types.len() as u32 - 1)
    }

    fn param(&mut self, block: Block, ty: Type) -> Val {
        let val = self.new_val(ty);
        self.shader.blocks[block.0 as usize].params.push(val);
        val
    }

    fn emit(&mut self, ty: Type, inst: Inst) -> Val {
        let val = self.new_val(ty);
        let site = self.site;
        self.shader.blocks[self.block.0 as usize].insts.push((val, inst, site));
        val
    }

    fn end(&mut self, block: Block, term: Term) {
        let data = &mut self.shader.blocks[block.0 as usize];
        debug_assert!(data.term.is_none());
        data.term = Some((term, self.site));
    }

    /// Where the last instruction of a block comes from; the block itself, if it has none.
    fn last_site(&self, block: Block) -> Site {
        let data = &self.shader.blocks[block.0 as usize];
        data.insts.last().map_or(data.site, |(_, _, site)| *site)
    }

    /// The interpreter must have a look: nothing follows.
    fn leave(&mut self) -> Run<Option<State>> {
        self.end(self.block, Term::Leave);
        Ok(None)
    }

    fn constant(&mut self, key: ConstKey) -> Val {
        if let Some(&val) = self.constants.get(&(self.block, key)) {
            return val;
        }
        let val = match key {
            ConstKey::Real(bits) => self.emit(Type::Real, Inst::Real(f64::from_bits(bits))),
            ConstKey::Int(value) => self.emit(Type::Int, Inst::Int(value)),
            ConstKey::Bool(value) => self.emit(Type::Bool, Inst::Bool(value)),
        };
        self.constants.insert((self.block, key), val);
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

    fn check_size(&self) -> Run<()> {
        if self.shader.types.len() > MAX_INSTS {
            return self.decline("it specializes to too much code");
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
