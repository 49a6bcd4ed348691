//! Roots and hit points of `xᵀJx = k` with a diagonal `J` of signs.
//!
//! With `a = dᵀJd`, `b = -oᵀJd`, `c = oᵀJo - k` and the moment `m = o × d`, the discriminant
//! `b² - ac` equals `k a - mᵀ adj(J) m`, of which nothing cancels that is not small itself; and
//! `o (dᵀJd) - d (oᵀJd) = (Jd) × m` gives the hit point without `t`.

use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::shape::{End, LocalRay, Root};

/// The coefficients of `a t² - 2 b t + c = 0` for one line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quadratic<R> {
    pub(crate) a: R,
    pub(crate) b: R,
    pub(crate) c: R,
    /// `b² - a c`.
    pub(crate) discriminant: R,
}

impl<R: Real> Quadratic<R> {
    /// `a` and the discriminant come from the shape, which knows best how to compute them.
    #[inline(always)]
    pub(crate) fn new(ray: &LocalRay<R>, signs: [f64; 3], k: f64, a: R, discriminant: R) -> Self {
        let (o, d) = (ray.origin, ray.dir);
        let b = -o.with_signs(signs).dot(d);
        if ray.is_on(0) {
            // The origin is a root: what c differs from 0 by is rounding.
            return Quadratic { a, b, c: R::ZERO, discriminant: b * b };
        }
        Quadratic { a, b, c: R::signed_squares(signs, [o.x, o.y, o.z], k), discriminant }
    }

    /// The roots `(b - s) / a` and `(b + s) / a` of face 0, neither by subtracting what is nearly
    /// equal. One of them is infinite or NaN where `a` is 0.
    #[inline(always)]
    pub(crate) fn roots(&self) -> [End<R>; 2] {
        let s =
            if self.c.is_surely_zero() { self.b.abs() } else { self.discriminant.sqrt_or_zero() };
        let end = |t: R, plus: bool| End { t, root: Root::new(0, plus) };
        // Either form gives both roots: the sign only tells which is accurate.
        if self.b.to_f64() >= 0.0 {
            let q = self.b + s;
            [end(self.c / q, false), end(q / self.a, true)]
        } else {
            let q = self.b - s;
            [end(q / self.a, false), end(self.c / q, true)]
        }
    }
}

/// The adjugate of the diagonal matrix of `signs` where it is used: `mᵀ adj(J) m`.
#[inline(always)]
pub(crate) fn moment_form<R: Real>(signs: [f64; 3], m: Vec3<R>) -> R {
    let [x, y, z] = signs;
    R::signed_squares([y * z, z * x, x * y], [m.x, m.y, m.z], 0.0)
}

/// The point where a line crosses the quadric, at the root with this sign of the square root.
#[inline(always)]
pub(crate) fn hit_point<R: Real>(
    ray: &LocalRay<R>,
    signs: [f64; 3],
    k: f64,
    plus: bool,
) -> Vec3<R> {
    let (d, m) = (ray.dir, ray.moment);
    let a = R::signed_squares(signs, [d.x, d.y, d.z], 0.0);
    let s = (R::from_f64(k) * a - moment_form(signs, m)).sqrt_or_zero();
    let signed_s = if plus { s } else { -s };
    // Dividing by a = |d|² loses nothing, so that the other form need not be looked for.
    if R::COUNTS_ONLY_IF_CERTAIN && signs == [1.0; 3] {
        return (d.cross(m) + d * signed_s) * (R::ONE / a);
    }
    // The line's point nearest to the origin, from where nothing is far.
    let near = d.cross(m) * (R::ONE / d.dot(d));
    let b = -near.with_signs(signs).dot(d);
    // The form above divides by a, which is tiny for lines nearly parallel to a cylinder's axis or
    // a cone's generator. Counted from the near point o, the root c/q of these lines has another:
    // o q + c d = ±s o - (Jo) × m - k d. Each rounds terms of the size of its divisor's bound, |d|² and
    // |o| |d|; the second serves where its divisor is much the larger part of its bound.
    const MUCH: f64 = 16.0;
    let is_negative = b.to_f64() < 0.0;
    let is_c_over_q = plus == is_negative;
    let q = if is_negative { b - s } else { b + s };
    let size = |x: R| x.to_f64().abs();
    if is_c_over_q && MUCH * size(a) * size(near.max_norm()) < size(q) * size(d.max_norm()) {
        let from_near = near * -signed_s - near.with_signs(signs).cross(m) - d * R::from_f64(k);
        return from_near * (R::ONE / q);
    }
    (d.with_signs(signs).cross(m) + d * signed_s) * (R::ONE / a)
}
