//! Building a hierarchy.
//!
//! All is decided by minima, maxima and counts, which come out the same in any order: the tree is the
//! same for any number of threads.

use rayon::prelude::*;

use crate::bounds::Bounds;
use crate::hierarchy::{Child, Hierarchy, MAX_DEPTH, Node, WIDTH};
use crate::ray::Boxes;

/// Bins that centres are sorted into along an axis, at most: as many as Wald found enough.
const MAX_BINS: usize = 16;

/// Bins that are enough for sets of 19 items or fewer, of which there are the most.
const FEW_BINS: usize = 8;

/// Sets larger than this are built by several threads: that takes about a millisecond, and handing a part
/// over a few microseconds.
const PARALLEL: usize = 4096;

/// Such sets are divided into so many branches or a few more.
const PARTS: usize = 64;

/// Of which each thread builds so many at a time, at best.
const BRANCHES: usize = 4;

/// So many items are sorted into bins by one thread.
const CHUNK: usize = 1 << 16;

/// A box with finite ends. The fourth numbers mean nothing: four are compared as fast as three are not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box32 {
    pub(super) lo: [f32; 4],
    pub(super) hi: [f32; 4],
}

/// A box to be placed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Item {
    bounds: Box32,
    number: u32,
}

impl Item {
    /// A numbered box, rounded outward.
    pub(crate) fn new(number: u32, bounds: &Bounds) -> Item {
        // What is empty stays so, however it is rounded.
        let bounds = if bounds.is_empty() { Box32::NOTHING } else { Box32::around(bounds) };
        Item { bounds, number }
    }

    /// Twice the centre.
    #[inline(always)]
    fn centre(&self) -> [f32; 4] {
        std::array::from_fn(|axis| self.bounds.lo[axis] + self.bounds.hi[axis])
    }
}

pub(super) fn build(mut items: Vec<Item>) -> Hierarchy {
    let mut hierarchy = Hierarchy::default();
    items.retain(|item| {
        let is_bounded = item.bounds.is_finite();
        if !is_bounded && !item.bounds.is_empty() {
            hierarchy.unbounded.push(item.number);
        }
        is_bounded
    });
    hierarchy.unbounded.sort_unstable();
    if items.is_empty() {
        return hierarchy;
    }
    let bounds = items.iter().fold(Box32::NOTHING, |bounds, item| bounds.or(&item.bounds));
    let centres = centre_bounds(&items);
    let size = |corner: &[f32; 4]| corner[..3].iter().fold(0.0, |size: f32, x| size.max(x.abs()));
    hierarchy.extent = size(&bounds.lo).max(size(&bounds.hi)).into();
    let is_large = items.len() > PARALLEL;
    if is_large {
        // Memory that is not used is not taken; what nodes are moved from is.
        hierarchy.nodes.reserve(most_nodes(items.len()));
    }
    grow(Set { items: &mut items, bounds, centres, depth: 0 }, &mut hierarchy.nodes);
    if !is_large {
        hierarchy.nodes.shrink_to_fit();
    }
    hierarchy
}

/// Nodes that so many items have at most: two or more make a node, and four nodes or items another.
fn most_nodes(n_items: usize) -> usize {
    2 * n_items / 3 + 1
}

/// Items, the boxes around them and around twice their centres, and how often they were split off.
struct Set<'i> {
    items: &'i mut [Item],
    bounds: Box32,
    centres: Box32,
    depth: usize,
}

impl Default for Set<'_> {
    fn default() -> Self {
        Set { items: &mut [], bounds: Box32::NOTHING, centres: Box32::NOTHING, depth: 0 }
    }
}

impl Set<'_> {
    /// The box around it, and its only item; where there are more, the node is not known yet.
    fn side(&self) -> (Box32, Child) {
        let child =
            if let [item] = &*self.items { Child::Item(item.number) } else { Child::Nothing };
        (self.bounds, child)
    }
}

/// Items below a node whose own nodes are to come.
struct Branch<'i> {
    parent: usize,
    side: usize,
    set: Set<'i>,
}

/// Adds the nodes of all items: those that hold many, and the branches below, some at a time in
/// parallel, so that few nodes are anywhere else meanwhile.
fn grow(set: Set<'_>, nodes: &mut Vec<Node>) {
    let is_large = set.items.len() > PARALLEL;
    let most_in_branch = is_large.then(|| PARALLEL.max(set.items.len() / PARTS));
    let mut branches = Vec::new();
    subtree(set, most_in_branch, nodes, &mut branches);
    let n_threads = rayon::current_num_threads();
    if n_threads == 1 {
        for Branch { parent, side, set } in branches {
            nodes[parent].children[side] = Child::Node(nodes.len() as u32);
            subtree(set, None, nodes, &mut Vec::new());
        }
        return;
    }
    let mut branches = branches.into_iter().peekable();
    while branches.peek().is_some() {
        let some: Vec<Branch<'_>> = branches.by_ref().take(BRANCHES * n_threads).collect();
        let built = some.into_par_iter().map(|Branch { parent, side, set }| {
            let mut nodes = Vec::with_capacity(most_nodes(set.items.len()));
            subtree(set, None, &mut nodes, &mut Vec::new());
            (parent, side, nodes)
        });
        for (parent, side, below) in built.collect::<Vec<_>>() {
            let offset = nodes.len() as u32;
            nodes[parent].children[side] = Child::Node(offset);
            nodes.extend(below.into_iter().map(|node| node.moved(offset)));
        }
    }
}

/// Adds the nodes of some items, whose order it changes, first that which holds all; but what holds so
/// many items at most is added to the branches.
fn subtree<'i>(
    set: Set<'i>,
    most_in_branch: Option<usize>,
    nodes: &mut Vec<Node>,
    branches: &mut Vec<Branch<'i>>,
) {
    if set.items.len() <= WIDTH {
        let sides = set.items.iter().map(|item| (item.bounds, Child::Item(item.number)));
        nodes.push(Node::of(sides));
        return;
    }
    let mut sets: [Set<'_>; WIDTH] = Default::default();
    sets[0] = set;
    let mut n_sets = 1;
    // The largest give way to their parts while there is room.
    while n_sets < WIDTH {
        let larger = (0..n_sets).filter(|&k| sets[k].items.len() > 1);
        let area = |k: usize| sets[k].bounds.half_area();
        let Some(largest) = larger.max_by(|&a, &b| area(a).total_cmp(&area(b))) else { break };
        [sets[largest], sets[n_sets]] = split(std::mem::take(&mut sets[largest]));
        n_sets += 1;
    }
    let parent = nodes.len();
    nodes.push(Node::of(sets[..n_sets].iter().map(Set::side)));
    for (side, set) in sets.into_iter().enumerate().filter(|(_, set)| set.items.len() > 1) {
        if most_in_branch.is_some_and(|most| set.items.len() <= most) {
            branches.push(Branch { parent, side, set });
        } else {
            nodes[parent].children[side] = Child::Node(nodes.len() as u32);
            subtree(set, most_in_branch, nodes, branches);
        }
    }
}

impl Node {
    /// A node without children. What holds nothing is where hardly a ray goes: an inverted box would be
    /// met by all.
    pub(super) const NOTHING: Node = Node {
        boxes: Boxes { lo: [[f32::MAX; WIDTH]; 3], hi: [[f32::MAX; WIDTH]; 3] },
        children: [Child::Nothing; WIDTH],
    };

    /// A node with these children and the boxes around them.
    fn of(sides: impl Iterator<Item = (Box32, Child)>) -> Node {
        let mut node = Node::NOTHING;
        for (side, (bounds, child)) in sides.enumerate() {
            node.children[side] = child;
            for axis in 0..3 {
                node.boxes.lo[axis][side] = bounds.lo[axis];
                node.boxes.hi[axis][side] = bounds.hi[axis];
            }
        }
        node
    }

    /// The same when nodes have got numbers higher by `offset`.
    fn moved(self, offset: u32) -> Node {
        let children = self.children.map(|child| match child {
            Child::Node(index) => Child::Node(index + offset),
            other => other,
        });
        Node { children, ..self }
    }
}

/// Splits a set of two or more items.
fn split<'i>(set: Set<'i>) -> [Set<'i>; 2] {
    let Set { items, centres, depth, .. } = set;
    let best = if depth < MAX_DEPTH / 2 { best_split(items, &centres) } else { None };
    let (middle, bounds, centres) = match best {
        Some(best) => {
            let (middle, centres) = partition(items, &best);
            (middle, best.bounds, centres)
        }
        None => {
            let middle = halve(items, &centres);
            let (left, right) = items.split_at(middle);
            let bounds = [left, right].map(|half| {
                half.iter().fold(Box32::NOTHING, |bounds, item| bounds.or(&item.bounds))
            });
            (middle, bounds, [left, right].map(centre_bounds))
        }
    };
    let (left, right) = items.split_at_mut(middle);
    let depth = depth + 1;
    [
        Set { items: left, bounds: bounds[0], centres: centres[0], depth },
        Set { items: right, bounds: bounds[1], centres: centres[1], depth },
    ]
}

/// Puts the first half of the items, by their centres on the longest axis, first.
fn halve(items: &mut [Item], centres: &Box32) -> usize {
    let length = |axis: usize| centres.hi[axis] - centres.lo[axis];
    let axis = (0..3).max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0);
    let middle = items.len() / 2;
    let centre = |item: &Item| item.centre()[axis];
    items.select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)));
    middle
}

/// Centres below the end of a bin, and the others.
struct Split {
    binning: Binning,
    axis: usize,
    end_bin: i32,
    /// Expected tests of items, but for a factor.
    cost: f64,
    /// Around the items on both sides.
    bounds: [Box32; 2],
}

/// How centres are sorted into bins along each axis.
#[derive(Clone, Copy)]
struct Binning {
    start: [f32; 4],
    /// Bins for each unit of length; 0 where all centres are in one place.
    scale: [f32; 4],
    n_bins: usize,
}

impl Binning {
    fn new(centres: &Box32, n_bins: usize) -> Self {
        let scale = |axis: usize| {
            let scale = n_bins as f32 / (centres.hi[axis] - centres.lo[axis]);
            if axis < 3 && scale.is_finite() { scale } else { 0.0 }
        };
        Binning { start: centres.lo, scale: std::array::from_fn(scale), n_bins }
    }

    #[inline(always)]
    fn bin(&self, item: &Item, axis: usize) -> i32 {
        let centre = item.bounds.lo[axis] + item.bounds.hi[axis];
        let bin = ((centre - self.start[axis]) * self.scale[axis]) as i32;
        bin.min(self.n_bins as i32 - 1)
    }
}

/// Puts the items before a split first. Returns how many these are, and the boxes around twice the
/// centres on both sides.
fn partition(items: &mut [Item], split: &Split) -> (usize, [Box32; 2]) {
    let mut middle = 0;
    let mut centres = [Box32::NOTHING; 2];
    for idx in 0..items.len() {
        let item = items[idx];
        let is_right = split.binning.bin(&item, split.axis) >= split.end_bin;
        let side = &mut centres[usize::from(is_right)];
        *side = side.or(&Box32::at(item.centre()));
        items[idx] = items[middle];
        items[middle] = item;
        middle += usize::from(!is_right);
    }
    (middle, centres)
}

/// The items of a bin: the box around them, and their number.
type Bin = (Box32, u32);

/// The bins of each axis.
type Bins<const N: usize> = [[Bin; N]; 3];

/// The split that costs least; none if all centres are the same.
fn best_split(items: &[Item], centres: &Box32) -> Option<Split> {
    // A few items have no use for many bins (Wald and others, "Embree", 2014).
    let n_bins = MAX_BINS.min(4 + items.len() / 4);
    let binning = Binning::new(centres, n_bins);
    if n_bins <= FEW_BINS {
        cheapest::<FEW_BINS>(items, binning)
    } else {
        cheapest::<MAX_BINS>(items, binning)
    }
}

/// The split into N bins or fewer that costs least.
fn cheapest<const N: usize>(items: &[Item], binning: Binning) -> Option<Split> {
    let bins = sorted::<N>(items, &binning);
    let axes = (0..3).filter(|&axis| binning.scale[axis] > 0.0);
    let splits = axes.filter_map(|axis| best_on_axis(items.len(), binning, axis, &bins[axis]));
    splits.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Sorts items into bins.
fn sorted<const N: usize>(items: &[Item], binning: &Binning) -> Bins<N> {
    if items.len() > CHUNK {
        let chunks = items.par_chunks(CHUNK).map(|chunk| sorted(chunk, binning));
        return chunks.reduce(|| [[NO_ITEMS; N]; 3], united);
    }
    let mut bins = [[NO_ITEMS; N]; 3];
    for item in items {
        for (axis, bins) in bins.iter_mut().enumerate() {
            let (bounds, n_items) = &mut bins[binning.bin(item, axis) as usize & (N - 1)];
            *bounds = bounds.or(&item.bounds);
            *n_items += 1;
        }
    }
    bins
}

const NO_ITEMS: Bin = (Box32::NOTHING, 0);

fn united<const N: usize>(mut a: Bins<N>, b: Bins<N>) -> Bins<N> {
    for (bin, other) in a.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
        *bin = with(*bin, other);
    }
    a
}

fn with((bounds, n): Bin, other: &Bin) -> Bin {
    (bounds.or(&other.0), n + other.1)
}

fn best_on_axis<const N: usize>(
    n_items: usize,
    binning: Binning,
    axis: usize,
    bins: &[Bin; N],
) -> Option<Split> {
    let bins = &bins[..binning.n_bins];
    let weight = |(bounds, n): &Bin| bounds.half_area() * f64::from(*n);
    // What lies in the bins before each.
    let mut before = [NO_ITEMS; N];
    for idx in 1..bins.len() {
        before[idx] = with(before[idx - 1], &bins[idx - 1]);
    }
    let mut best: Option<Split> = None;
    let mut so_far = NO_ITEMS;
    for idx in (1..bins.len()).rev() {
        so_far = with(so_far, &bins[idx]);
        let is_split = so_far.1 > 0 && so_far.1 < n_items as u32;
        let cost = weight(&before[idx]) + weight(&so_far);
        if is_split && best.as_ref().is_none_or(|best| cost < best.cost) {
            let bounds = [before[idx].0, so_far.0];
            best = Some(Split { binning, axis, end_bin: idx as i32, cost, bounds });
        }
    }
    best
}

/// The box around twice the centres.
fn centre_bounds(items: &[Item]) -> Box32 {
    items.iter().fold(Box32::NOTHING, |centres, item| centres.or(&Box32::at(item.centre())))
}

impl Box32 {
    /// Around nothing.
    const NOTHING: Box32 = Box32 { lo: [f32::INFINITY; 4], hi: [f32::NEG_INFINITY; 4] };

    /// Around a point.
    fn at(point: [f32; 4]) -> Box32 {
        Box32 { lo: point, hi: point }
    }

    /// Rounded outward.
    pub(super) fn around(bounds: &Bounds) -> Box32 {
        let down = |x: f64| {
            let single = x as f32;
            if f64::from(single) > x { single.next_down() } else { single }
        };
        let ends = |[x, y, z]: [f64; 3]| [x, y, z, 0.0].map(down);
        Box32 {
            lo: ends(bounds.lo.to_array()),
            hi: ends((-bounds.hi).to_array()).map(|negated| -negated),
        }
    }

    /// Whether its ends, and twice its centre, are numbers.
    fn is_finite(&self) -> bool {
        self.lo.iter().chain(&self.hi).all(|end| end.abs() <= f32::MAX / 2.0)
    }

    /// Whether it is around nothing.
    fn is_empty(&self) -> bool {
        self.lo[0] > self.hi[0]
    }

    #[inline(always)]
    fn or(&self, other: &Box32) -> Box32 {
        Box32 {
            lo: std::array::from_fn(|axis| self.lo[axis].min(other.lo[axis])),
            hi: std::array::from_fn(|axis| self.hi[axis].max(other.hi[axis])),
        }
    }

    fn half_area(&self) -> f64 {
        let length = |axis: usize| (f64::from(self.hi[axis]) - f64::from(self.lo[axis])).max(0.0);
        let [x, y, z] = [0, 1, 2].map(length);
        x * y + y * z + z * x
    }
}
