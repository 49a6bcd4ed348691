//! Double-double numbers: unevaluated sums of two doubles, with about 106 bits.
//!
//! Sources: T. J. Dekker, "A floating-point technique for extending the available precision"
//! (1971); Joldes, Muller and Popescu, "Tight and rigorous error bounds for basic building blocks
//! of double-word arithmetic" (2017), whose algorithms 6 (sum), 12 (product) and 17 (quotient)
//! these are: relative errors of at most 3, 5 and 10 times 2^-106.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The sum `hi + lo`, with `|lo|` at most half a unit in the last place of `hi`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dd {
    hi: f64,
    lo: f64,
}

/// Bound of the relative error of one operation on [`Dd`], the square root and the functions of
/// degrees included.
pub const DD_ERROR: f64 = 1.0 / (1u64 << 50) as f64 / (1u64 << 50) as f64;

/// `a + b` as a sum of its rounding and the exact error.
#[inline]
fn two_sum(a: f64, b: f64) -> Dd {
    let hi = a + b;
    let b_part = hi - a;
    Dd { hi, lo: (a - (hi - b_part)) + (b - b_part) }
}

/// The same for `|a| >= |b|` or `a == 0`.
#[inline]
fn quick_two_sum(a: f64, b: f64) -> Dd {
    let hi = a + b;
    Dd { hi, lo: b - (hi - a) }
}

/// `a * b` as a sum of its rounding and the exact error.
#[inline]
fn two_product(a: f64, b: f64) -> Dd {
    let hi = a * b;
    Dd { hi, lo: a.mul_add(b, -hi) }
}

impl Dd {
    /// 0.
    pub const ZERO: Dd = Dd { hi: 0.0, lo: 0.0 };
    /// 1.
    pub const ONE: Dd = Dd { hi: 1.0, lo: 0.0 };
    /// pi / 180.
    const RADIANS_PER_DEGREE: Dd =
        Dd { hi: 0.017_453_292_519_943_295, lo: 2.948_652_270_870_168_7e-19 };

    /// The nearest double.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        self.hi
    }

    /// The size.
    #[must_use]
    pub fn abs(self) -> Dd {
        if self.hi < 0.0 { -self } else { self }
    }

    /// The order of numbers, with a place for NaN.
    #[must_use]
    pub fn total_cmp(&self, other: &Dd) -> Ordering {
        self.hi.total_cmp(&other.hi).then(self.lo.total_cmp(&other.lo))
    }

    /// The square root, 0 for negative numbers (one Newton step from the root of `hi`).
    #[must_use]
    pub fn sqrt_or_zero(self) -> Dd {
        if self.hi <= 0.0 {
            return Dd::ZERO;
        }
        let root = self.hi.sqrt();
        let residual = self - two_product(root, root);
        quick_two_sum(root, residual.hi / (2.0 * root))
    }

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
    let x = Dd::RADIANS_PER_DEGREE * Dd::from(degrees);
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

impl From<f64> for Dd {
    fn from(value: f64) -> Dd {
        Dd { hi: value, lo: 0.0 }
    }
}

impl Neg for Dd {
    type Output = Dd;
    fn neg(self) -> Dd {
        Dd { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Dd {
    type Output = Dd;
    fn add(self, other: Dd) -> Dd {
        let (high, low) = (two_sum(self.hi, other.hi), two_sum(self.lo, other.lo));
        let sum = quick_two_sum(high.hi, high.lo + low.hi);
        quick_two_sum(sum.hi, low.lo + sum.lo)
    }
}

impl Sub for Dd {
    type Output = Dd;
    fn sub(self, other: Dd) -> Dd {
        self + -other
    }
}

impl Mul for Dd {
    type Output = Dd;
    fn mul(self, other: Dd) -> Dd {
        let product = two_product(self.hi, other.hi);
        let cross = self.lo.mul_add(other.hi, self.hi * other.lo);
        quick_two_sum(product.hi, product.lo + cross)
    }
}

impl Div for Dd {
    type Output = Dd;
    fn div(self, other: Dd) -> Dd {
        let quotient = self.hi / other.hi;
        let rest = self - other * Dd::from(quotient);
        quick_two_sum(quotient, rest.hi / other.hi)
    }
}

impl PartialOrd for Dd {
    fn partial_cmp(&self, other: &Dd) -> Option<Ordering> {
        match self.hi.partial_cmp(&other.hi) {
            Some(Ordering::Equal) => self.lo.partial_cmp(&other.lo),
            order => order,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Dd, b: Dd) -> bool {
        (a - b).abs().to_f64() <= 8.0 * DD_ERROR * b.abs().to_f64().max(f64::MIN_POSITIVE)
    }

    #[test]
    fn operations_invert_each_other() {
        for k in 1..2000 {
            let a = Dd::from(f64::from(k) * 0.37) / Dd::from(7.0);
            let b = Dd::from(f64::from(2001 - k) * 1.3e5) / Dd::from(3.0);
            assert!(close(a * b / b, a), "{k}");
            assert!(close(a.sqrt_or_zero() * a.sqrt_or_zero(), a), "{k}");
            assert!(((a + b) - b - a).abs().to_f64() <= 8.0 * DD_ERROR * b.to_f64(), "{k}");
        }
    }

    #[test]
    fn trigonometry_is_exact_where_it_can_be_and_precise_elsewhere() {
        let exact = [
            (0.0, 0.0, 1.0),
            (90.0, 1.0, 0.0),
            (180.0, 0.0, -1.0),
            (270.0, -1.0, 0.0),
            (-90.0, -1.0, 0.0),
        ];
        for (angle, sin, cos) in exact {
            assert_eq!(Dd::sin_cos_degrees(angle), (Dd::from(sin), Dd::from(cos)), "{angle}");
        }
        assert_eq!(Dd::sin_cos_degrees(30.0).0, Dd::from(0.5));
        assert_eq!(Dd::sin_cos_degrees(-60.0).1, Dd::from(0.5));
        let (sin, cos) = Dd::sin_cos_degrees(45.0);
        assert!(close(sin * sin, Dd::from(0.5)) && close(sin, cos));
        for k in -1000..1000 {
            let (sin, cos) = Dd::sin_cos_degrees(f64::from(k) * 0.7318);
            assert!(close(sin * sin + cos * cos, Dd::ONE), "{k}");
            assert!(
                ((sin.to_f64()) - (f64::from(k) * 0.7318).to_radians().sin()).abs() < 1e-14,
                "{k}"
            );
        }
    }
}
