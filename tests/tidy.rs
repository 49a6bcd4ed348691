//! The invariants of `docs/ARCHITECTURE.md` that are about the source text itself.

use std::path::{Path, PathBuf};

const CRATES: [&str; 4] = ["compiler", "vm", "jit", "renderer"];

/// The aim is 500; the dispatch loop, one arm for each kind of step, is the one room a little above.
const MAX_LINES: usize = 560;

/// What each crate may name, besides libraries.
const ALLOWED: [(&str, &[&str]); 4] = [
    ("compiler", &[]),
    ("renderer", &[]),
    ("vm", &["compiler", "renderer"]),
    ("jit", &["compiler", "renderer", "vm"]),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All Rust files of the project, by their path below its root.
fn rust_files() -> Vec<(String, String)> {
    let mut folders: Vec<PathBuf> = ["src", "tests", "benches", "fuzz/targets"]
        .iter()
        .chain(&CRATES)
        .map(|name| root().join(name))
        .collect();
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(&folder)
            .unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        for path in entries.map(|entry| entry.expect("readable").path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(root()).expect("below the root").display().to_string();
                files.push((name, std::fs::read_to_string(&path).expect("text")));
            }
        }
    }
    assert!(files.len() > 50, "only {} files", files.len());
    files
}

#[test]
fn crates_depend_one_way() {
    for (name, allowed) in ALLOWED {
        let manifest =
            std::fs::read_to_string(root().join(name).join("Cargo.toml")).expect("a manifest");
        let dependencies = manifest.split("[dependencies]").nth(1).expect("dependencies");
        for other in CRATES.iter().filter(|other| **other != name) {
            let names_it = dependencies.lines().any(|line| {
                line.starts_with(&format!("{other}.")) || line.starts_with(&format!("{other} "))
            });
            assert!(!names_it || allowed.contains(other), "{name} must not depend on {other}");
        }
    }
}

#[test]
fn unsafe_code_has_one_place() {
    for krate in ["compiler", "vm", "renderer"] {
        let lib = std::fs::read_to_string(root().join(krate).join("src/lib.rs")).expect("a crate");
        assert!(lib.contains("#![forbid(unsafe_code)]"), "{krate}");
    }
    let word = concat!("unsafe", " ");
    for (name, text) in rust_files() {
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let has_unsafe = code
            .clone()
            .any(|line| line.contains(&format!("{word}{{")) || line.contains(&format!("{word}fn")));
        assert!(!has_unsafe || name == "jit/src/code.rs", "{name}");
    }
}

#[test]
fn only_the_binary_touches_files_clocks_and_streams() {
    let forbidden = ["std::fs", "std::time", "std::env", "println!", "eprintln!", "std::process"];
    for (name, text) in rust_files() {
        let is_library =
            ["compiler/", "vm/", "renderer/"].iter().any(|krate| name.starts_with(krate));
        if !is_library {
            continue;
        }
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for word in forbidden {
            assert!(!code.contains(word), "{name} uses {word}");
        }
    }
}

#[test]
fn files_open_with_what_they_own_and_stay_short() {
    for (name, text) in rust_files() {
        assert!(text.starts_with("//!"), "{name} has no description");
        let n_lines = text.lines().count();
        assert!(n_lines <= MAX_LINES, "{name} has {n_lines} lines");
    }
}

#[test]
fn nothing_is_left_for_later() {
    let words = [
        concat!("TO", "DO"),
        concat!("FIX", "ME"),
        concat!("XX", "X"),
        concat!("unimplemented", "!"),
    ];
    for (name, text) in rust_files() {
        for word in words {
            assert!(!text.contains(word), "{name} says {word}");
        }
    }
}
