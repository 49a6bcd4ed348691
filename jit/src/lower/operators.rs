//! Scalar operators: what `compiler::scalar` computes, as instructions.

use compiler::op::Operator;
use cranelift_codegen::ir::condcodes::{FloatCC, IntCC};
use cranelift_codegen::ir::immediates::Ieee64;
use cranelift_codegen::ir::{self, AbiParam, InstBuilder, Signature, types};

use crate::lower::Lowering;
use crate::runtime;

/// The sign bit of a real.
const SIGN: u64 = 1 << 63;
const N_SIGN_AND_EXPONENT_BITS: u32 = 12;

/// 1 over a power of two, where that is exact and a normal number: what is divided by the one is what
/// is multiplied by the other.
fn exact_inverse(divisor: Ieee64) -> Option<Ieee64> {
    let divisor = f64::from_bits(divisor.bits());
    let inverse = 1.0 / divisor;
    let is_power = divisor.is_normal() && divisor.to_bits() << N_SIGN_AND_EXPONENT_BITS == 0;
    (is_power && inverse.is_normal()).then(|| Ieee64::with_float(inverse))
}

impl Lowering<'_, '_> {
    pub(super) fn scalar(&mut self, op: Operator, a: ir::Value, b: ir::Value) -> ir::Value {
        if let Some(function) = runtime::function(op) {
            return self.call(function, a);
        }
        match op {
            Operator::AddF => {
                let [a, b] = self.constant_last([a, b]);
                self.builder.ins().fadd(a, b)
            }
            Operator::SubF => {
                let a = self.in_register(a);
                self.builder.ins().fsub(a, b)
            }
            Operator::MulF => self.multiply_reals(a, b),
            Operator::DivF => match self.constant(b).and_then(exact_inverse) {
                Some(inverse) => {
                    let inverse = self.builder.ins().f64const(inverse);
                    self.multiply_reals(a, inverse)
                }
                None => {
                    let a = self.in_register(a);
                    self.builder.ins().fdiv(a, b)
                }
            },
            Operator::NegF => self.builder.ins().fneg(a),
            Operator::EqF => {
                let [a, b] = self.constant_last([a, b]);
                self.builder.ins().fcmp(FloatCC::Equal, a, b)
            }
            // On x86-64 this is a comparison of b with a, of which only a may be read from memory.
            Operator::LessF => {
                let b = self.in_register(b);
                self.builder.ins().fcmp(FloatCC::LessThan, a, b)
            }
            Operator::EqI => self.builder.ins().icmp(IntCC::Equal, a, b),
            Operator::LessI => self.builder.ins().icmp(IntCC::SignedLessThan, a, b),
            Operator::RealOf => self.builder.ins().fcvt_from_sint(types::F64, a),
            Operator::Frac => self.frac(a),
            Operator::ClampF => self.clamp(a),
            Operator::Sqrt => {
                let zero = self.builder.ins().f64const(0.0);
                let is_negative = self.builder.ins().fcmp(FloatCC::LessThan, a, zero);
                self.leave_if(is_negative);
                self.builder.ins().sqrt(a)
            }
            Operator::Floor => self.floor(a),
            Operator::AddI | Operator::SubI => self.add_or_sub(op, a, b),
            Operator::MulI => self.multiply(a, b),
            Operator::NegI => {
                let is_least = self.builder.ins().icmp_imm_s(IntCC::Equal, a, i64::MIN);
                self.leave_if(is_least);
                self.builder.ins().ineg(a)
            }
            Operator::DivI | Operator::ModI => self.divide(op, a, b),
            _ => unreachable!("the specializer performs {op:?} itself"),
        }
    }

    /// A sum takes less time than a product, and twice a number is both.
    fn multiply_reals(&mut self, a: ir::Value, b: ir::Value) -> ir::Value {
        let [a, b] = self.constant_last([a, b]);
        if self.constant(b) == Some(Ieee64::with_float(2.0)) {
            self.builder.ins().fadd(a, a)
        } else {
            self.builder.ins().fmul(a, b)
        }
    }

    fn call(&mut self, function: runtime::RealFn, argument: ir::Value) -> ir::Value {
        let mut signature = Signature::new(self.call_conv);
        signature.params.push(AbiParam::new(types::F64));
        signature.returns.push(AbiParam::new(types::F64));
        let signature = self.builder.import_signature(signature);
        // An absolute address needs no relocation, however far away the code lies.
        let address = self.builder.ins().iconst(self.pointer, function as usize as i64);
        let call = self.builder.ins().call_indirect(signature, address, &[argument]);
        self.builder.inst_results(call)[0]
    }

    fn clamp(&mut self, a: ir::Value) -> ir::Value {
        let zero = self.builder.ins().f64const(0.0);
        let one = self.builder.ins().f64const(1.0);
        let one = self.in_register(one);
        // Cranelift knows selections in this form as the minimum and the maximum of two.
        let is_above = self.builder.ins().fcmp(FloatCC::LessThan, one, a);
        let at_most_one = self.builder.ins().select(is_above, one, a);
        let is_below = self.builder.ins().fcmp(FloatCC::LessThan, at_most_one, zero);
        self.builder.ins().select(is_below, zero, at_most_one)
    }

    /// What is left of a number without its whole part has its sign, unless it is 0: that gets it here.
    /// Of an infinity it is NaN, whose sign may differ from the interpreter's: any NaN is any other.
    fn frac(&mut self, a: ir::Value) -> ir::Value {
        let whole = self.builder.ins().trunc(a);
        let part = self.builder.ins().fsub(a, whole);
        let mask = self.builder.ins().f64const(Ieee64::with_bits(SIGN));
        let mask = self.in_register(mask);
        let sign = self.builder.ins().band(a, mask);
        self.builder.ins().bor(part, sign)
    }

    /// All but the sign.
    pub(super) fn abs(&mut self, a: ir::Value) -> ir::Value {
        let mask = self.builder.ins().f64const(Ieee64::with_bits(!SIGN));
        let mask = self.in_register(mask);
        self.builder.ins().band(a, mask)
    }

    fn floor(&mut self, a: ir::Value) -> ir::Value {
        let below = self.builder.ins().floor(a);
        let low = self.builder.ins().f64const(-9_223_372_036_854_775_808.0);
        let high = self.builder.ins().f64const(9_223_372_036_854_775_808.0);
        // NaN leaves as what is too low. Each comparison is one instruction that reads its bound.
        let is_low = self.builder.ins().fcmp(FloatCC::UnorderedOrLessThan, below, low);
        self.leave_if(is_low);
        let is_high = self.builder.ins().fcmp(FloatCC::GreaterThanOrEqual, below, high);
        self.leave_if(is_high);
        self.builder.ins().fcvt_to_sint_sat(types::I64, below)
    }

    fn add_or_sub(&mut self, op: Operator, a: ir::Value, b: ir::Value) -> ir::Value {
        // It overflows if the result's sign differs from both operands' (of -b, for a - b).
        let (result, other_sign) = if op == Operator::AddI {
            let result = self.builder.ins().iadd(a, b);
            (result, self.builder.ins().bxor(b, result))
        } else {
            let result = self.builder.ins().isub(a, b);
            (result, self.builder.ins().bxor(a, b))
        };
        let sign = self.builder.ins().bxor(a, result);
        let both = self.builder.ins().band(sign, other_sign);
        let overflows = self.builder.ins().icmp_imm_s(IntCC::SignedLessThan, both, 0);
        self.leave_if(overflows);
        result
    }

    fn multiply(&mut self, a: ir::Value, b: ir::Value) -> ir::Value {
        let low = self.builder.ins().imul(a, b);
        let high = self.builder.ins().smulhi(a, b);
        let sign = self.builder.ins().sshr_imm_s(low, 63);
        let overflows = self.builder.ins().icmp(IntCC::NotEqual, high, sign);
        self.leave_if(overflows);
        low
    }

    fn divide(&mut self, op: Operator, a: ir::Value, b: ir::Value) -> ir::Value {
        // By 0 there is no result, and by -1 it may overflow: -1 <= b <= 0, moved to start at 0.
        let moved = self.builder.ins().iadd_imm_s(b, 1);
        let is_special = self.builder.ins().icmp_imm_s(IntCC::UnsignedLessThanOrEqual, moved, 1);
        self.leave_if(is_special);
        if op == Operator::DivI {
            self.builder.ins().sdiv(a, b)
        } else {
            self.builder.ins().srem(a, b)
        }
    }
}
