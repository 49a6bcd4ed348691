//! What specializing leaves to be made simpler, in SSA: tests of conditions that were made in two
//! ways, and checks of counters that cannot overflow.

use compiler::op::Operator;

use crate::sir::{Block, BlockData, Body, Inst, Term, Val};

/// Simplifies a body. It computes the same, and leaves where it did.
pub(crate) fn simplify(body: &mut Body) {
    let flow = Flow::new(body);
    for block in 0..body.blocks.len() {
        skip_test(body, block, &flow);
    }
    count_freely(body, &flow);
}

/// What leads where, and what is made of what.
struct Flow {
    /// What defines each value; nothing for parameters.
    insts: Vec<Option<Inst>>,
    /// How often each value is used.
    n_uses: Vec<u32>,
    /// By block, the blocks that jump to it.
    jumps: Vec<Vec<usize>>,
    /// By block, whether it gets the results of a call.
    follows_call: Vec<bool>,
}

impl Flow {
    fn new(body: &Body) -> Self {
        let mut flow = Flow {
            insts: vec![None; body.types.len()],
            n_uses: vec![0; body.types.len()],
            jumps: vec![Vec::new(); body.blocks.len()],
            follows_call: vec![false; body.blocks.len()],
        };
        for (number, block) in body.blocks.iter().enumerate() {
            for (val, inst, _) in &block.insts {
                flow.insts[val.0 as usize] = Some(*inst);
                inst.operands().into_iter().flatten().for_each(|operand| flow.is_used(operand));
            }
            match block.term.as_ref().map(|(term, _)| term) {
                Some(Term::Jump(to, args)) => {
                    flow.jumps[to.0 as usize].push(number);
                    args.iter().for_each(|arg| flow.is_used(*arg));
                }
                Some(Term::Call(_, args, next)) => {
                    flow.follows_call[next.0 as usize] = true;
                    args.iter().for_each(|arg| flow.is_used(*arg));
                }
                Some(Term::Return(results)) => {
                    results.iter().for_each(|result| flow.is_used(*result));
                }
                Some(Term::Branch(val, _) | Term::Switch(val, _)) => flow.is_used(*val),
                Some(Term::Leave) | None => {}
            }
        }
        flow
    }

    fn is_used(&mut self, val: Val) {
        self.n_uses[val.0 as usize] += 1;
    }

    fn int(&self, val: Val) -> Option<i64> {
        match self.insts[val.0 as usize] {
            Some(Inst::Int(value)) => Some(value),
            _ => None,
        }
    }
}

/// If a block only tests its parameter, has each block that jumps to it with a condition test that
/// condition itself; what is constant needs no test. GML has no `and` and no `or`, but `if` with
/// `true` or `false` on one side, which leads to such blocks.
fn skip_test(body: &mut Body, block: usize, flow: &Flow) {
    let Some(targets) = tested(&body.blocks[block], flow, block) else { return };
    for &from in &flow.jumps[block] {
        if let Some((term, _)) = &mut body.blocks[from].term
            && let Term::Jump(_, args) = term
        {
            *term = match flow.insts[args[0].0 as usize] {
                Some(Inst::Bool(condition)) => {
                    Term::Jump(targets[usize::from(!condition)], Vec::new())
                }
                _ => Term::Branch(args[0], targets),
            };
        }
    }
    // Nothing leads here any more.
    body.blocks[block].term = None;
}

/// Where a block goes on that does nothing but test its only parameter, which nobody else uses.
fn tested(data: &BlockData, flow: &Flow, block: usize) -> Option<[Block; 2]> {
    let &[param] = &data.params[..] else { return None };
    let Some((Term::Branch(condition, targets), _)) = data.term else { return None };
    let does_more = !data.insts.is_empty() || data.is_loop || flow.follows_call[block];
    let is_its = condition == param && flow.n_uses[param.0 as usize] == 1;
    (is_its && !does_more).then_some(targets)
}

/// Takes the check for overflow from sums of a counter and a step. A counter is the parameter of a
/// loop that starts with a constant, and that each round passes on with a constant added. Each round
/// pays fuel, of which there is less than 2^63, so that what all rounds add is bounded.
fn count_freely(body: &mut Body, flow: &Flow) {
    // What the steps of all rounds add is at most the largest step times 2^63 / cost: with these
    // limits half of 2^63, to which the start and one more step add less than the other half.
    const MAX_START: u64 = 1 << 61;
    let max_step = body.costs.fuel / 2;
    let step = |val: Val, counter: Val| match flow.insts[val.0 as usize] {
        Some(Inst::Scalar(Operator::AddI, [a, b])) if a == counter => flow.int(b),
        _ => None,
    };
    let is_passed_on = |arg: Val, counter: Val| {
        let starts = flow.int(arg).is_some_and(|start| start.unsigned_abs() <= MAX_START);
        let steps = step(arg, counter).is_some_and(|step| step.unsigned_abs() <= max_step);
        starts || steps || arg == counter
    };
    let mut counters = vec![false; body.types.len()];
    for (number, header) in body.blocks.iter().enumerate() {
        if !header.is_loop || flow.follows_call[number] {
            continue;
        }
        for (index, &param) in header.params.iter().enumerate() {
            let passes_on = |from: &usize| match &body.blocks[*from].term {
                Some((Term::Jump(_, args), _)) => is_passed_on(args[index], param),
                _ => false,
            };
            counters[param.0 as usize] = flow.jumps[number].iter().all(passes_on);
        }
    }
    for (_, inst, _) in body.blocks.iter_mut().flat_map(|data| &mut data.insts) {
        if let Inst::Scalar(Operator::AddI, [counter, by]) = *inst
            && counters[counter.0 as usize]
            && flow.int(by).is_some_and(|step| step.unsigned_abs() <= MAX_START)
        {
            *inst = Inst::Offset { offset: counter, index: by, stride: 1 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sir::{Site, Type};

    fn block(params: &[Val], insts: &[(Val, Inst)], term: Term, is_loop: bool) -> BlockData {
        let site = Site::default();
        let insts = insts.iter().map(|(val, inst)| (*val, *inst, site)).collect();
        BlockData { params: params.to_vec(), insts, term: Some((term, site)), site, is_loop }
    }

    fn body(types: Vec<Type>, blocks: Vec<BlockData>) -> Body {
        let mut body = Body::new(types);
        body.n_params = 1;
        body.blocks = blocks;
        body.costs.fuel = 10;
        body
    }

    fn term(body: &Body, block: usize) -> Option<&Term> {
        body.blocks[block].term.as_ref().map(|(term, _)| term)
    }

    /// `c { true } { d } if` tested at once: the side with `true` needs no test, the other tests d.
    #[test]
    fn conditions_made_in_two_ways_are_tested_where_they_are_made() {
        let [c, yes, d, joined] = [0, 1, 2, 3].map(Val);
        let blocks = |last: Term| {
            vec![
                block(&[], &[], Term::Branch(c, [Block(1), Block(2)]), false),
                block(&[], &[(yes, Inst::Bool(true))], Term::Jump(Block(3), vec![yes]), false),
                block(&[], &[(d, Inst::Bool(false))], Term::Jump(Block(3), vec![d]), false),
                block(&[joined], &[], Term::Branch(joined, [Block(4), Block(5)]), false),
                block(&[], &[], last, false),
                block(&[], &[], Term::Leave, false),
            ]
        };
        let mut simple = body(vec![Type::Bool; 4], blocks(Term::Leave));
        simple.blocks[2].insts[0].1 = Inst::Scalar(Operator::EqF, [c, c]);
        simplify(&mut simple);
        assert_eq!(term(&simple, 1), Some(&Term::Jump(Block(4), Vec::new())));
        assert_eq!(term(&simple, 2), Some(&Term::Branch(d, [Block(4), Block(5)])));
        assert_eq!(term(&simple, 3), None);
        // Whoever needs the condition later must get it.
        let mut needed = body(vec![Type::Bool; 4], blocks(Term::Return(vec![joined])));
        simplify(&mut needed);
        assert_eq!(term(&needed, 1), Some(&Term::Jump(Block(3), vec![yes])));
    }

    /// A loop that counts from `start` by `step`; whether the sum is still checked.
    fn is_checked(start: Inst, step: i64) -> bool {
        let [_, from, counter, by, next] = [0, 1, 2, 3, 4].map(Val);
        let sum = Inst::Scalar(Operator::AddI, [counter, by]);
        let blocks = vec![
            block(&[], &[(from, start)], Term::Jump(Block(1), vec![from]), false),
            block(
                &[counter],
                &[(by, Inst::Int(step)), (next, sum)],
                Term::Jump(Block(1), vec![next]),
                true,
            ),
        ];
        let mut counts = body(vec![Type::Int; 5], blocks);
        simplify(&mut counts);
        counts.blocks[1].insts[1].1 == sum
    }

    #[test]
    fn only_counters_that_cannot_overflow_go_unchecked() {
        assert!(!is_checked(Inst::Int(0), 1) && !is_checked(Inst::Int(-7), -5));
        // More than half of what a round costs.
        assert!(is_checked(Inst::Int(0), 6));
        assert!(is_checked(Inst::Int(i64::MAX), 1));
        assert!(is_checked(Inst::IntOfBool(Val(0)), 1), "it starts with anything");
    }
}
