//! The nine types of GML values: immutable, acyclic, shared.
//!
//! Reference counting is the whole memory manager. Points are held in place, since surface
//! functions make them all the time; hence the 32 bytes.

use std::cell::RefCell;
use std::sync::Arc;

use compiler::op::Type;
use compiler::scalar::{Operands, Point};
use renderer::light::Light;
use renderer::object::Object;

/// A value.
#[derive(Clone)]
pub enum Value {
    /// A boolean.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A real.
    Real(f64),
    /// A point.
    Point(Point),
    /// A string.
    Str(Arc<str>),
    /// A function with its captured values.
    Closure(Arc<Closure>),
    /// An array.
    Array(Arc<Array>),
    /// A solid, whose surfaces are closures.
    Object(Object<Arc<Closure>>),
    /// A light.
    Light(Arc<Light>),
}

/// Code and the values that it captured.
pub struct Closure {
    /// Index of the function in its program.
    pub function: u32,
    captures: Values,
}

impl Closure {
    pub(crate) fn new(function: u32, captures: Vec<Value>) -> Self {
        Closure { function, captures: Values(captures) }
    }

    /// The captured values, in the order of the function's list.
    #[must_use]
    pub fn captures(&self) -> &[Value] {
        &self.captures.0
    }
}

/// A sequence of values.
pub struct Array {
    items: Values,
}

impl Array {
    pub(crate) fn new(items: Vec<Value>) -> Self {
        Array { items: Values(items) }
    }

    /// The items.
    #[must_use]
    pub fn items(&self) -> &[Value] {
        &self.items.0
    }
}

/// Values owned by another value.
///
/// Dropping them does not recurse, however deeply values are nested: whatever dies while values are
/// being dropped leaves its own values to the outermost drop.
struct Values(Vec<Value>);

impl Drop for Values {
    fn drop(&mut self) {
        thread_local! {
            static ORPHANS: RefCell<Option<Vec<Value>>> = const { RefCell::new(None) };
        }
        if !self.0.iter().any(Value::owns_values) {
            return;
        }
        let values = std::mem::take(&mut self.0);
        let is_outermost = ORPHANS.with_borrow_mut(|orphans| match orphans {
            Some(orphans) => {
                orphans.extend(values);
                false
            }
            None => {
                *orphans = Some(values);
                true
            }
        });
        if is_outermost {
            while let Some(value) = ORPHANS.with_borrow_mut(|orphans| orphans.as_mut()?.pop()) {
                drop(value);
            }
            ORPHANS.set(None);
        }
    }
}

impl Value {
    /// The type.
    #[must_use]
    pub fn type_of(&self) -> Type {
        match self {
            Value::Bool(_) => Type::Bool,
            Value::Int(_) => Type::Int,
            Value::Real(_) => Type::Real,
            Value::Point(_) => Type::Point,
            Value::Str(_) => Type::Str,
            Value::Closure(_) => Type::Closure,
            Value::Array(_) => Type::Array,
            Value::Object(_) => Type::Object,
            Value::Light(_) => Type::Light,
        }
    }

    /// Overwrites a value. Where a number stood no destructor is called, and where the new value is
    /// known to be a number only its own bytes are written.
    #[inline(always)]
    pub(crate) fn set(&mut self, value: Value) {
        match self {
            Value::Bool(_) | Value::Int(_) | Value::Real(_) | Value::Point(_) => {
                std::mem::forget(std::mem::replace(self, value));
            }
            _ => drop_shared(std::mem::replace(self, value)),
        }
    }

    /// Overwrites a value by a copy; what is common is written field by field.
    #[inline(always)]
    pub(crate) fn set_copy(&mut self, from: &Value) {
        match from {
            Value::Real(value) => self.set(Value::Real(*value)),
            Value::Int(value) => self.set(Value::Int(*value)),
            Value::Bool(value) => self.set(Value::Bool(*value)),
            Value::Point(value) => self.set(Value::Point(*value)),
            Value::Closure(closure) => self.set(Value::Closure(closure.clone())),
            Value::Array(array) => self.set(Value::Array(array.clone())),
            _ => self.set(clone_shared(from)),
        }
    }

    /// Overwrites a value by another, which becomes a number of no meaning.
    #[inline(always)]
    pub(crate) fn take_from(&mut self, from: &mut Value) {
        match from {
            Value::Real(value) => self.set(Value::Real(*value)),
            Value::Int(value) => self.set(Value::Int(*value)),
            Value::Bool(value) => self.set(Value::Bool(*value)),
            Value::Point(value) => self.set(Value::Point(*value)),
            _ => match std::mem::replace(from, Value::Bool(false)) {
                Value::Closure(closure) => self.set(Value::Closure(closure)),
                other => self.set(other),
            },
        }
    }

    /// Whether dropping it may drop other values.
    fn owns_values(&self) -> bool {
        matches!(self, Value::Closure(_) | Value::Array(_) | Value::Object(_))
    }
}

#[inline(never)]
fn drop_shared(value: Value) {
    drop(value);
}

#[inline(never)]
fn clone_shared(value: &Value) -> Value {
    value.clone()
}

impl Operands for Value {
    #[inline]
    fn from_bool(value: bool) -> Self {
        Value::Bool(value)
    }
    #[inline]
    fn from_int(value: i64) -> Self {
        Value::Int(value)
    }
    #[inline]
    fn from_real(value: f64) -> Self {
        Value::Real(value)
    }
    #[inline]
    fn from_point(value: Point) -> Self {
        Value::Point(value)
    }
    #[inline]
    fn as_int(&self) -> Option<i64> {
        if let Value::Int(value) = self { Some(*value) } else { None }
    }
    #[inline]
    fn as_real(&self) -> Option<f64> {
        if let Value::Real(value) = self { Some(*value) } else { None }
    }
    #[inline]
    fn as_point(&self) -> Option<Point> {
        if let Value::Point(value) = self { Some(*value) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_32_bytes() {
        assert_eq!(size_of::<Value>(), 32);
    }

    #[test]
    fn a_million_nested_values_drop_on_a_small_stack() {
        let nest = || {
            let mut value = Value::Int(0);
            for depth in 0..1_000_000 {
                value = match depth % 3 {
                    0 => Value::Array(Arc::new(Array::new(vec![value]))),
                    1 => Value::Closure(Arc::new(Closure::new(0, vec![value]))),
                    _ => {
                        let surface = Arc::new(Closure::new(0, vec![value]));
                        Value::Object(Object::shape(renderer::object::ShapeKind::Sphere, surface))
                    }
                };
            }
            drop(value);
        };
        let thread = std::thread::Builder::new().stack_size(128 << 10).spawn(nest);
        thread.expect("a thread").join().expect("no overflow");
    }
}
