//! The grammar for editors finds the words that the compiler's lexer finds, in every scene, and has
//! the operators of the compiler's table. `GMLVM_BLESS=1` writes these into the grammar.

use std::fs;
use std::path::{Path, PathBuf};

use compiler::lexer::{Token, TokenKind};
use compiler::op::Operator;
use compiler::preprocess::{NoIncludes, tokens_and_errors};
use compiler::source::SourceMap;
use fancy_regex::Regex;
use serde_json::Value;
use support::scenes::shared;

mod support {
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod scenes;
}

const GRAMMAR: &str = "contrib/vscode/syntaxes/gml.tmLanguage.json";

/// Operators that do not compute but say what runs.
const CONTROL: [Operator; 2] = [Operator::Apply, Operator::If];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn grammar() -> Value {
    let text = fs::read_to_string(root().join(GRAMMAR)).expect("part of the project");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn operators_are_those_of_the_code() {
    let (control, others): (Vec<Operator>, Vec<Operator>) =
        Operator::ALL.iter().partition(|op| CONTROL.contains(op));
    for (rule, operators) in [("control", control), ("operator", others)] {
        let names: Vec<_> = operators.iter().map(|op| op.spelling()).collect();
        let expected = Value::from(format!("(?:{})(?![A-Za-z0-9_-])", names.join("|")));
        let grammar = grammar();
        let found = &grammar["repository"][rule]["match"];
        if *found == expected {
            continue;
        }
        assert!(
            std::env::var_os("GMLVM_BLESS").is_some(),
            "{GRAMMAR}: `{rule}` is out of date; GMLVM_BLESS=1 corrects it"
        );
        let text = fs::read_to_string(root().join(GRAMMAR)).expect("read before");
        let line = format!("\"match\": {found}");
        assert_eq!(text.matches(&line).count(), 1, "{line}");
        let blessed = text.replace(&line, &format!("\"match\": {expected}"));
        fs::write(root().join(GRAMMAR), blessed).expect("written");
    }
}

/// A word: how the grammar calls it, and its bytes.
type Word = (String, usize, usize);

/// A rule of the grammar, as TextMate applies it.
enum Rule {
    Match { name: String, regex: Regex },
    Span { name: String, begin: Regex, end: Regex },
}

fn rules(grammar: &Value) -> Vec<Rule> {
    let regex = |value: &Value| Regex::new(value.as_str().expect("a pattern")).expect("a regex");
    let mut rules = Vec::new();
    let mut waiting: Vec<&Value> = grammar["patterns"].as_array().expect("a list").iter().collect();
    waiting.reverse();
    while let Some(pattern) = waiting.pop() {
        if let Some(name) = pattern["include"].as_str() {
            waiting.push(&grammar["repository"][name.trim_start_matches('#')]);
        } else if let Some(inner) = pattern["patterns"].as_array() {
            waiting.extend(inner.iter().rev());
        } else {
            let name = pattern["name"].as_str().expect("a name").to_owned();
            rules.push(if pattern["begin"].is_string() {
                let (begin, end) = (regex(&pattern["begin"]), regex(&pattern["end"]));
                Rule::Span { name, begin, end }
            } else {
                Rule::Match { name, regex: regex(&pattern["match"]) }
            });
        }
    }
    rules
}

/// The words of a text, as an editor finds them: line by line, at each place the rule that matches
/// first, of several there the one that stands first.
fn words(rules: &[Rule], text: &str) -> Vec<Word> {
    let mut words = Vec::new();
    let mut start = 0;
    let mut open: Option<&Regex> = None;
    for line in text.split_inclusive('\n') {
        let mut at = 0;
        loop {
            if let Some(end) = open {
                let Some(found) = end.find_from_pos(line, at).expect("in bounds") else { break };
                (open, at) = (None, found.end());
            }
            let first = rules.iter().filter_map(|rule| {
                let (Rule::Match { regex, .. } | Rule::Span { begin: regex, .. }) = rule;
                let found = regex.find_from_pos(line, at).expect("in bounds")?;
                Some((found.start(), found.end(), rule))
            });
            let Some((from, to, rule)) = first.min_by_key(|(from, ..)| *from) else { break };
            assert!(to > at, "a rule that matches nothing");
            match rule {
                Rule::Match { name, .. } => words.push((name.clone(), start + from, start + to)),
                Rule::Span { name, end, .. } => {
                    words.push((name.clone(), start + from, start + to));
                    open = Some(end);
                }
            }
            at = to;
        }
        start += line.len();
    }
    words.retain(|(name, ..)| !name.starts_with("comment") && !name.starts_with("meta"));
    words
}

fn name_of(token: &Token) -> &'static str {
    match &token.kind {
        TokenKind::Bool(_) => "constant.language.boolean.gml",
        TokenKind::Int(_) => "constant.numeric.integer.gml",
        TokenKind::Real(_) => "constant.numeric.float.gml",
        TokenKind::Str(_) => "string.quoted.double.gml",
        TokenKind::Operator(op) if CONTROL.contains(op) => "keyword.control.gml",
        TokenKind::Operator(_) => "support.function.gml",
        TokenKind::Name(_) => "variable.other.gml",
        TokenKind::Binder(_) => "entity.name.variable.gml",
        TokenKind::OpenFunction | TokenKind::CloseFunction => "punctuation.section.function.gml",
        TokenKind::OpenArray | TokenKind::CloseArray => "punctuation.section.array.gml",
    }
}

/// The words that the lexer finds.
fn lexed(text: &str) -> Vec<Word> {
    let mut sources = SourceMap::default();
    let file = sources.add("scene.gml", text.as_bytes().to_vec()).expect("short");
    let (tokens, _) = tokens_and_errors(&mut sources, file, &mut NoIncludes);
    let word = |token: &Token| {
        let bytes = sources.file(file).range(token.span);
        (name_of(token).to_owned(), bytes.start, bytes.end)
    };
    tokens.iter().map(word).collect()
}

#[track_caller]
fn check(rules: &[Rule], place: &str, text: &str) -> usize {
    let (found, expected) = (words(rules, text), lexed(text));
    let differ = found.iter().zip(&expected).find(|(a, b)| a != b);
    if let Some((found, expected)) = differ {
        let word = |(name, from, to): &Word| format!("`{}` as {name}", &text[*from..*to]);
        panic!("{place}: the grammar has {}, the lexer {}", word(found), word(expected));
    }
    assert_eq!(found.len(), expected.len(), "{place}");
    found.len()
}

/// All scenes below some folders, and what they include.
fn scenes(mut folders: Vec<PathBuf>) -> Vec<PathBuf> {
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        let entries =
            fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        for path in entries.map(|entry| entry.expect("readable").path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ext| ext == "gml" || ext == "ins") {
                files.push(path);
            }
        }
    }
    files
}

#[test]
fn words_are_those_of_the_lexer() {
    let rules = rules(&grammar());
    let cases = [
        "1{2}apply[3] 1-1 5 /x-1 x-1 3x 123e 1.5e-3 1e6 1.5e if-not iffy true-ly false",
        "-7 -x 1 /* addi\n \" { */ 2 % sphere \" {\nspheres \"a % b /* \" /n_2",
        "#define X\n  #ifdef X \n addi\n#endif\n% a\u{b}apply",
    ];
    for text in cases {
        assert!(check(&rules, text, text) > 0 || text.starts_with("-7 -x"));
    }
    let own = scenes(["scenes", "tests/golden", "tests/stability"].map(|f| root().join(f)).into());
    assert!(own.len() > 70, "only {} scenes", own.len());
    let n_words = check_files(&rules, own);
    assert!(n_words > 9_000, "only {n_words} words");
    let folders = ["scenes/contest", "scenes/chicago", "stability"];
    check_files(&rules, scenes(folders.iter().filter_map(|folder| shared(folder)).collect()));
}

/// How many words some scenes have.
fn check_files(rules: &[Rule], scenes: Vec<PathBuf>) -> usize {
    let mut n_words = 0;
    for path in scenes {
        let bytes = fs::read(&path).expect("readable");
        // Of old scenes some are not UTF-8, which the compiler then reads as Latin-1.
        let text = String::from_utf8(bytes)
            .unwrap_or_else(|error| error.into_bytes().iter().copied().map(char::from).collect());
        n_words += check(rules, &path.display().to_string(), &text);
    }
    n_words
}
