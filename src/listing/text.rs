//! Listings of surface functions as text: each line behind the source line that it came from.

use std::io::{self, Write};

use compiler::bytecode::Program;
use compiler::disasm::{self, SourceLines};
use compiler::source::{SourceMap, Span};
use jit::listing::{Line, Listing, Native, Outcome, Site};
use jit::shaders::Evaluation;
use renderer::surface::SurfaceSample;

use crate::args::Stage;
use crate::clean::{clean, clean_lines};
use crate::listing::{Surfaces, known_results, needs, numbered};
use crate::load::place;

/// Writes what is known of surfaces that share a shader, and the stages asked for, in this order.
pub(crate) fn write(
    surfaces: &Surfaces,
    stages: &[Stage],
    program: &Program,
    sources: &SourceMap,
    out: &mut dyn Write,
) -> io::Result<()> {
    let Surfaces { numbers, listing } = surfaces;
    let title = disasm::title(program, listing.function);
    let span = program.functions[listing.function as usize].span;
    let head = format!("{}: {title}, {}", numbered(numbers), place(sources, span));
    writeln!(out, "{}: {}", clean(&head), outcome(&listing.outcome, sources))?;
    for (what, detail) in details(listing) {
        writeln!(out, "  {}: {}", clean(&what), clean(&detail))?;
    }
    for stage in stages {
        match (stage, &listing.outcome) {
            (Stage::Bytecode, _) => {
                for function in listing.functions.iter().rev() {
                    let text = disasm::function(program, *function, sources);
                    write!(out, "\n{}", clean_lines(&text))?;
                }
            }
            (Stage::Clif, Outcome::Native(Native { clif, .. })) => {
                writeln!(out, "\nclif:")?;
                lines(clif, program, sources, out)?;
            }
            (Stage::Asm, Outcome::Native(Native { asm, .. })) => {
                writeln!(out, "\nasm:")?;
                lines(asm, program, sources, out)?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// What a surface captured, how that reaches its code, and what is known of that: each with what it
/// says something of.
pub(super) fn details(listing: &Listing) -> Vec<(String, String)> {
    let native = match &listing.outcome {
        Outcome::Native(native) => Some(native),
        Outcome::Constant(_) | Outcome::Declined(_) => None,
    };
    let uniforms = listing.uniforms.iter().enumerate().map(|(slot, uniform)| match native {
        Some(_) => (
            format!("uniform {slot}"),
            format!("{} {} = {}", uniform.ty, uniform.name, uniform.value),
        ),
        None => ("captured".to_owned(), format!("{} = {}", uniform.name, uniform.value)),
    });
    let known = listing.known.iter().map(|known| {
        let what = if native.is_some() { "specialized on" } else { "captured" };
        (what.to_owned(), format!("{} = {}", known.name, known.value))
    });
    let mut details: Vec<_> = uniforms.chain(known).collect();
    if let Some(native) = native {
        details.push(("reads".to_owned(), needs(native.needs)));
        let results = known_results(&native.results);
        if !results.is_empty() {
            details.push(("known results".to_owned(), results.join(", ")));
        }
    }
    details
}

/// What surfaces are evaluated by, in words.
pub(super) fn outcome(outcome: &Outcome, sources: &SourceMap) -> String {
    match outcome {
        Outcome::Constant(sample) => {
            let SurfaceSample { color, kd, ks, phong_exp } = sample;
            let [red, green, blue] = color.to_array();
            format!(
                "constant, color ({red:?} {green:?} {blue:?}), kd {kd:?}, ks {ks:?}, n {phong_exp:?}"
            )
        }
        Outcome::Native(native) => format!("native, {} bytes of code", native.n_bytes),
        Outcome::Declined(why) => {
            format!("interpreted: {} at {}", why.reason, place(sources, why.span))
        }
    }
}

/// How surfaces were evaluated, in words.
pub(crate) fn evaluation(evaluation: &Evaluation, sources: &SourceMap) -> String {
    match evaluation {
        Evaluation::Constant => "constant".to_owned(),
        Evaluation::Native { n_bytes, n_uniforms, .. } => {
            format!("native, {n_bytes} bytes of code, {n_uniforms} uniforms")
        }
        Evaluation::Declined(why) => {
            format!("interpreted: {} at {}", why.reason, place(sources, why.span))
        }
        Evaluation::Cold => "interpreted: called too seldom to be worth compiling".to_owned(),
    }
}

/// The source text that a bytecode instruction came from.
pub(super) fn span(program: &Program, site: Site) -> Span {
    let function = &program.functions[site.function as usize];
    function.origins.get(site.pc as usize).map_or(function.span, |origin| origin.span)
}

fn lines(
    lines: &[Line],
    program: &Program,
    sources: &SourceMap,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut source_lines = SourceLines::new(sources);
    for line in lines {
        let span = line.site.map_or(Span::NONE, |site| span(program, site));
        if let Some(source) = source_lines.before(span) {
            writeln!(out, "  {}", clean(&source))?;
        }
        let offset = line.offset.map_or(String::new(), |offset| format!("{offset:04x}"));
        let listed = format!("    {offset:<4}  {}", line.text);
        let listed = if line.offset.is_none() { format!("    {}", line.text) } else { listed };
        match sources.file_of(span) {
            Some(file) => writeln!(out, "{listed:<64} ; {}", file.line_column(span))?,
            None => writeln!(out, "{listed}")?,
        }
    }
    Ok(())
}
