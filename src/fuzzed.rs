//! Properties of parts of the program that take bytes from strangers, as functions of any bytes, which
//! panic where one does not hold. Tests call them with some thousands of inputs, fuzz targets with more.

pub use part::any_part;
pub use path::Worlds;

#[cfg(test)]
#[allow(dead_code, reason = "it serves several test programs")]
#[path = "../tests/support/finds.rs"]
mod finds;
mod part;
mod path;

/// Takes a number below 256 off the front of bytes; 0 when there are none left.
fn take(bytes: &mut &[u8]) -> u8 {
    bytes.split_off_first().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tries what fuzzing has found, and more: `GMLVM_FUZZ_INPUTS` says how many inputs, `GMLVM_FUZZ_SEED`
    /// which.
    fn for_many(default: u64, target: &str, mut property: impl FnMut(&[u8])) {
        finds::of(target).iter().for_each(|bytes| property(bytes));
        let number = |variable: &str, default: u64| {
            std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
        };
        let mut state = number("GMLVM_FUZZ_SEED", 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        for _ in 0..number("GMLVM_FUZZ_INPUTS", default) {
            let mut next = || {
                // xorshift64* (Vigna 2016).
                state ^= state >> 12;
                state ^= state << 25;
                state ^= state >> 27;
                (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize
            };
            let n_bytes = next() % 64;
            let bytes: Vec<u8> = (0..n_bytes).map(|_| next() as u8).collect();
            property(&bytes);
        }
    }

    #[test]
    fn parts_are_those_that_were_written() {
        let mut n_taken = 0;
        for_many(20_000, "parts", |bytes| n_taken += u32::from(any_part(bytes)));
        assert!(n_taken > 0, "none is taken: nothing is tried");
    }

    #[test]
    fn names_lead_nowhere_else() {
        let sandbox = tempfile::tempdir().expect("a directory");
        let worlds = Worlds::new(sandbox.path()).expect("made");
        let mut n_written = 0;
        for_many(10_000, "paths", |bytes| n_written += u32::from(worlds.any_name(bytes)));
        assert!(n_written > 0, "none is written: nothing is tried");
    }
}
