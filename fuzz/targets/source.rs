//! Any bytes as a source file: they compile, or there is an error in the file to show. Names are
//! found in either case, and what the compiler takes for unbound is.
#![no_main]

use compiler::bytecode::Opcode;
use compiler::names::Names;
use compiler::preprocess::{NoIncludes, tokens_and_errors};
use compiler::source::SourceMap;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut sources = SourceMap::default();
    let file = sources.add("input.gml", bytes.to_vec()).expect("inputs are short");
    let (tokens, _) = tokens_and_errors(&mut sources, file, &mut NoIncludes);
    let names = Names::of(&tokens, &[]);
    match compiler::compile(&mut sources, file, &mut NoIncludes, &[]) {
        Ok(program) => {
            let code = program.functions.iter().flat_map(|f| f.code.iter().zip(&f.origins));
            for (_, origin) in code.filter(|(insn, _)| insn.op == Opcode::Unbound) {
                let mut uses = names.uses.iter().filter(|used| used.span == origin.span);
                assert!(uses.any(|used| used.binding.is_none()), "a name has two meanings");
            }
        }
        Err(diagnostics) => {
            assert!(!diagnostics.is_empty(), "it fails without an error");
            for diagnostic in diagnostics {
                assert!(sources.file_of(diagnostic.primary.span).is_some(), "an error is nowhere");
            }
        }
    }
});
