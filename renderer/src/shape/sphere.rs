//! `x² + y² + z² <= 1`; face 0.

use crate::numeric::real::Real;
use crate::shape::quadric::Quadratic;
use crate::shape::{Form, LocalRay, Span};

const SIGNS: [f64; 3] = [1.0, 1.0, 1.0];

pub(crate) const FORMS: [Form; 1] = [Form::Quadric { signs: SIGNS, k: 1.0 }];

#[inline(always)]
pub(crate) fn span<R: Real>(ray: &LocalRay<R>) -> Option<Span<R>> {
    let a = ray.dir.dot(ray.dir);
    let discriminant = a - ray.moment.dot(ray.moment);
    let quadratic = Quadratic::new(ray, SIGNS, 1.0, a, discriminant);
    // A tangent line has nothing of the sphere.
    if quadratic.discriminant > R::ZERO {
        let [enter, exit] = quadratic.roots();
        return Some(Span { enter, exit });
    }
    None
}
