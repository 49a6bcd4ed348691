//! Trees of set operations on a ray: the leaves' crossings in order, and what they do to the root.
//!
//! Each node has a value, whether the ray is inside it. A crossing flips its leaf, and the change
//! spreads upward as far as it changes anything. All flips of a tie come before the root is looked
//! at.

use crate::carving::Taken;
use crate::hierarchy::Pending;
use crate::numeric::real::Real;
use crate::object::SetOp;
use crate::ray::{Crossing, Reach};
use crate::scene::{Kind, NONE, Node, Scene, Tree};
use crate::trace::LeafSpan;

/// Memory for sweeping, kept from ray to ray.
#[derive(Debug)]
pub(crate) struct Workspace<R> {
    pub(crate) pending: Pending,
    leaves: Vec<u32>,
    /// For carvings, what is taken away on the current ray.
    pub(crate) taken: Vec<Taken<R>>,
    crossings: Vec<Crossing<R>>,
    states: Vec<State>,
    /// Of each node the operand that paints where a tie has changed the node, and that tie.
    painters: Vec<(u64, u32)>,
    /// Number of the current tie; ties of all rays count on.
    tie: u64,
    /// Numbers from here on belong to the current ray.
    first_tie: u64,
    /// The first `t` found on the current ray for each root of each shared surface, and the tie
    /// number that tells whether it is this ray's.
    shared_roots: Vec<[(u64, R); 2]>,
}

#[derive(Clone, Copy, Debug, Default)]
struct State {
    /// Sum of the weights of the operands that are true.
    sum: i32,
    is_inside: bool,
    was_inside: bool,
    /// The tie that last changed it; if it is not of the current ray, nothing of this holds.
    tie: u64,
}

impl<R: Real> Workspace<R> {
    pub(crate) fn new(scene: &Scene<R>) -> Self {
        Workspace {
            pending: Pending::default(),
            leaves: Vec::new(),
            taken: Vec::new(),
            crossings: Vec::new(),
            states: vec![State::default(); scene.nodes.len()],
            painters: vec![(0, NONE); scene.nodes.len()],
            tie: 1,
            first_tie: 1,
            shared_roots: vec![[(0, R::ZERO); 2]; scene.n_shared as usize],
        }
    }

    fn is_inside(&self, node: u32) -> bool {
        let state = &self.states[node as usize];
        state.tie >= self.first_tie && state.is_inside
    }

    /// Whether the current tie has changed a node.
    fn has_changed(&self, node: u32) -> bool {
        let state = &self.states[node as usize];
        state.tie == self.tie && state.is_inside != state.was_inside
    }

    /// The state of a node, which is going to change.
    fn state_mut(&mut self, node: u32) -> &mut State {
        let state = &mut self.states[node as usize];
        if state.tie < self.first_tie {
            *state = State { tie: self.tie, ..State::default() };
        } else if state.tie != self.tie {
            (state.was_inside, state.tie) = (state.is_inside, self.tie);
        }
        state
    }

    /// The `t` that all roots of this surface share, found first at `t`.
    fn shared_root(&mut self, surface: u32, plus: bool, t: R) -> R {
        let slot = &mut self.shared_roots[surface as usize][usize::from(plus)];
        if slot.0 < self.first_tie {
            *slot = (self.first_tie, t);
        }
        slot.1
    }
}

impl<R: Real> Scene<R> {
    /// Visits the boundaries of a tree between the ray's origin and `t_end`, in order, until `visit`
    /// returns true. Returns whether the origin is inside.
    pub(crate) fn sweep(
        &self,
        root: u32,
        tree: &Tree,
        reach: &Reach<R>,
        t_end: f64,
        workspace: &mut Workspace<R>,
        mut visit: impl FnMut(Crossing<R>) -> bool,
    ) -> bool {
        workspace.tie += 1;
        workspace.first_tie = workspace.tie;
        let mut leaves = std::mem::take(&mut workspace.leaves);
        let mut crossings = std::mem::take(&mut workspace.crossings);
        leaves.clear();
        crossings.clear();
        leaves.extend_from_slice(&tree.whole);
        let mut candidates = tree.hierarchy.candidates(&reach.line, &mut workspace.pending);
        while let Some(leaf) = candidates.next_unordered(t_end) {
            leaves.push(leaf);
        }
        // The first leaf's root of a shared surface counts.
        leaves.sort_unstable();
        for &leaf in &leaves {
            self.collect(leaf, reach, workspace, &mut crossings);
        }
        crossings.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.leaf().cmp(&b.leaf())));
        let starts_inside = workspace.is_inside(root);
        for tie in crossings.chunk_by(|a, b| self.is_tie(a, b, reach)) {
            workspace.tie += 1;
            for crossing in tie {
                self.flip(crossing, workspace);
            }
            if workspace.has_changed(root)
                && let Some(crossing) = self.painter(root, tie, workspace)
                && visit(crossing)
            {
                break;
            }
        }
        (workspace.leaves, workspace.crossings) = (leaves, crossings);
        starts_inside
    }

    /// Adds a leaf's crossings ahead, and puts the leaf inside if the ray starts there.
    fn collect(
        &self,
        leaf: u32,
        reach: &Reach<R>,
        workspace: &mut Workspace<R>,
        crossings: &mut Vec<Crossing<R>>,
    ) {
        let Some(LeafSpan { mut enter, mut exit }) = self.leaf_span(leaf, &reach.ray) else {
            return;
        };
        if self.n_shared > 0 {
            enter.t = self.shared_root(enter, workspace);
            exit.t = self.shared_root(exit, workspace);
        }
        let [enters, exits] = [enter, exit].map(|end| self.is_ahead(&end, reach));
        if exits && !enters {
            self.spread(self.details[leaf as usize].node, true, workspace);
        }
        if enters && enter.t.to_f64().is_finite() {
            crossings.push(enter);
        }
        if exits && exit.t.to_f64().is_finite() {
            crossings.push(exit);
        }
    }

    /// The `t` that a crossing has for all faces of its surface.
    #[inline(never)]
    fn shared_root(&self, end: Crossing<R>, workspace: &mut Workspace<R>) -> R {
        let surface = self.face_surface(&self.leaves[end.leaf() as usize], end.root().face());
        if surface < self.n_shared && end.t.to_f64().is_finite() {
            workspace.shared_root(surface, end.root().plus(), end.t)
        } else {
            end.t
        }
    }

    fn flip(&self, crossing: &Crossing<R>, workspace: &mut Workspace<R>) {
        self.spread(self.details[crossing.leaf() as usize].node, crossing.is_entry(), workspace);
    }

    /// Sets a node's value and those above that follow from it.
    fn spread(&self, node: u32, is_inside: bool, workspace: &mut Workspace<R>) {
        let (mut node, mut is_inside) = (node, is_inside);
        while node != NONE && workspace.is_inside(node) != is_inside {
            workspace.state_mut(node).is_inside = is_inside;
            let Node { parent, weight, .. } = self.nodes[node as usize];
            if parent == NONE {
                break;
            }
            let above = workspace.state_mut(parent);
            above.sum += if is_inside { weight } else { -weight };
            is_inside = above.sum >= self.nodes[parent as usize].threshold;
            node = parent;
        }
    }

    /// The crossing that supplies the surface where a tie has changed the root. Of the operands that
    /// have changed, it is the last of a union, and else the first: the second of two united, the
    /// minuend, and the first to take something away.
    fn painter(
        &self,
        root: u32,
        tie: &[Crossing<R>],
        workspace: &mut Workspace<R>,
    ) -> Option<Crossing<R>> {
        let crossing = match tie {
            [crossing] => crossing,
            _ => {
                let leaf = self.painting_leaf(root, tie, workspace)?;
                // A leaf that is entered and left within the tie has not changed: one crossing is meant.
                tie.iter().find(|crossing| crossing.leaf() == leaf)?
            }
        };
        let is_entry = workspace.is_inside(root);
        Some(Crossing::new(crossing.t, crossing.leaf(), crossing.root(), is_entry))
    }

    /// The leaf of that crossing. The way up from each leaf, as far as it has changed anything, is gone
    /// once, to tell nodes of their operands.
    fn painting_leaf(
        &self,
        root: u32,
        tie: &[Crossing<R>],
        workspace: &mut Workspace<R>,
    ) -> Option<u32> {
        for crossing in tie {
            let mut operand = self.details[crossing.leaf() as usize].node;
            while operand != root && workspace.has_changed(operand) {
                let node = self.nodes[operand as usize].parent;
                let is_known = self.paints(operand, node, workspace);
                if is_known {
                    break;
                }
                operand = node;
            }
        }
        let mut node = root;
        loop {
            if let Kind::Leaf(leaf) = self.nodes[node as usize].kind {
                return Some(leaf);
            }
            let (tie, painter) = workspace.painters[node as usize];
            node = (tie == workspace.tie).then_some(painter)?;
        }
    }

    /// Tells a node of an operand that the current tie has changed. Returns whether it knew of another.
    fn paints(&self, operand: u32, node: u32, workspace: &mut Workspace<R>) -> bool {
        let (tie, painter) = &mut workspace.painters[node as usize];
        let is_known = *tie == workspace.tie;
        let of_union = self.nodes[node as usize].kind == Kind::Combined(SetOp::Union);
        if !is_known || (operand > *painter) == of_union {
            (*tie, *painter) = (workspace.tie, operand);
        }
        is_known
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::{Object, ShapeKind};
    use crate::surface::SurfaceId;

    /// The operand of a node that a leaf is part of, if it is of one.
    fn operand_above(scene: &Scene, leaf: u32, node: u32) -> Option<u32> {
        let mut operand = scene.details[leaf as usize].node;
        while operand != NONE {
            let parent = scene.nodes[operand as usize].parent;
            if parent == node {
                return Some(operand);
            }
            operand = parent;
        }
        None
    }

    /// The leaf that paints, sought from the root downward.
    fn sought(scene: &Scene, tie: &[u32], workspace: &Workspace<f64>) -> Option<u32> {
        let mut node = 0;
        loop {
            let op = match scene.nodes[node as usize].kind {
                Kind::Leaf(leaf) => return Some(leaf),
                Kind::Combined(op) => op,
            };
            let operands = tie.iter().filter_map(|leaf| operand_above(scene, *leaf, node));
            let changed = operands.filter(|operand| workspace.has_changed(*operand));
            node = if op == SetOp::Union { changed.max() } else { changed.min() }?;
        }
    }

    #[test]
    fn the_painter_is_the_one_that_is_found_from_the_root_downward() {
        let mut random = 1u64;
        let mut below = |n: u64| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 33) % n
        };
        let mut n_painted = 0;
        for _ in 0..2000 {
            let shape = || Object::shape(ShapeKind::Sphere, ());
            let mut parts: Vec<Object<()>> = (0..9).map(|_| shape()).collect();
            while parts.len() > 1 {
                let [a, b] = [0; 2].map(|_| parts.swap_remove(below(parts.len() as u64) as usize));
                let op = if parts.is_empty() { 2 } else { below(3) };
                parts.push(match op {
                    0 => a.union(&b),
                    1 => a.intersect(&b),
                    _ => a.difference(&b),
                });
            }
            let scene: Scene = Scene::new(&parts[0], |()| SurfaceId(0));
            let mut workspace = Workspace::new(&scene);
            for _ in 0..12 {
                workspace.tie += 1;
                let tie: Vec<u32> = (0..9).filter(|_| below(3) == 0).collect();
                let crossings: Vec<Crossing<f64>> = tie
                    .iter()
                    .map(|&leaf| {
                        let is_inside = workspace.is_inside(scene.details[leaf as usize].node);
                        Crossing::new(1.0, leaf, crate::shape::Root::plane(0), !is_inside)
                    })
                    .collect();
                for crossing in &crossings {
                    scene.flip(crossing, &mut workspace);
                }
                if workspace.has_changed(0) {
                    n_painted += 1;
                    let painter = scene.painter(0, &crossings, &mut workspace);
                    let expected = sought(&scene, &tie, &workspace);
                    assert_eq!(painter.map(|crossing| crossing.leaf()), expected);
                }
            }
        }
        assert!(n_painted > 2000, "{n_painted}");
    }
}
