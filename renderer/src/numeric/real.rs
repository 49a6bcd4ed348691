//! The scalar type that the tracer's formulas are written over.

use std::cmp::Ordering;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::numeric::dd::Dd;

/// A type that stands for real numbers.
///
/// Implementations must be deterministic to the last bit on every target.
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// The relative error of one rounding: for doubles, half the distance from 1 to the next.
    const UNIT_ROUNDOFF: f64;
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;

    /// Whether the numbers come with bounds of their errors.
    const KEEPS_ACCOUNT: bool = false;
    /// Whether surface functions are asked for bounds of their answers, since texture coordinates
    /// are not known to the last bit of a double.
    const ASKS_FOR_BOUNDS: bool = false;
    /// Whether a result that is not certain is thrown away, so that a formula need not have the middles
    /// that it has in plain numbers: those of balls of double-double are what the rules decide by.
    const COUNTS_ONLY_IF_CERTAIN: bool = false;
    /// Whether a product of two doubles is such a number.
    const HOLDS_DOUBLE_PRODUCTS: bool;

    /// The number itself.
    fn from_f64(value: f64) -> Self;

    /// The nearest number of this type.
    fn from_dd(value: Dd) -> Self;

    /// The nearest number of this type to one that is known up to an error.
    #[must_use]
    fn from_bounded(value: Dd, error: f64) -> Self {
        let _ = error;
        Self::from_dd(value)
    }

    /// The nearest double.
    fn to_f64(self) -> f64;

    /// The size.
    #[must_use]
    fn abs(self) -> Self;

    /// The square root, 0 for negative numbers: those are roundings of 0 wherever the tracer asks.
    #[must_use]
    fn sqrt_or_zero(self) -> Self;

    /// A vector divided by its length, which is above 0.
    #[must_use]
    #[inline(always)]
    fn unit(v: [Self; 3]) -> [Self; 3] {
        let inverse = Self::ONE / Self::dot(v, v).sqrt_or_zero();
        v.map(|x| x * inverse)
    }

    /// The product with a sign: -1, 0 or 1.
    #[must_use]
    #[inline(always)]
    fn with_sign(self, sign: f64) -> Self {
        Self::from_f64(sign) * self
    }

    /// `self * factor + term` with one rounding; of double-double, while 2^-44 of the terms is left.
    #[must_use]
    fn mul_add(self, factor: Self, term: Self) -> Self;

    /// The inner product.
    #[must_use]
    #[inline(always)]
    fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
    }

    /// The inner product and a number, added up.
    #[must_use]
    #[inline(always)]
    fn dot_and(a: [Self; 3], b: [Self; 3], term: Self) -> Self {
        a[0].mul_add(b[0], a[1].mul_add(b[1], a[2].mul_add(b[2], term)))
    }

    /// `a*b - c*d` with a relative error of at most 3 roundings, however much of it cancels; of
    /// double-double, while 2^-44 of the terms is left (Kahan; see Jeannerod, Louvet and Muller,
    /// "Further analysis of Kahan's algorithm for the accurate computation of 2x2 determinants", 2013).
    #[must_use]
    fn difference_of_products(a: Self, b: Self, c: Self, d: Self) -> Self;

    /// `s1 x² + s2 y² + s3 z² - k` for signs s, however much of it cancels: the relative error is a
    /// few units in the last place unless the exact value is below 2^-44 of its terms.
    #[must_use]
    fn signed_squares(signs: [f64; 3], p: [Self; 3], k: f64) -> Self;

    /// `base` to the power of `exponent`, for a base above 0.
    #[must_use]
    fn power(base: Self, exponent: f64) -> Self;

    /// The angle of the point (x, z) around the y axis in turns, from +z toward +x, in [0, 1); 0
    /// for the origin.
    #[must_use]
    fn turns(x: Self, z: Self) -> Self;

    /// The smaller of two numbers; the other one if one is NaN.
    #[must_use]
    fn min(self, other: Self) -> Self {
        if other < self || self.is_nan() { other } else { self }
    }

    /// The larger of two numbers; the other one if one is NaN.
    #[must_use]
    fn max(self, other: Self) -> Self {
        if other > self || self.is_nan() { other } else { self }
    }

    /// The order of numbers, with a place for NaN.
    fn total_cmp(&self, other: &Self) -> Ordering;

    /// Whether it is no number at all.
    fn is_nan(self) -> bool;

    /// Whether it is above 0, by more than the `tolerance` for rounding.
    #[must_use]
    fn exceeds(self, tolerance: f64) -> bool {
        self.to_f64() > tolerance
    }

    /// Whether it is 0, up to the `tolerance` for rounding.
    #[must_use]
    fn vanishes(self, tolerance: f64) -> bool {
        self.abs().to_f64() <= tolerance
    }

    /// Whether its size is below a bound that is itself part of the rules.
    #[must_use]
    fn is_below(self, bound: f64) -> bool {
        self.abs().to_f64() < bound
    }

    /// Whether it is 0 without doubt.
    #[must_use]
    fn is_surely_zero(self) -> bool {
        self == Self::ZERO
    }

    /// Whether it is above 0 without doubt.
    #[must_use]
    fn is_surely_positive(self) -> bool {
        self > Self::ZERO
    }

    /// How far off it may be, of types that keep account of that.
    #[must_use]
    fn radius(self) -> f64 {
        0.0
    }

    /// The nearest double to the number that is meant.
    #[must_use]
    fn nearest_double(self) -> f64 {
        self.to_f64()
    }

    /// The doubles nearest to the least and to the largest number that may be meant.
    #[must_use]
    fn ends(self) -> [f64; 2] {
        [self.to_f64(); 2]
    }

    /// Whether this thread has made a decision that could not be made for certain, of types that
    /// notice, since this was asked last.
    #[must_use]
    fn take_doubt() -> bool {
        false
    }
}

/// The angle of the point (x, z) from that of `(small, large)`, at most an eighth of a turn, of
/// which the rest is symmetry: so multiples of an eighth come out exact.
#[inline]
pub(crate) fn around<R: Real>(x: R, z: R, angle: impl FnOnce(R, R) -> R) -> R {
    let (ax, az) = (x.abs(), z.abs());
    if ax == R::ZERO && az == R::ZERO {
        return R::ZERO;
    }
    let from_f64 = R::from_f64;
    let octant = if ax <= az { angle(ax, az) } else { from_f64(0.25) - angle(az, ax) };
    let half = if z < R::ZERO { from_f64(0.5) - octant } else { octant };
    let turn = if x < R::ZERO { R::ONE - half } else { half };
    // Just left of the seam the nearest number is 1, which is the seam itself.
    if turn < R::ONE { turn } else { R::ZERO }
}

impl Real for f64 {
    const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;
    const ZERO: f64 = 0.0;
    const ONE: f64 = 1.0;
    const HOLDS_DOUBLE_PRODUCTS: bool = false;

    #[inline(always)]
    fn from_f64(value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn from_dd(value: Dd) -> f64 {
        value.to_f64()
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline(always)]
    fn abs(self) -> f64 {
        self.abs()
    }

    #[inline(always)]
    fn sqrt_or_zero(self) -> f64 {
        if self > 0.0 { self.sqrt() } else { 0.0 }
    }

    #[inline(always)]
    fn mul_add(self, factor: f64, term: f64) -> f64 {
        self.mul_add(factor, term)
    }

    #[inline(always)]
    fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
        let cd = c * d;
        let error = (-c).mul_add(d, cd);
        a.mul_add(b, -cd) + error
    }

    #[inline(always)]
    fn signed_squares([s1, s2, s3]: [f64; 3], [x, y, z]: [f64; 3], k: f64) -> f64 {
        let (xx, yy, zz) = (s1 * x * x, s2 * y * y, s3 * z * z);
        let sum = xx + yy + zz - k;
        // Seven roundings of at most the terms' size: with this much left, all but 2^-40 is right.
        const CANCELLED: f64 = 1.0 / 4096.0;
        if sum.abs() >= CANCELLED * (xx.abs() + yy.abs() + zz.abs()) {
            return sum;
        }
        cancelled_squares([s1, s2, s3], [x, y, z], k)
    }

    fn power(base: f64, exponent: f64) -> f64 {
        if is_by_squaring(exponent) {
            return by_squaring(base, exponent as u32);
        }
        libm::pow(base, exponent)
    }

    fn turns(x: f64, z: f64) -> f64 {
        const RADIANS_PER_TURN: f64 = std::f64::consts::TAU;
        around(x, z, |small, large| libm::atan(small / large) / RADIANS_PER_TURN)
    }

    #[inline(always)]
    fn total_cmp(&self, other: &f64) -> Ordering {
        self.total_cmp(other)
    }

    #[inline(always)]
    fn is_nan(self) -> bool {
        self.is_nan()
    }
}

/// The same sum with twice the digits.
#[cold]
#[inline(never)]
fn cancelled_squares(signs: [f64; 3], p: [f64; 3], k: f64) -> f64 {
    let mut sum = -Dd::from(k);
    for (sign, coordinate) in signs.into_iter().zip(p) {
        sum = sum + Dd::from(sign * coordinate) * Dd::from(coordinate);
    }
    sum.to_f64()
}

/// Whether a power is found by squaring, which takes a fraction of the time of `pow`: by whole exponents
/// that a highlight may have.
///
/// That costs less than `exponent` roundings, no more than what one rounding of the base does to any
/// power of it. At the largest of these exponents that is 1.1e-13 of a highlight, whose levels in a byte
/// are 4e-3 apart.
#[inline(always)]
pub(crate) fn is_by_squaring(exponent: f64) -> bool {
    const MOST: f64 = 1024.0;
    (0.0..=MOST).contains(&exponent) && exponent.trunc() == exponent
}

fn by_squaring(mut base: f64, mut exponent: u32) -> f64 {
    let mut result = 1.0;
    while exponent > 0 {
        if exponent & 1 == 1 {
            result *= base;
        }
        base *= base;
        exponent >>= 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_of_products_keep_what_cancels() {
        let x = 1.0 + f64::EPSILON;
        // (1 + e)^2 - (1 + 2e) * 1 is e^2 exactly.
        let exact = f64::EPSILON * f64::EPSILON;
        assert_eq!(f64::difference_of_products(x, x, 1.0 + 2.0 * f64::EPSILON, 1.0), exact);
    }

    #[test]
    fn sums_of_squares_keep_what_cancels() {
        // (1 + e)² - 1 is 2e + e².
        let x = 1.0 + f64::EPSILON;
        let exact = 2.0 * f64::EPSILON + f64::EPSILON * f64::EPSILON;
        assert_eq!(f64::signed_squares([1.0, 1.0, 1.0], [x, 0.0, 0.0], 1.0), exact);
        assert_eq!(f64::signed_squares([1.0, -1.0, 1.0], [3e7, 5e7, 4e7], 0.0), 0.0);
        assert_eq!(f64::signed_squares([1.0, 0.0, 1.0], [3.0, 7.0, 4.0], 1.0), 24.0);
    }

    #[test]
    fn turns_are_exact_at_eighths_and_stay_below_one() {
        let cases = [
            (0.0, 1.0, 0.0),
            (1.0, 1.0, 0.125),
            (1.0, 0.0, 0.25),
            (1.0, -1.0, 0.375),
            (0.0, -1.0, 0.5),
            (-1.0, -1.0, 0.625),
            (-1.0, 0.0, 0.75),
            (-1.0, 1.0, 0.875),
            (-1e-17, 1.0, 0.0),
            (-0.0, 1.0, 0.0),
            (0.0, 0.0, 0.0),
        ];
        for (x, z, expected) in cases {
            assert_eq!(f64::turns(x, z), expected, "{x} {z}");
        }
    }

    #[test]
    fn turns_agree_with_their_sine_and_cosine() {
        for k in 0..10_000 {
            let angle = f64::from(k) * 0.000_628_3;
            let turn = f64::turns(angle.sin(), angle.cos());
            // `sin`, `cos` and `turns` err by about an ulp of 1 each.
            assert!(
                (turn - angle / std::f64::consts::TAU).abs() < 8.0 * f64::EPSILON,
                "{angle} {turn}"
            );
        }
    }

    #[test]
    fn powers_by_squaring_and_by_pow_agree() {
        for n in 0..=32u32 {
            for k in 1..40 {
                let base = f64::from(k) / 40.0;
                let (fast, slow) = (f64::power(base, f64::from(n)), libm::pow(base, f64::from(n)));
                let bound = f64::from(n + 2) * f64::UNIT_ROUNDOFF * slow;
                assert!((fast - slow).abs() <= bound, "{base}^{n}: {fast} {slow}");
            }
        }
        assert_eq!(f64::power(0.0, 0.0), 1.0);
    }
}
