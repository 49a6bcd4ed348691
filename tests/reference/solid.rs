//! Where a line is inside a solid: each shape by its inequalities, set operations by merging lists
//! of all boundaries.

use std::sync::Arc;

use renderer::object::{NodeKind, Object, SetOp, ShapeKind};
use vm::value::Closure;

use crate::number::{Big, Map, NOTHING, Vector, big, is_positive, to_f64};

/// A shape where it stands.
pub(crate) struct Leaf {
    pub(crate) kind: ShapeKind,
    /// Index of its surface function.
    pub(crate) surface: u32,
    pub(crate) object_from_world: Map,
    /// Sizes of the matrix and the shift of `object_from_world`.
    linear: f64,
    shift: f64,
    around: Option<Ball>,
}

/// A ball around a shape.
struct Ball {
    center: [f64; 3],
    radius: f64,
}

pub(crate) enum Solid {
    Leaf(Box<Leaf>),
    Combined(SetOp, Box<Solid>, Box<Solid>),
}

/// A boundary on a line.
#[derive(Clone)]
pub(crate) struct Crossing<'s> {
    pub(crate) t: Big,
    /// What would be 0 in exact arithmetic, at `t`.
    pub(crate) nothing: f64,
    pub(crate) leaf: &'s Leaf,
    pub(crate) face: u8,
    pub(crate) entering: bool,
}

/// All boundaries of a solid on a line, in order.
#[derive(Default)]
pub(crate) struct Boundaries<'s> {
    /// Whether the line comes from inside.
    from_inside: bool,
    pub(crate) crossings: Vec<Crossing<'s>>,
}

/// A line in world space.
pub(crate) struct Line {
    pub(crate) origin: Vector,
    pub(crate) dir: Vector,
}

impl Crossing<'_> {
    fn is_at(&self, other: &Crossing<'_>) -> bool {
        to_f64(&(&self.t - &other.t)).abs() <= self.nothing + other.nothing
    }

    /// Whether it is ahead of the line's origin, not at it.
    pub(crate) fn is_ahead(&self) -> bool {
        to_f64(&self.t) > self.nothing
    }
}

impl Solid {
    /// `surface` gives each surface function its number.
    pub(crate) fn new(
        object: &Object<Arc<Closure>>,
        placed: &Map,
        surface: &impl Fn(&Arc<Closure>) -> u32,
    ) -> Self {
        let mut operands = object.children();
        let mut operand =
            |placed: &Map| Solid::new(operands.next().expect("an operand"), placed, surface);
        match object.kind() {
            NodeKind::Shape(kind, closure) => {
                Solid::Leaf(Box::new(Leaf::new(*kind, surface(closure), placed)))
            }
            NodeKind::Transformed(op) => operand(&placed.after(&Map::of(*op))),
            NodeKind::Combined(op) => {
                Solid::Combined(*op, Box::new(operand(placed)), Box::new(operand(placed)))
            }
        }
    }

    pub(crate) fn n_shapes(&self) -> usize {
        match self {
            Solid::Leaf(_) => 1,
            Solid::Combined(_, a, b) => a.n_shapes() + b.n_shapes(),
        }
    }

    pub(crate) fn boundaries(&self, line: &Line) -> Boundaries<'_> {
        match self {
            Solid::Leaf(leaf) => leaf.boundaries(line),
            Solid::Combined(op, a, b) => combined(*op, a.boundaries(line), b.boundaries(line)),
        }
    }
}

/// Changes of both operands at one place take effect together. Where that changes the result, the
/// boundary is that of the operand that has changed; of both, the second of a union, else the first.
fn combined<'s>(op: SetOp, a: Boundaries<'s>, b: Boundaries<'s>) -> Boundaries<'s> {
    let result = |a: bool, b: bool| match op {
        SetOp::Union => a || b,
        SetOp::Intersect => a && b,
        SetOp::Difference => a && !b,
    };
    let (mut in_a, mut in_b) = (a.from_inside, b.from_inside);
    let mut all = Boundaries { from_inside: result(in_a, in_b), crossings: Vec::new() };
    let (mut from_a, mut from_b) =
        (a.crossings.into_iter().peekable(), b.crossings.into_iter().peekable());
    loop {
        let (takes_a, takes_b) = match (from_a.peek(), from_b.peek()) {
            (None, None) => return all,
            (Some(_), None) => (true, false),
            (None, Some(_)) => (false, true),
            (Some(a), Some(b)) if a.is_at(b) => (true, true),
            (Some(a), Some(b)) => (a.t < b.t, a.t >= b.t),
        };
        let was_inside = result(in_a, in_b);
        let of_a = from_a.next_if(|_| takes_a);
        let of_b = from_b.next_if(|_| takes_b);
        in_a ^= of_a.is_some();
        in_b ^= of_b.is_some();
        let is_inside = result(in_a, in_b);
        if is_inside != was_inside {
            let (first, second) = if op == SetOp::Union { (of_b, of_a) } else { (of_a, of_b) };
            let crossing = first.or(second).expect("one of them");
            all.crossings.push(Crossing { entering: is_inside, ..crossing });
        }
    }
}

/// Where a line is inside something convex: ends by face, none where it does not end.
struct Span {
    enter: Option<(Big, u8)>,
    exit: Option<(Big, u8)>,
}

impl Span {
    const ALL: Span = Span { enter: None, exit: None };

    /// What is in both. Where two ends are at one place, this one's stay.
    fn and(self, other: Span, is_same: impl Fn(&Big, &Big) -> bool) -> Option<Span> {
        let inner =
            |own: Option<(Big, u8)>, other: Option<(Big, u8)>, later: bool| match (own, other) {
                (Some(own), Some(other)) => {
                    let is_inner = !is_same(&own.0, &other.0) && (other.0 > own.0) == later;
                    Some(if is_inner { other } else { own })
                }
                (own, other) => own.or(other),
            };
        let span = Span {
            enter: inner(self.enter, other.enter, true),
            exit: inner(self.exit, other.exit, false),
        };
        match (&span.enter, &span.exit) {
            (Some((enter, _)), Some((exit, _))) if enter >= exit || is_same(enter, exit) => None,
            _ => Some(span),
        }
    }
}

impl Leaf {
    fn new(kind: ShapeKind, surface: u32, world_from_object: &Map) -> Self {
        let object_from_world = world_from_object.inverse();
        let (linear, shift) = (object_from_world.size(), object_from_world.shift.size());
        let (center, radius) = match kind {
            ShapeKind::Sphere => ([0.0; 3], 1.0),
            ShapeKind::Cube => ([0.5; 3], 0.9),
            ShapeKind::Cylinder | ShapeKind::Cone => ([0.0, 0.5, 0.0], 1.2),
            ShapeKind::Plane => ([0.0; 3], f64::INFINITY),
        };
        let stretch =
            world_from_object.rows.iter().map(|row| to_f64(&row.dot(row))).sum::<f64>().sqrt();
        let center = world_from_object.point(&Vector::from_f64s(center)).0.each_ref().map(to_f64);
        let ball = Ball { center, radius: radius * stretch };
        let around = ball.radius.is_finite().then_some(ball);
        Leaf { kind, surface, object_from_world, linear, shift, around }
    }

    /// The size of the terms that a point's place in object space is computed from.
    pub(crate) fn size_at(&self, point: &Vector) -> f64 {
        self.linear * point.size() + self.shift
    }

    fn boundaries(&self, line: &Line) -> Boundaries<'_> {
        if self.around.as_ref().is_some_and(|ball| ball.is_missed(line)) {
            return Boundaries::default();
        }
        let origin = self.object_from_world.point(&line.origin);
        let dir = self.object_from_world.vector(&line.dir);
        // Lengths of the direction that exact arithmetic would call 0.
        let reach = self.size_at(&line.origin) / dir.size();
        let nothing = |t: &Big| NOTHING * (reach + to_f64(t).abs());
        let local = Local { origin, dir, size: self.size_at(&line.origin) };
        let is_same = |a: &Big, b: &Big| to_f64(&(a - b)).abs() <= nothing(a) + nothing(b);
        let Some(span) = local.span(self.kind, is_same) else { return Boundaries::default() };
        let from_inside = span.enter.is_none();
        let ends = [(span.enter, true), (span.exit, false)];
        let crossing = |(end, entering): (Option<(Big, u8)>, bool)| {
            end.map(|(t, face)| Crossing { nothing: nothing(&t), t, leaf: self, face, entering })
        };
        Boundaries { from_inside, crossings: ends.into_iter().filter_map(crossing).collect() }
    }
}

impl Ball {
    /// Whether a line surely passes by: with room for all roundings of this test.
    fn is_missed(&self, line: &Line) -> bool {
        let d = line.dir.0.each_ref().map(to_f64);
        let o = line.origin.0.each_ref().map(to_f64);
        let to_center: [f64; 3] = std::array::from_fn(|i| self.center[i] - o[i]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (dd, cc, dc) = (dot(d, d), dot(to_center, to_center), dot(d, to_center));
        let size = dot(o, o) + dot(self.center, self.center);
        cc - dc * dc / dd > 1.01 * self.radius * self.radius + 1e-9 * size
    }
}

/// A line in a shape's space.
struct Local {
    origin: Vector,
    dir: Vector,
    /// Of the terms that the origin was computed from.
    size: f64,
}

impl Local {
    fn span(&self, kind: ShapeKind, is_same: impl Fn(&Big, &Big) -> bool + Copy) -> Option<Span> {
        match kind {
            ShapeKind::Sphere => self.quadric([1.0, 1.0, 1.0], 1.0),
            ShapeKind::Cylinder => {
                self.quadric([1.0, 0.0, 1.0], 1.0)?.and(self.between(1, [2, 1])?, is_same)
            }
            ShapeKind::Cone => {
                self.quadric([1.0, -1.0, 1.0], 0.0)?.and(self.below(1, 1.0, 1)?, is_same)
            }
            ShapeKind::Plane => self.below(1, 0.0, 0),
            ShapeKind::Cube => {
                let (x, y) = (self.between(0, [2, 3])?, self.between(1, [5, 4])?);
                x.and(y, is_same)?.and(self.between(2, [0, 1])?, is_same)
            }
        }
    }

    /// Where the coordinate is from 0 to 1; faces are those at 0 and 1.
    fn between(&self, axis: usize, [low, high]: [u8; 2]) -> Option<Span> {
        let crosses = |offset: f64, face| self.crossing(axis, offset).map(|t| (t, face));
        let (Some(at_0), Some(at_1)) = (crosses(0.0, low), crosses(1.0, high)) else {
            let at = to_f64(&self.origin.0[axis]);
            let nothing = NOTHING * self.size;
            return (-nothing <= at && at <= 1.0 + nothing).then_some(Span::ALL);
        };
        let upward = is_positive(&self.dir.0[axis]);
        let (enter, exit) = if upward { (at_0, at_1) } else { (at_1, at_0) };
        Some(Span { enter: Some(enter), exit: Some(exit) })
    }

    /// Where the coordinate is at most `offset`.
    fn below(&self, axis: usize, offset: f64, face: u8) -> Option<Span> {
        let Some(t) = self.crossing(axis, offset) else {
            let above = to_f64(&(&self.origin.0[axis] - big(offset)));
            return (above <= NOTHING * self.size).then_some(Span::ALL);
        };
        let end = Some((t, face));
        let upward = is_positive(&self.dir.0[axis]);
        Some(if upward {
            Span { exit: end, ..Span::ALL }
        } else {
            Span { enter: end, ..Span::ALL }
        })
    }

    /// None for a line parallel to the plane.
    fn crossing(&self, axis: usize, offset: f64) -> Option<Big> {
        let speed = &self.dir.0[axis];
        let is_parallel = to_f64(speed).abs() <= NOTHING * self.dir.size();
        (!is_parallel).then(|| (big(offset) - &self.origin.0[axis]) / speed)
    }

    /// Where `s1 x² + s2 y² + s3 z² <= k`, of a cone the upper half; face 0.
    fn quadric(&self, signs: [f64; 3], k: f64) -> Option<Span> {
        let j = Vector::from_f64s(signs);
        let (jo, jd) = (self.origin.by_component(&j), self.dir.by_component(&j));
        // a t² + 2 b t + c = 0
        let (a, b) = (self.dir.dot(&jd), self.origin.dot(&jd));
        let c = self.origin.dot(&jo) - big(k);
        let (d_size, o_size) = (self.dir.size(), self.size + 1.0);
        let is_cone = k == 0.0;
        let upward = is_positive(&self.dir.0[1]);
        if to_f64(&a).abs() <= NOTHING * d_size * d_size {
            // Linear: inside on one side of the root, or everywhere or nowhere.
            if to_f64(&b).abs() <= NOTHING * d_size * o_size {
                let is_inside = !is_cone && to_f64(&c) < -NOTHING * o_size * o_size;
                return is_inside.then_some(Span::ALL);
            }
            let root = Some((-c / (big(2.0) * &b), 0));
            return match (is_positive(&b), upward) {
                (true, false) => Some(Span { exit: root, ..Span::ALL }),
                (false, true) => Some(Span { enter: root, ..Span::ALL }),
                _ => None,
            };
        }
        let discriminant = &b * &b - &a * &c;
        let is_tangent = to_f64(&discriminant) <= NOTHING * d_size * d_size * o_size * o_size;
        if is_positive(&a) {
            if is_tangent {
                return None;
            }
            let root = discriminant.sqrt();
            let (enter, exit) = ((-&b - &root) / &a, (-&b + &root) / &a);
            // Both roots of a flat line are on one half of the cone.
            let y_between = &self.origin.0[1] - &self.dir.0[1] * &b / &a;
            let is_met = !is_cone || is_positive(&y_between);
            return is_met.then_some(Span { enter: Some((enter, 0)), exit: Some((exit, 0)) });
        }
        // Steeper than the cone: it enters the upper half for good, or comes from it.
        let root = if is_tangent { big(0.0) } else { discriminant.sqrt() };
        let near = (-&b + &root) / &a;
        let far = (-&b - &root) / &a;
        Some(if upward {
            Span { enter: Some((far, 0)), ..Span::ALL }
        } else {
            Span { exit: Some((near, 0)), ..Span::ALL }
        })
    }
}
