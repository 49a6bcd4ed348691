//! A bounding volume hierarchy: which of many boxes a ray meets, the near ones first.
//!
//! Built top-down by the surface area heuristic over bins (Wald, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies", 2007), the halves of large sets in parallel. Boxes are stored in
//! single precision, rounded outward.

use std::ops::ControlFlow;

use crate::bounds::Bounds;
use crate::ray::Line;

mod build;

/// Items at most in a leaf of the hierarchy.
const MAX_ITEMS: usize = 4;

/// Levels at most: the builder halves sets by number where the heuristic goes deeper than half.
const MAX_DEPTH: usize = 64;

/// Numbered boxes, for finding those that a ray meets.
#[derive(Debug, Default)]
pub(crate) struct Hierarchy {
    /// What holds all bounded items, if there are any, and the box around it.
    root: Option<(Box32, Child)>,
    nodes: Vec<Node>,
    /// Numbers of items, those of one leaf in a row.
    items: Vec<u32>,
    /// Items without finite bounds, which every ray is taken to meet.
    unbounded: Vec<u32>,
}

/// Two children and the boxes around them.
#[derive(Clone, Copy, Debug)]
struct Node {
    boxes: [Box32; 2],
    children: [Child; 2],
}

#[derive(Clone, Copy, Debug)]
struct Box32 {
    lo: [f32; 3],
    hi: [f32; 3],
}

/// A node, or a few items.
#[derive(Clone, Copy, Debug)]
struct Child {
    /// The node, or where in the list the items begin.
    first: u32,
    /// Number of items, 0 for a node.
    n_items: u32,
}

/// What is left to visit, nearest last: memory that is kept from ray to ray.
#[derive(Debug)]
pub(crate) struct Pending([(Child, f64); MAX_DEPTH]);

impl Default for Pending {
    fn default() -> Self {
        Pending([(Child { first: 0, n_items: 0 }, 0.0); MAX_DEPTH])
    }
}

impl Hierarchy {
    /// A hierarchy of numbered boxes. Empty ones are left out.
    pub(crate) fn new(boxes: impl Iterator<Item = (u32, Bounds)>) -> Self {
        build::build(boxes)
    }

    /// The size of the largest coordinate of its boxes.
    pub(crate) fn extent(&self) -> f64 {
        let of_corner =
            |corner: &[f32; 3]| corner.iter().fold(0.0, |size: f32, x| size.max(x.abs()));
        let root = self.root.as_ref();
        root.map_or(0.0, |(around, _)| of_corner(&around.lo).max(of_corner(&around.hi)).into())
    }

    /// Bytes that it takes.
    #[cfg(test)]
    pub(crate) fn n_bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + (self.items.len() + self.unbounded.len()) * 4
    }

    /// Visits the items whose boxes a ray meets between its origin and `t_end`, roughly from near to
    /// far, until `visit` breaks; `visit` may lower `t_end`.
    #[inline]
    pub(crate) fn visit<B>(
        &self,
        line: &Line,
        t_end: f64,
        Pending(pending): &mut Pending,
        mut visit: impl FnMut(u32, &mut f64) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let mut t_end = t_end;
        for &item in &self.unbounded {
            visit(item, &mut t_end)?;
        }
        let Some((around, mut current)) = self.root else { return ControlFlow::Continue(()) };
        if line.enters(&around.lo, &around.hi, t_end).is_none() {
            return ControlFlow::Continue(());
        }
        let mut n_pending = 0;
        loop {
            if current.n_items == 0 {
                let node = &self.nodes[current.first as usize];
                let met = [0, 1]
                    .map(|side| line.enters(&node.boxes[side].lo, &node.boxes[side].hi, t_end));
                match met {
                    [Some(t0), Some(t1)] => {
                        let near = usize::from(t1 < t0);
                        pending[n_pending] = (node.children[1 - near], t0.max(t1));
                        n_pending += 1;
                        current = node.children[near];
                        continue;
                    }
                    [Some(_), None] => {
                        current = node.children[0];
                        continue;
                    }
                    [None, Some(_)] => {
                        current = node.children[1];
                        continue;
                    }
                    [None, None] => {}
                }
            } else {
                let items = &self.items[current.first as usize..][..current.n_items as usize];
                for &item in items {
                    visit(item, &mut t_end)?;
                }
            }
            loop {
                if n_pending == 0 {
                    return ControlFlow::Continue(());
                }
                n_pending -= 1;
                let (child, t) = pending[n_pending];
                if t <= t_end {
                    current = child;
                    break;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
