//! Any bytes as a scene, compiled and run for a little while.
#![no_main]

use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "it serves several targets")]
#[path = "../../tests/support/sources.rs"]
mod sources;

fuzz_target!(|bytes: &[u8]| sources::compiles(bytes));
