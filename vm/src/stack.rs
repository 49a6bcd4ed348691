//! The operand stack.
//!
//! Slots above the top hold words of no meaning, so that pushing writes a tag and a payload in
//! place, and popping reads no more than that. `Vec::push` would build the word elsewhere and copy
//! all 32 bytes.

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

    /// The same, to be changed.
    pub(crate) fn as_mut_slice(&mut self) -> &mut [Word] {
        &mut self.slots[..self.len]
    }

    /// The slots of values to be pushed, the last on top.
    #[inline(always)]
    pub(crate) fn push<const N: usize>(&mut self) -> &mut [Word; N] {
        if self.slots.len() - self.len < N {
            self.grow();
        }
        let slots = self.slots[self.len..].first_chunk_mut().expect("there is room");
        self.len += N;
        slots
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        let larger = (self.slots.len() * 2).max(64);
        self.slots.resize(larger, Word::NOTHING);
    }

    /// Takes the topmost values, of which there must be as many; the last was on top.
    #[inline(always)]
    pub(crate) fn pop<const N: usize>(&mut self) -> &[Word; N] {
        self.len -= N;
        self.slots[self.len..].first_chunk().expect("there are as many")
    }

    /// Forgets all values from index `len` on.
    #[inline]
    pub(crate) fn truncate(&mut self, len: usize) {
        self.len = len;
    }
}
