//! Building a hierarchy.

use crate::bounds::Bounds;
use crate::hierarchy::{Box32, Child, Hierarchy, MAX_DEPTH, MAX_ITEMS, Node};

/// Bins that centres are sorted into along an axis, at most: as many as Wald found enough.
const MAX_BINS: usize = 16;

/// Sets larger than this are built by two threads: that takes about a millisecond, and handing half
/// of it over a few microseconds.
const PARALLEL: usize = 4096;

/// What testing the boxes of a node costs, in tests of an item, which bring the ray into its space.
/// 7381 spheres take the same time with 0.5.
const NODE_COST: f64 = 0.25;

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
    let (bounds, child) = subtree(&mut items, 0, 0, &mut hierarchy.nodes);
    hierarchy.root = Some((bounds, child));
    hierarchy.items = items.iter().map(|item| item.number).collect();
    hierarchy
}

/// Builds the subtree of items that begin at `first` in the whole list, and brings them in order.
/// Adds its nodes to others, and returns what holds them and the box around it.
fn subtree(items: &mut [Item], first: u32, depth: usize, nodes: &mut Vec<Node>) -> (Box32, Child) {
    let bounds = items.iter().fold(Box32::NOTHING, |bounds, item| bounds.or(&item.bounds));
    let split = if depth < MAX_DEPTH / 2 { best_split(items, &bounds) } else { None };
    let is_large = items.len() > MAX_ITEMS;
    let middle = match split {
        Some(split) if is_large || split.cost < items.len() as f64 => partition(items, &split),
        _ if is_large => halve(items),
        _ => return (bounds, Child { first, n_items: items.len() as u32 }),
    };
    let is_parallel = items.len() > PARALLEL;
    let (left, right) = items.split_at_mut(middle);
    let node = nodes.len();
    // To be overwritten when the children are known.
    nodes.push(Node { boxes: [bounds; 2], children: [Child { first, n_items: 0 }; 2] });
    let right_first = first + middle as u32;
    let halves = if is_parallel {
        let mut right_nodes = Vec::new();
        let (left, (right_box, right_child)) = rayon::join(
            || subtree(left, first, depth + 1, nodes),
            || subtree(right, right_first, depth + 1, &mut right_nodes),
        );
        let offset = nodes.len() as u32;
        nodes.extend(right_nodes.into_iter().map(|node| node.moved(offset)));
        [left, (right_box, right_child.moved(offset))]
    } else {
        let left = subtree(left, first, depth + 1, nodes);
        [left, subtree(right, right_first, depth + 1, nodes)]
    };
    nodes[node] = Node { boxes: halves.map(|half| half.0), children: halves.map(|half| half.1) };
    (bounds, Child { first: node as u32, n_items: 0 })
}

impl Node {
    /// The same when nodes have got numbers higher by `offset`.
    fn moved(self, offset: u32) -> Node {
        Node { children: self.children.map(|child| child.moved(offset)), ..self }
    }
}

impl Child {
    /// The same when its node has got a number higher by `offset`.
    fn moved(self, offset: u32) -> Child {
        let is_node = self.n_items == 0;
        Child { first: self.first + if is_node { offset } else { 0 }, ..self }
    }
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
    /// Expected tests of items.
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
fn best_split(items: &[Item], bounds: &Box32) -> Option<Split> {
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
    let splits =
        axes.filter_map(|(binning, bins)| best_on_axis(items.len(), bounds, *binning, bins));
    splits.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

fn best_on_axis(
    n_items: usize,
    bounds: &Box32,
    binning: Binning,
    bins: &[Bin; MAX_BINS],
) -> Option<Split> {
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
    let mut best: Option<(usize, f64)> = None;
    let mut so_far = (Box32::NOTHING, 0);
    for idx in (1..bins.len()).rev() {
        so_far = with(so_far, &bins[idx]);
        let is_split = so_far.1 > 0 && so_far.1 < n_items as u32;
        let total = before[idx] + weight(&so_far);
        if is_split && best.is_none_or(|(_, least)| total < least) {
            best = Some((idx, total));
        }
    }
    let (end_bin, weight) = best?;
    Some(Split { binning, end_bin, cost: NODE_COST + weight / bounds.half_area() })
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
