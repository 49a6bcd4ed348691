//! How much memory values take that are shared with the outside of a machine: strings, objects and
//! lights, and what closures and arrays have become there.
//!
//! The heap adds their sizes up as it takes them in, and has them counted, shared parts once, when
//! it is collected.

use std::collections::HashSet;
use std::sync::Arc;

use renderer::object::Object;

use crate::value::{Closure, Value};

/// Bytes of a reference-counted allocation besides its content: two counts and the allocator's own.
const HEADER_BYTES: usize = 32;

/// Bytes that a new array, closure or light with so many values takes.
pub(crate) fn bytes_for(n_values: usize) -> u64 {
    (HEADER_BYTES + size_of::<Vec<Value>>() + n_values * size_of::<Value>()) as u64
}

/// Bytes of all that can be reached from the roots, shared parts counted once.
pub(crate) fn count<'v>(roots: impl Iterator<Item = &'v Value>) -> u64 {
    let mut walk = Walk { seen: HashSet::new(), values: Vec::new(), objects: Vec::new(), bytes: 0 };
    for root in roots {
        walk.bytes += size_of::<Value>() as u64;
        walk.values.push(root);
        walk.run();
    }
    walk.bytes
}

struct Walk<'v> {
    seen: HashSet<usize>,
    values: Vec<&'v Value>,
    objects: Vec<&'v Object<Arc<Closure>>>,
    bytes: u64,
}

impl<'v> Walk<'v> {
    fn run(&mut self) {
        loop {
            if let Some(value) = self.values.pop() {
                match value {
                    Value::Array(array) => {
                        self.values_at(Arc::as_ptr(array) as usize, array.items())
                    }
                    Value::Closure(closure) => self.closure(closure),
                    Value::Object(object) => self.objects.push(object),
                    Value::Light(light) => self.values_at(Arc::as_ptr(light) as usize, &[]),
                    _ => {}
                }
            } else if let Some(object) = self.objects.pop() {
                if self.seen.insert(object.address()) {
                    self.bytes += Object::<Arc<Closure>>::NODE_BYTES as u64;
                    self.objects.extend(object.children());
                    if let Some(closure) = object.surface() {
                        self.closure(closure);
                    }
                }
            } else {
                return;
            }
        }
    }

    fn closure(&mut self, closure: &'v Arc<Closure>) {
        self.values_at(Arc::as_ptr(closure) as usize, closure.captures());
    }

    fn values_at(&mut self, address: usize, values: &'v [Value]) {
        if self.seen.insert(address) {
            self.bytes += bytes_for(values.len());
            self.values.extend(values);
        }
    }
}
