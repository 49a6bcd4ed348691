//! Names of images and of included files, in a directory beside which there is something to protect.
#![no_main]

use std::sync::LazyLock;

use gmlvm::fuzzed::Worlds;
use libfuzzer_sys::fuzz_target;

/// One for each process; the system's directory for temporary files is cleared by others.
static WORLDS: LazyLock<Worlds> = LazyLock::new(|| {
    let root = std::env::temp_dir().join(format!("gmlvm-fuzz-{}", std::process::id()));
    std::fs::create_dir(&root).expect("a new directory");
    Worlds::new(&root).expect("made")
});

fuzz_target!(|bytes: &[u8]| {
    WORLDS.any_name(bytes);
});
