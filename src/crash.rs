//! What can stop the program other than its input: a bug, or a processor that is too old.

use std::panic::set_hook;
use std::sync::Mutex;

use crate::clean::clean;
use crate::console;
use crate::failure::Failure;

/// What the first panic said, and where.
static FIRST_PANIC: Mutex<Option<String>> = Mutex::new(None);

/// Stack of the thread that does the work, whatever the limits of the main thread's are. Nesting of
/// the source text is limited to what fits in many times.
const STACK_BYTES: usize = 64 << 20;

/// Runs `work` on a thread of its own.
///
/// # Errors
/// What it fails with; that it has panicked, on whatever thread; or that the system has no room for
/// the thread.
pub(crate) fn guarded<T: Send>(
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    set_hook(Box::new(|panic| {
        if let Ok(mut first) = FIRST_PANIC.lock() {
            first.get_or_insert_with(|| panic.to_string());
        }
    }));
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, work)
            .map_err(|error| {
                Failure::Limit(format!("cannot start a thread: {}", console::reason(&error)))
            })?;
        thread.join().unwrap_or_else(|_| {
            let panic = FIRST_PANIC.lock().ok().and_then(|mut first| first.take());
            Err(Failure::Bug(apology(&panic.unwrap_or_default())))
        })
    })
}

fn apology(panic: &str) -> String {
    let command: Vec<_> = std::env::args_os()
        .map(|argument| clean(&argument.to_string_lossy()).into_owned())
        .collect();
    format!(
        "this is a bug in gmlvm; please report it\n  version: {}\n  command: {}\n  {}",
        env!("CARGO_PKG_VERSION"),
        command.join(" "),
        panic.replace('\n', "\n  ")
    )
}

/// Fails on a processor without the instructions that this program was compiled for.
///
/// Code compiled for a newer processor may stop the process before it comes here. But the
/// instructions asked for stand in the renderer for the most part, and then this comes first.
///
/// # Errors
/// With a text that says what is wrong.
pub(crate) fn require_cpu() -> Result<(), Failure> {
    #[cfg(all(target_arch = "x86_64", target_feature = "fma"))]
    {
        // The detection macro of the standard library answers "yes" at compile time for whatever
        // the compiler may use, so the processor itself is asked.
        use std::arch::x86_64::__cpuid;
        const FMA_IN_ECX: u32 = 1 << 12;
        const AVX2_IN_EBX: u32 = 1 << 5;
        let has_fma = __cpuid(1).ecx & FMA_IN_ECX != 0;
        let has_avx2 = __cpuid(0).eax >= 7 && __cpuid(7).ebx & AVX2_IN_EBX != 0;
        if !(has_fma && has_avx2) {
            return Err(Failure::Usage(
                "this build of gmlvm needs a processor with AVX2 and fused multiply-add \
                 (x86-64-v3, made since 2013), which this one is not; build it here with \
                 RUSTFLAGS=\"-C target-cpu=native\" (the same images, much slower)"
                    .to_owned(),
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_apology() {
        let ended = guarded(|| -> Result<(), Failure> { panic!("a\ntest") });
        let _ = std::panic::take_hook();
        let failure = ended.expect_err("it panicked");
        assert_eq!(failure.exit_code(), 70);
        let crash = failure.message().expect("an apology");
        assert!(crash.starts_with("this is a bug in gmlvm"), "{crash}");
        assert!(crash.contains(env!("CARGO_PKG_VERSION")) && crash.contains("test"), "{crash}");
        assert!(crash.contains("src/crash.rs"), "{crash}");
    }
}
