//! How much is made of a program is bounded by its length.

use super::*;
use crate::preprocess::NoIncludes;
use crate::source::SourceMap;

fn compile(text: &str) -> Result<Program, Vec<Diagnostic>> {
    let mut sources = SourceMap::default();
    let file = sources.add("a", text.as_bytes().to_vec()).unwrap();
    crate::compile(&mut sources, file, &mut NoIncludes, &[])
}

/// A function whose parameters are used within so many others.
fn nested(n_names: usize, depth: usize) -> String {
    let binders: String = (0..n_names).map(|n| format!("/a{n} ")).collect();
    let uses: String = (0..n_names).map(|n| format!("a{n} ")).collect();
    format!("{{ {binders}{}{uses}{} }}", "{ ".repeat(depth), "} ".repeat(depth))
}

#[test]
fn captures_are_bounded_by_the_words() {
    // The values counted are as many as names times depth; the words are two for each of both.
    let captured = |program: Program| program.functions.iter().map(|f| f.captures.len()).sum();
    let (n_names, depth) = (1000, 69);
    assert_eq!(compile(&nested(n_names, depth)).map(captured), Ok(n_names * depth));
    let errors = compile(&nested(n_names, 70)).map(|_| ()).unwrap_err();
    assert_eq!(errors[0].code, Code::ProgramTooLarge);
    assert_eq!(errors.len(), 1);
}

#[test]
fn too_many_captures_end_it_anywhere() {
    let inner = nested(2000, 100);
    for around in [
        format!("{inner} apply 1 /x x"),
        format!("[ 1 {inner} 2 ] length"),
        format!("{{ /c c {{ {inner} }} {{ 1 2 }} if addi c }} /f true f apply"),
        format!("{{ /c c {{ 1 }} {{ {inner} }} if }} /f true f apply"),
    ] {
        assert!(compile(&around).is_err());
    }
}

#[test]
fn sides_of_conditions_do_not_repeat_all_that_waits() {
    let (n_values, n_conditions) = (2000, 100);
    let text = format!(
        "{{ /x {} {} 1 {} }}",
        "1 ".repeat(n_values),
        "x { } { ".repeat(n_conditions),
        "} if ".repeat(n_conditions)
    );
    let program = compile(&text).unwrap();
    let n_insns: usize = program.functions.iter().map(|f| f.code.len()).sum();
    let n_words = n_values + 7 * n_conditions;
    assert!(n_insns < n_words, "{n_insns}");
}
