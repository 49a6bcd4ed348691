//! A bounding volume hierarchy: which of many boxes a ray meets, the near ones first.
//!
//! Built top-down by the surface area heuristic over bins (Wald, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies", 2007), the halves of large sets in parallel. Two levels of that are
//! one node here, whose four boxes are tested at once (Dammertz, Hanika and Keller, "Shallow Bounding
//! Volume Hierarchies", 2008). Boxes are stored in single precision, rounded outward.

use crate::ray::{Boxes, Line};

mod build;
mod start;

pub(crate) use build::Item;
pub(crate) use start::Start;

/// Children of a node.
const WIDTH: usize = 4;

/// Levels at most: the builder halves sets by number where the heuristic goes deeper than half.
const MAX_DEPTH: usize = 64;

/// Numbered boxes, for finding those that a ray meets.
#[derive(Debug, Default)]
pub(crate) struct Hierarchy {
    /// The root first, if there are bounded items.
    nodes: Vec<Node>,
    /// Items without finite bounds, which every ray is taken to meet.
    unbounded: Vec<u32>,
    /// The size of the largest coordinate of any box.
    extent: f64,
}

/// Children and the boxes around them.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Node {
    boxes: Boxes<WIDTH>,
    children: [Child; WIDTH],
}

#[derive(Clone, Copy, Debug)]
enum Child {
    Node(u32),
    Item(u32),
    Nothing,
}

/// What waits at most: on each level all children of a node but one, and at first all of a start.
const MAX_PENDING: usize = MAX_DEPTH * (WIDTH - 1) + start::MAX_NODES * WIDTH;

/// What is left to visit, nearest last, and where the ray enters it: memory that is kept from ray to
/// ray.
#[derive(Debug)]
pub(crate) struct Pending([(Child, f64); MAX_PENDING]);

impl Default for Pending {
    fn default() -> Self {
        Pending([(Child::Nothing, 0.0); MAX_PENDING])
    }
}

impl Hierarchy {
    /// A hierarchy of numbered boxes. Empty ones are left out.
    pub(crate) fn new(items: Vec<Item>) -> Self {
        build::build(items)
    }

    /// The size of the largest coordinate of its boxes.
    pub(crate) fn extent(&self) -> f64 {
        self.extent
    }

    /// Bytes that it takes.
    #[cfg(test)]
    pub(crate) fn n_bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.unbounded.len() * 4
    }

    /// The items without finite bounds.
    pub(crate) fn unbounded(&self) -> &[u32] {
        &self.unbounded
    }

    /// Looks for the items whose boxes a ray meets.
    #[inline(always)]
    pub(crate) fn candidates<'h>(
        &'h self,
        line: &'h Line,
        pending: &'h mut Pending,
    ) -> Candidates<'h> {
        pending.0[0] = (Child::Node(0), 0.0);
        let n_pending = usize::from(!self.nodes.is_empty());
        let (nodes, unbounded) = (&self.nodes[..], self.unbounded.iter());
        Candidates { nodes, unbounded, line, pending: &mut pending.0, n_pending }
    }

    /// The same for a line of the beam that the start was found for.
    #[inline(always)]
    pub(crate) fn candidates_from<'h>(
        &'h self,
        start: &Start,
        line: &'h Line,
        pending: &'h mut Pending,
    ) -> Candidates<'h> {
        debug_assert!(start.holds(line));
        let mut candidates = Candidates { n_pending: 0, ..self.candidates(line, pending) };
        if let Some(child) = start.only_child() {
            candidates.pending[0] = (child, 0.0);
            candidates.n_pending = 1;
        } else {
            for node in start.nodes() {
                candidates.open::<true>(node, 0, f64::INFINITY);
            }
        }
        candidates
    }
}

/// The items of a hierarchy that a ray may meet, roughly from near to far after those without finite
/// bounds.
pub(crate) struct Candidates<'h> {
    nodes: &'h [Node],
    unbounded: std::slice::Iter<'h, u32>,
    line: &'h Line,
    pending: &'h mut [(Child, f64)],
    n_pending: usize,
}

impl<'h> Candidates<'h> {
    /// The same, but with only these of the items without finite bounds.
    #[inline(always)]
    pub(crate) fn with_unbounded(self, unbounded: &'h [u32]) -> Self {
        Candidates { unbounded: unbounded.iter(), ..self }
    }

    /// The next item whose box the ray meets between its origin and `t_end`, which may become less
    /// from call to call.
    #[inline(always)]
    pub(crate) fn next(&mut self, t_end: f64) -> Option<u32> {
        self.advance::<true>(t_end)
    }

    /// The same, but for the order of items, which takes time to keep.
    #[inline(always)]
    pub(crate) fn next_unordered(&mut self, t_end: f64) -> Option<u32> {
        self.advance::<false>(t_end)
    }

    #[inline(always)]
    fn advance<const ORDERED: bool>(&mut self, t_end: f64) -> Option<u32> {
        if let Some(&item) = self.unbounded.next() {
            return Some(item);
        }
        while self.n_pending > 0 {
            self.n_pending -= 1;
            match self.pending[self.n_pending] {
                (_, t) if t > t_end => {}
                (Child::Item(item), _) => return Some(item),
                (Child::Node(index), _) => {
                    self.open::<ORDERED>(&self.nodes[index as usize], self.n_pending, t_end);
                }
                (Child::Nothing, _) => {}
            }
        }
        None
    }

    /// Puts the children of a node whose boxes are met on the stack, if `ORDERED` the nearest of all
    /// from `first` on last.
    #[inline(always)]
    fn open<const ORDERED: bool>(&mut self, node: &Node, first: usize, t_end: f64) {
        let (enter, mut met) = self.line.enters(&node.boxes, t_end);
        while met != 0 {
            let side = met.trailing_zeros() as usize;
            met &= met - 1;
            let mut place = self.n_pending;
            while ORDERED && place > first && self.pending[place - 1].1 < enter[side] {
                self.pending[place] = self.pending[place - 1];
                place -= 1;
            }
            self.pending[place] = (node.children[side], enter[side]);
            self.n_pending += 1;
        }
    }
}

#[cfg(test)]
mod tests;
