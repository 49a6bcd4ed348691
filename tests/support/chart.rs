//! What tests of charts share: running `gmlvm chart`, and reading what it writes.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::gmlvm::{Ended, Sandbox};

/// Runs `gmlvm chart` with the options that all tests of the program share, and these.
pub(crate) fn chart(sandbox: &Sandbox, args: &[&str]) -> Ended {
    sandbox.run(&[&["chart"], crate::COMMON, args].concat())
}

/// The same, which must succeed in silence; returns what it prints.
pub(crate) fn charted(sandbox: &Sandbox, args: &[&str]) -> String {
    let ended = chart(sandbox, args);
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""), "{}", ended.text());
    ended.text().to_owned()
}

/// Asserts that it ends with an exit code and a message that holds these words, and leaves all files as
/// they are.
pub(crate) fn assert_refused(sandbox: &Sandbox, args: &[&str], code: i32, message: &str) {
    let before = sandbox.files();
    let ended = chart(sandbox, args);
    assert_eq!(ended.code, code, "{args:?}: {}", ended.stderr);
    assert!(ended.stderr.contains(message), "{args:?}: {}", ended.stderr);
    assert_eq!(sandbox.files(), before, "{args:?}");
}

pub(crate) fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).expect("JSON")
}

pub(crate) fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("no list: {value}"))
}

pub(crate) fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("no number: {value}"))
}

/// The texts of an SVG file.
pub(crate) fn texts(svg: &str) -> Vec<&str> {
    svg.split("</text>").filter_map(|part| part.rsplit('>').next()).map(str::trim).collect()
}

/// Asserts that a drawing of the documentation is that of the data beside it, as it is drawn with these
/// options; `GMLVM_BLESS=1` draws it anew.
pub(crate) fn assert_drawn_from_data(name: &str, options: &[&str]) {
    let shown = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/charts").join(name);
    let shown = shown.with_extension("svg");
    let sandbox = Sandbox::new();
    let data = shown.with_extension("json").display().to_string();
    charted(&sandbox, &[options, &[data.as_str(), "-o", "c.svg"]].concat());
    let drawn = sandbox.read("c.svg");
    if std::env::var_os("GMLVM_BLESS").is_some() {
        fs::write(&shown, &drawn).expect("written");
    }
    let is_same = fs::read(&shown).expect("readable") == drawn;
    assert!(is_same, "{} is not what is drawn now", shown.display());
}
