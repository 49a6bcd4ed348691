//! Where images go: names from scenes and from the user, streams, formats, and what stays as it was.

use std::fs;
use std::io::Read;
use std::process::{Command, Stdio};

use crate::gmlvm::{PPM_HEADER, Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

#[test]
fn standard_input_and_output() {
    let sandbox = Sandbox::new();
    let scene = ball("a.ppm");
    let ended = sandbox.run_with(&["-"], scene.as_bytes());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let ended = sandbox.run_with(&["run", "-", "--output", "-"], scene.as_bytes());
    assert_eq!((ended.code, ended.stdout), (0, sandbox.read("a.ppm")), "{}", ended.stderr);
    let args = ["run", "-", "--output", "-", "--format", "png"];
    assert!(sandbox.run_with(&args, scene.as_bytes()).stdout.starts_with(b"\x89PNG"));
    let two = scene.repeat(2);
    let ended = sandbox.run_with(&["run", "-", "--output", "-"], two.as_bytes());
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("more than one image"), "{}", ended.stderr);
    let args = ["-", "--output", "-", "--stats", "-"];
    assert_eq!(sandbox.run_with(&args, scene.as_bytes()).code, 2);
}

#[test]
fn a_closed_pipe_is_no_error_to_speak_of() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    let mut command = sandbox.command(&["s.gml", "--output", "-", "--size", "400x400", "-q"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("runs");
    let mut stdout = child.stdout.take().expect("piped");
    stdout.read_exact(&mut [0]).expect("a byte");
    drop(stdout);
    let output = child.wait_with_output().expect("ends");
    assert_eq!(output.status.code(), Some(141));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_an_error() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
    for args in
        [&["eval", "s.gml", "-D", "n=1"][..], &["s.gml", "--output", "-"], &["explain", "E0001"]]
    {
        let output = sandbox.command(args).stdout(full()).stderr(Stdio::piped()).output();
        let output = output.expect("runs");
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        if args[0] == "eval" {
            // The stack is empty: there is nothing to write.
            assert_eq!(output.status.code(), Some(0), "{stderr}");
            continue;
        }
        assert_eq!(output.status.code(), Some(3), "{args:?} {stderr}");
        assert!(stderr.contains("no space left on device"), "{stderr}");
    }
    let ended = sandbox.run(&["s.gml", "--output", "/dev/full"]);
    assert_eq!(ended.code, 3, "{}", ended.stderr);
    assert!(ended.stderr.contains("E0601") && ended.stderr.contains("no space left"));
}

/// Scenes are not trusted: whatever they call their images, nothing outside changes.
#[test]
fn names_that_lead_elsewhere_are_refused() {
    let deep = "a/".repeat(2100);
    let long = "a".repeat(256);
    let names = [
        "",
        ".",
        "..",
        "/",
        "/etc/x",
        "//x",
        "../x",
        "a/../../x",
        "a/..",
        "./x",
        "a/./x",
        "a//x",
        "a/",
        "a\\x",
        "..\\x",
        "C:\\x",
        "link",
        "link/x",
        "out/x",
        "/dev/null",
        "/proc/self/mem",
        &deep,
        &long,
    ];
    for name in names {
        let sandbox = Sandbox::new();
        sandbox.file("in/s.gml", ball(name)).file("victim/x", "precious").file("in/a/keep", "");
        std::os::unix::fs::symlink("../victim/x", sandbox.path("in/link")).expect("a link");
        std::os::unix::fs::symlink("../victim", sandbox.path("in/out")).expect("a link");
        let before = sandbox.files();
        let mut command = sandbox.command(&["s.gml"]);
        let output = command.current_dir(sandbox.path("in")).output().expect("runs");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(5), "{name}: {stderr}");
        assert!(stderr.contains("E0501"), "{name}: {stderr}");
        assert_eq!(sandbox.files(), before, "{name}");
        assert_eq!(sandbox.read("victim/x"), b"precious");
    }
}

/// A link is refused for being one, also where it leads to no file or to an image, which could be
/// written otherwise.
#[test]
fn links_are_not_followed() {
    for (name, why) in [
        ("out/new.ppm", "leads through the link `out`"),
        ("out/old.ppm", "leads through the link `out`"),
        ("out/made/new.ppm", "leads through the link `out`"),
        ("below/out/new.ppm", "leads through the link `out`"),
        ("new.ppm", "is that of a symbolic link"),
        ("old.ppm", "is that of a symbolic link"),
    ] {
        let sandbox = Sandbox::new();
        sandbox.file("in/s.gml", ball(name)).file("victim/old.ppm", "P6 1 1 255 abc");
        sandbox.file("in/below/keep", "");
        for (to, link) in [
            ("../victim", "in/out"),
            ("../../victim", "in/below/out"),
            ("../victim/new.ppm", "in/new.ppm"),
            ("../victim/old.ppm", "in/old.ppm"),
        ] {
            std::os::unix::fs::symlink(to, sandbox.path(link)).expect("a link");
        }
        let mut command = sandbox.command(&["s.gml"]);
        let output = command.current_dir(sandbox.path("in")).output().expect("runs");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(5), "{name}: {stderr}");
        assert!(stderr.contains(why), "{name}: {stderr}");
        let victims = std::fs::read_dir(sandbox.path("victim")).expect("a directory");
        assert_eq!(victims.count(), 1, "{name}");
        assert_eq!(sandbox.read("victim/old.ppm"), b"P6 1 1 255 abc", "{name}");
    }
}

#[test]
fn control_characters_in_names_are_refused_and_not_shown() {
    for name in ["a\u{1b}[2Jb", "a\nb", "a\u{7f}", "a\u{9b}b"] {
        let sandbox = Sandbox::new();
        sandbox.file("s.gml", ball("x").replace("\"x\"", "name"));
        let ended = sandbox.run(&["s.gml", "-D", &format!("name={name}")]);
        assert_eq!(ended.code, 5, "{}", ended.stderr);
        let is_raw = |c: char| c.is_control() && c != '\n';
        assert!(!ended.stderr.contains(is_raw), "{:?}", ended.stderr);
        assert_eq!(sandbox.files(), ["s.gml"]);
    }
}

#[test]
fn what_is_no_file_is_not_replaced() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a")).file("a/b", "").file("t.gml", ball("f"));
    sandbox.file("u.gml", ball("s.gml/x/y")).file("v.gml", ball("new/../x"));
    let made = Command::new("mkfifo").arg(sandbox.path("f")).status().expect("mkfifo runs");
    assert!(made.success());
    let before = sandbox.files();
    for (scene, code, text) in [
        ("s.gml", 3, "a directory is in its place"),
        ("t.gml", 3, "something that is no file"),
        ("u.gml", 3, "`s.gml` is not a directory"),
        ("v.gml", 5, "leaves the output directory"),
    ] {
        let ended = sandbox.run(&[scene]);
        assert_eq!(ended.code, code, "{}", ended.stderr);
        assert!(ended.stderr.contains(text), "{}", ended.stderr);
        assert_eq!(sandbox.files(), before);
    }
}

#[test]
fn directories_are_made_and_files_replaced() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a/b/c.ppm")).file("out/a/b/c.ppm", "old");
    assert_eq!(sandbox.run(&["s.gml", "-o", "out"]).code, 0);
    assert!(sandbox.read("out/a/b/c.ppm").starts_with(PPM_HEADER));
    assert_eq!(sandbox.run(&["s.gml", "-o", "deep/er"]).code, 0);
    assert!(sandbox.read("deep/er/a/b/c.ppm").starts_with(PPM_HEADER));
    sandbox.file("twice.gml", ball("t.ppm") + &ball("t.ppm").replace("8 6", "4 3"));
    let ended = sandbox.run(&["twice.gml"]);
    assert_eq!((ended.code, ended.stderr.lines().count()), (0, 2), "{}", ended.stderr);
    assert!(sandbox.read("t.ppm").starts_with(b"P6\n# gmlvm\n4 3\n"));
    assert!(!sandbox.files().iter().any(|file| file.contains(".tmp")));
}

#[test]
fn a_failing_surface_leaves_nothing_behind() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a/b.ppm").replace("1.0 0.0 1.0 }", "1.0 0.0 }"));
    let ended = sandbox.run(&["s.gml", "-o", "out"]);
    assert_eq!(ended.code, 1);
    assert!(ended.stderr.contains("first met at pixel ("), "{}", ended.stderr);
    assert_eq!(sandbox.files(), ["s.gml"]);
}

#[test]
fn names_of_the_user_are_taken() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("x/first.ppm") + &ball("second"));
    assert_eq!(sandbox.run(&["s.gml", "--output", "{n}-{name}.png", "-o", "o"]).code, 0);
    assert_eq!(sandbox.files(), ["o/", "o/1-first.png", "o/2-second.png", "s.gml"]);
    assert!(sandbox.read("o/2-second.png").starts_with(b"\x89PNG"));
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("../x.ppm")).file("real", "old");
    std::os::unix::fs::symlink("real", sandbox.path("link")).expect("a link");
    assert_eq!(sandbox.run(&["s.gml", "--output", "link"]).code, 0);
    assert!(sandbox.read("real").starts_with(PPM_HEADER));
    assert!(sandbox.path("link").is_symlink());
    assert_eq!(sandbox.run(&["s.gml", "--output", "{name}.ppm"]).code, 5);
    assert_eq!(sandbox.run(&["s.gml", "--output", "/dev/null"]).code, 0);
}

/// What a scene fills in is trusted as little as a name that it gives.
#[test]
fn names_that_are_filled_in_replace_no_more_than_others() {
    for (name, template, why) in [
        ("notes.txt.ppm", "{name}", "is that of a file that is no image"),
        ("notes.ppm", "{name}.txt", "is that of a file that is no image"),
        ("link.ppm", "{name}.ppm", "is that of a symbolic link"),
        ("elsewhere.ppm", "{name}/a.ppm", "leads through the link `elsewhere`"),
        (".bashrc.ppm", "{name}", "has a hidden component"),
    ] {
        let sandbox = Sandbox::new();
        sandbox.file("s.gml", ball(name)).file("o/notes.txt", "precious").file("victim/x", "P6");
        for (to, link) in [("../victim/x", "o/link.ppm"), ("../victim", "o/elsewhere")] {
            std::os::unix::fs::symlink(to, sandbox.path(link)).expect("a link");
        }
        let before = sandbox.files();
        let ended = sandbox.run(&["s.gml", "-o", "o", "--output", template]);
        assert!(ended.code == 5 && ended.stderr.contains(why), "{name}: {}", ended.stderr);
        assert_eq!(sandbox.files(), before);
        assert_eq!(sandbox.read("o/notes.txt"), b"precious");
        assert_eq!(sandbox.read("victim/x"), b"P6");
    }
    // Directories of the user's own may be what they are.
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm")).file("real/keep", "");
    std::os::unix::fs::symlink("real", sandbox.path(".link")).expect("a link");
    assert_eq!(sandbox.run(&["s.gml", "--output", ".link/{name}/b.ppm"]).code, 0);
    assert!(sandbox.read("real/a/b.ppm").starts_with(PPM_HEADER));
}

#[test]
fn no_image_takes_the_place_of_another() {
    let scene = ball("a/x.ppm") + &ball("b/x.ppm").replace("8 6", "4 3");
    let certify = |marks| ["--certify", "--mark-uncertain", marks];
    for (options, file) in [
        (&["--output", "same.ppm"][..], "same.ppm"),
        (&["--output", "{name}.ppm"], "x.ppm"),
        (&certify("m.png"), "m.png"),
        (&certify("{name}.png"), "x.png"),
        (&[&certify("m.png")[..], &["--output", "{n}.png"]].concat(), "m.png"),
        (&[&certify("1.png")[..], &["--output", "{n}.png"]].concat(), "1.png"),
        (&["--frames", "1..1", "--output", "{frame}.ppm"], "0001.ppm"),
    ] {
        let sandbox = Sandbox::new();
        sandbox.file("s.gml", &scene);
        let ended = sandbox.run(&[&["s.gml"], options].concat());
        assert_eq!(ended.code, 2, "{options:?}: {}", ended.stderr);
        let text = format!("more than one image would go to `{file}`; use {{n}}");
        assert!(ended.stderr.contains(&text), "{options:?}: {}", ended.stderr);
        assert!(sandbox.path(file).exists(), "{options:?}");
    }
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", &scene).file("t.gml", ball("a.ppm") + &ball("a.png"));
    sandbox.file("2.ppm", "old");
    std::os::unix::fs::symlink("2.ppm", sandbox.path("1.ppm")).expect("a link");
    let ended = sandbox.run(&["s.gml", "--output", "{n}.ppm"]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert!(sandbox.read("2.ppm").starts_with(PPM_HEADER));
    assert_eq!(sandbox.run(&["t.gml", "--format", "png"]).code, 2);
    assert_eq!(sandbox.run(&["s.gml", "--output", "/dev/null"]).code, 0);
}

#[test]
fn formats_go_by_extension_unless_told() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.pfm") + &ball("a.png") + &ball("b") + &ball("c.txt"));
    assert_eq!(sandbox.run(&["s.gml"]).code, 0);
    assert!(sandbox.read("a.pfm").starts_with(b"PF\n8 6\n-1.0\n"));
    assert!(sandbox.read("a.png").starts_with(b"\x89PNG"));
    assert!(sandbox.read("b").starts_with(b"P6") && sandbox.read("c.txt").starts_with(b"P6"));
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm") + &ball("b"));
    assert_eq!(sandbox.run(&["s.gml", "--format", "png"]).code, 0);
    assert_eq!(sandbox.files(), ["a.png", "b", "s.gml"]);
    assert!(sandbox.read("b").starts_with(b"\x89PNG"));
}
