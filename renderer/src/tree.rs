//! Trees of set operations on a ray: the leaves' crossings in order, and what they do to the root.
//!
//! Each node has a value, whether the ray is inside it. A crossing flips its leaf, and the change
//! spreads upward as far as it changes anything. All flips of a tie come before the root is looked
//! at.

use std::ops::Range;

use crate::numeric::real::Real;
use crate::object::SetOp;
use crate::ray::{Crossing, Ray};
use crate::scene::{NONE, Operands, Scene};

/// Memory for sweeping, kept from ray to ray.
#[derive(Debug)]
pub(crate) struct Workspace<R> {
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
    /// Inside or outside; outside if the state is not of the current ray.
    is_inside: bool,
    was_inside: bool,
    /// The tie that last changed it.
    tie: u64,
}

impl<R: Real> Workspace<R> {
    pub(crate) fn new(scene: &Scene<R>) -> Self {
        Workspace {
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

    fn set(&mut self, node: u32, is_inside: bool) {
        let was_inside = self.is_inside(node);
        let state = &mut self.states[node as usize];
        if state.tie != self.tie {
            *state = State { is_inside, was_inside, tie: self.tie };
        }
        state.is_inside = is_inside;
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
    /// Visits the boundaries of a tree ahead of the ray's origin, in order, until `visit` returns
    /// true. Returns whether the origin is inside.
    pub(crate) fn sweep(
        &self,
        root: u32,
        leaves: Range<u32>,
        ray: &Ray<R>,
        workspace: &mut Workspace<R>,
        mut visit: impl FnMut(Crossing<R>) -> bool,
    ) -> bool {
        workspace.tie += 1;
        workspace.first_tie = workspace.tie;
        let mut crossings = std::mem::take(&mut workspace.crossings);
        crossings.clear();
        for leaf in leaves {
            self.collect(leaf, ray, workspace, &mut crossings);
        }
        crossings.sort_by(|a, b| a.t.to_f64().total_cmp(&b.t.to_f64()).then(a.leaf.cmp(&b.leaf)));
        let starts_inside = workspace.is_inside(root);
        for tie in crossings.chunk_by(Crossing::ties_with) {
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
        workspace.crossings = crossings;
        starts_inside
    }

    /// Adds a leaf's crossings ahead, and puts the leaf inside if the ray starts there.
    fn collect(
        &self,
        leaf: u32,
        ray: &Ray<R>,
        workspace: &mut Workspace<R>,
        crossings: &mut Vec<Crossing<R>>,
    ) {
        let Some(mut span) = self.leaf_span(leaf, ray) else { return };
        for end in [&mut span.enter, &mut span.exit] {
            let surface = self.face_surface(&self.leaves[leaf as usize], end.root.face);
            if surface < self.n_shared && end.t.to_f64().is_finite() {
                end.t = workspace.shared_root(surface, end.root.plus, end.t);
            }
        }
        if span.is_inside() {
            self.spread(self.leaves[leaf as usize].node, true, workspace);
        }
        let is_met = |end: &Crossing<R>| end.is_ahead() && end.t.to_f64().is_finite();
        crossings.extend([span.enter, span.exit].into_iter().filter(is_met));
    }

    fn flip(&self, crossing: &Crossing<R>, workspace: &mut Workspace<R>) {
        self.spread(self.leaves[crossing.leaf as usize].node, crossing.entering, workspace);
    }

    /// Sets a node's value and those above that follow from it.
    fn spread(&self, node: u32, is_inside: bool, workspace: &mut Workspace<R>) {
        let (mut node, mut is_inside) = (node, is_inside);
        while node != NONE && workspace.is_inside(node) != is_inside {
            workspace.set(node, is_inside);
            node = self.nodes[node as usize].parent;
            if node == NONE {
                break;
            }
            let Operands::Both(op, [first, second]) = self.nodes[node as usize].kind else { break };
            let (first, second) = (workspace.is_inside(first), workspace.is_inside(second));
            is_inside = match op {
                SetOp::Union => first || second,
                SetOp::Intersect => first && second,
                SetOp::Difference => first && !second,
            };
        }
    }

    /// The crossing that supplies the surface where a tie has changed the root. If both operands
    /// have changed, it is the second of a union, the first of an intersection, and the minuend.
    fn painter(
        &self,
        root: u32,
        tie: &[Crossing<R>],
        workspace: &Workspace<R>,
    ) -> Option<Crossing<R>> {
        let mut node = root;
        let leaf = loop {
            match self.nodes[node as usize].kind {
                Operands::Leaf(leaf) => break leaf,
                Operands::Both(op, [first, second]) => {
                    let takes_first = match op {
                        SetOp::Union => !workspace.has_changed(second),
                        SetOp::Intersect | SetOp::Difference => workspace.has_changed(first),
                    };
                    node = if takes_first { first } else { second };
                }
            }
        };
        // A leaf that is entered and left within the tie has not changed: one crossing is meant.
        let crossing = tie.iter().find(|crossing| crossing.leaf == leaf)?;
        Some(Crossing { entering: workspace.is_inside(root), ..*crossing })
    }
}
