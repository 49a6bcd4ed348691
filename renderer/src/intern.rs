//! Which faces of a scene lie on the same surface.
//!
//! Two spheres that coincide, a cylinder turned about its own axis, the lid of a drill that is
//! flush with a plate: exact arithmetic says that their surfaces are equal, and rounding says that
//! they are a hair apart. So surfaces are compared where they are set up, as world-space quadrics in
//! double-double, and equal ones get one number. A plane counts as the square of its equation,
//! which has no sign that could differ.

use rayon::prelude::*;

use crate::numeric::dd::{DD_ERROR, Dd};
use crate::numeric::real::Real;
use crate::object::ShapeKind;
use crate::placement::Placement;
use crate::shape::{Form, MAX_FACES, forms};

/// The upper triangle of the symmetric 4×4 matrix of a quadric, scaled so that its quadratic part
/// has Frobenius norm 1, and how far each entry may be off.
struct Quadric<R> {
    entries: [R; 10],
    errors: [f64; 10],
    /// What an operation rounds off at most, relative to its terms.
    unit: f64,
}

/// Of doubles: an entry adds up three products of rounded numbers, and a key ten entries. In
/// double-double a key takes 35 units of 2^-106 at most, of the 64 in [`DD_ERROR`].
const DOUBLE_ERROR: f64 = 16.0 * f64::UNIT_ROUNDOFF;

/// Rows and columns of the ten entries; 3 is the constant.
const PLACES: [(usize, usize); 10] =
    [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (3, 3)];

/// The number by which faces are sorted: a sum of a surface's entries, with weights that no geometry is
/// likely to be in tune with; and how far off it may be.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FaceKey {
    sum: f64,
    error: f32,
}

/// A face by its number among all of the scene.
#[derive(Clone, Copy)]
struct Face {
    sum: f64,
    error: f32,
    number: u32,
}

const WEIGHTS: [f64; 10] = [0.731, 0.417, 0.933, 0.269, 0.577, 0.871, 0.113, 0.349, 0.653, 0.197];

/// The keys of a shape's faces.
pub(crate) fn face_keys(kind: ShapeKind, placement: &Placement) -> [FaceKey; MAX_FACES] {
    let mut keys = [FaceKey::default(); MAX_FACES];
    for (key, form) in keys.iter_mut().zip(forms(kind)) {
        let (sum, error) = Quadric::<f64>::new(*form, placement, DOUBLE_ERROR).sum();
        let single = error as f32;
        let error = if f64::from(single) < error { single.next_up() } else { single };
        *key = FaceKey { sum, error };
    }
    keys
}

/// The faces of a scene, of which doubles tell most apart.
#[derive(Default)]
pub(crate) struct Faces(Vec<Face>);

impl Faces {
    /// None yet.
    pub(crate) fn with_room_for(n_faces: usize) -> Self {
        Faces(Vec::with_capacity(n_faces))
    }

    /// Adds the faces of the next shape. Returns the number of its first.
    pub(crate) fn add(&mut self, keys: &[FaceKey]) -> u32 {
        let first = self.0.len() as u32;
        let faces = (first..).zip(keys);
        self.0.extend(faces.map(|(number, &FaceKey { sum, error })| Face { sum, error, number }));
        first
    }

    /// The faces that doubles do not tell apart from all others.
    pub(crate) fn open(&mut self) -> impl Iterator<Item = u32> {
        self.0.par_sort_unstable_by(|a, b| a.sum.total_cmp(&b.sum).then(a.number.cmp(&b.number)));
        self.runs().filter(|run| run.len() > 1).flatten().map(|face| face.number)
    }

    /// Faces by their keys, as far as they may be equal.
    fn runs(&self) -> impl Iterator<Item = &[Face]> {
        self.0.chunk_by(|a, b| b.sum - a.sum <= f64::from(a.error) + f64::from(b.error))
    }

    /// The surface of every face, and how many of the surfaces have several faces: those have the
    /// lowest numbers. Where none has, nothing is listed, and each face may be its surface's number.
    /// `placed` tells of open faces what they are and where.
    pub(crate) fn surfaces<'p>(
        self,
        placed: impl Fn(u32) -> (Form, &'p Placement),
    ) -> (Vec<u32>, u32) {
        const ALONE: u32 = u32::MAX;
        let runs = self.runs().filter(|run| run.len() > 1);
        let runs = runs.flat_map(|run| finer_runs(run, &placed));
        let classes = runs.flat_map(|run| equal(&run, &placed)).filter(|class| class.len() > 1);
        let (mut surfaces, mut n_surfaces) = (Vec::new(), 0);
        for class in classes {
            surfaces.resize(self.0.len(), ALONE);
            for face in class {
                surfaces[face as usize] = n_surfaces;
            }
            n_surfaces += 1;
        }
        let n_shared = n_surfaces;
        for surface in surfaces.iter_mut().filter(|surface| **surface == ALONE) {
            *surface = n_surfaces;
            n_surfaces += 1;
        }
        (surfaces, n_shared)
    }
}

/// Splits faces that keys in doubles do not tell apart by such keys in double-double, and leaves out those
/// that are told apart from all others. Far from the origin doubles leave all faces of a scene in one run,
/// and to compare them in pairs would take time that grows with its square.
fn finer_runs<'p>(run: &[Face], placed: impl Fn(u32) -> (Form, &'p Placement)) -> Vec<Vec<u32>> {
    if let [first, second] = run {
        return vec![vec![first.number, second.number]];
    }
    let ends = |face: &Face| {
        let (form, placement) = placed(face.number);
        let (sum, error) = Quadric::<Dd>::new(form, placement, DD_ERROR).sum();
        (sum - Dd::from(error), sum + Dd::from(error), face.number)
    };
    let mut keys: Vec<(Dd, Dd, u32)> = run.iter().map(ends).collect();
    keys.sort_unstable_by(|(a, _, first), (b, _, second)| a.total_cmp(b).then(first.cmp(second)));
    let mut reach = Dd::from(f64::NEG_INFINITY);
    let runs = keys.chunk_by(|(_, high, _), (low, _, _)| {
        reach = Real::max(reach, *high);
        *low <= reach
    });
    let runs = runs.filter(|run| run.len() > 1);
    runs.map(|run| run.iter().map(|(_, _, number)| *number).collect()).collect()
}

/// Splits faces with nearly the same key into those whose surfaces are equal.
fn equal<'p>(run: &[u32], placed: impl Fn(u32) -> (Form, &'p Placement)) -> Vec<Vec<u32>> {
    let mut found: Vec<(Quadric<Dd>, Vec<u32>)> = Vec::new();
    for &number in run {
        let (form, placement) = placed(number);
        let candidate = Quadric::<Dd>::new(form, placement, DD_ERROR);
        match found.iter_mut().find(|(first, _)| first.is_same(&candidate)) {
            Some((_, members)) => members.push(number),
            None => found.push((candidate, vec![number])),
        }
    }
    found.into_iter().map(|(_, members)| members).collect()
}

impl<R: Real> Quadric<R> {
    fn new(form: Form, placement: &Placement, unit: f64) -> Self {
        let (signs, k) = match form {
            Form::Quadric { signs, k } => (signs, k),
            Form::Plane { axis, .. } => {
                let mut signs = [0.0; 3];
                signs[axis] = 1.0;
                (signs, 0.0)
            }
        };
        let map = &placement.object_from_world;
        let mut quadric = Quadric { entries: [R::ZERO; 10], errors: [0.0; 10], unit };
        for (axis, sign) in signs.into_iter().enumerate().filter(|(_, sign)| *sign != 0.0) {
            let mut row = map.entries[axis];
            if let Form::Plane { offset, .. } = form {
                row[3] = row[3] - Dd::from(offset);
            }
            quadric.add_square(R::from_f64(sign), &row.map(R::from_dd), &map.errors[axis]);
        }
        quadric.entries[9] = quadric.entries[9] - R::from_f64(k);
        quadric.errors[9] += unit * k;
        quadric.scaled()
    }

    /// Adds `sign (row · (x, y, z, 1))²`.
    fn add_square(&mut self, sign: R, row: &[R; 4], row_errors: &[f64; 4]) {
        let sizes = row.map(|entry| entry.abs().to_f64());
        for (place, &(i, j)) in PLACES.iter().enumerate() {
            self.entries[place] = self.entries[place] + sign * row[i] * row[j];
            let (ei, ej) = (row_errors[i], row_errors[j]);
            self.errors[place] +=
                sizes[i] * ej + sizes[j] * ei + ei * ej + self.unit * sizes[i] * sizes[j];
        }
    }

    fn scaled(mut self) -> Self {
        let mut square = R::ZERO;
        for (entry, &(i, j)) in self.entries[..6].iter().zip(&PLACES) {
            let times = R::from_f64(if i == j { 1.0 } else { 2.0 });
            square = square + times * *entry * *entry;
        }
        let norm = square.sqrt_or_zero();
        let size = norm.to_f64();
        // The norm of an error is at most the sum of its entries, those off the diagonal twice.
        let norm_error = 2.0 * self.errors[..6].iter().sum::<f64>() + self.unit * size;
        let inverse = R::ONE / norm;
        for (entry, error) in self.entries.iter_mut().zip(&mut self.errors) {
            *entry = *entry * inverse;
            let scaled_size = entry.abs().to_f64();
            *error = *error / size + scaled_size * (norm_error / size + self.unit);
        }
        self
    }

    /// The sum that faces are sorted by, and how far off it may be.
    fn sum(&self) -> (R, f64) {
        let (mut sum, mut error) = (R::ZERO, 0.0);
        for ((entry, entry_error), weight) in self.entries.iter().zip(&self.errors).zip(WEIGHTS) {
            sum = sum + R::from_f64(weight) * *entry;
            error += weight * entry_error + self.unit * entry.abs().to_f64();
        }
        (sum, error)
    }

    fn is_same(&self, other: &Quadric<R>) -> bool {
        (0..10).all(|i| {
            (self.entries[i] - other.entries[i]).abs().to_f64() <= self.errors[i] + other.errors[i]
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::object::TransformOp;
    use crate::placement::Turns;

    /// The surfaces of all faces of shapes with these transforms.
    fn surfaces(shapes: &[(ShapeKind, &[TransformOp])]) -> (Vec<u32>, u32) {
        let (mut faces, mut placed) = (Faces::default(), Vec::new());
        for (kind, ops) in shapes {
            let inward = |outer: Placement, &op| outer.of_transformed(op, &mut Turns::default());
            let placement = ops.iter().rev().fold(Placement::identity(), inward);
            faces.add(&face_keys(*kind, &placement)[..forms(*kind).len()]);
            placed.extend(forms(*kind).iter().map(|form| (*form, placement.clone())));
        }
        let open: Vec<u32> = faces.open().collect();
        faces.surfaces(|face| {
            assert!(open.contains(&face), "{face} is told apart");
            let (form, placement) = &placed[face as usize];
            (*form, placement)
        })
    }

    const TILT: TransformOp = TransformOp::RotateX(33.0);
    const AWAY: TransformOp = TransformOp::Translate(DVec3::new(0.1, 0.7, 2.3));

    #[test]
    fn equal_surfaces_get_one_number() {
        let turned = [TransformOp::RotateY(17.0), TransformOp::RotateZ(41.0), AWAY];
        let (spheres, n_shared) =
            surfaces(&[(ShapeKind::Sphere, &[AWAY]), (ShapeKind::Sphere, &turned)]);
        assert_eq!((spheres, n_shared), (vec![0, 0], 1));
        let around_axis: Vec<_> =
            [TransformOp::RotateY(10.0); 36].into_iter().chain([TILT, AWAY]).collect();
        let (cylinders, n_shared) =
            surfaces(&[(ShapeKind::Cylinder, &[TILT, AWAY]), (ShapeKind::Cylinder, &around_axis)]);
        assert_eq!((&cylinders[..3], n_shared), (&cylinders[3..], 3));
    }

    #[test]
    fn faces_of_turned_cubes_pair_up() {
        let center = TransformOp::Translate(DVec3::splat(-0.5));
        let once = [center, TransformOp::RotateX(90.0), TransformOp::RotateY(90.0), TILT, AWAY];
        let (cubes, n_shared) =
            surfaces(&[(ShapeKind::Cube, &[center, TILT, AWAY]), (ShapeKind::Cube, &once)]);
        assert_eq!(n_shared, 6);
        let (first, second) = cubes.split_at(6);
        assert!(first.iter().all(|surface| second.contains(surface)));
    }

    #[test]
    fn flush_caps_and_touching_faces_are_found() {
        let drill = [TransformOp::Scale(DVec3::new(0.3, 1.0, 0.3)), TILT, AWAY];
        let beside = [TransformOp::Translate(DVec3::X), TILT, AWAY];
        let (faces, n_shared) = surfaces(&[
            (ShapeKind::Cube, &[TILT, AWAY]),
            (ShapeKind::Cylinder, &drill),
            (ShapeKind::Cube, &beside),
        ]);
        let (cube, cylinder, neighbor) = (&faces[..6], &faces[6..9], &faces[9..]);
        assert_eq!((cylinder[1], cylinder[2]), (cube[4], cube[5]));
        // The neighbour touches at x = 1, and continues the four sides around.
        assert_eq!((neighbor[2], neighbor[0], neighbor[4]), (cube[3], cube[0], cube[4]));
        assert_eq!(n_shared, 5);
    }

    #[test]
    fn far_surfaces_are_told_apart_by_keys() {
        let placement_at = |x: u32| {
            let by = DVec3::new(2.5 * f64::from(x), 0.0, 1e9);
            Placement::identity().of_transformed(TransformOp::Translate(by), &mut Turns::default())
        };
        // The last two stand in the same place.
        let placements: Vec<Placement> = (0..50).chain([49]).map(placement_at).collect();
        let mut faces = Faces::default();
        for placement in &placements {
            faces.add(&face_keys(ShapeKind::Sphere, placement)[..1]);
        }
        assert_eq!(faces.open().count(), placements.len());
        let sphere = forms(ShapeKind::Sphere)[0];
        let placed = |face: u32| (sphere, &placements[face as usize]);
        let runs: Vec<_> = faces.runs().flat_map(|run| finer_runs(run, placed)).collect();
        assert_eq!(runs, [[49, 50]]);
    }

    #[test]
    fn surfaces_a_hair_apart_stay_apart() {
        for shift in [1e-15, 1e-20, 1e-25] {
            let moved = TransformOp::Translate(DVec3::new(0.0, shift, 0.0));
            let (_, n_shared) =
                surfaces(&[(ShapeKind::Sphere, &[]), (ShapeKind::Sphere, &[moved])]);
            assert_eq!(n_shared, 0, "{shift}");
        }
        for angle in [1e-20, 1e-35] {
            let (_, n_shared) = surfaces(&[
                (ShapeKind::Plane, &[]),
                (ShapeKind::Plane, &[TransformOp::RotateX(angle)]),
            ]);
            assert_eq!(n_shared, 0, "{angle}");
        }
    }
}
