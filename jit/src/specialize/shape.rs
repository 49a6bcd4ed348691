//! What values have in common that differ only in scalars.

use std::sync::Arc;

use compiler::op::Type as GmlType;

use crate::specialize::ConstKey;
use crate::specialize::join::Scalar;
use crate::sym::{Captures, Elements, Num, Sym, TableView};

/// One part of a shape, in the order of a walk through the values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Real,
    Int,
    Bool,
    Constant(ConstKey),
    Point,
    Closure(u32, usize),
    Array(usize),
    /// What exists outside the shader, by address.
    Known(usize),
    Table(u32, Vec<u32>),
    Choice(usize),
    Opaque(GmlType, usize),
    Dead,
}

/// What becomes of constants.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Constants {
    /// They belong to the shape.
    Keep,
    /// They do within closures and arrays.
    KeepWithin,
    /// They are scalars like others.
    Forget,
}

/// A walk through values, which notes their shape and has each of their scalars replaced.
pub(super) struct Walk<'f> {
    pub(super) parts: Vec<Part>,
    pub(super) replace: &'f mut dyn FnMut(Scalar) -> Sym,
}

/// Shapes are looked at so far: values may share parts so often that a walk would never end.
pub(super) const MAX_PARTS: usize = 512;

/// The shape of the values that are walked through, and their scalars.
pub(super) fn taken_apart(through: impl FnOnce(&mut Walk<'_>)) -> (Vec<Part>, Vec<Scalar>) {
    let mut scalars = Vec::new();
    let mut note = |scalar: Scalar| {
        scalars.push(scalar);
        scalar.sym()
    };
    let mut walk = Walk { parts: Vec::new(), replace: &mut note };
    through(&mut walk);
    (walk.parts, scalars)
}

impl Walk<'_> {
    /// The value with its scalars replaced; meaningless when there are too many parts.
    pub(super) fn value(&mut self, sym: &Sym, constants: Constants) -> Sym {
        if self.parts.len() > MAX_PARTS {
            return Sym::Dead;
        }
        let within = if constants == Constants::Forget { constants } else { Constants::Keep };
        match sym {
            Sym::Real(num) => Sym::Real(self.real(*num, constants)),
            Sym::Int(Num::Const(value)) if constants == Constants::Keep => {
                self.leaf(Part::Constant(ConstKey::Int(*value)), sym)
            }
            Sym::Bool(Num::Const(value)) if constants == Constants::Keep => {
                self.leaf(Part::Constant(ConstKey::Bool(*value)), sym)
            }
            Sym::Int(num) => {
                self.parts.push(Part::Int);
                (self.replace)(Scalar::Int(*num))
            }
            Sym::Bool(num) => {
                self.parts.push(Part::Bool);
                (self.replace)(Scalar::Bool(*num))
            }
            Sym::Point(point) => {
                self.parts.push(Part::Point);
                Sym::Point(point.map(|num| self.real(num, constants)))
            }
            Sym::Closure(_, Captures::Known(closure)) => {
                self.leaf(Part::Known(Arc::as_ptr(&closure.0) as usize), sym)
            }
            Sym::Closure(function, Captures::Parts(captures)) => {
                self.parts.push(Part::Closure(*function, captures.len()));
                let captures = captures.iter().map(|sym| self.value(sym, within)).collect();
                Sym::Closure(*function, Captures::Parts(captures))
            }
            Sym::Array(Elements::Known(array)) => {
                self.leaf(Part::Known(Arc::as_ptr(&array.0) as usize), sym)
            }
            Sym::Array(Elements::Constant(array)) => {
                self.leaf(Part::Known(Arc::as_ptr(array) as usize), sym)
            }
            Sym::Array(Elements::Parts(elements)) => {
                self.parts.push(Part::Array(elements.len()));
                let elements = elements.iter().map(|sym| self.value(sym, within)).collect();
                Sym::Array(Elements::Parts(elements))
            }
            Sym::Table(view) => {
                self.parts.push(Part::Table(view.table, view.lengths.to_vec()));
                match (self.replace)(Scalar::Int(Num::Ssa(view.offset))) {
                    Sym::Int(Num::Ssa(offset)) => Sym::Table(TableView { offset, ..view.clone() }),
                    _ => Sym::Dead,
                }
            }
            Sym::Choice(tag, alternatives) => {
                self.parts.push(Part::Choice(alternatives.len()));
                let tag = (self.replace)(Scalar::Int(Num::Ssa(*tag)));
                let alternatives =
                    alternatives.iter().map(|sym| self.value(sym, constants)).collect();
                match tag {
                    Sym::Int(Num::Ssa(tag)) => Sym::Choice(tag, alternatives),
                    _ => Sym::Dead,
                }
            }
            Sym::Opaque(ty, address) => self.leaf(Part::Opaque(*ty, *address), sym),
            Sym::Dead => self.leaf(Part::Dead, sym),
        }
    }

    fn leaf(&mut self, part: Part, sym: &Sym) -> Sym {
        self.parts.push(part);
        sym.clone()
    }

    fn real(&mut self, num: Num<f64>, constants: Constants) -> Num<f64> {
        if let (Num::Const(value), Constants::Keep) = (num, constants) {
            self.parts.push(Part::Constant(ConstKey::Real(value.to_bits())));
            return num;
        }
        self.parts.push(Part::Real);
        match (self.replace)(Scalar::Real(num)) {
            Sym::Real(replaced) => replaced,
            _ => num,
        }
    }
}
