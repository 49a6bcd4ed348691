//! README and manuals are true: their console blocks show what the program writes, pictures exist, and
//! links lead somewhere.
//!
//! In a fenced `console` block, a line that starts with `$` is a command, and what follows is what
//! it writes, standard output first. A line `...` stands for any lines, and a time at the end of a
//! line, such as `0.41 s`, for any time. A fenced `gml` block that opens with `% NAME.gml` is the
//! file of that name. All commands of a document run one after the other in one directory, in which
//! there are the project's scenes. `GMLVM_BLESS=1` writes anew what a command shows, if it is not what it
//! writes.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use crate::gmlvm::Sandbox;

#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

/// The command that runs this very test, and so is not run by it.
const TEST_COMMAND: &str = "cargo test --workspace";

/// Whole pictures take long without optimisation; of this scene a few rows do.
const LARGE_SCENE: &str = "scenes/showpiece.gml";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn console_blocks_show_what_the_program_writes() {
    let mut n_commands = 0;
    for document in documents() {
        if read(&document).contains("```console\n") {
            n_commands += check_console(&document);
        }
    }
    assert!(n_commands >= 20, "only {n_commands} commands");
}

/// Runs the commands of a document; returns how many there are.
fn check_console(document: &str) -> usize {
    let text = read(document);
    let sandbox = Sandbox::new();
    for entry in scene_files() {
        sandbox.file(&entry, fs::read(root().join(&entry)).expect("readable"));
    }
    let mut blessed = String::new();
    let mut n_commands = 0;
    let mut lines = text.lines().peekable();
    let mut language = None;
    while let Some(line) = lines.next() {
        blessed += line;
        blessed.push('\n');
        if let Some(fence) = line.strip_prefix("```") {
            language = if language.is_none() { Some(fence) } else { None };
        } else if language == Some("gml") && file_name(line).is_some() {
            let name = file_name(line).expect("just seen");
            let rest: Vec<_> = lines.clone().take_while(|line| !line.starts_with("```")).collect();
            sandbox.file(name, format!("{line}\n{}\n", rest.join("\n")));
        } else if language == Some("console") {
            let command = line.strip_prefix("$ ").unwrap_or_else(|| panic!("no command: {line}"));
            let mut shown = Vec::new();
            while let Some(line) =
                lines.next_if(|line| !line.starts_with("```") && !line.starts_with("$ "))
            {
                shown.push(line);
            }
            blessed += &outcome(&sandbox, command, &shown);
            n_commands += 1;
        }
    }
    if blessed != text {
        assert!(
            std::env::var_os("GMLVM_BLESS").is_some(),
            "{document}{}",
            first_difference(&text, &blessed)
        );
        fs::write(root().join(document), blessed).expect("written");
    }
    n_commands
}

/// The name in a line `% NAME`, if it can be a file's.
fn file_name(line: &str) -> Option<&str> {
    line.strip_prefix("% ").filter(|name| name.contains('.') && !name.contains(' '))
}

/// README and manuals, by their paths.
fn documents() -> Vec<String> {
    let mut names = vec!["README.md".to_owned(), "docs/gallery/README.md".to_owned()];
    for entry in fs::read_dir(root().join("docs")).expect("a folder") {
        let name = entry.expect("readable").file_name().into_string().expect("a plain name");
        names.extend(name.ends_with(".md").then(|| format!("docs/{name}")));
    }
    names.sort();
    names
}

/// What a block should show behind a command: `shown`, if that is true.
fn outcome(sandbox: &Sandbox, command: &str, shown: &[&str]) -> String {
    let lines = |lines: &[&str]| {
        lines.iter().fold(String::new(), |mut text, line| {
            writeln!(text, "{line}").expect("a string takes all");
            text
        })
    };
    if command == TEST_COMMAND {
        return lines(shown);
    }
    let words = words(command);
    let words: Vec<_> = words.iter().map(String::as_str).collect();
    let args = match words[..] {
        ["gmlvm", ref args @ ..] | ["cargo", "run", "--release", "--", ref args @ ..] => args,
        _ => panic!("not a command of ours: {command}"),
    };
    let mut args = args.to_vec();
    if args.contains(&LARGE_SCENE) {
        args.extend(["--region", "0,0,4096,4"]);
    }
    let ended = sandbox.run(&args);
    let written = format!("{}{}", ended.text(), ended.stderr);
    let written: Vec<_> = written.lines().collect();
    let is_failure = |line: &&str| line.starts_with("error") || line.starts_with("differ");
    assert_eq!(ended.code != 0, written.iter().any(is_failure), "{command}: {written:?}");
    let is_plain_run = args.contains(&"run") && !args.contains(&"-v") && ended.code == 0;
    if let Some(line) = written.last().filter(|_| is_plain_run) {
        assert_image_exists(sandbox, line);
    }
    lines(if matches(shown, &written) { shown } else { &written })
}

/// Of the line `NAME  WIDTHxHEIGHT  TIME`.
fn assert_image_exists(sandbox: &Sandbox, line: &str) {
    let [name, size, ..] = line.split_whitespace().collect::<Vec<_>>()[..] else {
        panic!("not about an image: {line}")
    };
    let bytes = sandbox.read(name);
    if name.ends_with(".ppm") {
        let header = format!("P6\n# gmlvm\n{}\n255\n", size.replace('x', " "));
        assert!(bytes.starts_with(header.as_bytes()), "{line}");
    } else {
        assert_eq!(png_size(&bytes), size, "{line}");
    }
}

/// The size that a PNG file states, as `WIDTHxHEIGHT`.
fn png_size(bytes: &[u8]) -> String {
    assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"));
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    format!("{}x{}", number(16), number(20))
}

/// Whether lines are those shown, in which `...` stands for any.
fn matches(shown: &[&str], written: &[&str]) -> bool {
    match shown {
        [] => written.is_empty(),
        ["...", rest @ ..] => (0..=written.len()).any(|n| matches(rest, &written[n..])),
        [line, rest @ ..] => written.split_first().is_some_and(|(first, others)| {
            timeless(line) == timeless(first) && matches(rest, others)
        }),
    }
}

/// A line, without the time that it may end with.
fn timeless(line: &str) -> &str {
    let line = line.trim_end();
    let time = line.strip_suffix(" s").and_then(|rest| rest.rsplit_once(' '));
    match time {
        Some((rest, number)) if number.parse::<f64>().is_ok() => rest,
        _ => line,
    }
}

/// The words of a command; `'` quotes.
fn words(command: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    for (part, text) in command.split('\'').enumerate() {
        let is_quoted = part % 2 == 1;
        for c in text.chars() {
            if c == ' ' && !is_quoted {
                words.push(String::new());
            } else {
                words.last_mut().expect("never empty").push(c);
            }
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

fn first_difference(shown: &str, written: &str) -> String {
    let n_same = shown.lines().zip(written.lines()).take_while(|(a, b)| a == b).count();
    let line = |text: &str| text.lines().nth(n_same).unwrap_or_default().to_owned();
    format!(
        ":{}: shows\n  {}\nbut it is\n  {}\n(GMLVM_BLESS=1 corrects it)",
        n_same + 1,
        line(shown),
        line(written)
    )
}

/// The scenes and what they include, by their paths below the root.
fn scene_files() -> Vec<String> {
    let mut folders = vec![PathBuf::from("scenes")];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root().join(&folder)).expect("a folder") {
            let entry = entry.expect("readable");
            let path = folder.join(entry.file_name());
            if entry.file_type().expect("a type").is_dir() {
                folders.push(path);
            } else {
                files.push(path.display().to_string());
            }
        }
    }
    files.sort();
    files
}

#[test]
fn every_scene_is_in_the_gallery() {
    let (readme, gallery) = (read("README.md"), read("docs/gallery/README.md"));
    let mut n_scenes = 0;
    for file in scene_files() {
        let Some(name) = file.strip_prefix("scenes/").and_then(|name| name.strip_suffix(".gml"))
        else {
            continue;
        };
        let picture = fs::read(root().join(format!("docs/gallery/{name}.png")))
            .unwrap_or_else(|error| panic!("{name}: {error}; `just gallery` makes it"));
        assert_ne!(png_size(&picture), "0x0");
        assert!(picture.len() < 700_000, "{name} has {} bytes", picture.len());
        assert!(readme.contains(&format!("docs/gallery/{name}.png")), "README.md: {name}");
        let row = format!("| ![]({name}.png) | [{name}](../../scenes/{name}.gml) |");
        assert!(gallery.contains(&row), "docs/gallery/README.md: {name}");
        n_scenes += 1;
    }
    assert!(n_scenes >= 12);
}

#[test]
fn links_lead_somewhere() {
    let mut n_links = 0;
    for name in documents() {
        let text = read(&name);
        let folder = Path::new(&name).parent().expect("a file has a folder");
        for link in text.split("](").skip(1) {
            let link = link.split([')', ' ']).next().unwrap_or_default();
            if link.contains("://") {
                continue;
            }
            let (target, heading) = link.split_once('#').unwrap_or((link, ""));
            let path = root().join(folder).join(target);
            assert!(target.is_empty() || path.exists(), "{name} links to {target}");
            if !heading.is_empty() {
                let there = match target {
                    "" => text.clone(),
                    _ => fs::read_to_string(path).expect("text"),
                };
                assert!(
                    headings(&there).any(|h| h == heading),
                    "{name} links to {target}#{heading}"
                );
            }
            n_links += 1;
        }
    }
    assert!(n_links > 100, "only {n_links} links");
}

/// The headings of a document, as links name them.
fn headings(text: &str) -> impl Iterator<Item = String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| {
        let words = line.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
        words.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect()
    })
}

#[test]
fn the_book_has_every_document() {
    let summary = read("docs/SUMMARY.md");
    for name in documents() {
        let name = name.strip_prefix("docs/").unwrap_or_default();
        let is_listed = summary.contains(&format!("]({name})"));
        assert_eq!(is_listed, !["", "SUMMARY.md"].contains(&name), "{name}");
    }
}

#[test]
fn dots_and_times_match_anything() {
    assert!(matches(&["a  0.05 s"], &["a  1.20 s"]));
    assert!(!matches(&["a  0.05 s"], &["b  0.05 s"]));
    assert!(matches(&["...", "b"], &["b"]));
    assert!(matches(&["a", "..."], &["a", "b", "c"]));
    assert!(!matches(&["a", "...", "c"], &["a", "b"]));
    assert_eq!(
        words("gmlvm run  --output '{name} 2.png'"),
        ["gmlvm", "run", "--output", "{name} 2.png"]
    );
}
