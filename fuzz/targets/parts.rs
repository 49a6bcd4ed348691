//! Any bytes as a part file, and part files with something changed.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    gmlvm::fuzzed::any_part(bytes);
});
