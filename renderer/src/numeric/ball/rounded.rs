//! Operations that say how far off their results are.

use crate::numeric::ball::{Ball, size};
use crate::numeric::dd::{DD_ERROR, Dd, two_product, two_sum};
use crate::numeric::real::{Real, is_by_squaring};

/// A result, and a bound of its error.
pub type Rounded<T> = (T, f64);

/// Numbers that balls are made of, with operations that bound what they round off, wherever that neither
/// overflows nor falls below [`LEAST`]. A result that is exact by an argument that costs little has a
/// bound of 0, so that symmetric scenes, and what lies along an axis, stay exact.
pub trait Bounding: Real {
    /// What radii that are not 0 have at least, as room for what falls below the range of doubles; 0 if
    /// operations find out themselves.
    const FLOOR: f64 = 0.0;

    /// The radius that a ball of this number has at least.
    #[inline(always)]
    fn least_radius(self) -> f64 {
        0.0
    }

    /// `q = a / b`, and a bound of `a - q b`.
    fn quotient(a: Self, b: Self) -> Rounded<Self>;

    /// The square root s of a number that is not negative, and a bound of `a - s²`.
    fn root(a: Self) -> Rounded<Self>;

    /// `s1 x² + s2 y² + s3 z² - k` for signs s.
    fn squares(signs: [f64; 3], p: [Self; 3], k: f64) -> Rounded<Self>;

    /// [`Real::power`].
    fn power_of(base: Self, exponent: f64) -> Rounded<Self>;

    /// [`Real::turns`].
    fn turns_of(x: Self, z: Self) -> Rounded<Self>;

    /// The doubles nearest to the ends of an interval around a number.
    fn nearest_doubles(middle: Self, radius: f64) -> [f64; 2];
}

/// Numbers, and how balls of them are added up and multiplied.
pub trait InBalls: Bounding {
    /// `a + b`.
    fn sum(a: Ball<Self>, b: Ball<Self>) -> Ball<Self>;

    /// `a b`.
    fn product(a: Ball<Self>, b: Ball<Self>) -> Ball<Self>;

    /// `a b + c`.
    fn product_sum(a: Ball<Self>, b: Ball<Self>, c: Ball<Self>) -> Ball<Self>;

    /// `a b - c d`.
    fn product_difference(ab: [Ball<Self>; 2], cd: [Ball<Self>; 2]) -> Ball<Self>;

    /// The inner product, and a number added to it.
    #[inline(always)]
    fn inner_product(
        a: [Ball<Self>; 3],
        b: [Ball<Self>; 3],
        term: Option<Ball<Self>>,
    ) -> Ball<Self> {
        let last = term.map_or_else(|| a[2] * b[2], |term| a[2].mul_add(b[2], term));
        a[0].mul_add(b[0], a[1].mul_add(b[1], last))
    }

    /// A vector divided by its length, which is above 0.
    #[inline(always)]
    fn unit_of(v: [Ball<Self>; 3]) -> [Ball<Self>; 3] {
        let inverse = Ball::ONE / Ball::dot(v, v).sqrt_or_zero();
        v.map(|x| x * inverse)
    }
}

/// Numbers that find out what is rounded off in sums and products.
trait Residual: Bounding {
    /// `a + b`.
    fn found_sum(a: Self, b: Self) -> Rounded<Self>;

    /// `a b`.
    fn found_product(a: Self, b: Self) -> Rounded<Self>;

    /// `a b + c`.
    fn found_product_sum(a: Self, b: Self, c: Self) -> Rounded<Self>;

    /// `a b - c d`.
    fn found_product_difference(a: Self, b: Self, c: Self, d: Self) -> Rounded<Self>;
}

impl<T: Residual> InBalls for T {
    #[inline(always)]
    fn sum(a: Ball<T>, b: Ball<T>) -> Ball<T> {
        // Nothing falls below the range of doubles in a sum.
        Ball::new(T::found_sum(a.middle, b.middle), a.radius + b.radius)
    }

    #[inline(always)]
    fn product(a: Ball<T>, b: Ball<T>) -> Ball<T> {
        let found = T::found_product(a.middle, b.middle);
        Ball::new(found, radius_of_product(a, b)).unless_tiny(|| is_exact_product(a, b))
    }

    #[inline(always)]
    fn product_sum(a: Ball<T>, b: Ball<T>, c: Ball<T>) -> Ball<T> {
        let found = T::found_product_sum(a.middle, b.middle, c.middle);
        Ball::new(found, radius_of_product(a, b) + c.radius)
            .unless_tiny(|| c.radius == 0.0 && is_exact_product(a, b))
    }

    #[inline(always)]
    fn product_difference([a, b]: [Ball<T>; 2], [c, d]: [Ball<T>; 2]) -> Ball<T> {
        let found = T::found_product_difference(a.middle, b.middle, c.middle, d.middle);
        Ball::new(found, radius_of_product(a, b) + radius_of_product(c, d))
            .unless_tiny(|| is_exact_product(a, b) && is_exact_product(c, d))
    }
}

/// What the radii of two factors become in their product.
#[inline(always)]
fn radius_of_product<T: InBalls>(a: Ball<T>, b: Ball<T>) -> f64 {
    size(a.middle).mul_add(b.radius, a.radius * b.largest_factor())
}

/// Whether a product that seems to be exact is: nothing of it can have been lost to underflow.
#[inline]
pub(super) fn is_exact_product<T: InBalls>(a: Ball<T>, b: Ball<T>) -> bool {
    let product = size(a.middle) * size(b.middle);
    let is_large = a.radius == 0.0 && b.radius == 0.0 && product >= LEAST;
    is_large || a.is_surely_zero() || b.is_surely_zero()
}

/// Products below this may have lost digits to underflow, and bounds below it their meaning: it is
/// 2^-900, so that what is above it has residuals of 2^-1006, in the range of doubles.
pub const LEAST: f64 = f64::from_bits((1023 - 900) << 52);

/// The roundings in a sum of at most six low parts, and in that of their sizes.
const OF_LOW_PARTS: f64 = 8.0 * (f64::EPSILON / 2.0);

/// The sum of doubles whose first is the largest in effect, and how far off it may be: each is added
/// without error, and what that leaves over is added in doubles.
#[inline(always)]
fn compensated<const N: usize>(terms: [f64; N], low_parts: f64, low_size: f64) -> Rounded<f64> {
    let (mut high, mut low, mut size) = (terms[0], low_parts, low_size);
    for term in &terms[1..] {
        let sum = two_sum(high, *term);
        high = sum.hi;
        low += sum.lo;
        size += sum.lo.abs();
    }
    let result = two_sum(high, low);
    (result.hi, result.lo.abs() + OF_LOW_PARTS * size)
}

impl Residual for f64 {
    #[inline(always)]
    fn found_sum(a: f64, b: f64) -> Rounded<f64> {
        let sum = two_sum(a, b);
        (sum.hi, sum.lo.abs())
    }

    #[inline(always)]
    fn found_product(a: f64, b: f64) -> Rounded<f64> {
        let product = two_product(a, b);
        (product.hi, product.lo.abs())
    }

    #[inline(always)]
    fn found_product_sum(a: f64, b: f64, c: f64) -> Rounded<f64> {
        let ab = two_product(a, b);
        compensated([ab.hi, c], ab.lo, ab.lo.abs())
    }

    #[inline(always)]
    fn found_product_difference(a: f64, b: f64, c: f64, d: f64) -> Rounded<f64> {
        let (ab, cd) = (two_product(a, b), two_product(-c, d));
        compensated([ab.hi, cd.hi], ab.lo + cd.lo, ab.lo.abs() + cd.lo.abs())
    }
}

impl Bounding for f64 {
    #[inline(always)]
    fn quotient(a: f64, b: f64) -> Rounded<f64> {
        let quotient = a / b;
        (quotient, (-quotient).mul_add(b, a).abs())
    }

    #[inline(always)]
    fn root(a: f64) -> Rounded<f64> {
        let root = a.sqrt();
        (root, (-root).mul_add(root, a).abs())
    }

    #[inline(always)]
    fn squares([s1, s2, s3]: [f64; 3], [x, y, z]: [f64; 3], k: f64) -> Rounded<f64> {
        let (xx, yy, zz) = (two_product(s1 * x, x), two_product(s2 * y, y), two_product(s3 * z, z));
        let low = xx.lo + yy.lo + zz.lo;
        compensated([xx.hi, yy.hi, zz.hi, -k], low, xx.lo.abs() + yy.lo.abs() + zz.lo.abs())
    }

    fn power_of(base: f64, exponent: f64) -> Rounded<f64> {
        let power = f64::power(base, exponent);
        if power == 1.0 && (base == 1.0 || exponent == 0.0) {
            return (power, 0.0);
        }
        // A product of powers of m and n, off by m - 1 and n - 1 roundings, is off by m + n - 1; `pow`
        // errs by less than two. The rest is room for what this grows to beyond first order.
        let roundings = if is_by_squaring(exponent) { 1.25 * exponent } else { 2.0 };
        (power, (roundings + 2.0) * f64::UNIT_ROUNDOFF * power)
    }

    fn turns_of(x: f64, z: f64) -> Rounded<f64> {
        let turns = f64::turns(x, z);
        // An eighth of a turn at most, with roundings of the quotient, of the arc tangent (less than
        // one unit in the last place), and of the division by 2π, and of 2π; then three differences
        // of at most a turn.
        let is_exact = x == 0.0 || z == 0.0 || x.abs() == z.abs();
        (turns, if is_exact { 0.0 } else { 5.0 * f64::UNIT_ROUNDOFF })
    }

    fn nearest_doubles(middle: f64, radius: f64) -> [f64; 2] {
        if radius == 0.0 {
            [middle; 2]
        } else {
            [(middle - radius).next_down(), (middle + radius).next_up()]
        }
    }
}

/// A bound of the error of a sum that cancels: see [`Dd`]'s implementation of [`Real`].
fn of_cancelling(result: Dd, terms: f64) -> f64 {
    const OF_TERMS: f64 = DD_ERROR / (1u64 << 49) as f64;
    DD_ERROR * result.size() + OF_TERMS * terms
}

impl Dd {
    fn size(self) -> f64 {
        self.hi.abs()
    }

    fn is_double(self) -> bool {
        self.lo == 0.0
    }

    /// A sum of two doubles' product and a third, if two doubles can hold it.
    #[inline]
    fn exact_product_sum(a: f64, b: f64, c: f64) -> Option<Dd> {
        let product = two_product(a, b);
        let high = two_sum(product.hi, c);
        let low = two_sum(high.lo, product.lo);
        (low.lo == 0.0).then(|| two_sum(high.hi, low.hi))
    }
}

// Whole, these are too long to stand wherever the tracer uses them.
impl Residual for Dd {
    #[inline]
    fn found_sum(a: Dd, b: Dd) -> Rounded<Dd> {
        let sum = a + b;
        let is_exact =
            a.is_double() && b.is_double() || a == Dd::ZERO || b == Dd::ZERO || sum == Dd::ZERO;
        (sum, if is_exact { 0.0 } else { DD_ERROR * sum.size() })
    }

    #[inline(never)]
    fn found_product(a: Dd, b: Dd) -> Rounded<Dd> {
        let product = a * b;
        let is_exact = a.is_double() && b.is_double() || a.abs() == Dd::ONE || b.abs() == Dd::ONE;
        (product, if is_exact { 0.0 } else { DD_ERROR * product.size() })
    }

    #[inline(never)]
    fn found_product_sum(a: Dd, b: Dd, c: Dd) -> Rounded<Dd> {
        if a == Dd::ZERO || b == Dd::ZERO {
            return (c, 0.0);
        }
        if a.is_double()
            && b.is_double()
            && c.is_double()
            && let Some(exact) = Dd::exact_product_sum(a.hi, b.hi, c.hi)
        {
            return (exact, 0.0);
        }
        let sum = a.mul_add(b, c);
        (sum, of_cancelling(sum, a.size() * b.size() + c.size()))
    }

    #[inline(never)]
    fn found_product_difference(a: Dd, b: Dd, c: Dd, d: Dd) -> Rounded<Dd> {
        let difference = Dd::difference_of_products(a, b, c, d);
        let (ab, cd) = (a.size() * b.size(), c.size() * d.size());
        let is_nothing = ab == 0.0 && cd == 0.0 || difference == Dd::ZERO && a == c && b == d;
        (difference, if is_nothing { 0.0 } else { of_cancelling(difference, ab + cd) })
    }
}

impl Bounding for Dd {
    #[inline(never)]
    fn quotient(a: Dd, b: Dd) -> Rounded<Dd> {
        let quotient = a / b;
        let is_double = a.is_double() && b.is_double() && quotient.is_double();
        let is_exact = is_double && quotient.hi.mul_add(-b.hi, a.hi) == 0.0;
        (quotient, if is_exact { 0.0 } else { DD_ERROR * a.size() })
    }

    #[inline(never)]
    fn root(a: Dd) -> Rounded<Dd> {
        let root = a.sqrt_or_zero();
        let is_exact = a.is_double() && root.is_double() && root.hi.mul_add(-root.hi, a.hi) == 0.0;
        // (s (1 + e))² - s² is 2 e s², and little more.
        (root, if is_exact { 0.0 } else { 3.0 * DD_ERROR * a.size() })
    }

    #[inline(never)]
    fn squares(signs: [f64; 3], p: [Dd; 3], k: f64) -> Rounded<Dd> {
        let sum = Dd::signed_squares(signs, p, k);
        let terms = p.map(|x| x.size() * x.size());
        (sum, of_cancelling(sum, terms[0] + terms[1] + terms[2] + k.abs()))
    }

    fn power_of(base: Dd, exponent: f64) -> Rounded<Dd> {
        let power = Dd::power(base, exponent);
        // Beyond, a double-double has neither the range nor the digits.
        const LIMIT: f64 = 650.0;
        let logarithm = exponent * libm::log(base.to_f64());
        let within = logarithm.abs() < LIMIT;
        if !within {
            return (power, if logarithm < 0.0 { LEAST } else { f64::INFINITY });
        }
        // Twice what `Dd::power` promises, which covers the rounding of the logarithm here.
        (power, (4.0 * logarithm.abs() + 16.0) * DD_ERROR * power.size())
    }

    fn turns_of(x: Dd, z: Dd) -> Rounded<Dd> {
        let is_exact = x == Dd::ZERO || z == Dd::ZERO || x.abs() == z.abs();
        // Beyond, products of the coordinates have neither the range nor the digits.
        let has_digits = (LEAST..=1.0 / LEAST).contains(&x.size().max(z.size()));
        let error = if has_digits { 4.0 * DD_ERROR } else { f64::INFINITY };
        (Dd::turns(x, z), if is_exact { 0.0 } else { error })
    }

    fn nearest_doubles(middle: Dd, radius: f64) -> [f64; 2] {
        // With room for rounding the ends of the low part.
        let room = radius + f64::EPSILON * (middle.lo.abs() + radius);
        let room = if radius == 0.0 { 0.0 } else { room };
        [middle.hi + (middle.lo - room), middle.hi + (middle.lo + room)]
    }
}
