//! Trigonometry in degrees, exact where the exact result is a number people write down.
//!
//! Multiplying by pi/180 first loses thousands of units in the last place near multiples of 180
//! degrees. Here the angle is reduced in degrees, which is exact, and only the small remainder
//! turns into radians, carried as an unevaluated sum of two doubles. The polynomials are those of
//! fdlibm (Sun Microsystems, 1993: `k_sin`, `k_cos`, `e_asin`), whose error is below 2^-58 on
//! [-pi/4, pi/4]; with the rounding of the last step the results stay below 0.75 units in the last
//! place (measured in the tests against 30-digit values).

/// pi/180 and 180/pi as sums of two doubles.
const RADIANS_HI: f64 = 0.017_453_292_519_943_295;
const RADIANS_LO: f64 = 2.948_652_270_870_168_4e-19;
const DEGREES_HI: f64 = 57.295_779_513_082_32;
const DEGREES_LO: f64 = -1.987_849_567_057_628e-15;

/// Below this the quotient by 90 and its product with 90 are exact in the reduction step.
const DIRECT_LIMIT: f64 = 1e12;

/// The angle as quadrant and remainder: `angle = 90 quadrant + (-45..=45)`, modulo 360.
fn reduce(angle: f64) -> (u64, f64) {
    let angle = if angle.abs() < DIRECT_LIMIT { angle } else { libm::fmod(angle, 360.0) };
    let quarter_turns = (angle / 90.0).round_ties_even();
    (quarter_turns as i64 as u64, quarter_turns.mul_add(-90.0, angle))
}

/// Degrees to radians as an unevaluated sum; `angle` is at most 45 in size.
fn to_radians(angle: f64) -> (f64, f64) {
    let hi = angle * RADIANS_HI;
    (hi, angle.mul_add(RADIANS_HI, -hi) + angle * RADIANS_LO)
}

/// sin(x + y) for |x| <= pi/4 and y a tail of x.
fn sin_kernel(x: f64, y: f64) -> f64 {
    const S1: f64 = -1.666_666_666_666_663_2e-1;
    const S2: f64 = 8.333_333_333_322_49e-3;
    const S3: f64 = -1.984_126_982_985_795e-4;
    const S4: f64 = 2.755_731_370_707_006_8e-6;
    const S5: f64 = -2.505_076_025_340_686_3e-8;
    const S6: f64 = 1.589_690_995_211_55e-10;
    let z = x * x;
    let r = z.mul_add(z.mul_add(z.mul_add(z.mul_add(S6, S5), S4), S3), S2);
    let cube = z * x;
    x + (cube.mul_add(S1, z.mul_add(cube.mul_add(r, -0.5 * y), y)))
}

/// cos(x + y) for |x| <= pi/4 and y a tail of x.
fn cos_kernel(x: f64, y: f64) -> f64 {
    const C1: f64 = 4.166_666_666_666_66e-2;
    const C2: f64 = -1.388_888_888_887_411e-3;
    const C3: f64 = 2.480_158_728_947_673e-5;
    const C4: f64 = -2.755_731_435_139_066_3e-7;
    const C5: f64 = 2.087_572_321_298_175e-9;
    const C6: f64 = -1.135_964_755_778_819_5e-11;
    let z = x * x;
    let r = z.mul_add(z.mul_add(z.mul_add(z.mul_add(z.mul_add(C6, C5), C4), C3), C2), C1);
    // 1 - z/2 with the rounding error of both steps, so that only the last addition rounds.
    let half = 0.5 * z;
    let half_error = x.mul_add(x, -z) * 0.5;
    let w = 1.0 - half;
    w + (((1.0 - w) - half) + (z * z).mul_add(r, x.mul_add(-y, -half_error)))
}

fn quadrant(quarter_turns: u64, remainder: f64) -> f64 {
    let exact_half = remainder.abs() == 30.0;
    let (x, y) = to_radians(remainder);
    let magnitude = match quarter_turns & 1 {
        // sin 30 degrees is one half, the one other rational value (Niven's theorem).
        0 if exact_half => 0.5f64.copysign(remainder),
        0 => sin_kernel(x, y),
        _ => cos_kernel(x, y),
    };
    // Adding 0.0 turns -0.0 into 0.0, so that sin 180 is the same zero as sin 0.
    if quarter_turns & 2 == 0 { magnitude + 0.0 } else { -magnitude + 0.0 }
}

/// The sine of an angle in degrees; NaN for infinities.
#[must_use]
pub fn sin(angle: f64) -> f64 {
    let (quarter_turns, remainder) = reduce(angle);
    quadrant(quarter_turns, remainder)
}

/// The cosine of an angle in degrees; NaN for infinities.
#[must_use]
pub fn cos(angle: f64) -> f64 {
    let (quarter_turns, remainder) = reduce(angle);
    quadrant(quarter_turns.wrapping_add(1), remainder)
}

/// (asin(x) - x) / x as a function of x squared, for |x| <= 1/2.
fn asin_tail(z: f64) -> f64 {
    const P: [f64; 6] = [
        1.666_666_666_666_666_6e-1,
        -3.255_658_186_224_009e-1,
        2.012_125_321_348_629_3e-1,
        -4.005_553_450_067_941e-2,
        7.915_349_942_898_145e-4,
        3.479_331_075_960_212e-5,
    ];
    const Q: [f64; 5] = [
        1.0,
        -2.403_394_911_734_414,
        2.020_945_760_233_505_7,
        -6.882_839_716_054_533e-1,
        7.703_815_055_590_194e-2,
    ];
    let horner = |c: &[f64]| c.iter().rev().fold(0.0, |sum: f64, &k| sum.mul_add(z, k));
    z * horner(&P) / horner(&Q)
}

/// The arc sine of `s + s_lo`, |s| <= 1/2, in degrees times `factor`, as an unevaluated sum.
fn small_asin(s: f64, s_lo: f64, factor: f64) -> (f64, f64) {
    let scale = factor * DEGREES_HI;
    let tail = s.mul_add(asin_tail(s * s), s_lo);
    let hi = s * scale;
    (hi, s.mul_add(scale, -hi) + s.mul_add(factor * DEGREES_LO, tail * scale))
}

/// The arc sine in degrees of a number from 1/2 to 1, from which 90 is yet to be taken: twice the
/// arc sine of the half angle, sqrt((1 - x)/2).
fn half_angle(x: f64) -> (f64, f64) {
    let z = 0.5 * (1.0 - x);
    let s = z.sqrt();
    let s_lo = if s == 0.0 { 0.0 } else { s.mul_add(-s, z) / (2.0 * s) };
    small_asin(s, s_lo, 2.0)
}

/// `a - (hi + lo)`, rounded once; |a| > |hi|.
fn less_sum(a: f64, (hi, lo): (f64, f64)) -> f64 {
    let difference = a - hi;
    difference + (((a - difference) - hi) - lo)
}

/// The arc sine in degrees, from -90 to 90; NaN outside [-1, 1].
#[must_use]
pub fn asin(x: f64) -> f64 {
    if x.abs() <= 0.5 {
        let (hi, lo) = small_asin(x, 0.0, 1.0);
        return hi + lo;
    }
    less_sum(90.0, half_angle(x.abs())).copysign(x)
}

/// The arc cosine in degrees, from 0 to 180; NaN outside [-1, 1].
#[must_use]
pub fn acos(x: f64) -> f64 {
    if x.abs() <= 0.5 {
        return less_sum(90.0, small_asin(x, 0.0, 1.0));
    }
    let half = half_angle(x.abs());
    if x < 0.0 { less_sum(180.0, half) } else { half.0 + half.1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_of_thirty_and_ninety_are_exact() {
        let sines =
            [0.0, 0.5, f64::NAN, 1.0, f64::NAN, 0.5, 0.0, -0.5, f64::NAN, -1.0, f64::NAN, -0.5];
        for k in -1200i64..1200 {
            let expected = sines[k.rem_euclid(12) as usize];
            if expected.is_nan() {
                continue;
            }
            assert_eq!(sin(30.0 * k as f64).to_bits(), expected.to_bits(), "sin {}", 30 * k);
            assert_eq!(cos(30.0 * k as f64 - 90.0).to_bits(), expected.to_bits(), "cos");
        }
    }

    #[test]
    fn sine_is_odd_and_cosine_even_and_far_angles_reduce_exactly() {
        for k in 1..5000 {
            let angle = f64::from(k) * 0.7310585;
            assert_eq!(sin(-angle), -sin(angle));
            assert_eq!(cos(-angle), cos(angle));
            // The sum is exact for angles with few bits.
            let near = f64::from(k) / 8.0;
            assert_eq!(sin(near), sin(near + 360.0 * 1e9));
        }
        assert_eq!(sin(1e300), sin(libm::fmod(1e300, 360.0)));
        assert!(sin(f64::INFINITY).is_nan() && cos(f64::NAN).is_nan());
    }

    #[test]
    fn inverse_functions_hit_the_exact_angles() {
        assert_eq!((acos(0.5), acos(-0.5), asin(0.5), asin(-0.5)), (60.0, 120.0, 30.0, -30.0));
        assert_eq!(
            (acos(1.0), acos(-1.0), acos(0.0), asin(1.0), asin(-1.0)),
            (0.0, 180.0, 90.0, 90.0, -90.0)
        );
        assert!(
            asin(1.0000000000000002).is_nan() && acos(-2.0).is_nan() && acos(f64::NAN).is_nan()
        );
    }
}
