//! What `--untrusted` promises: limits that a scene cannot wait out, and that no file but those that are
//! its own is read or written.

use std::fs;

use crate::gmlvm::{Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

fn link(sandbox: &Sandbox, to: &str, name: &str) {
    std::os::unix::fs::symlink(to, sandbox.path(name)).expect("a link");
}

/// Each limit is hit where it is, and not without the option, nor with one of its own. (That of fuel, which
/// takes seconds to burn, is held to its number by a test of the command line.)
#[test]
fn limits_are_tight() {
    let grow = |n: u32| {
        format!("{{ /f /n n 0 eqi {{ 1 }} {{ n 1 subi f f apply 1 addi }} if }} /f {n} f f apply")
    };
    let size = |size: &str| ball("a.ppm").replace("8 6", size);
    let arrays = format!(
        "{{ /f /n /a n 0 eqi {{ a }} {{ [ a {} ] n 1 subi f f apply }} if }} /f 1 40000 f f apply /x",
        "0 ".repeat(1000)
    );
    for (scene, code, option) in [
        ("1 ".repeat((1 << 18) + 1), "E0013", "--max-words 262145"),
        (grow(20_000), "E0402", "--max-depth 20001"),
        (arrays, "E0403", "--max-memory 4G"),
        (size("4097 4096"), "E0404", "--max-pixels 17000000"),
        (size("4096 4096").repeat(4) + &ball("a.ppm"), "E0404", "--max-total-pixels 67108912"),
        (ball("a.ppm").repeat(17), "E0404", "--max-images 17"),
        (ball("a.ppm").replace(" 0 90.0", " 1001 90.0"), "E0404", "--max-reflections 1001"),
    ] {
        let sandbox = Sandbox::new();
        sandbox.file("s.gml", &scene);
        let ended = sandbox.run(&["check", "s.gml", "--untrusted"]);
        assert_eq!(ended.code, 4, "{option}: {}", ended.stderr);
        assert!(ended.stderr.contains(code), "{code}: {}", ended.stderr);
        assert_eq!(sandbox.run(&["check", "s.gml"]).code, 0, "{code}");
        let own: Vec<_> = option.split(' ').collect();
        let ended = sandbox.run(&[&["check", "s.gml", "--untrusted"], &own[..]].concat());
        assert_eq!(ended.code, 0, "{option}: {}", ended.stderr);
    }
}

/// A scene that is not trusted replaces nothing: not the user's images, not its own, and not the reports of
/// an earlier run.
#[test]
fn nothing_is_replaced() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm")).file("twice.gml", ball("b.ppm").repeat(2));
    sandbox.file("a.ppm", "P6 precious").file("st.json", "precious").file("marks.png", "precious");
    link(&sandbox, "nowhere", "dangling.ppm");
    let marks = "run s.gml --output n.ppm --certify --mark-uncertain marks.png";
    for option in
        ["--untrusted", "--no-clobber", "--clobber --no-clobber", "--untrusted --no-clobber"]
    {
        for (args, there) in [
            ("run s.gml", "a.ppm"),
            ("run s.gml --output a.ppm", "a.ppm"),
            ("run s.gml --output {name}.ppm", "a.ppm"),
            ("run s.gml --output dangling.ppm", "dangling.ppm"),
            ("run s.gml --output n.ppm --stats st.json", "st.json"),
            (marks, "marks.png"),
        ] {
            let before = sandbox.files();
            // What takes an hour to render is not rendered first.
            let args = format!("{args} {option} --samples 16 --size 3000x3000");
            let args =
                if args.contains("--certify") { args.replace(" --samples 16", "") } else { args };
            let ended = sandbox.run(&args.split_whitespace().collect::<Vec<_>>());
            assert_eq!(ended.code, 3, "{args}: {}", ended.stderr);
            let said = format!("could not write `{there}`: it exists already");
            assert!(ended.stderr.contains(&said), "{args}: {}", ended.stderr);
            assert_eq!(sandbox.files(), before, "{args}");
        }
        let args = format!("run twice.gml {option}");
        let ended = sandbox.run(&args.split(' ').collect::<Vec<_>>());
        assert_eq!(ended.code, 3, "{}", ended.stderr);
        fs::remove_file(sandbox.path("b.ppm")).expect("the first image is there");
        let args = format!("run s.gml {option} --watch");
        let ended = sandbox.run(&args.split(' ').collect::<Vec<_>>());
        assert!(ended.code == 2 && ended.stderr.contains("--clobber"), "{}", ended.stderr);
    }
    assert_eq!(sandbox.read("a.ppm"), b"P6 precious");
    // Devices are written to, and the user's word counts.
    let null = ["s.gml", "--untrusted", "--output", "/dev/null", "--stats", "/dev/null"];
    assert_eq!(sandbox.run(&null).code, 0);
    let own = ["twice.gml", "--untrusted", "--clobber", "--stats", "st.json"];
    assert_eq!(sandbox.run(&own).code, 0);
    assert!(sandbox.read("st.json").starts_with(b"{"));
    assert_eq!(sandbox.run(&["s.gml"]).code, 0);
    assert!(sandbox.read("a.ppm").starts_with(b"P6\n# gmlvm"));
}

/// Included files are the scene's own: no link leads to others, and the directory that gmlvm happens to
/// be started in is not that of a scene on the standard input.
#[test]
fn includes_stay_in_the_directory() {
    let sandbox = Sandbox::new();
    sandbox.file("secret/key.ins", "42").file("in/own.ins", "7").file("in/d/own.ins", "8");
    sandbox.file("in/d/next.gml", "#include \"own.ins\"\n").file("own.ins", "9");
    link(&sandbox, "../secret/key.ins", "in/link.ins");
    link(&sandbox, "../secret", "in/out");
    link(&sandbox, "own.ins", "in/loop.ins");
    link(&sandbox, "in", "shortcut");
    let made = std::process::Command::new("mkfifo").arg(sandbox.path("in/fifo.ins")).status();
    assert!(made.expect("mkfifo runs").success());
    for (name, trusted, untrusted) in [
        ("own.ins", "7\n", "7\n"),
        ("d/own.ins", "8\n", "8\n"),
        ("./d/next.gml", "8\n", "8\n"),
        ("link.ins", "42\n", ""),
        ("out/key.ins", "42\n", ""),
        ("loop.ins", "7\n", ""),
        ("fifo.ins", "", ""),
        ("../secret/key.ins", "", ""),
        ("d", "", ""),
    ] {
        sandbox.file("in/s.gml", format!("#include \"{name}\"\n"));
        for scene in ["in/s.gml", "./in/s.gml", "shortcut/s.gml"] {
            assert_eq!(sandbox.run(&["eval", scene]).text(), trusted, "{name}");
            let ended = sandbox.run(&["eval", scene, "--untrusted"]);
            assert_eq!(ended.text(), untrusted, "{name}: {}", ended.stderr);
            assert_eq!(ended.code, i32::from(untrusted.is_empty()), "{name}: {}", ended.stderr);
            assert!(!ended.stderr.contains("42"), "{}", ended.stderr);
        }
    }
    let scene = b"#include \"own.ins\"\n";
    assert_eq!(sandbox.run_with(&["eval", "-"], scene).text(), "9\n");
    assert_eq!(sandbox.run_with(&["eval", "-", "--untrusted"], scene).code, 1);
    // A directory that the user names is trusted, but not the links in it.
    let ended = sandbox.run_with(&["eval", "-", "--untrusted", "-I", "in"], scene);
    assert_eq!(ended.text(), "7\n", "{}", ended.stderr);
    let linked = b"#include \"link.ins\"\n";
    assert_eq!(sandbox.run_with(&["eval", "-", "--untrusted", "-I", "in"], linked).code, 1);
}

/// Confined or not, the images are the same, wherever the command line sends them.
#[test]
fn images_are_the_same() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("x/a.ppm") + &ball("b.png")).file("t.gml", ball("a.ppm"));
    assert_eq!(sandbox.run(&["s.gml", "-o", "trusted"]).code, 0);
    for (options, files) in [
        ("-o new/out", ["new/out/x/a.ppm", "new/out/b.png"]),
        ("", ["x/a.ppm", "b.png"]),
        ("--output by-name/{n}/{name}", ["by-name/1/a", "by-name/2/b"]),
    ] {
        let options: Vec<_> = options.split_whitespace().collect();
        let stats = format!("st/{}.json", files[0]);
        let args = [&["run", "s.gml", "--untrusted", "--stats", &stats], &options[..]].concat();
        let ended = sandbox.run(&args);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        assert_eq!(sandbox.read(files[0]), sandbox.read("trusted/x/a.ppm"));
        assert!(
            files[1].ends_with("/b") || sandbox.read(files[1]) == sandbox.read("trusted/b.png")
        );
        assert!(sandbox.read(&stats).starts_with(b"{"));
    }
    for options in ["--output -", "--output /dev/null", "--certify --mark-uncertain m/a.png"] {
        let options: Vec<_> = options.split_whitespace().collect();
        let ended = sandbox.run(&[&["t.gml", "--untrusted", "-v"], &options[..]].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
    }
    assert!(sandbox.read("m/a.png").starts_with(b"\x89PNG"));
    let ended = sandbox.run(&["t.gml", "--untrusted", "--output", "/dev/full"]);
    assert_eq!(ended.code, 3);
    assert!(ended.stderr.contains("no space left on device"), "{}", ended.stderr);
}

/// The kernel's rules are in force while a scene runs, where it has any; `-v` says so.
#[cfg(target_os = "linux")]
#[test]
fn the_kernel_is_asked() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    let said = sandbox.run(&["s.gml", "--untrusted", "-v"]).stderr;
    assert!(said.starts_with("confined") || said.starts_with("not confined"), "{said}");
    assert!(!sandbox.run(&["s.gml", "-v"]).stderr.contains("confined"));
    assert!(!sandbox.run(&["s.gml", "--untrusted"]).stderr.contains("confined"));
    let has_landlock =
        fs::read_to_string("/sys/kernel/security/lsm").is_ok_and(|l| l.contains("landlock"));
    assert!(!has_landlock || said.starts_with("confined"), "{said}");
}

/// Whatever is shown of names and texts, a terminal takes none of it for a command: not on the standard
/// error, and not on the standard output where that is for the eye.
#[test]
fn terminals_get_no_commands() {
    let evil = "e\u{1b}]0;x\u{7}\u{9b}2J\u{202e}";
    let sandbox = Sandbox::new();
    let scene = format!("{evil}.gml");
    let inner = format!("{evil}.ins");
    sandbox
        .file(&scene, ball("a.ppm"))
        .file(&inner, "1 1.0 addi")
        .file("in.gml", format!("#include \"{inner}\"\n"));
    sandbox
        .file("bad.gml", format!("1 {evil} \"{evil}\" % {evil}\n"))
        .file("named.gml", ball("x").replace("\"x\"", "s"));
    sandbox.file("text.gml", "s [ s ]").file("d", "");
    let define = format!("s={evil}");
    for args in [
        &["run", &scene, "-v"][..],
        &["run", &scene, "-o", evil],
        &["run", &scene, "--output", &format!("{evil}.ppm")],
        &["run", &scene, "--output", &format!("d/{evil}.ppm")],
        &["run", &scene, "--stats", &format!("d/{evil}")],
        &["run", &scene, "--certify", "--mark-uncertain", &format!("d/{evil}.png")],
        &["run", &scene, "--mark-uncertain", evil, "--certify"],
        &["run", &scene, evil],
        &["run", evil],
        &["run", &scene, "--output", &format!("{{{evil}}}")],
        &["run", &scene, "--timeout", evil],
        &["run", "named.gml", "-D", &define],
        &["run", "named.gml", "-D", &define, "--message-format", "short"],
        &["run", "named.gml", "-D", evil],
        &["run", &scene, "--timeout", "1ms", "--size", "3000x3000", "--output", evil],
        &["check", &scene, "bad.gml", "in.gml", evil, "-v"],
        &["check", &scene, "bad.gml", "in.gml", evil, "--message-format", "short"],
        &["eval", "text.gml", "-D", &define],
        &["eval", "in.gml"],
        &["disasm", "text.gml", "-D", &define],
        &["disasm", &scene, "--emit", "tokens,ast,bytecode,clif"],
        &["disasm", &scene, "--function", evil],
        &["bench", &scene, "--runs", "1", "--engines", "interp"],
        &["bench", &scene, "--runs", "1", "--surfaces"],
        &["chart", &scene, "--runs", "1", "--methods", evil],
        &["chart", &scene, "--runs", "1"],
        &["diff", evil, "a.ppm"],
        &["explain", evil],
        &[evil],
    ] {
        let ended = sandbox.run(args);
        for text in [ended.text(), &ended.stderr] {
            let is_raw = |c: char| (c.is_control() && c != '\n' && c != '\t') || c == '\u{202e}';
            assert!(!text.contains(is_raw), "{args:?}: {text:?}");
        }
    }
}
