//! Any bytes as a source file: they compile, or there is an error in the file to show.
#![no_main]

use compiler::preprocess::NoIncludes;
use compiler::source::SourceMap;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut sources = SourceMap::default();
    let file = sources.add("input.gml", bytes.to_vec()).expect("inputs are short");
    if let Err(diagnostics) = compiler::compile(&mut sources, file, &mut NoIncludes, &[]) {
        assert!(!diagnostics.is_empty(), "it fails without an error");
        for diagnostic in diagnostics {
            assert!(sources.file_of(diagnostic.primary.span).is_some(), "an error is nowhere");
        }
    }
});
