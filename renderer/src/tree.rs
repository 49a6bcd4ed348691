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
        workspace: &Workspace<R>,
    ) -> Option<Crossing<R>> {
        let mut node = root;
        let leaf = loop {
            let op = match self.nodes[node as usize].kind {
                Kind::Leaf(leaf) => break leaf,
                Kind::Combined(op) => op,
            };
            let changed = tie
                .iter()
                .filter_map(|crossing| self.operand_above(crossing.leaf(), node))
                .filter(|operand| workspace.has_changed(*operand));
            node = if op == SetOp::Union { changed.max() } else { changed.min() }?;
        };
        // A leaf that is entered and left within the tie has not changed: one crossing is meant.
        let crossing = tie.iter().find(|crossing| crossing.leaf() == leaf)?;
        let is_entry = workspace.is_inside(root);
        Some(Crossing::new(crossing.t, leaf, crossing.root(), is_entry))
    }

    /// The operand of a node that a leaf is part of, if it is of one.
    fn operand_above(&self, leaf: u32, node: u32) -> Option<u32> {
        let mut operand = self.details[leaf as usize].node;
        while operand > node {
            let parent = self.nodes[operand as usize].parent;
            if parent == node {
                return Some(operand);
            }
            operand = parent;
        }
        None
    }
}
