//! The heap of one machine: closures and arrays as runs of words, and values from outside.
//!
//! A closure or an array is a header with its number of words, and its function if it is a closure,
//! followed by those words. Strings, objects and lights are held as values beside the cells.
//!
//! The heap is a stack. Since values never change, whatever refers to a value is younger than that
//! value; so when nothing is in use that is younger than some value, the heap can be cut there. No
//! reference is counted, and no value is traced or moved. What is not in use but older than something
//! that is stays until that goes.

use std::collections::HashMap;

use crate::value::Value;
use crate::word::{Tag, Word};

/// Bytes of a reference-counted allocation besides its content: two counts and the allocator's own.
const SHARED_BYTES: usize = 32;

/// Closures, arrays, and what words cannot hold.
#[derive(Clone, Default)]
pub(crate) struct Heap {
    cells: Vec<Word>,
    foreign: Vec<Foreign>,
    /// What closures and arrays have become outside, by their addresses.
    exports: HashMap<usize, Export>,
    /// Bytes of the foreign values and of what has been exported.
    outside_bytes: u64,
    /// Number of cells and foreign values that have been cut off.
    n_cut: u64,
}

/// A string, an object or a light.
#[derive(Clone)]
struct Foreign {
    value: Value,
    /// Number of cells when it was adopted: what refers to it lies behind those.
    born: usize,
    /// Bytes outside then, its own included.
    outside_bytes: u64,
}

/// A closure or an array as it is outside the machine.
#[derive(Clone)]
struct Export {
    value: Value,
    n_bytes: u64,
    /// Number of foreign values that it came after: those that follow may hold it.
    n_foreign: usize,
}

/// How far a heap reaches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Extent {
    n_cells: usize,
    n_foreign: usize,
}

impl Extent {
    fn or(self, other: Extent) -> Extent {
        Extent {
            n_cells: self.n_cells.max(other.n_cells),
            n_foreign: self.n_foreign.max(other.n_foreign),
        }
    }
}

impl Heap {
    /// A closure of a function, with captured values of no meaning yet.
    #[inline]
    pub(crate) fn closure(&mut self, function: u32, n_captures: usize) -> Word {
        let address = self.allocate(n_captures);
        self.cells[address].y = u64::from(function);
        Word::new(Tag::Closure, address as u64)
    }

    /// An array with items of no meaning yet.
    #[inline]
    pub(crate) fn array(&mut self, n_items: usize) -> Word {
        Word::new(Tag::Array, self.allocate(n_items) as u64)
    }

    fn allocate(&mut self, n_words: usize) -> usize {
        let address = self.cells.len();
        self.cells.push(Word::new(Tag::Header, n_words as u64));
        self.cells.resize(address + 1 + n_words, Word::NOTHING);
        address
    }

    /// Takes in a string, an object or a light, which owns so many bytes.
    pub(crate) fn adopt(&mut self, tag: Tag, value: Value, n_bytes: u64) -> Word {
        self.outside_bytes += n_bytes + size_of::<Foreign>() as u64;
        let (born, outside_bytes) = (self.cells.len(), self.outside_bytes);
        self.foreign.push(Foreign { value, born, outside_bytes });
        Word::new(tag, self.foreign.len() as u64 - 1)
    }

    /// A string, an object or a light.
    pub(crate) fn foreign(&self, word: Word) -> &Value {
        &self.foreign[word.address()].value
    }

    /// The function of a closure.
    #[inline(always)]
    pub(crate) fn function(&self, closure: usize) -> u32 {
        self.cells[closure].y as u32
    }

    /// A captured value of a closure.
    #[inline(always)]
    pub(crate) fn capture(&self, closure: usize, index: u32) -> Word {
        self.cells[closure + 1 + index as usize]
    }

    /// Number of items of an array.
    #[inline(always)]
    pub(crate) fn length(&self, array: usize) -> usize {
        self.cells[array].x as usize
    }

    /// An item of an array.
    #[inline(always)]
    pub(crate) fn item(&self, array: usize, index: i64) -> Option<Word> {
        let is_inside = (index as u64) < self.cells[array].x;
        is_inside.then(|| self.cells[array + 1 + index as usize])
    }

    /// The items of an array, or the captured values of a closure.
    pub(crate) fn items(&self, address: usize) -> &[Word] {
        &self.cells[address + 1..][..self.cells[address].x as usize]
    }

    pub(crate) fn items_mut(&mut self, address: usize) -> &mut [Word] {
        let n_words = self.cells[address].x as usize;
        &mut self.cells[address + 1..][..n_words]
    }

    /// What a closure or an array has become outside, if it was needed there.
    pub(crate) fn exported(&self, address: usize) -> Option<&Value> {
        self.exports.get(&address).map(|export| &export.value)
    }

    pub(crate) fn set_exported(&mut self, address: usize, value: Value) {
        let n_values = self.cells[address].x as usize;
        let content = size_of::<Vec<Value>>() + n_values * size_of::<Value>();
        let n_bytes = (SHARED_BYTES + content + size_of::<Export>()) as u64;
        self.outside_bytes += n_bytes;
        self.exports.insert(address, Export { value, n_bytes, n_foreign: self.foreign.len() });
    }

    /// Bytes in use.
    #[inline(always)]
    pub(crate) fn n_bytes(&self) -> u64 {
        (self.cells.len() * size_of::<Word>()) as u64 + self.outside_bytes
    }

    /// Number of cells and foreign values that there ever were.
    pub(crate) fn n_made(&self) -> u64 {
        (self.cells.len() + self.foreign.len()) as u64 + self.n_cut
    }

    pub(crate) fn extent(&self) -> Extent {
        Extent { n_cells: self.cells.len(), n_foreign: self.foreign.len() }
    }

    /// By how much the heap reaches farther, in cells; a foreign value counts for a few.
    #[inline(always)]
    pub(crate) fn growth_since(&self, extent: Extent) -> usize {
        const CELLS_OF_FOREIGN: usize = 8;
        let n_foreign = self.foreign.len() - extent.n_foreign;
        self.cells.len() - extent.n_cells + CELLS_OF_FOREIGN * n_foreign
    }

    /// As far as the extent and all values in use, which may refer to anything older.
    pub(crate) fn extent_of<'w>(
        &self,
        extent: Extent,
        in_use: impl Iterator<Item = &'w Word>,
    ) -> Extent {
        let of = |word: &Word| match word.tag {
            Tag::Closure | Tag::Array => {
                let n_words = self.cells[word.address()].x as usize;
                Extent { n_cells: word.address() + 1 + n_words, n_foreign: 0 }
            }
            Tag::Str | Tag::Object | Tag::Light => {
                Extent { n_cells: 0, n_foreign: word.address() + 1 }
            }
            _ => Extent::default(),
        };
        in_use.map(of).fold(extent, Extent::or)
    }

    /// Forgets what lies beyond an extent. Foreign values beyond it stay if cells within it may refer
    /// to them.
    #[inline]
    pub(crate) fn cut(&mut self, extent: Extent) {
        if extent != self.extent() {
            self.cut_off(extent);
        }
    }

    #[inline(never)]
    fn cut_off(&mut self, extent: Extent) {
        let n_made = self.n_made();
        self.cells.truncate(extent.n_cells);
        let may_be_held = |foreign: &Foreign| foreign.born < extent.n_cells;
        let n_free = self.foreign.iter().rev().take_while(|last| !may_be_held(last)).count();
        let n_foreign = extent.n_foreign.max(self.foreign.len() - n_free);
        self.foreign.truncate(n_foreign);
        self.n_cut = n_made - (self.cells.len() + self.foreign.len()) as u64;
        self.outside_bytes = self.foreign.last().map_or(0, |foreign| foreign.outside_bytes);
        // What was exported before the last foreign value is counted with that.
        self.exports.retain(|address, export| {
            let stays = *address < extent.n_cells;
            if stays && export.n_foreign >= n_foreign {
                export.n_foreign = n_foreign;
                self.outside_bytes += export.n_bytes;
            }
            stays
        });
    }
}

#[cfg(test)]
mod tests;
