//! The manual says what the code does: tables derive from the code's own tables, listings are those
//! of the compiler, and the examples evaluate to what stands beside them.
//!
//! In a fenced `gml` block, the lines up to one with `%!` are a program, and behind `%!` stands how
//! it ends, as in `tests/lang`. A block without `%!` is a program that ends well; one that opens with
//! `% NAME.gml` or includes a file is run where its commands are, by `tests/readme.rs`.

#[path = "support/derived.rs"]
mod derived;
#[path = "support/lang.rs"]
mod support;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use compiler::bytecode::{Format, Opcode};
use compiler::diagnostic::Code;
use compiler::op::Operator;
use compiler::preprocess::NoIncludes;
use compiler::source::SourceMap;

use derived::check_block;
use support::outcome;

#[test]
fn operators_are_those_of_the_code() {
    let mut table = "| operator | stack effect | what it does |\n| --- | --- | --- |\n".to_owned();
    for &op in Operator::ALL {
        let _ = writeln!(table, "| `{}` | {} | {} |", op.spelling(), op.stack_effect(), op.doc());
    }
    check_block("language.md", "operators", &table);
}

#[test]
fn errors_are_those_of_the_code() {
    let mut table = "| code | error |\n| --- | --- |\n".to_owned();
    for &code in Code::ALL {
        let _ = writeln!(table, "| {} | {} |", code.as_str(), code.title());
    }
    check_block("language.md", "errors", &table);
}

#[test]
fn instructions_are_those_of_the_code() {
    let mut table = "| instruction | fields | effect |\n| --- | --- | --- |\n".to_owned();
    for &op in Opcode::ALL {
        let format = op.format();
        let _ = writeln!(table, "| `{}` | {format:?} | {} |", op.mnemonic(), effect(op));
    }
    check_block("bytecode.md", "instructions", &table);
}

#[test]
fn formats_are_those_of_the_code() {
    let mut formats: Vec<Format> = Vec::new();
    for op in Opcode::ALL {
        if !formats.contains(&op.format()) {
            formats.push(op.format());
        }
    }
    let mut table = "| format | fields in use |\n| --- | --- |\n".to_owned();
    for format in formats {
        let _ = writeln!(table, "| {format:?} | {} |", fields(format));
    }
    check_block("bytecode.md", "formats", &table);
}

/// The listing is that of the `gml` block before it.
#[test]
fn the_listing_is_that_of_the_example() {
    let text = read("bytecode.md");
    let (before, _) = text.split_once("<!-- listing -->").expect("there is a listing");
    let example = gml_blocks(before).pop().expect("an example comes before the listing");
    let mut sources = SourceMap::default();
    let file = sources.add("example.gml", example.text.into_bytes()).expect("short");
    let program = compiler::compile(&mut sources, file, &mut NoIncludes, &[]).expect("correct");
    let listing = compiler::disasm::program(&program, &sources);
    check_block("bytecode.md", "listing", &format!("```text\n{listing}```\n"));
}

#[test]
fn examples_evaluate_to_what_stands_beside_them() {
    let mut failures = Vec::new();
    let mut n_examples = 0;
    for path in manual() {
        let text = std::fs::read_to_string(&path).expect("just listed");
        for block in gml_blocks(&text) {
            let cases = block.cases();
            n_examples += cases.len();
            for (program, expected) in cases {
                let got = outcome(&program);
                if got != expected {
                    let place = format!("{}:{}", path.display(), block.line);
                    failures.push(format!(
                        "{place}: {program}\n  expected {expected}\n  got      {got}"
                    ));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(n_examples >= 60, "only {n_examples} examples");
}

#[test]
fn programs_without_an_outcome_end_well() {
    let mut n_programs = 0;
    for path in manual() {
        let text = std::fs::read_to_string(&path).expect("just listed");
        for block in gml_blocks(&text) {
            if block.text.contains("%!") || block.text.contains("#") || block.is_file() {
                continue;
            }
            let got = outcome(&block.text);
            assert!(!got.starts_with("error"), "{}:{}: {got}", path.display(), block.line);
            n_programs += 1;
        }
    }
    assert!(n_programs >= 2, "only {n_programs} programs");
}

/// What an instruction does: its documentation, or for scalar operators the GML that it performs.
fn effect(op: Opcode) -> String {
    let Some(operator) = op.operator() else { return op.doc().to_owned() };
    let name = operator.spelling();
    match op.format() {
        Format::AB => format!("`r[a] = r[b] {name}`"),
        Format::ABC => format!("`r[a] = r[b] r[c] {name}`"),
        Format::ABConstant => format!("`r[a] = r[b] k[imm] {name}`"),
        Format::ABJump => format!("jumps unless `r[a] r[b] {name}`"),
        Format::AKJump => format!("jumps unless `r[a] k[b] {name}`"),
        Format::ABCRegister => format!("`r[imm] = r[a] r[b] r[c] {name}`"),
        other => unreachable!("no scalar operator has the format {other:?}"),
    }
}

fn fields(format: Format) -> &'static str {
    match format {
        Format::None => "none",
        Format::A => "`a`: a register",
        Format::AB => "`a`, `b`: registers",
        Format::ABC => "`a`, `b`, `c`: registers",
        Format::ABCRegister => "`a`, `b`, `c`, `imm`: registers, the last for the result",
        Format::AConstant => "`a`: a register; `imm`: a constant",
        Format::Constant => "`imm`: a constant",
        Format::ABConstant => "`a`, `b`: registers; `imm`: a constant",
        Format::ACapture => "`a`: a register; `imm`: a captured value of the running closure",
        Format::ASlot => "`a`: a register; `imm`: a spill slot",
        Format::AFunction => "`a`: a register; `imm`: a function of the program",
        Format::ACount => "`a`: a register; `imm`: a number",
        Format::Range => {
            "`a`: the first of `b` registers; `c`: 1 + the number of the operator that asks, or 0"
        }
        Format::Jump => "`imm`: the distance of a jump",
        Format::AJump => "`a`: a register; `imm`: the distance of a jump",
        Format::ABJump => "`a`, `b`: registers; `imm`: the distance of a jump",
        Format::AKJump => "`a`: a register; `b`: a constant; `imm`: the distance of a jump",
        Format::AOperator => "`a`: a register; `b`: the number of an operator",
    }
}

/// A fenced block of GML.
struct Block {
    /// Line of the opening fence, from 1.
    line: usize,
    text: String,
}

impl Block {
    /// Whether it is the file that its first line names.
    fn is_file(&self) -> bool {
        let first = self.text.lines().next().unwrap_or_default();
        first.starts_with("% ")
            && !first.trim_start_matches("% ").contains(' ')
            && first.contains('.')
    }

    /// The programs in it, each with how it ends.
    fn cases(&self) -> Vec<(String, String)> {
        let mut cases = Vec::new();
        let mut program = String::new();
        for line in self.text.lines() {
            let Some((code, expected)) = line.split_once("%!") else {
                program.push_str(line);
                program.push('\n');
                continue;
            };
            program.push_str(code.trim_end());
            cases.push((std::mem::take(&mut program), expected.trim().to_owned()));
        }
        cases
    }
}

fn gml_blocks(document: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut is_open = false;
    for (idx, line) in document.lines().enumerate() {
        if line == "```gml" {
            blocks.push(Block { line: idx + 1, text: String::new() });
            is_open = true;
        } else if line == "```" {
            is_open = false;
        } else if let Some(block) = blocks.last_mut().filter(|_| is_open) {
            block.text.push_str(line);
            block.text.push('\n');
        }
    }
    blocks
}

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

fn read(document: &str) -> String {
    std::fs::read_to_string(docs().join(document)).expect("the manual is part of the project")
}

/// The documents in `docs/`, in a fixed order.
fn manual() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(docs()).expect("the manual is part of the project");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "md"));
    paths.sort();
    paths
}
