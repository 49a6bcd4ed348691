//! What crosses the border of a machine: words to shared values and back.
//!
//! Sharing is kept both ways: a closure that surfaces many solids is one closure outside, and one
//! that many closures captured is one in the heap. Neither way recurses.

use std::collections::HashMap;
use std::sync::Arc;

use compiler::scalar::Operands;

use crate::heap::Heap;
use crate::value::{Array, Closure, Value};
use crate::word::{Tag, Word};

impl Heap {
    /// The value that a word stands for.
    pub(crate) fn export(&mut self, word: Word) -> Value {
        let mut pending = vec![word];
        while let Some(&next) = pending.last() {
            if self.is_outside(next) {
                pending.pop();
                continue;
            }
            let n_pending = pending.len();
            let parts = self.items(next.address());
            pending.extend(parts.iter().filter(|part| !self.is_outside(**part)));
            if pending.len() == n_pending {
                self.export_one(next);
            }
        }
        self.outside(word)
    }

    fn is_outside(&self, word: Word) -> bool {
        !matches!(word.tag, Tag::Closure | Tag::Array) || self.exported(word.address()).is_some()
    }

    /// The value of a word that needs no export, or has had it.
    fn outside(&self, word: Word) -> Value {
        if let Some(scalar) = word.to_scalar() {
            return scalar;
        }
        match word.tag {
            Tag::Closure | Tag::Array => {
                self.exported(word.address()).expect("exported before").clone()
            }
            _ => self.foreign(word).clone(),
        }
    }

    /// Exports a closure or an array all parts of which are outside.
    fn export_one(&mut self, word: Word) {
        let address = word.address();
        let values = self.items(address).iter().map(|part| self.outside(*part)).collect();
        let value = match word.tag {
            Tag::Closure => Value::Closure(Arc::new(Closure::new(self.function(address), values))),
            _ => Value::Array(Arc::new(Array::new(values))),
        };
        self.set_exported(address, value);
    }
}

/// The closures and arrays that a heap has taken in, by their addresses outside.
#[derive(Default)]
pub(crate) struct Imports {
    words: HashMap<usize, Word>,
    /// Keeps the addresses from being used again.
    closures: Vec<Arc<Closure>>,
}

/// Where values have to be copied to: the items of the closure or array at an address.
type Unfilled<'v> = Vec<(usize, &'v [Value])>;

impl Imports {
    /// Brings a closure, with all that it has captured, into the heap.
    pub(crate) fn import(&mut self, closure: &Arc<Closure>, heap: &mut Heap) -> Word {
        if let Some(word) = self.words.get(&(Arc::as_ptr(closure) as usize)) {
            return *word;
        }
        self.closures.push(closure.clone());
        let mut unfilled = Vec::new();
        let word = self.closure(closure, heap, &mut unfilled);
        while let Some((address, values)) = unfilled.pop() {
            for (idx, value) in values.iter().enumerate() {
                heap.items_mut(address)[idx] = self.word(value, heap, &mut unfilled);
            }
        }
        word
    }

    fn word<'v>(&mut self, value: &'v Value, heap: &mut Heap, unfilled: &mut Unfilled<'v>) -> Word {
        match value {
            Value::Bool(value) => Word::from_bool(*value),
            Value::Int(value) => Word::from_int(*value),
            Value::Real(value) => Word::from_real(*value),
            Value::Point(value) => Word::from_point(*value),
            Value::Closure(closure) => self.closure(closure, heap, unfilled),
            Value::Array(array) => self.array(array, heap, unfilled),
            Value::Str(_) => heap.adopt(Tag::Str, value.clone(), 0),
            Value::Object(_) => heap.adopt(Tag::Object, value.clone(), 0),
            Value::Light(_) => heap.adopt(Tag::Light, value.clone(), 0),
        }
    }

    fn closure<'v>(
        &mut self,
        closure: &'v Arc<Closure>,
        heap: &mut Heap,
        unfilled: &mut Unfilled<'v>,
    ) -> Word {
        *self.words.entry(Arc::as_ptr(closure) as usize).or_insert_with(|| {
            let values = closure.captures();
            let word = heap.closure(closure.function, values.len());
            unfilled.push((word.address(), values));
            word
        })
    }

    fn array<'v>(
        &mut self,
        array: &'v Arc<Array>,
        heap: &mut Heap,
        unfilled: &mut Unfilled<'v>,
    ) -> Word {
        *self.words.entry(Arc::as_ptr(array) as usize).or_insert_with(|| {
            let values = array.items();
            let word = heap.array(values.len());
            unfilled.push((word.address(), values));
            word
        })
    }
}
