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

    /// Bytes in use.
    #[inline(always)]
    pub(crate) fn n_bytes(&self) -> u64 {
        (self.len * size_of::<Word>()) as u64
    }

    /// The values, bottom first.
    #[inline]
    pub(crate) fn as_slice(&self) -> &[Word] {
        &self.slots[..self.len]
    }

    /// Pushes values, the last on top.
    #[inline(always)]
    pub(crate) fn push<const N: usize>(&mut self, words: [Word; N]) {
        if self.slots.len() - self.len < N {
            self.grow();
        }
        for (slot, word) in self.slots[self.len..][..N].iter_mut().zip(words) {
            slot.set(word);
        }
        self.len += N;
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        let larger = (self.slots.len() * 2).max(64);
        self.slots.resize(larger, Word::NOTHING);
    }

    /// Takes the topmost values, of which there must be as many; the first was on top.
    #[inline(always)]
    pub(crate) fn pop<const N: usize>(&mut self) -> [Word; N] {
        let top = self.len;
        self.len -= N;
        let words = &self.slots[self.len..top];
        std::array::from_fn(|idx| words[N - 1 - idx])
    }

    /// Forgets all values from index `len` on.
    #[inline]
    pub(crate) fn truncate(&mut self, len: usize) {
        self.len = len;
    }
}
