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
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Placement {
    pub(crate) world_from_object: Bounded,
    pub(crate) object_from_world: Bounded,
}

/// A map, and how far each of its entries may be off.
#[derive(Clone, Debug, PartialEq)]
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
        Placement { world_from_object: Bounded::identity(), object_from_world: Bounded::identity() }
    }

    /// The placement of what is inside an object that is transformed by `op` and then placed here.
    pub(crate) fn of_transformed(&self, op: TransformOp, turns: &mut Turns) -> Self {
        let mut inside = self.clone();
        inside.transform(op, turns);
        inside
    }

    /// Becomes that placement.
    pub(crate) fn transform(&mut self, op: TransformOp, turns: &mut Turns) {
        let Placement { world_from_object: outer, object_from_world: inner } = self;
        match op {
            TransformOp::Translate(by) => {
                outer.after_translation(by);
                inner.translate(-by);
            }
            TransformOp::Scale(by) => {
                let factors = [by.x, by.y, by.z].map(Dd::from);
                outer.after_scaling(factors, 0.0);
                inner.scale(factors.map(|s| Dd::ONE / s), DD_ERROR);
            }
            TransformOp::RotateX(angle) => self.rotate(turns.sin_cos(angle), [1, 2]),
            TransformOp::RotateY(angle) => self.rotate(turns.sin_cos(angle), [2, 0]),
            TransformOp::RotateZ(angle) => self.rotate(turns.sin_cos(angle), [0, 1]),
        }
    }

    /// The same for a turn by an angle from the first axis toward the second.
    fn rotate(&mut self, (sin, cos): (Dd, Dd), axes: [usize; 2]) {
        let is_exact = [sin, cos].iter().all(|x| [Dd::ZERO, Dd::ONE].contains(&x.abs()));
        let relative_error = if is_exact { 0.0 } else { DD_ERROR };
        let turn = |sin: Dd| Turn { axes, matrix: [[cos, -sin], [sin, cos]], relative_error };
        self.world_from_object.after_turn(&turn(sin));
        self.object_from_world.turn(&turn(-sin));
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

/// A rotation, but for the axis that it is around.
struct Turn {
    axes: [usize; 2],
    matrix: [[Dd; 2]; 2],
    /// Of each entry: the sine of a tiny angle is known as well as its cosine.
    relative_error: f64,
}

impl Turn {
    fn at(&self, row: usize, column: usize) -> Entry {
        Entry::off_by(self.matrix[row][column], self.relative_error)
    }

    /// The sum of products, of what there is of each side, in the order of the axes.
    #[inline(always)]
    fn sum(&self, factors: impl Fn(usize) -> (Entry, Entry)) -> Sum {
        let first = usize::from(self.axes[0] > self.axes[1]);
        let mut sum = Sum::default();
        for side in [first, 1 - first] {
            let (a, b) = factors(side);
            sum.add_product(a, b);
        }
        sum
    }

    /// Bound of the 2-norm of what the matrix, whose entries are 1 at most, may be off by.
    fn norm_error(&self) -> f64 {
        2.0 * self.relative_error
    }
}

impl Bounded {
    fn identity() -> Self {
        let mut map = Bounded {
            entries: [[Dd::ZERO; 4]; 3],
            errors: [[0.0; 4]; 3],
            norm: 1.0,
            norm_error: 0.0,
        };
        for axis in 0..3 {
            map.entries[axis][axis] = Dd::ONE;
        }
        map
    }

    /// Has the bounds that its matrix has when it is multiplied by one of this norm and with this error.
    /// Its entries stay, as those do that are multiplied by 0 and 1 alone.
    fn multiply_norm(&mut self, norm: f64, norm_error: f64) {
        let product = self.norm * norm;
        // An entry sums three products: 11 roundings of 2^-106 times at most the product of the
        // norms, and three entries a row make that a bound of the matrix, still below DD_ERROR. What falls
        // below the range of doubles is less than FLOOR in each of nine entries, and in this.
        let of_factors = self.norm_error * (norm + norm_error) + self.norm * norm_error;
        self.norm_error = of_factors + DD_ERROR * product + 4.0 * FLOOR;
        self.norm = product;
    }

    /// The same for a diagonal matrix of factors with these relative errors.
    fn multiply_norm_of(&mut self, factors: [Dd; 3], relative_error: f64) {
        let norm = largest(factors);
        self.multiply_norm(norm, error_of(norm, relative_error));
    }

    /// Sets an entry of the matrix.
    #[inline(always)]
    fn set(&mut self, row: usize, column: usize, sum: &Sum) {
        self.entries[row][column] = sum.value;
        self.errors[row][column] = sum.bound().min(self.norm_error);
    }

    /// Sets an entry of the shift.
    #[inline(always)]
    fn set_shift(&mut self, row: usize, sum: &Sum) {
        self.entries[row][3] = sum.value;
        self.errors[row][3] = sum.bound();
    }

    /// Becomes the map that moves by a vector first.
    fn after_translation(&mut self, by: DVec3) {
        self.multiply_norm(1.0, 0.0);
        for row in 0..3 {
            let mut sum = Sum::default();
            for (column, by) in by.to_array().into_iter().enumerate() {
                sum.add_product(self.at(row, column), Entry::exactly(by));
            }
            sum.add(self.at(row, 3));
            self.set_shift(row, &sum);
        }
    }

    /// Becomes the map that moves by a vector afterwards.
    fn translate(&mut self, by: DVec3) {
        self.multiply_norm(1.0, 0.0);
        for (row, by) in by.to_array().into_iter().enumerate() {
            self.set_shift(row, &Sum::of(self.at(row, 3)).and(Entry::exactly(by)));
        }
    }

    /// Becomes the map that multiplies coordinates by factors with these relative errors first.
    fn after_scaling(&mut self, factors: [Dd; 3], relative_error: f64) {
        self.multiply_norm_of(factors, relative_error);
        for row in 0..3 {
            for (column, factor) in factors.into_iter().enumerate() {
                let factor = Entry::off_by(factor, relative_error);
                self.set(row, column, &Sum::of_product(self.at(row, column), factor));
            }
        }
    }

    /// Becomes the map that multiplies coordinates by factors with these relative errors afterwards.
    fn scale(&mut self, factors: [Dd; 3], relative_error: f64) {
        self.multiply_norm_of(factors, relative_error);
        for (row, factor) in factors.into_iter().enumerate() {
            let factor = Entry::off_by(factor, relative_error);
            for column in 0..3 {
                self.set(row, column, &Sum::of_product(factor, self.at(row, column)));
            }
            let shift = Sum::of_product(factor, self.at(row, 3)).and(Entry::exactly(0.0));
            self.set_shift(row, &shift);
        }
    }

    /// Becomes the map that turns first.
    fn after_turn(&mut self, turn: &Turn) {
        self.multiply_norm(1.0, turn.norm_error());
        for row in 0..3 {
            let sums = [0, 1].map(|column| {
                turn.sum(|side| (self.at(row, turn.axes[side]), turn.at(side, column)))
            });
            for (column, sum) in turn.axes.into_iter().zip(&sums) {
                self.set(row, column, sum);
            }
        }
    }

    /// Becomes the map that turns afterwards.
    fn turn(&mut self, turn: &Turn) {
        self.multiply_norm(1.0, turn.norm_error());
        for column in 0..4 {
            let sums = [0, 1]
                .map(|row| turn.sum(|side| (turn.at(row, side), self.at(turn.axes[side], column))));
            for (row, sum) in turn.axes.into_iter().zip(sums) {
                if column < 3 {
                    self.set(row, column, &sum);
                } else {
                    self.set_shift(row, &sum.and(Entry::exactly(0.0)));
                }
            }
        }
        let around = 3 - turn.axes[0] - turn.axes[1];
        self.set_shift(around, &Sum::of(self.at(around, 3)).and(Entry::exactly(0.0)));
    }

    fn at(&self, row: usize, column: usize) -> Entry {
        Entry { value: self.entries[row][column], error: self.errors[row][column] }
    }

    /// The map in the tracer's numbers. An entry that its error bound cannot tell from 0 is 0.
    pub(crate) fn rounded<R: Real>(&self) -> Affine<R> {
        let row =
            |row: usize| Vec3::new(self.entry(row, 0), self.entry(row, 1), self.entry(row, 2));
        Affine { rows: [row(0), row(1), row(2)], shift: self.column(3) }
    }

    /// A column of that, where the last is the shift.
    #[inline]
    pub(crate) fn column<R: Real>(&self, column: usize) -> Vec3<R> {
        Vec3::new(self.entry(0, column), self.entry(1, column), self.entry(2, column))
    }

    #[inline]
    fn entry<R: Real>(&self, row: usize, column: usize) -> R {
        let Entry { value, error } = self.at(row, column);
        let is_zero = value.abs().to_f64() <= error;
        if is_zero { R::ZERO } else { R::from_bounded(value, error) }
    }
}

/// An entry of a map.
#[derive(Clone, Copy, Debug)]
struct Entry {
    value: Dd,
    error: f64,
}

/// The largest size.
fn largest(factors: [Dd; 3]) -> f64 {
    factors.iter().fold(0.0, |norm: f64, factor| norm.max(factor.abs().to_f64()))
}

/// What falls below the range of doubles in an entry, and in its bound, is less: an operation that does
/// so rounds off at most 2^-1075. A product of double-double has three of these in its value, and its
/// bound three; so a sum of three products has 18, and its bound one more. A factor or a sine comes from
/// at most four. That is 2^-1070.
const FLOOR: f64 = f64::from_bits(1 << 4);

/// That of a number of this size which has been rounded, unless its relative error is 0.
fn error_of(size: f64, relative_error: f64) -> f64 {
    relative_error * size + if relative_error > 0.0 { FLOOR } else { 0.0 }
}

impl Entry {
    fn exactly(value: f64) -> Entry {
        Entry { value: Dd::from(value), error: 0.0 }
    }

    fn off_by(value: Dd, relative_error: f64) -> Entry {
        Entry { value, error: error_of(value.abs().to_f64(), relative_error) }
    }

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
    /// That of one term.
    fn of(term: Entry) -> Sum {
        Sum::of_product(Entry::exactly(1.0), term)
    }

    fn of_product(a: Entry, b: Entry) -> Sum {
        let mut sum = Sum::default();
        sum.add_product(a, b);
        sum
    }

    /// With one more term.
    fn and(mut self, term: Entry) -> Sum {
        self.add(term);
        self
    }

    /// How far off it may be.
    fn bound(&self) -> f64 {
        self.error + if self.is_rounded { DD_ERROR * self.size + FLOOR } else { 0.0 }
    }

    #[inline(always)]
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
        let error = a.error * (b_size + b.error) + a_size * b.error;
        self.add(Entry { value: a.value * b.value, error });
    }

    #[inline(always)]
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
mod tests;
