//! A bounding volume hierarchy: which of many boxes a ray meets, the near ones first.
//!
//! Built top-down by the surface area heuristic over bins (Wald, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies", 2007), the halves of large sets in parallel. Two levels of that are
//! one node here, whose four boxes are tested at once (Dammertz, Hanika and Keller, "Shallow Bounding
//! Volume Hierarchies", 2008). Boxes are stored in single precision, rounded outward.

use std::ops::ControlFlow;

use crate::bounds::Bounds;
use crate::ray::{Boxes, Line};

mod build;

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

/// What is left to visit, nearest last, and where the ray enters it: memory that is kept from ray to
/// ray. All children of a node but one wait on each level.
#[derive(Debug)]
pub(crate) struct Pending([(Child, f64); MAX_DEPTH * (WIDTH - 1) + 1]);

impl Default for Pending {
    fn default() -> Self {
        Pending([(Child::Nothing, 0.0); MAX_DEPTH * (WIDTH - 1) + 1])
    }
}

impl Hierarchy {
    /// A hierarchy of numbered boxes. Empty ones are left out.
    pub(crate) fn new(boxes: impl Iterator<Item = (u32, Bounds)>) -> Self {
        build::build(boxes)
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

    /// Visits the items whose boxes a ray meets between its origin and `t_end`, roughly from near to
    /// far, until `visit` breaks; `visit` may lower `t_end`.
    #[inline(always)]
    pub(crate) fn visit<B>(
        &self,
        line: &Line,
        t_end: f64,
        pending: &mut Pending,
        visit: impl FnMut(u32, &mut f64) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        self.visit_with(&self.unbounded, line, t_end, pending, visit)
    }

    /// The same, but with only these of the items without finite bounds.
    #[inline(always)]
    pub(crate) fn visit_with<B>(
        &self,
        unbounded: &[u32],
        line: &Line,
        t_end: f64,
        Pending(pending): &mut Pending,
        mut visit: impl FnMut(u32, &mut f64) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let mut t_end = t_end;
        let mut unbounded = unbounded.iter();
        let mut n_pending = usize::from(!self.nodes.is_empty());
        pending[0] = (Child::Node(0), 0.0);
        loop {
            let child = if let Some(&item) = unbounded.next() {
                Child::Item(item)
            } else if n_pending > 0 {
                n_pending -= 1;
                let (child, t) = pending[n_pending];
                if t <= t_end { child } else { Child::Nothing }
            } else {
                return ControlFlow::Continue(());
            };
            match child {
                Child::Item(item) => visit(item, &mut t_end)?,
                Child::Node(index) => {
                    let node = &self.nodes[index as usize];
                    let (enter, mut met) = line.enters(&node.boxes, t_end);
                    let first = n_pending;
                    while met != 0 {
                        let side = met.trailing_zeros() as usize;
                        met &= met - 1;
                        let mut place = n_pending;
                        while place > first && pending[place - 1].1 < enter[side] {
                            pending[place] = pending[place - 1];
                            place -= 1;
                        }
                        pending[place] = (node.children[side], enter[side]);
                        n_pending += 1;
                    }
                }
                Child::Nothing => {}
            }
        }
    }
}

#[cfg(test)]
mod tests;
