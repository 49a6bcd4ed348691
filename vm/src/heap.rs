//! The heap of one machine: closures and arrays as runs of words, and values from outside.
//!
//! A closure or an array is a header with its number of words, and its function if it is a closure,
//! followed by those words. Strings, objects and lights are held as values beside the cells.
//!
//! The heap is a stack. Since values never change, whatever refers to a value is younger than that
//! value; so when nothing is in use that is younger than some value, the heap can be cut there. No
//! reference is counted, and no closure or array is traced or moved. What is not in use but older than
//! one that is stays until that goes. Values from outside, which refer to nothing in the heap, are moved
//! down where a cut would spare them: else a loop that adds to an object would keep all of its rounds.

use std::collections::HashMap;
use std::sync::Arc;

use renderer::object::Object;

use crate::value::{Closure, Value};
use crate::word::{Tag, Word};

/// Bytes of a reference-counted allocation besides its content: two counts and the allocator's own.
const SHARED_BYTES: usize = 32;

/// Bytes that an object or a light owns.
pub(crate) const OBJECT_BYTES: u64 = Object::<Arc<Closure>>::NODE_BYTES as u64;

/// Closures, arrays, and what words cannot hold.
#[derive(Clone, Default)]
pub(crate) struct Heap {
    cells: Vec<Word>,
    foreign: Vec<Foreign>,
    /// What closures and arrays have become outside, by their addresses.
    exports: HashMap<usize, Export>,
    /// Bytes of the foreign values and of what has been exported.
    outside_bytes: u64,
    /// Number of cells that have been cut off.
    n_cut: u64,
}

/// A string, an object or a light.
#[derive(Clone)]
struct Foreign {
    value: Value,
    /// Its place among the cells, where a header of no words stands for it.
    address: usize,
    /// Bytes outside when it came, its own included.
    outside_bytes: u64,
}

impl Foreign {
    /// Bytes that are free once it is dropped, at least.
    fn bytes_freed(&self) -> u64 {
        let is_last = match &self.value {
            Value::Object(object) => !object.is_shared(),
            Value::Light(light) => Arc::strong_count(light) == 1,
            _ => false,
        };
        size_of::<Foreign>() as u64 + if is_last { OBJECT_BYTES } else { 0 }
    }
}

/// A closure or an array as it is outside the machine.
#[derive(Clone)]
struct Export {
    value: Value,
    n_bytes: u64,
    /// Number of foreign values that it came after: those that follow may hold it.
    n_foreign: usize,
}

impl Heap {
    /// A closure of a function, with captured values of no meaning yet.
    #[inline]
    pub(crate) fn closure(&mut self, function: u32, n_captures: usize) -> Word {
        let closure = self.begin_closure(function, n_captures);
        self.cells.resize(closure.address() + 1 + n_captures, Word::NOTHING);
        closure
    }

    /// A closure of a function, whose captured values are to be given at once, one after the other.
    #[inline(always)]
    pub(crate) fn begin_closure(&mut self, function: u32, n_captures: usize) -> Word {
        let address = self.cells.len();
        self.cells
            .push(Word { y: u64::from(function), ..Word::new(Tag::Header, n_captures as u64) });
        Word::new(Tag::Closure, address as u64)
    }

    /// The next captured value of a closure that was begun.
    #[inline(always)]
    pub(crate) fn add_capture(&mut self, word: Word) {
        self.cells.push(word);
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
        let address = self.allocate(0);
        self.outside_bytes += n_bytes + size_of::<Foreign>() as u64;
        self.foreign.push(Foreign { value, address, outside_bytes: self.outside_bytes });
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
    pub(crate) fn capture(&self, closure: usize, index: u32) -> &Word {
        &self.cells[closure + 1 + index as usize]
    }

    /// Number of items of an array.
    #[inline(always)]
    pub(crate) fn length(&self, array: usize) -> usize {
        self.cells[array].x as usize
    }

    /// An item of an array.
    #[inline(always)]
    pub(crate) fn item(&self, array: usize, index: i64) -> Option<&Word> {
        let is_inside = (index as u64) < self.cells[array].x;
        is_inside.then(|| &self.cells[array + 1 + index as usize])
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

    /// Number of cells, which is where the next value will be.
    #[inline(always)]
    pub(crate) fn n_cells(&self) -> usize {
        self.cells.len()
    }

    /// Number of cells that were ever made.
    pub(crate) fn n_made(&self) -> u64 {
        self.cells.len() as u64 + self.n_cut
    }

    /// Where a value ends that is in the heap; 0 for others.
    pub(crate) fn end(&self, word: Word) -> usize {
        match word.tag {
            Tag::Closure | Tag::Array => word.address() + 1 + self.cells[word.address()].x as usize,
            Tag::Str | Tag::Object | Tag::Light => self.foreign[word.address()].address + 1,
            _ => 0,
        }
    }

    /// Forgets what lies behind so many cells.
    #[inline]
    pub(crate) fn cut(&mut self, n_cells: usize) {
        if n_cells < self.cells.len() {
            self.n_cut += (self.cells.len() - n_cells) as u64;
            self.cells.truncate(n_cells);
            let is_behind = |foreign: &Foreign| foreign.address >= n_cells;
            if self.foreign.last().is_some_and(is_behind) || !self.exports.is_empty() {
                self.cut_outside(n_cells);
            }
        }
    }

    /// Forgets what lies behind so many cells, and all that has been exported.
    pub(crate) fn reset(&mut self, n_cells: usize) {
        if !self.exports.is_empty() {
            self.exports.clear();
            self.cut_outside(n_cells);
        }
        self.cut(n_cells);
    }

    /// Cuts the heap behind so many cells, but for the strings, objects and lights that these words refer
    /// to. Since such values refer to nothing in the heap, they can be moved to its new end.
    pub(crate) fn cut_around(&mut self, n_cells: usize, in_use: &mut [Word]) {
        let n_foreign = self.foreign.partition_point(|foreign| foreign.address < n_cells);
        let refers_behind = |word: &Word| word.is_foreign() && word.address() >= n_foreign;
        let mut kept: Vec<usize> =
            in_use.iter().filter(|word| refers_behind(word)).map(|word| word.address()).collect();
        if kept.is_empty() {
            return self.cut(n_cells);
        }
        kept.sort_unstable();
        kept.dedup();
        for word in in_use.iter_mut().filter(|word| refers_behind(word)) {
            let place = kept.partition_point(|index| *index < word.address());
            word.x = (n_foreign + place) as u64;
        }
        let (mut rest, mut moved) = (&kept[..], Vec::with_capacity(kept.len()));
        // The youngest go first: what others hold goes after those.
        while self.foreign.len() > n_foreign
            && let Some(foreign) = self.foreign.pop()
        {
            match rest.split_last() {
                Some((last, before)) if *last == self.foreign.len() => {
                    rest = before;
                    moved.push(foreign);
                }
                _ => self.outside_bytes -= foreign.bytes_freed(),
            }
        }
        self.exports.retain(|address, _| *address < n_cells);
        for export in self.exports.values_mut() {
            export.n_foreign = export.n_foreign.min(n_foreign);
        }
        self.n_cut += (self.cells.len() - n_cells) as u64;
        self.cells.truncate(n_cells);
        while let Some(foreign) = moved.pop() {
            // Whatever they or other values outside still hold is counted until all of them go.
            let (address, outside_bytes) = (self.allocate(0), self.outside_bytes);
            self.foreign.push(Foreign { address, outside_bytes, ..foreign });
        }
    }

    /// Forgets what is outside of what has been cut off.
    #[inline(never)]
    fn cut_outside(&mut self, n_cells: usize) {
        let n_foreign = self.foreign.partition_point(|foreign| foreign.address < n_cells);
        self.foreign.truncate(n_foreign);
        self.outside_bytes = self.foreign.last().map_or(0, |foreign| foreign.outside_bytes);
        // What was exported before the last foreign value is counted with that.
        self.exports.retain(|address, export| {
            let stays = *address < n_cells;
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
