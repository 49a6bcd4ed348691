//! Double-double numbers as the numbers of the tracer.
//!
//! What `f64` gets from fused multiply-add, a result that is right however much of it cancels, is got
//! here in two steps: a plain result, which is good where little has cancelled, and else a sum of the
//! partial products by their sizes. That is right to 2^-150 of the terms, far below what numbers of 106
//! bits tell of them.

use std::cmp::Ordering;

use crate::numeric::dd::elementary;
use crate::numeric::dd::{DD_ERROR, Dd, quick_two_sum, two_product, two_sum};
use crate::numeric::real::Real;

impl Real for Dd {
    /// That of the worst of the operations; with placements, whose entries err by a few times as
    /// much, this is what bounds by [roundings](crate::ray::TIE_ROUNDINGS) count in.
    const UNIT_ROUNDOFF: f64 = DD_ERROR;
    const ZERO: Dd = Dd::ZERO;
    const ONE: Dd = Dd::ONE;
    const HOLDS_DOUBLE_PRODUCTS: bool = true;

    #[inline]
    fn from_f64(value: f64) -> Dd {
        Dd::from(value)
    }

    #[inline]
    fn from_dd(value: Dd) -> Dd {
        value
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self.hi
    }

    #[inline]
    fn abs(self) -> Dd {
        Dd::abs(self)
    }

    #[inline]
    fn sqrt_or_zero(self) -> Dd {
        Dd::sqrt_or_zero(self)
    }

    #[inline]
    fn mul_add(self, factor: Dd, term: Dd) -> Dd {
        // The product errs by 5 units of 2^-106, and is at most 5 times the sum where a quarter of
        // the term is left.
        let sum = self * factor + term;
        if sum.hi.abs() >= LEFT * term.hi.abs() {
            return sum;
        }
        cancelled(&[(self, factor)], term)
    }

    #[inline]
    fn difference_of_products(a: Dd, b: Dd, c: Dd, d: Dd) -> Dd {
        let (ab, cd) = (a * b, c * d);
        let difference = ab - cd;
        // Two products that err by 5 units each and are at most 4 times the difference.
        if difference.hi.abs() >= LEFT * ab.hi.abs().max(cd.hi.abs()) {
            return difference;
        }
        cancelled(&[(a, b), (-c, d)], Dd::ZERO)
    }

    #[inline]
    fn signed_squares([s1, s2, s3]: [f64; 3], [x, y, z]: [Dd; 3], k: f64) -> Dd {
        let (xx, yy, zz) = (Dd::from(s1) * x * x, Dd::from(s2) * y * y, Dd::from(s3) * z * z);
        let sum = xx + yy + zz - Dd::from(k);
        // Products that err by 5 units, and three sums by 3: 14 units of the squares' sum at most,
        // and of k no more than that where the result is not k itself.
        if sum.hi.abs() >= LEFT * (xx.hi.abs() + yy.hi.abs() + zz.hi.abs()) {
            return sum;
        }
        cancelled(
            &[(Dd::from(s1) * x, x), (Dd::from(s2) * y, y), (Dd::from(s3) * z, z)],
            Dd::from(-k),
        )
    }

    /// With a relative error of `2 |exponent ln base|` + 8 times that of an operation.
    fn power(base: Dd, exponent: f64) -> Dd {
        elementary::power(base, exponent)
    }

    fn turns(x: Dd, z: Dd) -> Dd {
        elementary::turns(x, z)
    }

    #[inline]
    fn total_cmp(&self, other: &Dd) -> Ordering {
        Dd::total_cmp(self, other)
    }

    #[inline]
    fn is_nan(self) -> bool {
        self.hi.is_nan()
    }
}

/// How much of its terms a sum must be to be right as it is.
const LEFT: f64 = 0.25;

/// The sum of at most three products and a term, of which much cancels: with an error of 2^-150 of the
/// largest, and a relative one below 2^-104 if 2^-44 of it is left.
#[inline(never)]
fn cancelled(products: &[(Dd, Dd)], term: Dd) -> Dd {
    // Parts of the size of the terms add up without error but for what goes to those below; these, of
    // 2^-53 of the size, with 2^-105 of their own; the last, of 2^-106, as doubles.
    let (mut top, mut middle, mut bottom) = (term.hi, Dd::from(term.lo), 0.0);
    for (a, b) in products {
        let high = two_product(a.hi, b.hi);
        let (left, right) = (two_product(a.hi, b.lo), two_product(a.lo, b.hi));
        let sum = two_sum(top, high.hi);
        top = sum.hi;
        middle = middle.plus(sum.lo).plus(high.lo).plus(left.hi).plus(right.hi);
        bottom += left.lo + right.lo + a.lo * b.lo;
    }
    Dd::from(top) + middle.plus(bottom)
}

impl Dd {
    /// The sum with a double, with an error of 2^-105.
    #[inline]
    fn plus(self, double: f64) -> Dd {
        let sum = two_sum(self.hi, double);
        quick_two_sum(sum.hi, self.lo + sum.lo)
    }
}
