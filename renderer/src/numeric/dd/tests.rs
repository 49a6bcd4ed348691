//! Double-double numbers against numbers of 256 bits.

use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;

use super::*;
use crate::numeric::real::Real;

type Big = FBig<HalfEven>;

/// Bits that the expected values are computed with.
const PRECISION: usize = 256;

fn big(value: f64) -> Big {
    Big::try_from(value).expect("finite").with_precision(PRECISION).value()
}

/// The number as it is.
fn exactly(value: Dd) -> Big {
    big(value.hi) + big(value.lo)
}

/// How far a number is off, in units of 2^-106 of the value expected.
#[track_caller]
fn off_by(found: Dd, expected: &Big) -> f64 {
    if *expected == Big::ZERO {
        assert_eq!(found, Dd::ZERO);
        return 0.0;
    }
    assert_eq!(found.hi + found.lo, found.hi, "not normal");
    let relative = (exactly(found) - expected) / expected;
    relative.to_f64().value().abs() * 2f64.powi(106)
}

/// A sequence of numbers with many digits, of sizes from 2^-20 to 2^20.
struct Numbers(u64);

impl Numbers {
    fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn any(&mut self) -> Dd {
        let hi = (2.0 * self.unit() - 1.0) * f64::exp2((40.0 * self.unit() - 20.0).round());
        two_sum(hi, (self.unit() - 0.5) * hi * f64::EPSILON)
    }

    fn positive(&mut self) -> Dd {
        self.any().abs()
    }
}

/// The largest error among many cases, in units of 2^-106.
fn worst(n: usize, mut case: impl FnMut(&mut Numbers) -> f64) -> f64 {
    let mut numbers = Numbers(1);
    (0..n).map(|_| case(&mut numbers)).fold(0.0, f64::max)
}

#[test]
fn operations_keep_their_bounds() {
    let sum = |numbers: &mut Numbers| {
        let (a, b) = (numbers.any(), numbers.any());
        off_by(a + b, &(exactly(a) + exactly(b))).max(off_by(a - b, &(exactly(a) - exactly(b))))
    };
    assert!(worst(5000, sum) <= 3.0);
    let product = |numbers: &mut Numbers| {
        let (a, b) = (numbers.any(), numbers.any());
        off_by(a * b, &(exactly(a) * exactly(b)))
    };
    assert!(worst(5000, product) <= 5.0);
    let quotient = |numbers: &mut Numbers| {
        let (a, b) = (numbers.any(), numbers.any());
        off_by(a / b, &(exactly(a) / exactly(b)))
    };
    assert!(worst(5000, quotient) <= 10.0);
    let root = |numbers: &mut Numbers| {
        let a = numbers.positive();
        off_by(a.sqrt_or_zero(), &exactly(a).sqrt())
    };
    assert!(worst(5000, root) <= 4.0);
}

#[test]
fn sums_that_cancel_keep_their_bound() {
    let bound = 64.0;
    // As much cancels as may, and rather more than a double could bear if several do.
    let near = |a: Dd, numbers: &mut Numbers| {
        let apart = f64::exp2(-(40.0 * numbers.unit()).round());
        a + a * Dd::from(apart * (numbers.unit() - 0.5))
    };
    let difference = |numbers: &mut Numbers| {
        let (a, b) = (numbers.any(), numbers.any());
        let (c, d) = (near(a, numbers), near(b, numbers));
        let exact = exactly(a) * exactly(b) - exactly(c) * exactly(d);
        off_by(Dd::difference_of_products(a, b, c, d), &exact)
    };
    assert!(worst(5000, difference) <= bound);
    let fused = |numbers: &mut Numbers| {
        let (a, b) = (numbers.any(), numbers.any());
        let term = near(-(a * b), numbers);
        off_by(a.mul_add(b, term), &(exactly(a) * exactly(b) + exactly(term)))
    };
    assert!(worst(5000, fused) <= bound);
    let squares = |numbers: &mut Numbers| {
        let unit = numbers.unit() * 90.0;
        let (sin, cos) = Dd::sin_cos_degrees(unit);
        let p = [near(sin, numbers), Dd::from(numbers.unit()), near(cos, numbers)];
        let [x, y, z] = p.map(exactly);
        let cylinder = &x * &x + &z * &z - big(1.0);
        let sphere = &cylinder + &y * &y;
        off_by(Dd::signed_squares([1.0, 0.0, 1.0], p, 1.0), &cylinder)
            .max(off_by(Dd::signed_squares([1.0, 1.0, 1.0], p, 1.0), &sphere))
    };
    assert!(worst(5000, squares) <= bound);
    // What is left of nearly everything has a few digits still.
    let residue = |numbers: &mut Numbers| {
        let (a, b) = (numbers.any(), numbers.any());
        let exact = exactly(a) * exactly(b) - exactly(a * b);
        off_by(a.mul_add(b, -(a * b)), &exact)
    };
    assert!(worst(5000, residue) <= 2f64.powi(106 - 40));
    // (3, 5, 4) lies on the cone.
    let on_cone = [3e7, 5e7, 4e7].map(Dd::from);
    assert_eq!(Dd::signed_squares([1.0, -1.0, 1.0], on_cone, 0.0), Dd::ZERO);
}

#[test]
fn sines_and_cosines_of_degrees_keep_their_bound() {
    let case = |numbers: &mut Numbers| {
        let degrees = (numbers.unit() - 0.5) * 89.0;
        let (sin, cos) = Dd::sin_cos_degrees(degrees);
        let (s, c) = (big(degrees) * Big::pi(PRECISION) / big(180.0)).sin_cos();
        off_by(sin, &s).max(off_by(cos, &c))
    };
    assert!(worst(300, case) <= 64.0);
    let exact = [
        (0.0, 0.0, 1.0),
        (90.0, 1.0, 0.0),
        (180.0, 0.0, -1.0),
        (270.0, -1.0, 0.0),
        (-90.0, -1.0, 0.0),
        (36_000.0, 0.0, 1.0),
    ];
    for (angle, sin, cos) in exact {
        assert_eq!(Dd::sin_cos_degrees(angle), (Dd::from(sin), Dd::from(cos)), "{angle}");
    }
    assert_eq!(Dd::sin_cos_degrees(30.0).0, Dd::from(0.5));
    assert_eq!(Dd::sin_cos_degrees(-60.0).1, Dd::from(0.5));
}

#[test]
fn turns_are_arc_tangents() {
    let case = |numbers: &mut Numbers| {
        let (x, z) = (numbers.any(), numbers.any());
        let full = Big::pi(PRECISION) * big(2.0);
        let angle = exactly(x).atan2(&exactly(z)) / full;
        let angle = if x < Dd::ZERO { angle + big(1.0) } else { angle };
        off_by(Dd::turns(x, z), &angle)
    };
    assert!(worst(300, case) <= 64.0);
    for (x, z, turns) in [
        (0.0, 1.0, 0.0),
        (1.0, 1.0, 0.125),
        (1.0, 0.0, 0.25),
        (1.0, -1.0, 0.375),
        (0.0, -1.0, 0.5),
        (-1.0, 0.0, 0.75),
        (-1.0, 1.0, 0.875),
        (0.0, 0.0, 0.0),
    ] {
        assert_eq!(Dd::turns(Dd::from(x), Dd::from(z)), Dd::from(turns), "{x} {z}");
    }
}

#[test]
fn powers_keep_their_bound() {
    let case = |numbers: &mut Numbers| {
        let base = numbers.positive();
        // Some whole numbers, some not, some of them negative.
        let exponent = (numbers.unit() - 0.3) * 40.0;
        let exponent = if numbers.unit() < 0.3 { exponent.round() } else { exponent };
        let log = exactly(base).ln() * big(exponent);
        let size = log.to_f64().value().abs();
        off_by(Dd::power(base, exponent), &log.exp()) / (64.0 * (2.0 * size + 8.0))
    };
    assert!(worst(500, case) <= 1.0);
    // Highlights: whole exponents, of bases just below 1.
    let highlight = |numbers: &mut Numbers| {
        let base = Dd::ONE - numbers.positive() * Dd::from(1e-9);
        let exponent = (numbers.unit() * 1000.0).round();
        off_by(Dd::power(base, exponent), &exactly(base).powi((exponent as i64).into()))
    };
    assert!(worst(500, highlight) <= 64.0 * 10.0);
    // A logarithm near 0 is known as well as others are.
    let base = Dd::ONE - Dd::from(1e-10);
    let exponent = 1e10 + 0.5;
    let expected = (exactly(base).ln() * big(exponent)).exp();
    assert!(off_by(Dd::power(base, exponent), &expected) <= 64.0 * 10.0);
}

#[test]
fn powers_of_what_is_far_from_one_keep_their_bound() {
    for base in [1e-320, 1e-305, 1e-270, 1e270, 1.7e308] {
        for exponent in [-0.5, 0.3, 0.5] {
            let log = big(base).ln() * big(exponent);
            let bound = 64.0 * (2.0 * log.to_f64().value().abs() + 8.0);
            let power = Dd::power(Dd::from(base), exponent);
            assert!(off_by(power, &log.exp()) <= bound, "{base}^{exponent}");
        }
    }
}

#[test]
fn powers_have_ends() {
    let power = |base: f64, exponent: f64| Dd::power(Dd::from(base), exponent).to_f64();
    assert_eq!((power(0.0, 0.0), power(0.0, 2.5), power(0.5, 1e300)), (1.0, 0.0, 0.0));
    assert_eq!((power(0.0, -1.0), power(0.5, -1e300)), (f64::INFINITY, f64::INFINITY));
    assert_eq!((power(1.0, 1e300), power(1.0, -2.5)), (1.0, 1.0));
    assert!(power(f64::NAN, 0.5).is_nan() && power(f64::INFINITY, 0.5).is_infinite());
}

#[test]
fn what_is_no_number_behaves_as_in_doubles() {
    let values = [0.0, -0.0, 1.0, -2.5, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 1e300];
    for a in values {
        for b in values {
            let (x, y) = (Dd::from(a), Dd::from(b));
            let pairs = [(x + y, a + b), (x - y, a - b), (x * y, a * b), (x / y, a / b)];
            for (found, expected) in pairs {
                assert!(
                    found.to_f64() == expected || found.to_f64().is_nan() && expected.is_nan(),
                    "{a} {b}: {found:?}, not {expected}"
                );
            }
            assert_eq!(x.partial_cmp(&y), a.partial_cmp(&b));
        }
        let root = if a > 0.0 { a.sqrt() } else { 0.0 };
        assert_eq!(Dd::from(a).sqrt_or_zero().to_f64(), root);
    }
}

#[test]
fn numbers_are_told_apart_by_their_low_parts() {
    let (a, b) = (Dd::ONE, Dd { hi: 1.0, lo: 1e-30 });
    assert!(a < b && a != b && a.total_cmp(&b) == Ordering::Less && Real::max(a, b) == b);
    assert_eq!(Dd::from_dd(b), b);
}
