//! Measuring on scenes that are part of the program: the stability suite, and the room of mirrors.

use std::sync::Arc;

use compiler::diagnostic::Diagnostic;
use compiler::preprocess::NoIncludes;
use compiler::source::SourceMap;
use vm::host::{Host, RenderJob};
use vm::machine::Machine;
use vm::program::LoadedProgram;

use crate::args::{Engine, Precision};
use crate::chart::data::Outcome;
use crate::chart::errors::Light;
use crate::chart::measure::{Bench, outcome};
use crate::chart::methods::{METHODS, Method, Numbers, Render};
use crate::chart::render::{self, Setting, Stop};
use crate::chart::study::data::{Case, Cells, Curve, Form, Item, Panel};
use crate::chart::study::sets::Kind;
use crate::failure::Failure;
use crate::run;
use crate::run::limits::Used;
use crate::run::plan::Plan;
use crate::stability::{self, CASES, Way};
use crate::trace::{self, Account};

/// Counts wrong pixels of each case of the stability suite.
///
/// # Errors
/// None that a scene of ours has.
pub(super) fn suite(bench: Bench<'_>) -> Result<Vec<Panel>, Failure> {
    let ways: Vec<(&Method, Way)> =
        METHODS.iter().filter_map(|method| Some((method, way(method.render)?))).collect();
    let by_name: Vec<Way> = ways.iter().map(|(_, way)| *way).collect();
    let mut cases = Vec::new();
    let mut cells: Vec<Vec<u64>> = ways.iter().map(|_| Vec::new()).collect();
    for case in CASES {
        let wrong = stability::wrong(case, &by_name, bench.all_threads, bench.reporter)?;
        cases.push(Case { name: case.name.to_owned(), pixels: wrong.n_pixels });
        cells.iter_mut().zip(wrong.by_way).for_each(|(all, n)| all.push(n));
    }
    let item = |((method, _), wrong): (&(&Method, Way), Vec<u64>)| Item {
        name: method.name.to_owned(),
        outcome: Outcome::Rendered(Cells { wrong }),
    };
    let items = ways.iter().zip(cells).map(item).collect();
    Ok(vec![panel(Kind::Stability, Form::Cells { cases, items }, bench)])
}

/// The same for the suite; none if that cannot be held against its cases, or is as good as another.
fn way(render: Render) -> Option<Way> {
    match render {
        Render::Tracer(Engine::Jit, precision) => {
            Some(Way::Ours(stability::Method { engine: Engine::Jit, precision }))
        }
        Render::Naive(Numbers::F64, epsilon) => Some(Way::NaiveDoubles(epsilon)),
        Render::Naive(Numbers::F32, epsilon) => Some(Way::NaiveSingles(epsilon)),
        Render::Tracer(..) | Render::Sampled(_) => None,
    }
}

fn panel(kind: Kind, form: Form, bench: Bench<'_>) -> Panel {
    Panel { kind, scene: String::new(), form, about: bench.about.clone() }
}

/// Paths have up to so many reflections.
const MAX_BOUNCES: u32 = 60;

/// What a point of a path adds of its colour.
const SHARE: f64 = 0.001;

/// Methods that are held against double-double.
const HELD: [&str; 3] = ["naive-f32-1e-3", "naive-f64-1e-9", "jit-f64"];

/// What balls of doubles tell. Those of double-double say nothing here: surface functions get
/// coordinates as doubles, and balls that know these know the rest.
const BOUND: &str = "bound of doubles";

/// Measures how far off paths are after more and more reflections.
///
/// # Errors
/// When the region asked for has no pixels.
pub(super) fn bounces(bench: Bench<'_>) -> Result<Vec<Panel>, Failure> {
    let mut sources = SourceMap::default();
    let text = include_str!("bounces.gml");
    let root = sources.add("bounces.gml", text.into()).expect("programs of ours are short");
    let program = compiler::compile(&mut sources, root, &mut NoIncludes, &[])
        .expect("programs of ours are right");
    let program = Arc::new(LoadedProgram::new(program));
    let item = |name: &str| {
        let curve = Curve { points: Vec::new(), times: Vec::new() };
        Item { name: name.to_owned(), outcome: Outcome::Rendered(curve) }
    };
    let items = HELD.into_iter().chain([BOUND]).map(item).collect();
    let mut room = Room { bench, items, stopped_by: None };
    let ended = Machine::new(&program, bench.args.limits.machine()).run(&mut room);
    let Room { mut items, stopped_by, .. } = room;
    if let Some(failure) = stopped_by {
        return Err(failure);
    }
    if let Err(error) = ended {
        let reason = error.into_diagnostic().message;
        items.iter_mut().for_each(|item| {
            item.outcome = Outcome::Failed { reason: reason.clone() };
        });
    }
    Ok(vec![panel(Kind::Bounces, Form::Curves { items }, bench)])
}

/// A host that traces the room with more and more reflections.
struct Room<'b> {
    bench: Bench<'b>,
    items: Vec<Item<Curve>>,
    stopped_by: Option<Failure>,
}

impl Host for Room<'_> {
    fn render(&mut self, mut job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        for n in 1..=MAX_BOUNCES {
            job.depth = n;
            let args = self.bench.args;
            let mut used = Used::default();
            used.add(job.width, job.height);
            args.limits.check(&job, used, job.width, job.height, Precision::Certified)?;
            match Plan::new(&job, &args.picture) {
                Ok(plan) => self.reflect(&job, &plan, f64::from(n))?,
                Err(failure) => {
                    self.stopped_by = Some(failure);
                    return Err(run::stopped());
                }
            }
        }
        Ok(())
    }
}

impl Room<'_> {
    /// Adds a point to each line that has not ended.
    fn reflect(&mut self, job: &RenderJob<'_>, plan: &Plan, n: f64) -> Result<(), Box<Diagnostic>> {
        let Bench { args, thread, all_threads, .. } = self.bench;
        let limits = args.limits.machine();
        let unhurried = Setting { threads: all_threads, limits, timeout: None };
        let timed = Setting { threads: thread, limits, timeout: Some(args.timeout) };
        let exact = Render::Tracer(Engine::Jit, Precision::Dd);
        let reference = match render::render(job, plan, exact, unhurried) {
            Ok(rendered) => rendered.pixels,
            Err(Stop::Wrong(diagnostic)) => return Err(diagnostic),
            Err(Stop::TooDeep | Stop::TimedOut) => unreachable!("the tracer has all time"),
        };
        let (held, bounds) = self.items.split_at_mut(HELD.len());
        for item in held {
            let method = Method::named(&item.name).expect("it is in the table");
            let Outcome::Rendered(curve) = &mut item.outcome else { continue };
            match render::render(job, plan, method.render, timed) {
                Ok(rendered) => curve.add(n, differences(&rendered.pixels, &reference)),
                Err(stop) => item.outcome = outcome(stop, timed),
            }
        }
        let settings = unhurried.of_tracer(Engine::Jit, Precision::Certified);
        let accounts = trace::accounts(job, plan, settings, &|_| {})
            .map_err(|failure| run::surface_error(failure, job))?;
        let largest = |channels: &[Account; 3]| {
            channels.iter().map(|account| account.bound).fold(0.0, f64::max)
        };
        let bound =
            |account: &Option<[Account; 3]>| account.as_ref().map_or(f64::INFINITY, largest);
        for item in bounds {
            let Outcome::Rendered(curve) = &mut item.outcome else { continue };
            curve.add(n, accounts.iter().map(bound).collect());
        }
        Ok(())
    }
}

impl Curve {
    /// Adds the median of errors of linear light, if that is finite.
    fn add(&mut self, n: f64, mut errors: Vec<f64>) {
        errors.sort_by(f64::total_cmp);
        let middle = errors[errors.len() / 2] / SHARE;
        if middle.is_finite() {
            self.points.push([n, middle]);
        }
    }
}

/// The largest differences of pixels' channels.
fn differences(image: &[Light], reference: &[Light]) -> Vec<f64> {
    let of_pixel = |(pixel, expected): (&Light, &Light)| match (pixel, expected) {
        (Some(pixel), Some(expected)) => {
            (0..3).map(|c| (pixel[c] - expected[c]).abs()).fold(0.0, f64::max)
        }
        _ => f64::INFINITY,
    };
    image.iter().zip(reference).map(of_pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_pixel_counts() {
        let gray = |c: f64| Some([c; 3]);
        let reference = [0.5, 0.5, 0.5].map(gray);
        let errors = differences(&[gray(0.5), Some([0.5, 0.625, 0.5]), None], &reference);
        assert_eq!(errors, [0.0, 0.125, f64::INFINITY]);
        let mut curve = Curve { points: Vec::new(), times: Vec::new() };
        curve.add(1.0, errors);
        curve.add(2.0, vec![f64::INFINITY; 3]);
        assert_eq!(curve.points, [[1.0, 0.125 / SHARE]]);
    }
}
