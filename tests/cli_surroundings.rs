//! Hostile surroundings: devices and pipes in the place of files, streams that are closed or full, a
//! full disk, files that a scene must not replace, and command lines that make no sense.

use std::fs::{self, File};
use std::process::{Command, Stdio};

use crate::gmlvm::{Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// What is no plain file: devices, links, directories, pipes.
#[test]
fn what_is_no_text_is_not_read() {
    let sandbox = Sandbox::new();
    let link = |to: &str, name: &str| {
        std::os::unix::fs::symlink(to, sandbox.path(name)).expect("a link");
    };
    link("/dev/zero", "zero");
    link("loop", "loop");
    fs::create_dir(sandbox.path("dir")).expect("a directory");
    let made = Command::new("mkfifo").arg(sandbox.path("fifo")).status().expect("mkfifo runs");
    assert!(made.success());
    for (args, exit) in [
        ("eval /dev/zero", 4),
        ("eval zero", 4),
        ("eval /dev/null", 0),
        ("eval loop", 2),
        ("eval dir", 2),
        ("diff /dev/zero /dev/zero", 2),
        ("diff dir dir", 2),
    ] {
        let (code, stderr) = sandbox.confined(args);
        assert_eq!(code, Some(exit), "{args}: {stderr}");
    }
    for name in ["zero", "loop", "dir", "fifo", "dir/none", "none", "/dev/zero", "../x"] {
        sandbox.file("s.gml", format!("#include \"{name}\"\n"));
        let (code, stderr) = sandbox.confined("eval s.gml -I dir -I none");
        assert_eq!(code, Some(1), "{name}: {stderr}");
        assert!(stderr.contains("error[E0010]") && stderr.contains("s.gml:1:10"), "{stderr}");
    }
}

/// Closed, full and broken streams.
#[test]
fn streams_fail_cleanly() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm")).file("n.gml", "1").file("x.gml", "x");
    for (args, exit) in [
        ("s.gml <&-", 0),
        ("s.gml >&- 2>&- <&-", 0),
        ("eval - <&-", 0),
        ("x.gml 2>&-", 1),
        ("x.gml 2>/dev/full", 1),
        ("s.gml 2>/dev/full", 0),
        ("s.gml --output - >/dev/full", 3),
        ("s.gml --stats - >/dev/full", 3),
        ("s.gml --stats /dev/full", 3),
        ("s.gml --output /dev/full", 3),
        ("eval n.gml >/dev/full", 3),
        ("disasm n.gml >/dev/full", 3),
        ("explain E0201 >/dev/full", 3),
    ] {
        let (code, stderr) = sandbox.confined(args);
        assert_eq!(code, Some(exit), "{args}: {stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
    }
    let mut command = sandbox.command(&["s.gml", "--output", "-", "--size", "900x900", "-q"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("runs");
    drop(child.stdout.take());
    let ended = child.wait_with_output().expect("ends");
    assert_eq!((ended.status.code(), ended.stderr.len()), (Some(141), 0));
}

#[test]
fn options_have_bounds() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm")).file("n.gml", "n").file("d/x", "");
    let before = sandbox.files();
    for (args, exit) in [
        (&["s.gml", "-j", "0"][..], 2),
        (&["s.gml", "-j", "100000"], 2),
        (&["s.gml", "-j", "-1"], 2),
        (&["s.gml", "--region", "8,0,1,1"], 2),
        (&["s.gml", "--region", "0,0,0,1"], 2),
        (&["s.gml", "--region", "4294967295,4294967295,4294967295,4294967295"], 2),
        (&["s.gml", "--size", "0x0"], 2),
        (&["s.gml", "--size", "4294967296x1"], 2),
        (&["s.gml", "--size", "1000000000x1000000000"], 4),
        (&["s.gml", "--depth", "-1"], 2),
        (&["s.gml", "--depth", "4294967296"], 2),
        (&["s.gml", "-q", "-v"], 2),
        (&["s.gml", "--output", "-", "--stats", "-"], 2),
        (&["s.gml", "--output", "{nope}.ppm"], 2),
        (&["s.gml", "--output", "{n"], 2),
        (&["s.gml", "--output", ""], 2),
        (&["s.gml", "--output", "new/"], 2),
        (&["s.gml", "--output", ".."], 3),
        (&["s.gml", "--output", "n.gml/x"], 3),
        (&["s.gml", "-o", "n.gml"], 3),
        (&["s.gml", "--max-memory", "0"], 4),
        (&["s.gml", "--max-pixels", "0"], 4),
        (&["s.gml", "--fuel", "0"], 4),
        (&["s.gml", "--fuel", "18446744073709551616"], 2),
        (&["s.gml", "--max-memory", "99999999999T"], 2),
        (&["eval", "n.gml", "-D", "=1"], 2),
        (&["eval", "n.gml", "-D", "n=1e999"], 2),
        (&["eval", "n.gml", "-D", "n=\"a"], 2),
        (&["eval", "n.gml", "-D", "\u{e9}=1"], 2),
        (&["eval", "n.gml", "n.gml"], 2),
        (&["explain", "EE0201"], 2),
        (&["explain", ""], 2),
        (&["disasm", "n.gml", "--emit", ""], 2),
        (&["-v"], 2),
        (&[], 2),
        (&["no\u{1b}[2Jfile"], 2),
    ] {
        let ended = sandbox.run(args);
        assert_eq!(ended.code, exit, "{args:?}: {}", ended.stderr);
        assert!(!ended.stderr.is_empty() && !ended.stderr.contains('\u{1b}'), "{:?}", ended.stderr);
        assert_eq!(sandbox.files(), before, "{args:?}");
    }
    let mut command = sandbox.command(&["s.gml"]);
    let ended = command.env("RAYON_NUM_THREADS", "100000").output().expect("runs");
    assert_eq!(ended.status.code(), Some(2));
    let ended = sandbox.run(&["s.gml", "--stats", "n.gml/x"]);
    assert_eq!(ended.code, 3);
    assert!(ended.stderr.contains("not a directory"), "{}", ended.stderr);
    let ended = sandbox.run(&["eval", "n.gml", "-D", "n=1", "-D", "n=2"]);
    assert_eq!(ended.text(), "2\n");
}

/// The full disk of a file system of 64 kilobytes; where users may mount one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing_behind() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a/b.ppm")).file("disk/x", "");
    let binary = env!("CARGO_BIN_EXE_gmlvm");
    let script = format!(
        "mount -t tmpfs -o size=64k none disk && mkdir disk/a && echo old >disk/a/b.ppm || exit 99
         {binary} s.gml -o disk --size 400x400; code=$?
         ls -A disk disk/a | tr '\\n' ' '; cat disk/a/b.ppm; exit $code"
    );
    let Some(output) = sandbox.mounting(&script) else { return };
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    assert!(stderr.contains("could not write `disk/a/b.ppm`: no space left"), "{stderr}");
    let shown = String::from_utf8_lossy(&output.stdout);
    assert_eq!(shown, "disk: a  disk/a: b.ppm old\n");
}

/// A scene replaces images, and nothing else that lies about.
#[test]
fn only_images_are_replaced() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("s.gml")).file("t.gml", ball("notes")).file("notes", "mine");
    sandbox.file("u.gml", ball(".bashrc")).file("v.gml", ball("a/.git/x.ppm"));
    let before = sandbox.files();
    for (scene, text) in [
        ("s.gml", "is that of a file that is no image"),
        ("t.gml", "is that of a file that is no image"),
        ("u.gml", "has a hidden component"),
        ("v.gml", "has a hidden component"),
    ] {
        let ended = sandbox.run(&[scene]);
        assert_eq!(ended.code, 5, "{scene}: {}", ended.stderr);
        assert!(ended.stderr.contains(text), "{scene}: {}", ended.stderr);
        assert_eq!(sandbox.files(), before);
    }
    assert_eq!(sandbox.run(&["check", "u.gml"]).code, 5);
    assert_eq!(
        (sandbox.read("notes"), sandbox.read("s.gml")),
        ("mine".into(), ball("s.gml").into())
    );
    // The user may, an empty file is free, and so is what is called an image or is one.
    assert_eq!(sandbox.run(&["t.gml", "--output", "notes"]).code, 0);
    assert_eq!(sandbox.run(&["t.gml"]).code, 0);
    File::create(sandbox.path("notes")).expect("a file");
    assert_eq!(sandbox.run(&["t.gml"]).code, 0);
    sandbox.file("a.ppm", "mine").file("w.gml", ball("a.ppm"));
    assert_eq!(sandbox.run(&["w.gml"]).code, 0);
}

/// The message marks the scene's name only where it is the one in question.
#[test]
fn names_of_the_command_line_are_not_blamed_on_the_scene() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    let ended = sandbox.run(&["s.gml", "--output", "/dev/full"]);
    assert!(!ended.stderr.contains("this name"), "{}", ended.stderr);
    let ended = sandbox.run(&["s.gml", "-o", "s.gml"]);
    assert!(ended.stderr.contains("this name"), "{}", ended.stderr);
    let ended = sandbox.run(&["s.gml", "--output", "b.ppm"]);
    assert!(ended.stderr.starts_with("b.ppm  8x6  "), "{}", ended.stderr);
}
