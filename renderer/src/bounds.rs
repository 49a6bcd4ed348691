//! Boxes around solids, in world space, and around the parts of a tree of set operations that matter.

use glam::{DAffine3, DVec3};

use crate::object::{SetOp, ShapeKind};
use crate::scene::{Kind, NONE, Node};

/// A box with sides along the axes; it may be unbounded, and holds nothing if a lower end lies above
/// its upper end. No end is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) lo: DVec3,
    pub(crate) hi: DVec3,
}

impl Bounds {
    pub(crate) const ALL: Bounds = Bounds { lo: DVec3::NEG_INFINITY, hi: DVec3::INFINITY };
    pub(crate) const NOTHING: Bounds = Bounds { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY };

    pub(crate) fn is_empty(&self) -> bool {
        self.lo.cmpgt(self.hi).any()
    }

    /// Larger by what `pad` says for its largest coordinate, at bounded ends.
    pub(crate) fn padded(&self, pad: impl Fn(f64) -> f64) -> Bounds {
        let ends = [self.lo.to_array(), self.hi.to_array()];
        let bounded = ends.as_flattened().iter().filter(|end| end.is_finite());
        let pad = pad(bounded.fold(0.0, |size: f64, end| size.max(end.abs())));
        if !pad.is_finite() {
            return Bounds::ALL;
        }
        Bounds { lo: self.lo - pad, hi: self.hi + pad }
    }

    /// The smallest box around both.
    pub(crate) fn or(&self, other: &Bounds) -> Bounds {
        Bounds { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// What lies in both.
    pub(crate) fn and(&self, other: &Bounds) -> Bounds {
        Bounds { lo: self.lo.max(other.lo), hi: self.hi.min(other.hi) }
    }
}

/// The box around a shape, tight however it is turned, but for a few roundings.
pub(crate) fn of_shape(
    kind: ShapeKind,
    world_from_object: &DAffine3,
    object_from_world: &DAffine3,
) -> Bounds {
    if kind == ShapeKind::Plane {
        return of_half_space(object_from_world);
    }
    let mut bounds = Bounds::ALL;
    for axis in 0..3 {
        let (below, above) = extent(kind, world_from_object.matrix3.row(axis));
        let shift = world_from_object.translation[axis];
        let (lo, hi) = (shift + below, shift + above);
        // Whatever is not a number bounds nothing.
        if lo <= hi {
            (bounds.lo[axis], bounds.hi[axis]) = (lo, hi);
        }
    }
    bounds
}

/// How far a shape reaches along the linear form with these coefficients.
fn extent(kind: ShapeKind, DVec3 { x, y, z }: DVec3) -> (f64, f64) {
    let around = (x * x + z * z).sqrt();
    match kind {
        ShapeKind::Sphere => {
            let radius = (x * x + y * y + z * z).sqrt();
            (-radius, radius)
        }
        ShapeKind::Cube => {
            (x.min(0.0) + y.min(0.0) + z.min(0.0), x.max(0.0) + y.max(0.0) + z.max(0.0))
        }
        ShapeKind::Cylinder => (y.min(0.0) - around, y.max(0.0) + around),
        // The apex, and the disc around (0, 1, 0).
        ShapeKind::Cone => ((y - around).min(0.0), (y + around).max(0.0)),
        ShapeKind::Plane => (f64::NEG_INFINITY, f64::INFINITY),
    }
}

/// Half-spaces have a bound if they face along an axis.
fn of_half_space(object_from_world: &DAffine3) -> Bounds {
    let mut bounds = Bounds::ALL;
    let row = object_from_world.matrix3.row(1);
    let shift = object_from_world.translation.y;
    for axis in 0..3 {
        if (0..3).all(|other| (row[other] == 0.0) == (other != axis)) {
            // row x + shift <= 0
            let end = -shift / row[axis];
            if row[axis] > 0.0 && end.is_finite() {
                bounds.hi[axis] = end;
            } else if end.is_finite() {
                bounds.lo[axis] = end;
            }
        }
    }
    bounds
}

/// For the nodes of one tree, in preorder, where they matter: outside, their value makes no
/// difference to the root's. A leaf that a ray does not meet there may be taken as not met at all.
///
/// Outside its bounds the root is false, whatever is left out, since every node is: a union as all
/// its operands are, an intersection as one is, a difference as the minuend is. Inside, the same
/// holds for each operand that is left out, so that all values are right.
pub(crate) fn relevant(
    nodes: &[Node],
    first: u32,
    mut bounds_of: impl FnMut(u32) -> Bounds,
) -> Vec<Bounds> {
    let parent = |index: usize| {
        (nodes[index].parent != NONE).then(|| (nodes[index].parent - first) as usize)
    };
    let mut bounds: Vec<Bounds> = nodes
        .iter()
        .map(|node| match node.kind {
            Kind::Leaf(leaf) => bounds_of(leaf),
            Kind::Combined(SetOp::Intersect) => Bounds::ALL,
            Kind::Combined(SetOp::Union | SetOp::Difference) => Bounds::NOTHING,
        })
        .collect();
    for index in (0..nodes.len()).rev() {
        let Some(above) = parent(index) else { continue };
        let own = bounds[index];
        match nodes[above].kind {
            Kind::Combined(SetOp::Union) => bounds[above] = bounds[above].or(&own),
            Kind::Combined(SetOp::Intersect) => bounds[above] = bounds[above].and(&own),
            Kind::Combined(SetOp::Difference) if nodes[index].weight > 0 => bounds[above] = own,
            Kind::Combined(SetOp::Difference) | Kind::Leaf(_) => {}
        }
    }
    for index in 0..nodes.len() {
        if let Some(above) = parent(index) {
            bounds[index] = bounds[index].and(&bounds[above]);
        }
    }
    bounds
}

#[cfg(test)]
mod tests;
