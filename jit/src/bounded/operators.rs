//! What each operator does to radii.
//!
//! Let u = 2^-53 be the unit roundoff. Each operation on doubles gives the exact result x as fl(x),
//! with |fl(x) - x| <= u |x| + 2^-1075, unless it overflows; sums are exact where they are below
//! 2^-1022. An operator has an exact result f at the centre, where the shader gets c = fl(f), and an
//! exact result g at the point in question, where the plain shader gets p = fl(g). With a *spread*
//! S >= |g - f|, found from the operands' radii,
//!
//! ```text
//! |p - c| <= |p - g| + |g - f| + |f - c| <= u (|f| + S) + S + u |c| + 2^-1074
//!         <= S (1 + u) + 2 u |c| (1 + u) + 2^-1073.
//! ```
//!
//! The radius is (S' + R) [`INFLATION`], of the computed spread S' and R = 2 u |c| + [`TINY`], all in
//! doubles. S' is below S at most by a factor of (1 - u)^16, as no spread below takes more than 16
//! operations that round, and by underflows of 2^-1075 in some of them, which are not magnified
//! afterwards and together less than half of `TINY`. The sum and the inflation round once each, and
//! so does R. (1 + 2^-48) = (1 + 32 u) makes up for all that: (1 - u)^19 (1 + 32 u) > 1 + 2 u.
//!
//! No infinity or NaN is taken for a number: where an operand's radius is not finite, nor is the
//! spread, or the shader leaves, as comparisons with NaN are never true. A finite radius tells that
//! neither c nor p has overflowed: R is infinite from |c| = 2^960 on, NaN if c is, and below, if
//! |f| + S reached 2^1024, S' would be so near to it that the inflation overflowed. An operand without
//! a radius may be anything; if it is infinite or NaN, so is c, or c is the same at all points (a
//! finite number divided by an infinity) and so is the bound.

use compiler::op::Operator;

use crate::bounded::{Bounding, Pair};
use crate::sir::{Inst, Relation, Type, Val};

/// Makes up for the rounding of radii: 1 + 32 u.
const INFLATION: f64 = 1.0 + 1.0 / (1u64 << 48) as f64;

/// Makes up for underflow: 2^51 times what one operation may lose by it.
const TINY: f64 = f64::MIN_POSITIVE;

/// 2^64; numbers of 2^960 and more overflow when multiplied by it.
const LARGE: f64 = (1u128 << 64) as f64;

/// What the results of basic operations and square roots are off by at most, of their size: u.
const HALF_UNIT: f64 = f64::EPSILON / 2.0;

/// The same for the functions of `compiler::degrees`: a unit in the last place, which is the most
/// that is documented and tested there, is at most 2 u of the size.
const UNIT: f64 = f64::EPSILON;

/// Rounded to nearest; what that takes away is less than a rounding, which is made up for.
const RADIANS_PER_DEGREE: f64 = std::f64::consts::PI / 180.0;
const DEGREES_PER_RADIAN: f64 = 180.0 / std::f64::consts::PI;

impl Bounding<'_> {
    /// What stands for the result of an operator.
    pub(super) fn scalar(&mut self, op: Operator, [a, b]: [Pair; 2], ty: Type) -> Pair {
        if a.radius.is_none() && b.radius.is_none() {
            let centre = self.emit(ty, Inst::Scalar(op, [a.centre, b.centre]));
            return Pair { centre, radius: None };
        }
        match op {
            // Different for sure, or it has left.
            Operator::EqF => {
                self.require_order([a, b]);
                Pair { centre: self.emit(ty, Inst::Bool(false)), radius: None }
            }
            Operator::LessF => {
                self.require_order([a, b]);
                let centre = self.emit(ty, Inst::Scalar(op, [a.centre, b.centre]));
                Pair { centre, radius: None }
            }
            Operator::Floor => self.floor(a),
            _ => {
                let centre = self.emit(ty, Inst::Scalar(op, [a.centre, b.centre]));
                let radius = self.radius_of(op, [a, b], centre);
                Pair { centre, radius: Some(radius) }
            }
        }
    }

    /// The radius of a real that an operator gives; unary ones have their operand twice.
    fn radius_of(&mut self, op: Operator, [a, b]: [Pair; 2], centre: Val) -> Val {
        let of_a = self.radius_or_zero(a);
        match op {
            // Exact, and moving numbers no further apart.
            Operator::NegF | Operator::ClampF => of_a,
            Operator::Frac => {
                self.require_whole_part(a, centre);
                of_a
            }
            Operator::AddF | Operator::SubF => {
                let spread = self.sum_of_radii([a, b]);
                self.rounded(spread, centre, HALF_UNIT)
            }
            Operator::MulF => {
                let spread = self.spread_of_product(a, b);
                self.rounded(spread, centre, HALF_UNIT)
            }
            Operator::DivF => {
                let spread = self.spread_of_quotient(a, b, centre);
                self.rounded(spread, centre, HALF_UNIT)
            }
            Operator::Sqrt => {
                let spread = self.spread_of_root(a, centre);
                self.rounded(spread, centre, HALF_UNIT)
            }
            // |sin x - sin y| <= |x - y| in radians.
            Operator::Sin | Operator::Cos => {
                let factor = self.real(RADIANS_PER_DEGREE);
                let spread = self.mul(of_a, factor);
                self.rounded(spread, centre, UNIT)
            }
            Operator::Asin | Operator::Acos => {
                let spread = self.spread_of_arc(a);
                self.rounded(spread, centre, UNIT)
            }
            _ => unreachable!("{op:?} gives no real that depends on reals"),
        }
    }

    /// The radius of a result with this spread and centre; `relative_error` is that of the operation.
    fn rounded(&mut self, spread: Val, centre: Val, relative_error: f64) -> Val {
        let size = self.abs(centre);
        let (large, twice) = (self.real(LARGE), self.real(2.0 * relative_error / LARGE));
        let (tiny, inflation) = (self.real(TINY), self.real(INFLATION));
        let scaled = self.mul(size, large);
        let rounding = self.mul(scaled, twice);
        let rounding = self.add(rounding, tiny);
        let sum = self.add(spread, rounding);
        self.mul(sum, inflation)
    }

    /// |(a + x)(b + y) - a b| <= (|b| + |y|) |x| + |a| |y|.
    fn spread_of_product(&mut self, a: Pair, b: Pair) -> Val {
        let (a, b) = if a.radius.is_none() { (b, a) } else { (a, b) };
        let of_a = self.radius_or_zero(a);
        let size = self.abs(b.centre);
        let Some(of_b) = b.radius else { return self.mul(size, of_a) };
        let reach = self.add(size, of_b);
        let by_a = self.mul(reach, of_a);
        let size = self.abs(a.centre);
        let by_b = self.mul(size, of_b);
        self.add(by_a, by_b)
    }

    /// |(a + x)/(b + y) - a/b| = |x - (a/b) y| / |b + y| <= (|x| + |a/b| |y|) / (|b| - |y|), where
    /// that is positive. An underflow above the bar, or of the quotient, would be magnified by what is
    /// below it.
    fn spread_of_quotient(&mut self, a: Pair, b: Pair, quotient: Val) -> Val {
        let of_a = self.radius_or_zero(a);
        let size = self.abs(b.centre);
        let Some(of_b) = b.radius else { return self.div(of_a, size) };
        let (zero, tiny) = (self.real(0.0), self.real(TINY));
        let least = self.sub(size, of_b);
        self.require(Relation::Less, zero, least);
        let quotient = self.abs(quotient);
        let quotient = self.add(quotient, tiny);
        let by_b = self.mul(quotient, of_b);
        let by_a = self.add(of_a, tiny);
        let sum = self.add(by_a, by_b);
        self.div(sum, least)
    }

    /// Where x <= a, so that a - x has a root: |sqrt(a + y) - sqrt(a)| <= x / (sqrt(a) + sqrt(a - x))
    /// for |y| <= x, and sqrt(a - x) >= sqrt(a) - x / sqrt(a), as 1 - z <= sqrt(1 - z). The sum below
    /// the bar is from one to two times sqrt(a), and nothing is lost in it.
    fn spread_of_root(&mut self, a: Pair, root: Val) -> Val {
        let of_a = self.radius_or_zero(a);
        self.require(Relation::Less, of_a, a.centre);
        let less = self.div(of_a, root);
        let twice = self.add(root, root);
        let sum = self.sub(twice, less);
        self.div(of_a, sum)
    }

    /// The slope of arc sine and arc cosine at x is 180/pi / sqrt(1 - x^2), and greatest at the end of
    /// the interval. Inflated, the end is not below the exact one.
    fn spread_of_arc(&mut self, a: Pair) -> Val {
        let of_a = self.radius_or_zero(a);
        let (one, inflation) = (self.real(1.0), self.real(INFLATION));
        let size = self.abs(a.centre);
        let end = self.add(size, of_a);
        let end = self.mul(end, inflation);
        self.require(Relation::Less, end, one);
        let (below, above) = (self.sub(one, end), self.add(one, end));
        let product = self.mul(below, above);
        let root = self.emit(Type::Real, Inst::Scalar(Operator::Sqrt, [product; 2]));
        let factor = self.real(DEGREES_PER_RADIAN);
        let scaled = self.mul(of_a, factor);
        self.div(scaled, root)
    }

    /// Leaves unless a < b at all points or at none, and a = b at none: they are further apart than
    /// both radii together. The inflation makes up for the rounding of both sides. Numbers so small
    /// that it has no effect are added and subtracted exactly.
    fn require_order(&mut self, [a, b]: [Pair; 2]) {
        let reach = self.sum_of_radii([a, b]);
        let reach = self.inflated(reach);
        let difference = self.sub(a.centre, b.centre);
        let distance = self.abs(difference);
        self.require(Relation::Less, reach, distance);
    }

    /// The whole part f below, if it is that at all points: x <= a - f and x < (f + 1) - a for the
    /// radius x. Where `f + 1` rounds, a is f, so that only a radius of 0 passes. The differences round at most once, for which the inflation makes up.
    fn floor(&mut self, a: Pair) -> Pair {
        let of_a = self.radius_or_zero(a);
        let whole = self.emit(Type::Int, Inst::Scalar(Operator::Floor, [a.centre; 2]));
        let below = self.emit(Type::Real, Inst::Scalar(Operator::RealOf, [whole; 2]));
        let reach = self.inflated(of_a);
        let part = self.sub(a.centre, below);
        self.require(Relation::AtMost, reach, part);
        let one = self.real(1.0);
        let next = self.add(below, one);
        let rest = self.sub(next, a.centre);
        self.require(Relation::Less, reach, rest);
        Pair { centre: whole, radius: None }
    }

    /// Leaves unless the part of a before the point is the same at all points. `part` is the one
    /// behind it, which is exact. If the former is 0, then |a| + x < 1 for the radius x; otherwise
    /// |part| must not reach down to 0 either.
    fn require_whole_part(&mut self, a: Pair, part: Val) {
        let of_a = self.radius_or_zero(a);
        let reach = self.inflated(of_a);
        let (zero, one) = (self.real(0.0), self.real(1.0));
        let size = self.abs(part);
        let rest = self.sub(one, size);
        self.require(Relation::Less, reach, rest);
        let whole = self.sub(a.centre, part);
        let is_zero = self.emit(Type::Bool, Inst::Scalar(Operator::EqF, [whole, zero]));
        let is_zero = self.emit(Type::Int, Inst::IntOfBool(is_zero));
        let is_zero = self.emit(Type::Real, Inst::Scalar(Operator::RealOf, [is_zero; 2]));
        // Greater than what has passed, if the whole part is 0.
        let limit = self.add(size, is_zero);
        self.require(Relation::AtMost, reach, limit);
    }

    fn sum_of_radii(&mut self, [a, b]: [Pair; 2]) -> Val {
        match (a.radius, b.radius) {
            (Some(of_a), Some(of_b)) => self.add(of_a, of_b),
            (Some(radius), None) | (None, Some(radius)) => radius,
            (None, None) => self.real(0.0),
        }
    }

    fn radius_or_zero(&mut self, pair: Pair) -> Val {
        pair.radius.unwrap_or_else(|| self.real(0.0))
    }

    fn inflated(&mut self, radius: Val) -> Val {
        let inflation = self.real(INFLATION);
        self.mul(radius, inflation)
    }

    fn require(&mut self, relation: Relation, a: Val, b: Val) {
        self.emit(Type::Real, Inst::Require(relation, [a, b]));
    }

    fn abs(&mut self, a: Val) -> Val {
        self.emit(Type::Real, Inst::Abs(a))
    }

    fn add(&mut self, a: Val, b: Val) -> Val {
        self.emit(Type::Real, Inst::Scalar(Operator::AddF, [a, b]))
    }

    fn sub(&mut self, a: Val, b: Val) -> Val {
        self.emit(Type::Real, Inst::Scalar(Operator::SubF, [a, b]))
    }

    fn mul(&mut self, a: Val, b: Val) -> Val {
        self.emit(Type::Real, Inst::Scalar(Operator::MulF, [a, b]))
    }

    fn div(&mut self, a: Val, b: Val) -> Val {
        self.emit(Type::Real, Inst::Scalar(Operator::DivF, [a, b]))
    }
}
