//! The operand stack.
//!
//! Slots above the top hold words of no meaning, so that pushing writes a tag and a payload in
//! place, and popping reads no more than that. `Vec::push` would build the word elsewhere and copy
//! all 32 bytes.

use crate::word::Word;

/// There are at least so many slots.
const MIN_SLOTS: usize = 64;

/// Values that cross calls, the last on top.
pub(crate) struct OperandStack {
    slots: Vec<Word>,
    len: usize,
    /// As many slots as may be in use when the machine next looks.
    max_slots: usize,
}

impl OperandStack {
    /// An empty stack, of which so many bytes may be used.
    pub(crate) fn new(max_bytes: u64) -> Self {
        let max_slots = usize::try_from(max_bytes).unwrap_or(usize::MAX) / size_of::<Word>();
        OperandStack { slots: Vec::new(), len: 0, max_slots }
    }

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

    /// Makes twice as many slots, but no more than may be used; if those are too few, an eighth more, until
    /// the machine looks.
    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        let n_slots = self.slots.len();
        let larger = (2 * n_slots).min(self.max_slots).max(n_slots + n_slots / 8).max(MIN_SLOTS);
        self.slots.reserve_exact(larger - n_slots);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn n_slots_for(n_values: usize, max_values: usize) -> usize {
        let mut stack = OperandStack::new((max_values * size_of::<Word>()) as u64);
        for _ in 0..n_values {
            stack.push::<3>();
        }
        stack.slots.capacity()
    }

    #[test]
    fn it_grows_to_what_may_be_used_and_hardly_beyond() {
        assert_eq!(n_slots_for(1, 0), MIN_SLOTS);
        assert_eq!(n_slots_for(100, 1 << 20), 512);
        assert_eq!(n_slots_for(100, 400), 400);
        assert_eq!(n_slots_for(134, 400), 450);
    }
}
