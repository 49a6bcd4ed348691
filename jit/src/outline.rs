//! What of a surface closure a shader is specialized on, and what it is told at run time.
//!
//! Closures that share code and differ only in captured reals and points share one shader: those
//! are its uniforms. Everything else that is captured (code, integers, booleans, arrays) may steer
//! control flow or types, and is part of the shader's key.

use std::rc::Rc;
use std::sync::Arc;

use vm::value::{Closure, Value};

use crate::sir::{N_ARGUMENTS, Type, Val};
use crate::sym::{Captures, Num, Sym};

/// Closures in closures are looked into so far; what lies deeper is specialized on as it is.
const MAX_PARTS: usize = 256;

/// One thing that a shader is specialized on.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum KeyItem {
    Function(u32),
    Real,
    Point,
    IntUniform,
    Int(i64),
    Bool(bool),
    /// A value that is shared with the program, by address; the program keeps it in place.
    Address(usize),
}

/// The outline of a closure.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    pub(crate) function: u32,
    pub(crate) captures: Rc<[Sym]>,
    pub(crate) key: Vec<KeyItem>,
    /// Bits of the uniforms.
    pub(crate) uniforms: Vec<u64>,
    pub(crate) uniform_types: Vec<Type>,
}

/// Outlines a closure; with `int_uniforms`, captured integers are uniforms too.
pub(crate) fn outline(closure: &Arc<Closure>, int_uniforms: bool) -> Outline {
    let mut walk = Walk { key: Vec::new(), uniforms: Vec::new(), types: Vec::new(), int_uniforms };
    let captures = walk.closure(closure);
    Outline {
        function: closure.function,
        captures,
        key: walk.key,
        uniforms: walk.uniforms,
        uniform_types: walk.types,
    }
}

struct Walk {
    key: Vec<KeyItem>,
    uniforms: Vec<u64>,
    types: Vec<Type>,
    int_uniforms: bool,
}

impl Walk {
    /// The recursion is bounded by the number of parts.
    fn closure(&mut self, closure: &Arc<Closure>) -> Rc<[Sym]> {
        self.key.push(KeyItem::Function(closure.function));
        closure.captures().iter().map(|value| self.value(value)).collect()
    }

    fn value(&mut self, value: &Value) -> Sym {
        match value {
            Value::Real(real) => {
                self.key.push(KeyItem::Real);
                Sym::Real(self.uniform(Type::Real, real.to_bits()))
            }
            Value::Point(point) => {
                self.key.push(KeyItem::Point);
                Sym::Point(point.map(|c| self.uniform(Type::Real, c.to_bits())))
            }
            Value::Int(int) if self.int_uniforms => {
                self.key.push(KeyItem::IntUniform);
                Sym::Int(self.uniform(Type::Int, *int as u64))
            }
            Value::Int(int) => {
                self.key.push(KeyItem::Int(*int));
                Sym::of_value(value)
            }
            Value::Bool(bool) => {
                self.key.push(KeyItem::Bool(*bool));
                Sym::of_value(value)
            }
            Value::Closure(closure) if self.key.len() < MAX_PARTS => {
                let captures = self.closure(closure);
                Sym::Closure(closure.function, Captures::Parts(captures))
            }
            _ => {
                self.key.push(KeyItem::Address(address(value)));
                Sym::of_value(value)
            }
        }
    }

    fn uniform<T>(&mut self, ty: Type, bits: u64) -> Num<T> {
        self.uniforms.push(bits);
        self.types.push(ty);
        Num::Ssa(Val(N_ARGUMENTS + self.uniforms.len() as u32 - 1))
    }
}

fn address(value: &Value) -> usize {
    match value {
        Value::Closure(closure) => Arc::as_ptr(closure) as usize,
        Value::Array(array) => Arc::as_ptr(array) as usize,
        Value::Str(text) => Arc::as_ptr(text).cast::<u8>() as usize,
        Value::Object(object) => object.address(),
        Value::Light(light) => Arc::as_ptr(light) as usize,
        Value::Bool(_) | Value::Int(_) | Value::Real(_) | Value::Point(_) => 0,
    }
}
