//! The operand stack.
//!
//! Slots above the top hold words of no meaning, so that pushing writes a tag and a payload in
//! place. `Vec::push` would build the word elsewhere and copy all 32 bytes.

use crate::word::Word;

/// Values that cross calls, the last on top.
#[derive(Default)]
pub(crate) struct OperandStack {
    slots: Vec<Word>,
    len: usize,
}

impl OperandStack {
    /// Number of values.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The values, bottom first.
    #[inline]
    pub(crate) fn as_slice(&self) -> &[Word] {
        &self.slots[..self.len]
    }

    /// The values, bottom first.
    pub(crate) fn as_mut_slice(&mut self) -> &mut [Word] {
        &mut self.slots[..self.len]
    }

    /// Pushes a value.
    #[inline(always)]
    pub(crate) fn push(&mut self, word: Word) {
        if self.len == self.slots.len() {
            self.grow();
        }
        self.slots[self.len].set(word);
        self.len += 1;
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        let larger = (self.slots.len() * 2).max(64);
        self.slots.resize(larger, Word::NOTHING);
    }

    /// Moves the topmost value, of which there must be one, to `target`.
    #[inline(always)]
    pub(crate) fn pop_to(&mut self, target: &mut Word) {
        self.len -= 1;
        target.set(self.slots[self.len]);
    }

    /// Forgets all values from index `len` on.
    #[inline]
    pub(crate) fn truncate(&mut self, len: usize) {
        self.len = len;
    }
}
