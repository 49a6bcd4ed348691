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
use crate::scene::{Kind, Node, Scene, Tree};
use crate::trace::LeafSpan;
use crate::tree::Workspace;

/// Where a ray meets more that is taken away, a list is made: comparisons of all with one another grow
/// with the square of the number. Of a block from which overlapping spheres are taken away one behind the
/// other, a picture takes 0.81 to 0.97 of the time that it takes with lists where rays meet 4 to 32 of
/// them; without a limit it takes 1.13 where they meet 48. Beyond the limit, what has been found in vain
/// makes that 1.1 to 1.3.
const MAX_TAKEN: usize = 32;

/// The span of a shape that is taken away, of which the exit lies ahead.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taken<R> {
    /// None if the ray starts behind it.
    enter: Option<R>,
    exit: Crossing<R>,
}

/// The shapes that a tree is carved from, in order, by its nodes in preorder; none if it is no carving.
pub(crate) fn whole(nodes: &[Node], root: u32) -> Vec<u32> {
    let (mut whole, mut is_taken) = (Vec::new(), Vec::with_capacity(nodes.len()));
    for (index, node) in nodes.iter().enumerate() {
        let is_above_taken = index > 0 && is_taken[(node.parent - root) as usize];
        let is_this_taken = is_above_taken || node.weight < 0;
        match node.kind {
            Kind::Leaf(leaf) if !is_this_taken => whole.push(leaf),
            Kind::Combined(SetOp::Union) if !is_this_taken => return Vec::new(),
            Kind::Combined(SetOp::Intersect | SetOp::Difference) if is_this_taken => {
                return Vec::new();
            }
            Kind::Leaf(_) | Kind::Combined(_) => {}
        }
        is_taken.push(is_this_taken);
    }
    whole
}

/// Whether a crossing lies behind another so far that they cannot tie, whatever their tolerances are. Lists
/// give all faces of a shared surface the root of one of them, which is about ten roundings away from that
/// of another: of four tolerances of 64 roundings, two of which make a tie, that leaves enough.
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
    /// The first entry of a carving ahead of a ray that starts outside it, if there is one that is not
    /// behind `t_end`. None if a list of crossings must tell.
    #[inline(always)]
    pub(crate) fn carved_entry(
        &self,
        tree: &Tree,
        reach: &Reach<R>,
        t_end: f64,
        workspace: &mut Workspace<R>,
    ) -> Option<Option<Crossing<R>>> {
        let mut whole =
            Whole { enter: None, exit: R::from_f64(f64::INFINITY), least_exit: f64::INFINITY };
        for &leaf in &tree.whole {
            let Some(span) = self.leaf_span(leaf, &reach.ray) else { return Some(None) };
            if !whole.narrow(&span, reach)? {
                return Some(None);
            }
        }
        let end = t_end.min(reach.line.end_of_ties(whole.exit));
        // Most rays enter the whole where nothing is taken away.
        if let Some(enter) = whole.enter {
            if enter.t.to_f64() - enter.t.radius() > t_end {
                return Some(None);
            }
            let limit = end.min(reach.line.end_of_ties(enter.t));
            self.take_away(tree, reach, limit, workspace)?;
            let first = self.first_remaining(&whole, &workspace.taken, reach)?;
            if first.is_none_or(|first| first.t.to_f64() <= limit) {
                return Some(first);
            }
        }
        self.take_away(tree, reach, end, workspace)?;
        self.first_remaining(&whole, &workspace.taken, reach)
    }

    /// Finds what is taken away on a ray before `t_end`.
    #[inline(always)]
    fn take_away(
        &self,
        tree: &Tree,
        reach: &Reach<R>,
        t_end: f64,
        workspace: &mut Workspace<R>,
    ) -> Option<()> {
        let Workspace { pending, taken, .. } = workspace;
        taken.clear();
        let mut candidates = tree.hierarchy.candidates(&reach.line, pending);
        while let Some(leaf) = candidates.next_unordered(t_end) {
            let Some(LeafSpan { enter, exit }) = self.leaf_span(leaf, &reach.ray) else { continue };
            if !reach.is_plainly_ahead(exit.t)? {
                continue;
            }
            if taken.len() == MAX_TAKEN {
                return None;
            }
            let is_ahead = reach.is_plainly_ahead(enter.t)?;
            taken.push(Taken { enter: is_ahead.then_some(enter.t), exit });
        }
        Some(())
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
                if taken.exit.leaf() == first.leaf() {
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
        let is_shared =
            self.face_surface(&self.leaves[first.leaf() as usize], face) < self.n_shared;
        (!is_shared).then(|| Some(Crossing::new(first.t, first.leaf(), first.root(), true)))
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
