//! Chapters of the book that derive from the program: the reference of commands, and the pictures of
//! the tutorial. `GMLVM_BLESS=1` makes both anew.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use crate::derived::check_block;
use crate::gmlvm::Sandbox;

#[path = "support/derived.rs"]
mod derived;
#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// What `gmlvm ARGS` prints where lines may have 100 columns.
fn help(args: &[&str]) -> String {
    let sandbox = Sandbox::new();
    let output = sandbox.command(args).env("COLUMNS", "100").output().expect("it runs");
    assert!(output.status.success(), "{args:?}");
    let text = String::from_utf8(output.stdout).expect("text");
    text.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

#[test]
fn the_reference_of_commands_is_what_help_prints() {
    let all = help(&["--help"]);
    let listed = all.split_once("\nCommands:\n").expect("a list of commands").1;
    let names: Vec<_> = listed
        .lines()
        .map_while(|line| line.strip_prefix("  "))
        .filter(|line| !line.starts_with(' '))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect();
    assert!(names.len() >= 13, "{names:?}");
    let mut text = format!("\n```text\n{all}```\n");
    for name in names {
        let page = help(&[name, "--help"]);
        let _ = write!(text, "\n## gmlvm {name}\n\n```text\n{page}```\n");
    }
    check_block("commands.md", "commands", &text);
}

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

/// The files that a document shows, by the names in their first lines.
fn files_in(document: &str) -> Vec<(String, String)> {
    let text = fs::read_to_string(docs().join(document)).expect("part of the project");
    let blocks = text.split("\n```gml\n% ").skip(1);
    let block = |block: &str| {
        let (block, _) = block.split_once("```").expect("the block ends");
        let name = block.lines().next().expect("a name").to_owned();
        (name, format!("% {block}"))
    };
    blocks.map(block).collect()
}

#[test]
fn the_pictures_of_the_tutorial_are_those_of_its_scenes() {
    let sandbox = Sandbox::new();
    let files = files_in("tutorial.md");
    let tutorial = fs::read_to_string(docs().join("tutorial.md")).expect("part of the project");
    let mut n_pictures = 0;
    for (name, text) in files {
        sandbox.file(&name, &text);
        let Some(stem) = name.strip_suffix(".gml") else { continue };
        let picture = format!("tutorial/{stem}.png");
        if !tutorial.contains(&format!("({picture})")) {
            continue;
        }
        let ended = sandbox.run(&["run", &name, "--format", "png", "-q"]);
        assert_eq!(ended.code, 0, "{name}: {}", ended.stderr);
        let drawn = sandbox.read(&format!("{stem}.png"));
        assert!(drawn.len() < 40_000, "{picture} has {} bytes", drawn.len());
        let path = docs().join(&picture);
        if fs::read(&path).ok().as_ref() != Some(&drawn) {
            let is_blessed = std::env::var_os("GMLVM_BLESS").is_some();
            assert!(is_blessed, "docs/{picture} is not what {name} draws; GMLVM_BLESS=1 renews it");
            fs::create_dir_all(docs().join("tutorial")).expect("a folder");
            fs::write(path, drawn).expect("written");
        }
        n_pictures += 1;
    }
    assert!(n_pictures >= 5, "only {n_pictures} pictures");
}
