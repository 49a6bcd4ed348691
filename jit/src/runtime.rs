//! Functions that native code calls: those of the interpreter, so that the bits agree.

use compiler::degrees;
use compiler::op::Operator;

/// A function of one real, by the platform's C convention.
pub(crate) type RealFn = extern "C" fn(f64) -> f64;

extern "C" fn sin(angle: f64) -> f64 {
    degrees::sin(angle)
}

extern "C" fn cos(angle: f64) -> f64 {
    degrees::cos(angle)
}

extern "C" fn asin(x: f64) -> f64 {
    degrees::asin(x)
}

extern "C" fn acos(x: f64) -> f64 {
    degrees::acos(x)
}

/// All functions that native code calls, by operator.
pub(crate) fn functions() -> impl Iterator<Item = (Operator, RealFn)> {
    Operator::ALL.iter().filter_map(|&op| Some((op, function(op)?)))
}

/// The function that performs an operator, if native code calls one for it.
pub(crate) fn function(op: Operator) -> Option<RealFn> {
    Some(match op {
        Operator::Sin => sin,
        Operator::Cos => cos,
        Operator::Asin => asin,
        Operator::Acos => acos,
        _ => return None,
    })
}
