//! What machine code does to the process: to its memory, and to what the profiler `perf` is told.
#![cfg(target_os = "linux")]

use std::process::Command;
use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use compiler::preprocess::NoIncludes;
use compiler::source::SourceMap;
use jit::shaders::{Evaluation, Region, Shaders, Tiering};
use renderer::surface::{SurfaceEval, SurfaceId, SurfacePoint};
use support::gmlvm::Sandbox;
use vm::host::{Host, RenderJob};
use vm::machine::{Limits, Machine};
use vm::program::LoadedProgram;
use vm::value::{Closure, Value};

mod support {
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod gmlvm;
}

const LIMITS: Limits = Limits { fuel: 200_000, max_depth: 1000, max_memory: 1 << 30 };

/// Takes u, v and a table; leaves two surfaces.
const PROGRAM: &str = "\
[ 0.25 0.5 0.75 ] /table
{ /v /u /face table face get /t u v mulf t addf /x x x x point 1.0 0.0 1.0 }
{ /v /u /face u sin v addf /x x x 0.5 point 1.0 x 1.0 }
";

/// Compiles made by the test for leaks, after some that do not count.
const N_COMPILES: usize = 10_000;
/// Memory that they may leave behind.
const MAX_GROWTH: usize = 10 << 20;

struct NoRender;

impl Host for NoRender {
    fn render(&mut self, _: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        unreachable!("the program does not render")
    }
}

fn load(text: &str) -> (Arc<LoadedProgram>, Vec<Arc<Closure>>) {
    let mut sources = SourceMap::default();
    let file = sources.add("case.gml", text.as_bytes().to_vec()).expect("short");
    let bytecode = compiler::compile(&mut sources, file, &mut NoIncludes, &[]).expect("correct");
    let program = Arc::new(LoadedProgram::new(bytecode));
    let Ok(stack) = Machine::new(&program, LIMITS).run(&mut NoRender) else {
        panic!("it fails");
    };
    let closures = stack.into_iter().map(|value| match value {
        Value::Closure(closure) => closure,
        other => panic!("{} is no surface", vm::display::to_text(&other)),
    });
    (program, closures.collect())
}

/// A mapping of this process.
struct Mapping {
    range: std::ops::Range<usize>,
    permissions: String,
    line: String,
}

fn mappings() -> Vec<Mapping> {
    let text = std::fs::read_to_string("/proc/self/maps").expect("there are mappings");
    let address = |text: &str| usize::from_str_radix(text, 16).expect("an address");
    let mapping = |line: &str| {
        let mut words = line.split(' ');
        let (start, end) = words.next()?.split_once('-')?;
        let permissions = words.next()?.to_owned();
        Some(Mapping { range: address(start)..address(end), permissions, line: line.to_owned() })
    };
    text.lines().map(|line| mapping(line).expect("a mapping")).collect()
}

fn is_native(shaders: &Shaders<'_>) -> bool {
    let is_native =
        |evaluation: &Evaluation| matches!(evaluation, Evaluation::Native { n_bytes: 1.., .. });
    shaders.report().iter().all(|report| is_native(&report.evaluation))
}

#[test]
fn no_memory_is_writable_and_executable() {
    let (program, surfaces) = load(PROGRAM);
    let regions = std::sync::Mutex::new(Vec::new());
    let note = |region: Region| regions.lock().expect("no panic").push(region);
    let shaders = Shaders::observed(&program, &surfaces, LIMITS, Tiering::Eager, Some(&note));
    assert!(is_native(&shaders));
    let mut worker = shaders.worker();
    for index in 0..2 {
        let at = SurfacePoint { face: 1, u: 0.5, v: 0.25 };
        assert!(worker.eval(SurfaceId(index), &at).is_ok());
    }
    let mappings = mappings();
    for Mapping { permissions, line, .. } in &mappings {
        let both = permissions.contains('w') && permissions.contains('x');
        assert!(!both, "{line}");
    }
    let regions = regions.lock().expect("no panic");
    assert_eq!(regions.len(), 2);
    for region in regions.iter() {
        let home = mappings.iter().find(|mapping| mapping.range.contains(&region.address));
        let home = home.expect("the code is mapped");
        assert!(home.permissions.starts_with("r-x"), "{}", home.line);
        assert!(home.range.contains(&(region.address + region.n_bytes - 1)), "{}", home.line);
    }
}

/// Memory in use, in bytes.
fn resident() -> usize {
    let text = std::fs::read_to_string("/proc/self/status").expect("it is told");
    let line = text.lines().find(|line| line.starts_with("VmRSS:")).expect("its size");
    let kib = line.split_whitespace().nth(1).expect("a number");
    kib.parse::<usize>().expect("a number") << 10
}

#[test]
fn code_is_given_back() {
    let (program, surfaces) = load(PROGRAM);
    let compile = |n: usize| {
        for _ in 0..n / surfaces.len() {
            assert!(is_native(&Shaders::new(&program, &surfaces, LIMITS, Tiering::Eager)));
        }
    };
    let n_mappings = || mappings().iter().filter(|map| map.permissions.contains('x')).count();
    // The allocator takes what it needs at first, and keeps it.
    compile(N_COMPILES / 10);
    let (before, mapped) = (resident(), n_mappings());
    compile(N_COMPILES);
    let growth = resident().saturating_sub(before);
    println!("{N_COMPILES} compiles, {growth} bytes more");
    assert!(growth < MAX_GROWTH, "{growth} bytes more");
    assert!(n_mappings() <= mapped + 2, "{} mappings of code, {mapped} before", n_mappings());
}

const SCENE: &str = "\
{ /v /u /face u sin v addf /x x x 0.5 point 1.0 0.5 1.0 } /waves
0.5 0.5 0.5 point [] waves sphere 1 90.0 8 6 \"a.ppm\" render
";

#[test]
fn perf_is_told_of_shaders() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", SCENE).file("victim", "untouched");
    // The process keeps its number when the shell becomes the program.
    let script = format!(
        "echo $$; ln -s \"$PWD/victim\" /tmp/perf-$$.map; exec {} s.gml --engine jit --perf-map \
         --frames 1..2",
        env!("CARGO_BIN_EXE_gmlvm")
    );
    let mut shell = Command::new("sh");
    let output = shell.args(["-c", &script]).current_dir(sandbox.path(".")).output();
    let output = output.expect("sh runs");
    assert!(output.status.success(), "{output:?}");
    let number = String::from_utf8(output.stdout).expect("text");
    let path = format!("/tmp/perf-{}.map", number.trim());
    let is_link = std::fs::symlink_metadata(&path).expect("there is a map").is_symlink();
    let map = std::fs::read_to_string(&path).expect("text");
    std::fs::remove_file(&path).expect("it can be removed");
    assert!(!is_link);
    assert_eq!(sandbox.read("victim"), b"untouched");
    assert_eq!(map.lines().count(), 2, "a shader for each frame: {map}");
    for line in map.lines() {
        let words: Vec<_> = line.split(' ').collect();
        let [address, size, name] = words[..] else { panic!("{map}") };
        assert_eq!(name, "gmlvm::s.gml:1:1");
        let [address, size] = [address, size].map(|n| usize::from_str_radix(n, 16).expect("hex"));
        assert!(address > 0 && (32..4096).contains(&size), "{map}");
    }
}
