//! Trigonometry in degrees, exact where the exact result is a number people write down.
//!
//! Multiplying by pi/180 first loses thousands of units in the last place near multiples of 180
//! degrees. Here the angle is reduced in degrees, which is exact, and only the small remainder
//! turns into radians, carried as an unevaluated sum of two doubles. The polynomials are those of
//! fdlibm (Sun Microsystems, 1993: `k_sin`, `k_cos`, `e_asin`), whose error is below 2^-58 on
//! [-pi/4, pi/4]. With the rounding of the last step, the worst results measured are off by 0.663
//! units in the last place for the sine, 0.680 for the cosine, 0.743 for the arc cosine and, just
//! above 1/2, 0.989 for the arc sine. The tests have values near those.

/// pi/180 and 180/pi as sums of two doubles.
const RADIANS_HI: f64 = 0.017_453_292_519_943_295;
const RADIANS_LO: f64 = 2.948_652_270_870_168e-19;
const DEGREES_HI: f64 = 57.295_779_513_082_32;
const DEGREES_LO: f64 = -1.987_849_567_057_628e-15;

/// Below this the number of quarter turns, and its product with 90, are exact in the reduction.
const DIRECT_LIMIT: f64 = 1e12;

/// The unit in the last place of doubles of this size is 1, so that adding it rounds.
const ROUNDER: f64 = 1.5 * (1u64 << 52) as f64;

/// The angle as quadrant, of which the two lowest bits count, and remainder:
/// `angle = 90 quadrant + (-45..=45)`, but for a rounding error at the ends, modulo 360.
fn reduce(angle: f64) -> (u64, f64) {
    reduce_direct(if is_direct(angle) { angle } else { libm::fmod(angle, 360.0) })
}

/// The same for angles below [`DIRECT_LIMIT`].
#[inline(always)]
fn reduce_direct(angle: f64) -> (u64, f64) {
    let rounded = angle.mul_add(1.0 / 90.0, ROUNDER);
    (rounded.to_bits(), (rounded - ROUNDER).mul_add(-90.0, angle))
}

/// Degrees to radians as an unevaluated sum; `angle` is at most 45 in size.
#[inline(always)]
fn to_radians(angle: f64) -> (f64, f64) {
    let hi = angle * RADIANS_HI;
    (hi, angle.mul_add(RADIANS_HI, -hi) + angle * RADIANS_LO)
}

/// sin(x + y) for |x| <= pi/4 and y a tail of x.
#[inline(always)]
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
#[inline(always)]
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

/// The same without branches: what is not wanted is masked out, since a compiler may turn a choice
/// between two polynomials into a branch.
#[inline(always)]
fn quadrant_select(quarter_turns: u64, remainder: f64) -> f64 {
    let (x, y) = to_radians(remainder);
    let (sine, cosine) = (sin_kernel(x, y), cos_kernel(x, y));
    let sine = if remainder.abs() == 30.0 { 0.5f64.copysign(remainder) } else { sine };
    let is_odd = (quarter_turns & 1).wrapping_neg();
    let magnitude = (sine.to_bits() & !is_odd) | (cosine.to_bits() & is_odd);
    f64::from_bits(magnitude ^ (quarter_turns & 2) << 62) + 0.0
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

/// Whether [`sin_direct`] and [`cos_direct`] are the sine and cosine of an angle.
#[inline]
#[must_use]
pub fn is_direct(angle: f64) -> bool {
    angle.abs() < DIRECT_LIMIT
}

/// [`sin`] of an angle that [`is_direct`], to the bit. It has no branches, so that loops over it become
/// vector instructions; by itself it is slower.
#[inline(always)]
#[must_use]
pub fn sin_direct(angle: f64) -> f64 {
    let (quarter_turns, remainder) = reduce_direct(angle);
    quadrant_select(quarter_turns, remainder)
}

/// [`cos`] of an angle that [`is_direct`], as [`sin_direct`].
#[inline(always)]
#[must_use]
pub fn cos_direct(angle: f64) -> f64 {
    let (quarter_turns, remainder) = reduce_direct(angle);
    quadrant_select(quarter_turns.wrapping_add(1), remainder)
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
    fn without_branches_the_bits_are_the_same() {
        let limit = 1e12f64.next_down();
        let special = [0.0, -0.0, 1e-300, 30.0, 45.0, 45f64.next_up(), 90.0, 135.0, limit, -limit];
        let many = (-20_000i32..20_000).map(|k| f64::from(k) * 1.5);
        let odd = (-20_000i32..20_000).map(|k| f64::from(k).powi(3) * 0.123_456_789);
        for angle in special.into_iter().chain(many).chain(odd) {
            let of = |f: fn(f64) -> f64| f(angle).to_bits();
            assert!(is_direct(angle));
            assert_eq!((of(sin_direct), of(cos_direct)), (of(sin), of(cos)), "{angle}");
        }
        assert!([1e12, -1e300, f64::NAN, f64::INFINITY].iter().all(|angle| !is_direct(*angle)));
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

    /// How far a result is from `hi + lo`, in units in the last place of `hi`.
    fn ulps_off(got: f64, hi: f64, lo: f64) -> f64 {
        let unit = hi.abs().next_up() - hi.abs();
        (((got - hi) - lo) / unit).abs()
    }

    #[track_caller]
    fn assert_within(bound: f64, function: fn(f64) -> f64, values: impl Iterator<Item = [f64; 3]>) {
        for [x, hi, lo] in values {
            let ulps = ulps_off(function(x), hi, lo);
            assert!(ulps < bound, "{ulps} ulp at {x}");
        }
    }

    #[test]
    fn sine_and_cosine_are_within_three_quarters_of_a_unit() {
        assert_within(0.75, sin, SINES.iter().map(|&(x, hi, lo, ..)| [x, hi, lo]));
        assert_within(0.75, cos, SINES.iter().map(|&(x, _, _, hi, lo)| [x, hi, lo]));
    }

    /// The arc sine just above 1/2 is 90 less twice an angle of almost 30, so that the error of the
    /// larger number counts.
    #[test]
    fn arc_sine_is_within_one_unit_and_arc_cosine_within_three_quarters() {
        assert_within(1.0, asin, ARC_SINES.iter().map(|&(x, hi, lo, ..)| [x, hi, lo]));
        assert_within(0.75, acos, ARC_SINES.iter().map(|&(x, _, _, hi, lo)| [x, hi, lo]));
    }

    // Computed with 1400 bits by mpmath and rounded to 106: enough for the sine of 1e300 degrees.
    // The angles without a short form are the worst of some 100 000 at random.

    /// Angle, sine and cosine; the results as sums of two doubles.
    #[rustfmt::skip]
    #[expect(clippy::approx_constant, reason = "they are measured against the code, not used by it")]
    const SINES: [(f64, f64, f64, f64, f64); 40] = [
        (1.0, 0.01745240643728351, 1.1662166393407661e-18, 0.9998476951563913, -3.0420500034710914e-17),
        (7.5, 0.1305261922200516, -9.607666023901524e-18, 0.9914448613738104, 2.898989874454537e-17),
        (15.0, 0.25881904510252074, 2.287249500495561e-17, 0.9659258262890683, -2.5463971562308955e-17),
        (22.5, 0.3826834323650898, -1.0050772696461588e-17, 0.9238795325112867, 1.7645047084336677e-17),
        (29.999999999999996, 0.49999999999999994, 1.811902798636511e-18, 0.8660254037844387, -2.9843605815626635e-17),
        (30.000000000000004, 0.5, 5.3699248432621316e-17, 0.8660254037844386, 1.9172145571180006e-17),
        (36.0, 0.5877852522924731, -7.93475083819002e-18, 0.8090169943749475, -2.716057601841253e-17),
        (44.99999999999999, 0.7071067811865475, -2.5004669591996625e-17, 0.7071067811865476, 3.935403891998314e-17),
        (45.0, 0.7071067811865476, -4.833646656726457e-17, 0.7071067811865476, -4.833646656726457e-17),
        (45.00000000000001, 0.7071067811865476, 3.935403891998314e-17, 0.7071067811865475, -2.5004669591996625e-17),
        (59.99999999999999, 0.8660254037844386, -1.1831129966674504e-17, 0.5000000000000001, -3.623805597273027e-18),
        (60.00000000000001, 0.8660254037844387, 1.1596697222278641e-18, 0.4999999999999999, 3.6238055972730195e-18),
        (72.0, 0.9510565162951535, 4.0934500900087295e-17, 0.30901699437494745, -2.716057601841253e-17),
        (89.99999999999999, 1.0, -3.0758499010436085e-32, 2.4802620430283604e-16, 4.1902869026986405e-33),
        (90.00000000000001, 1.0, -3.0758499010436085e-32, -2.4802620430283604e-16, -4.1902869026986405e-33),
        (100.1, 0.9845031799744367, -5.411711446328545e-17, -0.175366726091987, -1.1882028397493375e-17),
        (135.0, 0.7071067811865476, -4.833646656726457e-17, -0.7071067811865476, 4.833646656726457e-17),
        (179.99999999999997, 4.960524086056721e-16, 8.380573805397266e-33, -1.0, 1.2303399604174434e-31),
        (180.00000000000003, -4.960524086056721e-16, -8.380573805397266e-33, -1.0, 1.2303399604174434e-31),
        (-0.1, -0.001745328365898309, 9.829358964865576e-20, 0.9999984769132877, 6.078279724601492e-18),
        (-33.3, -0.5490228179981317, -1.7332706271674516e-17, 0.8358073613682703, 1.1660362703501092e-17),
        (-225.0, 0.7071067811865476, -4.833646656726457e-17, -0.7071067811865476, 4.833646656726457e-17),
        (-359.99999999999994, 9.921048172113442e-16, 1.676114761079441e-32, 1.0, -4.921359841669774e-31),
        (1e-05, 1.745329251994321e-07, -6.184061021004098e-24, 0.9999999999999848, -2.0815551970749192e-17),
        (1e-300, 1.7453292519943295e-302, 7.8986e-319, 1.0, 0.0),
        (1234.5678, 0.4294427364776287, -1.781895387446449e-17, -0.9030940903840563, 5.100455701668196e-17),
        (-98765.4321, -0.8148031251425383, 4.684560676779724e-17, -0.5797377573161447, -4.3113170007620885e-17),
        (123456789.125, -0.15858889273546717, 7.369355703635931e-18, -0.9873447032829712, -3.3676918641188113e-17),
        (1000000000000.0, -0.984807753012208, -3.905108875799298e-17, 0.17364817766693036, -1.0090493350843633e-17),
        (1000000000000000.0, -0.984807753012208, -3.905108875799298e-17, 0.17364817766693036, -1.0090493350843633e-17),
        (1e+22, -0.984807753012208, -3.905108875799298e-17, 0.17364817766693036, -1.0090493350843633e-17),
        (1e+300, 0.0, 0.0, 1.0, 0.0),
        (136.89457749570641, 0.6833428735828077, -3.7392105773325016e-17, -0.7300976079426579, -2.6221025802411943e-17),
        (223.43181650858202, -0.6874908738200148, 3.7899030693531366e-17, -0.7261930173267934, -1.6981178717331956e-19),
        (224.0623090475763, -0.6954402401539347, 3.820059737499743e-17, -0.7185839355111118, -4.394128831166742e-17),
        (44.32344326606551, 0.6987080613600175, -3.818788190351065e-17, 0.7154069086824127, 1.0193247692634371e-17),
        (680537.6560389207, 0.6735798088319848, -3.917140186294154e-17, -0.739114497986521, -1.6594421518231244e-17),
        (313.75881392653616, -0.7222575766503245, 8.228519498667757e-19, 0.6916241703202691, -3.55607834061847e-17),
        (46.90143543155475, 0.7301793944541164, 4.4951347757302866e-17, 0.6832554807058776, -3.7026198765738066e-17),
        (313.02344488236156, -0.7310745732243058, 2.240535410834499e-17, 0.6822975658647034, -3.7381392544197127e-17),
    ];

    /// Number, arc sine and arc cosine in degrees; the results as sums of two doubles.
    #[rustfmt::skip]
    #[expect(clippy::approx_constant, reason = "they are measured against the code, not used by it")]
    const ARC_SINES: [(f64, f64, f64, f64, f64); 40] = [
        (1e-300, 5.729577951308232e-299, -7.2735344e-316, 90.0, -5.729577951308232e-299),
        (1e-10, 5.729577951308233e-09, -3.1595673153993164e-25, 89.99999999427042, -2.914668942831629e-15),
        (0.001, 0.0572957890623832, 2.252488793560603e-18, 89.94270421093762, -3.450882759035453e-15),
        (0.1, 5.739170477266787, -8.596032537252304e-18, 84.26082952273322, -4.432296065963374e-15),
        (0.2, 11.536959032815489, -1.7345885406538121e-16, 78.46304096718451, 1.7345885406538121e-16),
        (0.25, 14.477512185929925, -8.474532367814498e-16, 75.52248781407008, 8.474532367814498e-16),
        (0.3, 17.45760312372209, 6.247942972521337e-16, 72.5423968762779, 2.9279193815483673e-15),
        (0.4, 23.57817847820183, 1.1670075249690477e-15, 66.42182152179817, 2.3857061538314534e-15),
        (0.49999999999999994, 29.999999999999996, -1.1987452423007054e-16, 60.00000000000001, -3.4328391545704303e-15),
        (0.5000000000000001, 30.000000000000007, 2.3974904846014147e-16, 59.99999999999999, -2.3974904846014147e-16),
        (0.6, 36.86989764584402, -2.555908417416265e-16, 53.13010235415598, 2.555908417416265e-16),
        (0.7, 44.4270040008057, -2.169043996538986e-15, 45.5729959991943, 2.169043996538986e-15),
        (0.7071067811865476, 45.00000000000001, -3.188797501170834e-15, 44.99999999999999, 3.188797501170834e-15),
        (0.75, 48.590377890729144, -3.2666639776962116e-15, 41.409622109270856, 3.2666639776962116e-15),
        (0.8, 53.13010235415598, 2.9060530762945572e-15, 36.86989764584402, -2.9060530762945572e-15),
        (0.8660254037844386, 59.99999999999999, 1.3557476279224066e-15, 30.000000000000007, -1.3557476279224066e-15),
        (0.9, 64.15806723683288, -3.527587018634443e-15, 25.841932763167126, -2.512666016605776e-17),
        (0.99, 81.89038554400582, -6.006865145822692e-15, 8.109614455994182, 6.777946276219404e-16),
        (0.999999, 89.91897152479233, -4.472920931788395e-15, 0.08102847520767845, 4.273257672139978e-18),
        (0.9999999999999999, 89.99999914622636, -4.2449216870686505e-15, 8.537736462515939e-07, -2.1722273828790225e-23),
        (-0.05, -2.8659839825988622, 7.673609496139526e-17, 92.86598398259886, -5.208253048114579e-16),
        (-0.125, -7.180755781458282, 3.1607901749154665e-16, 97.18075578145829, -6.533327955392423e-15),
        (-0.45, -26.743683950403007, -2.3899086563470097e-16, 116.74368395040301, -3.3137228131658e-15),
        (-0.55, -33.36701296923175, -1.4187792193832288e-15, 123.36701296923175, 1.4187792193832288e-15),
        (-0.65, -40.541601873504526, 2.166367341285836e-15, 130.54160187350453, -9.271794698886838e-15),
        (-0.95, -71.80512766123321, -7.738271190171596e-16, 161.80512766123323, -1.3437027596184844e-14),
        (-0.999999999999, -89.99991897242779, -2.764746503752835e-15, 179.9999189724278, 2.764746503752835e-15),
        (-0.9999999999999999, -89.99999914622636, 4.2449216870686505e-15, 179.99999914622634, 9.965933028133354e-15),
        (0.5066570378369383, 30.441412131802355, -3.8822152755828204e-17, 59.55858786819765, -3.513891526044673e-15),
        (-0.50689022433067, -30.456910246772157, 6.462710317317884e-17, 120.45691024677215, 3.488086575627322e-15),
        (0.5174295419614349, 31.159987659085555, -1.1120217521596333e-16, 58.84001234091445, -3.4415115035845377e-15),
        (-0.5247277423438618, -31.64991681085998, 1.1222159459381952e-16, 121.64991681085998, 3.4404920842066813e-15),
        (0.5038711644865624, 30.25644638112391, 1.7227165228457482e-15, 59.743553618876085, 1.8299971559547527e-15),
        (0.5183175309121897, 31.219462317373786, 1.5031772154164527e-15, 58.78053768262621, 2.0495364633840484e-15),
        (0.5051909236704734, 30.344027121035072, 1.4881107031207467e-15, 59.655972878964924, 2.0646029756797543e-15),
        (0.5080708981260729, 30.53541845718841, -4.939767389195755e-16, 59.464581542811594, -3.0587369398809252e-15),
        (0.5049571015985646, 30.328504713482292, -6.14192201285812e-16, 59.67149528651771, -2.938521477514689e-15),
        (0.5703282999240686, 34.773122278747955, -2.614437673027747e-15, 55.226877721252045, 2.614437673027747e-15),
        (0.5154531677629661, 31.027750161044185, 8.310669910315274e-16, 58.97224983895581, 2.7216466877689733e-15),
        (0.5233593616697036, 31.557861813938953, -7.1465351623908e-16, 58.44213818606105, -2.838060162561421e-15),
    ];
}
