//! Hostile scenes: whatever a program's text and values are, gmlvm ends in bounded time and memory with
//! the right exit code, says where and why, and leaves nothing half-written.

use std::collections::BTreeSet;

use crate::gmlvm::{Sandbox, ball};

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

const LIGHT: &str = "0.5 0.5 0.5 point [ 1.0 -1.0 1.0 point 1.0 1.0 1.0 point light ]";

fn surface(body: &str) -> String {
    format!("{LIGHT}\n{{ {body} }} sphere 0.0 0.0 2.0 translate 3 90.0 40 30 \"a.ppm\" render")
}

/// The first pixel in reading order is named, whatever the number of threads.
#[test]
fn errors_of_surfaces_are_the_first_ones() {
    let good = "1.0 1.0 1.0 point 1.0 0.5 1.0";
    for (body, code, options, exit) in [
        ("/v /u /face 1 2.0 addi".to_owned(), "E0201", "", 1),
        (format!("/v /u /face u 0.5 lessf {{ 1 }} {{ {good} }} if"), "E0203", "", 1),
        (format!("/v /u /face v 0.5 lessf {{ {good} }} {{ zork }} if"), "E0102", "", 1),
        ("/a /b /c /d".to_owned(), "E0101", "", 1),
        (format!("/v /u /face 1 {good}"), "E0203", "", 1),
        (good.to_owned(), "E0203", "", 1),
        (String::new(), "E0203", "", 1),
        (format!("/v /u /face 1 0 divi {good}"), "E0302", "", 1),
        (format!("/v /u /face u negf sqrt {good}"), "E0303", "", 1),
        (format!("/v /u /face [ 1 ] 1 get {good}"), "E0304", "", 1),
        (format!("/v /u /face 0.0 0.0 divf floor {good}"), "E0305", "", 1),
        (format!("/v /u /face {{ }} sphere 0.0 uscale {good}"), "E0306", "", 1),
        ("/v /u /face 9223372036854775807 1 addi".to_owned(), "E0301", "", 1),
        ("{ /f f f apply } /f f f apply".to_owned(), "E0401", "--fuel 10000", 4),
        ("{ /f f f apply 1 } /f f f apply".to_owned(), "E0402", "--max-depth 1000", 4),
        ("{ /f /a [ a a ] f f apply } /f 1 f f apply".to_owned(), "E0403", "--max-memory 1M", 4),
    ] {
        let sandbox = Sandbox::new();
        sandbox.file("s.gml", surface(&body));
        let mut seen = BTreeSet::new();
        for threads in ["1", "2", "7"] {
            let options: Vec<&str> = options.split_whitespace().collect();
            let ended = sandbox.run(&[&["s.gml", "-j", threads], &options[..]].concat());
            assert_eq!(ended.code, exit, "{body}: {}", ended.stderr);
            assert!(ended.stderr.contains(code), "{body}: {}", ended.stderr);
            assert!(ended.stderr.contains(" s.gml:2:"), "{body}: {}", ended.stderr);
            assert_eq!(sandbox.files(), ["s.gml"], "{body}");
            seen.insert(ended.stderr);
        }
        assert_eq!(seen.len(), 1, "{body}: {seen:?}");
        let stderr = seen.first().expect("one");
        assert!(stderr.contains("first met at pixel ("), "{body}: {stderr}");
    }
}

#[test]
fn operands_of_render_have_bounds() {
    let ball = ball("a.ppm");
    for (from, to, exit, code) in [
        ("90.0", "0.0", 1, "E0307"),
        ("90.0", "-1.0", 1, "E0307"),
        ("90.0", "180.0", 1, "E0307"),
        ("90.0", "0.0 0.0 divf", 1, "E0307"),
        ("90.0", "1.0 0.0 divf", 1, "E0307"),
        ("90.0", "90", 1, "E0201"),
        ("8 6", "0 6", 1, "E0307"),
        ("8 6", "8 -6", 1, "E0307"),
        ("8 6", "9223372036854775807 6", 1, "E0307"),
        ("8 6", "1000000000 1000000000", 4, "E0404"),
        ("8 6", "4294967295 4294967295", 4, "E0404"),
        ("[]", "[ 1 ]", 1, "E0307"),
        ("[]", "[ [ ] ]", 1, "E0307"),
        ("[]", "{ }", 1, "E0201"),
        ("\"a.ppm\"", "5", 1, "E0201"),
        ("\"a.ppm\"", "\"\"", 5, "E0501"),
        (" 0 90.0", " 0.0 90.0", 1, "E0201"),
        ("2.0 translate", "0.0 0.0 divf translate", 1, "E0306"),
        ("2.0 translate", "2.0 translate 0.0 uscale", 1, "E0306"),
        ("2.0 translate", "2.0 translate -0.0 1.0 1.0 scale", 1, "E0306"),
        ("2.0 translate", "2.0 translate 1.0 0.0 divf rotatex", 1, "E0306"),
        ("2.0 translate", "2.0 translate 1e200 uscale 1e200 uscale", 1, "E0306"),
    ] {
        let scene = ball.replacen(from, to, 1);
        assert_ne!(scene, ball);
        let sandbox = Sandbox::new();
        let ended = sandbox.file("s.gml", &scene).run(&["s.gml"]);
        assert_eq!(ended.code, exit, "{to}: {}", ended.stderr);
        assert!(ended.stderr.contains(code), "{to}: {}", ended.stderr);
        assert!(ended.stderr.contains(" s.gml:1:"), "{to}: {}", ended.stderr);
        assert_eq!(sandbox.files(), ["s.gml"]);
    }
}

/// NaN and infinities are values: they make no error, and the same image on any number of threads.
#[test]
fn numbers_that_are_none_make_an_image() {
    let (nan, inf) = ("0.0 0.0 divf", "1.0 0.0 divf");
    let shiny = format!("{{ /v /u /face {inf} {nan} 1.0 point {nan} {inf} {nan} }}");
    let lights = format!(
        "[ {nan} 1.0 0.0 point {inf} 1.0 1.0 point light 0.0 0.0 0.0 point 1.0 1.0 1.0 point light \
         {inf} 1.0 0.0 point 1.0 {nan} 1.0 point pointlight \
         0.0 1.0 0.0 point 0.0 1.0 0.0 point 1.0 1.0 1.0 point {nan} {inf} spotlight ]"
    );
    let scene = format!(
        "{nan} {inf} -1.0 point {lights} {nan} -1.0 0.0 point {shiny} sphere 0.0 0.0 2.0 translate \
         {shiny} plane 0.0 -0.5 0.0 translate union 5 1e-300 9 7 \"a.ppm\" render"
    );
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", scene.replace("1e-300", "90.0")).file("t.gml", scene);
    for scene in ["s.gml", "t.gml"] {
        let images: BTreeSet<_> = ["1", "2", "7"]
            .map(|threads| {
                let ended = sandbox.run(&[scene, "-q", "--output", "-", "-j", threads]);
                assert_eq!((ended.code, ended.stderr.as_str()), (0, ""));
                ended.stdout
            })
            .into();
        assert_eq!(images.len(), 1);
    }
}

/// Text whose length, nesting or number of files is out of all proportion.
#[test]
fn monstrous_text() {
    let sandbox = Sandbox::new();
    let million = 1_000_000;
    sandbox
        .file("name.gml", "a".repeat(million))
        .file("text.gml", format!("\"{}\"", "a".repeat(million)))
        .file("number.gml", "1".repeat(million))
        .file("real.gml", format!("0.{0} 1e{0}", "0".repeat(million)))
        .file("line.gml", format!("[ {0} 1 1.0 addi {0} ]", "1 ".repeat(million / 4)))
        .file("errors.gml", "@ ".repeat(million))
        .file("comments.gml", "/* ".repeat(million))
        .file("ifs.gml", "#ifndef A\n".repeat(million / 10))
        .file("mixed.gml", "{[".repeat(million))
        .file("image.gml", ball(&"a".repeat(million)))
        .file("bomb-0.ins", "1 2 3\n")
        .file("bomb.gml", "#include \"bomb-30.ins\"\n")
        .file("chain.gml", "#include \"chain-0.ins\"\n")
        .file("many.gml", "#include \"empty.ins\"\n".repeat(20_000))
        .file("empty.ins", "")
        .file("circle.gml", "#include \"./circle.gml\"\n")
        .file("self.gml", "#include \"d/../self.gml\"\n");
    for idx in 1..=30 {
        sandbox.file(
            &format!("bomb-{idx}.ins"),
            format!("#include \"bomb-{}.ins\"\n", idx - 1).repeat(2),
        );
    }
    for idx in 0..100 {
        sandbox.file(&format!("chain-{idx}.ins"), format!("#include \"chain-{}.ins\"\n", idx + 1));
    }
    for (scene, exit, text) in [
        ("name.gml", 1, "error[E0102]"),
        ("text.gml", 0, ""),
        ("number.gml", 1, "error[E0003]"),
        ("real.gml", 0, ""),
        ("line.gml", 1, "line.gml:1:500010"),
        ("errors.gml", 1, "errors.gml:1:1"),
        ("comments.gml", 1, "error[E0012]"),
        ("ifs.gml", 1, "error[E0009]"),
        ("mixed.gml", 4, "mixed.gml:1:501"),
        ("image.gml", 5, "error[E0501]"),
        ("bomb.gml", 4, "error[E0013]"),
        ("chain.gml", 4, "chain-63.ins:1:10"),
        ("many.gml", 4, "many.gml:10001:10"),
        ("circle.gml", 1, "error[E0011]"),
        ("self.gml", 1, "error[E0010]"),
    ] {
        let (code, stderr) = sandbox.confined(&format!("eval {scene} >/dev/null"));
        assert_eq!(code, Some(exit), "{scene}: {stderr:.2000}");
        assert!(stderr.contains(text), "{scene}: {stderr:.2000}");
        assert!(stderr.len() < 10_000, "{scene}: {} bytes of messages", stderr.len());
    }
}

/// Values that nest deeply, or that unfold to more than there is room for.
#[test]
fn monstrous_values() {
    let grow = |step: &str, n: usize, seed: &str| {
        format!(
            "{{ /self /n /a n 0 eqi {{ a }} {{ {step} n 1 subi self self apply }} if }} /f {seed} {n} f f apply"
        )
    };
    let white = "{ /v /u /face 1.0 1.0 1.0 point 1.0 0.0 1.0 } sphere";
    let seen = |object: &str| format!("{LIGHT} {object} 0 60.0 4 4 \"a.ppm\" render");
    let doubled = |op: &str| seen(&format!("{white} /o {} o", format!("o o {op} /o ").repeat(60)));
    let sandbox = Sandbox::new();
    sandbox
        .file("arrays.gml", grow("[ a ]", 1_000_000, "[ ]"))
        .file("dropped.gml", grow("[ a ]", 1_000_000, "[ ]") + " /x 1")
        .file("closures.gml", grow("{ a }", 1_000_000, "{ }"))
        .file("differences.gml", grow(&format!("{white} a difference"), 300_000, white))
        .file("unions.gml", seen(&grow(&format!("a {white} union"), 100_000, white)))
        .file("unions-right.gml", seen(&grow(&format!("{white} a union"), 100_000, white)))
        .file("moves.gml", seen(&grow("a 0.0 0.0 1e-7 translate", 500_000, white)))
        .file("two-arrays.gml", format!("[ 1 ] /o {} o", "[ o o ] /o ".repeat(60)))
        .file("two-unions.gml", doubled("union"))
        .file("two-differences.gml", doubled("difference"))
        .file("loop.gml", "{ /f /n n 0 eqi { } { n 1 subi f f apply } if } /f 25000 f f apply")
        .file(
            "lights.gml",
            seen(white).replace(
                "light ]",
                &format!("light {} ]", {
                    grow(
                        "1.0 1.0 1.0 point 1.0 1.0 1.0 point light a",
                        100_000,
                        "1.0 1.0 1.0 point 1.0 1.0 1.0 point light",
                    )
                }),
            ),
        );
    for (scene, exit) in [
        ("eval arrays.gml", 0),
        ("eval dropped.gml", 0),
        ("eval closures.gml", 0),
        ("eval differences.gml", 0),
        ("run unions.gml -o out", 0),
        ("run unions-right.gml -o out", 0),
        ("run moves.gml -o out", 0),
        ("eval two-arrays.gml", 0),
        ("run two-unions.gml", 4),
        ("run two-differences.gml", 4),
        ("eval loop.gml", 0),
        ("eval lights.gml", 0),
    ] {
        let (code, stderr) = sandbox.confined(&format!("{scene} >/dev/null"));
        assert_eq!(code, Some(exit), "{scene}: {stderr:.2000}");
    }
    // However much it prints, it ends.
    let printed = sandbox.run(&["eval", "two-arrays.gml"]).stdout.len();
    assert!(printed < 2 << 20, "{printed}");
}

/// Operands keep their order when there are more bindings and operands than registers.
#[test]
fn more_values_than_registers() {
    let sandbox = Sandbox::new();
    let light = "1.0 1.0 1.0 point 1.0 1.0 1.0 point light ";
    for (item, shown) in [("{ } sphere ", "<object>"), (light, "<light>")] {
        let ended = sandbox.run_with(&["eval", "-"], item.repeat(1000).as_bytes());
        assert_eq!(ended.text(), format!("{shown}\n").repeat(1000), "{}", ended.stderr);
    }
    for n_bindings in (180..200).chain([260]) {
        let bindings: String = (0..n_bindings).map(|n| format!("x {n}.0 addf /v{n} ")).collect();
        let [a, b, c] = [1, 2, 3].map(|n| format!("v{}", n_bindings - n));
        for pending in [0, 1, 2, 63, 64, 100] {
            let pending_text: String = (0..pending).map(|n| format!("x {n}.0 addf ")).collect();
            let program = format!(
                "[ {{ /x {bindings} {pending_text} {{ }} sphere {a} {b} {c} translate }} ] /f \
                 0.5 f 0 get apply"
            );
            let ended = sandbox.run_with(&["eval", "-"], program.as_bytes());
            let expected: String = (0..pending).map(|n| format!("{n}.5\n")).collect();
            assert_eq!(ended.text(), expected + "<object>\n", "{n_bindings}: {}", ended.stderr);
        }
    }
}

/// Depth beyond measure is refused; as much as is allowed takes little memory.
#[test]
fn mirrors_without_end() {
    let mirrors = |ks: &str| {
        let plane = format!("{{ /v /u /face 1.0 1.0 1.0 point 0.0 {ks} 1.0 }} plane");
        format!(
            "1.0 1.0 1.0 point [] {plane} -90.0 rotatex 0.0 0.0 4.0 translate {plane} 90.0 rotatex \
             0.0 0.0 -4.0 translate union 9223372036854775807 60.0 3 3 \"a.ppm\" render"
        )
    };
    let sandbox = Sandbox::new();
    sandbox.file("perfect.gml", mirrors("1.0")).file("dim.gml", mirrors("0.5"));
    for (scene, exit) in [
        ("perfect.gml -j 1", 4),
        ("perfect.gml -j 7", 4),
        ("dim.gml", 4),
        ("perfect.gml -o out --depth 100000", 0),
    ] {
        let (code, stderr) = sandbox.confined(scene);
        assert_eq!(code, Some(exit), "{scene}: {stderr}");
        if exit == 4 {
            assert!(stderr.contains("error[E0404]"), "{stderr}");
            assert!(!sandbox.path("a.ppm").exists());
        }
    }
}

/// Lines and columns count from 1, columns in characters.
#[test]
fn places_are_right() {
    let sandbox = Sandbox::new();
    sandbox.file("inc/a.ins", "\r\n\t1 1.0 addi").file("inc/b.ins", "{ 1 1.0 addi } /f");
    for (text, place) in [
        ("\t\t1\t2.0\taddi", "s.gml:1:9: "),
        ("1 /x\r\n2\r\n\r\n3 2.0 addi\r\n4\r\n", "s.gml:4:7: "),
        ("1 \u{b} 2.0\u{c} addi", "s.gml:1:10: "),
        ("% caf\u{e9} \u{2603} \u{1d11e}\n\"a\" 2.0 addi % \u{2603}", "s.gml:2:9: "),
        ("/* \u{2603}\u{1d11e}\u{e9} */ 1 2.0 addi", "s.gml:1:17: "),
        ("/* \u{6f22}\u{5b57} */ 1 2.0 addi", "s.gml:1:16: "),
        ("/* e\u{301}\u{200d} \u{202e} */ 1 2.0 addi", "s.gml:1:19: "),
        ("# 12 \"other.gml\"\n#line 5\n1 2.0 addi", "s.gml:3:7: "),
        ("1 1.0 {", "s.gml:1:7: "),
        ("#include \"inc/a.ins\"\n", "inc/a.ins:2:8: "),
        ("#include \"inc/b.ins\"\n\nf apply", "inc/b.ins:1:9: "),
        ("#ifdef X\n#include \"nope\"\n@@\n#endif\n1 2.0 addi", "s.gml:5:7: "),
    ] {
        let ended =
            sandbox.file("s.gml", text).run(&["eval", "s.gml", "--message-format", "short"]);
        assert_eq!(ended.code, 1, "{text:?}: {}", ended.stderr);
        assert!(ended.stderr.starts_with(place), "{text:?}: {}", ended.stderr);
        let human = sandbox.run(&["eval", "s.gml"]).stderr;
        let place = place.trim_end_matches(": ");
        assert!(human.contains(&format!("--> {place}\n")), "{text:?}: {human}");
    }
    let latin1 = b"% caf\xe9\n/* \xff */ 1 2.0 addi";
    let ended = sandbox.run_with(&["eval", "-", "--message-format", "short"], latin1);
    assert!(ended.stderr.starts_with("<stdin>:2:15: "), "{}", ended.stderr);
    // The path is shown as it was given.
    let absolute = sandbox.path("s.gml").display().to_string();
    sandbox.file("s.gml", "x");
    let ended = sandbox.run(&["eval", &absolute, "--message-format", "short"]);
    assert!(ended.stderr.starts_with(&format!("{absolute}:1:1: ")), "{}", ended.stderr);
}

/// Comments may hold anything; what is printed for the user's eyes may not.
#[test]
fn terminals_get_no_commands_from_listings() {
    let sandbox = Sandbox::new();
    sandbox.file("s.gml", "\t1 % \u{1b}[2J\u{9b}\u{202e}\n{ /* \u{1b}]0;title\u{7} */ 2 } \"a b\"");
    for stage in ["tokens", "ast", "bytecode"] {
        let ended = sandbox.run(&["disasm", "s.gml", "--emit", stage]);
        let is_raw = |c: char| (c.is_control() && c != '\n' && c != '\t') || c == '\u{202e}';
        assert_eq!(ended.code, 0);
        assert!(!ended.text().contains(is_raw), "{:?}", ended.text());
    }
}
