//! Bounded shaders enclose what surface functions give.
//!
//! `GMLVM_FUZZ_PROGRAMS` sets how many random programs, `GMLVM_FUZZ_SEED` where to start.

use renderer::surface::{Bounded, BoundedPoint, SurfacePoint};
use support::enclosure::{Tally, check_program};
use support::generator::{LIMITS, Random, points, program};

#[allow(dead_code, unreachable_pub, reason = "shared with the fuzz targets, where it is public")]
mod support {
    pub(crate) mod agreement;
    pub(crate) mod enclosure;
    pub(crate) mod generator;
}

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Radii from 1e-16 to 1e-3; now and then a coordinate is exact.
fn around(at: SurfacePoint, k: usize) -> BoundedPoint {
    let radius = |k: usize| if k % 16 == 15 { 0.0 } else { 10f64.powi(-16 + (k % 14) as i32) };
    BoundedPoint {
        face: at.face,
        u: Bounded { value: at.u, error: radius(k) },
        v: Bounded { value: at.v, error: radius(k.wrapping_mul(7) / 16) },
    }
}

#[test]
fn random_functions_stay_within_bounds() {
    let first = number("GMLVM_FUZZ_SEED", 1);
    let n_programs = number("GMLVM_FUZZ_PROGRAMS", 2000);
    let mut tally = Tally::default();
    let mut n_native = 0;
    for seed in first..first + n_programs {
        let text = program(&mut Random::new(seed));
        let points = points(&mut Random::new(!seed));
        let points =
            points.into_iter().enumerate().map(|(k, at)| around(at, seed as usize * 5 + k));
        n_native += u64::from(check_program(&text, LIMITS, points, 4, &mut tally) == Some(true));
    }
    let (part, tightness) = (tally.part_answered(), tally.median_tightness());
    println!(
        "{n_native} native, {} requests, {part} answered, {} calls, bounds {tightness} times too wide",
        tally.asked, tally.calls
    );
    assert!(n_native * 2 > n_programs && part > 0.5, "{part} of {} answered", tally.asked);
}
