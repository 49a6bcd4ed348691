//! Measuring how well lines that come from far away meet a sphere.

use std::convert::Infallible;
use std::hint::black_box;

use renderer::line::enters_sphere;
use renderer::numeric::ball::Ball;
use renderer::numeric::dd::Dd;
use renderer::numeric::real::Real;
use renderer::numeric::vec3::Vec3;

use crate::chart::data::Outcome;
use crate::chart::measure::Bench;
use crate::chart::study::data::{Curve, Form, Item, Panel};
use crate::chart::study::kernels::{kahan, moment, passes, perpendicular, textbook};
use crate::chart::study::sets::Kind;
use crate::failure::Failure;
use crate::measure::machine::thread_time;
use crate::measure::rounds::Rounds;

/// Lines at each distance.
const N_LINES: usize = 4000;

/// How often all lines are intersected in a round.
const SWEEPS: u32 = 10;

/// How far away lines begin, in radii: ten times this, and so on.
const N_DISTANCES: i32 = 8;

/// How far lines pass from the centre at most, in radii.
const REACH: f64 = 1.05;

/// A line: origin and direction.
type Line = [[f64; 3]; 2];

/// The exact truth about a line: whether, and where, it enters the sphere.
type Truth = Option<[Ball<Dd>; 3]>;

/// A way to intersect, with lines at each distance.
struct Contender {
    name: &'static str,
    /// The point where the line with this number enters, at this distance.
    enters: Box<dyn Fn(usize, usize) -> Option<[Dd; 3]>>,
    /// Intersects all lines at the least distance.
    all: Box<dyn Fn()>,
    /// Seconds for one of them, by round.
    times: Vec<f64>,
}

/// A way in the numbers that it computes in.
fn contender<F: Copy + 'static>(
    name: &'static str,
    lines: &[Vec<Line>],
    of: impl Fn(f64) -> F,
    dd: impl Fn(F) -> Dd + 'static,
    enters: impl Fn([F; 3], [F; 3]) -> Option<[F; 3]> + Copy + 'static,
) -> Contender {
    let line = |line: &Line| line.map(|vector| vector.map(&of));
    let lines: Vec<Vec<[[F; 3]; 2]>> =
        lines.iter().map(|lines| lines.iter().map(line).collect()).collect();
    let nearest = lines[0].clone();
    Contender {
        name,
        enters: Box::new(move |distance, index| {
            let [origin, dir] = lines[distance][index];
            enters(origin, dir).map(|point| point.map(&dd))
        }),
        all: Box::new(move || {
            for [origin, dir] in &nearest {
                black_box(enters(*origin, *dir));
            }
        }),
        times: Vec::new(),
    }
}

fn contenders(lines: &[Vec<Line>]) -> Vec<Contender> {
    let (single, from_single) = (|x: f64| x as f32, |x: f32| Dd::from(f64::from(x)));
    let (double, from_double) = (|x: f64| x, Dd::from);
    vec![
        contender("textbook-f32", lines, single, from_single, textbook),
        contender("perpendicular-f32", lines, single, from_single, perpendicular),
        contender("moment-f32", lines, single, from_single, moment),
        contender("textbook-f64", lines, double, from_double, textbook),
        contender("kahan-f64", lines, double, from_double, kahan),
        contender("perpendicular-f64", lines, double, from_double, perpendicular),
        contender("gmlvm-f64", lines, double, from_double, ours::<f64>),
        contender("gmlvm-dd", lines, Dd::from, |x: Dd| x, ours::<Dd>),
    ]
}

/// The tracer's.
fn ours<R: Real>(origin: [R; 3], dir: [R; 3]) -> Option<[R; 3]> {
    let vector = |[x, y, z]: [R; 3]| Vec3::new(x, y, z);
    enters_sphere(vector(origin), vector(dir)).map(Vec3::into)
}

/// Measures all ways at all distances.
///
/// # Errors
/// None, as other sets may have.
pub(super) fn measure(bench: Bench<'_>) -> Result<Vec<Panel>, Failure> {
    let lines: Vec<Vec<Line>> = (1..=N_DISTANCES).map(|n| lines(10_f64.powi(n))).collect();
    let mut contenders = contenders(&lines);
    let rounds = Rounds::new(bench.args.warmup, bench.args.runs, None);
    let done: Result<(), Infallible> = rounds.each(contenders.len(), |index, counts| {
        let contender = &mut contenders[index];
        let start = thread_time();
        (0..SWEEPS).for_each(|_| (contender.all)());
        let n = f64::from(SWEEPS) * N_LINES as f64;
        let time = (thread_time() - start).as_secs_f64() / n;
        if counts {
            contender.times.push(time);
        }
        Ok(())
    });
    let Ok(()) = done;
    let truths: Vec<Vec<Option<Truth>>> =
        lines.iter().map(|lines| lines.iter().map(truth).collect()).collect();
    let figures: Vec<_> = contenders.iter().map(|c| errors(c, &truths)).collect();
    let panel = |kind: Kind, which: usize| {
        let item = |(contender, figures): (&Contender, &[Curve; 2])| Item {
            name: contender.name.to_owned(),
            outcome: Outcome::Rendered(figures[which].clone()),
        };
        let items = contenders.iter().zip(&figures).map(item).collect();
        let form = Form::Curves { items };
        Panel { kind, scene: String::new(), form, about: bench.about.clone() }
    };
    Ok(vec![panel(Kind::Misses, 0), panel(Kind::Points, 1)])
}

/// What a way gets wrong: the share of lines, and the largest error of points.
fn errors(contender: &Contender, truths: &[Vec<Option<Truth>>]) -> [Curve; 2] {
    let mut curves =
        [contender.times.clone(), Vec::new()].map(|times| Curve { points: vec![], times });
    for (distance, truths) in truths.iter().enumerate() {
        let (mut n_wrong, mut n_known, mut n_met, mut largest) = (0, 0, 0, 0.0_f64);
        for (index, truth) in truths.iter().enumerate() {
            let Some(truth) = truth else { continue };
            n_known += 1;
            match ((contender.enters)(distance, index), truth) {
                (Some(point), Some(exact)) => {
                    n_met += 1;
                    largest = largest.max(off(point, *exact));
                }
                (None, None) => {}
                _ => n_wrong += 1,
            }
        }
        let at = 10_f64.powi(distance as i32 + 1);
        curves[0].points.push([at, f64::from(n_wrong) / f64::from(n_known)]);
        // Of a way that finds no point, none is off.
        if n_met > 0 {
            curves[1].points.push([at, largest]);
        }
    }
    curves
}

/// How far a point is from where it should be, at most.
fn off(point: [Dd; 3], exact: [Ball<Dd>; 3]) -> f64 {
    let squares = [0, 1, 2].map(|axis| {
        let off = exact[axis] - Ball::from_dd(point[axis]);
        (off.to_f64().abs() + off.radius()).powi(2)
    });
    squares.iter().sum::<f64>().sqrt()
}

/// The truth about a line, by balls of double-double, of which the textbook's formula says whether it is a
/// hit and the tracer's where; none if they cannot tell.
fn truth(line: &Line) -> Option<Truth> {
    let [o, d] = line.map(Vec3::<Ball<Dd>>::from_f64s);
    let (a, b) = (d.dot(d), o.dot(d));
    let discriminant = b * b - a * (o.dot(o) - Real::ONE);
    let is_hit = discriminant > Real::ZERO;
    if Ball::<Dd>::take_doubt() {
        return None;
    }
    let point = is_hit.then(|| enters_sphere(o, d).map(Vec3::into));
    let has_doubt = Ball::<Dd>::take_doubt();
    match point {
        None => Some(None),
        Some(point) => point.filter(|_| !has_doubt).map(Some),
    }
}

/// Lines from this far away, in all directions, spread over the sphere as it is seen from there. All
/// numbers are exact in single precision, so that no way has to round them first.
fn lines(distance: f64) -> Vec<Line> {
    let mut state = distance.to_bits();
    // From -1 to 1.
    let mut random = || {
        // Steele, Lea and Flood, "Fast splittable pseudorandom number generators" (2014).
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        2.0 * ((z ^ z >> 31) as f64 / u64::MAX as f64) - 1.0
    };
    let single = |x: f64| f64::from(x as f32);
    let mut lines = Vec::new();
    while lines.len() < N_LINES {
        let [away, to, length] = [0; 3].map(|_| [0; 3].map(|_| random()));
        let size = away.iter().map(|x| x * x).sum::<f64>().sqrt();
        let origin = away.map(|x| single(distance * x / size));
        // Single precision has few directions, but of all lengths together enough that come near.
        let length = 1.5 + 0.5 * length[0];
        let dir =
            [0, 1, 2].map(|axis| single((REACH * to[axis] - origin[axis]) * length / distance));
        if size <= 1.0 && passes(origin, dir) <= REACH {
            lines.push([origin, dir]);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A way that is wrong is seen to be.
    #[test]
    fn errors_are_those_of_the_way() {
        let lines = vec![lines(10.0)];
        let truths: Vec<Vec<_>> = vec![lines[0].iter().map(truth).collect()];
        let n_known = truths[0].iter().flatten().count();
        assert!(n_known > N_LINES * 99 / 100, "{n_known}");
        let n_hits = truths[0].iter().flatten().filter(|truth| truth.is_some()).count();
        assert!(N_LINES / 2 < n_hits && n_hits < n_known, "{n_hits}");
        let of = |enters: fn([f64; 3], [f64; 3]) -> Option<[f64; 3]>| {
            let [wrong, off] = errors(&contender("", &lines, |x| x, Dd::from, enters), &truths);
            [wrong.points[0][1], off.points[0][1]]
        };
        let none = errors(&contender("", &lines, |x| x, Dd::from, |_: [f64; 3], _| None), &truths);
        assert_eq!(none[0].points, [[10.0, n_hits as f64 / n_known as f64]]);
        assert!(none[1].points.is_empty());
        let [wrong, off] = of(|o, d| moment(o, d).map(|[x, y, z]| [x, y, z + 0.25]));
        assert!(wrong == 0.0 && (off - 0.25).abs() < 1e-9, "{wrong} {off}");
        let [wrong, off] = of(moment);
        // The discriminant errs by four roundings, and its root by half of that over itself, which is a
        // fiftieth where a line is as near to a tangent as one in four thousand is.
        let bound = 4.0 / 2.0 * 50.0 * f64::EPSILON / 2.0;
        assert!(wrong == 0.0 && off < bound, "{wrong} {off}");
    }
}
