//! Any bytes as the text of a scene, to tokens.
#![no_main]

use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "it serves several targets")]
#[path = "../../tests/support/sources.rs"]
mod sources;

fuzz_target!(|bytes: &[u8]| sources::lexes(bytes));
