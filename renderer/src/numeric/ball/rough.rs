//! Doubles whose every operation counts as rounded, for balls that take little time.
//!
//! What an operation rounds off is bounded by half a unit in the last place of its result, rather than
//! found. Results of 0 stay exact, if what they follow from is, and so do roots, whose residual is their
//! bound, and whole eighths of a turn. Where a decision needs to know that another result is exact as well,
//! balls of plain doubles tell.
//!
//! What falls below the range of doubles takes no case of its own, as no bound but that of 0 is lost to
//! it: a ball is 0 exactly, or exact and at least 2^-400, or has a radius of at least 2^-505. So a
//! product of two that are not 0 has a bound of at least 2^-1012, to which the [floor](Bounding::floor)
//! adds 2^-500. A sum needs none: of exact terms, which are multiples of 2^-452, it is 0 or at least
//! that, and half a unit in its last place is 2^-505.
//!
//! A product and a term that are added with one rounding may cancel, and no room is needed for that: of
//! exact numbers the sum is a multiple of 2^-904, so that it is rounded by at most half a unit in its
//! last place, and 0 only if it is exactly 0. If one of them is not exact, its radius is in the bound, and
//! with the floor that is more than what is rounded off below the range of doubles.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::numeric::ball::rounded::{Bounding, Rounded};
use crate::numeric::ball::{Ball, radius_of_product};
use crate::numeric::dd::Dd;
use crate::numeric::real::Real;

/// Such a double.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Rough(f64);

/// The [`Bounding::floor`]: 2^-500.
const FLOOR: f64 = f64::from_bits((1023 - 500) << 52);

/// What numbers have at least that are taken to be exact: 2^-400.
const LEAST_EXACT: f64 = f64::from_bits((1023 - 400) << 52);

/// A bound of what rounding a result of this size has changed.
#[inline(always)]
fn unit(size: f64) -> f64 {
    size * f64::UNIT_ROUNDOFF
}

impl Bounding for Rough {
    const HAS_FLOOR: bool = true;

    #[inline(always)]
    fn floor(bound: f64) -> f64 {
        if bound > 0.0 { FLOOR } else { 0.0 }
    }

    #[inline(always)]
    fn least_radius(self) -> f64 {
        if self.0.abs() < LEAST_EXACT && self.0 != 0.0 { FLOOR } else { 0.0 }
    }

    #[inline(always)]
    fn inner_product(
        a: [Ball<Self>; 3],
        b: [Ball<Self>; 3],
        term: Option<Ball<Self>>,
    ) -> Ball<Self> {
        let of = |index: usize| radius_of_product(a[index], b[index]);
        let ([ax, ay, az], [bx, by, bz]) = (a.map(|x| x.middle.0), b.map(|x| x.middle.0));
        let (last, of_last) = match term {
            None => (az * bz, 0.0),
            Some(Ball { middle: Rough(term), radius }) => (az.mul_add(bz, term), radius),
        };
        let second = ay.mul_add(by, last);
        let sum = ax.mul_add(bx, second);
        let rounded = unit(last.abs() + second.abs() + sum.abs());
        Ball::new((Rough(sum), rounded), of(0) + of(1) + (of(2) + of_last))
    }

    #[inline(always)]
    fn sum(Rough(a): Self, Rough(b): Self) -> Rounded<Self> {
        let sum = a + b;
        (Rough(sum), unit(sum.abs()))
    }

    #[inline(always)]
    fn product(Rough(a): Self, Rough(b): Self) -> Rounded<Self> {
        let product = a * b;
        (Rough(product), unit(product.abs()))
    }

    #[inline(always)]
    fn quotient(Rough(a): Self, Rough(b): Self) -> Rounded<Self> {
        (Rough(a / b), unit(a.abs()))
    }

    #[inline(always)]
    fn root(Rough(a): Self) -> Rounded<Self> {
        let root = a.sqrt();
        (Rough(root), (-root).mul_add(root, a).abs())
    }

    #[inline(always)]
    fn product_sum(Rough(a): Self, Rough(b): Self, Rough(c): Self) -> Rounded<Self> {
        let sum = a.mul_add(b, c);
        (Rough(sum), unit(sum.abs()))
    }

    #[inline(always)]
    fn product_difference(a: Self, b: Self, c: Self, d: Self) -> Rounded<Self> {
        let [a, b, c, d] = [a, b, c, d].map(Rough::to_f64);
        let difference = f64::difference_of_products(a, b, c, d);
        // Kahan's relative error is two of these, so that exact products which cancel are exactly 0.
        (Rough(difference), 2.0 * unit(difference.abs()))
    }

    #[inline(always)]
    fn squares([s1, s2, s3]: [f64; 3], p: [Self; 3], k: f64) -> Rounded<Self> {
        let [x, y, z] = p.map(Rough::to_f64);
        let first = (s3 * z).mul_add(z, -k);
        let second = (s2 * y).mul_add(y, first);
        let sum = (s1 * x).mul_add(x, second);
        (Rough(sum), unit(first.abs() + second.abs() + sum.abs()))
    }

    fn power_of(Rough(base): Self, exponent: f64) -> Rounded<Self> {
        let (power, error) = f64::power_of(base, exponent);
        let of_zero = if base == 0.0 { 0.0 } else { FLOOR };
        (Rough(power), error + of_zero)
    }

    fn turns_of(Rough(x): Self, Rough(z): Self) -> Rounded<Self> {
        let (turns, error) = f64::turns_of(x, z);
        (Rough(turns), error)
    }

    fn nearest_doubles(Rough(middle): Self, radius: f64) -> [f64; 2] {
        f64::nearest_doubles(middle, radius)
    }
}

impl Real for Rough {
    const UNIT_ROUNDOFF: f64 = f64::UNIT_ROUNDOFF;
    const ZERO: Self = Rough(0.0);
    const ONE: Self = Rough(1.0);
    const HOLDS_DOUBLE_PRODUCTS: bool = false;

    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Rough(value)
    }

    #[inline(always)]
    fn from_dd(value: Dd) -> Self {
        Rough(value.to_f64())
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.0
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Rough(self.0.abs())
    }

    #[inline(always)]
    fn sqrt_or_zero(self) -> Self {
        Rough(self.0.sqrt_or_zero())
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Rough(self.0.mul_add(factor.0, term.0))
    }

    #[inline(always)]
    fn difference_of_products(a: Self, b: Self, c: Self, d: Self) -> Self {
        Rough(f64::difference_of_products(a.0, b.0, c.0, d.0))
    }

    #[inline(always)]
    fn signed_squares(signs: [f64; 3], p: [Self; 3], k: f64) -> Self {
        Rough(f64::signed_squares(signs, p.map(Rough::to_f64), k))
    }

    fn power(base: Self, exponent: f64) -> Self {
        Rough(f64::power(base.0, exponent))
    }

    fn turns(x: Self, z: Self) -> Self {
        Rough(f64::turns(x.0, z.0))
    }

    #[inline(always)]
    fn total_cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }

    #[inline(always)]
    fn is_nan(self) -> bool {
        self.0.is_nan()
    }
}

impl Add for Rough {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Rough(self.0 + other.0)
    }
}

impl Sub for Rough {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Rough(self.0 - other.0)
    }
}

impl Mul for Rough {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Rough(self.0 * other.0)
    }
}

impl Div for Rough {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Rough(self.0 / other.0)
    }
}

impl Neg for Rough {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Rough(-self.0)
    }
}
