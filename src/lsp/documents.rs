//! The texts that the editor has open, and their names: URIs outside, paths inside.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use compiler::preprocess::Includes;

use crate::args::Inputs;
use crate::load::FileIncludes;
use crate::lsp::text::Lines;
use crate::lsp::types::ContentChange;

/// A text that is open.
#[derive(Clone, Debug)]
pub(super) struct Document {
    /// As the editor names it.
    pub(super) uri: String,
    /// The number that the editor gives to this state of the text.
    pub(super) version: i32,
    /// The text.
    pub(super) text: Arc<str>,
}

impl Document {
    /// The name by which messages and the compiler know it.
    pub(super) fn name(&self) -> String {
        match path_of(&self.uri) {
            Some(path) => path.display().to_string(),
            None => self.uri.clone(),
        }
    }

    /// Whether it is a program. Other files are there to be included: on their own they need not
    /// make sense.
    pub(super) fn is_program(&self) -> bool {
        path_of(&self.uri).is_none_or(|path| path.extension().is_none_or(|ext| ext == "gml"))
    }

    /// Makes a change that the editor tells of.
    pub(super) fn change(&mut self, change: &ContentChange) {
        let Some(range) = change.range else {
            self.text = change.text.as_str().into();
            return;
        };
        let lines = Lines::of(&self.text);
        let start = lines.byte(&self.text, range.start);
        let end = lines.byte(&self.text, range.end).max(start);
        let (before, after) = (&self.text[..start], &self.text[end..]);
        self.text = [before, &change.text, after].concat().into();
    }
}

/// All that are open, by their names.
pub(super) type Open = Arc<BTreeMap<String, Document>>;

/// Finds included files: as they stand in the editor, or else on the disk.
pub(super) struct OpenIncludes<'a> {
    files: FileIncludes<'a>,
    open: &'a BTreeMap<String, Document>,
}

impl<'a> OpenIncludes<'a> {
    /// For a document of this name.
    pub(super) fn new(
        document: &Document,
        inputs: &'a Inputs,
        open: &'a BTreeMap<String, Document>,
    ) -> Self {
        let path = path_of(&document.uri);
        let files =
            FileIncludes::new(document.name(), path.as_deref().and_then(Path::parent), inputs);
        OpenIncludes { files, open }
    }
}

impl Includes for OpenIncludes<'_> {
    fn load(&mut self, from: &str, name: &str) -> Option<(String, Vec<u8>)> {
        let (shown, bytes) = self.files.load(from, name)?;
        let open = self.open.get(&shown).map(|document| document.text.as_bytes().to_vec());
        Some((shown, open.unwrap_or(bytes)))
    }
}

/// The path of a `file:` URI.
pub(super) fn path_of(uri: &str) -> Option<PathBuf> {
    let rest = uri.strip_prefix("file://")?;
    let rest = rest.strip_prefix("localhost").unwrap_or(rest);
    let mut bytes = Vec::new();
    let mut left = rest.as_bytes();
    while let [first, after @ ..] = left {
        let digits = after.get(..2).filter(|_| *first == b'%');
        let decoded =
            digits.and_then(|d| u8::from_str_radix(std::str::from_utf8(d).ok()?, 16).ok());
        bytes.push(decoded.unwrap_or(*first));
        left = if decoded.is_some() { &after[2..] } else { after };
    }
    let path = PathBuf::from(String::from_utf8(bytes).ok()?);
    path.is_absolute().then_some(path)
}

/// The URI of a file by the name that the compiler knows it by; if it is open, the editor's.
pub(super) fn uri_of(name: &str, open: &BTreeMap<String, Document>) -> Option<String> {
    if let Some(document) = open.get(name) {
        return Some(document.uri.clone());
    }
    let mut uri = "file://".to_owned();
    for byte in std::path::absolute(name).ok()?.to_str()?.bytes() {
        if byte.is_ascii_alphanumeric() || b"/-._~".contains(&byte) {
            uri.push(byte.into());
        } else {
            uri += &format!("%{byte:02X}");
        }
    }
    Some(uri)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_uris() {
        assert_eq!(path_of("file:///a/b%20c.gml"), Some("/a/b c.gml".into()));
        assert_eq!(path_of("file://localhost/%C3%A9"), Some("/\u{e9}".into()));
        assert_eq!(path_of("untitled:Untitled-1"), None);
        assert_eq!(path_of("file://elsewhere/a"), None);
        assert_eq!(path_of("file:///%FF"), None);
        for name in ["/a/b c.gml", "/\u{e9}/100%/a#b?c", "/\u{1f98a}"] {
            let uri = uri_of(name, &BTreeMap::new()).expect("a path");
            assert_eq!(path_of(&uri), Some(name.into()), "{uri}");
        }
    }
}
