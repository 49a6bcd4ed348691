//! The command line: commands, options, exit codes and messages.

use crate::gmlvm::{PPM_HEADER, Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

#[test]
fn a_scene_is_run_with_or_without_the_word() {
    for args in
        [&["s.gml"][..], &["run", "s.gml"], &["-o", ".", "s.gml"], &["--color=never", "s.gml"]]
    {
        let sandbox = Sandbox::new();
        let ended = sandbox.file("s.gml", ball("a.ppm")).run(args);
        assert_eq!((ended.code, ended.stdout.len()), (0, 0), "{args:?}: {}", ended.stderr);
        assert!(ended.stderr.starts_with("a.ppm  8x6  "), "{}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1);
        let image = sandbox.read("a.ppm");
        assert!(image.starts_with(PPM_HEADER));
        assert_eq!(image.len(), PPM_HEADER.len() + 8 * 6 * 3);
        assert_eq!(sandbox.files(), ["a.ppm", "s.gml"]);
    }
}

#[test]
fn quiet_is_quiet() {
    let sandbox = Sandbox::new();
    let ended = sandbox.file("s.gml", ball("a.ppm")).run(&["-q", "s.gml"]);
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""));
}

#[test]
fn exit_codes() {
    let table: [(&str, &[&str], i32); 20] = [
        ("1 2 addi", &["eval", "s"], 0),
        ("1 2.0 addi", &["eval", "s"], 1),
        ("{", &["eval", "s"], 1),
        ("", &["eval", "missing.gml"], 2),
        ("", &["eval", "."], 2),
        ("", &["eval"], 2),
        ("", &["run", "s", "--engine", "fast"], 2),
        ("", &["run", "s", "--size", "0x5"], 2),
        ("", &["run", "s", "--region", "1,2,3"], 2),
        ("", &["run", "s", "-j", "0"], 2),
        ("", &["run", "s", "-D", "addi=1"], 2),
        ("", &["run", "s", "--output", "{frame}.ppm"], 2),
        ("", &["frobnicate", "s"], 2),
        ("", &["explain", "E9999"], 2),
        ("", &["explain", "E0201"], 0),
        ("", &["--help"], 0),
        ("", &["--version"], 0),
        ("", &["s"], 0),
        ("{ /f f f apply } /f f f apply", &["eval", "s", "--fuel", "1000"], 4),
        ("{ /f f f apply 1 } /f f f apply", &["check", "s", "--max-depth", "1000"], 4),
    ];
    for (scene, args, code) in table {
        let sandbox = Sandbox::new();
        let ended = sandbox.file("s", scene).run(args);
        assert_eq!(ended.code, code, "{args:?}: {}", ended.stderr);
        assert_eq!(ended.stderr.is_empty(), code == 0, "{args:?}: {}", ended.stderr);
        assert_eq!(sandbox.files(), ["s"]);
    }
}

#[test]
fn definitions_and_includes() {
    let sandbox = Sandbox::new();
    sandbox
        .file("s.gml", "#include \"f.ins\"\nn r b s t")
        .file("inc/f.ins", "#include \"g.ins\"\n");
    sandbox.file("inc/g.ins", "7 ");
    let defines = ["-D", "n=5", "-D", "r=0.5", "-D", "b=true", "-D", "s=\"a b\"", "-D", "t=a.ppm"];
    let args = [&["eval", "s.gml", "-I", "inc"][..], &defines].concat();
    let ended = sandbox.run(&args);
    assert_eq!(ended.text(), "7\n5\n0.5\ntrue\n\"a b\"\n\"a.ppm\"\n", "{}", ended.stderr);
}

#[test]
fn eval_prints_the_stack() {
    let sandbox = Sandbox::new();
    let program = "5 0.1 1.0 1e300 -0.0 true \"text\" 1.0 2.0 3.0 point [ 1 [ 2 ] ] { } { } sphere \
                   1.0 1.0 1.0 point dup-free light";
    let program = program.replace("dup-free", "1.0 1.0 1.0 point");
    let ended = sandbox.run_with(&["eval", "-"], program.as_bytes());
    let expected = "5\n0.1\n1.0\n1e300\n-0.0\ntrue\n\"text\"\n1.0 2.0 3.0 point\n[ 1 [ 2 ] ]\n\
                    {...}\n<object>\n<light>\n";
    assert_eq!((ended.text(), ended.stderr.as_str()), (expected, ""));
    let ended = sandbox.run_with(&["eval", "-"], (ball("a.ppm") + "1").as_bytes());
    assert_eq!((ended.text(), sandbox.files().len()), ("1\n", 0));
}

#[test]
fn check_reports_and_writes_nothing() {
    let sandbox = Sandbox::new();
    sandbox.file("good.gml", ball("a.ppm")).file("bad.gml", "1 + 2 @").file("away.gml", ball("/a"));
    let ended = sandbox.run(&["check", "good.gml"]);
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""));
    let args =
        ["check", "--message-format", "short", "good.gml", "bad.gml", "away.gml", "none.gml"];
    let ended = sandbox.run(&args);
    assert_eq!(ended.code, 1);
    let lines: Vec<_> = ended.stderr.lines().collect();
    assert_eq!(lines.len(), 4, "{lines:?}");
    assert!(lines[0].starts_with("bad.gml:1:3: error[E0001]: "), "{lines:?}");
    assert!(lines[1].starts_with("bad.gml:1:7: error[E0001]: "), "{lines:?}");
    assert!(lines[2].contains("error[E0501]"), "{lines:?}");
    assert!(lines[3].starts_with("error: cannot read `none.gml`"), "{lines:?}");
    assert_eq!(sandbox.files(), ["away.gml", "bad.gml", "good.gml"]);
}

#[test]
fn messages_as_json() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", "{ /self /n\n self self apply 1 } /f\n1 /radius \"\u{1b}\" raduis");
    let ended = sandbox.run(&["eval", "s.gml", "--message-format", "json"]);
    let message: serde_json::Value = serde_json::from_str(&ended.stderr).expect("one JSON object");
    assert_eq!((ended.code, &message["code"]), (1, &"E0002".into()));
    assert_eq!(message["spans"][0]["line"], 3);
    sandbox.file("s.gml", "1 /radius\nraduis");
    let ended = sandbox.run(&["eval", "s.gml", "--message-format", "json"]);
    let message: serde_json::Value = serde_json::from_str(&ended.stderr).expect("one JSON object");
    assert_eq!(message["helps"][0], "did you mean `radius`?");
    let spans = &message["spans"];
    assert_eq!((&spans[0]["column"], &spans[0]["end_column"]), (&1.into(), &7.into()));
    assert_eq!((&spans[0]["primary"], &spans[1]["primary"]), (&true.into(), &false.into()));
    let ended = sandbox.run(&["eval", "none.gml", "--message-format", "json"]);
    let message: serde_json::Value = serde_json::from_str(&ended.stderr).expect("one JSON object");
    assert!(message["code"].is_null());
}

#[test]
fn disasm_shows_each_stage() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", "{ /x x 1.5 addf } /f\n[ 1.0 f apply ]");
    let show = |args: &[&str]| {
        let ended = sandbox.run(&[&["disasm", "s.gml"], args].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        ended.text().to_owned()
    };
    let tokens = show(&["--emit", "tokens"]);
    assert_eq!(tokens.lines().count(), 12, "{tokens}");
    assert!(tokens.contains("1:3       binder         /x"), "{tokens}");
    let tree = show(&["--emit", "ast"]);
    assert!(tree.contains("1:1       function\n1:3         binder /x\n"), "{tree}");
    let code = show(&[]);
    assert!(
        code.contains("main program") && code.contains("AddF") && code.contains("x 1.5 addf"),
        "{code}"
    );
    assert!(show(&["--function", "0"]).starts_with("function 0 `f`"));
    assert_eq!(show(&["--function", "0"]), show(&["--function", "f"]));
    let all = show(&["--emit", "tokens,ast,bytecode"]);
    assert_eq!(all, format!("{tokens}\n{tree}\n{code}"));
    assert_eq!(sandbox.run(&["disasm", "s.gml", "--function", "99"]).code, 2);
}

#[test]
fn explain_knows_every_code() {
    let sandbox = Sandbox::new();
    for code in compiler::diagnostic::Code::ALL {
        let ended = sandbox.run(&["explain", &code.as_str().to_lowercase()]);
        assert!(ended.text().starts_with(code.as_str()), "{}", ended.text());
        assert!(ended.text().lines().all(|line| line.chars().count() <= 80), "{}", ended.text());
    }
    let ended = sandbox.run(&["explain", "E0202"]);
    assert!(ended.stderr.contains("did you mean `E0201`") || ended.stderr.contains("`E0203`"));
}

#[test]
fn diff_tells_images_apart() {
    let sandbox = Sandbox::new();
    sandbox.file("a.ppm", b"P6\n2 1\n255\n\x00\x00\x00\x0a\x0a\x0a");
    sandbox.file("b.ppm", b"P6 # odd\n2 1\n255\n\x00\x00\x00\x0a\x0c\x0a");
    sandbox.file("c.ppm", b"P6\n1 2\n65535\n\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00");
    sandbox.file("junk", b"GIF89a");
    let code = |args: &[&str]| sandbox.run(&[&["diff"], args].concat()).code;
    assert_eq!(code(&["a.ppm", "a.ppm"]), 0);
    assert_eq!(code(&["a.ppm", "b.ppm"]), 1);
    assert_eq!(code(&["a.ppm", "b.ppm", "--tolerance", "1"]), 1);
    assert_eq!(code(&["a.ppm", "b.ppm", "--tolerance", "2"]), 0);
    assert_eq!(code(&["a.ppm", "b.ppm", "--metric", "max", "--tolerance", "2"]), 0);
    assert_eq!(code(&["a.ppm", "b.ppm", "--metric", "rmse", "--tolerance", "0.9"]), 0);
    assert_eq!(code(&["a.ppm", "b.ppm", "--metric", "rmse", "--tolerance", "0.7"]), 1);
    assert_eq!(code(&["a.ppm", "b.ppm", "--metric", "psnr", "--tolerance", "40"]), 0);
    assert_eq!(code(&["a.ppm", "b.ppm", "--metric", "psnr"]), 1);
    assert_eq!(code(&["a.ppm", "a.ppm", "--metric", "psnr"]), 0);
    assert_eq!(code(&["a.ppm", "c.ppm"]), 1);
    assert_eq!(code(&["a.ppm", "junk"]), 2);
    assert_eq!(code(&["a.ppm", "none"]), 2);
    assert_eq!(code(&["a.ppm", "b.ppm", "--tolerance", "-1"]), 2);
    let ended = sandbox.run(&["diff", "a.ppm", "b.ppm", "--json", "--map", "map.png"]);
    let result: serde_json::Value = serde_json::from_slice(&ended.stdout).expect("JSON");
    assert_eq!((&result["same"], &result["differing"]), (&false.into(), &1.into()));
    assert_eq!((&result["first"][0], &result["max"]), (&1.into(), &2.0.into()));
    assert_eq!(code(&["map.png", "map.png"]), 0);
}

/// Reference, micro-scene D: two mirrors face each other.
#[test]
fn depth_and_dialect_follow_the_reference() {
    let mirror = |color: &str, angle: &str, z: &str| {
        format!(
            "{{ /v /u /face {color} point 0.2 0.8 1.0 }} plane {angle} rotatex 0.0 0.0 {z} translate "
        )
    };
    let mirrors = mirror("0.5 0.5 1.0", "-90.0", "4.0") + &mirror("1.0 0.5 0.5", "90.0", "-4.0");
    let sandbox = Sandbox::new();
    let scene = |attn: &str| {
        format!("1.0 1.0 1.0 point [] {attn} {mirrors} union 0 60.0 3 3 \"m.ppm\" render")
    };
    sandbox.file("icfp.gml", scene("")).file("chicago.gml", scene("1.0 0.0 0.0 point"));
    let center = |args: &[&str]| {
        let ended = sandbox.run(&[args, &["--output", "-", "-q"]].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let at = ended.stdout.len() - 5 * 3;
        [ended.stdout[at], ended.stdout[at + 1], ended.stdout[at + 2]]
    };
    let icfp = [[25, 25, 51], [45, 35, 71], [54, 39, 87], [60, 41, 94]];
    let chicago = [[25, 25, 51], [25, 25, 51], [66, 45, 71], [82, 62, 104], [108, 75, 117]];
    for (depth, expected) in icfp.iter().enumerate() {
        assert_eq!(center(&["icfp.gml", "--depth", &depth.to_string()]), *expected);
        let args = ["chicago.gml", "--dialect", "icfp", "--depth", &depth.to_string()];
        assert_eq!(center(&args), *expected);
    }
    for (depth, expected) in chicago.iter().enumerate() {
        assert_eq!(center(&["chicago.gml", "--depth", &depth.to_string()]), *expected);
    }
}

/// A striped ground, a millionth of a unit below the eye. In the first row below the horizon the
/// stripes begin at the centres of pixels, where doubles cannot tell one from the next.
#[test]
fn double_doubles_tell_what_doubles_cannot() {
    let sandbox = Sandbox::new();
    sandbox.file(
        "ground.gml",
        "{ /v /u /face u floor 2 modi 0 eqi { 1.0 } { 0.0 } if /c c c c point
          1.0 0.0 1.0 } plane 1.0e-6 uscale 0.0 -1.0e-6 0.0 translate /ground
         1.0 1.0 1.0 point [] ground 0 1.0 24 24 \"g.ppm\" render",
    );
    let image = |args: &[&str]| {
        let args = [&["ground.gml", "--output", "-", "-q", "--stats", "s.json"], args].concat();
        let ended = sandbox.run(&args);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let stats = serde_json::from_slice::<serde_json::Value>(&sandbox.read("s.json"));
        (ended.stdout, stats.unwrap()["precision"].as_str().unwrap().to_owned())
    };
    let (plain, precision) = image(&[]);
    assert_eq!(precision, "f64");
    assert_eq!(image(&["--precision", "f64"]).0, plain);
    let (precise, precision) = image(&["--precision", "dd"]);
    assert_eq!(precision, "dd");
    assert_ne!(precise, plain);
    let row = |image: &[u8]| image[image.len() - 12 * 24 * 3..][..24 * 3].to_owned();
    assert_eq!(row(&precise), [0; 24 * 3]);
    assert_ne!(row(&plain), [0; 24 * 3]);
}

#[test]
fn size_region_and_threads() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm"));
    let image = |args: &[&str]| {
        let ended = sandbox.run(&[&["s.gml", "--output", "-", "-q"], args].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        ended.stdout
    };
    let whole = image(&["-j", "1"]);
    assert!(image(&["-j", "2"]) == whole && image(&["-j", "7"]) == whole);
    let part = image(&["--region", "4,3,100,1"]);
    let pixels = |image: &[u8]| image[PPM_HEADER.len()..].as_chunks::<3>().0.to_vec();
    for (idx, (part, whole)) in pixels(&part).iter().zip(pixels(&whole)).enumerate() {
        let is_inside = idx / 8 == 3 && idx % 8 >= 4;
        assert_eq!(*part, if is_inside { whole } else { [0; 3] }, "{idx}");
    }
    assert!(image(&["--size", "5x7"]).starts_with(b"P6\n# gmlvm\n5 7\n255\n"));
    assert_eq!(sandbox.run(&["s.gml", "--region", "8,0,1,1"]).code, 2);
}

#[test]
fn a_plan_is_explained_and_can_be_switched_off() {
    let sandbox = Sandbox::new();
    sandbox.file("a.gml", ball("a.ppm"));
    let plain = sandbox.run(&["a.gml", "--output", "-"]);
    let off = sandbox.run(&["a.gml", "--output", "-", "--plan", "off"]);
    let explained = sandbox.run(&["a.gml", "--output", "-", "--explain"]);
    assert!(plain.stdout == off.stdout && plain.stdout == explained.stdout);
    assert!(explained.stderr.contains(" rays from the eye, "), "{}", explained.stderr);
    let omissions = explained.stderr.lines().filter(|line| line.contains("  without "));
    assert!(omissions.count() >= 3, "{}", explained.stderr);
    let both = sandbox.run(&["a.gml", "--explain", "--plan", "off"]);
    assert!(both.code == 2, "{}", both.stderr);
    // Of parts, what was traced before takes no time.
    let parts = sandbox.run(&["a.gml", "--explain", "--parts", "p"]);
    assert!(parts.code == 2 && !sandbox.path("p").exists(), "{}", parts.stderr);
    // A pixel that is NaN is what it is.
    sandbox
        .file("nan.gml", ball("a.pfm").replace("1.0 1.0 1.0 point", "0.0 0.0 divf /x x x x point"));
    let nan = sandbox.run(&["nan.gml", "--explain"]);
    assert_eq!(nan.code, 0, "{}", nan.stderr);
    assert!(sandbox.read("a.pfm").windows(4).any(|bytes| bytes == f32::NAN.to_le_bytes()));
}

#[test]
fn statistics_are_json() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", ball("a.ppm") + &ball("b.ppm"));
    let ended = sandbox.run(&["s.gml", "-q", "--stats", "-"]);
    let stats: serde_json::Value = serde_json::from_slice(&ended.stdout).expect("JSON");
    for phase in ["read", "compile", "run", "build", "jit", "trace", "write"] {
        assert!(stats["phases"][phase].as_f64().expect("a number") >= 0.0, "{phase}");
    }
    assert!(stats["total"].as_f64().expect("a number") > 0.0);
    assert_eq!((&stats["counts"]["images"], &stats["counts"]["pixels"]), (&2.into(), &96.into()));
    assert_eq!(
        (&stats["rays"]["primary"], &stats["images"][1]["file"]),
        (&96.into(), &"b.ppm".into())
    );
    assert_eq!(sandbox.run(&["s.gml", "--stats", "out/stats.json"]).code, 0);
    assert!(sandbox.read("out/stats.json").starts_with(b"{"));
}

#[test]
fn garbage_is_an_error_and_no_crash() {
    let mut state = 1_u64;
    let mut noise = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as u8
    };
    let garbage: Vec<u8> = (0..100_000).map(|_| noise()).collect();
    let cases = [
        (garbage, 1),
        (b"\x00\x01\x02".to_vec(), 1),
        (b"1 \xff\xfe 2".to_vec(), 1),
        (b"% caf\xe9 \xff\n\"a\"".to_vec(), 0),
        ("{".repeat(1_000_000).into_bytes(), 4),
        ("[".repeat(1_000_000).into_bytes(), 4),
        ("]".repeat(1_000_000).into_bytes(), 1),
        ("{ /f f f apply 1 } /f f f apply".into(), 4),
    ];
    let sandbox = Sandbox::new();
    for (program, code) in cases {
        for command in ["eval", "check", "run", "disasm"] {
            let ended = sandbox.run_with(&[command, "-"], &program);
            let expected =
                if command == "disasm" && program.starts_with(b"{ /f") { 0 } else { code };
            assert_eq!(ended.code, expected, "{command}: {}", ended.stderr);
            let is_raw = |c: char| c.is_control() && c != '\n';
            assert!(!ended.stderr.contains(is_raw), "{:?}", ended.stderr);
        }
    }
}

#[test]
fn colours_on_demand_only() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", "x");
    let has_color = |args: &[&str], variable: Option<&str>| {
        let mut command = sandbox.command(&[&["eval", "s.gml"], args].concat());
        if let Some(variable) = variable {
            command.env(variable, "1");
        }
        command.output().expect("runs").stderr.contains(&0x1b)
    };
    assert!(!has_color(&[], None));
    assert!(has_color(&["--color", "always"], None));
    assert!(has_color(&[], Some("CLICOLOR_FORCE")));
    assert!(!has_color(&["--color", "never"], Some("CLICOLOR_FORCE")));
}

/// Whatever the shell allows: the deepest nesting that is a program, and recursion without end.
#[test]
fn small_stacks_suffice() {
    let sandbox = Sandbox::new();
    sandbox.file("nested.gml", "{".repeat(499) + &"}".repeat(499)).file("s.gml", ball("a.ppm"));
    let recursion = "{ /f /n n 0 eqi { 0 } { n 1 subi f f apply 1 addi } if } /f 1000000 f f apply";
    sandbox.file("deep.gml", recursion);
    let binary = env!("CARGO_BIN_EXE_gmlvm");
    for (command, code) in [
        ("eval nested.gml", 0),
        ("disasm nested.gml --emit ast,bytecode", 0),
        ("deep.gml", 4),
        ("deep.gml --max-depth 2000000", 0),
        ("s.gml", 0),
    ] {
        let script = format!("ulimit -s 512; exec {binary} {command}");
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", &script]).current_dir(sandbox.path("."));
        let output = shell.output().expect("sh runs");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{command}: {stderr}");
    }
}

/// A system that has no room for a thread is no bug.
#[cfg(target_os = "linux")]
#[test]
fn a_thread_that_cannot_be_started_is_told_of() {
    let sandbox = Sandbox::new();
    sandbox.file("e.gml", "1 2 addi");
    // Room for the program, but not for a stack of 64 MiB besides.
    let script = format!("ulimit -v 60000; exec {} eval e.gml", env!("CARGO_BIN_EXE_gmlvm"));
    let mut shell = std::process::Command::new("sh");
    let output = shell.args(["-c", &script]).current_dir(sandbox.path(".")).output();
    let output = output.expect("sh runs");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("cannot start a thread"), "{stderr}");
    assert_eq!(output.status.code(), Some(4), "{stderr}");
}

#[test]
fn help_is_whole() {
    let sandbox = Sandbox::new();
    let help = |args: &[&str]| sandbox.run(args).text().to_owned();
    let run = help(&["run", "--help"]);
    for text in ["Scenes are not trusted", "--output '{name}-draft.png'", "Limits:", "10000000000"]
    {
        assert!(run.contains(text), "{text}: {run}");
    }
    assert!(help(&["diff", "--help"]).contains("1/255 of full scale"));
    let codes = help(&["--help"]);
    assert!(codes.contains("70  a bug in gmlvm") && codes.contains("141 whoever"), "{codes}");
    assert!(help(&["help", "check"]).contains("nothing is traced"));
}
