//! What stays when the heap is cut, and what it is said to take.

use std::sync::Arc;

use renderer::object::ShapeKind;

use super::*;
use crate::value::Array;

fn string(heap: &mut Heap) -> Word {
    heap.adopt(Tag::Str, Value::Str("text".into()), 100)
}

#[test]
fn what_is_older_than_the_cut_stays() {
    let mut heap = Heap::default();
    let old = heap.array(3);
    let kept = heap.closure(7, 2);
    let n_bytes = heap.n_bytes();
    heap.array(100);
    heap.cut(heap.end(kept));
    assert_eq!(heap.n_bytes(), n_bytes);
    assert_eq!((heap.length(old.address()), heap.function(kept.address())), (3, 7));
    assert_eq!(heap.n_made(), 4 + 3 + 101);
    heap.cut(heap.end(old));
    assert_eq!(heap.n_cells(), 4);
    heap.cut(100);
    assert_eq!((heap.n_cells(), heap.length(old.address())), (4, 3));
}

#[test]
fn foreign_values_have_their_place_among_the_cells() {
    let mut heap = Heap::default();
    let first = string(&mut heap);
    let array = heap.array(1);
    let with_array = heap.n_bytes();
    let second = string(&mut heap);
    let with_second = heap.n_bytes();
    string(&mut heap);
    heap.cut(heap.end(second));
    assert_eq!(heap.n_bytes(), with_second);
    assert!(matches!(heap.foreign(second), Value::Str(_)));
    heap.cut(heap.end(array));
    assert_eq!((heap.n_bytes(), heap.foreign.len()), (with_array, 1));
    heap.cut(heap.end(first));
    assert_eq!((heap.n_cells(), heap.foreign.len()), (1, 1));
    assert_eq!(heap.end(Word::new(Tag::Int, 12)), 0);
}

#[test]
fn objects_in_use_move_to_where_the_heap_is_cut() {
    let mut heap = Heap::default();
    let surface = Arc::new(Closure::new(0, Vec::new()));
    let array = heap.array(2);
    let with_array = heap.n_bytes();
    let adopt = |heap: &mut Heap, object: &Object<Arc<Closure>>| {
        heap.adopt(Tag::Object, Value::Object(object.clone()), OBJECT_BYTES)
    };
    let sphere = || Object::shape(ShapeKind::Sphere, surface.clone());
    let parts = [sphere(), sphere()];
    let whole = parts[0].union(&parts[1]);
    let other = parts[0].difference(&parts[1]);
    adopt(&mut heap, &parts[0]);
    adopt(&mut heap, &parts[1]);
    let [unused, used] = [&other, &whole].map(|object| adopt(&mut heap, object));
    let last = adopt(&mut heap, &sphere());
    let n_bytes = heap.n_bytes();
    drop((parts, other));

    let mut in_use = [Word::new(Tag::Int, unused.x), last, used, array, last];
    heap.cut_around(heap.end(array), &mut in_use);
    let places = [unused.x, 1, 0, array.x, 1];
    assert_eq!(in_use.map(|word| word.x), places);
    assert_eq!(heap.n_cells(), 3 + 2);
    // Three have gone, and the memory of the one that nobody holds.
    let of_three = 3 * (size_of::<Foreign>() + size_of::<Word>()) as u64;
    assert_eq!(heap.n_bytes(), n_bytes - of_three - OBJECT_BYTES);
    assert!(matches!(heap.foreign(in_use[1]), Value::Object(last) if last.n_shapes() == 1));
    let Value::Object(found) = heap.foreign(in_use[2]) else { panic!("an object was in use") };
    assert_eq!(found.address(), whole.address());

    // What is older than the cut stays where it is.
    let mut again = in_use;
    heap.cut_around(heap.n_cells(), &mut again);
    assert_eq!(again.map(|word| word.x), places);
    heap.cut(heap.end(array));
    assert_eq!(heap.n_bytes(), with_array);
}

#[test]
fn what_was_exported_is_counted_once_for_as_long_as_somebody_may_hold_it() {
    let mut heap = Heap::default();
    let value = || Value::Array(Arc::new(Array::new(vec![Value::Int(1)])));
    let old = heap.array(1);
    heap.set_exported(old.address(), value());
    let with_old = heap.n_bytes();
    let mark = heap.n_cells();
    let young = heap.array(1);
    heap.set_exported(young.address(), value());
    let before_string = heap.n_bytes();
    let holder = string(&mut heap);
    let with_all = heap.n_bytes();

    // The string may hold what the arrays have become; further strings hold nothing more.
    let mut held = heap.clone();
    string(&mut held);
    held.cut(held.end(holder));
    assert_eq!(held.n_bytes(), with_all);
    assert!(held.exported(old.address()).is_some() && held.exported(young.address()).is_some());

    for _ in 0..3 {
        heap.cut(mark);
        assert_eq!(heap.n_bytes(), with_old);
        assert!(heap.exported(old.address()).is_some() && heap.exported(young.address()).is_none());
        let young = heap.array(1);
        heap.set_exported(young.address(), value());
        assert_eq!(heap.n_bytes(), before_string);
        string(&mut heap);
        assert_eq!(heap.n_bytes(), with_all);
    }
}
