//! Placements against the matrices of their transforms, and what exact arithmetic says of them.

use super::*;

fn placed(ops: &[TransformOp]) -> Placement {
    // What is applied first is innermost.
    let mut turns = Turns::default();
    let place = |outer: Placement, &op| outer.of_transformed(op, &mut turns);
    ops.iter().rev().fold(Placement::identity(), place)
}

/// The map that does `first`, then `then`, by all products of their entries.
fn after(then: &Bounded, first: &Bounded) -> Bounded {
    let mut map = then.clone();
    map.multiply_norm(first.norm, first.norm_error);
    for row in 0..3 {
        for column in 0..4 {
            let mut sum = Sum::default();
            for k in 0..3 {
                sum.add_product(then.at(row, k), first.at(k, column));
            }
            if column == 3 {
                map.set_shift(row, &sum.and(then.at(row, 3)));
            } else {
                map.set(row, column, &sum);
            }
        }
    }
    map
}

/// The whole matrices of an operator and of its inverse.
fn maps_of(op: TransformOp) -> [Bounded; 2] {
    let diagonal = |factors: [Dd; 3], relative_error: f64| {
        let mut map = Bounded::identity();
        for (axis, factor) in factors.into_iter().enumerate() {
            map.entries[axis][axis] = factor;
            map.errors[axis][axis] = Entry::off_by(factor, relative_error).error;
        }
        map.norm = largest(factors);
        map.norm_error = error_of(map.norm, relative_error);
        map
    };
    let turns = |angle, i: usize, j: usize| {
        let (sin, cos) = Dd::sin_cos_degrees(angle);
        let relative_error = if angle == 90.0 { 0.0 } else { DD_ERROR };
        [sin, -sin].map(|sin| {
            let mut map = diagonal([Dd::ONE; 3], 0.0);
            for (row, column, value) in [(i, i, cos), (j, j, cos), (i, j, -sin), (j, i, sin)] {
                let Entry { value, error } = Entry::off_by(value, relative_error);
                (map.entries[row][column], map.errors[row][column]) = (value, error);
            }
            map.norm_error = 2.0 * relative_error;
            map
        })
    };
    match op {
        TransformOp::Translate(by) => [by, -by].map(|by| {
            let mut map = diagonal([Dd::ONE; 3], 0.0);
            for row in 0..3 {
                map.entries[row][3] = Dd::from(by[row]);
            }
            map
        }),
        TransformOp::Scale(by) => {
            let factors = by.to_array().map(Dd::from);
            [diagonal(factors, 0.0), diagonal(factors.map(|s| Dd::ONE / s), DD_ERROR)]
        }
        TransformOp::RotateX(angle) => turns(angle, 1, 2),
        TransformOp::RotateY(angle) => turns(angle, 2, 0),
        TransformOp::RotateZ(angle) => turns(angle, 0, 1),
    }
}

#[test]
fn operators_compose_like_their_matrices() {
    let ops = [
        TransformOp::Translate(DVec3::new(0.1, -1e7, 0.0)),
        TransformOp::RotateX(33.0),
        TransformOp::Scale(DVec3::new(0.3, 1.0, -7.0)),
        TransformOp::RotateY(-101.5),
        TransformOp::Translate(DVec3::new(0.0, 2.5, 1e-3)),
        TransformOp::RotateZ(90.0),
        TransformOp::Scale(DVec3::splat(1.0 / 3.0)),
        TransformOp::RotateZ(17.0),
    ];
    let mut turns = Turns::default();
    for start in 0..ops.len() {
        let mut placement = Placement::identity();
        for op in ops.iter().cycle().skip(start).step_by(3).take(12) {
            let [forward, inverse] = maps_of(*op);
            let expected = Placement {
                world_from_object: after(&placement.world_from_object, &forward),
                object_from_world: after(&inverse, &placement.object_from_world),
            };
            placement = placement.of_transformed(*op, &mut turns);
            assert_eq!(placement, expected, "{op:?}");
        }
    }
}

#[test]
fn full_turns_are_the_identity() {
    let identity: Affine<f64> = Placement::identity().world_from_object.rounded();
    for (angle, times) in [(90.0, 4), (1.0, 360), (10.0, 36), (120.0, 3), (45.0, 8)] {
        for op in
            [TransformOp::RotateX(angle), TransformOp::RotateY(angle), TransformOp::RotateZ(angle)]
        {
            let placement = placed(&vec![op; times]);
            assert_eq!(placement.world_from_object.rounded::<f64>(), identity, "{op:?}");
            assert_eq!(placement.object_from_world.rounded::<f64>(), identity, "{op:?}");
        }
    }
}

#[test]
fn there_and_back_is_the_identity() {
    let far = DVec3::new(1e7, 0.0, 0.0);
    let ops = [
        TransformOp::Translate(far),
        TransformOp::RotateY(30.0),
        TransformOp::Scale(DVec3::new(3.0, 7.0, -0.1)),
        TransformOp::Scale(DVec3::new(1.0 / 4.0, 1.0, 1.0)),
        TransformOp::Scale(DVec3::new(4.0, 1.0, 1.0)),
    ];
    let placement = placed(&ops);
    let there = placement.world_from_object.rounded::<f64>();
    let back = placement.object_from_world.rounded::<f64>();
    for p in [Vec3::new(1.0, 2.0, 3.0), Vec3::new(-0.3, 0.7, 1e3)] {
        let q = back.point(there.point(p));
        // Both shifts, of at most 3e7, are rounded to doubles.
        assert!((q - p).max_norm() <= 3e7 * f64::EPSILON, "{q:?}");
    }
    let undone = placed(&[
        TransformOp::Translate(far),
        TransformOp::RotateY(30.0),
        TransformOp::RotateY(-30.0),
        TransformOp::Translate(-far),
    ]);
    assert_eq!(
        undone.world_from_object.rounded::<f64>(),
        Placement::identity().world_from_object.rounded()
    );
}

#[test]
fn extreme_factors_keep_their_small_entries() {
    let placement =
        placed(&[TransformOp::Scale(DVec3::new(1e40, 1.0, 1e-40)), TransformOp::RotateX(30.0)]);
    let map = placement.world_from_object.rounded::<f64>();
    assert_eq!(map.rows[0].x, 1e40);
    assert!((map.rows[1].y - 0.75f64.sqrt()).abs() < 1e-15 && map.rows[2].y == 0.5);
    assert_eq!(map.rows[1].z, -0.5 * 1e-40);
}

#[test]
fn tiny_turns_keep_their_sines() {
    for angle in [-1e-25, 1e-35, -1e-200] {
        let map = placed(&[TransformOp::RotateX(angle)]).object_from_world.rounded::<f64>();
        let sine = angle.to_radians();
        assert!((map.rows[1].z - sine).abs() <= 4.0 * f64::EPSILON * sine.abs(), "{angle}");
        assert_eq!(map.rows[2].y, -map.rows[1].z);
    }
}

#[test]
fn bounds_hold_what_falls_below_the_range_of_doubles() {
    // The product of these factors is 13 exactly.
    let factors = [8.706_007_433_388_422e300, 1.493_221_789_605_150_2e-300];
    let [there, back] = factors.map(|factor| TransformOp::Scale(DVec3::splat(factor)));
    let inverse = placed(&[there, back]).object_from_world;
    let (expected, entry) = (Dd::ONE / Dd::from(13.0), inverse.at(0, 0));
    let off = (entry.value - expected).abs().to_f64();
    assert!(off > DD_ERROR, "{off:e}");
    assert!(off <= entry.error, "{off:e} {:e}", entry.error);
    // A sine that is below the least of doubles is not 0.
    let tiny = TransformOp::RotateX(1e-320);
    let far = TransformOp::Scale(DVec3::splat(1e-300));
    let sine = placed(&[tiny, far]).world_from_object.at(2, 1);
    assert!(sine.value == Dd::ZERO && sine.error > 0.0, "{sine:?}");
}

#[test]
fn rotations_turn_the_way_the_reference_says() {
    let image = |op, p: [f64; 3]| {
        let q = placed(&[op]).world_from_object.rounded::<f64>().point(Vec3::new(p[0], p[1], p[2]));
        [q.x, q.y, q.z]
    };
    assert_eq!(image(TransformOp::RotateX(90.0), [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
    assert_eq!(image(TransformOp::RotateY(90.0), [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
    assert_eq!(image(TransformOp::RotateZ(90.0), [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
}
