//! Where a line enters the unit sphere, in ways that are in use: for charts, beside the tracer's own.

use crate::stability::naive::Number;

type V<F> = [F; 3];

fn dot<F: Number>([a, b, c]: V<F>, [x, y, z]: V<F>) -> F {
    a * x + b * y + c * z
}

fn cross<F: Number>([a, b, c]: V<F>, [x, y, z]: V<F>, minor: impl Fn(F, F, F, F) -> F) -> V<F> {
    [minor(b, z, c, y), minor(c, x, a, z), minor(a, y, b, x)]
}

/// `origin + t dir`.
fn at<F: Number>(origin: V<F>, dir: V<F>, t: F) -> V<F> {
    [0, 1, 2].map(|axis| origin[axis] + t * dir[axis])
}

/// `a b - c d`, which loses nothing that cancels (Kahan).
fn difference_of_products<F: Number>(a: F, b: F, c: F, d: F) -> F {
    let cd = c * d;
    a.mul_add(b, -cd) + (-c).mul_add(d, cd)
}

/// The nearer root of `a t² + 2 b t + c = 0`, where `s` is the root of `b² - a c`: neither of the sums
/// of which one cancels.
fn nearer<F: Number>(a: F, b: F, c: F, s: F) -> F {
    if b < F::zero() { c / (s - b) } else { -(b + s) / a }
}

/// The formula of school.
pub(super) fn textbook<F: Number>(o: V<F>, d: V<F>) -> Option<V<F>> {
    let (a, b, c) = (dot(d, d), dot(o, d), dot(o, o) - F::one());
    let discriminant = b * b - a * c;
    (discriminant > F::zero()).then(|| at(o, d, (-b - discriminant.sqrt()) / a))
}

/// The same, but that neither the discriminant nor the root loses what cancels (as in pbrt, `Quadratic`).
pub(super) fn kahan<F: Number>(o: V<F>, d: V<F>) -> Option<V<F>> {
    let (a, b, c) = (dot(d, d), dot(o, d), dot(o, o) - F::one());
    let discriminant = difference_of_products(b, b, a, c);
    (discriminant > F::zero()).then(|| at(o, d, nearer(a, b, c, discriminant.sqrt())))
}

/// By the vector from the centre to the line (Haines, Günther and Akenine-Möller, "Precision improvements
/// for ray/sphere intersection", Ray Tracing Gems, 2019).
pub(super) fn perpendicular<F: Number>(o: V<F>, d: V<F>) -> Option<V<F>> {
    let (a, b, c) = (dot(d, d), dot(o, d), dot(o, o) - F::one());
    let foot = at(o, d, -b / a);
    let within = F::one() - dot(foot, foot);
    (within > F::zero()).then(|| at(o, d, nearer(a, b, c, (a * within).sqrt())))
}

/// How far a line passes from the origin.
pub(super) fn passes(o: V<f64>, d: V<f64>) -> f64 {
    let m = cross(o, d, difference_of_products);
    (dot(m, m) / dot(d, d)).sqrt()
}

/// By the line's moment `o × d`, which is how the tracer does it.
pub(super) fn moment<F: Number>(o: V<F>, d: V<F>) -> Option<V<F>> {
    let m = cross(o, d, difference_of_products);
    let a = dot(d, d);
    let discriminant = a - dot(m, m);
    let s = discriminant.max(F::zero()).sqrt();
    let foot = cross(d, m, |a, b, c, d| a * b - c * d);
    (discriminant > F::zero()).then(|| [0, 1, 2].map(|axis| (foot[axis] - s * d[axis]) / a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_find_the_same_point() {
        let all = [textbook::<f64>, kahan, perpendicular, moment];
        let (o, d) = ([-3.0, 0.5, 1.0], [2.0, 0.1, -0.6]);
        let points = all.map(|kernel| kernel(o, d).expect("a hit"));
        for point in points {
            // Some twenty roundings of terms of at most 10.
            let bound = 20.0 * 10.0 * f64::EPSILON;
            assert!((dot(point, point) - 1.0).abs() < bound, "{point:?}");
            assert!((0..3).all(|axis| (point[axis] - points[0][axis]).abs() < bound), "{points:?}");
        }
        assert!(all.iter().all(|kernel| kernel(o, [2.0, 1.5, 0.0]).is_none()));
        assert!(textbook(o.map(|x| x as f32), d.map(|x| x as f32)).is_some());
    }
}
