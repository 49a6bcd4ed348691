//! Where surface functions are called: points spread evenly over the faces of solids, the same each
//! time.

use renderer::object::ShapeKind;
use renderer::surface::SurfacePoint;

/// How many points there are, for all faces together.
const N_POINTS: usize = 1024;

/// What part of the unit square a face has as its coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Domain {
    Square,
    /// The disc in it.
    Disc,
}

/// The domains of a solid's faces, by number. Of a plane, whose coordinates have no bounds, the unit
/// square has to do.
fn faces(kind: ShapeKind) -> &'static [Domain] {
    match kind {
        ShapeKind::Sphere | ShapeKind::Plane => &[Domain::Square],
        ShapeKind::Cube => &[Domain::Square; 6],
        ShapeKind::Cylinder => &[Domain::Square, Domain::Disc, Domain::Disc],
        ShapeKind::Cone => &[Domain::Square, Domain::Disc],
    }
}

/// Points on all faces of these solids, face by face in turn.
///
/// The coordinates are an additive recurrence whose steps are powers of the reciprocal of the plastic
/// number, after Martin Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences" (2018).
pub(super) fn spread(kinds: &[ShapeKind]) -> Vec<SurfacePoint> {
    const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
    let sides: Vec<(u8, Domain)> =
        kinds.iter().flat_map(|&kind| (0..).zip(faces(kind).iter().copied())).collect();
    let point = |index: usize| {
        let [u, v] = STEPS.map(|step| (0.5 + index as f64 * step).fract());
        let (face, domain) = sides[index % sides.len()];
        let [x, y] = [u, v].map(|c| 2.0 * c - 1.0);
        let is_on_it = domain == Domain::Square || x * x + y * y <= 1.0;
        is_on_it.then_some(SurfacePoint { face, u, v })
    };
    if sides.is_empty() { Vec::new() } else { (0..).filter_map(point).take(N_POINTS).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_cover_all_faces_and_lie_on_them() {
        assert!(spread(&[]).is_empty());
        let points = spread(&[ShapeKind::Cylinder, ShapeKind::Cube]);
        assert_eq!((points.len(), points[0]), (N_POINTS, SurfacePoint { face: 0, u: 0.5, v: 0.5 }));
        let caps = spread(&[ShapeKind::Cone]);
        let radius = |at: &SurfacePoint| (2.0 * at.u - 1.0).hypot(2.0 * at.v - 1.0);
        let inside = caps.iter().filter(|at| at.face == 1);
        assert!(inside.clone().count() > N_POINTS / 3);
        assert!(inside.map(radius).fold(0.0, f64::max) <= 1.0);
        for face in 0..6 {
            let on_face: Vec<_> = points.iter().filter(|at| at.face == face).collect();
            assert!(on_face.len() > N_POINTS / 12, "{face}");
            // Each quarter of the square gets its part.
            for quarter in 0..4 {
                let is_in = |at: &&&SurfacePoint| {
                    (at.u < 0.5) == (quarter % 2 == 0) && (at.v < 0.5) == (quarter < 2)
                };
                let n = on_face.iter().filter(is_in).count();
                assert!(n > on_face.len() / 6, "{face} {quarter}: {n} of {}", on_face.len());
            }
        }
        assert!(points.iter().all(|at| (0.0..1.0).contains(&at.u) && (0.0..1.0).contains(&at.v)));
    }
}
