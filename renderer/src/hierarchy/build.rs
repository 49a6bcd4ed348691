//! Building a hierarchy.

use crate::bounds::Bounds;
use crate::hierarchy::{Child, Hierarchy, MAX_DEPTH, Node, WIDTH};
use crate::ray::Boxes;

/// Bins that centres are sorted into along an axis, at most: as many as Wald found enough.
const MAX_BINS: usize = 16;

/// Sets larger than this are built by two threads: that takes about a millisecond, and handing half
/// of it over a few microseconds.
const PARALLEL: usize = 4096;

/// A box with finite ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box32 {
    pub(super) lo: [f32; 3],
    pub(super) hi: [f32; 3],
}

/// A box to be placed.
#[derive(Clone, Copy)]
struct Item {
    bounds: Box32,
    number: u32,
}

impl Item {
    /// Twice the centre.
    fn centre(&self, axis: usize) -> f32 {
        self.bounds.lo[axis] + self.bounds.hi[axis]
    }
}

pub(super) fn build(boxes: impl Iterator<Item = (u32, Bounds)>) -> Hierarchy {
    let mut hierarchy = Hierarchy::default();
    let mut items = Vec::new();
    for (number, bounds) in boxes {
        let single = Box32::around(&bounds);
        if bounds.is_empty() {
            continue;
        } else if single.is_finite() {
            items.push(Item { bounds: single, number });
        } else {
            hierarchy.unbounded.push(number);
        }
    }
    if items.is_empty() {
        return hierarchy;
    }
    let mut pairs = Vec::new();
    let root = subtree(&mut items, 0, &mut pairs);
    let size = |corner: &[f32; 3]| corner.iter().fold(0.0, |size: f32, x| size.max(x.abs()));
    hierarchy.extent = size(&root.0.lo).max(size(&root.0.hi)).into();
    hierarchy.nodes.reserve_exact(pairs.len() / 2 + 1);
    widen(&pairs, vec![root], &mut hierarchy.nodes);
    hierarchy
}

/// Two children and the boxes around them.
#[derive(Clone, Copy)]
struct Pair([(Box32, Child); 2]);

/// Builds the subtree of some items, of which it changes the order. Adds its nodes to others, and
/// returns what holds them and the box around it.
fn subtree(items: &mut [Item], depth: usize, nodes: &mut Vec<Pair>) -> (Box32, Child) {
    let bounds = items.iter().fold(Box32::NOTHING, |bounds, item| bounds.or(&item.bounds));
    if let [item] = items {
        return (bounds, Child::Item(item.number));
    }
    let split = if depth < MAX_DEPTH / 2 { best_split(items) } else { None };
    let middle = match split {
        Some(split) => partition(items, &split),
        None => halve(items),
    };
    let is_parallel = items.len() > PARALLEL;
    let (left, right) = items.split_at_mut(middle);
    let node = nodes.len();
    // To be overwritten when the children are known.
    nodes.push(Pair([(bounds, Child::Nothing); 2]));
    let halves = if is_parallel {
        let mut right_nodes = Vec::new();
        let (left, (right_box, right_child)) = rayon::join(
            || subtree(left, depth + 1, nodes),
            || subtree(right, depth + 1, &mut right_nodes),
        );
        let offset = nodes.len() as u32;
        nodes.extend(right_nodes.into_iter().map(|pair| pair.moved(offset)));
        [left, (right_box, right_child.moved(offset))]
    } else {
        let left = subtree(left, depth + 1, nodes);
        [left, subtree(right, depth + 1, nodes)]
    };
    nodes[node] = Pair(halves);
    (bounds, Child::Node(node as u32))
}

impl Pair {
    /// The same when nodes have got numbers higher by `offset`.
    fn moved(self, offset: u32) -> Pair {
        Pair(self.0.map(|(bounds, child)| (bounds, child.moved(offset))))
    }
}

impl Child {
    /// The same when its node has got a number higher by `offset`.
    fn moved(self, offset: u32) -> Child {
        match self {
            Child::Node(index) => Child::Node(index + offset),
            other => other,
        }
    }
}

/// Adds a node with these children, of which the largest give way to their own while there is room,
/// and all below it. Returns its number.
fn widen(pairs: &[Pair], mut children: Vec<(Box32, Child)>, nodes: &mut Vec<Node>) -> u32 {
    while children.len() < WIDTH {
        let inner = (0..children.len()).filter(|&k| matches!(children[k].1, Child::Node(_)));
        let area = |k: usize| children[k].0.half_area();
        let Some(largest) = inner.max_by(|&a, &b| area(a).total_cmp(&area(b))) else { break };
        if let (_, Child::Node(index)) = children.swap_remove(largest) {
            children.extend(pairs[index as usize].0);
        }
    }
    let number = nodes.len();
    // What holds nothing is where hardly a ray goes: an inverted box would be met by all.
    let boxes = Boxes { lo: [[f32::MAX; WIDTH]; 3], hi: [[f32::MAX; WIDTH]; 3] };
    nodes.push(Node { boxes, children: [Child::Nothing; WIDTH] });
    for (k, (bounds, child)) in children.into_iter().enumerate() {
        let child = match child {
            Child::Node(index) => Child::Node(widen(pairs, pairs[index as usize].0.into(), nodes)),
            other => other,
        };
        let node = &mut nodes[number];
        node.children[k] = child;
        for axis in 0..3 {
            (node.boxes.lo[axis][k], node.boxes.hi[axis][k]) = (bounds.lo[axis], bounds.hi[axis]);
        }
    }
    number as u32
}

/// Puts the first half of the items, by their centres on the longest axis, first.
fn halve(items: &mut [Item]) -> usize {
    let centres = centre_bounds(items);
    let length = |axis: usize| centres.hi[axis] - centres.lo[axis];
    let axis = (0..3).max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0);
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.centre(axis).total_cmp(&b.centre(axis)));
    middle
}

/// Centres below the end of a bin, and the others.
struct Split {
    binning: Binning,
    end_bin: usize,
    /// Expected tests of items, but for a factor.
    cost: f64,
}

/// How centres are sorted into bins along an axis.
#[derive(Clone, Copy)]
struct Binning {
    axis: usize,
    start: f32,
    /// Bins for each unit of length; 0 where all centres are in one place.
    scale: f32,
    n_bins: usize,
}

impl Binning {
    fn new(axis: usize, centres: &Box32, n_bins: usize) -> Self {
        let scale = n_bins as f32 / (centres.hi[axis] - centres.lo[axis]);
        let scale = if scale.is_finite() { scale } else { 0.0 };
        Binning { axis, start: centres.lo[axis], scale, n_bins }
    }

    #[inline]
    fn bin(&self, item: &Item) -> usize {
        let bin = ((item.centre(self.axis) - self.start) * self.scale) as usize;
        bin.min(self.n_bins - 1)
    }
}

fn partition(items: &mut [Item], split: &Split) -> usize {
    let mut middle = 0;
    for idx in 0..items.len() {
        if split.binning.bin(&items[idx]) < split.end_bin {
            items.swap(idx, middle);
            middle += 1;
        }
    }
    middle
}

/// The items of a bin: the box around them, and their number.
type Bin = (Box32, u32);

/// The split that costs least; none if all centres are the same.
fn best_split(items: &[Item]) -> Option<Split> {
    let centres = centre_bounds(items);
    // A few items have no use for many bins (Wald and others, "Embree", 2014).
    let n_bins = MAX_BINS.min(4 + items.len() / 4);
    let binnings = [0, 1, 2].map(|axis| Binning::new(axis, &centres, n_bins));
    let mut bins: [[Bin; MAX_BINS]; 3] = [[(Box32::NOTHING, 0); MAX_BINS]; 3];
    for item in items {
        for (binning, bins) in binnings.iter().zip(&mut bins) {
            let (bounds, n_items) = &mut bins[binning.bin(item)];
            *bounds = bounds.or(&item.bounds);
            *n_items += 1;
        }
    }
    let axes = binnings.iter().zip(&bins).filter(|(binning, _)| binning.scale > 0.0);
    let splits = axes.filter_map(|(binning, bins)| best_on_axis(items.len(), *binning, bins));
    splits.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

fn best_on_axis(n_items: usize, binning: Binning, bins: &[Bin; MAX_BINS]) -> Option<Split> {
    let bins = &bins[..binning.n_bins];
    let with = |(bounds, n): Bin, bin: &Bin| (bounds.or(&bin.0), n + bin.1);
    let weight = |(bounds, n): &Bin| bounds.half_area() * f64::from(*n);
    // The weight of what lies in the bins before each.
    let mut before = [0.0; MAX_BINS];
    let mut so_far = (Box32::NOTHING, 0);
    for (before, bin) in before.iter_mut().zip(bins) {
        *before = weight(&so_far);
        so_far = with(so_far, bin);
    }
    let mut best: Option<Split> = None;
    let mut so_far = (Box32::NOTHING, 0);
    for idx in (1..bins.len()).rev() {
        so_far = with(so_far, &bins[idx]);
        let is_split = so_far.1 > 0 && so_far.1 < n_items as u32;
        let cost = before[idx] + weight(&so_far);
        if is_split && best.as_ref().is_none_or(|best| cost < best.cost) {
            best = Some(Split { binning, end_bin: idx, cost });
        }
    }
    best
}

fn centre_bounds(items: &[Item]) -> Box32 {
    let mut centres = Box32::NOTHING;
    for item in items {
        let centre = [0, 1, 2].map(|axis| item.centre(axis));
        centres = centres.or(&Box32 { lo: centre, hi: centre });
    }
    centres
}

impl Box32 {
    /// Around nothing.
    const NOTHING: Box32 = Box32 { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };

    /// Rounded outward.
    pub(super) fn around(bounds: &Bounds) -> Box32 {
        let down = |x: f64| {
            let single = x as f32;
            if f64::from(single) > x { single.next_down() } else { single }
        };
        let [lo, hi] = [bounds.lo.to_array(), bounds.hi.to_array()];
        Box32 { lo: lo.map(down), hi: hi.map(|x| -down(-x)) }
    }

    /// Whether its ends, and twice its centre, are numbers.
    fn is_finite(&self) -> bool {
        self.lo.iter().chain(&self.hi).all(|end| end.abs() <= f32::MAX / 2.0)
    }

    #[inline]
    fn or(&self, other: &Box32) -> Box32 {
        // No end is NaN, for which `f32::min` would have to look.
        let less = |a: f32, b: f32| if a < b { a } else { b };
        let more = |a: f32, b: f32| if a > b { a } else { b };
        Box32 {
            lo: std::array::from_fn(|axis| less(self.lo[axis], other.lo[axis])),
            hi: std::array::from_fn(|axis| more(self.hi[axis], other.hi[axis])),
        }
    }

    fn half_area(&self) -> f64 {
        let length = |axis| (f64::from(self.hi[axis]) - f64::from(self.lo[axis])).max(0.0);
        let [x, y, z] = std::array::from_fn(length);
        x * y + y * z + z * x
    }
}
