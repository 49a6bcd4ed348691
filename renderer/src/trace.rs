//! The first boundary of a scene on a ray.
//!
//! Surfaces are two-sided: an entry and an exit count alike. No ray is offset from its origin and
//! none has a least distance: a ray knows the face that it starts on, whose root is 0 exactly, and
//! the medium that it starts in. Crossings that rounding cannot tell apart form one group (a tie),
//! whose changes take effect together, so that skins of no thickness vanish.

use std::ops::ControlFlow;

use crate::hierarchy::Pending;
use crate::numeric::real::Real;
use crate::object::ShapeKind;
use crate::plan::Part;
use crate::ray::{Crossing, Line, Medium, On, Ray, Reach, TIE_ROUNDINGS};
use crate::scene::{Component, Leaf, Scene};
use crate::shape::{self, End, LocalRay};
use crate::tiles::Tiles;
use crate::tree;

/// Memory for tracing, kept from ray to ray.
#[derive(Debug)]
pub(crate) struct Workspace<R> {
    pub(crate) tree: tree::Workspace<R>,
    pending: Pending,
    /// Where rays from the eye begin to look.
    pub(crate) tiles: Tiles,
    /// Boundaries of components, with the component's index.
    crossings: Vec<(u32, Crossing<R>)>,
}

impl<R: Real> Workspace<R> {
    pub(crate) fn new(scene: &Scene<R>) -> Self {
        Workspace {
            tree: tree::Workspace::new(scene),
            pending: Pending::default(),
            tiles: Tiles::new(),
            crossings: Vec::new(),
        }
    }
}

/// A leaf's span on a ray, as crossings; infinite ends lie at infinite `t`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafSpan<R> {
    pub(crate) enter: Crossing<R>,
    pub(crate) exit: Crossing<R>,
}

impl<R: Real> Leaf<R> {
    /// Whether a ray surely has no entry that matters, by what takes less than its whole span: the
    /// height above a plane and how it changes along the ray, which the full test computes alike.
    #[inline(always)]
    fn is_surely_missed<const OUTSIDE: bool>(&self, index: u32, ray: &Ray<R>, t_end: f64) -> bool {
        // From the one surface of a convex solid, the outside leads nowhere into it.
        if OUTSIDE && ray.on.is_some_and(|on| on.leaf == index) {
            return matches!(self.kind, ShapeKind::Sphere | ShapeKind::Plane);
        }
        if self.kind != ShapeKind::Plane {
            return false;
        }
        let row = self.object_from_world.rows[1];
        let height = match ray.on {
            None => self.eye.y,
            Some(_) => self.object_from_world.point(ray.origin).y,
        };
        let rise = row.dot(ray.dir);
        if height.is_surely_positive() {
            // Away from the plane, or not down to it before all that matters has ended, with room
            // for ties, beside which the rounding of this sum is nothing.
            rise.is_surely_positive()
                || rise.mul_add(R::from_f64(t_end), height).is_surely_positive()
        } else {
            // The plane is met at a `t` that is not above 0, which is no entry ahead.
            OUTSIDE && (rise.is_surely_positive() || (-height).is_surely_positive())
        }
    }
}

impl<R: Real> Scene<R> {
    /// The ray in a leaf's object space.
    #[inline(always)]
    pub(crate) fn local_ray(&self, index: u32, ray: &Ray<R>) -> LocalRay<R> {
        let leaf = &self.leaves[index as usize];
        let dir = leaf.local_vector(ray.dir);
        let origin = || leaf.local_point(ray.origin);
        match &ray.on {
            Some(on) if on.leaf == index => LocalRay::new(on.point, dir, self.faces_on(leaf, on)),
            Some(on) if on.surface < self.n_shared => {
                LocalRay::new(origin(), dir, self.faces_on(leaf, on))
            }
            Some(_) => LocalRay::new(origin(), dir, 0),
            None if self.omissions.holds(Part::Eye) => LocalRay::new(leaf.eye, dir, leaf.at_eye),
            None => LocalRay::new(origin(), dir, leaf.at_eye),
        }
    }

    /// The faces of a leaf, by bit, that are part of the surface that the ray starts on.
    #[inline]
    fn faces_on(&self, leaf: &Leaf<R>, on: &On<R>) -> u8 {
        let n_faces = shape::forms(leaf.kind).len() as u8;
        (0..n_faces)
            .filter(|&face| self.face_surface(leaf, face) == on.surface)
            .fold(0, |bits, face| bits | 1 << face)
    }

    /// Where a ray's line is inside a leaf.
    #[inline(always)]
    pub(crate) fn leaf_span(&self, index: u32, ray: &Ray<R>) -> Option<LeafSpan<R>> {
        let local = self.local_ray(index, ray);
        let span = shape::span(self.leaves[index as usize].kind, &local)?;
        let crossing = |End { t, root }, entering| Crossing::new(t, index, root, entering);
        Some(LeafSpan { enter: crossing(span.enter, true), exit: crossing(span.exit, false) })
    }

    /// How far `t` of a crossing may be off.
    #[cold]
    fn tolerance(&self, crossing: Crossing<R>, ray: Ray<R>) -> f64 {
        let leaf = &self.leaves[crossing.leaf() as usize];
        let local = self.local_ray(crossing.leaf(), &ray);
        let t = crossing.t.to_f64().abs();
        let is_exact = local.is_on(crossing.root().face()) && crossing.t.is_surely_zero();
        // An infinite end is no crossing, and ties with nothing.
        if is_exact || !t.is_finite() {
            return 0.0;
        }
        // What rounding may have moved the origin by, in lengths of the direction.
        let reach = leaf.origin_size(&ray) / local.dir.max_norm().to_f64();
        TIE_ROUNDINGS * R::UNIT_ROUNDOFF * (t + reach)
    }

    /// Whether a crossing lies ahead of the ray's origin by more than its tolerance.
    #[inline(always)]
    pub(crate) fn is_ahead(&self, crossing: &Crossing<R>, reach: &Reach<R>) -> bool {
        let compare = || crossing.t.exceeds(self.tolerance(*crossing, reach.ray));
        reach.is_plainly_ahead(crossing.t).unwrap_or_else(compare)
    }

    /// Whether the ray's origin is inside a leaf's span, or enters it at once.
    #[inline(always)]
    pub(crate) fn is_inside(&self, span: &LeafSpan<R>, reach: &Reach<R>) -> bool {
        !self.is_ahead(&span.enter, reach) && self.is_ahead(&span.exit, reach)
    }

    /// Where a ray enters a leaf, if that lies ahead and not behind `t_end`, where nothing is first or
    /// ties with what is; breaks if the leaf holds the origin, unless the ray is known to start
    /// `OUTSIDE`.
    #[inline(always)]
    fn leaf_entry<const OUTSIDE: bool>(
        &self,
        index: u32,
        reach: &Reach<R>,
        t_end: f64,
    ) -> ControlFlow<(), Option<Crossing<R>>> {
        let leaf = &self.leaves[index as usize];
        let ray = &reach.ray;
        if self.omissions.holds(Part::Planes) && leaf.is_surely_missed::<OUTSIDE>(index, ray, t_end)
        {
            return ControlFlow::Continue(None);
        }
        let local = self.local_ray(index, ray);
        let Some(span) = shape::span(leaf.kind, &local) else { return ControlFlow::Continue(None) };
        let t = span.enter.t;
        let is_behind = OUTSIDE && (-t).is_surely_positive();
        if is_behind || t.to_f64() - t.radius() > t_end {
            return ControlFlow::Continue(None);
        }
        let crossing = |End { t, root }, entering| Crossing::new(t, index, root, entering);
        let enter = crossing(span.enter, true);
        if self.is_ahead(&enter, reach) {
            return ControlFlow::Continue(Some(enter));
        }
        if !OUTSIDE && self.is_ahead(&crossing(span.exit, false), reach) {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(None)
    }

    /// Whether two crossings, the second of which is not the nearer, cannot be told apart or are of one
    /// and the same surface.
    #[inline(always)]
    pub(crate) fn is_tie(&self, a: &Crossing<R>, b: &Crossing<R>, reach: &Reach<R>) -> bool {
        let is_plainly_behind = b.t.to_f64() - b.t.radius() > reach.line.end_of_ties(a.t);
        !is_plainly_behind && self.are_one(*a, *b, reach.ray)
    }

    /// The same by their own tolerances.
    #[cold]
    fn are_one(&self, a: Crossing<R>, b: Crossing<R>, ray: Ray<R>) -> bool {
        // Numbers that keep account of their errors may not know that such roots are the same.
        let is_same = || {
            let [of_a, of_b] =
                [a, b].map(|c| self.face_surface(&self.leaves[c.leaf() as usize], c.root().face()));
            let is_one = a.leaf() == b.leaf() && a.root() == b.root();
            is_one || of_a == of_b && of_a < self.n_shared && a.root().plus() == b.root().plus()
        };
        let tolerance = |crossing| self.tolerance(crossing, ray);
        R::KEEPS_ACCOUNT && is_same() || (a.t - b.t).vanishes(tolerance(a) + tolerance(b))
    }

    /// A ray, to be tested against boxes.
    #[inline(always)]
    fn reach(&self, ray: &Ray<R>) -> Reach<R> {
        Reach { ray: *ray, line: self.line(ray) }
    }

    /// A ray as the line that is tested against boxes.
    #[inline(always)]
    pub(crate) fn line(&self, ray: &Ray<R>) -> Line {
        Line::new(ray, self.conditioning, self.extent)
    }

    /// The first boundary ahead of the ray's origin. Of those that tie with the first, the one of
    /// the last operand of the union that the scene is paints.
    #[inline(always)]
    pub(crate) fn first_hit(
        &self,
        ray: &Ray<R>,
        workspace: &mut Workspace<R>,
    ) -> Option<Crossing<R>> {
        let reach = self.reach(ray);
        let entry = match ray.medium {
            Medium::Inside => ControlFlow::Break(()),
            Medium::Outside => self.first_entry::<true>(&reach, workspace),
            Medium::Unknown => self.first_entry::<false>(&reach, workspace),
        };
        match entry {
            ControlFlow::Continue(crossing) => crossing,
            ControlFlow::Break(()) => self.first_exit(reach, workspace),
        }
    }

    /// The first boundary of a ray that starts outside the union; breaks if it starts inside.
    #[inline(always)]
    fn first_entry<const OUTSIDE: bool>(
        &self,
        reach: &Reach<R>,
        workspace: &mut Workspace<R>,
    ) -> ControlFlow<(), Option<Crossing<R>>> {
        let Workspace { tree, pending, tiles, crossings: others } = workspace;
        others.clear();
        let mut first: Option<Crossing<R>> = None;
        let (mut first_index, mut t_end) = (0, f64::INFINITY);
        // Only rays from the eye start in a medium that is unknown, and their tile has been entered. 1 over
        // a direction is monotone across it, and the origins of lines are equally uncertain, so its beam
        // holds them; only balls, of which each has an error of its own, have to be asked.
        let mut candidates = match tiles.start() {
            Some(start) if !OUTSIDE && (!R::KEEPS_ACCOUNT || start.holds(&reach.line)) => {
                self.hierarchy.candidates_from(start, &reach.line, pending)
            }
            _ => self.hierarchy.candidates(&reach.line, pending),
        };
        while let Some(index) = candidates.next(t_end) {
            let Some(crossing) = self.entry::<OUTSIDE>(index, reach, t_end, tree)? else {
                continue;
            };
            // Of those at the same `t` that of the lowest index is the first, in whatever order they are
            // found.
            let is_behind = |first: Crossing<R>| {
                crossing.t.total_cmp(&first.t).then(index.cmp(&first_index)).is_ge()
            };
            if first.is_some_and(is_behind) {
                others.push((index, crossing));
                continue;
            }
            t_end = reach.line.end_of_ties(crossing.t);
            let may_tie = |other: &Crossing<R>| other.t.to_f64() - other.t.radius() <= t_end;
            if !others.is_empty() {
                others.retain(|(_, other)| may_tie(other));
            }
            if let Some(other) = first.filter(may_tie) {
                others.push((first_index, other));
            }
            (first, first_index) = (Some(crossing), index);
        }
        if !others.is_empty()
            && let Some(nearest) = first
        {
            first = Some(self.last_tied(first_index, nearest, others, *reach));
        }
        ControlFlow::Continue(first)
    }

    /// Of the first crossing and those that tie with it, the one of the last component.
    #[cold]
    fn last_tied(
        &self,
        index: u32,
        first: Crossing<R>,
        others: &[(u32, Crossing<R>)],
        reach: Reach<R>,
    ) -> Crossing<R> {
        let ties = others.iter().filter(|(_, other)| self.is_tie(&first, other, &reach));
        let last = ties.max_by_key(|(other, _)| *other).filter(|(other, _)| *other > index);
        last.map_or(first, |(_, last)| *last)
    }

    /// Whether anything is met before `t_end` (anywhere, if none), of unbounded components only one of
    /// the `obstacles` if there are any such. The component `blocker` is tried first, and becomes the one
    /// that was found to be met, if any.
    #[inline(always)]
    pub(crate) fn is_blocked(
        &self,
        ray: &Ray<R>,
        t_end: Option<R>,
        obstacles: Option<&[u32]>,
        blocker: &mut Option<u32>,
        workspace: &mut Workspace<R>,
    ) -> bool {
        if ray.medium != Medium::Outside {
            return self.is_blocked_inside(*ray, t_end, workspace);
        }
        let reach = self.reach(ray);
        let end_of_ties = t_end.map_or(f64::INFINITY, |end| reach.line.end_of_ties(end));
        let Workspace { tree, pending, .. } = workspace;
        let unbounded = obstacles.unwrap_or(self.hierarchy.unbounded());
        let candidates = self.hierarchy.candidates(&reach.line, pending);
        let mut candidates = candidates.with_unbounded(unbounded);
        let (tried, mut is_tried) = (blocker.take(), false);
        loop {
            let index = match tried {
                Some(index) if !is_tried => index,
                _ => match candidates.next_unordered(end_of_ties) {
                    Some(index) if tried == Some(index) => continue,
                    Some(index) => index,
                    None => return false,
                },
            };
            is_tried = true;
            let crossing = self.entry::<true>(index, &reach, end_of_ties, tree);
            let crossing = crossing.continue_value().flatten();
            if crossing.is_some_and(|crossing| self.is_before(t_end, &crossing, &reach)) {
                *blocker = Some(index);
                return true;
            }
        }
    }

    /// The same for rays that may start inside a solid.
    #[cold]
    fn is_blocked_inside(
        &self,
        ray: Ray<R>,
        t_end: Option<R>,
        workspace: &mut Workspace<R>,
    ) -> bool {
        let crossing = self.first_hit(&ray, workspace);
        crossing.is_some_and(|crossing| self.is_before(t_end, &crossing, &self.reach(&ray)))
    }

    /// Whether a crossing lies before `t_end` by more than its tolerance.
    #[inline(always)]
    fn is_before(&self, t_end: Option<R>, crossing: &Crossing<R>, reach: &Reach<R>) -> bool {
        let Some(end) = t_end else { return true };
        let distance = end - crossing.t;
        reach.is_plainly_beyond(distance, crossing.t)
            || distance.exceeds(self.tolerance(*crossing, reach.ray))
    }

    /// The first boundary of a component ahead, if it does not lie behind `t_end`; breaks if the
    /// component holds the ray's origin. For rays that are known to start `OUTSIDE` nothing holds it,
    /// whatever rounding says, and only entries count.
    #[inline(always)]
    fn entry<const OUTSIDE: bool>(
        &self,
        index: u32,
        reach: &Reach<R>,
        t_end: f64,
        workspace: &mut tree::Workspace<R>,
    ) -> ControlFlow<(), Option<Crossing<R>>> {
        match self.components[index as usize] {
            Component::Leaf(leaf) => self.leaf_entry::<OUTSIDE>(leaf, reach, t_end),
            Component::Tree { root, tree } => {
                self.tree_entry::<OUTSIDE>(root, tree, *reach, t_end, workspace)
            }
        }
    }

    /// The same for a tree, by its root node and its index.
    #[inline(never)]
    fn tree_entry<const OUTSIDE: bool>(
        &self,
        root: u32,
        tree: u32,
        reach: Reach<R>,
        t_end: f64,
        workspace: &mut tree::Workspace<R>,
    ) -> ControlFlow<(), Option<Crossing<R>>> {
        let tree = &self.trees[tree as usize];
        if !tree.whole.is_empty()
            && self.omissions.holds(Part::Lists)
            && let Some(entry) = self.carved_entry(tree, &reach, t_end, workspace)
        {
            return ControlFlow::Continue(entry);
        }
        let mut first = None;
        let is_inside = self.sweep(root, tree, &reach, t_end, workspace, |crossing| {
            let counts = crossing.is_entry() || !OUTSIDE;
            if counts {
                first = Some(crossing);
            }
            counts
        });
        if is_inside && !OUTSIDE {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(first)
    }

    /// For a ray that starts inside the union: where it leaves it. Boundaries between components
    /// that overlap or touch are none of the union.
    #[inline(never)]
    fn first_exit(&self, reach: Reach<R>, workspace: &mut Workspace<R>) -> Option<Crossing<R>> {
        let Workspace { tree, pending, crossings, .. } = workspace;
        crossings.clear();
        let mut n_around: usize = 0;
        let mut candidates = self.hierarchy.candidates(&reach.line, pending);
        while let Some(index) = candidates.next(f64::INFINITY) {
            n_around += usize::from(match self.components[index as usize] {
                Component::Leaf(leaf) => self.leaf_span(leaf, &reach.ray).is_some_and(|span| {
                    let is_met = |end: &Crossing<R>| {
                        end.t.to_f64().is_finite() && self.is_ahead(end, &reach)
                    };
                    let ends = [span.enter, span.exit].into_iter().filter(is_met);
                    crossings.extend(ends.map(|end| (index, end)));
                    self.is_inside(&span, &reach)
                }),
                Component::Tree { root, tree: index } => {
                    let shapes = &self.trees[index as usize];
                    self.sweep(root, shapes, &reach, f64::INFINITY, tree, |crossing| {
                        crossings.push((index, crossing));
                        false
                    })
                }
            });
        }
        crossings.sort_by(|(i, a), (j, b)| a.t.total_cmp(&b.t).then(i.cmp(j)));
        let groups = crossings.chunk_by(|(_, a), (_, b)| self.is_tie(a, b, &reach));
        for group in groups {
            let was_inside = n_around > 0;
            for (_, crossing) in group {
                n_around =
                    if crossing.is_entry() { n_around + 1 } else { n_around.saturating_sub(1) };
            }
            if was_inside && n_around == 0 {
                let exits = group.iter().filter(|(_, crossing)| !crossing.is_entry());
                return exits.max_by_key(|(index, _)| *index).map(|(_, crossing)| *crossing);
            }
        }
        None
    }
}
