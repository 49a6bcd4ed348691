//! Carvings: intersections of shapes from which others are taken away, as most trees of set operations
//! are. All shapes are convex, so what remains before anything is taken away is one span of a ray, and
//! where the ray enters the solid is either the beginning of that span or the end of one that is taken
//! away. No list of crossings is made for that, nor are they put in order.
//!
//! Wherever crossings are so near to one another that they may tie, or are shared by several faces,
//! there is no answer here, and [`Scene::sweep`] is asked. So the answers are the same.

use crate::numeric::real::Real;
use crate::object::SetOp;
use crate::ray::{Crossing, Reach};
use crate::scene::{Kind, Node, Scene};
use crate::trace::LeafSpan;
use crate::tree::Workspace;

/// With more shapes met than this on a ray, a list in order is quicker: their comparisons with one
/// another grow with the square of the number.
const MAX_SHAPES: usize = 8;

/// The span of a shape that is taken away, of which the exit lies ahead.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taken<R> {
    /// None if the ray starts behind it.
    enter: Option<R>,
    exit: Crossing<R>,
}

/// For the nodes of one tree, in preorder, whether each is part of what is taken away, if the tree is a
/// carving.
pub(crate) fn taken_away(nodes: &[Node], root: u32) -> Option<Vec<bool>> {
    let mut is_taken: Vec<bool> = Vec::with_capacity(nodes.len());
    for (index, node) in nodes.iter().enumerate() {
        let is_above_taken = index > 0 && is_taken[(node.parent - root) as usize];
        let is_this_taken = is_above_taken || node.weight < 0;
        let fits = match node.kind {
            Kind::Leaf(_) => true,
            Kind::Combined(SetOp::Union) => is_this_taken,
            Kind::Combined(SetOp::Intersect | SetOp::Difference) => !is_this_taken,
        };
        if !fits {
            return None;
        }
        is_taken.push(is_this_taken);
    }
    Some(is_taken)
}

/// Whether a crossing lies behind another so far that they cannot tie, nor be taken for one another.
#[inline(always)]
fn is_plainly_behind<R: Real>(t: R, other: R, reach: &Reach<R>) -> bool {
    t.to_f64() - t.radius() > reach.line.end_of_ties(other)
}

/// What of a ray is in all shapes that a carving is carved from.
struct Whole<R> {
    /// The last of the entries that lie ahead.
    enter: Option<Crossing<R>>,
    /// The first exit.
    exit: R,
    /// A bound of all exits from below.
    least_exit: f64,
}

impl<R: Real> Scene<R> {
    /// The first entry of a carving of so many shapes ahead of a ray that starts outside it, if there is
    /// one that is not behind `t_end`. None if a list of crossings must tell.
    #[inline(always)]
    pub(crate) fn carved_entry(
        &self,
        hierarchy: u32,
        n_whole: u32,
        reach: &Reach<R>,
        t_end: f64,
        workspace: &mut Workspace<R>,
    ) -> Option<Option<Crossing<R>>> {
        let Workspace { pending, leaves, taken, .. } = workspace;
        leaves.clear();
        taken.clear();
        let infinite = R::from_f64(f64::INFINITY);
        let mut whole = Whole { enter: None, exit: infinite, least_exit: f64::INFINITY };
        let (mut n_met, mut t_end) = (0, t_end);
        let mut candidates = self.trees[hierarchy as usize].candidates(&reach.line, pending);
        while let Some(leaf) = candidates.next(t_end) {
            if self.leaves[leaf as usize].is_taken_away {
                leaves.push(leaf);
                continue;
            }
            let Some(span) = self.leaf_span(leaf, &reach.ray) else { return Some(None) };
            if !whole.narrow(&span, reach)? {
                return Some(None);
            }
            n_met += 1;
            if n_met == n_whole {
                t_end = t_end.min(reach.line.end_of_ties(whole.exit));
            }
        }
        if n_met < n_whole {
            return Some(None);
        }
        if leaves.len() > MAX_SHAPES {
            return None;
        }
        for &leaf in leaves.iter() {
            let Some(LeafSpan { enter, exit }) = self.leaf_span(leaf, &reach.ray) else { continue };
            if reach.is_plainly_ahead(exit.t)? {
                let is_ahead = reach.is_plainly_ahead(enter.t)?;
                taken.push(Taken { enter: is_ahead.then_some(enter.t), exit });
            }
        }
        self.first_remaining(&whole, taken, reach)
    }

    /// Where the first part of the whole begins that is not taken away.
    #[inline(always)]
    fn first_remaining(
        &self,
        whole: &Whole<R>,
        taken: &[Taken<R>],
        reach: &Reach<R>,
    ) -> Option<Option<Crossing<R>>> {
        let mut first = match whole.enter {
            Some(enter) => enter,
            // It starts in the whole, so that it must start in what is taken away.
            None => taken.iter().find(|taken| taken.enter.is_none())?.exit,
        };
        loop {
            if is_plainly_behind(first.t, whole.exit, reach) {
                return Some(None);
            }
            if whole.least_exit <= reach.line.end_of_ties(first.t) {
                return None;
            }
            let mut around = None;
            for taken in taken {
                if taken.exit.leaf == first.leaf {
                    continue;
                }
                let is_left = is_plainly_behind(first.t, taken.exit.t, reach);
                let is_entered =
                    taken.enter.is_none_or(|enter| is_plainly_behind(first.t, enter, reach));
                let is_yet_to_come =
                    taken.enter.is_some_and(|enter| is_plainly_behind(enter, first.t, reach));
                if is_entered && is_plainly_behind(taken.exit.t, first.t, reach) {
                    around = Some(taken.exit);
                } else if !is_left && !is_yet_to_come {
                    return None;
                }
            }
            match around {
                Some(exit) => first = exit,
                None => break,
            }
        }
        let face = first.root().face();
        let is_shared = self.face_surface(&self.leaves[first.leaf as usize], face) < self.n_shared;
        (!is_shared).then(|| Some(Crossing::new(first.t, first.leaf, first.root(), true)))
    }
}

impl<R: Real> Whole<R> {
    /// Leaves what is also in another span. False if that is nothing ahead; none if it is not plain.
    #[inline(always)]
    fn narrow(
        &mut self,
        &LeafSpan { enter, exit }: &LeafSpan<R>,
        reach: &Reach<R>,
    ) -> Option<bool> {
        if !reach.is_plainly_ahead(exit.t)? {
            return Some(false);
        }
        if reach.is_plainly_ahead(enter.t)? {
            let is_last = match self.enter {
                None => true,
                Some(last) if is_plainly_behind(enter.t, last.t, reach) => true,
                Some(last) if is_plainly_behind(last.t, enter.t, reach) => false,
                Some(_) => return None,
            };
            if is_last {
                self.enter = Some(enter);
            }
        }
        if exit.t.total_cmp(&self.exit).is_lt() {
            self.exit = exit.t;
        }
        self.least_exit = self.least_exit.min(exit.t.to_f64() - exit.t.radius());
        Some(true)
    }
}
