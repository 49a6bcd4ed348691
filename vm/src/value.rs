//! The nine types of GML values: immutable, acyclic, shared.
//!
//! Reference counting is the whole memory manager. Points are held in place, since surface
//! functions make them all the time; hence the 32 bytes.

use std::cell::RefCell;
use std::sync::Arc;

use compiler::op::Type;
use compiler::scalar::Point;
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

    /// Whether dropping it may drop other values.
    fn owns_values(&self) -> bool {
        matches!(self, Value::Closure(_) | Value::Array(_) | Value::Object(_))
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
