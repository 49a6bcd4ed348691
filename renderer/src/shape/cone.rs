//! `x² + z² <= y²`, `0 <= y <= 1`; face 0 is the side, 1 the base at y = 1.

use crate::numeric::real::Real;
use crate::shape::quadric::{Quadratic, moment_form};
use crate::shape::{Form, LocalRay, Span, slab};

const SIGNS: [f64; 3] = [1.0, -1.0, 1.0];

pub(crate) const FORMS: [Form; 2] =
    [Form::Quadric { signs: SIGNS, k: 0.0 }, Form::Plane { axis: 1, offset: 1.0 }];

pub(crate) fn span<R: Real>(ray: &LocalRay<R>) -> Option<Span<R>> {
    side(ray)?.and(slab::below(ray, 1, R::ONE, 1)?)
}

/// Where the line is within the upper half of the double cone, which is convex.
fn side<R: Real>(ray: &LocalRay<R>) -> Option<Span<R>> {
    let (d, m) = (ray.dir, ray.moment);
    let a = R::signed_squares(SIGNS, [d.x, d.y, d.z], 0.0);
    let quadratic = Quadratic::new(ray, SIGNS, 0.0, a, -moment_form(SIGNS, m));
    if a > R::ZERO {
        // A flat line: inside between its roots, if it passes the upper half. The midpoint of the
        // roots is ((Jd) × m) / a.
        let is_above = R::difference_of_products(d.z, m.x, d.x, m.z) > R::ZERO;
        if !is_above || quadratic.discriminant <= R::ZERO {
            return None;
        }
        let [enter, exit] = quadratic.roots();
        return Some(Span { enter, exit });
    }
    steep(ray, &quadratic)
}

/// A line at least as steep as the generators enters the upper half and stays, or comes from it.
fn steep<R: Real>(ray: &LocalRay<R>, quadratic: &Quadratic<R>) -> Option<Span<R>> {
    let mut roots = quadratic.roots();
    let upward = ray.dir.y > R::ZERO;
    if quadratic.a == R::ZERO {
        // Parallel to a generator: inside on one side of its one root. It is the upper half that
        // it is in there if it goes up into it or comes down from it.
        if quadratic.b == R::ZERO || (quadratic.b > R::ZERO) != upward {
            return None;
        }
        let finite = roots[usize::from(quadratic.b < R::ZERO)];
        roots = [finite, finite];
    } else if quadratic.b == R::ZERO && quadratic.discriminant <= R::ZERO {
        // Through the apex, which is the origin: both roots are 0.
        roots.iter_mut().for_each(|root| root.t = R::ZERO);
    }
    let by_t = if roots[0].t <= roots[1].t { roots } else { [roots[1], roots[0]] };
    Some(if upward {
        Span { enter: by_t[1], ..Span::line() }
    } else {
        Span { exit: by_t[0], ..Span::line() }
    })
}
