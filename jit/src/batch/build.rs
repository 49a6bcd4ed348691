//! SSA to steps.

use compiler::op::Operator;

use super::{ALL, ARGUMENTS, Action, Batch, MAX_REGISTERS, Operand, Step};
use crate::sir::{Block, Body, Inst, N_ARGUMENTS, Shader, Term, Type, Val, Version};

/// Nanoseconds of processor time that a sine or cosine takes more as a call (9) than at one of many
/// points (2), on the machine of `benches/history`. Other operators take about as long either way.
const SAVED_BY_ANGLE: usize = 7;

/// Nanoseconds that handing over a point and its answer is taken for, an estimate from the times of whole
/// pictures, and as much again to be surely quicker.
const GATHERING: usize = 21;

/// Makes steps of a shader; none if it has loops or routines, or takes too many registers.
pub(crate) fn build(shader: &Shader) -> Option<Batch> {
    let body = &shader.main;
    if shader.version != Version::Plain || body.has_calls() {
        return None;
    }
    let order = order(body)?;
    let mut values = vec![None; body.types.len()];
    for (value, register) in values.iter_mut().zip(ARGUMENTS) {
        *value = Some(Operand::Register(register));
    }
    for uniform in 0..shader.n_uniforms {
        values[(N_ARGUMENTS + uniform) as usize] = Some(Operand::Uniform(uniform));
    }
    let mut building = Building {
        shader,
        body,
        live: body.live(),
        steps: Vec::new(),
        n_registers: N_ARGUMENTS,
        values,
        masks: vec![None; body.blocks.len()],
        results: None,
    };
    building.masks[0] = Some(ALL);
    for block in order {
        building.block(block)?;
    }
    let results = building.results?.map(|result| building.register(result));
    let mut batch = Batch {
        steps: building.steps,
        n_registers: building.n_registers as usize,
        results,
        pays: false,
    };
    allocate(&mut batch);
    batch.pays = pays(&batch);
    (batch.n_registers <= MAX_REGISTERS).then_some(batch)
}

/// Whether many calls are slower. A step that is no vector instruction, or that only some points are in
/// need of, is taken for a nanosecond lost.
fn pays(batch: &Batch) -> bool {
    let is_angle =
        |step: &&Step| matches!(step.action, Action::Scalar(Operator::Sin | Operator::Cos));
    let n_angles = |steps: &[Step]| steps.iter().filter(is_angle).count();
    let everywhere: Vec<Step> = batch.steps.iter().copied().filter(|s| s.mask == ALL).collect();
    let n_lost = batch.steps.len() - everywhere.len()
        + everywhere.iter().filter(|step| step.is_slow()).count();
    SAVED_BY_ANGLE * n_angles(&everywhere) > GATHERING + n_lost
}

/// The blocks that can be reached, each behind all that lead to it; none if there are loops.
fn order(body: &Body) -> Option<Vec<Block>> {
    let mut n_before = vec![0; body.blocks.len()];
    let mut is_reached = vec![false; body.blocks.len()];
    let mut pending = vec![Block(0)];
    is_reached[0] = true;
    while let Some(block) = pending.pop() {
        for next in successors(body, block) {
            n_before[next.0 as usize] += 1;
            if !std::mem::replace(&mut is_reached[next.0 as usize], true) {
                pending.push(next);
            }
        }
    }
    let mut order = Vec::new();
    pending.push(Block(0));
    while let Some(block) = pending.pop() {
        order.push(block);
        for next in successors(body, block) {
            n_before[next.0 as usize] -= 1;
            if n_before[next.0 as usize] == 0 {
                pending.push(next);
            }
        }
    }
    (order.len() == is_reached.iter().filter(|&&is| is).count()).then_some(order)
}

fn successors(body: &Body, block: Block) -> Vec<Block> {
    match &body.blocks[block.0 as usize].term {
        Some((Term::Jump(next, _) | Term::Call(_, _, next), _)) => vec![*next],
        Some((Term::Branch(_, nexts), _)) => nexts.to_vec(),
        Some((Term::Switch(_, nexts), _)) => nexts.clone(),
        Some((Term::Return(_) | Term::Leave, _)) | None => Vec::new(),
    }
}

struct Building<'s> {
    shader: &'s Shader,
    body: &'s Body,
    live: Vec<bool>,
    steps: Vec<Step>,
    /// Each value has its own for now.
    n_registers: u32,
    values: Vec<Option<Operand>>,
    /// Which points reach a block, by those that lead to it so far.
    masks: Vec<Option<Operand>>,
    results: Option<[Operand; 6]>,
}

impl Building<'_> {
    fn value(&self, val: Val) -> Operand {
        self.values[val.0 as usize].expect("definitions come before uses")
    }

    fn step(&mut self, action: Action, [a, b]: [Operand; 2], mask: Operand) -> Operand {
        let to = self.n_registers;
        self.n_registers += 1;
        self.steps.push(Step { action, to, a, b, mask });
        Operand::Register(to)
    }

    /// The register of an operand, or one that it is copied to.
    fn register(&mut self, operand: Operand) -> u32 {
        match operand {
            Operand::Register(register) => register,
            Operand::Same(_) | Operand::Uniform(_) => {
                self.step(Action::Copy, [operand, operand], ALL);
                self.n_registers - 1
            }
        }
    }

    /// None if it has what only other versions of shaders have.
    fn block(&mut self, block: Block) -> Option<()> {
        let data = &self.body.blocks[block.0 as usize];
        let mask = self.masks[block.0 as usize].expect("what leads here comes before");
        let start = self.steps.len();
        if mask != ALL {
            self.steps.push(Step { action: Action::Skip(0), to: 0, a: ALL, b: ALL, mask });
        }
        for (val, inst, _) in &data.insts {
            if self.live[val.0 as usize] {
                let value = self.inst(inst, mask)?;
                self.values[val.0 as usize] = Some(value);
            }
        }
        let term = &data.term.as_ref()?.0;
        self.pass_on(term, mask);
        // Masks are computed in any case: the mask of a block that is skipped says so.
        let n_steps = (self.steps.len() - start) as u32;
        if mask != ALL {
            self.steps[start].action = Action::Skip(n_steps - 1);
        }
        self.lead_on(term, mask);
        Some(())
    }

    fn inst(&mut self, inst: &Inst, mask: Operand) -> Option<Operand> {
        let none = Operand::Same(0);
        let (action, operands) = match *inst {
            Inst::Real(real) => return Some(Operand::Same(real.to_bits())),
            Inst::Int(int) => return Some(Operand::Same(int as u64)),
            Inst::Bool(is) => return Some(Operand::Same(if is { !0 } else { 0 })),
            Inst::IntOfBool(val) => (Action::IntOfBool, [self.value(val), none]),
            Inst::Scalar(op, operands) => (Action::Scalar(op), operands.map(|val| self.value(val))),
            Inst::Checked { index, length } => (Action::Checked(length), [self.value(index), none]),
            Inst::Offset { offset, index, stride } => {
                (Action::Offset(stride), [self.value(index), self.value(offset)])
            }
            Inst::Entry { table, start, column } => {
                let action = Action::Entry { table, column };
                let entry = self.step(action, [self.value(start), none], mask);
                if self.shader.tables[table as usize].ty != Type::Bool {
                    return Some(entry);
                }
                // Tables have 1 for true.
                (Action::Scalar(Operator::EqI), [entry, Operand::Same(1)])
            }
            Inst::Abs(_) | Inst::Require(..) | Inst::Decided(_) => return None,
        };
        Some(self.step(action, operands, mask))
    }

    /// What a block hands to the next.
    fn pass_on(&mut self, term: &Term, mask: Operand) {
        match term {
            Term::Jump(target, args) => {
                let params = &self.body.blocks[target.0 as usize].params;
                for (param, arg) in params.iter().zip(args) {
                    if self.live[param.0 as usize] {
                        let known = self.values[param.0 as usize];
                        let value = self.join(known, self.value(*arg), mask);
                        self.values[param.0 as usize] = Some(value);
                    }
                }
            }
            Term::Return(vals) => {
                let known = self.results;
                let results = std::array::from_fn(|index| {
                    let known = known.map(|results| results[index]);
                    self.join(known, self.value(vals[index]), mask)
                });
                self.results = Some(results);
            }
            Term::Leave => {
                self.steps.push(Step { action: Action::Leave, to: 0, a: ALL, b: ALL, mask });
            }
            Term::Branch(..) | Term::Switch(..) | Term::Call(..) => {}
        }
    }

    /// A value that comes from several blocks has a register that all of them write.
    fn join(&mut self, known: Option<Operand>, value: Operand, mask: Operand) -> Operand {
        match known {
            None if mask == ALL => value,
            None => self.step(Action::Copy, [value, value], mask),
            Some(Operand::Register(to)) => {
                self.steps.push(Step { action: Action::Blend, to, a: value, b: value, mask });
                Operand::Register(to)
            }
            Some(_) => unreachable!("a value that is joined has a register"),
        }
    }

    /// Which points go on where.
    fn lead_on(&mut self, term: &Term, mask: Operand) {
        match term {
            Term::Jump(target, _) => self.reach(*target, mask),
            Term::Branch(condition, [yes, no]) => {
                let condition = self.value(*condition);
                for (target, action) in [(yes, Action::And), (no, Action::AndNot)] {
                    let part = self.step(action, [mask, condition], ALL);
                    self.reach(*target, part);
                }
            }
            Term::Switch(tag, targets) => {
                let tag = self.value(*tag);
                for (number, target) in targets.iter().enumerate() {
                    let number = Operand::Same(number as u64);
                    let is = self.step(Action::Scalar(Operator::EqI), [tag, number], ALL);
                    let part = self.step(Action::And, [mask, is], ALL);
                    self.reach(*target, part);
                }
            }
            Term::Return(_) | Term::Call(..) | Term::Leave => {}
        }
    }

    fn reach(&mut self, block: Block, mask: Operand) {
        let all = match self.masks[block.0 as usize] {
            None => mask,
            Some(so_far) => self.step(Action::Or, [so_far, mask], ALL),
        };
        self.masks[block.0 as usize] = Some(all);
    }
}

impl Step {
    /// Whether no vector instruction does it.
    fn is_slow(&self) -> bool {
        use Operator::{Acos, Asin, DivI, Floor, ModI, MulI, RealOf};
        matches!(
            self.action,
            Action::Scalar(Asin | Acos | DivI | Floor | ModI | MulI | RealOf)
                | Action::Entry { .. }
        )
    }

    fn operands(&mut self) -> [&mut Operand; 3] {
        [&mut self.a, &mut self.b, &mut self.mask]
    }

    fn has_result(&self) -> bool {
        !matches!(self.action, Action::Leave | Action::Skip(_))
    }
}

/// Lets values share registers that are not needed at the same time. A step's result is never in the
/// register of one of its operands.
fn allocate(batch: &mut Batch) {
    let mut last_uses = vec![0; batch.n_registers];
    let Batch { steps, results, .. } = batch;
    for (index, step) in steps.iter_mut().enumerate() {
        for operand in step.operands() {
            if let Operand::Register(register) = operand {
                last_uses[*register as usize] = index;
            }
        }
        if step.has_result() {
            last_uses[step.to as usize] = index;
        }
    }
    for result in results.iter() {
        last_uses[*result as usize] = steps.len();
    }
    let mut places = vec![None; last_uses.len()];
    let mut ends = vec![Vec::new(); steps.len() + 1];
    for (register, &end) in last_uses.iter().enumerate() {
        ends[end].push(register);
    }
    let mut free = Vec::new();
    let mut n_places = N_ARGUMENTS;
    for register in ARGUMENTS {
        places[register as usize] = Some(register);
    }
    let place = |operand: &mut Operand, places: &[Option<u32>]| {
        if let Operand::Register(register) = operand {
            *register = places[*register as usize].expect("definitions come before uses");
        }
    };
    for (index, step) in steps.iter_mut().enumerate() {
        for operand in step.operands() {
            place(operand, &places);
        }
        if step.has_result() {
            let to = places[step.to as usize].get_or_insert_with(|| {
                free.pop().unwrap_or_else(|| {
                    n_places += 1;
                    n_places - 1
                })
            });
            step.to = *to;
        }
        free.extend(ends[index].iter().filter_map(|&register| places[register]));
    }
    for result in results.iter_mut() {
        *result = places[*result as usize].expect("results are defined");
    }
    batch.n_registers = n_places as usize;
}
