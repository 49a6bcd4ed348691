//! What a call may use does not depend on the calls before it.

use compiler::diagnostic::Diagnostic;
use compiler::preprocess::NoIncludes;
use compiler::source::SourceMap;

use super::*;
use crate::host::{Host, RenderJob};
use crate::value::Value;

struct NoRender;

impl Host for NoRender {
    fn render(&mut self, _: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        Ok(())
    }
}

/// A program that leaves surface functions, each of which uses up something else: captured values,
/// registers, what objects hold, and a heap that a loop clears as often as it may look at the stack.
fn program() -> String {
    let many = "x ".repeat(3000);
    let result = "1.0 1.0 1.0 point 1.0 0.0 1.0";
    format!(
        "{{ /x [ {many} ] }} /fill
         {{ /self /n n 0 eqi {{ 0 }} {{ n 1 subi self self apply 1 addi }} if }} /deep
         {{ /self /n n 0 eqi {{ }} {{ n n fill apply /array n 1 subi self self apply }} if }} /loop
         {{ /self /n n 0 eqi {{ }} {{ n n 1 subi self self apply }} if }} /push
         1 fill apply /first 2 fill apply /second
         {{ /v /u /face first 0 get fill apply /a {result} }}
         {{ /v /u /face second 0 get fill apply length deep deep apply /a {result} }}
         {{ /v /u /face {{ }} sphere /s {{ }} sphere s union /s face fill apply /a {result} }}
         {{ /v /u /face [ 30000 push push apply 40 loop loop apply ] /a {result} }}"
    )
}

fn load() -> (Arc<LoadedProgram>, Vec<Arc<Closure>>) {
    let mut sources = SourceMap::default();
    let file = sources.add("surfaces.gml", program().into_bytes()).expect("short");
    let bytecode = compiler::compile(&mut sources, file, &mut NoIncludes, &[]).expect("a program");
    let loaded = Arc::new(LoadedProgram::new(bytecode));
    let limits = Limits { fuel: 1_000_000, max_depth: 1000, max_memory: 1 << 30 };
    let values = Machine::new(&loaded, limits).run(&mut NoRender).expect("no error");
    let surfaces = values.into_iter().map(|value| match value {
        Value::Closure(closure) => closure,
        other => panic!("{}", crate::display::to_text(&other)),
    });
    let surfaces = surfaces.collect();
    (loaded, surfaces)
}

#[test]
fn calls_do_not_use_up_what_others_may_use() {
    let (program, surfaces) = load();
    let call = |max_memory: u64, calls: &[u32]| {
        let limits = Limits { fuel: 1_000_000, max_depth: 10_000, max_memory };
        let mut interpreter = InterpSurfaces::new(&program, &surfaces, limits);
        let at = SurfacePoint { face: 0, u: 0.5, v: 0.5 };
        calls.iter().map(|id| interpreter.eval(SurfaceId(*id), &at).is_ok()).last().expect("a call")
    };
    let all = 0..surfaces.len() as u32;
    for id in all.clone() {
        let (mut too_little, mut enough) = (0, 1 << 26);
        assert!(call(enough, &[id]));
        while enough - too_little > 1 {
            let middle = (too_little + enough) / 2;
            *(if call(middle, &[id]) { &mut enough } else { &mut too_little }) = middle;
        }
        for other in all.clone() {
            for before in [vec![other], vec![other, other], vec![id, other, id]] {
                let calls = [&before[..], &[id]].concat();
                assert!(call(enough, &calls), "{calls:?}: fails with {enough} bytes");
                assert!(!call(too_little, &calls), "{calls:?}: needs {enough} bytes alone");
            }
        }
    }
}
