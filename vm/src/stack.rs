//! The operand stack.
//!
//! Slots above the top hold numbers of no meaning, so that pushing is one store of a tag and one of
//! a payload. `Vec::push` would build the value elsewhere and copy all 32 bytes.

use crate::value::Value;

/// Values that cross calls, the last on top.
#[derive(Default)]
pub(crate) struct OperandStack {
    slots: Vec<Value>,
    len: usize,
}

impl OperandStack {
    /// Number of values.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The values, bottom first.
    #[inline]
    pub(crate) fn as_slice(&self) -> &[Value] {
        &self.slots[..self.len]
    }

    /// Pushes a copy of a value.
    #[inline(always)]
    pub(crate) fn push_copy(&mut self, value: &Value) {
        if self.len == self.slots.len() {
            self.grow();
        }
        self.slots[self.len].set_copy(value);
        self.len += 1;
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        let larger = (self.slots.len() * 2).max(64);
        self.slots.resize(larger, Value::Bool(false));
    }

    /// Moves the topmost value, of which there must be one, to `target`.
    #[inline(always)]
    pub(crate) fn pop_to(&mut self, target: &mut Value) {
        self.len -= 1;
        target.take_from(&mut self.slots[self.len]);
    }

    /// Takes all values from index `from` on, bottom first.
    pub(crate) fn split_off(&mut self, from: usize) -> Vec<Value> {
        let taken = &mut self.slots[from..self.len];
        let values =
            taken.iter_mut().map(|slot| std::mem::replace(slot, Value::Bool(false))).collect();
        self.len = from;
        values
    }

    /// Forgets all values.
    pub(crate) fn clear(&mut self) {
        for slot in &mut self.slots[..self.len] {
            slot.set(Value::Bool(false));
        }
        self.len = 0;
    }
}
