//! Balls against numbers of 256 bits: whatever real numbers the operands stand for, the result of the
//! operation on those is in the ball that the operation on the balls gives.

use std::any::TypeId;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;

use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;

use super::rough::Rough;
use super::*;

type Big = FBig<HalfEven>;

fn big(value: f64) -> Big {
    Big::try_from(value).expect("finite").with_precision(256).value()
}

/// What tells a number's exact value.
trait Exactly: InBalls {
    fn exactly(self) -> Big;

    /// What it is above a number, in as many digits as that has: the parts of a double-double number may
    /// be further apart than 256 bits.
    fn above(self, number: &Big) -> Big {
        self.exactly() - number
    }

    /// A number with all the digits of its type, near a double.
    fn with_digits(hi: f64, rest: f64) -> Self;
}

impl Exactly for f64 {
    fn exactly(self) -> Big {
        big(self)
    }

    fn with_digits(hi: f64, _: f64) -> f64 {
        hi
    }
}

impl Exactly for Rough {
    fn exactly(self) -> Big {
        big(self.to_f64())
    }

    fn with_digits(hi: f64, _: f64) -> Rough {
        Rough::from_f64(hi)
    }
}

impl Exactly for Dd {
    fn exactly(self) -> Big {
        big(self.hi) + big(self.lo)
    }

    fn above(self, number: &Big) -> Big {
        (big(self.hi) - number) + big(self.lo)
    }

    fn with_digits(hi: f64, rest: f64) -> Dd {
        Dd::from(hi) + Dd::from(rest * hi * f64::EPSILON / 2.0)
    }
}

/// A sequence of numbers.
struct Numbers(u64);

impl Numbers {
    /// From 0 to 1.
    fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// From -1 to 1.
    fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Of any sign and of sizes from 2^-20 to 2^20; often one of few digits.
    fn middle<T: Exactly>(&mut self) -> T {
        let scale = f64::exp2((40.0 * self.unit() - 20.0).round());
        if self.unit() < 0.2 {
            return T::from_f64((4.0 * self.signed()).round() * scale);
        }
        let hi = self.signed() * scale;
        T::with_digits(hi, self.signed())
    }

    /// A ball, and a number in it: often at its edge, and often the ball is but that number.
    fn ball<T: Exactly>(&mut self) -> (Ball<T>, Big) {
        let middle: T = self.middle();
        self.around(middle)
    }

    fn around<T: Exactly>(&mut self, middle: T) -> (Ball<T>, Big) {
        let relative = f64::exp2(-110.0 * self.unit());
        let radius = if self.unit() < 0.3 { 0.0 } else { size(middle) * relative };
        let reach = reach_of(radius);
        let offset = match (4.0 * self.unit()) as u32 {
            0 => reach,
            1 => -reach,
            _ => self.signed() * reach,
        };
        (Ball { middle, radius }, middle.exactly() + big(offset))
    }
}

thread_local! {
    /// How far numbers may be from the middle of their ball, in radii.
    static REACH: Cell<f64> = const { Cell::new(1.0) };
    /// Of each operation on numbers of each type, how often it was asked, and how often it bounded nothing.
    static ASKED: RefCell<HashMap<(&'static str, TypeId), [u32; 2]>> = RefCell::default();
}

/// How far a number may be from the middle of a ball with this radius.
fn reach_of(radius: f64) -> f64 {
    // No further, however it is rounded.
    match REACH.get() {
        1.0 => radius,
        reach => (radius * reach).next_down().max(0.0),
    }
}

/// Whether the result of an operation bounds anything, which is counted.
fn is_bounded<T: Exactly>(ball: Ball<T>, what: &'static str) -> bool {
    let is_bounded = ball.radius.is_finite() && ball.middle.to_f64().is_finite();
    ASKED.with_borrow_mut(|asked| {
        let [n_asked, n_unbounded] = asked.entry((what, TypeId::of::<T>())).or_default();
        *n_asked += 1;
        *n_unbounded += u32::from(!is_bounded);
    });
    is_bounded
}

#[track_caller]
fn assert_holds<T: Exactly>(ball: Ball<T>, number: &Big, what: &'static str) {
    if !is_bounded(ball, what) {
        return;
    }
    let above = ball.middle.above(number);
    let off = above.to_f64().value().abs();
    // Bounds fall short by fewer than 32 roundings.
    let bound = ball.radius * REACH.get() * (1.0 + 16.0 * f64::EPSILON);
    assert!(off <= bound, "{what}: {ball:?} is off by {off:e}");
    // What is below the range of doubles is something nevertheless.
    assert!(ball.radius > 0.0 || above == Big::ZERO, "{what}: {ball:?} is not exact");
}

/// Runs a case on many numbers, in all types. No operation may leave more than this share of its results
/// without a bound.
fn all(n: usize, most_unbounded: f64, in_types: [fn(&mut Numbers); 3]) {
    let mut numbers = Numbers(7);
    // What the radii of operands fall short by, those of results may fall short by as well.
    for reach in [1.0, ROOM] {
        REACH.set(reach);
        for _ in 0..n {
            for case in in_types {
                case(&mut numbers);
            }
        }
    }
    for ((what, _), [n_asked, n_unbounded]) in ASKED.take() {
        let share = f64::from(n_unbounded) / f64::from(n_asked);
        assert!(share <= most_unbounded, "{what}: {share} of {n_asked} have no bound");
    }
}

fn operations<T: Exactly>(numbers: &mut Numbers) {
    operations_on([0; 3].map(|_| numbers.ball::<T>()));
    inner_products([0; 7].map(|_| numbers.ball::<T>()));
}

fn operations_on<T: Exactly>([(a, x), (b, y), (c, z)]: [(Ball<T>, Big); 3]) {
    assert_holds(a + b, &(&x + &y), "sum");
    assert_holds(a - b, &(&x - &y), "difference");
    assert_holds(a * b, &(&x * &y), "product");
    assert_holds(a.mul_add(b, c), &(&x * &y + &z), "product and sum");
    assert_holds(-a, &-&x, "negation");
    if y != Big::ZERO {
        assert_holds(a / b, &(&x / &y), "quotient");
    }
    if x > Big::ZERO {
        assert_holds(a.sqrt_or_zero(), &x.sqrt(), "root");
    }
    for sign in [-1.0, 0.0, 1.0] {
        assert_holds(a.with_sign(sign), &(&x * big(sign)), "signed number");
    }
    let smaller = if x < y { &x } else { &y };
    let larger = if x < y { &y } else { &x };
    assert_holds(a.min(b), smaller, "minimum");
    assert_holds(a.max(b), larger, "maximum");
}

fn inner_products<T: Exactly>(numbers: [(Ball<T>, Big); 7]) {
    let ball = |index: usize| numbers[index].0;
    let product = |i: usize, j: usize| &numbers[i].1 * &numbers[j].1;
    let (a, b) = ([0, 1, 2].map(ball), [3, 4, 5].map(ball));
    let exact = product(0, 3) + product(1, 4) + product(2, 5);
    assert_holds(Ball::dot(a, b), &exact, "inner product");
    assert_holds(Ball::dot_and(a, b, ball(6)), &(exact + &numbers[6].1), "inner product and sum");
    let exact = product(0, 3) - product(1, 4);
    let found = Ball::difference_of_products(ball(0), ball(3), ball(1), ball(4));
    assert_holds(found, &exact, "difference of products");
    let exact = product(0, 0) - product(1, 1) + product(2, 2) - big(1.0);
    let found = Ball::signed_squares([1.0, -1.0, 1.0], a, 1.0);
    assert_holds(found, &exact, "squares");
}

#[test]
fn operations_hold_their_results() {
    // Some are to be divided by what is off by nearly as much as it is large.
    all(20_000, 0.001, [operations::<f64>, operations::<Rough>, operations::<Dd>]);
}

/// A ball of any scale that doubles have, those below the normal ones among them, or 0; and a number
/// in it.
fn of_any_scale<T: Exactly>(numbers: &mut Numbers) -> (Ball<T>, Big) {
    let mut any = |least: f64| {
        let scale = (2098.0 * numbers.unit() - 1074.0).max(least).round() as i32;
        libm::scalbn(2.0 * numbers.unit() - 1.0, scale)
    };
    let (middle, radius) = (any(-1074.0), any(-1074.0).abs());
    let is_small = radius < middle.abs();
    let radius = if numbers.unit() < 0.4 && is_small { radius } else { 0.0 };
    let middle = if numbers.unit() < 0.1 { 0.0 } else { middle };
    let reach = reach_of(radius);
    let offset = if numbers.unit() < 0.5 { reach } else { -reach };
    // From the least of doubles to the largest are 2098 bits.
    let [middle_digits, offset] = [middle, offset].map(|x| big(x).with_precision(2400).value());
    (Ball::from_bounded(Dd::from(middle), radius), middle_digits + offset)
}

fn operations_at_any_scale<T: Exactly>(numbers: &mut Numbers) {
    operations_on([0; 3].map(|_| of_any_scale::<T>(numbers)));
    inner_products([0; 7].map(|_| of_any_scale::<T>(numbers)));
}

#[test]
fn operations_hold_their_results_at_any_scale() {
    let in_types = [
        operations_at_any_scale::<f64>,
        operations_at_any_scale::<Rough>,
        operations_at_any_scale::<Dd>,
    ];
    all(6_000, 0.6, in_types);
}

#[test]
fn rough_doubles_know_little_to_be_exact() {
    let ball = Ball::<Rough>::from_f64;
    let (zero, two, tiny) = (ball(0.0), ball(2.0), ball(1e-300));
    let exact = [zero, -zero, two, zero * two, zero + zero, zero / two, zero.sqrt_or_zero()];
    assert!(exact.iter().all(|ball| ball.radius == 0.0));
    assert_eq!(Ball::dot([zero, two, zero], [two, zero, zero]).radius, 0.0);
    assert_eq!(Ball::difference_of_products(zero, two, zero, two).radius, 0.0);
    let (three, four) = (ball(3.0), ball(4.0));
    assert_eq!((four.sqrt_or_zero().radius, Ball::turns(two, -two).radius), (0.0, 0.0));
    assert!((four - four).is_surely_zero());
    let cancelled = [
        two.mul_add(two, -four),
        Ball::dot_and([zero, zero, two], [two; 3], -four),
        Ball::difference_of_products(two, three, three, two),
    ];
    assert!(cancelled.iter().all(|ball| ball.holds_zero() && ball.radius > 0.0));
    let rounded = [two * two, two + two, two / two, two - two * ball(1.0), tiny, tiny * tiny];
    assert!(rounded.iter().all(|ball| ball.radius > 0.0));
    assert!((tiny * tiny).radius < 1e-149);
}

#[test]
fn bounds_of_roots_are_half_those_of_squares() {
    // The root of 4 + r is 2 + r / 4, and little less.
    let root = Ball { middle: 4.0, radius: 1e-9 }.sqrt_or_zero();
    assert!((2.5e-10..2.501e-10).contains(&root.radius), "{root:?}");
    // That of 4 - 3 is 1: the bound holds it, and not twice as much.
    let root = Ball { middle: 4.0, radius: 3.0 }.sqrt_or_zero();
    assert!((1.0..1.5).contains(&root.radius), "{root:?}");
    // That of a number which is as far off as the room for roundings lets it be, and nearly 0.
    let root = Ball { middle: 4.0, radius: 3.76 }.sqrt_or_zero();
    assert!(up(root.radius) >= 2.0 - (4.0 - 3.76 * ROOM).sqrt(), "{root:?}");
    // What is known of nothing tells nothing.
    assert!(Ball { middle: 4.0, radius: f64::NAN }.sqrt_or_zero().radius.is_nan());
}

fn units<T: Exactly>(numbers: &mut Numbers) {
    unit([0; 3].map(|_| numbers.ball::<T>()));
    unit([0; 3].map(|_| of_any_scale::<T>(numbers)));
}

fn unit<T: Exactly>(v: [(Ball<T>, Big); 3]) {
    // Vectors beyond are brought to a length near 1 first.
    let largest = v.iter().fold(0.0, |largest: f64, (ball, _)| largest.max(size(ball.middle)));
    let length = v.iter().fold(Big::ZERO, |sum, (_, x)| sum + x * x).sqrt();
    if !(1e-140..1e140).contains(&largest) || length == Big::ZERO {
        return;
    }
    let found = Ball::unit([0, 1, 2].map(|index: usize| v[index].0));
    for (found, (_, x)) in found.into_iter().zip(&v) {
        assert_holds(found, &(x / &length), "component of a unit vector");
    }
}

#[test]
fn unit_vectors_hold_their_results() {
    // What may be 0 has no direction.
    all(6_000, 0.1, [units::<f64>, units::<Rough>, units::<Dd>]);
}

/// Sums of products of which much cancels, or all.
fn cancelling<T: Exactly>(numbers: &mut Numbers) {
    let [(a, x), (b, y)] = [0; 2].map(|_| numbers.ball::<T>());
    let apart = if numbers.unit() < 0.2 { 0.0 } else { f64::exp2(-100.0 * numbers.unit()) };
    let near = |t: T, numbers: &mut Numbers| t + t * T::from_f64(apart * numbers.signed());
    let (c, d) = (near(a.middle, numbers), near(b.middle, numbers));
    let ((c, z), (d, w)) = (numbers.around(c), numbers.around(d));
    let exact = &x * &y - &z * &w;
    assert_holds(Ball::difference_of_products(a, b, c, d), &exact, "difference of products");
    let term = near(-(a.middle * b.middle), numbers);
    let (term, t) = numbers.around(term);
    assert_holds(a.mul_add(b, term), &(&x * &y + &t), "product and sum");
    let [(e, v), (f, u)] = [0; 2].map(|_| numbers.ball::<T>());
    let found = Ball::dot_and([e, Ball::ZERO, a], [f, e, b], term);
    assert_holds(found, &(&v * &u + (&x * &y + t)), "inner product and sum");
    let unit = numbers.unit() * 90.0;
    let (sin, cos) = Dd::sin_cos_degrees(unit);
    let [sin, cos] = [sin, cos].map(|x| near(T::from_dd(x), numbers));
    let ((p, px), (q, qx), (r, rx)) =
        (numbers.around(sin), numbers.around(cos), numbers.ball::<T>());
    let exact = &px * &px + &qx * &qx - big(1.0);
    let found = Ball::signed_squares([1.0, 0.0, 1.0], [p, r, q], 1.0);
    assert_holds(found, &exact, "squares of a cylinder");
    let exact = &px * &px + &qx * &qx - &rx * &rx;
    let found = Ball::signed_squares([1.0, -1.0, 1.0], [p, r, q], 0.0);
    assert_holds(found, &exact, "squares of a cone");
}

#[test]
fn sums_that_cancel_hold_their_results() {
    all(20_000, 0.0, [cancelling::<f64>, cancelling::<Rough>, cancelling::<Dd>]);
}

fn powers<T: Exactly>(numbers: &mut Numbers) {
    let base = numbers.ball::<T>();
    power(base, numbers);
    let base = of_any_scale::<T>(numbers);
    power(base, numbers);
}

fn power<T: Exactly>((ball, x): (Ball<T>, Big), numbers: &mut Numbers) {
    if x <= Big::ZERO || ball.middle.to_f64() <= 0.0 {
        return;
    }
    let exponent = (numbers.unit() - 0.2) * 40.0;
    let exponent = if numbers.unit() < 0.5 { exponent.round() } else { exponent };
    let exact = (x.with_precision(256).value().ln() * big(exponent)).exp();
    // Logarithms and exponentials of 256 bits, not exact ones.
    let found = Ball::power(ball, exponent);
    let room = Ball { radius: found.radius + 1e-60 * size(found.middle), ..found };
    assert_holds(room, &exact, "power");
}

#[test]
fn powers_hold_their_results() {
    all(3_000, 0.35, [powers::<f64>, powers::<Rough>, powers::<Dd>]);
}

fn angles<T: Exactly>(numbers: &mut Numbers) {
    let reach = if numbers.unit() < 0.5 { 20.0 } else { 1070.0 };
    let (turn, distance) = (360.0 * numbers.unit(), f64::exp2(reach * numbers.signed()).min(1e300));
    let (sin, cos) = Dd::sin_cos_degrees(turn);
    let [x, z] = [sin, cos].map(|x| T::from_dd(x * Dd::from(distance)));
    let ((x, px), (z, pz)) = (numbers.around(x), numbers.around(z));
    let found = Ball::turns(x, z);
    if !is_bounded(found, "turns") {
        return;
    }
    // The tangent of the angle between what was found and the point, by the addition theorem.
    let (sin, cos) = (found.middle.exactly() * Big::pi(256) * big(2.0)).sin_cos();
    let (across, along) = (&px * &cos - &pz * &sin, &px * &sin + &pz * &cos);
    assert!(along > Big::ZERO, "{found:?}");
    let between = (across / along).to_f64().value().abs().atan() / std::f64::consts::TAU;
    // The arc tangent is rounded here, and what is exact is known to 256 bits.
    let bound = found.radius * REACH.get();
    let room = bound * 4.0 * f64::EPSILON + 1e-70;
    assert!(between <= bound + room, "{found:?} {between:e}");
}

#[test]
fn angles_hold_their_results() {
    all(1_000, 0.5, [angles::<f64>, angles::<Rough>, angles::<Dd>]);
}

/// Whether something leaves a doubt.
fn doubts<X>(decide: impl FnOnce() -> X) -> bool {
    let _ = Ball::<f64>::take_doubt();
    decide();
    Ball::<f64>::take_doubt()
}

#[test]
fn only_what_overlaps_is_in_doubt() {
    let ball = |middle: f64, radius: f64| Ball { middle, radius };
    let (one, near, far) = (ball(1.0, 1e-10), ball(1.0 + 1e-10, 1e-11), ball(1.0 + 1e-9, 1e-11));
    assert!(doubts(|| one < near) && doubts(|| one == near) && doubts(|| one >= one));
    assert!(!doubts(|| (one < far, far > one, one != far, far >= one)));
    assert_eq!((one < far, far > one, one == far, far <= one), (true, true, false, false));
    let (zero, exact) = (Ball::<f64>::ZERO, ball(3.0, 0.0));
    assert!(!doubts(|| exact == exact) && !doubts(|| zero <= zero) && exact == ball(3.0, 0.0));
    let infinite = ball(f64::INFINITY, 0.0);
    assert!(!doubts(|| infinite > one) && !doubts(|| infinite == infinite) && infinite > one);
    assert!(doubts(|| ball(f64::NAN, 0.0) < one) && doubts(|| one < ball(2.0, f64::INFINITY)));
    assert!(doubts(|| one < ball(2.0, f64::NAN)));
    // What is asked of one number.
    let small = ball(1e-20, 1e-19);
    assert!(doubts(|| small.exceeds(0.0)) && doubts(|| small.vanishes(0.0)));
    assert!(!doubts(|| small.is_below(1e-3)) && small.is_below(1e-3) && !one.is_below(1e-3));
    assert!(
        doubts(|| small.is_below(1e-19)) && !doubts(|| zero.exceeds(0.0)) && !zero.exceeds(0.0)
    );
    assert!(one.exceeds(2.0) && zero.vanishes(0.0) && !one.vanishes(2.0));
    assert!(doubts(|| ball(f64::NAN, 0.0).exceeds(0.0)));
}

#[test]
fn doubles_nearest_to_a_ball_are_certain_or_in_doubt() {
    let third = Ball { middle: Dd::ONE / Dd::from(3.0), radius: 1e-30 };
    assert!(!doubts(|| third.nearest_double()));
    assert_eq!(third.nearest_double(), 1.0 / 3.0);
    // Half way between two doubles.
    let tie = Dd::ONE + Dd::from(f64::EPSILON / 2.0);
    assert!(doubts(|| Ball { middle: tie, radius: 1e-30 }.nearest_double()));
    assert!(!doubts(|| Ball { middle: tie, radius: 0.0 }.nearest_double()));
    assert!(doubts(|| Ball { middle: 0.5, radius: 1e-17 }.nearest_double()));
}

#[test]
fn the_seam_is_in_doubt_and_exact_angles_are_not() {
    let turns = |x: (f64, f64), z: (f64, f64)| {
        let ball = |(middle, radius): (f64, f64)| Ball { middle, radius };
        Ball::turns(ball(x), ball(z))
    };
    assert!(turns((1e-20, 1e-19), (1.0, 0.0)).radius.is_infinite());
    assert!(turns((-1e-20, 0.0), (1.0, 0.0)).radius.is_infinite());
    assert!(turns((0.0, 1e-19), (0.0, 1e-19)).radius.is_infinite());
    for (x, z, turn) in [(0.0, 1.0, 0.0), (1.0, 0.0, 0.25), (1.0, 1.0, 0.125), (0.0, -1.0, 0.5)] {
        let found = turns((x, 0.0), (z, 0.0));
        assert_eq!((found.middle, found.radius), (turn, 0.0));
    }
    assert!(turns((1e-20, 1e-19), (-1.0, 0.0)).radius < 1e-15);
}

#[test]
fn bounds_survive_underflow() {
    let tiny = Ball { middle: 1e-200, radius: 0.0 };
    let product = tiny * tiny;
    assert_eq!(product.middle, 0.0);
    assert!(product.radius > 0.0, "1e-400 is not 0");
    let quotient = Ball { middle: 1e-300, radius: 0.0 } / Ball { middle: 3e200, radius: 0.0 };
    assert!(quotient.radius > 0.0);
    let (zero, two) = (Ball::<f64>::ZERO, Ball { middle: 2.0, radius: 0.0 });
    assert_eq!(((zero * two).radius, (zero / two).radius, (two * two).radius), (0.0, 0.0, 0.0));
    let third = Ball { middle: 1.0 / 3.0, radius: 1e-17 };
    assert_eq!(((zero * third).radius, third.mul_add(zero, two).radius), (0.0, 0.0));
}
