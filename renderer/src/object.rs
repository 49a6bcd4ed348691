//! Solids as a GML program describes them: shapes, transforms and set operations, shared freely.

use std::sync::Arc;

use glam::DVec3;

/// The five solids, in their own object space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShapeKind {
    /// `x² + y² + z² <= 1`.
    Sphere,
    /// `0 <= x, y, z <= 1`.
    Cube,
    /// `x² + z² <= 1`, `0 <= y <= 1`.
    Cylinder,
    /// `x² + z² <= y²`, `0 <= y <= 1`: apex at the origin.
    Cone,
    /// The half-space `y <= 0`.
    Plane,
}

/// A transform, applied on top of those that an object has already.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransformOp {
    /// Adds a vector.
    Translate(DVec3),
    /// Multiplies each coordinate; negative factors mirror.
    Scale(DVec3),
    /// Turns y toward z, by degrees.
    RotateX(f64),
    /// Turns z toward x, by degrees.
    RotateY(f64),
    /// Turns x toward y, by degrees.
    RotateZ(f64),
}

/// A transform that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransformError {
    /// A scale factor is 0.
    ZeroScale,
    /// An operand is NaN or infinite, or the product of all transforms may leave the range of
    /// doubles.
    NonFinite,
}

/// Set operations on solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SetOp {
    /// Points in either.
    Union,
    /// Points in both.
    Intersect,
    /// Points in the first but not in the second.
    Difference,
}

/// A solid; `S` is a surface function.
#[derive(Debug)]
pub struct Object<S>(Arc<Node<S>>);

impl<S> Clone for Object<S> {
    fn clone(&self) -> Self {
        Object(self.0.clone())
    }
}

#[derive(Debug)]
struct Node<S> {
    kind: NodeKind<S>,
    children: [Option<Object<S>>; 2],
    n_shapes: u64,
    range: StoredRange,
}

/// What an object is; what it is made of are its [`children`](Object::children).
#[derive(Debug)]
pub enum NodeKind<S> {
    /// A shape in its own space, and its surface function.
    Shape(ShapeKind, S),
    /// Its one operand, transformed.
    Transformed(TransformOp),
    /// Its two operands, united, intersected, or the second taken from the first.
    Combined(SetOp),
}

/// Bounds of the matrices from object to world space and back: their 2-norms, and the lengths of
/// the shifts. While these are finite, so is every entry.
#[derive(Clone, Copy, Debug)]
struct Range {
    linear: f64,
    shift: f64,
    inverse_linear: f64,
    inverse_shift: f64,
}

impl Range {
    const IDENTITY: Range =
        Range { linear: 1.0, shift: 0.0, inverse_linear: 1.0, inverse_shift: 0.0 };

    fn transformed(self, op: TransformOp) -> Range {
        match op {
            TransformOp::Translate(by) => Range {
                shift: self.shift + by.length(),
                inverse_shift: self.inverse_shift + self.inverse_linear * by.length(),
                ..self
            },
            TransformOp::Scale(by) => {
                let largest = by.abs().max_element();
                Range {
                    linear: self.linear * largest,
                    shift: self.shift * largest,
                    inverse_linear: self.inverse_linear / by.abs().min_element(),
                    ..self
                }
            }
            TransformOp::RotateX(_) | TransformOp::RotateY(_) | TransformOp::RotateZ(_) => self,
        }
    }

    fn combined(self, other: Range) -> Range {
        Range {
            linear: self.linear.max(other.linear),
            shift: self.shift.max(other.shift),
            inverse_linear: self.inverse_linear.max(other.inverse_linear),
            inverse_shift: self.inverse_shift.max(other.inverse_shift),
        }
    }

    fn is_finite(self) -> bool {
        [self.linear, self.shift, self.inverse_linear, self.inverse_shift]
            .iter()
            .all(|x| x.is_finite())
    }
}

/// A [`Range`] in half the space.
#[derive(Clone, Copy, Debug)]
struct StoredRange([UpperHalf; 4]);

impl From<Range> for StoredRange {
    fn from(range: Range) -> Self {
        let Range { linear, shift, inverse_linear, inverse_shift } = range;
        StoredRange([linear, shift, inverse_linear, inverse_shift].map(UpperHalf::of))
    }
}

impl From<StoredRange> for Range {
    fn from(StoredRange(bounds): StoredRange) -> Self {
        let [linear, shift, inverse_linear, inverse_shift] = bounds.map(UpperHalf::bound);
        Range { linear, shift, inverse_linear, inverse_shift }
    }
}

/// The upper half of a double that is not negative, rounded up: by less than 2^-20 of it, so that a chain
/// of a million transforms has bounds that are less than three times as large as they could be.
#[derive(Clone, Copy, Debug)]
struct UpperHalf(u32);

impl UpperHalf {
    fn of(bound: f64) -> Self {
        let bits = bound.to_bits();
        let is_rounded = bits as u32 != 0;
        UpperHalf((bits >> 32) as u32 + u32::from(is_rounded))
    }

    fn bound(self) -> f64 {
        f64::from_bits(u64::from(self.0) << 32)
    }
}

impl<S> Object<S> {
    /// Bytes that one node of a description takes, with two counts and a word of the allocator's.
    pub const NODE_BYTES: usize = size_of::<Node<S>>() + 3 * size_of::<usize>();

    fn node(
        kind: NodeKind<S>,
        children: [Option<Object<S>>; 2],
        n_shapes: u64,
        range: Range,
    ) -> Self {
        Object(Arc::new(Node { kind, children, n_shapes, range: range.into() }))
    }

    /// A shape in its own space.
    #[must_use]
    pub fn shape(kind: ShapeKind, surface: S) -> Self {
        Object::node(NodeKind::Shape(kind, surface), [None, None], 1, Range::IDENTITY)
    }

    /// The object, transformed.
    ///
    /// # Errors
    /// When the transform cannot be undone in doubles.
    pub fn transformed(&self, op: TransformOp) -> Result<Self, TransformError> {
        let is_finite = match op {
            TransformOp::Translate(by) | TransformOp::Scale(by) => by.is_finite(),
            TransformOp::RotateX(angle)
            | TransformOp::RotateY(angle)
            | TransformOp::RotateZ(angle) => angle.is_finite(),
        };
        if let TransformOp::Scale(by) = op
            && by.cmpeq(DVec3::ZERO).any()
        {
            return Err(TransformError::ZeroScale);
        }
        let range = Range::from(self.0.range).transformed(op);
        if !is_finite || !range.is_finite() {
            return Err(TransformError::NonFinite);
        }
        let kind = NodeKind::Transformed(op);
        Ok(Object::node(kind, [Some(self.clone()), None], self.0.n_shapes, range))
    }

    fn combined(&self, other: &Self, op: SetOp) -> Self {
        let n_shapes = self.0.n_shapes.saturating_add(other.0.n_shapes);
        let range = Range::from(self.0.range).combined(other.0.range.into());
        let children = [Some(self.clone()), Some(other.clone())];
        Object::node(NodeKind::Combined(op), children, n_shapes, range)
    }

    /// The points in either object.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        self.combined(other, SetOp::Union)
    }

    /// The points in both objects.
    #[must_use]
    pub fn intersect(&self, other: &Self) -> Self {
        self.combined(other, SetOp::Intersect)
    }

    /// The points in this object but not in the other.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Self {
        self.combined(other, SetOp::Difference)
    }

    /// Number of shapes that a scene of this object has, those met repeatedly counted each time.
    #[must_use]
    pub fn n_shapes(&self) -> u64 {
        self.0.n_shapes
    }

    /// Whether it has other owners: another value, or an object that it is part of.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        Arc::strong_count(&self.0) > 1
    }

    /// What tells shared nodes apart.
    #[must_use]
    pub fn address(&self) -> usize {
        Arc::as_ptr(&self.0) as usize
    }

    /// The objects that it is made of, first operand first.
    pub fn children(&self) -> impl DoubleEndedIterator<Item = &Object<S>> {
        self.0.children.iter().flatten()
    }

    /// The surface function, if it is a shape.
    #[must_use]
    pub fn surface(&self) -> Option<&S> {
        if let NodeKind::Shape(_, surface) = &self.0.kind { Some(surface) } else { None }
    }

    /// What it is, but for the objects that it is made of.
    #[must_use]
    pub fn kind(&self) -> &NodeKind<S> {
        &self.0.kind
    }
}

impl<S> Drop for Node<S> {
    /// Without recursion: a program can nest objects deeper than any native stack.
    fn drop(&mut self) {
        let mut pending: Vec<Object<S>> =
            self.children.iter_mut().filter_map(Option::take).collect();
        while let Some(object) = pending.pop() {
            if let Some(mut node) = Arc::into_inner(object.0) {
                pending.extend(node.children.iter_mut().filter_map(Option::take));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_transforms_are_refused_and_long_chains_are_not() {
        let sphere = Object::shape(ShapeKind::Sphere, ());
        let scale = |x: f64| TransformOp::Scale(DVec3::new(1.0, x, 1.0));
        assert_eq!(sphere.transformed(scale(0.0)).err(), Some(TransformError::ZeroScale));
        assert_eq!(sphere.transformed(scale(f64::NAN)).err(), Some(TransformError::NonFinite));
        assert_eq!(
            sphere.transformed(TransformOp::RotateX(f64::INFINITY)).err(),
            Some(TransformError::NonFinite)
        );
        let huge = sphere.transformed(scale(1e200)).expect("in range");
        assert_eq!(huge.transformed(scale(1e200)).err(), Some(TransformError::NonFinite));
        let mut object = sphere;
        for _ in 0..100_000 {
            object =
                object.transformed(TransformOp::Translate(DVec3::splat(1e7))).expect("in range");
            object = object.transformed(TransformOp::RotateY(17.0)).expect("in range");
        }
    }

    #[test]
    fn doubling_an_object_saturates_its_size() {
        let mut object = Object::shape(ShapeKind::Cube, ());
        for _ in 0..100 {
            object = object.union(&object);
        }
        assert_eq!(object.n_shapes(), u64::MAX);
    }
}
