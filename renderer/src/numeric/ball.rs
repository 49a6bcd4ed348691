//! Balls: numbers with rigorous bounds of their error, for knowing which pixels are certain.
//!
//! An operation on balls gives a ball that holds the result of the operation on real numbers,
//! whichever real numbers the operands stand for. Its radius sums up what the radii of the operands
//! become and what the operation itself rounds off; no rounding mode is ever changed. A result that
//! was not rounded adds nothing ("residual" bounds), so that exact numbers stay exact. Finding that out
//! takes time, so that there are balls of [rough](rough::Rough) doubles too, which do so for little more
//! than zeros.
//!
//! A comparison of balls that overlap cannot be decided. It then answers as the middles say, and
//! leaves a mark, which [`Real::take_doubt`] asks for and takes away: what followed from the answer is
//! not certain. The mark is the thread's own, since a comparison has nowhere else to put it.

use std::cell::Cell;
use std::cmp::Ordering;
use std::hint::cold_path;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::numeric::ball::rounded::{InBalls, LEAST, is_exact_product};
use crate::numeric::dd::{DD_ERROR, Dd};
use crate::numeric::real::Real;

pub mod rough;
pub mod rounded;
#[cfg(test)]
mod tests;

/// The real numbers that differ from `middle` by at most `radius`, with [`ROOM`]; infinite and NaN radii
/// bound nothing.
#[derive(Clone, Copy, Debug)]
pub struct Ball<T> {
    middle: T,
    radius: f64,
}

thread_local! {
    static DOUBT: Cell<bool> = const { Cell::new(false) };
}

/// Leaves the mark that something could not be decided.
#[cold]
#[inline(never)]
fn doubt() {
    DOUBT.set(true);
}

/// Room for the roundings of radii. Each operation makes one of others with fewer than 32 roundings of
/// 2^-53, by which it may fall short, and the more so the more operations have led to it: by a sixteenth
/// after 2^44 of them one after another, which take hours for a single pixel. That is made up for once,
/// where something hangs on a radius: where balls are compared, where bounds are handed out, and in
/// operations that do more with a radius than multiply it by what is known and add it up.
const ROOM: f64 = 1.0 + 1.0 / 16.0;

/// A bound from a radius, or from a sum of some.
#[inline(always)]
fn up(radius: f64) -> f64 {
    radius * ROOM
}

/// The same from a number that its own roundings may have made smaller, and nothing else: fewer than 16.
#[inline(always)]
fn rounded_up(bound: f64) -> f64 {
    bound * (1.0 + 8.0 * f64::EPSILON)
}

#[inline(always)]
fn size<T: Real>(x: T) -> f64 {
    x.to_f64().abs()
}

impl<T: InBalls> Ball<T> {
    /// Whether 0 is one of the numbers.
    pub(crate) fn holds_zero(self) -> bool {
        let is_outside = size(self.middle) > up(self.radius);
        !is_outside
    }

    #[inline(always)]
    fn new((middle, error): (T, f64), radius: f64) -> Self {
        Ball { middle, radius: radius + error }.floored()
    }

    /// With room for what has fallen below the range of doubles in the radius and in the middle, unless
    /// the radius is 0.
    #[inline(always)]
    fn floored(self) -> Self {
        // NaN is not below it.
        if T::FLOOR > 0.0 && self.radius < T::FLOOR {
            cold_path();
            return Ball { radius: if self.radius > 0.0 { T::FLOOR } else { 0.0 }, ..self };
        }
        self
    }

    /// What another radius is multiplied by in a product, at most.
    #[inline(always)]
    fn largest_factor(self) -> f64 {
        self.radius.mul_add(ROOM, size(self.middle))
    }

    /// What bounds `x` from above, for a number of either sign.
    #[inline(always)]
    fn largest(self) -> f64 {
        rounded_up(size(self.middle) + up(self.radius))
    }

    /// Whether all of it is on one side of 0, or it is 0.
    #[inline(always)]
    fn is_sign_certain(self) -> bool {
        let middle = self.middle.to_f64();
        middle.abs() > up(self.radius) || self.radius == 0.0 && !middle.is_nan()
    }

    /// A ball as it was computed, if nothing in it can have fallen below the range of doubles, or what
    /// is a bound nevertheless.
    #[inline(always)]
    fn unless_tiny(self, is_exact: impl FnOnce() -> bool) -> Self {
        // NaN is not tiny.
        if T::FLOOR == 0.0 && self.radius < LEAST && !(self.radius == 0.0 && is_exact()) {
            return Ball { radius: LEAST, ..self };
        }
        self
    }

    /// How two balls compare: by `by_middles` where they overlap, which cannot be decided.
    #[inline(always)]
    fn decide(self, other: Self, by_middles: impl Fn(&T, &T) -> bool) -> bool {
        let gap = (self.middle - other.middle).to_f64().abs();
        // Beside the room for radii the rounding of the gap is nothing.
        let is_certain = gap > up(self.radius + other.radius) && gap < f64::INFINITY;
        if !is_certain && !self.is_certain_beside(other) {
            doubt();
        }
        by_middles(&self.middle, &other.middle)
    }

    /// Whether two balls without a gap compare as their middles do: if both are exact or infinite.
    #[cold]
    fn is_certain_beside(self, other: Self) -> bool {
        let is_unbounded = |x: Self| x.radius == 0.0 && x.middle.to_f64().is_infinite();
        self.radius == 0.0 && other.radius == 0.0
            || is_unbounded(self) && other.radius.is_finite()
            || is_unbounded(other) && self.radius.is_finite()
    }
}

impl<T: InBalls> Add for Ball<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        T::sum(self, other)
    }
}

impl<T: InBalls> Sub for Ball<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<T: InBalls> Neg for Ball<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Ball { middle: -self.middle, ..self }
    }
}

impl<T: InBalls> Mul for Ball<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        T::product(self, other)
    }
}

impl<T: InBalls> Div for Ball<T> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let (quotient, rest) = T::quotient(self.middle, other.middle);
        // a'/b' - q = (a' - q b') / b' with a' - q b' = (a - q b) + (a' - a) - q (b' - b).
        let numerator = size(quotient).mul_add(other.radius, rest + self.radius);
        let denominator = other.radius.mul_add(-ROOM, size(other.middle));
        if T::FLOOR > 0.0 {
            let radius = if denominator > 0.0 { numerator / denominator } else { f64::INFINITY };
            // The numerator is 0 for an exact 0 alone, however much it is divided by.
            let is_tiny = radius < T::FLOOR && numerator > 0.0;
            return Ball { middle: quotient, radius: if is_tiny { T::FLOOR } else { radius } };
        }
        let holds_zero = denominator <= 0.0 || denominator.is_nan();
        if holds_zero {
            return Ball { middle: quotient, radius: f64::INFINITY };
        }
        let is_tiny = numerator < LEAST;
        if !is_tiny {
            return Ball { middle: quotient, radius: numerator / denominator }
                .unless_tiny(|| false);
        }
        let is_exact = numerator == 0.0
            && (self.middle == T::ZERO || size(self.middle) >= LEAST && size(quotient) >= LEAST);
        if is_exact {
            return Ball { middle: quotient, radius: 0.0 };
        }
        Ball { middle: quotient, radius: LEAST / denominator + LEAST }
    }
}

impl<T: InBalls> PartialEq for Ball<T> {
    fn eq(&self, other: &Self) -> bool {
        self.decide(*other, |a, b| a == b)
    }
}

impl<T: InBalls> PartialOrd for Ball<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.decide(*other, |_, _| true);
        self.middle.partial_cmp(&other.middle)
    }

    #[inline(always)]
    fn lt(&self, other: &Self) -> bool {
        self.decide(*other, |a, b| a < b)
    }

    #[inline(always)]
    fn le(&self, other: &Self) -> bool {
        self.decide(*other, |a, b| a <= b)
    }

    #[inline(always)]
    fn gt(&self, other: &Self) -> bool {
        self.decide(*other, |a, b| a > b)
    }

    #[inline(always)]
    fn ge(&self, other: &Self) -> bool {
        self.decide(*other, |a, b| a >= b)
    }
}

impl<T: InBalls> Real for Ball<T> {
    /// That of the middles, by which ties are resolved that cannot be decided.
    const UNIT_ROUNDOFF: f64 = T::UNIT_ROUNDOFF;
    const ZERO: Self = Ball { middle: T::ZERO, radius: 0.0 };
    const ONE: Self = Ball { middle: T::ONE, radius: 0.0 };
    const KEEPS_ACCOUNT: bool = true;
    const ASKS_FOR_BOUNDS: bool = !T::HOLDS_DOUBLE_PRODUCTS;
    const COUNTS_ONLY_IF_CERTAIN: bool = !T::HOLDS_DOUBLE_PRODUCTS;
    const HOLDS_DOUBLE_PRODUCTS: bool = T::HOLDS_DOUBLE_PRODUCTS;

    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        let middle = T::from_f64(value);
        Ball { middle, radius: middle.least_radius() }
    }

    #[inline]
    fn from_dd(value: Dd) -> Self {
        // Of few operations.
        Ball::from_bounded(value, 4.0 * DD_ERROR * value.to_f64().abs())
            .unless_tiny(|| value == Dd::ZERO)
    }

    #[inline(always)]
    fn from_bounded(value: Dd, error: f64) -> Self {
        let middle = T::from_dd(value);
        // What a double has no room for.
        let rounding = if T::HOLDS_DOUBLE_PRODUCTS { 0.0 } else { value.lo.abs() };
        Ball::new((middle, rounding), error + middle.least_radius())
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.middle.to_f64()
    }

    /// The size; where the sign is not certain, the number with the sign that makes its middle
    /// positive, which is in the same ball.
    #[inline(always)]
    fn abs(self) -> Self {
        Ball { middle: self.middle.abs(), ..self }
    }

    #[inline(always)]
    fn sqrt_or_zero(self) -> Self {
        let (root, rest) = T::root(self.middle.max(T::ZERO));
        let s = size(root);
        let spread = rest + self.radius;
        let square = s * s;
        let most = up(spread);
        if square > most && square > LEAST {
            // The root of x' differs by |x' - s²| / (√x' + s), where x' is at least s² - spread, so that
            // √x' is at least s (1 - spread / s²). Halves, as twice the largest numbers are infinite.
            let radius = spread / s * (0.5 * square / (square - 0.5 * most));
            return Ball { middle: root, radius }.floored().unless_tiny(|| spread == 0.0);
        }
        if spread == 0.0 && s == 0.0 {
            return Self::ZERO;
        }
        // √x' is between 0 and the root of the largest. NaN stays.
        let most = rounded_up(self.largest().sqrt());
        Ball { middle: root, radius: if most < LEAST { LEAST } else { most } }
    }

    #[inline(always)]
    fn unit(v: [Self; 3]) -> [Self; 3] {
        T::unit_of(v)
    }

    #[inline(always)]
    fn with_sign(self, sign: f64) -> Self {
        let middle = T::from_f64(sign) * self.middle;
        // Any number times 0 is 0, but what is infinite or NaN is none.
        let radius = if sign == 0.0 { size(middle) } else { self.radius };
        Ball { middle, radius }
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        T::product_sum(self, factor, term)
    }

    #[inline(always)]
    fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        T::inner_product(a, b, None)
    }

    #[inline(always)]
    fn dot_and(a: [Self; 3], b: [Self; 3], term: Self) -> Self {
        T::inner_product(a, b, Some(term))
    }

    #[inline(always)]
    fn difference_of_products(a: Self, b: Self, c: Self, d: Self) -> Self {
        T::product_difference([a, b], [c, d])
    }

    #[inline(always)]
    fn signed_squares(signs: [f64; 3], p: [Self; 3], k: f64) -> Self {
        let of_square = |index: usize| {
            let Ball { middle, radius } = p[index];
            if signs[index] == 0.0 {
                0.0
            } else {
                radius * radius.mul_add(ROOM, 2.0 * size(middle))
            }
        };
        let spread = of_square(0) + of_square(1) + of_square(2);
        let middles = p.map(|x| x.middle);
        let is_exact = |x: Self| is_exact_product(x, x);
        Ball::new(T::squares(signs, middles, k), spread).unless_tiny(|| p.into_iter().all(is_exact))
    }

    fn power(base: Self, exponent: f64) -> Self {
        let (power, error) = T::power_of(base.middle, exponent);
        if base.radius == 0.0 {
            let is_exact = base.middle == T::ZERO || base.middle == T::ONE || exponent == 0.0;
            return Ball::new((power, error), 0.0).unless_tiny(|| is_exact);
        }
        if exponent < 0.0 || exponent.is_nan() {
            return Ball { middle: power, radius: f64::INFINITY };
        }
        // b (1 + r) to the power of n is bⁿ (1 + r)ⁿ, with (1 + r)ⁿ - 1 <= exp(n r) - 1, which is at
        // most 2 n r for n r <= 1; for n < 1 it is at most r downward.
        let relative = base.radius / size(base.middle);
        let growth = exponent.max(1.0) * relative;
        if growth <= 0.5 {
            let spread = (size(power) + error) * 2.0 * growth;
            return Ball::new((power, error), spread).unless_tiny(|| false);
        }
        // Between 0 and the power of the largest base.
        let (most, error) = T::power_of(T::from_f64(base.largest()), exponent);
        Ball::new((power, error), size(most) + size(power)).unless_tiny(|| false)
    }

    fn turns(x: Self, z: Self) -> Self {
        let (turns, error) = T::turns_of(x.middle, z.middle);
        // So little before a whole turn that it was rounded to the seam.
        let is_at_seam = turns == T::ZERO && x.middle < T::ZERO;
        if is_at_seam {
            return Ball { middle: turns, radius: f64::INFINITY };
        }
        if x.radius == 0.0 && z.radius == 0.0 {
            return Ball { middle: turns, radius: error };
        }
        let is_ahead = z.middle.to_f64() >= 0.0;
        let is_on_seam = up(x.radius) >= size(x.middle) && is_ahead;
        let (spread, distance) = (up(x.radius + z.radius), size(x.middle).max(size(z.middle)));
        let rest = distance - spread;
        let holds_axis = rest <= 0.0 || rest.is_nan();
        if is_on_seam || holds_axis {
            return Ball { middle: turns, radius: f64::INFINITY };
        }
        // A point moves around the axis by at most as much as it moves by, over its distance.
        let moved = spread / (rest * std::f64::consts::TAU);
        Ball::new((turns, error), moved.max(LEAST))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // The smaller of two numbers moves no more than the one that moves more.
        Ball { middle: self.middle.min(other.middle), radius: wider(self.radius, other.radius) }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Ball { middle: self.middle.max(other.middle), radius: wider(self.radius, other.radius) }
    }

    #[inline(always)]
    fn total_cmp(&self, other: &Self) -> Ordering {
        self.middle.total_cmp(&other.middle)
    }

    #[inline(always)]
    fn is_nan(self) -> bool {
        self.middle.is_nan()
    }

    #[inline(always)]
    fn exceeds(self, tolerance: f64) -> bool {
        let middle = self.middle.to_f64();
        if self.is_sign_certain() {
            return middle > 0.0;
        }
        doubt();
        middle > tolerance
    }

    #[inline(always)]
    fn vanishes(self, tolerance: f64) -> bool {
        let middle = self.middle.to_f64();
        if self.is_sign_certain() {
            return middle == 0.0;
        }
        doubt();
        middle.abs() <= tolerance
    }

    #[inline(always)]
    fn is_below(self, bound: f64) -> bool {
        // Bounds come from fewer than 16 operations on doubles.
        const BOUND_ERROR: f64 = 8.0 * f64::EPSILON;
        let size = size(self.middle);
        let is_certain =
            self.radius == 0.0 || (size - bound).abs() > up(self.radius) + BOUND_ERROR * bound;
        if !is_certain {
            doubt();
        }
        size < bound
    }

    #[inline(always)]
    fn is_surely_zero(self) -> bool {
        self.radius == 0.0 && self.middle == T::ZERO
    }

    #[inline(always)]
    fn is_surely_positive(self) -> bool {
        self.is_sign_certain() && self.middle.to_f64() > 0.0
    }

    #[inline(always)]
    fn radius(self) -> f64 {
        up(self.radius)
    }

    fn nearest_double(self) -> f64 {
        let [low, high] = self.ends();
        if low != high {
            doubt();
        }
        self.middle.to_f64()
    }

    fn ends(self) -> [f64; 2] {
        T::nearest_doubles(self.middle, up(self.radius))
    }

    #[inline(always)]
    fn take_doubt() -> bool {
        DOUBT.take()
    }
}

/// The larger of two radii, NaN if either is.
#[inline(always)]
fn wider(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}
