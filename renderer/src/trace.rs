//! The first boundary of a scene on a ray.
//!
//! Surfaces are two-sided: an entry and an exit count alike. No ray is offset from its origin and
//! none has a least distance: a ray knows the face that it starts on, whose root is 0 exactly, and
//! the medium that it starts in. Crossings that rounding cannot tell apart form one group (a tie),
//! whose changes take effect together, so that skins of no thickness vanish.

use std::convert::Infallible;
use std::ops::ControlFlow;

use crate::hierarchy::Pending;
use crate::numeric::real::Real;
use crate::object::ShapeKind;
use crate::plan::Part;
use crate::ray::{Crossing, Line, Medium, On, Ray, Reach, TIE_ROUNDINGS};
use crate::scene::{Component, Leaf, Scene};
use crate::shape::{self, LocalRay};
use crate::tree;

/// Memory for tracing, kept from ray to ray.
#[derive(Debug)]
pub(crate) struct Workspace<R> {
    pub(crate) tree: tree::Workspace<R>,
    pending: Pending,
    /// Boundaries of components, with the component's index.
    crossings: Vec<(u32, Crossing<R>)>,
}

impl<R: Real> Workspace<R> {
    pub(crate) fn new(scene: &Scene<R>) -> Self {
        Workspace {
            tree: tree::Workspace::new(scene),
            pending: Pending::default(),
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

impl<R: Real> LeafSpan<R> {
    /// Whether the origin is inside, or enters at once.
    pub(crate) fn is_inside(&self) -> bool {
        !self.enter.is_ahead() && self.exit.is_ahead()
    }
}

impl<R: Real> Leaf<R> {
    /// An end of the leaf's span on a ray, as a crossing.
    #[inline(always)]
    fn crossing(
        &self,
        index: u32,
        ray: &Ray<R>,
        local: &LocalRay<R>,
        end: shape::End<R>,
        entering: bool,
    ) -> Crossing<R> {
        let t = end.t.to_f64().abs();
        // What rounding may have moved the origin by, in lengths of the direction.
        let reach = self.origin_size(ray) / local.dir.max_norm().to_f64();
        // An infinite end is no crossing, and ties with nothing.
        let roundings = if t.is_finite() { t + reach } else { 0.0 };
        let tolerance = TIE_ROUNDINGS * R::UNIT_ROUNDOFF * roundings;
        let is_exact = local.is_on(end.root.face) && end.t.is_surely_zero();
        let tolerance = if is_exact { 0.0 } else { tolerance };
        Crossing { t: end.t, tolerance, leaf: index, root: end.root, entering }
    }

    /// Whether a ray surely has no entry that matters, by what takes less than its whole span.
    #[inline(always)]
    fn is_surely_missed<const OUTSIDE: bool>(&self, index: u32, reach: &Reach<'_, R>) -> bool {
        let ray = reach.ray;
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
            rise.is_surely_positive()
                || rise.mul_add(R::from_f64(reach.t_end), height).is_surely_positive()
        } else {
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
        let leaf = &self.leaves[index as usize];
        let local = self.local_ray(index, ray);
        let span = shape::span(leaf.kind, &local)?;
        let crossing = |end, entering| leaf.crossing(index, ray, &local, end, entering);
        Some(LeafSpan { enter: crossing(span.enter, true), exit: crossing(span.exit, false) })
    }

    /// Where a ray enters a leaf, if that lies ahead and no farther than anything matters;
    /// breaks if the leaf holds the origin, unless the ray is known to start `OUTSIDE`.
    #[inline(always)]
    fn leaf_entry<const OUTSIDE: bool>(
        &self,
        index: u32,
        reach: &Reach<'_, R>,
    ) -> ControlFlow<(), Option<Crossing<R>>> {
        let leaf = &self.leaves[index as usize];
        let ray = reach.ray;
        if self.omissions.holds(Part::Planes) && leaf.is_surely_missed::<OUTSIDE>(index, reach) {
            return ControlFlow::Continue(None);
        }
        let local = self.local_ray(index, ray);
        let Some(span) = shape::span(leaf.kind, &local) else { return ControlFlow::Continue(None) };
        let t = span.enter.t;
        let is_behind = OUTSIDE && (-t).is_surely_positive();
        if is_behind || t.to_f64() - t.radius() > reach.t_end {
            return ControlFlow::Continue(None);
        }
        let crossing = |end, entering| leaf.crossing(index, ray, &local, end, entering);
        let enter = crossing(span.enter, true);
        if enter.is_ahead() {
            return ControlFlow::Continue(Some(enter));
        }
        if !OUTSIDE && crossing(span.exit, false).is_ahead() {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(None)
    }

    /// Whether two crossings cannot be told apart, or are of one and the same surface.
    pub(crate) fn is_tie(&self, a: &Crossing<R>, b: &Crossing<R>) -> bool {
        // Numbers that keep account of their errors may not know that such roots are the same.
        let is_same = || {
            let [of_a, of_b] =
                [a, b].map(|c| self.face_surface(&self.leaves[c.leaf as usize], c.root.face));
            let is_one = a.leaf == b.leaf && a.root == b.root;
            is_one || of_a == of_b && of_a < self.n_shared && a.root.plus == b.root.plus
        };
        R::KEEPS_ACCOUNT && is_same() || a.ties_with(b)
    }

    /// The first boundary ahead of the ray's origin. Of those that tie with the first, the one of
    /// the last operand of the union that the scene is paints.
    pub(crate) fn first_hit(
        &self,
        ray: &Ray<R>,
        workspace: &mut Workspace<R>,
    ) -> Option<Crossing<R>> {
        let reach = self.reach(ray, f64::INFINITY);
        let entry = match ray.medium {
            Medium::Inside => ControlFlow::Break(()),
            Medium::Outside => self.first_entry::<true>(&reach, workspace),
            Medium::Unknown => self.first_entry::<false>(&reach, workspace),
        };
        match entry {
            ControlFlow::Continue(crossing) => crossing,
            ControlFlow::Break(()) => self.first_exit(&reach, workspace),
        }
    }

    /// The first boundary of a ray that starts outside the union; breaks if it starts inside.
    fn first_entry<const OUTSIDE: bool>(
        &self,
        reach: &Reach<'_, R>,
        workspace: &mut Workspace<R>,
    ) -> ControlFlow<(), Option<Crossing<R>>> {
        let Workspace { tree, pending, crossings } = workspace;
        crossings.clear();
        let mut first: Option<Crossing<R>> = None;
        self.hierarchy.visit(&reach.line, reach.t_end, pending, |index, t_end| {
            let nearer = Reach { t_end: *t_end, ..*reach };
            let Some(crossing) = self.entry::<OUTSIDE>(index, &nearer, tree)? else {
                return ControlFlow::Continue(());
            };
            crossings.push((index, crossing));
            // Which of two that tie is called the first makes no difference.
            if first.as_ref().is_none_or(|first| crossing.t.total_cmp(&first.t).is_lt()) {
                first = Some(crossing);
                *t_end = reach.line.end_of_ties(crossing.t);
            }
            ControlFlow::Continue(())
        })?;
        let Some(first) = first else { return ControlFlow::Continue(None) };
        let ties = crossings.iter().filter(|(_, crossing)| self.is_tie(crossing, &first));
        let last = ties.max_by_key(|(index, _)| *index);
        ControlFlow::Continue(last.map(|(_, crossing)| *crossing))
    }

    /// A ray up to `t_end`.
    #[inline(always)]
    fn reach<'r>(&self, ray: &'r Ray<R>, t_end: f64) -> Reach<'r, R> {
        Reach { ray, line: Line::new(ray, self.conditioning, self.extent), t_end }
    }

    /// Whether anything is met before `t_end` (anywhere, if none). The component `blocker` is tried
    /// first, and becomes the one that was found to be met, if any.
    pub(crate) fn is_blocked(
        &self,
        ray: &Ray<R>,
        t_end: Option<R>,
        blocker: &mut Option<u32>,
        workspace: &mut Workspace<R>,
    ) -> bool {
        let is_before = |crossing: &Crossing<R>| match t_end {
            None => true,
            Some(end) => (end - crossing.t).exceeds(crossing.tolerance),
        };
        if ray.medium != Medium::Outside {
            return self.first_hit(ray, workspace).as_ref().is_some_and(is_before);
        }
        let Workspace { tree, pending, .. } = workspace;
        let mut reach = self.reach(ray, f64::INFINITY);
        if let Some(end) = t_end {
            reach.t_end = reach.line.end_of_ties(end);
        }
        let mut is_blocker = |index| {
            let crossing = self.entry::<true>(index, &reach, tree);
            crossing.continue_value().flatten().as_ref().is_some_and(is_before)
        };
        if blocker.is_some_and(&mut is_blocker) {
            return true;
        }
        let tried = blocker.take();
        let visited = self.hierarchy.visit(&reach.line, reach.t_end, pending, |index, _| {
            if tried != Some(index) && is_blocker(index) {
                *blocker = Some(index);
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        visited.is_break()
    }

    /// The first boundary of a component ahead, if it lies within reach; breaks if the component
    /// holds the ray's origin. For rays that are known to start `OUTSIDE` nothing holds it, whatever
    /// rounding says, and only entries count.
    #[inline(always)]
    fn entry<const OUTSIDE: bool>(
        &self,
        index: u32,
        reach: &Reach<'_, R>,
        workspace: &mut tree::Workspace<R>,
    ) -> ControlFlow<(), Option<Crossing<R>>> {
        match self.components[index as usize] {
            Component::Leaf(leaf) => self.leaf_entry::<OUTSIDE>(leaf, reach),
            Component::Tree { root, hierarchy } => {
                let mut first = None;
                let is_inside = self.sweep(root, hierarchy, reach, workspace, |crossing| {
                    let counts = crossing.entering || !OUTSIDE;
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
        }
    }

    /// For a ray that starts inside the union: where it leaves it. Boundaries between components
    /// that overlap or touch are none of the union.
    fn first_exit(
        &self,
        reach: &Reach<'_, R>,
        workspace: &mut Workspace<R>,
    ) -> Option<Crossing<R>> {
        let Workspace { tree, pending, crossings } = workspace;
        crossings.clear();
        let mut n_around: usize = 0;
        let ControlFlow::Continue(()) =
            self.hierarchy.visit(&reach.line, reach.t_end, pending, |index, _| {
                n_around += usize::from(match self.components[index as usize] {
                    Component::Leaf(leaf) => self.leaf_span(leaf, reach.ray).is_some_and(|span| {
                        let ends = [span.enter, span.exit]
                            .into_iter()
                            .filter(|end| end.is_ahead() && end.t.to_f64().is_finite());
                        crossings.extend(ends.map(|end| (index, end)));
                        span.is_inside()
                    }),
                    Component::Tree { root, hierarchy } => {
                        self.sweep(root, hierarchy, reach, tree, |crossing| {
                            crossings.push((index, crossing));
                            false
                        })
                    }
                });
                ControlFlow::<Infallible>::Continue(())
            });
        crossings.sort_by(|(i, a), (j, b)| a.t.total_cmp(&b.t).then(i.cmp(j)));
        let groups = crossings.chunk_by(|(_, a), (_, b)| self.is_tie(a, b));
        for group in groups {
            let was_inside = n_around > 0;
            for (_, crossing) in group {
                n_around =
                    if crossing.entering { n_around + 1 } else { n_around.saturating_sub(1) };
            }
            if was_inside && n_around == 0 {
                let exits = group.iter().filter(|(_, crossing)| !crossing.entering);
                return exits.max_by_key(|(index, _)| *index).map(|(_, crossing)| *crossing);
            }
        }
        None
    }
}
