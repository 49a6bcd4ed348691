//! Double-double numbers: unevaluated sums of two doubles, with about 106 bits.
//!
//! Sources: T. J. Dekker, "A floating-point technique for extending the available precision"
//! (1971); Joldes, Muller and Popescu, "Tight and rigorous error bounds for basic building blocks
//! of double-word arithmetic" (2017), whose algorithms 6 (sum), 12 (product) and 17 (quotient)
//! these are: relative errors of at most 3, 5 and 10 times 2^-106.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

mod elementary;
mod real;

/// The sum `hi + lo`, with `|lo|` at most half a unit in the last place of `hi`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dd {
    pub(crate) hi: f64,
    pub(crate) lo: f64,
}

/// Bound of the relative error of one operation on [`Dd`]: 64 times 2^-106. The four operations err
/// by at most 10 of these, the square root by 4 (Lefèvre, Louvet, Muller, Picot and Rideau,
/// "Accurate calculation of Euclidean norms using double-word arithmetic", 2023), and the functions of
/// degrees, whose series add up some twenty terms that fall off quickly, by less than 64.
pub const DD_ERROR: f64 = 1.0 / (1u64 << 50) as f64 / (1u64 << 50) as f64;

/// `a + b` as a sum of its rounding and the exact error.
#[inline]
pub(crate) fn two_sum(a: f64, b: f64) -> Dd {
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
pub(crate) fn two_product(a: f64, b: f64) -> Dd {
    let hi = a * b;
    Dd { hi, lo: a.mul_add(b, -hi) }
}

impl Dd {
    /// 0.
    pub const ZERO: Dd = Dd { hi: 0.0, lo: 0.0 };
    /// 1.
    pub const ONE: Dd = Dd { hi: 1.0, lo: 0.0 };
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

    /// The square root, 0 for what is not above 0 (one Newton step from the root of `hi`).
    #[must_use]
    pub fn sqrt_or_zero(self) -> Dd {
        let root = self.hi.sqrt();
        let is_positive = self.hi > 0.0;
        if !is_positive || root.is_infinite() {
            return Dd::from(if is_positive { root } else { 0.0 });
        }
        let residual = root.mul_add(-root, self.hi) + self.lo;
        quick_two_sum(root, residual / (2.0 * root))
    }

    /// The number times a power of two.
    fn times_power_of_two(self, exponent: i32) -> Dd {
        Dd { hi: libm::scalbn(self.hi, exponent), lo: libm::scalbn(self.lo, exponent) }
    }

    /// The number itself where it is one; infinite and NaN as `f64` says, without a low part.
    #[inline]
    fn or_unbounded(self, rounded: f64) -> Dd {
        if self.hi.is_finite() { self } else { Dd::from(rounded) }
    }
}

impl From<f64> for Dd {
    fn from(value: f64) -> Dd {
        Dd { hi: value, lo: 0.0 }
    }
}

impl Neg for Dd {
    type Output = Dd;
    #[inline]
    fn neg(self) -> Dd {
        Dd { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Dd {
    type Output = Dd;
    #[inline]
    fn add(self, other: Dd) -> Dd {
        let (high, low) = (two_sum(self.hi, other.hi), two_sum(self.lo, other.lo));
        let sum = quick_two_sum(high.hi, high.lo + low.hi);
        quick_two_sum(sum.hi, low.lo + sum.lo).or_unbounded(self.hi + other.hi)
    }
}

impl Sub for Dd {
    type Output = Dd;
    #[inline]
    fn sub(self, other: Dd) -> Dd {
        self + -other
    }
}

impl Mul for Dd {
    type Output = Dd;
    #[inline]
    fn mul(self, other: Dd) -> Dd {
        let product = two_product(self.hi, other.hi);
        let cross = self.lo.mul_add(other.hi, self.hi * other.lo);
        quick_two_sum(product.hi, product.lo + cross).or_unbounded(self.hi * other.hi)
    }
}

impl Div for Dd {
    type Output = Dd;
    #[inline]
    fn div(self, other: Dd) -> Dd {
        let quotient = self.hi / other.hi;
        let rest = self - other * Dd::from(quotient);
        quick_two_sum(quotient, rest.hi / other.hi).or_unbounded(quotient)
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
mod tests;
