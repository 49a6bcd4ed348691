//! Properties of the five solids, on many rays.

use super::*;
use crate::numeric::dd::Dd;

const KINDS: [ShapeKind; 5] =
    [ShapeKind::Sphere, ShapeKind::Cube, ShapeKind::Cylinder, ShapeKind::Cone, ShapeKind::Plane];

/// A sequence of numbers in [0, 1) that looks random: the upper bits of a linear congruential generator.
struct Points(u64);

impl Points {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self, size: f64) -> Vec3<f64> {
        let mut coordinate = || (2.0 * self.next() - 1.0) * size;
        Vec3::new(coordinate(), coordinate(), coordinate())
    }
}

/// How far a point is from satisfying the solid's inequalities: negative inside, 0 on the surface.
fn outside_by(kind: ShapeKind, p: Vec3<f64>) -> f64 {
    let slab = |x: f64| (-x).max(x - 1.0);
    match kind {
        ShapeKind::Sphere => p.dot(p) - 1.0,
        ShapeKind::Cube => slab(p.x).max(slab(p.y)).max(slab(p.z)),
        ShapeKind::Cylinder => (p.x * p.x + p.z * p.z - 1.0).max(slab(p.y)),
        ShapeKind::Cone => (p.x * p.x + p.z * p.z - p.y * p.y).max(slab(p.y)),
        ShapeKind::Plane => p.y,
    }
}

/// Calls `check` with many rays that start at `distance` and pass the solids closely.
fn for_rays(distance: f64, mut check: impl FnMut(ShapeKind, LocalRay<f64>)) {
    let mut points = Points(1);
    for _ in 0..20_000 {
        let target = points.vector(1.2);
        let from = points.vector(1.0).normalized().expect("not zero") * distance;
        for kind in KINDS {
            check(kind, LocalRay::new(from, target - from, 0));
        }
    }
}

#[test]
fn spans_hold_exactly_the_points_inside() {
    for_rays(3.0, |kind, ray| {
        let span = span(kind, &ray);
        for k in 0..40 {
            let t = f64::from(k) * 0.05;
            let off = outside_by(kind, ray.origin + ray.dir * t);
            let inside = span.is_some_and(|span| span.enter.t <= t && t <= span.exit.t);
            // Within rounding of the surface either answer is right.
            assert!(off.abs() < 1e-12 || inside == (off < 0.0), "{kind:?} {ray:?} {t} {off}");
        }
    });
}

#[test]
fn hit_points_lie_on_their_face_at_any_distance() {
    for distance in [3.0, 1e4, 1e8] {
        for_rays(distance, |kind, ray| {
            let Some(span) = span(kind, &ray) else { return };
            for end in [span.enter, span.exit].iter().filter(|end| end.t.is_finite()) {
                let p = hit_point(kind, &ray, end.root);
                let off = match forms(kind)[end.root.face() as usize] {
                    Form::Plane { axis, offset } => [p.x, p.y, p.z][axis] - offset,
                    Form::Quadric { signs, k } => f64::signed_squares(signs, [p.x, p.y, p.z], k),
                };
                let size = 1.0 + p.dot(p);
                assert!(off.abs() <= 1e-13 * size, "{kind:?} {end:?} {p:?} {off}");
                let shifted = outside_by(kind, p);
                assert!(
                    shifted <= 1e-13 * size || distance > 1e7,
                    "{kind:?} {end:?} {p:?} {shifted}"
                );
            }
        });
    }
}

#[test]
fn a_ray_from_a_hit_point_does_not_meet_its_face_there() {
    for_rays(3.0, |kind, ray| {
        let Some(hit) = span(kind, &ray) else { return };
        let end = hit.enter;
        if end.t.is_infinite() {
            return;
        }
        let p = hit_point(kind, &ray, end.root);
        let normal = normal(kind, end.root.face(), p);
        let back = LocalRay::new(p, -ray.dir, 1 << end.root.face());
        if -ray.dir.dot(normal) <= 0.0 {
            return;
        }
        if let Some(span) = span(kind, &back) {
            assert!(span.exit.t <= 0.0, "{kind:?} {ray:?} {span:?}");
        }
    });
}

#[test]
fn texture_coordinates_invert_table_1() {
    let circle = |u: f64| (360.0 * u).to_radians().sin_cos();
    for i in 0..40 {
        for j in 1..40 {
            let (u, v) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
            let (sin, cos) = circle(u);
            let y = 2.0 * v - 1.0;
            let r = (1.0 - y * y).sqrt();
            let cap = |y| Vec3::new(2.0 * u - 1.0, y, 2.0 * v - 1.0);
            let cases = [
                (ShapeKind::Sphere, 0, Vec3::new(r * sin, y, r * cos)),
                (ShapeKind::Cylinder, 0, Vec3::new(sin, v, cos)),
                (ShapeKind::Cylinder, 1, cap(1.0)),
                (ShapeKind::Cylinder, 2, cap(0.0)),
                (ShapeKind::Cone, 0, Vec3::new(v * sin, v, v * cos)),
                (ShapeKind::Cone, 1, cap(1.0)),
                (ShapeKind::Cube, 0, Vec3::new(u, v, 0.0)),
                (ShapeKind::Cube, 1, Vec3::new(u, v, 1.0)),
                (ShapeKind::Cube, 2, Vec3::new(0.0, v, u)),
                (ShapeKind::Cube, 3, Vec3::new(1.0, v, u)),
                (ShapeKind::Cube, 4, Vec3::new(u, 1.0, v)),
                (ShapeKind::Cube, 5, Vec3::new(u, 0.0, v)),
                (ShapeKind::Plane, 0, Vec3::new(u, 0.0, v)),
            ];
            for (kind, face, p) in cases {
                let (found_u, found_v) = (texture_u(kind, face, p), texture_v(kind, face, p));
                let off = (found_u - u).abs().min((found_u - u).abs() - 1.0).abs();
                let off = if (found_u - u).abs() > 0.5 { off } else { (found_u - u).abs() };
                assert!(
                    off < 1e-14 && (found_v - v).abs() < 1e-15,
                    "{kind:?} {face} {u} {v}: {found_u} {found_v}"
                );
            }
        }
    }
}

#[test]
fn texture_coordinates_stay_in_range_at_seams_and_poles() {
    let beyond = [-1e-17, -0.0, 0.0, 1e-17, 1.0, 1.000_000_000_000_000_2, -1.0];
    for x in beyond {
        for y in beyond {
            for z in beyond {
                for kind in
                    [ShapeKind::Sphere, ShapeKind::Cylinder, ShapeKind::Cone, ShapeKind::Cube]
                {
                    for face in 0..forms(kind).len() as u8 {
                        let p = Vec3::new(x, y, z);
                        let (u, v) = (texture_u(kind, face, p), texture_v(kind, face, p));
                        assert!(
                            (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v),
                            "{kind:?} {face} {x} {y} {z}"
                        );
                        let around = face == 0 && kind != ShapeKind::Cube;
                        assert!(!around || u < 1.0, "{kind:?} {x} {y} {z}");
                    }
                }
            }
        }
    }
}

#[test]
fn awkward_lines() {
    let line = |o: [f64; 3], d: [f64; 3]| {
        LocalRay::new(Vec3::new(o[0], o[1], o[2]), Vec3::new(d[0], d[1], d[2]), 0)
    };
    let ends = |kind, ray: LocalRay<f64>| span(kind, &ray).map(|span| (span.enter.t, span.exit.t));
    // Along the axes, from the centre and from an apex.
    assert_eq!(
        ends(ShapeKind::Cylinder, line([0.0, -1.0, 0.0], [0.0, 1.0, 0.0])),
        Some((1.0, 2.0))
    );
    assert_eq!(ends(ShapeKind::Cone, line([0.0, -1.0, 0.0], [0.0, 1.0, 0.0])), Some((1.0, 2.0)));
    assert_eq!(ends(ShapeKind::Cone, line([0.0, 0.0, 0.0], [0.0, 1.0, 0.0])), Some((0.0, 1.0)));
    assert_eq!(ends(ShapeKind::Cone, line([0.0, 2.0, 0.0], [0.0, -1.0, 0.0])), Some((1.0, 2.0)));
    assert_eq!(ends(ShapeKind::Cone, line([0.0, 0.0, 0.0], [0.6, 1.0, 0.0])), Some((0.0, 1.0)));
    // Parallel to a generator, inside and out; and a generator itself.
    assert_eq!(ends(ShapeKind::Cone, line([0.0, 1.0, 0.0], [-1.0, -1.0, 0.0])), Some((0.0, 0.5)));
    assert_eq!(ends(ShapeKind::Cone, line([3.0, 0.0, 0.0], [1.0, 1.0, 0.0])), None);
    assert_eq!(ends(ShapeKind::Cone, line([0.0, 0.0, 0.0], [1.0, 1.0, 0.0])), None);
    // In the lower half of the double cone.
    assert_eq!(ends(ShapeKind::Cone, line([-3.0, -0.5, 0.0], [1.0, 0.0, 0.0])), None);
    // Tangents miss, faces and edges of a cube count as inside only along their planes.
    assert_eq!(ends(ShapeKind::Sphere, line([-2.0, 1.0, 0.0], [1.0, 0.0, 0.0])), None);
    assert_eq!(ends(ShapeKind::Cube, line([-1.0, 0.0, 0.5], [1.0, 0.0, 0.0])), Some((1.0, 2.0)));
    assert_eq!(ends(ShapeKind::Cube, line([-1.0, -1e-17, 0.5], [1.0, 0.0, 0.0])), None);
    // Within a half-space, and beside it.
    let all = (f64::NEG_INFINITY, f64::INFINITY);
    assert_eq!(ends(ShapeKind::Plane, line([0.0, -1.0, 0.0], [1.0, 0.0, 0.0])), Some(all));
    assert_eq!(ends(ShapeKind::Plane, line([0.0, 0.0, 0.0], [1.0, 0.0, 0.0])), Some(all));
    assert_eq!(ends(ShapeKind::Plane, line([0.0, 1.0, 0.0], [1.0, 0.0, 0.0])), None);
}

#[test]
fn far_spheres_are_hit_where_geometry_says() {
    // At 1e8 radii b² - ac has no digit left, and one line in five is decided wrongly by it.
    for distance in [1e2f64, 1e5, 1e8] {
        for k in 0..1000 {
            let impact = 0.9 + f64::from(k) * 2e-4 + 1e-9;
            let ray = LocalRay::new(Vec3::new(impact, 0.0, -distance), Vec3::new(0.0, 0.0, 1.0), 0);
            assert_eq!(
                span(ShapeKind::Sphere, &ray).is_some(),
                impact < 1.0,
                "{distance} {impact}"
            );
        }
    }
}

#[test]
fn more_digits_than_a_double_has_do_not_step_over_the_seam() {
    let just_left = Vec3::new(Dd::from(-1e-25), Dd::ZERO, Dd::ONE);
    assert!(Dd::turns(just_left.x, just_left.z) < Dd::ONE);
    assert_eq!(texture_u(ShapeKind::Sphere, 0, just_left), Dd::ZERO);
}

#[test]
fn what_is_nothing_beside_its_terms_is_zero() {
    assert_eq!((settled(1e-25, 1.0), settled(-1e-25, 1.0), settled(1e-23, 1.0)), (0.0, 0.0, 1e-23));
    assert_eq!(settled(Dd::from(1e-20), 1e6), Dd::ZERO);
}
