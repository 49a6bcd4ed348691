//! Functions of double-double numbers that take a series: sines, angles, powers.

use crate::numeric::dd::Dd;
use crate::numeric::real::{Real, around};

/// pi / 180.
const RADIANS_PER_DEGREE: Dd =
    Dd { hi: 0.017_453_292_519_943_295, lo: 2.948_652_270_870_168_7e-19 };
/// 180 / pi.
const DEGREES_PER_RADIAN: Dd = Dd { hi: 57.295_779_513_082_32, lo: -1.987_849_567_057_628_3e-15 };
/// The natural logarithm of 2.
const LN_2: Dd = Dd { hi: std::f64::consts::LN_2, lo: 2.319_046_813_846_299_6e-17 };

impl Dd {
    /// The sine and cosine of an angle in degrees; exact where they are 0, 1/2 or 1 in size.
    #[must_use]
    pub fn sin_cos_degrees(angle: f64) -> (Dd, Dd) {
        // Both steps are exact: `fmod`, and the fused step, whose result is below 45.
        let angle = libm::fmod(angle, 360.0);
        let quarter_turns = (angle / 90.0).round_ties_even();
        let rest = quarter_turns.mul_add(-90.0, angle);
        let (sin, cos) = first_octant(rest);
        match quarter_turns as i64 & 3 {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }
}

/// Sine and cosine of at most 45 degrees by their Taylor series.
fn first_octant(degrees: f64) -> (Dd, Dd) {
    let x = RADIANS_PER_DEGREE * Dd::from(degrees);
    let square = x * x;
    // (pi/4)^28 / 28! < 2^-106: the terms up to x^27 suffice.
    let series = |first: Dd, mut n: u32| {
        let (mut term, mut sum) = (first, first);
        while n < 28 {
            term = -(term * square) / Dd::from(f64::from(n * (n + 1)));
            sum = sum + term;
            n += 2;
        }
        sum
    };
    let sin = if degrees.abs() == 30.0 { Dd::from(0.5f64.copysign(degrees)) } else { series(x, 2) };
    (sin, series(Dd::ONE, 1))
}

/// The angle of the point (x, z) in turns; see [`Real::turns`].
pub(super) fn turns(x: Dd, z: Dd) -> Dd {
    around(x, z, |small, large| {
        if small == large {
            return Dd::from(0.125);
        }
        // An angle `near`, to a double's accuracy, and what is left by the addition theorem: a
        // tangent below 2^-50, which is its own arc tangent but for a third of its cube.
        let near = libm::atan(small.to_f64() / large.to_f64()) * DEGREES_PER_RADIAN.hi;
        let (sin, cos) = Dd::sin_cos_degrees(near);
        let rest = Dd::difference_of_products(small, cos, large, sin) / (large * cos + small * sin);
        (Dd::from(near) + rest * DEGREES_PER_RADIAN) / Dd::from(360.0)
    })
}

/// `base` to the power of `exponent`; see [`Real::power`].
pub(super) fn power(base: Dd, exponent: f64) -> Dd {
    // A product of n factors errs by n roundings of 5 units of 2^-106: up to here less than 8 bounds
    // of one operation.
    const BY_SQUARING: f64 = 64.0;
    if (0.0..=BY_SQUARING).contains(&exponent) && exponent.trunc() == exponent {
        return by_squaring(base, exponent as u32);
    }
    if base <= Dd::ZERO {
        return Dd::from(libm::pow(base.hi, exponent));
    }
    exp(ln(base) * Dd::from(exponent))
}

fn by_squaring(mut base: Dd, mut exponent: u32) -> Dd {
    let mut result = Dd::ONE;
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = result * base;
        }
        base = base * base;
        exponent >>= 1;
    }
    result
}

/// The exponential function, with an absolute error of the argument's last place.
fn exp(x: Dd) -> Dd {
    // Beyond, the result is no normal double.
    const LIMIT: f64 = 700.0;
    let within = x.hi.abs() <= LIMIT;
    if !within {
        return Dd::from(libm::exp(x.hi));
    }
    let twos = (x.hi / LN_2.hi).round_ties_even();
    let rest = x - LN_2 * Dd::from(twos);
    // The series is that of exp(r) - 1 for |r| < 2^-9, doubled eight times: e -> (1 + e)² - 1. Of
    // (2^-9)^n / n!, the eleventh is below 2^-124, which doubling makes 2^-116.
    const DOUBLINGS: i32 = 8;
    const TERMS: u32 = 11;
    let rest = rest.times_power_of_two(-DOUBLINGS);
    let (mut term, mut sum) = (rest, rest);
    for n in 2..TERMS {
        term = term * rest / Dd::from(f64::from(n));
        sum = sum + term;
    }
    for _ in 0..DOUBLINGS {
        sum = sum.times_power_of_two(1) + sum * sum;
    }
    (Dd::ONE + sum).times_power_of_two(twos as i32)
}

/// The natural logarithm of a number above 0, with a small relative error also near 1.
fn ln(x: Dd) -> Dd {
    // ln x = l + ln(x exp(-l)) with l so near that the second part has a short series, and 0 where
    // all of the logarithm is that part.
    const STEPS: f64 = 32.0;
    let near = (libm::log(x.hi) * STEPS).round_ties_even() / STEPS;
    if !near.is_finite() {
        return Dd::from(near);
    }
    // Further from 1 the exponential below comes near the ends of its range, and low parts to those of
    // doubles: 512 powers of two nearer to it neither does.
    const FAR: f64 = 600.0;
    if near.abs() > FAR {
        let twos = 512f64.copysign(near);
        return ln(x.times_power_of_two(-twos as i32)) + LN_2 * Dd::from(twos);
    }
    let rest = if near == 0.0 { x } else { x * exp(Dd::from(-near)) };
    // 2 atanh z for |z| < 2^-6: the term of z^21 is below 2^-130.
    let z = (rest - Dd::ONE) / (rest + Dd::ONE);
    let square = z * z;
    let mut sum = Dd::ZERO;
    for n in (1..20).rev().step_by(2) {
        sum = sum * square + Dd::ONE / Dd::from(f64::from(n));
    }
    Dd::from(near) + (z * sum).times_power_of_two(1)
}
