//! Rays in world space, what they meet, and how far rounding may put that off.

use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::shape::Root;

/// Roundings of the size of the terms that `t` may be off by. Bringing origin and direction into
/// object space, forming the root and comparing it costs about ten; 64 leaves room for planes met
/// at up to one in six. With no tolerance flush cuts leave skins (`tests/stability/edge-to-edge.gml`);
/// with half a rounding none is left in any scene of the tests.
pub(crate) const TIE_ROUNDINGS: f64 = 64.0;

/// A ray in world space. The direction has any length; `t` counts in its lengths.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray<R> {
    pub(crate) origin: Vec3<R>,
    pub(crate) dir: Vec3<R>,
    /// The surface that it starts on, unless it starts at the eye.
    pub(crate) on: Option<On<R>>,
    pub(crate) medium: Medium,
}

/// The face that a ray starts on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct On<R> {
    pub(crate) leaf: u32,
    /// The world-space surface that the face is part of.
    pub(crate) surface: u32,
    /// The origin in the leaf's object space, where it is known best.
    pub(crate) point: Vec3<R>,
}

/// What a ray runs through at first. Light that is reflected, and the light of lamps on the same
/// side, stay in the medium that the ray came through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Medium {
    /// Yet to be seen, as for the eye.
    Unknown,
    /// No solid: the first boundary is an entry.
    Outside,
    /// The inside of a solid: the first boundary is an exit.
    Inside,
}

/// A boundary of the scene, or of a part of it, on a ray. How far `t` may be off is its tolerance:
/// crossings within their tolerances of one another are one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing<R> {
    pub(crate) t: R,
    /// From the top: the leaf in 32 bits, the root, and whether it is an entry, in one word, since they are
    /// moved as one.
    boundary: u64,
}

impl<R> Crossing<R> {
    #[inline(always)]
    pub(crate) fn new(t: R, leaf: u32, root: Root, is_entry: bool) -> Self {
        let side = root.bits() << 1 | u32::from(is_entry);
        Crossing { t, boundary: u64::from(leaf) << 32 | u64::from(side) }
    }

    /// The index of the shape whose boundary it is.
    #[inline(always)]
    pub(crate) fn leaf(&self) -> u32 {
        (self.boundary >> 32) as u32
    }

    #[inline(always)]
    pub(crate) fn root(&self) -> Root {
        Root::from_bits(self.boundary as u32 >> 1)
    }

    /// Whether the ray goes from outside to inside.
    #[inline(always)]
    pub(crate) fn is_entry(&self) -> bool {
        self.boundary & 1 == 1
    }
}

/// How much larger rounding errors are in world space than the coordinates that they come from,
/// because shapes are stretched or lie far from the origin of their own space: an error bound is
/// `roundings (linear |x| + shift)` for a point x. Of several shapes, the largest.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Conditioning {
    pub(crate) linear: f64,
    pub(crate) shift: f64,
}

impl Conditioning {
    pub(crate) fn or(self, other: Conditioning) -> Conditioning {
        Conditioning { linear: self.linear.max(other.linear), shift: self.shift.max(other.shift) }
    }

    /// How far off a point may be whose coordinates are at most `size`.
    pub(crate) fn error(self, size: f64) -> f64 {
        TIE_ROUNDINGS * f64::UNIT_ROUNDOFF * (self.linear * size + self.shift)
    }
}

/// A ray, for being tested against boxes: it meets all of them that hold anything that it is found
/// to meet, however that is rounded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// The origin, moved up and down by what rounding may have moved it.
    above: [f64; 3],
    below: [f64; 3],
    /// 1 over the direction.
    inverse: [f64; 3],
    /// What the tolerance of any crossing has besides roundings of `t`, at most.
    tolerance: f64,
}

/// What the three roundings of a slab's ends, four where the direction has more digits than a double,
/// may take off an interval, with room (Ize, "Robust BVH Ray Traversal", 2013).
const WIDER: f64 = 1.0 + 8.0 * f64::EPSILON;

impl Line {
    /// `extent` is the size of the largest coordinate of any box.
    #[inline(always)]
    pub(crate) fn new<R: Real>(ray: &Ray<R>, conditioning: Conditioning, extent: f64) -> Self {
        let origin = ray.origin.to_dvec3();
        let size = ray.origin.max_norm().to_f64();
        // Along an axis that it is parallel to, the ray is inside or far outside.
        let inverse = ray.dir.to_dvec3().recip().map(|x| x.clamp(-f64::MAX, f64::MAX));
        let of_longest = inverse.abs().min_element();
        let error = conditioning.error(size) + spread(ray, (extent + size) * of_longest);
        // Twice the bound: `error` and this product are rounded themselves.
        Line {
            above: (origin + error).to_array(),
            below: (origin - error).to_array(),
            inverse: inverse.to_array(),
            tolerance: 2.0 * error * of_longest,
        }
    }

    /// Up to where crossings matter to one, `t` and how far off that may be apart: they may tie with
    /// others that tie with it, each by the tolerances of two.
    #[inline(always)]
    pub(crate) fn end_of_ties<R: Real>(&self, t: R) -> f64 {
        t.to_f64() + 4.0 * self.tolerance_at(t) + t.radius()
    }

    /// The tolerance of any crossing at `t`, at most.
    #[inline(always)]
    fn tolerance_at<R: Real>(&self, t: R) -> f64 {
        self.tolerance + TIE_ROUNDINGS * f64::UNIT_ROUNDOFF * t.to_f64().abs()
    }

    /// The `t` at which the ray enters each box, 0 if it starts inside; and, by bit, which it meets
    /// before `t_end`.
    #[inline(always)]
    pub(crate) fn enters<const N: usize>(&self, boxes: &Boxes<N>, t_end: f64) -> ([f64; N], u32) {
        let (mut enter, mut exit) = ([0.0; N], [t_end; N]);
        // Comparisons, unlike `f64::min`, are one instruction each for all boxes. NaN, which a box
        // has at both ends, leaves an interval alone.
        for axis in 0..3 {
            let (lo, hi) = (&boxes.lo[axis], &boxes.hi[axis]);
            for k in 0..N {
                let low = (f64::from(lo[k]) - self.above[axis]) * self.inverse[axis];
                let high = (f64::from(hi[k]) - self.below[axis]) * self.inverse[axis];
                let near = if low < high { low } else { high };
                let far = if low > high { low } else { high };
                enter[k] = if near > enter[k] { near } else { enter[k] };
                exit[k] = if far < exit[k] { far } else { exit[k] };
            }
        }
        let mut met = 0;
        for k in 0..N {
            met |= u32::from(enter[k] <= exit[k] * WIDER) << k;
        }
        (enter, met)
    }
}

/// Lines from one origin, as those through a rectangle of the image plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beam {
    /// The greatest `above` and the least `below` of its lines.
    above: [f64; 3],
    below: [f64; 3],
    /// The least and the greatest of 1 over the direction, anything where that may have both signs.
    inverse: [[f64; 3]; 2],
}

impl Beam {
    /// All lines whose directions are between these, each component on its own.
    pub(crate) fn between(corners: &[Line; 4]) -> Beam {
        let of = |get: fn(&Line) -> [f64; 3], axis: usize, choose: fn(f64, f64) -> f64| {
            corners.iter().map(|line| get(line)[axis]).reduce(choose).unwrap_or(f64::NAN)
        };
        let mut beam = Beam { above: [0.0; 3], below: [0.0; 3], inverse: [[0.0; 3]; 2] };
        for axis in 0..3 {
            let above = of(|line| line.above, axis, f64::max);
            let below = of(|line| line.below, axis, f64::min);
            // The directions of balls between them may be a little less certain, which widens origins;
            // [`Beam::holds`] tells.
            (beam.above[axis], beam.below[axis]) =
                (above + (above - below), below - (above - below));
            let least = of(|line| line.inverse, axis, f64::min);
            let greatest = of(|line| line.inverse, axis, f64::max);
            let has_sign = least.is_sign_negative() == greatest.is_sign_negative();
            let range = if has_sign { [least, greatest] } else { [-f64::MAX, f64::MAX] };
            [beam.inverse[0][axis], beam.inverse[1][axis]] = range;
        }
        beam
    }

    /// Whether it holds a line.
    #[inline(always)]
    pub(crate) fn holds(&self, line: &Line) -> bool {
        (0..3).all(|axis| {
            let range = self.inverse[0][axis]..=self.inverse[1][axis];
            line.above[axis] <= self.above[axis]
                && line.below[axis] >= self.below[axis]
                && range.contains(&line.inverse[axis])
        })
    }

    /// Which boxes any of its lines may meet, by bit. What [`Line::enters`] computes is done with
    /// intervals, the product of two of which lies between the products of their ends: rounding keeps the
    /// order of numbers, so none that a line meets is missed.
    pub(crate) fn meets<const N: usize>(&self, boxes: &Boxes<N>) -> u32 {
        let [least, greatest] = &self.inverse;
        let (mut enter, mut exit) = ([0.0; N], [f64::INFINITY; N]);
        for axis in 0..3 {
            for k in 0..N {
                let low = f64::from(boxes.lo[axis][k]) - self.above[axis];
                let high = f64::from(boxes.hi[axis][k]) - self.below[axis];
                let [a, b] = [low * least[axis], low * greatest[axis]];
                let [c, d] = [high * least[axis], high * greatest[axis]];
                // NaN leaves an interval alone.
                enter[k] = a.min(b).min(c.min(d)).max(enter[k]);
                exit[k] = a.max(b).max(c.max(d)).min(exit[k]);
            }
        }
        (0..N).filter(|&k| enter[k] <= exit[k] * WIDER).fold(0, |met, k| met | 1 << k)
    }
}

/// Boxes side by side, with sides along the axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boxes<const N: usize> {
    /// Lower ends, by axis.
    pub(crate) lo: [[f32; N]; 3],
    /// Upper ends, by axis.
    pub(crate) hi: [[f32; N]; 3],
}

/// How far the rays that a ray of balls may stand for are from one another, up to `t_end`.
#[inline(always)]
fn spread<R: Real>(ray: &Ray<R>, t_end: f64) -> f64 {
    // Sums, unlike maxima, keep NaN, with which the ray meets all boxes.
    let radius = |v: Vec3<R>| v.x.radius() + v.y.radius() + v.z.radius();
    let (of_origin, of_dir) = (radius(ray.origin), radius(ray.dir));
    if of_origin == 0.0 && of_dir == 0.0 {
        return 0.0;
    }
    // Twice, since `t_end` and the sum are rounded.
    2.0 * (of_origin + of_dir * t_end)
}

/// A ray, and how it is tested against boxes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach<R> {
    pub(crate) ray: Ray<R>,
    pub(crate) line: Line,
}

impl<R: Real> Reach<R> {
    /// Whether a crossing at `t` lies ahead of the origin by more than its tolerance, whatever that
    /// is; none where it makes a difference.
    #[inline(always)]
    pub(crate) fn is_plainly_ahead(&self, t: R) -> Option<bool> {
        if t.is_surely_zero() || (-t).is_surely_positive() {
            return Some(false);
        }
        let is_ahead = t.to_f64() == f64::INFINITY || self.is_plainly_beyond(t, t);
        is_ahead.then_some(true)
    }

    /// Whether a distance from a crossing at `t` is above its tolerance, whatever that is.
    #[inline(always)]
    pub(crate) fn is_plainly_beyond(&self, distance: R, t: R) -> bool {
        // Twice the bound: the tolerance is rounded too.
        distance.to_f64() - distance.radius() > 2.0 * self.line.tolerance_at(t)
    }
}
