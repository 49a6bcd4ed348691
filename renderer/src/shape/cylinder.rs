//! `x² + z² <= 1`, `0 <= y <= 1`; face 0 is the side, 1 the top, 2 the bottom.

use crate::numeric::real::Real;
use crate::shape::quadric::Quadratic;
use crate::shape::{Form, LocalRay, Span, slab};

const SIGNS: [f64; 3] = [1.0, 0.0, 1.0];

pub(crate) const FORMS: [Form; 3] = [
    Form::Quadric { signs: SIGNS, k: 1.0 },
    Form::Plane { axis: 1, offset: 1.0 },
    Form::Plane { axis: 1, offset: 0.0 },
];

pub(crate) fn span<R: Real>(ray: &LocalRay<R>) -> Option<Span<R>> {
    side(ray)?.and(slab::between(ray, 1, [2, 1])?)
}

/// Where the line is within the cylinder without ends.
fn side<R: Real>(ray: &LocalRay<R>) -> Option<Span<R>> {
    let (d, m) = (ray.dir, ray.moment);
    let a = d.x.mul_add(d.x, d.z * d.z);
    let quadratic = Quadratic::new(ray, SIGNS, 1.0, a, (-m.y).mul_add(m.y, a));
    if a == R::ZERO {
        return (quadratic.c < R::ZERO).then(Span::line);
    }
    if quadratic.discriminant > R::ZERO {
        let [enter, exit] = quadratic.roots();
        return Some(Span { enter, exit });
    }
    None
}
