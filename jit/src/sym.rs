//! GML values as a specializer sees them: known, or partly known.

use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;

use compiler::bytecode::{Constant, ConstantArray};
use compiler::op::Type;
use vm::value::{Array, Closure, Value};

use crate::sir::Val;

/// So many parts of two values are compared.
pub(crate) const MAX_COMPARED: usize = 1024;

/// A scalar: a constant, or a value of the shader.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Num<T> {
    Const(T),
    Ssa(Val),
}

/// A GML value.
#[derive(Clone, Debug)]
pub(crate) enum Sym {
    Real(Num<f64>),
    Int(Num<i64>),
    Bool(Num<bool>),
    Point([Num<f64>; 3]),
    Closure(u32, Captures),
    Array(Elements),
    /// A part of a table of numbers that is only reached by index.
    Table(TableView),
    /// One of several values, by number.
    Choice(Val, Rc<[Sym]>),
    /// A string, an object or a light: no operator of a surface function takes one.
    Opaque(Type, usize),
    /// A register that nobody reads any more.
    Dead,
}

/// The captured values of a closure.
#[derive(Clone, Debug)]
pub(crate) enum Captures {
    Known(KnownClosure),
    Parts(Rc<[Sym]>),
}

/// A closure that exists.
#[derive(Clone)]
pub(crate) struct KnownClosure(pub(crate) Arc<Closure>);

/// The elements of an array.
#[derive(Clone, Debug)]
pub(crate) enum Elements {
    Known(KnownArray),
    Constant(Arc<ConstantArray>),
    Parts(Rc<[Sym]>),
}

/// An array that exists.
#[derive(Clone)]
pub(crate) struct KnownArray(pub(crate) Arc<Array>);

impl std::fmt::Debug for KnownClosure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "closure of function {}", self.0.function)
    }
}

impl std::fmt::Debug for KnownArray {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "array of {}", self.0.items().len())
    }
}

/// What is left of an array of arrays of numbers after some indices.
#[derive(Clone, Debug)]
pub(crate) struct TableView {
    pub(crate) table: u32,
    /// Lengths of the arrays still to be indexed, the outermost first.
    pub(crate) lengths: Rc<[u32]>,
    /// Index of the first entry of the table in view.
    pub(crate) offset: Val,
}

impl Captures {
    pub(crate) fn len(&self) -> usize {
        match self {
            Captures::Known(closure) => closure.0.captures().len(),
            Captures::Parts(parts) => parts.len(),
        }
    }

    pub(crate) fn get(&self, index: usize) -> Sym {
        match self {
            Captures::Known(closure) => Sym::of_value(&closure.0.captures()[index]),
            Captures::Parts(parts) => parts[index].clone(),
        }
    }

    /// Whether both are the same values in memory.
    fn is_identical(&self, other: &Captures) -> bool {
        match (self, other) {
            (Captures::Known(a), Captures::Known(b)) => Arc::ptr_eq(&a.0, &b.0),
            (Captures::Parts(a), Captures::Parts(b)) => Rc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl Elements {
    pub(crate) fn len(&self) -> usize {
        match self {
            Elements::Known(array) => array.0.items().len(),
            Elements::Constant(array) => array.items().len(),
            Elements::Parts(parts) => parts.len(),
        }
    }

    pub(crate) fn get(&self, index: usize) -> Sym {
        match self {
            Elements::Known(array) => Sym::of_value(&array.0.items()[index]),
            Elements::Constant(array) => Sym::of_constant(&array.items()[index]),
            Elements::Parts(parts) => parts[index].clone(),
        }
    }

    fn is_identical(&self, other: &Elements) -> bool {
        match (self, other) {
            (Elements::Known(a), Elements::Known(b)) => Arc::ptr_eq(&a.0, &b.0),
            (Elements::Constant(a), Elements::Constant(b)) => Arc::ptr_eq(a, b),
            (Elements::Parts(a), Elements::Parts(b)) => Rc::ptr_eq(a, b),
            _ => false,
        }
    }
}

impl Sym {
    pub(crate) fn of_value(value: &Value) -> Sym {
        match value {
            Value::Bool(value) => Sym::Bool(Num::Const(*value)),
            Value::Int(value) => Sym::Int(Num::Const(*value)),
            Value::Real(value) => Sym::Real(Num::Const(*value)),
            Value::Point(point) => Sym::Point(point.map(Num::Const)),
            Value::Closure(closure) => {
                Sym::Closure(closure.function, Captures::Known(KnownClosure(closure.clone())))
            }
            Value::Array(array) => Sym::Array(Elements::Known(KnownArray(array.clone()))),
            Value::Str(text) => Sym::Opaque(Type::Str, Arc::as_ptr(text).cast::<u8>() as usize),
            Value::Object(object) => Sym::Opaque(Type::Object, object.address()),
            Value::Light(light) => Sym::Opaque(Type::Light, Arc::as_ptr(light) as usize),
        }
    }

    pub(crate) fn of_constant(constant: &Constant) -> Sym {
        match constant {
            Constant::Bool(value) => Sym::Bool(Num::Const(*value)),
            Constant::Int(value) => Sym::Int(Num::Const(*value)),
            Constant::Real(value) => Sym::Real(Num::Const(*value)),
            Constant::Point(point) => Sym::Point(point.map(Num::Const)),
            Constant::Function(function) => Sym::Closure(*function, Captures::Parts(Rc::new([]))),
            Constant::Array(array) => Sym::Array(Elements::Constant(array.clone())),
            Constant::Str(text) => Sym::Opaque(Type::Str, Arc::as_ptr(text).cast::<u8>() as usize),
        }
    }

    /// The constant, if it is a known scalar or point.
    pub(crate) fn as_constant(&self) -> Option<Constant> {
        match self {
            Sym::Real(Num::Const(value)) => Some(Constant::Real(*value)),
            Sym::Int(Num::Const(value)) => Some(Constant::Int(*value)),
            Sym::Bool(Num::Const(value)) => Some(Constant::Bool(*value)),
            Sym::Point([Num::Const(x), Num::Const(y), Num::Const(z)]) => {
                Some(Constant::Point([*x, *y, *z]))
            }
            _ => None,
        }
    }

    /// The type; none for a choice, which may be of several.
    pub(crate) fn type_of(&self) -> Option<Type> {
        Some(match self {
            Sym::Real(_) => Type::Real,
            Sym::Int(_) => Type::Int,
            Sym::Bool(_) => Type::Bool,
            Sym::Point(_) => Type::Point,
            Sym::Closure(..) => Type::Closure,
            Sym::Array(_) | Sym::Table(_) => Type::Array,
            Sym::Opaque(ty, _) => *ty,
            Sym::Choice(..) | Sym::Dead => return None,
        })
    }

    /// Whether both are the same value for sure. Constants are compared by their bits. Values that
    /// share their parts may be endless to walk through: they are different where no parts are left to be
    /// compared, of which there should be [`MAX_COMPARED`] at first.
    pub(crate) fn is_same_within(&self, other: &Sym, left: &Cell<usize>) -> bool {
        if left.get() == 0 {
            return false;
        }
        left.set(left.get() - 1);
        match (self, other) {
            (Sym::Real(a), Sym::Real(b)) => same_real(a, b),
            (Sym::Int(a), Sym::Int(b)) => a == b,
            (Sym::Bool(a), Sym::Bool(b)) => a == b,
            (Sym::Point(a), Sym::Point(b)) => a.iter().zip(b).all(|(a, b)| same_real(a, b)),
            (Sym::Closure(f, a), Sym::Closure(g, b)) => {
                let same_part = |i| a.get(i).is_same_within(&b.get(i), left);
                f == g && (a.is_identical(b) || all_same(a.len(), b.len(), same_part))
            }
            (Sym::Array(a), Sym::Array(b)) => {
                let same_part = |i| a.get(i).is_same_within(&b.get(i), left);
                a.is_identical(b) || all_same(a.len(), b.len(), same_part)
            }
            (Sym::Table(a), Sym::Table(b)) => {
                a.table == b.table && a.lengths == b.lengths && a.offset == b.offset
            }
            (Sym::Choice(a, x), Sym::Choice(b, y)) => {
                let same_part = |i: usize| x[i].is_same_within(&y[i], left);
                a == b && all_same(x.len(), y.len(), same_part)
            }
            (Sym::Opaque(s, a), Sym::Opaque(t, b)) => s == t && a == b,
            (Sym::Dead, Sym::Dead) => true,
            _ => false,
        }
    }
}

fn all_same(n: usize, m: usize, same: impl Fn(usize) -> bool) -> bool {
    n == m && (0..n).all(same)
}

pub(crate) fn same_real(a: &Num<f64>, b: &Num<f64>) -> bool {
    match (a, b) {
        (Num::Const(a), Num::Const(b)) => a.to_bits() == b.to_bits(),
        _ => a == b,
    }
}
