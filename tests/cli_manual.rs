//! Completion scripts and manual pages, held against the shells and `man` where they are installed.

use std::process::{Command, Stdio};

use crate::gmlvm::Sandbox;

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// Runs a program in the sandbox; none if it is not installed.
fn output(sandbox: &Sandbox, program: &str, args: &[&str]) -> Option<(bool, String)> {
    let mut command = Command::new(program);
    command.args(args).current_dir(sandbox.path(".")).stdin(Stdio::null());
    let output = command.env("MANWIDTH", "100").env("LC_ALL", "C.UTF-8").output().ok()?;
    let text = [output.stdout, output.stderr].concat();
    Some((output.status.success(), String::from_utf8_lossy(&text).into_owned()))
}

#[test]
fn shells_take_the_scripts() {
    let sandbox = Sandbox::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let ended = sandbox.run(&["completions", shell]);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        for word in ["stability", "untrusted", "shard", "certified"] {
            assert!(ended.text().contains(word), "{shell}: {word}");
        }
        sandbox.file(shell, &ended.stdout);
        if !["bash", "zsh", "fish"].contains(&shell) {
            continue;
        }
        match output(&sandbox, shell, &["-n", shell]) {
            Some(outcome) => assert_eq!(outcome, (true, String::new()), "{shell}"),
            None => eprintln!("skipped: {shell} is not installed"),
        }
    }
    // What bash makes of `gmlvm run --unt` and a tabulator.
    let script = "source ./bash; COMP_WORDS=(gmlvm run --unt); COMP_CWORD=2; \
                  _gmlvm gmlvm --unt run; echo \"${COMPREPLY[@]}\"";
    if let Some((is_done, said)) = output(&sandbox, "bash", &["--norc", "-c", script]) {
        assert!(is_done && said == "--untrusted\n", "{said}");
    }
    assert_eq!(sandbox.run(&["completions", "cmd"]).code, 2);
}

#[test]
fn manual_pages() {
    let sandbox = Sandbox::new();
    assert_eq!(sandbox.run(&["man", "man1"]).code, 0);
    let pages = sandbox.files();
    let commands = ["bench", "chart", "check", "completions", "diff", "disasm", "eval", "explain"];
    let further = ["man", "merge", "run", "stability", "view"];
    let names =
        commands.iter().chain(&["lsp"]).chain(&further).map(|name| format!("man1/gmlvm-{name}.1"));
    let mut expected: Vec<_> = names.chain(["man1/".into(), "man1/gmlvm.1".into()]).collect();
    expected.sort();
    assert_eq!(pages, expected);
    for page in pages.iter().filter(|page| page.ends_with(".1")) {
        let text = String::from_utf8(sandbox.read(page)).expect("text");
        assert!(text.contains(".SH NAME") && text.contains("gmlvm"), "{page}");
        let Some((is_done, shown)) = output(&sandbox, "man", &["--warnings", "-l", page]) else {
            return eprintln!("skipped: man is not installed");
        };
        assert!(is_done && !shown.contains("warning"), "{page}: {shown}");
    }
    let run = String::from_utf8(sandbox.read("man1/gmlvm-run.1")).expect("text");
    assert!(run.contains("\\-\\-untrusted") && run.contains("\\-\\-message\\-format"), "{run}");
    assert_eq!(sandbox.run(&["man", "man1/gmlvm.1"]).code, 3);
}
