//! The half-space `y <= 0`; face 0.

use crate::numeric::real::Real;
use crate::shape::{Form, LocalRay, Span, slab};

pub(crate) const FORMS: [Form; 1] = [Form::Plane { axis: 1, offset: 0.0 }];

#[inline(always)]
pub(crate) fn span<R: Real>(ray: &LocalRay<R>) -> Option<Span<R>> {
    slab::below(ray, 1, R::ZERO, 0)
}
