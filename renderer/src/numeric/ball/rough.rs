//! Doubles whose every operation counts as rounded, for balls that take little time.
//!
//! What an operation rounds off is bounded by half a unit in the last place of its result, or of the terms
//! that it adds up, rather than found: a product `a b` of balls with the radii r and s has the radius
//! `|a| (s + u |b|) + r (|b| + s)`, where u is 2^-53. What of this is of one factor serves all products
//! with it. Results of 0 stay exact where all terms are 0 exactly, or are two exact numbers that are added,
//! and so do roots, whose residual is their bound, and whole eighths of a turn. Where a decision needs to
//! know that another result is exact as well, balls of plain doubles tell.
//!
//! What falls below the range of doubles takes no case of its own, as no bound but that of 0 is lost to
//! it: a ball is 0 exactly, or exact and at least 2^-400, or has a radius of at least 2^-505. So a
//! product of two that are not 0 has a bound of at least 2^-1012, for which the [floor](Bounding::FLOOR)
//! puts 2^-500. A sum needs none: of exact terms, which are multiples of 2^-452, it is 0 or at least
//! that, and half a unit in its last place is 2^-505.
//!
//! A product and a term that are added with one rounding may cancel, and no room is needed for that: of
//! exact numbers the sum is a multiple of 2^-904, so that it is rounded by at most half a unit in its
//! last place. If one of them is not exact, its radius is in the bound, and with the floor that is more
//! than what is rounded off below the range of doubles.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::numeric::ball::rounded::{Bounding, InBalls, Rounded};
use crate::numeric::ball::{Ball, ROOM, size, up};
use crate::numeric::dd::Dd;
use crate::numeric::real::Real;

/// Such a double.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Rough(f64);

/// The [`Bounding::FLOOR`]: 2^-500.
const FLOOR: f64 = f64::from_bits((1023 - 500) << 52);

/// What numbers have at least that are taken to be exact: 2^-400.
const LEAST_EXACT: f64 = f64::from_bits((1023 - 400) << 52);

/// A bound of what rounding a result of this size has changed.
#[inline(always)]
fn unit(size: f64) -> f64 {
    size * f64::UNIT_ROUNDOFF
}

/// A factor as it enters the bound of a product.
#[derive(Clone, Copy)]
struct Factor {
    /// The most that it can be, by which the radius of the other is multiplied.
    largest: f64,
    /// How far off it is, and what is rounded off, for each part of the other.
    error: f64,
}

impl Factor {
    /// In a product that is rounded so many times.
    #[inline(always)]
    fn new(x: Ball<Rough>, n_roundings: f64) -> Self {
        let error = x.middle.0.abs().mul_add(n_roundings * f64::UNIT_ROUNDOFF, x.radius);
        Factor { largest: x.largest_factor(), error }
    }

    /// The bound of the product with another, and a bound.
    #[inline(always)]
    fn times_and(self, other: Ball<Rough>, bound: f64) -> f64 {
        other.middle.0.abs().mul_add(self.error, other.radius.mul_add(self.largest, bound))
    }

    /// The bound of the product with another.
    #[inline(always)]
    fn times(self, other: Ball<Rough>) -> f64 {
        other.middle.0.abs().mul_add(self.error, other.radius * self.largest)
    }
}

/// The ball of a result whose error has this bound.
#[inline(always)]
fn ball(middle: f64, radius: f64) -> Ball<Rough> {
    Ball { middle: Rough(middle), radius }.floored()
}

impl Bounding for Rough {
    const FLOOR: f64 = FLOOR;

    #[inline(always)]
    fn least_radius(self) -> f64 {
        if self.0.abs() < LEAST_EXACT && self.0 != 0.0 { FLOOR } else { 0.0 }
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
        // With room for the roundings of the ends.
        let room =
            if radius == 0.0 { 0.0 } else { radius + f64::EPSILON * (middle.abs() + radius) };
        [middle - room, middle + room]
    }
}

impl InBalls for Rough {
    #[inline(always)]
    fn sum(a: Ball<Self>, b: Ball<Self>) -> Ball<Self> {
        let sum = a.middle.0 + b.middle.0;
        let radius = sum.abs().mul_add(f64::UNIT_ROUNDOFF, a.radius + b.radius);
        Ball { middle: Rough(sum), radius }
    }

    #[inline(always)]
    fn product(a: Ball<Self>, b: Ball<Self>) -> Ball<Self> {
        ball(a.middle.0 * b.middle.0, Factor::new(b, 1.0).times(a))
    }

    #[inline(always)]
    fn product_sum(a: Ball<Self>, b: Ball<Self>, c: Ball<Self>) -> Ball<Self> {
        let of_term = c.middle.0.abs().mul_add(f64::UNIT_ROUNDOFF, c.radius);
        let sum = a.middle.0.mul_add(b.middle.0, c.middle.0);
        ball(sum, Factor::new(b, 1.0).times_and(a, of_term))
    }

    #[inline(always)]
    fn product_difference([a, b]: [Ball<Self>; 2], [c, d]: [Ball<Self>; 2]) -> Ball<Self> {
        let difference = a.middle.0.mul_add(b.middle.0, -(c.middle.0 * d.middle.0));
        // The second product is rounded, and then the difference. The first counts as rounded twice as well,
        // so that a factor is the same in either place, where a cross product has it.
        let of_first = Factor::new(b, 2.0).times(a);
        ball(difference, Factor::new(d, 2.0).times_and(c, of_first))
    }

    #[inline(always)]
    fn inner_product(
        a: [Ball<Self>; 3],
        b: [Ball<Self>; 3],
        term: Option<Ball<Self>>,
    ) -> Ball<Self> {
        let ([ax, ay, az], [bx, by, bz]) = (a.map(|x| x.middle.0), b.map(|x| x.middle.0));
        // Rounded three times: the last product, or its sum with the term, and two sums that hold it.
        let factors = b.map(|x| Factor::new(x, 3.0));
        let (last, of_last) = match term {
            None => (az * bz, factors[2].times(a[2])),
            Some(Ball { middle: Rough(term), radius }) => {
                let of_term = term.abs().mul_add(3.0 * f64::UNIT_ROUNDOFF, radius);
                (az.mul_add(bz, term), factors[2].times_and(a[2], of_term))
            }
        };
        let sum = ax.mul_add(bx, ay.mul_add(by, last));
        ball(sum, factors[0].times_and(a[0], factors[1].times_and(a[1], of_last)))
    }

    #[inline(always)]
    fn unit_of(v: [Ball<Self>; 3]) -> [Ball<Self>; 3] {
        let [x, y, z] = v.map(|x| x.middle.0);
        let inverse = 1.0 / x.mul_add(x, y.mul_add(y, z * z)).sqrt();
        // What a change of each by its radius makes of the sum of the squares, and of 1 over its root.
        let of_square = |x: Ball<Self>| x.radius * x.radius.mul_add(ROOM, 2.0 * size(x.middle));
        let of_squares = of_square(v[0]) + of_square(v[1]) + of_square(v[2]);
        let relative = of_squares * inverse * inverse;
        // NaN is none of these, nor is what may be 0.
        let is_small = up(relative) <= 0.25;
        // 1/√(1 - e) is at most 1 + e/2 (1 + e) for e <= 1/4. Three roundings of the sum are one and a half
        // of its root; that is rounded, and so are the quotient and the product.
        const ROUNDINGS: f64 = 5.0 * f64::UNIT_ROUNDOFF;
        let growth = (0.5 * relative).mul_add(relative.mul_add(ROOM, 1.0), ROUNDINGS);
        let growth = if is_small { growth } else { f64::INFINITY };
        let largest = inverse * growth.mul_add(ROOM, 1.0);
        v.map(|x| {
            let unit = x.middle.0 * inverse;
            ball(unit, unit.abs().mul_add(growth, x.radius * largest))
        })
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
