//! What each scalar operator computes: the one place that says so.
//!
//! The interpreter, the constant folder and the documentation are views of these functions, which
//! the rows of [`for_each_scalar!`](crate::for_each_scalar) name. They are deterministic to the
//! last bit: only IEEE 754 basic operations, square root, fused multiply-add and the pure-Rust
//! `libm` are used, none of which depends on the CPU or the C library.

use crate::op::Operator;

/// A point or a colour: x, y, z.
pub type Point = [f64; 3];

/// A scalar operator has no result for its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The result does not fit in 64 bits.
    IntegerOverflow,
    /// `divi` or `modi` by 0.
    DivisionByZero,
    /// `sqrt` of a negative real.
    NegativeRoot,
    /// `floor` of NaN, an infinity, or a real beyond 64-bit integers.
    FloorRange,
}

type Scalar<T> = Result<T, Fault>;

macro_rules! functions {
    ($(fn $name:ident($($x:ident: $t:ty),+) -> $r:ty = $body:expr;)*) => {
        $(
            #[inline]
            #[doc = concat!("The meaning of the operator row that names `", stringify!($name), "`.")]
            ///
            /// # Errors
            /// The [`Fault`]s that the operator's documentation names.
            pub fn $name($($x: $t),+) -> Scalar<$r> { $body }
        )*
    };
}

functions! {
    fn neg_i(a: i64) -> i64 = a.checked_neg().ok_or(Fault::IntegerOverflow);
    fn neg_f(a: f64) -> f64 = Ok(-a);
    fn frac(a: f64) -> f64 = Ok((a - a.trunc()).copysign(a));
    fn real(a: i64) -> f64 = Ok(a as f64);
    fn clamp_f(a: f64) -> f64 = Ok(a.clamp(0.0, 1.0));
    fn sqrt(a: f64) -> f64 = if a < 0.0 { Err(Fault::NegativeRoot) } else { Ok(a.sqrt()) };
    fn sin(a: f64) -> f64 = Ok(crate::degrees::sin(a));
    fn cos(a: f64) -> f64 = Ok(crate::degrees::cos(a));
    fn asin(a: f64) -> f64 = Ok(crate::degrees::asin(a));
    fn acos(a: f64) -> f64 = Ok(crate::degrees::acos(a));
    fn get_x(p: Point) -> f64 = Ok(p[0]);
    fn get_y(p: Point) -> f64 = Ok(p[1]);
    fn get_z(p: Point) -> f64 = Ok(p[2]);
    fn add_i(a: i64, b: i64) -> i64 = a.checked_add(b).ok_or(Fault::IntegerOverflow);
    fn add_f(a: f64, b: f64) -> f64 = Ok(a + b);
    fn sub_i(a: i64, b: i64) -> i64 = a.checked_sub(b).ok_or(Fault::IntegerOverflow);
    fn sub_f(a: f64, b: f64) -> f64 = Ok(a - b);
    fn mul_i(a: i64, b: i64) -> i64 = a.checked_mul(b).ok_or(Fault::IntegerOverflow);
    fn mul_f(a: f64, b: f64) -> f64 = Ok(a * b);
    fn div_i(a: i64, b: i64) -> i64 = if b == 0 {
        Err(Fault::DivisionByZero)
    } else {
        a.checked_div(b).ok_or(Fault::IntegerOverflow)
    };
    fn div_f(a: f64, b: f64) -> f64 = Ok(a / b);
    // The remainder of MIN by -1 is 0: only its quotient overflows.
    fn mod_i(a: i64, b: i64) -> i64 = if b == 0 {
        Err(Fault::DivisionByZero)
    } else {
        Ok(a.wrapping_rem(b))
    };
    fn eq_i(a: i64, b: i64) -> bool = Ok(a == b);
    fn eq_f(a: f64, b: f64) -> bool = Ok(a == b);
    fn less_i(a: i64, b: i64) -> bool = Ok(a < b);
    fn less_f(a: f64, b: f64) -> bool = Ok(a < b);
    fn point(x: f64, y: f64, z: f64) -> Point = Ok([x, y, z]);
}

/// The meaning of `floor`.
///
/// # Errors
/// [`Fault::FloorRange`] for NaN, infinities and reals whose whole part 64 bits cannot hold.
#[inline]
pub fn floor(a: f64) -> Scalar<i64> {
    let below = a.floor();
    // 2^63 is a double, the greatest i64 is not: hence one closed and one open end.
    const TWO_63: f64 = 9_223_372_036_854_775_808.0;
    if (-TWO_63..TWO_63).contains(&below) { Ok(below as i64) } else { Err(Fault::FloorRange) }
}

/// Values that scalar operators take and give.
pub trait Operands: Sized {
    /// A boolean result.
    fn from_bool(value: bool) -> Self;
    /// An integer result.
    fn from_int(value: i64) -> Self;
    /// A real result.
    fn from_real(value: f64) -> Self;
    /// A point result.
    fn from_point(value: Point) -> Self;
    /// The integer, if it is one.
    fn as_int(&self) -> Option<i64>;
    /// The real, if it is one.
    fn as_real(&self) -> Option<f64>;
    /// The point, if it is one.
    fn as_point(&self) -> Option<Point>;
}

/// Reads an operand of the type that an operator row names.
#[macro_export]
macro_rules! scalar_operand {
    (Int, $value:expr) => {
        $crate::scalar::Operands::as_int($value)
    };
    (Real, $value:expr) => {
        $crate::scalar::Operands::as_real($value)
    };
    (Point, $value:expr) => {
        $crate::scalar::Operands::as_point($value)
    };
}

/// Makes a value of the type that an operator row names.
#[macro_export]
macro_rules! scalar_result {
    (Bool, $value:expr) => {
        $crate::scalar::Operands::from_bool($value)
    };
    (Int, $value:expr) => {
        $crate::scalar::Operands::from_int($value)
    };
    (Real, $value:expr) => {
        $crate::scalar::Operands::from_real($value)
    };
    (Point, $value:expr) => {
        $crate::scalar::Operands::from_point($value)
    };
}

macro_rules! define_evaluate {
    ([] unary { $($(#[$ud:meta])+ $u:ident $us:literal $uf:ident($ut:ident) -> $ur:ident;)* }
      binary { $($(#[$bd:meta])+ $b:ident $bk:ident $bs:literal $bf:ident($bt:ident, $bt2:ident) -> $br:ident;)* }
      compare { $($(#[$cd:meta])+ $c:ident $ck:ident $cj:ident $cjk:ident $cs:literal $cf:ident($ct:ident, $ct2:ident) -> $cr:ident;)* }
      ternary { $($(#[$td:meta])+ $t:ident $ts:literal $tf:ident($tt:ident, $tt2:ident, $tt3:ident) -> $tr:ident;)* }) => {
        /// Applies a scalar operator to as many operands as it takes, bottom first.
        ///
        /// `None` when it is no scalar operator or an operand has the wrong type.
        pub fn evaluate<V: Operands>(op: Operator, operands: &[V]) -> Option<Scalar<V>> {
            match (op, operands) {
                $((Operator::$u, [a]) =>
                    Some($uf(scalar_operand!($ut, a)?).map(|r| scalar_result!($ur, r))),)*
                $((Operator::$b, [a, b]) =>
                    Some($bf(scalar_operand!($bt, a)?, scalar_operand!($bt2, b)?).map(|r| scalar_result!($br, r))),)*
                $((Operator::$c, [a, b]) =>
                    Some($cf(scalar_operand!($ct, a)?, scalar_operand!($ct2, b)?).map(|r| scalar_result!($cr, r))),)*
                $((Operator::$t, [a, b, c]) => Some(
                    $tf(scalar_operand!($tt, a)?, scalar_operand!($tt2, b)?, scalar_operand!($tt3, c)?)
                        .map(|r| scalar_result!($tr, r))),)*
                _ => None,
            }
        }
    };
}

crate::for_each_scalar!(define_evaluate, []);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integer_division_truncates_and_the_remainder_follows_the_dividend() {
        assert_eq!((div_i(-7, 2), mod_i(-7, 2), mod_i(7, -2)), (Ok(-3), Ok(-1), Ok(1)));
        assert_eq!(div_i(i64::MIN, -1), Err(Fault::IntegerOverflow));
        assert_eq!(mod_i(i64::MIN, -1), Ok(0));
        assert_eq!(div_i(1, 0), Err(Fault::DivisionByZero));
        assert_eq!(neg_i(i64::MIN), Err(Fault::IntegerOverflow));
    }

    #[test]
    fn floor_and_frac_round_as_specified() {
        assert_eq!((floor(-0.5), floor(-2.25), frac(-2.25)), (Ok(-1), Ok(-3), Ok(-0.25)));
        assert_eq!(floor(-9_223_372_036_854_775_808.0), Ok(i64::MIN));
        for beyond in [9_223_372_036_854_775_808.0, f64::NAN, f64::INFINITY, -1e300] {
            assert_eq!(floor(beyond), Err(Fault::FloorRange), "{beyond}");
        }
    }

    #[test]
    fn sqrt_of_minus_zero_is_fine() {
        assert_eq!(sqrt(-0.0).map(f64::to_bits), Ok((-0.0f64).to_bits()));
        assert_eq!(sqrt(-1e-300), Err(Fault::NegativeRoot));
    }
}
