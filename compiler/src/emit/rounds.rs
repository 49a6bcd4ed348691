//! Functions that call themselves in tail position: the loops of GML.
//!
//! The compiler does not know which function a parameter is. But a call in tail position of a
//! parameter that is passed on, with as many arguments as the function begins by popping, is most
//! likely of the function itself: another round. Two things make rounds shorter, and are right
//! whatever is called. Captured values are fetched once, behind the pops at the beginning, where a
//! further round need not come by. And an argument is computed in the register that the next round
//! wants it in, if that holds nothing which is still to be read.

use crate::bytecode::{Function, Insn, Opcode, Origin};
use crate::emit::registers::CROWDED;
use crate::flow::{captured_registers, contains, jump_targets, live_registers};

/// Longer functions are left as they are: their rounds would gain little, and this bounds the time
/// that it takes.
const MAX_LENGTH: usize = 512;

/// A call in tail position that is most likely of the running function.
struct Round {
    /// Where the straight code begins that ends with the call.
    begin: usize,
    /// Where its pushes begin.
    pushes: usize,
    /// Where the call is.
    call: usize,
    /// The registers pushed, topmost first.
    arguments: Vec<u8>,
}

/// Shortens the rounds of a function. `functions` has those that it creates.
pub(super) fn shorten(functions: &[Function], function: &mut Function) {
    let parameters = parameters(&function.code);
    if function.code.len() > MAX_LENGTH || rounds(&function.code, &parameters).is_empty() {
        return;
    }
    fetch_at_entry(functions, function);
    for round in rounds(&function.code, &parameters) {
        for (index, &wanted) in parameters.iter().enumerate() {
            compute_in_place(functions, &mut function.code, &round, round.arguments[index], wanted);
        }
    }
}

fn leading_pops(code: &[Insn]) -> usize {
    code.iter().take_while(|insn| insn.op == Opcode::Pop).count()
}

/// The registers that the leading pops fill, topmost value first.
fn parameters(code: &[Insn]) -> Vec<u8> {
    let pops = code[..leading_pops(code)].iter();
    pops.flat_map(|pop| (0..pop.b).map(|offset| pop.a.wrapping_add(offset))).collect()
}

fn rounds(code: &[Insn], parameters: &[u8]) -> Vec<Round> {
    let is_target = jump_targets(code);
    let calls = (0..code.len()).filter(|pc| code[*pc].op == Opcode::TailApply);
    let rounds = calls.filter_map(|call| {
        let n_pushes = code[..call].iter().rev().map_while(pushed).count();
        let pushes = call - n_pushes;
        let pushed = code[pushes..call].iter().filter_map(pushed).flatten();
        let mut arguments: Vec<u8> = pushed.collect();
        arguments.reverse();
        let is_passed_on = parameters.len() == arguments.len()
            && parameters.iter().zip(&arguments).any(|pair| pair == (&code[call].a, pair.0));
        let is_end = |pc: &usize| is_target[*pc + 1] || code[*pc].jump().is_some();
        let begin = (0..call).rev().find(is_end).map_or(0, |end| end + 1);
        (is_passed_on && begin <= pushes).then_some(Round { begin, pushes, call, arguments })
    });
    rounds.collect()
}

/// The registers that an instruction pushes, the last on top.
fn pushed(insn: &Insn) -> Option<Vec<u8>> {
    let Insn { op, a, b, c, .. } = *insn;
    match op {
        Opcode::Push => Some(vec![a]),
        Opcode::Push2 => Some(vec![a, b]),
        Opcode::Push3 => Some(vec![a, b, c]),
        _ => None,
    }
}

/// Whether a closure made by one of the instructions captures what is in a register.
fn is_captured(functions: &[Function], code: &[Insn], register: u8) -> bool {
    let makes = code.iter().filter(|insn| insn.op == Opcode::MakeClosure);
    makes.flat_map(|make| captured_registers(&functions[make.imm as usize])).any(|r| r == register)
}

/// Moves captures behind the leading pops, into registers of their own.
fn fetch_at_entry(functions: &[Function], function: &mut Function) {
    let live = live_registers(functions, function);
    let n_pops = leading_pops(&function.code);
    let mut fetched: Vec<(Insn, Origin)> = Vec::new();
    let mut is_moved = vec![false; function.code.len()];
    let captures =
        (n_pops..function.code.len()).filter(|pc| function.code[*pc].op == Opcode::Capture);
    for pc in captures.collect::<Vec<_>>() {
        let Insn { a, imm, .. } = function.code[pc];
        let behind = function.code[pc + 1..].iter().position(|insn| insn.is_writing(a));
        let end = behind.map_or(function.code.len(), |distance| pc + 1 + distance);
        let reads = pc + 1..(end + 1).min(function.code.len());
        if is_captured(functions, &function.code[reads.clone()], a) {
            continue;
        }
        // The value must reach what reads the register up to `end`, and nothing else may.
        let is_mixed = function.code[..end].iter().enumerate().any(|(from, insn)| {
            let target = insn.jump().map_or(from + 1, |distance| from + 1 + distance);
            let passes_by = if from < pc { target > pc && target <= end } else { target > end };
            passes_by && contains(&live[target], a)
        });
        let known = fetched.iter().find(|(known, _)| known.imm == imm).map(|(known, _)| known.a);
        let is_room = (function.n_registers as usize) < CROWDED;
        if is_mixed || (known.is_none() && !is_room) {
            continue;
        }
        let register = known.unwrap_or_else(|| {
            let register = function.n_registers as u8;
            function.n_registers += 1;
            fetched.push((Insn { a: register, ..function.code[pc] }, function.origins[pc]));
            register
        });
        rename_reads(&mut function.code[reads], a, register);
        is_moved[pc] = true;
    }
    rearrange(function, n_pops, fetched, &is_moved);
}

fn rename_reads(code: &mut [Insn], from: u8, to: u8) {
    for field in code.iter_mut().flat_map(Insn::read_fields_mut).filter(|field| **field == from) {
        *field = to;
    }
}

/// Inserts instructions at `place` and takes out those that have been moved.
fn rearrange(
    function: &mut Function,
    place: usize,
    inserted: Vec<(Insn, Origin)>,
    is_moved: &[bool],
) {
    let mut n_moved = 0;
    let mut places: Vec<usize> = Vec::with_capacity(is_moved.len() + 1);
    for (pc, is_moved) in is_moved.iter().enumerate() {
        places.push(if pc < place { pc } else { pc + inserted.len() - n_moved });
        n_moved += usize::from(*is_moved);
    }
    places.push(is_moved.len() + inserted.len() - n_moved);
    for (pc, insn) in function.code.iter_mut().enumerate() {
        if let Some(distance) = insn.jump() {
            insn.imm = (places[pc + 1 + distance] - places[pc] - 1) as u32;
        }
    }
    let old = std::mem::take(&mut function.code).into_iter().zip(function.origins.drain(..));
    let mut kept: Vec<(Insn, Origin)> =
        old.zip(is_moved).filter(|(_, is_moved)| !**is_moved).map(|(old, _)| old).collect();
    kept.splice(place..place, inserted);
    (function.code, function.origins) = kept.into_iter().unzip();
}

/// Lets the instruction that computes an argument write the register that is wanted for it, if
/// nothing else needs that from there to the call.
fn compute_in_place(
    functions: &[Function],
    code: &mut [Insn],
    round: &Round,
    argument: u8,
    wanted: u8,
) {
    let is_pushed_once = round.arguments.iter().filter(|r| **r == argument).count() == 1;
    if round.arguments.contains(&wanted) || !is_pushed_once || argument == code[round.call].a {
        return;
    }
    let made = (round.begin..round.pushes).rev().find(|pc| code[*pc].is_writing(argument));
    let is_computed = |made: &usize| !matches!(code[*made].op, Opcode::Pop | Opcode::Capture);
    let Some(made) = made.filter(is_computed) else { return };
    let between = &code[made + 1..=round.call];
    let is_read = |insn: &Insn, register: u8| {
        [insn.a, insn.b, insn.c]
            .into_iter()
            .zip(insn.reads())
            .any(|field| field == (register, true))
    };
    let is_free = !between.iter().any(|insn| is_read(insn, wanted) || insn.is_writing(wanted))
        && ![argument, wanted].iter().any(|r| is_captured(functions, between, *r));
    if is_free {
        let insn = &mut code[made];
        match insn.op {
            Opcode::Point | Opcode::Choose => insn.imm = u32::from(wanted),
            _ => insn.a = wanted,
        }
        rename_reads(&mut code[made + 1..=round.call], argument, wanted);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preprocess::NoIncludes;
    use crate::source::SourceMap;

    /// The code of the first function of a program.
    fn code(text: &str) -> Vec<(Opcode, [u8; 3])> {
        let mut sources = SourceMap::default();
        let file = sources.add("case.gml", text.as_bytes().to_vec()).expect("short");
        let program =
            crate::compile(&mut sources, file, &mut NoIncludes, &[]).expect("well formed");
        program.functions[0].code.iter().map(|insn| (insn.op, [insn.a, insn.b, insn.c])).collect()
    }

    #[test]
    fn rounds_fetch_at_the_entry_and_compute_in_place() {
        let code = code("{ /k { /f /n /x n 1 lessi { x } { x k mulf n 1 subi f f apply } if } }");
        let expected = [
            (Opcode::Pop, [0, 3, 0]),
            (Opcode::Capture, [6, 0, 0]),
            (Opcode::JumpUnlessLessIK, [1, 0, 0]),
            (Opcode::Push, [2, 0, 0]),
            (Opcode::Return, [0, 0, 0]),
            (Opcode::MulF, [2, 2, 6]),
            (Opcode::SubIK, [1, 1, 0]),
            (Opcode::Push3, [2, 1, 0]),
            (Opcode::TailApply, [0, 0, 0]),
        ];
        assert_eq!(code, expected);
    }

    #[test]
    fn a_parameter_that_is_still_read_keeps_its_register() {
        let code = code("{ /f /b /a b a addi a f f apply }");
        let sum = code.iter().find(|insn| insn.0 == Opcode::AddI).expect("it adds");
        // `a` is pushed behind the sum that is to take its place.
        assert!(![0, 1, 2].contains(&sum.1[0]), "{code:?}");
    }
}
