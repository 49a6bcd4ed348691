//! Runs a program without images and tells in one line how it ended.

use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use compiler::preprocess::NoIncludes;
use compiler::source::SourceMap;
use vm::host::{Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;

/// Takes what there is to render, and leaves it at that.
struct NoRender;

impl Host for NoRender {
    fn render(&mut self, _: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        Ok(())
    }
}

const LIMITS: Limits = Limits { fuel: 50_000_000, max_depth: 100_000, max_memory: 256 << 20 };

/// The final stack as `gmlvm eval` prints it, in one line; or `error CODE at COLUMN`.
pub(crate) fn outcome(program: &str) -> String {
    let mut sources = SourceMap::default();
    let file = sources.add("case.gml", program.as_bytes().to_vec()).expect("short");
    let failed = |sources: &SourceMap, diagnostic: &Diagnostic| {
        let span = diagnostic.primary.span;
        let column = sources.file_of(span).map_or(0, |file| file.line_column(span).column);
        format!("error {} at {column}", diagnostic.code.as_str())
    };
    let bytecode = match compiler::compile(&mut sources, file, &mut NoIncludes, &[]) {
        Ok(bytecode) => bytecode,
        Err(diagnostics) => return failed(&sources, &diagnostics[0]),
    };
    let loaded = Arc::new(LoadedProgram::new(bytecode));
    match Machine::new(&loaded, LIMITS).run(&mut NoRender) {
        Ok(stack) => stack.iter().map(vm::display::to_text).collect::<Vec<_>>().join(" "),
        Err(error) => failed(&sources, &error.into_diagnostic()),
    }
}
