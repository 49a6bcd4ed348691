//! Where a shape stands: its transforms, composed operator by operator in double-double together
//! with their exact inverses and a bound of the error of each entry.
//!
//! Inverting the finished matrix would lose digits that composing the inverses keeps: a shape
//! moved by 1e7, turned and moved back comes out exact to the last bit of a double. The bounds tell
//! which entries are 0 and which surfaces are the same, so that no tolerance is guessed.

use std::collections::HashMap;

use glam::DVec3;

use crate::numeric::affine::Affine;
use crate::numeric::dd::{DD_ERROR, Dd};
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::object::TransformOp;

/// The maps between object and world space.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    pub(crate) world_from_object: Bounded,
    pub(crate) object_from_world: Bounded,
}

/// A map, and how far each of its entries may be off.
#[derive(Clone, Debug)]
pub(crate) struct Bounded {
    /// Entries `[row][column]`; the last column is the shift.
    pub(crate) entries: [[Dd; 4]; 3],
    pub(crate) errors: [[f64; 4]; 3],
    /// Bounds of the 2-norm of the matrix and of its error. In long chains of rotations, which
    /// leave norms alone, these stay small where bounds by entry grow.
    norm: f64,
    norm_error: f64,
}

impl Placement {
    /// A shape in its own space.
    pub(crate) fn identity() -> Self {
        Placement {
            world_from_object: Bounded::diagonal([Dd::ONE; 3], 0.0),
            object_from_world: Bounded::diagonal([Dd::ONE; 3], 0.0),
        }
    }

    /// The placement of what is inside an object that is transformed by `op` and then placed here.
    pub(crate) fn of_transformed(&self, op: TransformOp, turns: &mut Turns) -> Self {
        let (forward, inverse) = match op {
            TransformOp::Translate(by) => (Bounded::translation(by), Bounded::translation(-by)),
            TransformOp::Scale(by) => {
                let factors = [by.x, by.y, by.z].map(Dd::from);
                (
                    Bounded::diagonal(factors, 0.0),
                    Bounded::diagonal(factors.map(|s| Dd::ONE / s), DD_ERROR),
                )
            }
            TransformOp::RotateX(angle) => rotation(turns.sin_cos(angle), 1, 2),
            TransformOp::RotateY(angle) => rotation(turns.sin_cos(angle), 2, 0),
            TransformOp::RotateZ(angle) => rotation(turns.sin_cos(angle), 0, 1),
        };
        Placement {
            world_from_object: self.world_from_object.after(&forward),
            object_from_world: inverse.after(&self.object_from_world),
        }
    }
}

/// Sines and cosines of the angles of a scene, which come again with each place of a shared solid.
#[derive(Debug, Default)]
pub(crate) struct Turns(HashMap<u64, (Dd, Dd)>);

impl Turns {
    fn sin_cos(&mut self, angle: f64) -> (Dd, Dd) {
        *self.0.entry(angle.to_bits()).or_insert_with(|| Dd::sin_cos_degrees(angle))
    }
}

/// The rotation by an angle from axis `i` toward axis `j`, and its inverse.
fn rotation((sin, cos): (Dd, Dd), i: usize, j: usize) -> (Bounded, Bounded) {
    let is_exact = [sin, cos].iter().all(|x| [Dd::ZERO, Dd::ONE].contains(&x.abs()));
    let turn = |sin: Dd| {
        let mut map = Bounded::diagonal([Dd::ONE; 3], 0.0);
        map.entries[i][i] = cos;
        map.entries[j][j] = cos;
        map.entries[i][j] = -sin;
        map.entries[j][i] = sin;
        if !is_exact {
            for (row, column) in [(i, i), (i, j), (j, i), (j, j)] {
                map.errors[row][column] = DD_ERROR;
            }
            map.norm_error = 2.0 * DD_ERROR;
        }
        map
    };
    (turn(sin), turn(-sin))
}

impl Bounded {
    fn diagonal(factors: [Dd; 3], relative_error: f64) -> Self {
        let mut map = Bounded {
            entries: [[Dd::ZERO; 4]; 3],
            errors: [[0.0; 4]; 3],
            norm: 0.0,
            norm_error: 0.0,
        };
        for (axis, factor) in factors.into_iter().enumerate() {
            let size = factor.abs().to_f64();
            map.entries[axis][axis] = factor;
            map.errors[axis][axis] = relative_error * size;
            map.norm = map.norm.max(size);
        }
        map.norm_error = relative_error * map.norm;
        map
    }

    fn translation(by: DVec3) -> Self {
        let mut map = Bounded::diagonal([Dd::ONE; 3], 0.0);
        for (row, shift) in map.entries.iter_mut().zip(by.to_array()) {
            row[3] = Dd::from(shift);
        }
        map
    }

    /// The map that does `first`, then `self`.
    fn after(&self, first: &Bounded) -> Bounded {
        let norm = self.norm * first.norm;
        // An entry sums three products: 11 roundings of 2^-106 times at most the product of the
        // norms, and three entries a row make that a bound of the matrix, still below DD_ERROR.
        let norm_error =
            self.norm_error * first.norm + self.norm * first.norm_error + DD_ERROR * norm;
        let mut result =
            Bounded { entries: [[Dd::ZERO; 4]; 3], errors: [[0.0; 4]; 3], norm, norm_error };
        for row in 0..3 {
            for column in 0..4 {
                let mut sum = Sum::default();
                for k in 0..3 {
                    sum.add_product(self.at(row, k), first.at(k, column));
                }
                if column == 3 {
                    sum.add(self.at(row, 3));
                }
                let bound = sum.error + if sum.is_rounded { DD_ERROR * sum.size } else { 0.0 };
                result.entries[row][column] = sum.value;
                result.errors[row][column] =
                    if column == 3 { bound } else { bound.min(norm_error) };
            }
        }
        result
    }

    fn at(&self, row: usize, column: usize) -> Entry {
        Entry { value: self.entries[row][column], error: self.errors[row][column] }
    }

    /// The map in the tracer's numbers. An entry that its error bound cannot tell from 0 is 0.
    pub(crate) fn rounded<R: Real>(&self) -> Affine<R> {
        let entry = |row: usize, column: usize| {
            let value = self.entries[row][column];
            let error = self.errors[row][column];
            let is_zero = value.abs().to_f64() <= error;
            if is_zero { R::ZERO } else { R::from_bounded(value, error) }
        };
        let rows = [0, 1, 2].map(|row| Vec3::new(entry(row, 0), entry(row, 1), entry(row, 2)));
        Affine { rows, shift: Vec3::new(entry(0, 3), entry(1, 3), entry(2, 3)) }
    }
}

/// An entry of a map.
#[derive(Clone, Copy)]
struct Entry {
    value: Dd,
    error: f64,
}

impl Entry {
    fn is_exactly(&self, value: Dd) -> bool {
        self.value == value && self.error == 0.0
    }
}

/// A sum of products of entries. Most transforms are of zeros and ones, which round nothing.
#[derive(Default)]
struct Sum {
    value: Dd,
    /// What the errors of the entries amount to.
    error: f64,
    /// The sum of the sizes of the terms.
    size: f64,
    is_rounded: bool,
}

impl Sum {
    fn add_product(&mut self, a: Entry, b: Entry) {
        if a.is_exactly(Dd::ZERO) || b.is_exactly(Dd::ZERO) {
            return;
        }
        if a.is_exactly(Dd::ONE) {
            return self.add(b);
        }
        if b.is_exactly(Dd::ONE) {
            return self.add(a);
        }
        let (a_size, b_size) = (a.value.abs().to_f64(), b.value.abs().to_f64());
        self.is_rounded = true;
        self.add(Entry { value: a.value * b.value, error: a.error * b_size + a_size * b.error });
    }

    fn add(&mut self, term: Entry) {
        if self.size == 0.0 {
            self.value = term.value;
        } else {
            self.value = self.value + term.value;
            self.is_rounded = true;
        }
        self.error += term.error;
        self.size += term.value.abs().to_f64();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(ops: &[TransformOp]) -> Placement {
        // What is applied first is innermost.
        let mut turns = Turns::default();
        let place = |outer: Placement, &op| outer.of_transformed(op, &mut turns);
        ops.iter().rev().fold(Placement::identity(), place)
    }

    #[test]
    fn full_turns_are_the_identity() {
        let identity: Affine<f64> = Placement::identity().world_from_object.rounded();
        for (angle, times) in [(90.0, 4), (1.0, 360), (10.0, 36), (120.0, 3), (45.0, 8)] {
            for op in [
                TransformOp::RotateX(angle),
                TransformOp::RotateY(angle),
                TransformOp::RotateZ(angle),
            ] {
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
    fn rotations_turn_the_way_the_reference_says() {
        let image = |op, p: [f64; 3]| {
            let q =
                placed(&[op]).world_from_object.rounded::<f64>().point(Vec3::new(p[0], p[1], p[2]));
            [q.x, q.y, q.z]
        };
        assert_eq!(image(TransformOp::RotateX(90.0), [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(image(TransformOp::RotateY(90.0), [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
        assert_eq!(image(TransformOp::RotateZ(90.0), [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
    }
}
