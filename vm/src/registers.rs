//! The registers of all active calls, in columns: a tag and a payload each, and what only points
//! need apart from them.
//!
//! The frame of the running call is a window of 256 registers, so that a register number needs no
//! bounds check, and it indexes a column of bytes and one of words without arithmetic.

use compiler::scalar::Operands;

use crate::stack::OperandStack;
use crate::word::{Tag, Word};

/// Registers that an instruction can name. A function uses its first few; the callee's window
/// starts behind those.
pub(crate) const WINDOW: usize = 256;

/// What the registers grow by at least.
const CHUNK: usize = 4 * WINDOW;

/// Registers and spill slots, those of outer calls first.
#[derive(Default)]
pub(crate) struct Registers {
    /// So many may be used; the columns are as long or, if more once were, longer.
    len: usize,
    tags: Vec<Tag>,
    xs: Vec<u64>,
    /// The other coordinates of points.
    yzs: Vec<[u64; 2]>,
}

impl Registers {
    /// Number of registers.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Bytes in use.
    pub(crate) fn n_bytes(&self) -> u64 {
        (self.len() * (size_of::<Tag>() + size_of::<u64>() + size_of::<[u64; 2]>())) as u64
    }

    /// Makes room for so many registers.
    pub(crate) fn grow(&mut self, len: usize) {
        self.len = len.next_multiple_of(CHUNK);
        if self.tags.len() < self.len {
            self.tags.resize(self.len, Word::NOTHING.tag);
            self.xs.resize(self.len, Word::NOTHING.x);
            self.yzs.resize(self.len, [0; 2]);
        }
    }

    /// Leaves as many as there are at least, but keeps the memory.
    pub(crate) fn shrink(&mut self) {
        self.len = self.len.min(CHUNK);
    }

    /// The frame at `base`.
    #[inline(always)]
    pub(crate) fn window(&mut self, base: usize) -> Window<'_> {
        let room = "entering a function makes room for a window";
        Window {
            tags: self.tags[base..].first_chunk_mut().expect(room),
            xs: self.xs[base..].first_chunk_mut().expect(room),
            yzs: self.yzs[base..].first_chunk_mut().expect(room),
        }
    }

    pub(crate) fn get(&self, index: usize) -> Word {
        let [y, z] = self.yzs[index];
        Word { tag: self.tags[index], x: self.xs[index], y, z }
    }

    pub(crate) fn set(&mut self, index: usize, word: Word) {
        (self.tags[index], self.xs[index]) = (word.tag, word.x);
        self.yzs[index] = [word.y, word.z];
    }
}

/// The registers of the running call.
pub(crate) struct Window<'m> {
    tags: &'m mut [Tag; WINDOW],
    xs: &'m mut [u64; WINDOW],
    yzs: &'m mut [[u64; 2]; WINDOW],
}

impl Window<'_> {
    #[inline(always)]
    pub(crate) fn get(&self, register: u8) -> Word {
        let [y, z] = self.yzs[register as usize];
        Word { tag: self.tag(register), x: self.xs[register as usize], y, z }
    }

    #[inline(always)]
    pub(crate) fn tag(&self, register: u8) -> Tag {
        self.tags[register as usize]
    }

    #[inline(always)]
    pub(crate) fn x(&self, register: u8) -> u64 {
        self.xs[register as usize]
    }

    /// Copies one register to another.
    #[inline(always)]
    pub(crate) fn copy(&mut self, from: u8, to: u8) {
        let tag = self.tag(from);
        self.tags[to as usize] = tag;
        self.xs[to as usize] = self.x(from);
        if tag == Tag::Point {
            self.yzs[to as usize] = self.yzs[from as usize];
        }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, register: u8, word: Word) {
        self.tags[register as usize] = word.tag;
        self.xs[register as usize] = word.x;
        if word.tag == Tag::Point {
            self.yzs[register as usize] = [word.y, word.z];
        }
    }

    /// Sets a register to a word in memory, of which it reads what is needed.
    #[inline(always)]
    pub(crate) fn load(&mut self, register: u8, word: &Word) {
        let tag = word.tag;
        self.tags[register as usize] = tag;
        self.xs[register as usize] = word.x;
        if tag == Tag::Point {
            self.yzs[register as usize] = [word.y, word.z];
        }
    }

    /// Sets a word in memory to what is in a register.
    #[inline(always)]
    pub(crate) fn store(&self, register: u8, word: &mut Word) {
        let tag = self.tag(register);
        (word.tag, word.x) = (tag, self.x(register));
        if tag == Tag::Point {
            [word.y, word.z] = self.yzs[register as usize];
        }
    }

    /// Pushes what is in registers, the last on top.
    #[inline(always)]
    pub(crate) fn push<const N: usize>(&self, registers: [u8; N], stack: &mut OperandStack) {
        let slots = stack.push::<N>();
        for idx in 0..N {
            self.store(registers[idx], &mut slots[idx]);
        }
    }

    #[inline(always)]
    pub(crate) fn set_real(&mut self, register: u8, value: f64) {
        self.set(register, Word::from_real(value));
    }
}
