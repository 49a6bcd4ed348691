//! The heap of one machine: closures and arrays as runs of words, and values from outside.
//!
//! A closure or an array is a header with its number of words, followed by those words. A header
//! also knows the function of a closure and which value, if any, the closure or array has become
//! outside the machine (see [`exchange`](crate::exchange)). Strings, objects and lights are held
//! as values beside the cells.
//!
//! Memory is reclaimed by copying what is in reach (Cheney 1970), without recursion however deeply
//! values are nested. What was there when the heap was [settled](Heap::settle) stays where it is.

use crate::memory;
use crate::value::Value;
use crate::word::{Tag, Word};

/// For a header: it has no value outside.
const NONE: u64 = u64::MAX;

/// Closures, arrays, and what words cannot hold.
#[derive(Clone, Default)]
pub(crate) struct Heap {
    cells: Vec<Word>,
    foreign: Vec<Value>,
    /// Cells and foreign values before these never move nor go.
    settled: (usize, usize),
    /// Bytes that the foreign values take, at most.
    foreign_bytes: u64,
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
        self.cells.push(Word { tag: Tag::Header, x: n_words as u64, y: 0, z: NONE });
        self.cells.resize(address + 1 + n_words, Word::NOTHING);
        address
    }

    /// Takes in a string, an object or a light, which owns so many bytes.
    pub(crate) fn adopt(&mut self, tag: Tag, value: Value, n_bytes: u64) -> Word {
        Word::new(tag, self.keep(value, n_bytes))
    }

    fn keep(&mut self, value: Value, n_bytes: u64) -> u64 {
        self.foreign_bytes += n_bytes + size_of::<Value>() as u64;
        self.foreign.push(value);
        self.foreign.len() as u64 - 1
    }

    /// A string, an object or a light.
    pub(crate) fn foreign(&self, word: Word) -> &Value {
        &self.foreign[word.address()]
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
        let index = self.cells[address].z;
        (index != NONE).then(|| &self.foreign[index as usize])
    }

    pub(crate) fn set_exported(&mut self, address: usize, value: Value) {
        let n_bytes = memory::bytes_for(self.cells[address].x as usize);
        self.cells[address].z = self.keep(value, n_bytes);
    }

    /// Bytes in use, values that are no longer in reach included.
    #[inline(always)]
    pub(crate) fn n_bytes(&self) -> u64 {
        (self.cells.len() * size_of::<Word>()) as u64 + self.foreign_bytes
    }

    /// Keeps for good, and in its place, all that is here now.
    pub(crate) fn settle(&mut self) {
        self.settled = (self.cells.len(), self.foreign.len());
    }
}

/// A collection under way: what is in reach has been copied to a new heap, and the cells in the new
/// one from some index on still refer to the old.
pub(crate) struct Collection<'h> {
    heap: &'h mut Heap,
    old_cells: Vec<Word>,
    old_foreign: Vec<Value>,
    /// Where foreign values are now.
    new_places: Vec<u64>,
}

impl<'h> Collection<'h> {
    pub(crate) fn begin(heap: &'h mut Heap) -> Self {
        let (n_cells, n_foreign) = heap.settled;
        let old_cells = std::mem::take(&mut heap.cells);
        heap.cells.extend_from_slice(&old_cells[..n_cells]);
        let old_foreign = heap.foreign.split_off(n_foreign);
        let new_places = vec![NONE; old_foreign.len()];
        Collection { heap, old_cells, old_foreign, new_places }
    }

    /// Keeps what a word refers to, and makes the word say where that is now.
    pub(crate) fn keep(&mut self, word: &mut Word) {
        match word.tag {
            Tag::Closure | Tag::Array => word.x = self.moved(word.address()) as u64,
            Tag::Str | Tag::Object | Tag::Light => word.x = self.moved_foreign(word.x),
            Tag::Header if word.z != NONE => word.z = self.moved_foreign(word.z),
            _ => {}
        }
    }

    /// Keeps a closure or an array; returns where it is now.
    pub(crate) fn moved(&mut self, address: usize) -> usize {
        if address < self.heap.settled.0 {
            return address;
        }
        let header = self.old_cells[address];
        if header.tag == Tag::Moved {
            return header.address();
        }
        let new_address = self.heap.cells.len();
        let n_words = header.x as usize;
        self.heap.cells.extend_from_slice(&self.old_cells[address..=address + n_words]);
        self.old_cells[address] = Word::new(Tag::Moved, new_address as u64);
        new_address
    }

    fn moved_foreign(&mut self, index: u64) -> u64 {
        let n_settled = self.heap.settled.1 as u64;
        if index < n_settled {
            return index;
        }
        let old = (index - n_settled) as usize;
        if self.new_places[old] == NONE {
            self.new_places[old] = self.heap.foreign.len() as u64;
            let value = std::mem::replace(&mut self.old_foreign[old], Value::Bool(false));
            self.heap.foreign.push(value);
        }
        self.new_places[old]
    }

    /// Keeps what is in reach of what has been kept, and forgets the rest.
    pub(crate) fn finish(mut self) {
        let mut scanned = 0;
        while scanned < self.heap.cells.len() {
            let mut cell = self.heap.cells[scanned];
            self.keep(&mut cell);
            self.heap.cells[scanned] = cell;
            scanned += 1;
        }
        self.heap.foreign_bytes = memory::count(self.heap.foreign.iter());
    }
}
