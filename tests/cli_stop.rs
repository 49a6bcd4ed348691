//! Runs that are ended from outside: by a signal, by the clock, by a limit of the shell. Each ends at
//! once, says why, and leaves nothing torn behind.

use std::fs;
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::gmlvm::{Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// The aim for the time from a signal to the end.
const AIM: Duration = Duration::from_millis(100);

/// The machine may be busy with other tests: the best of so many tries counts.
const TRIES: usize = 5;

/// More fuel than any test waits for.
const FUEL: &str = "1000000000000000";

/// A scene that fills its sandbox with work of one kind, with no end in sight.
fn endless() -> Sandbox {
    let sandbox = Sandbox::new();
    let ball = ball("a.ppm");
    let shade = "/v /u /face { /f /n n 0.0 lessf { n } { n 1.0 addf f f apply } if } /f \
                 1.0 f f apply /x x x x point 1.0 0.0 1.0";
    sandbox
        .file("program.gml", "{ /self self self apply } /loop loop loop apply")
        .file("surface.gml", ball.replace("/v /u /face 1.0 1.0 1.0 point 1.0 0.0 1.0", shade))
        .file("image.gml", ball.replace("8 6", "16000 16000"))
        .file(
            "images.gml",
            format!("{{ /self {ball} self self apply }} /loop loop loop apply")
                .replace("0.5 0.5 0.5 point []", "1.0 1.0 1.0 point []"),
        );
    sandbox
}

/// Every kind of work, as arguments.
const WORK: [&[&str]; 6] = [
    &["eval", "program.gml", "--fuel", FUEL],
    &["surface.gml", "--fuel", FUEL, "--engine", "interp"],
    &["surface.gml", "--fuel", FUEL, "--engine", "jit"],
    &["surface.gml", "--fuel", FUEL, "--precision", "certified"],
    &["image.gml"],
    &["image.gml", "--engine", "jit", "-j", "3"],
];

/// No process of a test needs longer; one that does is killed.
const PATIENCE: Duration = Duration::from_secs(60);

/// Starts it with the usual answers to signals, whatever whoever runs the tests wants ignored.
fn start(command: Command) -> Child {
    let mut usual = Command::new("env");
    usual.arg("--default-signal=HUP,INT,TERM").arg(command.get_program()).args(command.get_args());
    usual.current_dir(command.get_current_dir().expect("a sandbox")).stdin(Stdio::null());
    let child = usual.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("runs");
    thread::sleep(Duration::from_millis(250));
    child
}

fn signal(child: &Child, signal: Signal) {
    let pid = Pid::from_raw(child.id() as i32).expect("a process");
    kill_process(pid, signal).expect("it runs");
}

/// Waits for the end; returns the exit code and what was said.
fn end(mut child: Child) -> (Option<i32>, String) {
    let mut said = String::new();
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("asks") {
            break status;
        }
        if started.elapsed() > PATIENCE {
            child.kill().expect("it runs");
        }
        thread::sleep(Duration::from_millis(1));
    };
    child.stderr.take().expect("piped").read_to_string(&mut said).expect("text");
    (status.code(), said)
}

#[test]
fn signals_end_any_work_at_once() {
    let sandbox = endless();
    let before = sandbox.files();
    for (idx, args) in WORK.iter().enumerate() {
        let (sent, code) = [(Signal::INT, 130), (Signal::TERM, 143), (Signal::HUP, 129)][idx % 3];
        let mut best = Duration::MAX;
        for _ in 0..TRIES {
            let child = start(sandbox.command(args));
            let sent_at = Instant::now();
            signal(&child, sent);
            let ended = end(child);
            best = best.min(sent_at.elapsed());
            assert_eq!(ended, (Some(code), String::new()), "{args:?}");
            assert_eq!(sandbox.files(), before, "{args:?}");
            if best <= AIM {
                break;
            }
        }
        assert!(best <= AIM, "{args:?} took {best:?}");
    }
}

/// A process that waits for a pipe to be read is not waited for.
#[test]
fn signals_end_a_run_that_is_stuck() {
    let sandbox = endless();
    sandbox.file("s.gml", ball("a.ppm"));
    let mut command = sandbox.command(&["s.gml", "--output", "-", "--size", "500x500"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().expect("runs");
    thread::sleep(Duration::from_millis(500));
    signal(&child, Signal::TERM);
    assert_eq!(child.wait_with_output().expect("ends").status.code(), Some(143));
    // The time limit has something to say, but the pipe is full and nobody reads it.
    let script = format!(
        "{{ head -c 65536 /dev/zero >&2; {} image.gml --timeout 700ms; echo $? >code; }} \
         2>&1 >/dev/null | sleep 5 & sleep 4; cat code",
        env!("CARGO_BIN_EXE_gmlvm")
    );
    let mut shell = Command::new("sh");
    let output = shell.args(["-c", &script]).current_dir(sandbox.path(".")).output();
    assert_eq!(String::from_utf8_lossy(&output.expect("runs").stdout), "4\n");
}

/// What `nohup` and shells want ignored stays ignored.
#[test]
fn ignored_signals_stay_ignored() {
    let sandbox = endless();
    let mut shell = Command::new("sh");
    let script = format!("trap '' INT HUP; exec {} image.gml", env!("CARGO_BIN_EXE_gmlvm"));
    shell.args(["-c", &script]).current_dir(sandbox.path("."));
    let mut child = start(shell);
    signal(&child, Signal::INT);
    signal(&child, Signal::HUP);
    thread::sleep(Duration::from_millis(200));
    assert_eq!(child.try_wait().expect("asks"), None);
    signal(&child, Signal::TERM);
    assert_eq!(end(child).0, Some(143));
}

#[test]
fn the_clock_ends_any_work() {
    let sandbox = endless();
    let before = sandbox.files();
    let checked: [&[&str]; 2] = [
        &["check", "program.gml", "--fuel", FUEL],
        &["disasm", "program.gml", "--emit", "clif", "--fuel", FUEL],
    ];
    for args in WORK.iter().chain(&checked) {
        let limit = Duration::from_millis(300);
        let mut best = Duration::MAX;
        for _ in 0..TRIES {
            let begun = Instant::now();
            let ended = sandbox.run(&[args, &["--timeout", "300ms"][..]].concat());
            best = best.min(begun.elapsed());
            assert_eq!(ended.code, 4, "{args:?}: {}", ended.stderr);
            assert!(ended.stderr.contains("error[E0405]: the time limit of 0.3 s is reached"));
            assert!(ended.stderr.contains("`--timeout SECONDS`"), "{}", ended.stderr);
            let is_rendering = args[0].contains("image") || args[0].contains("surface");
            assert_eq!(ended.stderr.contains("`a.ppm` was being rendered"), is_rendering);
            assert_eq!(sandbox.files(), before, "{args:?}");
            if best <= limit + AIM {
                break;
            }
        }
        assert!(best <= limit + AIM, "{args:?} took {best:?}");
    }
    // Whoever is done in time hears nothing of it.
    sandbox.file("s.gml", ball("b.ppm"));
    assert_eq!(sandbox.run(&["s.gml", "--timeout", "60"]).code, 0);
    let ended = sandbox.run(&["s.gml", "--timeout", "0"]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    let json = ["image.gml", "--timeout", "100ms", "--message-format", "json"];
    assert!(sandbox.run(&json).stderr.contains("\"code\":\"E0405\""));
}

/// Images that were finished stay, the one that was not does not appear, and no temporary name is left
/// where files cannot do without: there is no `/proc` here to name them from.
#[cfg(target_os = "linux")]
#[test]
fn no_temporary_name_is_left() {
    let sandbox = endless();
    let script = format!(
        "mount -t tmpfs none /proc || exit 99
         for try in 1 2 3 4 5 6 7 8 9 10; do
             {} images.gml -q -o out --max-images 1000000 & sleep 0.$((20 + try)); kill -TERM $!; wait $!
             [ $? = 143 ] || exit 1
         done; ls -A out",
        env!("CARGO_BIN_EXE_gmlvm")
    );
    let Some(output) = sandbox.mounting(&script) else { return };
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "a.ppm\n");
}

/// A process that cannot even be told leaves nothing half-written either.
#[test]
fn a_killed_process_leaves_whole_files_or_none() {
    let sandbox = endless();
    let whole = {
        sandbox.file("s.gml", ball("b.ppm"));
        assert_eq!(sandbox.run(&["s.gml"]).code, 0);
        sandbox.read("b.ppm").len()
    };
    for idx in 0..20 {
        let mut command = sandbox.command(&["images.gml", "-q", "-o", "out"]);
        let mut child = command.stderr(Stdio::null()).spawn().expect("runs");
        thread::sleep(Duration::from_millis(20 + 7 * idx));
        signal(&child, Signal::KILL);
        child.wait().expect("ends");
        for entry in fs::read_dir(sandbox.path("out")).into_iter().flatten() {
            let entry = entry.expect("readable");
            // A name that waited to become the file's stands for a whole file.
            assert_eq!(entry.metadata().expect("readable").len(), whole as u64, "{entry:?}");
        }
    }
    assert_eq!(sandbox.read("out/a.ppm").len(), whole);
}

/// The terminal's last line is the shell's again.
#[test]
fn the_progress_bar_is_cleared() {
    let sandbox = endless();
    let line = format!("timeout --foreground -s INT 1 {} image.gml", env!("CARGO_BIN_EXE_gmlvm"));
    let mut script = Command::new("script");
    script.args(["-qec", &line, "/dev/null"]).current_dir(sandbox.path(".")).stdin(Stdio::null());
    let Ok(output) = script.env("TERM", "xterm").output() else {
        return eprintln!("skipped: no `script` here");
    };
    let shown = String::from_utf8_lossy(&output.stdout);
    assert!(shown.contains("a.ppm  ["), "no bar: {shown:?}");
    let (_, after) = shown.rsplit_once("left").expect("a bar");
    assert!(after.contains("\u{1b}[2K"), "the bar stays: {after:?}");
}

/// The shell's limit for files is an error like any other.
#[cfg(target_os = "linux")]
#[test]
fn a_file_size_limit_is_an_error() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm")).file("a.ppm", "old");
    let binary = env!("CARGO_BIN_EXE_gmlvm");
    for (options, shown) in [("", "`a.ppm`"), ("-o out", "`out/a.ppm`"), ("--output b", "`b`")] {
        let script = format!("ulimit -f 8; exec {binary} s.gml --size 400x400 {options}");
        let mut shell = Command::new("sh");
        let output = shell.args(["-c", &script]).current_dir(sandbox.path(".")).output();
        let output = output.expect("sh runs");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{stderr}");
        let message = format!("could not write {shown}: file too large");
        assert!(stderr.contains(&message), "{stderr}");
    }
    assert_eq!(sandbox.read("a.ppm"), b"old");
    assert!(!sandbox.files().iter().any(|file| file.ends_with("tmp") || file.ends_with('b')));
}

#[test]
fn a_directory_that_is_not_ours_to_write_is_an_error() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm")).file("locked/x", "");
    // Root may write anywhere, but not where the file system is mounted to be read only.
    for (target, options) in [("locked", "-o locked"), (".", "--output locked/b.ppm")] {
        let script = format!(
            "mount --bind locked locked && mount -o remount,ro,bind locked || exit 99
             cd {}; {} s.gml {options}",
            sandbox.path(".").display(),
            env!("CARGO_BIN_EXE_gmlvm")
        );
        let Some(output) = sandbox.mounting(&script) else { return };
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{target}: {stderr}");
        assert!(stderr.contains("read-only file system"), "{target}: {stderr}");
    }
    assert_eq!(sandbox.files(), ["locked/", "locked/x", "s.gml"]);
}
