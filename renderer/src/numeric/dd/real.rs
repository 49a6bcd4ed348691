//! Double-double numbers as the numbers of the tracer.
//!
//! What `f64` gets from fused multiply-add, a result that is right however much of it cancels, is got
//! here in steps: a plain result, which is good where little has cancelled; a sum of the partial
//! products by their sizes, which is good to 2^-150 of the terms; and else the exact sum, rounded once.

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

/// The sum of at most three products and a term, of which much cancels.
#[inline(never)]
fn cancelled(products: &[(Dd, Dd)], term: Dd) -> Dd {
    // Parts of the size of the terms add up without error but for what goes to those below; these, of
    // 2^-53 of the size, with 2^-105 of their own; the last, of 2^-106, as doubles.
    let (mut top, mut middle, mut bottom) = (term.hi, Dd::from(term.lo), 0.0);
    let mut size = term.hi.abs();
    for (a, b) in products {
        let high = two_product(a.hi, b.hi);
        let (left, right) = (two_product(a.hi, b.lo), two_product(a.lo, b.hi));
        let sum = two_sum(top, high.hi);
        top = sum.hi;
        middle = middle.plus(sum.lo).plus(high.lo).plus(left.hi).plus(right.hi);
        bottom += left.lo + right.lo + a.lo * b.lo;
        size = size.max(high.hi.abs());
    }
    let sum = Dd::from(top) + middle.plus(bottom);
    const ENOUGH: f64 = 1.0 / (1u64 << 44) as f64;
    if sum.hi.abs() >= ENOUGH * size { sum } else { exact(products, term) }
}

impl Dd {
    /// The sum with a double, with an error of 2^-105.
    #[inline]
    fn plus(self, double: f64) -> Dd {
        let sum = two_sum(self.hi, double);
        quick_two_sum(sum.hi, self.lo + sum.lo)
    }
}

/// Parts of numbers at most: two for each number, eight for each of three products.
const MAX_PARTS: usize = 26;

/// An exact sum of doubles: an expansion whose parts do not overlap, in order of their size
/// (Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
/// 1997).
struct Expansion {
    parts: [f64; MAX_PARTS],
    n_parts: usize,
}

/// The same sum, exact but for one rounding.
#[cold]
#[inline(never)]
fn exact(products: &[(Dd, Dd)], term: Dd) -> Dd {
    let mut sum = Expansion { parts: [0.0; MAX_PARTS], n_parts: 0 };
    for &(a, b) in products {
        for (x, y) in [(a.lo, b.lo), (a.lo, b.hi), (a.hi, b.lo), (a.hi, b.hi)] {
            sum.add(two_product(x, y));
        }
    }
    sum.add(term);
    // From the small ones up: each partial sum is as large as its last part, or nearly.
    sum.parts[..sum.n_parts].iter().fold(Dd::ZERO, |sum, part| sum + Dd::from(*part))
}

impl Expansion {
    fn add_double(&mut self, mut double: f64) {
        let mut n_left = 0;
        for index in 0..self.n_parts {
            let Dd { hi, lo } = two_sum(double, self.parts[index]);
            if lo != 0.0 {
                self.parts[n_left] = lo;
                n_left += 1;
            }
            double = hi;
        }
        if double != 0.0 {
            self.parts[n_left] = double;
            n_left += 1;
        }
        self.n_parts = n_left;
    }

    fn add(&mut self, Dd { hi, lo }: Dd) {
        self.add_double(lo);
        self.add_double(hi);
    }
}
