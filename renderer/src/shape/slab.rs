//! Planes across an axis, and the space between two of them.

use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::shape::{End, LocalRay, Root, Span};

fn coordinate<R: Real>(v: Vec3<R>, axis: usize) -> R {
    match axis {
        0 => v.x,
        1 => v.y,
        _ => v.z,
    }
}

/// Where a ray's line crosses the plane of `face`, at `offset` on `axis`; it must not be parallel.
#[inline(always)]
fn crossing<R: Real>(ray: &LocalRay<R>, axis: usize, offset: R, face: u8) -> End<R> {
    let t = if ray.is_on(face) {
        R::ZERO
    } else {
        (offset - coordinate(ray.origin, axis)) / coordinate(ray.dir, axis)
    };
    End { t, root: Root::plane(face) }
}

/// Where a line is at most at `offset` on `axis`.
#[inline(always)]
pub(crate) fn below<R: Real>(
    ray: &LocalRay<R>,
    axis: usize,
    offset: R,
    face: u8,
) -> Option<Span<R>> {
    let dir = coordinate(ray.dir, axis);
    if dir == R::ZERO {
        let is_inside = ray.is_on(face) || coordinate(ray.origin, axis) <= offset;
        return is_inside.then(Span::line);
    }
    let end = crossing(ray, axis, offset, face);
    Some(if dir > R::ZERO {
        Span { exit: end, ..Span::line() }
    } else {
        Span { enter: end, ..Span::line() }
    })
}

/// Where a line is from 0 to 1 on `axis`; `faces` are those at 0 and at 1.
#[inline(always)]
pub(crate) fn between<R: Real>(ray: &LocalRay<R>, axis: usize, faces: [u8; 2]) -> Option<Span<R>> {
    let (origin, dir) = (coordinate(ray.origin, axis), coordinate(ray.dir, axis));
    if dir == R::ZERO {
        return (R::ZERO <= origin && origin <= R::ONE).then(Span::line);
    }
    let low = crossing(ray, axis, R::ZERO, faces[0]);
    let high = crossing(ray, axis, R::ONE, faces[1]);
    Some(if dir > R::ZERO {
        Span { enter: low, exit: high }
    } else {
        Span { enter: high, exit: low }
    })
}

/// The point where a line crosses the plane at `offset` on `axis`, from the moment: with
/// `m = o × d`, the other coordinates are `(c d_j ± m_k) / d_i`.
#[inline(always)]
pub(crate) fn hit_point<R: Real>(ray: &LocalRay<R>, axis: usize, c: R) -> Vec3<R> {
    let (d, m) = (ray.dir, ray.moment);
    match axis {
        0 => Vec3::new(c, c.mul_add(d.y, -m.z) / d.x, c.mul_add(d.z, m.y) / d.x),
        1 => Vec3::new(c.mul_add(d.x, m.z) / d.y, c, c.mul_add(d.z, -m.x) / d.y),
        _ => Vec3::new(c.mul_add(d.x, -m.y) / d.z, c.mul_add(d.y, m.x) / d.z, c),
    }
}
