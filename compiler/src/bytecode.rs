//! Bytecode: fixed-width register instructions, with all that is not code in side tables.
//!
//! A function owns up to 256 registers. Within a function, operands live in registers; only what
//! crosses a call goes over the operand stack. All jumps go forward, so an activation executes each
//! instruction at most once: loops are calls in tail position. `docs/bytecode.md` has the full
//! description; the rows of `for_each_control!` and [`for_each_scalar!`](crate::for_each_scalar)
//! are its source.

use std::sync::Arc;

use crate::op::{Operator, Type};
use crate::scalar::{Operands, Point};
use crate::source::Span;

/// One instruction: eight bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Insn {
    /// What to do.
    pub op: Opcode,
    /// Mostly the register for the result.
    pub a: u8,
    /// Mostly the register of the first operand.
    pub b: u8,
    /// Mostly the register of the second operand.
    pub c: u8,
    /// Index of a constant, a capture, a function or a slot; or the distance of a forward jump,
    /// counted from the next instruction.
    pub imm: u32,
}

/// How the fields of an instruction are used and shown; `r` is a register, `k` a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// No fields.
    None,
    /// `r[a]`.
    A,
    /// `r[a] r[b]`.
    AB,
    /// `r[a] r[b] r[c]`.
    ABC,
    /// `r[a] r[b] r[c] r[imm]`.
    ABCRegister,
    /// `r[a] k[imm]`.
    AConstant,
    /// `k[imm]`.
    Constant,
    /// `r[a] r[b] k[imm]`.
    ABConstant,
    /// `r[a]`, captured value `imm`.
    ACapture,
    /// `r[a]`, slot `imm`.
    ASlot,
    /// `r[a]`, function `imm`.
    AFunction,
    /// `r[a]`, number `imm`.
    ACount,
    /// `r[a]` to `r[a + b - 1]`.
    Range,
    /// Jump by `imm`.
    Jump,
    /// `r[a]`, jump by `imm`.
    AJump,
    /// `r[a] r[b]`, jump by `imm`.
    ABJump,
    /// `r[a] k[b]`, jump by `imm`.
    AKJump,
    /// `r[a]`, operator `b`.
    AOperator,
}

/// The instructions that are not scalar operators: name, format, documentation.
#[macro_export]
macro_rules! for_each_control {
    ($then:ident, [$($extra:tt)*]) => {
        $then! {
            [$($extra)*]
            control {
                /// `r[a] = k[imm]`
                Load AConstant;
                /// `r[a] =` captured value `imm` of the running closure
                Capture ACapture;
                /// `r[a] = r[b]`
                Move AB;
                /// `slot[imm] = r[a]`; slots hold the bindings for which there are no registers
                Spill ASlot;
                /// `r[a] = slot[imm]`
                Unspill ASlot;
                /// Pushes `r[a]` on the operand stack
                Push A;
                /// Pushes `r[a]`, then `r[b]`
                Push2 AB;
                /// Pushes `r[a]`, `r[b]`, then `r[c]`
                Push3 ABC;
                /// Pushes `k[imm]`
                PushConstant Constant;
                /// Pops `b` values (1 to 3) into `r[a]`, `r[a+1]`, ..., topmost first
                Pop Range;
                /// `r[a] =` a closure of function `imm`, which lists what it captures
                MakeClosure AFunction;
                /// Puts a floor under the operand stack: what is below is out of reach
                BeginArray None;
                /// `r[a] =` an array of all that is above the floor; the former floor returns
                EndArray A;
                /// `r[a] =` an array of the topmost `imm` values of the operand stack
                MakeArray ACount;
                /// `r[a] = r[b]` at index `r[c]`
                Get ABC;
                /// `r[a] =` number of elements of `r[b]`
                Length AB;
                /// Calls the closure `r[a]`
                Apply A;
                /// Calls the closure `r[a]` in place of the running one
                TailApply A;
                /// Ends the call
                Return None;
                /// `r[imm] = r[a] ? r[b] : r[c]`, all checked: a boolean and two closures
                Choose ABCRegister;
                /// Jumps
                Jump Jump;
                /// Jumps if the boolean `r[a]` is false
                JumpUnless AJump;
                /// Stops: the name `k[imm]` is not bound
                Unbound Constant;
                /// `r[a] =` result of an operator on objects and lights, operands from the operand stack
                Operate AOperator;
            }
        }
    };
}

macro_rules! opcode_enum {
    ([control { $($(#[doc = $kd:literal])+ $k:ident $kf:ident;)* }]
      unary { $($(#[doc = $ud:literal])+ $u:ident $us:literal $uf:ident($ut:ident) -> $ur:ident;)* }
      binary { $($(#[doc = $bd:literal])+ $b:ident $bk:ident $bs:literal $bf:ident($bt:ident, $bt2:ident) -> $br:ident;)* }
      compare { $($(#[doc = $cd:literal])+ $c:ident $ck:ident $cj:ident $cjk:ident $cs:literal $cf:ident($ct:ident, $ct2:ident) -> $cr:ident;)* }
      ternary { $($(#[doc = $td:literal])+ $t:ident $ts:literal $tf:ident($tt:ident, $tt2:ident, $tt3:ident) -> $tr:ident;)* }) => {
        /// What an instruction does. For scalar operators: the row's name on registers, with `K` on
        /// a register and a constant, with `JumpUnless` a comparison and a jump in one.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum Opcode {
            $($(#[doc = $kd])+ $k,)*
            $($(#[doc = $ud])+ $u,)*
            $($(#[doc = $bd])+ $b, #[doc = "The same, second operand constant."] $bk,)*
            $($(#[doc = $cd])+ $c, #[doc = "The same, second operand constant."] $ck,
              #[doc = "Compares `r[a]` and `r[b]` and jumps if the answer is no."] $cj,
              #[doc = "Compares `r[a]` and `k[b]` and jumps if the answer is no."] $cjk,)*
            $($(#[doc = $td])+ $t,)*
        }

        impl Opcode {
            /// All opcodes.
            pub const ALL: &[Opcode] = &[
                $(Opcode::$k,)* $(Opcode::$u,)* $(Opcode::$b, Opcode::$bk,)*
                $(Opcode::$c, Opcode::$ck, Opcode::$cj, Opcode::$cjk,)* $(Opcode::$t,)*
            ];

            /// The name in disassembly.
            #[must_use]
            pub fn mnemonic(self) -> &'static str {
                match self {
                    $(Opcode::$k => stringify!($k),)* $(Opcode::$u => stringify!($u),)*
                    $(Opcode::$b => stringify!($b), Opcode::$bk => stringify!($bk),)*
                    $(Opcode::$c => stringify!($c), Opcode::$ck => stringify!($ck),
                      Opcode::$cj => stringify!($cj), Opcode::$cjk => stringify!($cjk),)*
                    $(Opcode::$t => stringify!($t),)*
                }
            }

            /// How its fields are used.
            #[must_use]
            pub fn format(self) -> Format {
                match self {
                    $(Opcode::$k => Format::$kf,)* $(Opcode::$u => Format::AB,)*
                    $(Opcode::$b => Format::ABC, Opcode::$bk => Format::ABConstant,)*
                    $(Opcode::$c => Format::ABC, Opcode::$ck => Format::ABConstant,
                      Opcode::$cj => Format::ABJump, Opcode::$cjk => Format::AKJump,)*
                    $(Opcode::$t => Format::ABCRegister,)*
                }
            }

            /// What it does, in words or as an assignment.
            #[must_use]
            pub fn doc(self) -> &'static str {
                match self {
                    $(Opcode::$k => concat!($($kd),+).trim_ascii(),)*
                    $(Opcode::$u => concat!($($ud),+).trim_ascii(),)*
                    $(Opcode::$b | Opcode::$bk => concat!($($bd),+).trim_ascii(),)*
                    $(Opcode::$c | Opcode::$ck | Opcode::$cj | Opcode::$cjk => concat!($($cd),+).trim_ascii(),)*
                    $(Opcode::$t => concat!($($td),+).trim_ascii(),)*
                }
            }

            /// The operator whose meaning the instruction has, if it is a scalar one.
            #[must_use]
            pub fn operator(self) -> Option<Operator> {
                Some(match self {
                    $(Opcode::$u => Operator::$u,)* $(Opcode::$b | Opcode::$bk => Operator::$b,)*
                    $(Opcode::$c | Opcode::$ck | Opcode::$cj | Opcode::$cjk => Operator::$c,)*
                    $(Opcode::$t => Operator::$t,)*
                    _ => return None,
                })
            }

            /// The instruction of a scalar operator on registers.
            #[must_use]
            pub fn on_registers(op: Operator) -> Option<Opcode> {
                Some(match op {
                    $(Operator::$u => Opcode::$u,)* $(Operator::$b => Opcode::$b,)*
                    $(Operator::$c => Opcode::$c,)* $(Operator::$t => Opcode::$t,)*
                    _ => return None,
                })
            }

            /// The same instruction with a constant as its second operand.
            #[must_use]
            pub fn with_constant(self) -> Option<Opcode> {
                Some(match self {
                    $(Opcode::$b => Opcode::$bk,)* $(Opcode::$c => Opcode::$ck,)*
                    _ => return None,
                })
            }

            /// The comparison fused with a jump, taken when the answer is no.
            #[must_use]
            pub fn fused_with_jump(self) -> Option<Opcode> {
                Some(match self {
                    $(Opcode::$c => Opcode::$cj, Opcode::$ck => Opcode::$cjk,)*
                    _ => return None,
                })
            }
        }
    };
}

macro_rules! with_control {
    ([] $($control:tt)*) => { $crate::for_each_scalar!(opcode_enum, [$($control)*]); };
}

for_each_control!(with_control, []);

/// A value known at compile time.
#[derive(Clone, Debug)]
pub enum Constant {
    /// A boolean.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A real.
    Real(f64),
    /// A string.
    Str(Arc<str>),
    /// A point.
    Point(Point),
    /// A function that captures nothing, by its index.
    Function(u32),
    /// An array.
    Array(Arc<ConstantArray>),
}

/// A constant array, which may be shared by others.
#[derive(Clone, Debug)]
pub struct ConstantArray {
    items: Vec<Constant>,
    nesting: usize,
}

impl ConstantArray {
    /// An array of these items.
    #[must_use]
    pub fn new(items: Vec<Constant>) -> Self {
        let inner = items.iter().map(Constant::nesting).max().unwrap_or(0);
        ConstantArray { items, nesting: inner + 1 }
    }

    /// The items.
    #[must_use]
    pub fn items(&self) -> &[Constant] {
        &self.items
    }
}

impl Constant {
    /// The type.
    #[must_use]
    pub fn type_of(&self) -> Type {
        match self {
            Constant::Bool(_) => Type::Bool,
            Constant::Int(_) => Type::Int,
            Constant::Real(_) => Type::Real,
            Constant::Str(_) => Type::Str,
            Constant::Point(_) => Type::Point,
            Constant::Function(_) => Type::Closure,
            Constant::Array(_) => Type::Array,
        }
    }

    /// How many arrays are nested in it, itself included.
    #[must_use]
    pub fn nesting(&self) -> usize {
        if let Constant::Array(array) = self { array.nesting } else { 0 }
    }
}

impl Operands for Constant {
    fn from_bool(value: bool) -> Self {
        Constant::Bool(value)
    }
    fn from_int(value: i64) -> Self {
        Constant::Int(value)
    }
    fn from_real(value: f64) -> Self {
        Constant::Real(value)
    }
    fn from_point(value: Point) -> Self {
        Constant::Point(value)
    }
    fn as_int(&self) -> Option<i64> {
        if let Constant::Int(value) = self { Some(*value) } else { None }
    }
    fn as_real(&self) -> Option<f64> {
        if let Constant::Real(value) = self { Some(*value) } else { None }
    }
    fn as_point(&self) -> Option<Point> {
        if let Constant::Point(value) = self { Some(*value) } else { None }
    }
}

/// Where a new closure finds a value to capture, in the frame of the function that creates it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CaptureSource {
    /// In a register.
    Register(u8),
    /// In a spill slot.
    Slot(u32),
    /// Among the captured values of the creator itself.
    Capture(u32),
}

/// The source text behind one instruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// The operator, name, binder or bracket.
    pub span: Span,
    /// Where the operands were written; for `Pop` what asks for each value.
    pub operands: [Span; 3],
}

/// The code of one `{ }`, or of the main program.
#[derive(Clone, Debug, Default)]
pub struct Function {
    /// The name it is bound to at once, as in `{ ... } /name`.
    pub name: Option<Arc<str>>,
    /// The source text, brackets included.
    pub span: Span,
    /// Instructions.
    pub code: Vec<Insn>,
    /// Source positions, one for each instruction.
    pub origins: Vec<Origin>,
    /// Constants, by index.
    pub constants: Vec<Constant>,
    /// What a closure of this function captures.
    pub captures: Vec<CaptureSource>,
    /// Names of the captured bindings, for listings.
    pub capture_names: Vec<Arc<str>>,
    /// Number of registers, at most 256.
    pub n_registers: u32,
    /// Number of spill slots, which lie behind the registers.
    pub n_slots: u32,
}

/// A compiled program.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// All functions; a function comes before those that create it, the main program last.
    pub functions: Vec<Function>,
}

impl Program {
    /// Index of the main program.
    #[must_use]
    pub fn main(&self) -> u32 {
        self.functions.len() as u32 - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instruction_has_eight_bytes() {
        assert_eq!(size_of::<Insn>(), 8);
    }
}
