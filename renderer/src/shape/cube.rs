//! `0 <= x, y, z <= 1`; faces 0 to 5 are z = 0, z = 1, x = 0, x = 1, y = 1, y = 0.

use crate::numeric::real::Real;
use crate::shape::{Form, LocalRay, Span, slab};

pub(crate) const FORMS: [Form; 6] = [
    Form::Plane { axis: 2, offset: 0.0 },
    Form::Plane { axis: 2, offset: 1.0 },
    Form::Plane { axis: 0, offset: 0.0 },
    Form::Plane { axis: 0, offset: 1.0 },
    Form::Plane { axis: 1, offset: 1.0 },
    Form::Plane { axis: 1, offset: 0.0 },
];

#[inline(always)]
pub(crate) fn span<R: Real>(ray: &LocalRay<R>) -> Option<Span<R>> {
    let x = slab::between(ray, 0, [2, 3])?;
    let y = slab::between(ray, 1, [5, 4])?;
    let z = slab::between(ray, 2, [0, 1])?;
    x.and(y)?.and(z)
}
