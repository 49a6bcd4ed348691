//! Surface functions, generated as the bytes say, by the interpreter and as native code.
#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../tests/support/agreement.rs"]
mod agreement;
#[path = "../../tests/support/generator.rs"]
mod generator;

fuzz_target!(|bytes: &[u8]| {
    let mut random = generator::Random::of_bytes(bytes);
    let text = generator::program(&mut random);
    let points = generator::points(&mut random);
    agreement::agree(&text, generator::LIMITS, points.into_iter());
});
