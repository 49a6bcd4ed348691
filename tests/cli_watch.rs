//! `run --watch`, and response files.

use std::fs;
use std::process::{Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::gmlvm::{PPM_HEADER, Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

const PATIENCE: Duration = Duration::from_secs(20);

/// A process that is ended with the test.
struct Watch(Child);

impl Watch {
    fn start(sandbox: &Sandbox, args: &[&str]) -> Self {
        let errors = fs::File::create(sandbox.path("stderr")).expect("a file");
        let mut command = sandbox.command(args);
        Watch(command.stdout(Stdio::null()).stderr(errors).spawn().expect("runs"))
    }

    fn end(&mut self) -> Option<i32> {
        let pid = Pid::from_raw(self.0.id() as i32).expect("a process");
        kill_process(pid, Signal::TERM).expect("it runs");
        self.0.wait().expect("ends").code()
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[track_caller]
fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < PATIENCE, "waiting in vain: {what}");
        thread::sleep(Duration::from_millis(10));
    }
}

/// The image, if there is one.
fn image(sandbox: &Sandbox) -> Option<Vec<u8>> {
    fs::read(sandbox.path("a.ppm")).ok()
}

fn said(sandbox: &Sandbox) -> String {
    String::from_utf8_lossy(&sandbox.read("stderr")).into_owned()
}

/// A ball of another brightness.
fn shade(ambient: &str) -> String {
    ball("a.ppm").replace("0.5 0.5 0.5 point", &format!("{ambient} {ambient} {ambient} point"))
}

#[test]
fn changes_are_rendered() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", shade("0.25"));
    let mut watch = Watch::start(&sandbox, &["s.gml", "--watch"]);
    wait_until("a first image", || image(&sandbox).is_some());
    let first = image(&sandbox).expect("there");
    // In place, as some editors save.
    sandbox.file("s.gml", shade("0.5"));
    wait_until("a second image", || image(&sandbox).is_some_and(|image| image != first));
    let second = image(&sandbox).expect("there");
    // By renaming, as others do; with an include that is not there yet.
    sandbox.file("new", "#include \"light.ins\"\n".to_owned() + &shade("x"));
    fs::rename(sandbox.path("new"), sandbox.path("s.gml")).expect("renamed");
    wait_until("an error", || said(&sandbox).contains("E0010"));
    assert_eq!(image(&sandbox), Some(second.clone()), "errors keep the last image");
    sandbox.file("light.ins", "0.75 /x\n");
    wait_until("an image again", || image(&sandbox).is_some_and(|image| image != second));
    let third = image(&sandbox).expect("there");
    // What is included is watched, and every image is whole.
    sandbox.file("light.ins", "1.0 /x\n");
    wait_until("a fourth image", || image(&sandbox).is_some_and(|image| image != third));
    assert!(image(&sandbox).expect("there").starts_with(PPM_HEADER));
    assert_eq!(watch.end(), Some(143));
    assert!(!said(&sandbox).contains("\u{1b}"), "{}", said(&sandbox));
}

/// A change ends the run that it makes useless, and the end of watching ends the last.
#[test]
fn runs_that_are_overtaken_end() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm").replace("8 6", "16000 16000"));
    let mut watch = Watch::start(&sandbox, &["run", "s.gml", "--watch", "--timeout", "500s"]);
    let runs = || {
        let parent = format!("PPid:\t{}\n", watch.0.id());
        let entries = fs::read_dir("/proc").into_iter().flatten().flatten();
        let statuses = entries.filter_map(|entry| {
            let status = fs::read_to_string(entry.path().join("status")).ok()?;
            status.contains(&parent).then(|| entry.path())
        });
        statuses.collect::<Vec<_>>()
    };
    if !fs::exists("/proc/self/status").is_ok_and(|exists| exists) {
        return eprintln!("skipped: no /proc here");
    }
    wait_until("a run", || runs().len() == 1);
    let first = runs();
    sandbox.file("s.gml", ball("a.ppm").replace("8 6", "16000 16001"));
    wait_until("another run", || runs().len() == 1 && runs() != first);
    let second = runs();
    assert!(!first[0].exists());
    assert_eq!(watch.end(), Some(143));
    wait_until("an end", || !second[0].exists());
    assert_eq!(image(&sandbox), None);
}

#[test]
fn the_standard_input_is_not_watched() {
    let sandbox = Sandbox::new();
    assert_eq!(sandbox.run(&["-", "--watch"]).code, 2);
}

#[test]
fn response_files() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm")).file("draft", "--size\n4x3\n\n  --output\r\nto be\n");
    sandbox.file("@s.gml", ball("b.ppm")).file("all", "run\ns.gml\n--format=png\n@nothing\n");
    let ended = sandbox.run(&["s.gml", "@draft"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(sandbox.read("to be").starts_with(b"P6\n# gmlvm\n4 3\n"));
    // Later options do not come from nowhere, and files name no files.
    let ended = sandbox.run(&["@all"]);
    assert!(ended.code == 2 && ended.stderr.contains("@nothing"), "{}", ended.stderr);
    assert_eq!(sandbox.run(&["./@s.gml"]).code, 0);
    for missing in ["@none", "@", "@.", "@/dev/zero", "@\u{1b}[2J"] {
        let ended = sandbox.run(&["s.gml", missing]);
        assert_eq!(ended.code, 2, "{missing}: {}", ended.stderr);
        assert!(
            ended.stderr.contains("`@") && !ended.stderr.contains('\u{1b}'),
            "{}",
            ended.stderr
        );
    }
}

/// What a response file names is not taken for a further one by the runs to come.
#[test]
fn response_files_are_read_once() {
    let sandbox = Sandbox::new();
    sandbox.file("@s.gml", ball("a.ppm")).file("all", "run\n@s.gml\n--watch\n");
    let mut watch = Watch::start(&sandbox, &["@all"]);
    wait_until("an image", || image(&sandbox).is_some());
    assert_eq!(watch.end(), Some(143));
}

/// Each run draws its image.
#[test]
fn watching_shows_previews() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", shade("0.25"));
    let mut watch = Watch::start(&sandbox, &["s.gml", "--watch", "--preview", "--color", "always"]);
    let n_rows = || said(&sandbox).matches("\u{1b}[0m\n").count();
    wait_until("a picture", || n_rows() == 3);
    sandbox.file("s.gml", shade("0.5"));
    wait_until("another picture", || n_rows() == 6);
    assert_eq!(watch.end(), Some(143));
}
