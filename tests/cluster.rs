//! The scripts of `contrib/` on real GNU parallel and Slurm, with a shard killed midway; where they are
//! not installed these tests say `skipped`. The manifest for Kubernetes is held to what gmlvm takes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::gmlvm::Sandbox;

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

const BINARY: &str = env!("CARGO_BIN_EXE_gmlvm");

/// Sizes of images. A task is to be killed in the middle, so where it ends before that, the next size is
/// tried.
const SIZES: [&str; 3] = ["600x400", "1800x1200", "5400x3600"];

/// The exit code of a session whose task was too quick to be killed.
const TOO_QUICK: i32 = 98;

const PATIENCE: Duration = Duration::from_secs(120);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn has(program: &str) -> bool {
    let found = Command::new("sh").args(["-c", &format!("command -v {program}")]).output();
    found.is_ok_and(|output| output.status.success())
}

/// A sandbox with a scene that takes a while, and in `single/` what a single run makes of it.
fn sandbox(size: &str) -> Sandbox {
    let sandbox = Sandbox::new();
    let shiny = "{ /v /u /face u v u point 0.7 0.9 9.0 }";
    let spheres: String = (0..24)
        .map(|n| {
            let (x, z) = (f64::from(n % 6) - 2.5, f64::from(n / 6) + 2.5);
            format!("{shiny} sphere 0.4 uscale {x:?} 0.0 {z:?} translate union ")
        })
        .collect();
    sandbox.file(
        "s.gml",
        format!(
            "0.3 0.3 0.3 point [ 1.0 -1.0 1.0 point 1.0 1.0 1.0 point light ] {shiny} plane 0.0 -1.0 0.0 \
             translate {spheres} 9 70.0 60 40 \"a.ppm\" render"
        ),
    );
    let ended = sandbox.run(&["s.gml", "-o", "single", "--size", size]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    sandbox
}

fn command(sandbox: &Sandbox, program: impl Into<PathBuf>) -> Command {
    let mut command = Command::new(program.into());
    command.current_dir(sandbox.path(".")).env("GMLVM", BINARY).env("OUT", "out");
    command.env_remove("PARALLEL").stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn n_parts(sandbox: &Sandbox) -> usize {
    let entries = fs::read_dir(sandbox.path("p")).into_iter().flatten().flatten();
    entries.filter(|entry| entry.path().extension().is_some_and(|e| e == "part")).count()
}

#[track_caller]
fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < PATIENCE, "waiting in vain for: {what}");
        thread::sleep(Duration::from_millis(10));
    }
}

/// Waits for the end; returns whether that was a success, and what was said.
fn ended(child: Child) -> (bool, String) {
    let output = child.wait_with_output().expect("ends");
    (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[track_caller]
fn is_the_single_image(sandbox: &Sandbox) {
    assert!(sandbox.read("out/a.ppm") == sandbox.read("single/a.ppm"));
}

/// The process that renders a shard in this sandbox.
fn process_of(sandbox: &Sandbox, shard: &str) -> Option<String> {
    let here = fs::canonicalize(sandbox.path(".")).expect("there");
    fs::read_dir("/proc").ok()?.flatten().find_map(|entry| {
        let process = entry.path();
        let line = fs::read(process.join("cmdline")).ok()?;
        let line = String::from_utf8_lossy(&line);
        let is_it = line.starts_with(BINARY) && line.contains(&format!("--shard\0{shard}\0"));
        let is_here = fs::read_link(process.join("cwd")).is_ok_and(|directory| directory == here);
        (is_it && is_here).then(|| entry.file_name().to_string_lossy().into_owned())
    })
}

#[cfg(target_os = "linux")]
#[test]
fn gnu_parallel() {
    if !has("parallel") {
        return eprintln!("skipped: GNU parallel is not installed");
    }
    assert!(
        SIZES.into_iter().any(parallel_with_a_kill),
        "each shard was done before it was killed"
    );
}

/// Renders with GNU parallel, one shard killed midway; returns false if that was done before.
#[cfg(target_os = "linux")]
fn parallel_with_a_kill(size: &str) -> bool {
    let sandbox = sandbox(size);
    let script = root().join("contrib/render-parallel.sh");
    let mut command = command(&sandbox, &script);
    let child = command.args(["s.gml", "p", "3", "--size", size]).spawn().expect("runs");
    let mut killed = None;
    wait_until("shard 2, or all", || {
        killed = process_of(&sandbox, "2/3");
        killed.is_some() || sandbox.path("out/a.ppm").exists()
    });
    let n_before = n_parts(&sandbox);
    wait_until("parts", || {
        n_parts(&sandbox) > n_before + 2 || process_of(&sandbox, "2/3").is_none()
    });
    let is_killed = killed.is_some_and(|process| {
        Command::new("kill").args(["-9", &process]).status().expect("kill runs").success()
    });
    let (is_done, said) = ended(child);
    assert!(is_done, "{said}");
    is_the_single_image(&sandbox);
    // What it had done was there when the shard was tried again.
    let again: Vec<_> = said.lines().filter(|line| line.contains("shard 2/3")).collect();
    assert_eq!(again.len(), 1, "{said}");
    is_killed && again[0].contains("of them there already")
}

/// Without `--shard K/N` in the command, each job takes its number from GNU parallel.
#[test]
fn gnu_parallel_numbers_its_jobs() {
    if !has("parallel") {
        return eprintln!("skipped: GNU parallel is not installed");
    }
    let size = SIZES[0];
    let sandbox = sandbox(size);
    let line = format!(
        "seq 4 | GMLVM_SHARDS=4 parallel -N0 {BINARY} run s.gml --size {size} --parts p --shard auto -j 1"
    );
    let (is_done, said) = ended(command(&sandbox, "sh").args(["-c", &line]).spawn().expect("runs"));
    assert!(is_done && said.contains("shard 4/4"), "{said}");
    let merged = sandbox.run(&["merge", "p", "-o", "out"]);
    assert_eq!(merged.code, 0, "{}", merged.stderr);
    is_the_single_image(&sandbox);
}

#[cfg(target_os = "linux")]
#[test]
fn slurm_array() {
    if let Some(missing) = ["slurmctld", "slurmd", "munged", "sbatch"].iter().find(|p| !has(p)) {
        return eprintln!("skipped: {missing} is not installed");
    }
    assert!(SIZES.into_iter().any(slurm_with_a_kill), "each task was done before it was killed");
}

/// Renders as a job array of Slurm's, one task killed midway; returns false if that was done before.
#[cfg(target_os = "linux")]
fn slurm_with_a_kill(size: &str) -> bool {
    let sandbox = sandbox(size);
    let script = root().join("contrib/render-slurm.sh");
    let script = script.display();
    let wait = "while [ -n \"$(squeue -h)\" ]; do sleep 0.2; done";
    // One task is killed when there are some parts; then all of it is started again.
    let session = format!(
        "set -e
         jobs=$({script} s.gml p 3 --size {size}); array=${{jobs% *}}
         until [ \"$(ls p | grep -c part)\" -gt 4 ]; do sleep 0.02; done
         until scancel --signal KILL --full ${{array}}_2; do
             [ -n \"$(squeue -h -j ${{array}}_2)\" ] || exit {TOO_QUICK}; sleep 0.1
         done
         {wait}
         ls p | grep -c part; ls out 2>&1 || true
         {script} s.gml p 3 --size {size}
         {wait}
         cat p/*.log"
    );
    let cluster = root().join("tests/support/slurm.sh");
    let directory = sandbox.path("slurm").display().to_string();
    let mut command = command(&sandbox, cluster);
    let child = command.args([&directory, "sh", "-c", &session]).spawn().expect("runs");
    let output = child.wait_with_output().expect("ends");
    let [shown, said] =
        [output.stdout, output.stderr].map(|b| String::from_utf8_lossy(&b).into_owned());
    match output.status.code() {
        Some(TOO_QUICK) => return false,
        Some(99) => {
            eprintln!("skipped: no Slurm to be started here: {said}");
            return true;
        }
        code => assert_eq!(code, Some(0), "{shown}\n{said}"),
    }
    // It may have been done when the signal arrived.
    if !shown.contains("cannot access 'out'") {
        return false;
    }
    let n_before: usize = shown.lines().next().expect("a number").parse().expect("a number");
    assert!(n_before >= 5, "{shown}");
    assert!(shown.contains("shard 2/3, ") && shown.contains("of them there already"), "{shown}");
    is_the_single_image(&sandbox);
    true
}

/// What the manifest has a pod run is a command of ours, and its numbers agree.
#[test]
fn kubernetes_manifest() {
    let manifest =
        fs::read_to_string(root().join("contrib/render-kubernetes.yaml")).expect("there");
    let line = |start: &str| {
        let mut lines = manifest.lines().map(str::trim);
        lines.find_map(|line| line.strip_prefix(start)).unwrap_or_else(|| panic!("no {start}"))
    };
    let shards = line("completions: ").trim_end_matches(" # shards");
    assert_eq!(line("value: ").trim_end_matches(" # shards"), format!("\"{shards}\""));
    assert_eq!(line("completionMode: "), "Indexed");
    let words = line("command: [gmlvm, ").trim_end_matches(']').replace('"', "");
    let args: Vec<_> = words.split(", ").collect();
    let sandbox = Sandbox::new();
    sandbox.file("scene.gml", gmlvm::ball("a.ppm"));
    for index in 0..shards.parse().expect("a number") {
        let index: u32 = index;
        let mut command = sandbox.command(&args);
        command.env("JOB_COMPLETION_INDEX", index.to_string()).env("GMLVM_SHARDS", shards);
        let output = command.output().expect("runs");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(stderr.contains(&format!("shard {}/{shards}", index + 1)), "{stderr}");
    }
    assert_eq!(sandbox.run(&["merge", "parts"]).code, 0);
    assert_eq!(sandbox.run(&["scene.gml", "-o", "single"]).code, 0);
    assert_eq!(sandbox.read("a.ppm"), sandbox.read("single/a.ppm"));
}
