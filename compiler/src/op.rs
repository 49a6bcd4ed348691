//! The operators of GML: one table, from which spelling, types, documentation and the bytecode of
//! the scalar operators derive.
//!
//! A row of `for_each_scalar!` names the operator, its spelling, its function in
//! [`scalar`](crate::scalar), its operand types bottom first, and its result. What a scalar operator
//! computes stands in that function and nowhere else. The other operators work on closures, arrays
//! or scenes; the virtual machine performs them, checking operands against the types given here.

use std::fmt;

/// The types of GML values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Type {
    /// `true` or `false`.
    Bool,
    /// 64-bit integer.
    Int,
    /// IEEE 754 double.
    Real,
    /// Text.
    Str,
    /// Three reals.
    Point,
    /// Code with the values it captured.
    Closure,
    /// Sequence of values.
    Array,
    /// Solid.
    Object,
    /// Light source.
    Light,
    /// Any of them.
    Any,
}

impl Type {
    /// With its article, as messages use it: `an integer`.
    #[must_use]
    pub fn with_article(self) -> &'static str {
        match self {
            Type::Bool => "a boolean",
            Type::Int => "an integer",
            Type::Real => "a real",
            Type::Str => "a string",
            Type::Point => "a point",
            Type::Closure => "a function",
            Type::Array => "an array",
            Type::Object => "an object",
            Type::Light => "a light",
            Type::Any => "a value",
        }
    }

    /// Without an article: `integer`.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.with_article().split_once(' ').map_or("value", |(_, name)| name)
    }
}

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Calls `$then!` with the rows of all scalar operators, grouped by the shape of their
/// instructions, behind any tokens given in `[ ]`.
///
/// `binary` operators exist as an instruction on two registers and as one whose second operand is
/// a constant; `compare` operators also fuse with a conditional jump, in both forms.
#[macro_export]
macro_rules! for_each_scalar {
    ($then:ident, [$($extra:tt)*]) => {
        $then! {
            [$($extra)*]
            unary {
                /// The negated integer. Overflow is an error.
                NegI "negi" neg_i(Int) -> Int;
                /// The negated real.
                NegF "negf" neg_f(Real) -> Real;
                /// The greatest integer not above the real. NaN and what 64 bits cannot hold are errors.
                Floor "floor" floor(Real) -> Int;
                /// The part behind the point, with the sign of the operand: `-2.25` gives `-0.25`.
                Frac "frac" frac(Real) -> Real;
                /// The integer as a real, rounded to nearest.
                RealOf "real" real(Int) -> Real;
                /// The real, but 0.0 where it is below and 1.0 where it is above. NaN stays NaN.
                ClampF "clampf" clamp_f(Real) -> Real;
                /// The square root. A negative operand is an error.
                Sqrt "sqrt" sqrt(Real) -> Real;
                /// The sine of an angle in degrees, exact where it is 0, ±0.5 or ±1.
                Sin "sin" sin(Real) -> Real;
                /// The cosine of an angle in degrees, exact where it is 0, ±0.5 or ±1.
                Cos "cos" cos(Real) -> Real;
                /// The angle in degrees, from -90 to 90, that has this sine. NaN outside -1 to 1.
                Asin "asin" asin(Real) -> Real;
                /// The angle in degrees, from 0 to 180, that has this cosine. NaN outside -1 to 1.
                Acos "acos" acos(Real) -> Real;
                /// The x component.
                GetX "getx" get_x(Point) -> Real;
                /// The y component.
                GetY "gety" get_y(Point) -> Real;
                /// The z component.
                GetZ "getz" get_z(Point) -> Real;
            }
            binary {
                /// The sum. Overflow is an error.
                AddI AddIK "addi" add_i(Int, Int) -> Int;
                /// The sum.
                AddF AddFK "addf" add_f(Real, Real) -> Real;
                /// The first less the second. Overflow is an error.
                SubI SubIK "subi" sub_i(Int, Int) -> Int;
                /// The first less the second.
                SubF SubFK "subf" sub_f(Real, Real) -> Real;
                /// The product. Overflow is an error.
                MulI MulIK "muli" mul_i(Int, Int) -> Int;
                /// The product.
                MulF MulFK "mulf" mul_f(Real, Real) -> Real;
                /// The quotient, rounded toward 0. A divisor of 0 and overflow are errors.
                DivI DivIK "divi" div_i(Int, Int) -> Int;
                /// The quotient, as IEEE 754 has it: by 0.0 an infinity or NaN.
                DivF DivFK "divf" div_f(Real, Real) -> Real;
                /// The remainder of `divi`, with the sign of the first. A divisor of 0 is an error.
                ModI ModIK "modi" mod_i(Int, Int) -> Int;
            }
            compare {
                /// Whether two integers are equal.
                EqI EqIK JumpUnlessEqI JumpUnlessEqIK "eqi" eq_i(Int, Int) -> Bool;
                /// Whether two reals are equal: NaN equals nothing, -0.0 equals 0.0.
                EqF EqFK JumpUnlessEqF JumpUnlessEqFK "eqf" eq_f(Real, Real) -> Bool;
                /// Whether the first integer is less than the second.
                LessI LessIK JumpUnlessLessI JumpUnlessLessIK "lessi" less_i(Int, Int) -> Bool;
                /// Whether the first real is less than the second; false for NaN.
                LessF LessFK JumpUnlessLessF JumpUnlessLessFK "lessf" less_f(Real, Real) -> Bool;
            }
            ternary {
                /// The point with these x, y and z.
                Point "point" point(Real, Real, Real) -> Point;
            }
        }
    };
}

/// The operators that the virtual machine performs itself: name, spelling, operands, results.
macro_rules! for_each_other {
    ($then:ident, [$($extra:tt)*]) => {
        $then! {
            [$($extra)*]
            /// Runs a function on the stack as it is.
            Apply "apply" (Closure) -> ();
            /// Runs the first function if the boolean is true, the second otherwise.
            If "if" (Bool Closure Closure) -> ();
            /// The array's element with this index, from 0. An index out of range is an error.
            Get "get" (Array Int) -> (Any);
            /// The number of elements.
            Length "length" (Array) -> (Int);
            /// The unit sphere around the origin.
            Sphere "sphere" (Closure) -> (Object);
            /// The cube from the origin to (1, 1, 1).
            Cube "cube" (Closure) -> (Object);
            /// The cylinder of radius 1 around the y axis from y = 0 to y = 1.
            Cylinder "cylinder" (Closure) -> (Object);
            /// The cone with its apex at the origin and a base of radius 1 at y = 1.
            Cone "cone" (Closure) -> (Object);
            /// The half-space y <= 0.
            Plane "plane" (Closure) -> (Object);
            /// The object, moved by (x, y, z).
            Translate "translate" (Object Real Real Real) -> (Object);
            /// The object, scaled along x, y and z. A factor of 0 is an error.
            Scale "scale" (Object Real Real Real) -> (Object);
            /// The object, scaled alike in all directions. A factor of 0 is an error.
            UScale "uscale" (Object Real) -> (Object);
            /// The object, turned around the x axis by degrees, y toward z.
            RotateX "rotatex" (Object Real) -> (Object);
            /// The object, turned around the y axis by degrees, z toward x.
            RotateY "rotatey" (Object Real) -> (Object);
            /// The object, turned around the z axis by degrees, x toward y.
            RotateZ "rotatez" (Object Real) -> (Object);
            /// A light infinitely far away: the direction its light travels in, and its colour.
            Light "light" (Point Point) -> (Light);
            /// A light at a position, with a colour.
            PointLight "pointlight" (Point Point) -> (Light);
            /// A light at a position, aimed at a point, with a colour, a cutoff in degrees and an exponent.
            SpotLight "spotlight" (Point Point Point Real Real) -> (Light);
            /// The points in either object.
            Union "union" (Object Object) -> (Object);
            /// The points in both objects.
            Intersect "intersect" (Object Object) -> (Object);
            /// The points in the first object but not in the second.
            Difference "difference" (Object Object) -> (Object);
            /// Renders an image: ambient light, lights, (Chicago dialect: attenuation,) object, depth, field of view, width, height, file name.
            Render "render" (Point Array Object Int Real Int Int Str) -> ();
        }
    };
}

macro_rules! operator_enum {
    ([unary { $($(#[doc = $ud:literal])+ $u:ident $us:literal $uf:ident($ut:ident) -> $ur:ident;)* }
      binary { $($(#[doc = $bd:literal])+ $b:ident $bk:ident $bs:literal $bf:ident($bt:ident, $bt2:ident) -> $br:ident;)* }
      compare { $($(#[doc = $cd:literal])+ $c:ident $ck:ident $cj:ident $cjk:ident $cs:literal $cf:ident($ct:ident, $ct2:ident) -> $cr:ident;)* }
      ternary { $($(#[doc = $td:literal])+ $t:ident $ts:literal $tf:ident($tt:ident, $tt2:ident, $tt3:ident) -> $tr:ident;)* }]
     $($(#[doc = $od:literal])+ $o:ident $os:literal ($($ot:ident)*) -> ($($or:ident)*);)*) => {
        /// The 50 operators.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum Operator {
            $($(#[doc = $ud])+ $u,)*
            $($(#[doc = $bd])+ $b,)*
            $($(#[doc = $cd])+ $c,)*
            $($(#[doc = $td])+ $t,)*
            $($(#[doc = $od])+ $o,)*
        }

        impl Operator {
            /// All operators, in the order of the table.
            pub const ALL: &[Operator] = &[
                $(Operator::$u,)* $(Operator::$b,)* $(Operator::$c,)* $(Operator::$t,)* $(Operator::$o,)*
            ];

            /// The reserved name.
            #[must_use]
            pub fn spelling(self) -> &'static str {
                match self {
                    $(Operator::$u => $us,)* $(Operator::$b => $bs,)* $(Operator::$c => $cs,)*
                    $(Operator::$t => $ts,)* $(Operator::$o => $os,)*
                }
            }

            /// Types of the operands, bottom of the stack first. For `render` the ICFP form; the
            /// Chicago form has a point (attenuation) before the object.
            #[must_use]
            pub fn operands(self) -> &'static [Type] {
                match self {
                    $(Operator::$u => &[Type::$ut],)* $(Operator::$b => &[Type::$bt, Type::$bt2],)*
                    $(Operator::$c => &[Type::$ct, Type::$ct2],)*
                    $(Operator::$t => &[Type::$tt, Type::$tt2, Type::$tt3],)*
                    $(Operator::$o => &[$(Type::$ot),*],)*
                }
            }

            /// Types of the results; for `apply` and `if` those of the function come on top.
            #[must_use]
            pub fn results(self) -> &'static [Type] {
                match self {
                    $(Operator::$u => &[Type::$ur],)* $(Operator::$b => &[Type::$br],)*
                    $(Operator::$c => &[Type::$cr],)* $(Operator::$t => &[Type::$tr],)*
                    $(Operator::$o => &[$(Type::$or),*],)*
                }
            }

            /// What it does, in a sentence or two.
            #[must_use]
            pub fn doc(self) -> &'static str {
                match self {
                    $(Operator::$u => concat!($($ud),+).trim_ascii(),)*
                    $(Operator::$b => concat!($($bd),+).trim_ascii(),)*
                    $(Operator::$c => concat!($($cd),+).trim_ascii(),)*
                    $(Operator::$t => concat!($($td),+).trim_ascii(),)*
                    $(Operator::$o => concat!($($od),+).trim_ascii(),)*
                }
            }
        }
    };
}

macro_rules! with_scalars {
    ([] $($scalars:tt)*) => { for_each_other!(operator_enum, [$($scalars)*]); };
}

crate::for_each_scalar!(with_scalars, []);

impl Operator {
    /// Operands and results by their types, as `object real → object`; `...` is what a function leaves.
    #[must_use]
    pub fn stack_effect(self) -> String {
        let names = |types: &[Type]| types.iter().map(|ty| ty.name()).collect::<Vec<_>>().join(" ");
        let results = match self {
            Operator::Apply | Operator::If => "...".to_owned(),
            _ => names(self.results()),
        };
        format!("{} → {results}", names(self.operands())).trim_end().to_owned()
    }

    /// The operator with this reserved name.
    #[must_use]
    pub fn from_spelling(name: &str) -> Option<Operator> {
        Operator::ALL.iter().copied().find(|op| op.spelling() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_fifty_operators_with_distinct_spellings() {
        let spellings: std::collections::HashSet<_> =
            Operator::ALL.iter().map(|op| op.spelling()).collect();
        assert_eq!((Operator::ALL.len(), spellings.len()), (50, 50));
    }
}
