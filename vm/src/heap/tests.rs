//! What stays when the heap is cut, and what it is said to take.

use std::sync::Arc;

use super::*;
use crate::value::Array;

fn string(heap: &mut Heap) -> Word {
    heap.adopt(Tag::Str, Value::Str("text".into()), 100)
}

fn extent_of(heap: &Heap, words: &[Word]) -> Extent {
    heap.extent_of(Extent::default(), words.iter())
}

#[test]
fn what_is_younger_than_all_in_use_goes() {
    let mut heap = Heap::default();
    let old = heap.array(3);
    let kept = heap.closure(7, 2);
    let n_bytes = heap.n_bytes();
    heap.array(100);
    heap.cut(extent_of(&heap, &[old, kept]));
    assert_eq!(heap.n_bytes(), n_bytes);
    assert_eq!((heap.length(old.address()), heap.function(kept.address())), (3, 7));
    assert_eq!(heap.n_made(), 4 + 3 + 101);
    let extent = extent_of(&heap, &[old]);
    assert_eq!(heap.growth_since(extent), 3);
    heap.cut(extent);
    assert_eq!(heap.growth_since(extent), 0);
}

#[test]
fn foreign_values_stay_while_they_are_in_use_or_cells_may_hold_them() {
    let mut heap = Heap::default();
    let first = string(&mut heap);
    let holder = heap.array(1);
    let second = string(&mut heap);
    let third = string(&mut heap);
    let with_second = heap.n_bytes() - 100 - size_of::<Foreign>() as u64;
    heap.cut(extent_of(&heap, &[second]));
    assert_eq!(heap.extent(), Extent { n_cells: 0, n_foreign: 2 });
    assert!(matches!(heap.foreign(second), Value::Str(_)) && third.address() == 2);

    let mut heap_with_holder = Heap::default();
    assert_eq!(string(&mut heap_with_holder).address(), first.address());
    let holder_there = heap_with_holder.array(1);
    assert_eq!(holder_there.address(), holder.address());
    string(&mut heap_with_holder);
    assert_eq!(heap_with_holder.n_bytes(), with_second);
    heap_with_holder.cut(extent_of(&heap_with_holder, &[holder_there]));
    // The array may hold the first string, but not the second.
    assert_eq!(heap_with_holder.extent(), Extent { n_cells: 2, n_foreign: 1 });
}

#[test]
fn foreign_values_within_the_extent_stay_though_nothing_follows_them() {
    let mut heap = Heap::default();
    string(&mut heap);
    let mark = heap.extent();
    string(&mut heap);
    heap.cut(heap.extent_of(mark, [].iter()));
    assert_eq!(heap.extent(), mark);
}

#[test]
fn what_was_exported_is_counted_once_for_as_long_as_somebody_may_hold_it() {
    let mut heap = Heap::default();
    let value = || Value::Array(Arc::new(Array::new(vec![Value::Int(1)])));
    let old = heap.array(1);
    heap.set_exported(old.address(), value());
    let with_old = heap.n_bytes();
    let mark = heap.extent();
    let young = heap.array(1);
    heap.set_exported(young.address(), value());
    let before_string = heap.n_bytes();
    let holder = string(&mut heap);
    let with_all = heap.n_bytes();

    // The young array goes, but the string may hold what it has become.
    let mut held = heap.clone();
    held.cut(extent_of(&held, &[old, holder]));
    assert_eq!(held.n_bytes(), with_all - 2 * size_of::<Word>() as u64);
    assert!(held.exported(old.address()).is_some() && held.exported(young.address()).is_none());

    for _ in 0..3 {
        heap.cut(mark);
        assert_eq!(heap.n_bytes(), with_old);
        let young = heap.array(1);
        heap.set_exported(young.address(), value());
        assert_eq!(heap.n_bytes(), before_string);
        string(&mut heap);
        assert_eq!(heap.n_bytes(), with_all);
    }
}
