//! Random surface functions by both engines, and those that fuzzing has found (`fuzz/finds/engines`).
//!
//! `GMLVM_FUZZ_PROGRAMS` sets how many programs, `GMLVM_FUZZ_SEED` where to start.

use jit::shaders::Evaluation;
use renderer::surface::SurfacePoint;
use support::agreement::{Agreed, agree};
use support::finds;
use support::generator::{LIMITS, Random, points, program};

#[allow(unreachable_pub, reason = "shared with the fuzz targets, where it is public")]
mod support {
    pub(crate) mod agreement;
    #[allow(dead_code, reason = "it serves several test programs")]
    pub(crate) mod finds;
    pub(crate) mod generator;
}

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Why each program went the way it went.
#[derive(Debug, Default)]
struct Tally {
    failed_before: u64,
    native: u64,
    constant: u64,
    declined: std::collections::BTreeMap<String, u64>,
    calls: u64,
    errors: u64,
    in_batches: u64,
}

fn check(seed: u64, tally: &mut Tally) {
    let text = program(&mut Random::new(seed));
    let points: Vec<SurfacePoint> = points(&mut Random::new(!seed));
    let Some(Agreed { evaluation, results, in_batches }) = agree(&text, LIMITS, points.into_iter())
    else {
        tally.failed_before += 1;
        return;
    };
    match evaluation {
        Evaluation::Native { .. } => tally.native += 1,
        Evaluation::Constant => tally.constant += 1,
        Evaluation::Declined(why) => *tally.declined.entry(why.reason).or_default() += 1,
        Evaluation::Cold => unreachable!("all are compiled at once"),
    }
    tally.calls += results.len() as u64;
    tally.in_batches += in_batches as u64;
    tally.errors += results.iter().filter(|result| result.is_err()).count() as u64;
}

#[test]
fn native_code_agrees_with_the_interpreter() {
    let first = number("GMLVM_FUZZ_SEED", 1);
    let n_programs = number("GMLVM_FUZZ_PROGRAMS", 3000);
    let mut tally = Tally::default();
    for seed in first..first + n_programs {
        check(seed, &mut tally);
    }
    println!("{tally:#?}");
    // A generator whose programs all fail would find nothing; nor would one of what is declined.
    assert!(tally.native * 2 > n_programs && tally.errors * 2 < tally.calls, "{tally:?}");
    assert!(tally.in_batches * 4 > tally.calls, "too few answers in batches: {tally:?}");
    let n_declined: u64 = tally.declined.values().sum();
    assert!(n_declined * 50 <= n_programs, "more than 2 % are declined: {tally:?}");
}

#[test]
fn native_code_agrees_on_what_was_found() {
    for bytes in finds::of("engines") {
        let mut random = Random::of_bytes(&bytes);
        let text = program(&mut random);
        let points = points(&mut random);
        agree(&text, LIMITS, points.into_iter());
    }
}
