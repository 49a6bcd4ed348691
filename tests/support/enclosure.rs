//! What the bounds of a surface function are held against: the function itself at many points within
//! the bounds of a point.

use std::slice;
use std::sync::Arc;

use jit::shaders::{Evaluation, Shaders, Tiering};
use renderer::surface::{
    Bounded, BoundedPoint, BoundedSample, LocateBounded, Needs, SurfaceEval, SurfaceId,
    SurfacePoint, SurfaceSample,
};
use vm::machine::Limits;
use vm::program::LoadedProgram;
use vm::surfaces::InterpSurfaces;
use vm::value::Closure;

use super::agreement::load;

/// Coordinates that doubles can name within the bounds, in order; all of them if they are few.
fn doubles(within: Bounded, n: u32) -> Vec<f64> {
    let Bounded { value, error } = within;
    // A rounded distance below the error means an exact one below it; from 0 it is exact.
    let is_in = |x: &f64| {
        let distance = (x - value).abs();
        distance < error || *x == value || (value == 0.0 && distance == error)
    };
    let mut found: Vec<f64> = Vec::new();
    let mut next = value;
    for _ in 0..n / 2 {
        next = next.next_up();
        found.push(next);
    }
    next = value;
    for _ in 0..n / 2 {
        next = next.next_down();
        found.push(next);
    }
    let step = |k: u32| value + error * (2.0 * f64::from(k) / f64::from(n) - 1.0);
    found.extend((0..=n).map(step));
    found.extend([value, (value + error).next_down(), (value - error).next_up()]);
    found.retain(is_in);
    found.sort_by(f64::total_cmp);
    found.dedup();
    found
}

/// A place that tells nothing it was not asked for.
pub struct Place(pub BoundedPoint);

impl LocateBounded for Place {
    fn locate_bounded(&self, needs: Needs) -> BoundedPoint {
        let nonsense = Bounded { value: -17.5, error: f64::INFINITY };
        let BoundedPoint { face, u, v } = self.0;
        BoundedPoint {
            face: if needs.face { face } else { 99 },
            u: if needs.u { u } else { nonsense },
            v: if needs.v { v } else { nonsense },
        }
    }
}

/// The six numbers of a sample.
pub fn numbers(sample: &SurfaceSample) -> [f64; 6] {
    let SurfaceSample { color, kd, ks, phong_exp } = sample;
    [color.x, color.y, color.z, *kd, *ks, *phong_exp]
}

/// Their bounds.
pub fn bounds(sample: &BoundedSample) -> [Bounded; 6] {
    let [red, green, blue] = sample.color;
    [red, green, blue, sample.kd, sample.ks, sample.phong_exp]
}

/// What became of requests for bounds.
#[derive(Debug, Default)]
pub struct Tally {
    /// Requests where the function has an answer at the centre.
    pub asked: u64,
    /// Those that were answered.
    pub answered: u64,
    /// Calls of the function within bounds.
    pub calls: u64,
    /// Of results that vary within the bounds: the bound over the greatest distance from its centre.
    pub tightness: Vec<f64>,
}

impl Tally {
    /// The median of the bounds over what was found.
    pub fn median_tightness(&mut self) -> f64 {
        self.tightness.sort_by(f64::total_cmp);
        self.tightness.get(self.tightness.len() / 2).copied().unwrap_or(f64::NAN)
    }

    /// The part of requests that were answered.
    pub fn part_answered(&self) -> f64 {
        self.answered as f64 / self.asked as f64
    }
}

/// Asks for bounds at a point, and calls the function at `n` by `n` points and more within.
///
/// # Panics
/// If one of those has no answer, or one that is out of bounds.
pub fn check(
    bounding: &mut impl SurfaceEval,
    plain: &mut impl SurfaceEval,
    at: BoundedPoint,
    n: u32,
    context: &str,
    tally: &mut Tally,
) {
    let centre = SurfacePoint { face: at.face, u: at.u.value, v: at.v.value };
    tally.asked += u64::from(plain.eval(SurfaceId(0), &centre).is_ok());
    let Some(sample) = bounding.eval_bounded(SurfaceId(0), &Place(at)) else { return };
    tally.answered += 1;
    let bounds = bounds(&sample);
    let mut furthest = [0.0f64; 6];
    for u in doubles(at.u, n) {
        for v in doubles(at.v, n) {
            let point = SurfacePoint { face: at.face, u, v };
            tally.calls += 1;
            let Ok(sample) = plain.eval(SurfaceId(0), &point) else {
                panic!("no answer at {point:?} within {at:?}:\n{context}");
            };
            for (index, (found, Bounded { value, error })) in
                numbers(&sample).into_iter().zip(bounds).enumerate()
            {
                let distance = if found == value { 0.0 } else { (found - value).abs() };
                assert!(
                    error == f64::INFINITY || distance <= error,
                    "result {index} is {found} at {point:?}, not {value} ± {error} as in {at:?}:\n{context}"
                );
                furthest[index] = furthest[index].max(distance);
            }
        }
    }
    let varying =
        bounds.iter().zip(furthest).filter(|(bound, far)| *far > 0.0 && bound.error.is_finite());
    tally.tightness.extend(varying.map(|(bound, far)| bound.error / far));
}

/// Asks for bounds of a surface function at some points. Whether it is native code; only then the
/// requests are counted.
///
/// # Panics
/// As [`check`].
pub fn check_function(
    (program, closure): (&Arc<LoadedProgram>, &Arc<Closure>),
    limits: Limits,
    points: impl Iterator<Item = BoundedPoint>,
    n: u32,
    context: &str,
    tally: &mut Tally,
) -> bool {
    let surfaces = slice::from_ref(closure);
    let shaders = Shaders::new(program, surfaces, limits, Tiering::Eager);
    let mut bounding = shaders.worker();
    let mut plain = InterpSurfaces::new(program, surfaces, limits);
    let is_native = matches!(shaders.report()[0].evaluation, Evaluation::Native { .. });
    let mut idle = Tally::default();
    let tally = if is_native { tally } else { &mut idle };
    for at in points {
        check(&mut bounding, &mut plain, at, n, context, tally);
    }
    is_native
}

/// The same of the function that a program leaves; none if the program fails before.
///
/// # Panics
/// As [`check`].
pub fn check_program(
    text: &str,
    limits: Limits,
    points: impl Iterator<Item = BoundedPoint>,
    n: u32,
    tally: &mut Tally,
) -> Option<bool> {
    let (program, closure) = load(text, limits)?;
    Some(check_function((&program, &closure), limits, points, n, text, tally))
}
