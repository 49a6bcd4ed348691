//! Measuring on scenes that are named: each image of each in turn.

use std::cell::RefCell;
use std::path::Path;

use rayon::ThreadPool;
use renderer::certify::Certainty;
use renderer::image::Pixel;
use renderer::plan::{Omissions, Part};
use renderer::shade::Doubt;
use vm::host::RenderJob;

use crate::args::{Engine, Precision};
use crate::chart::data::Outcome;
use crate::chart::errors::Light;
use crate::chart::measure::{Bench, each_image, outcome};
use crate::chart::methods::{Diagram, METHODS, Method, Render};
use crate::chart::render::{self, Setting, Stop, in_time};
use crate::chart::study::data::{Dots, Form, Item, Mark, Mask, Pair, Panel, Shares};
use crate::chart::study::sets::Kind;
use crate::clean::clean;
use crate::failure::Failure;
use crate::formats::Pixels;
use crate::load::Source;
use crate::measure::machine;
use crate::measure::rounds::Rounds;
use crate::measure::statistics::median;
use crate::run;
use crate::run::certainty::Known;
use crate::run::plan::Plan;
use crate::trace::{self, Account, Settings, Traced};

/// Points of a panel of bounds, spread evenly over the image.
const N_DOTS: usize = 150;

/// An image to be measured.
struct Image<'i> {
    job: &'i RenderJob<'i>,
    plan: &'i Plan,
    bench: Bench<'i>,
    /// The scene, with a number from the second image on.
    name: String,
}

/// Measures what a panel of this kind shows, for each image of a scene.
///
/// # Errors
/// What is wrong with the scene.
pub(super) fn measure(kind: Kind, scene: &Path, bench: Bench<'_>) -> Result<Vec<Panel>, Failure> {
    let scene_name = clean(&scene.display().to_string()).into_owned();
    let mut panels = Vec::new();
    let source = Source::read(scene, &bench.args.inputs, bench.reporter)?;
    each_image(source, scene, bench, &mut |job, plan, used| {
        let args = bench.args;
        let (width, height) = (plan.view.width, plan.view.height);
        args.limits.check(job, used, width, height, Precision::Certified)?;
        let name = match used.images {
            1 => scene_name.clone(),
            number => format!("{scene_name}, image {number}"),
        };
        let image = Image { job, plan, bench, name: name.clone() };
        let form = match kind {
            Kind::Certainty => Form::Shares { items: vec![image.item(image.shares())] },
            Kind::Threads => Form::Pairs { items: vec![image.item(image.threads())] },
            Kind::Omissions => Form::Pairs { items: image.omissions() },
            Kind::Bounds => Form::Dots { items: vec![image.item(image.dots())] },
            Kind::Differences => Form::Masks { items: image.masks()? },
            Kind::Misses | Kind::Points | Kind::Stability | Kind::Bounces => {
                unreachable!("these are not of scenes")
            }
        };
        panels.push(Panel { kind, scene: name, form, about: bench.about.clone() });
        Ok(())
    })?;
    Ok(panels)
}

impl Image<'_> {
    fn item<F>(&self, measured: Result<F, Stop>) -> Item<F> {
        named(&self.name, measured, self.timed())
    }

    /// One thread, and the time that a method has.
    fn timed(&self) -> Setting<'_> {
        let Bench { args, thread, .. } = self.bench;
        Setting { threads: thread, limits: args.limits.machine(), timeout: Some(args.timeout) }
    }

    fn unhurried<'t>(&self, threads: &'t ThreadPool) -> Setting<'t> {
        Setting { threads, limits: self.bench.args.limits.machine(), timeout: None }
    }

    fn trace(&self, setting: Setting<'_>, settings: Settings<'_>) -> Result<Traced, Stop> {
        in_time(setting, |progress| {
            trace::trace_job(self.job, self.plan, settings, false, progress)
                .map_err(|failure| Stop::Wrong(run::surface_error(failure, self.job)))
        })
    }

    /// Lets each of `n` ways trace the image in each round: seconds of tracing by way, and what came of
    /// each way at last. `trace` gets the number of the way.
    fn rounds(
        &self,
        n: usize,
        trace: impl Fn(usize) -> Result<Traced, Stop>,
    ) -> Result<Vec<(Vec<f64>, Traced)>, Stop> {
        let Bench { args, reporter, .. } = self.bench;
        let rounds = Rounds::new(args.warmup, args.runs, None);
        let bar = rounds.bar(&self.name, n, reporter.quiet);
        let mut all: Vec<(Vec<f64>, Option<Traced>)> = (0..n).map(|_| (Vec::new(), None)).collect();
        rounds.each(n, |index, counts| {
            let traced = trace(index)?;
            if counts {
                all[index].0.push(traced.trace_time.as_secs_f64());
            }
            all[index].1 = Some(traced);
            bar.inc(1);
            Ok::<(), Stop>(())
        })?;
        bar.finish();
        Ok(all.into_iter().filter_map(|(times, traced)| Some((times, traced?))).collect())
    }

    fn shares(&self) -> Result<Shares, Stop> {
        let precisions = [Precision::F64, Precision::Certified];
        let setting = self.timed();
        let mut all = self.rounds(2, |index| {
            self.trace(setting, setting.of_tracer(Engine::Jit, precisions[index]))
        })?;
        let (times, certified) = all.pop().expect("two ways");
        let (base, _) = all.pop().expect("two ways");
        let known = Known::count(&certified.certainties.unwrap_or_default());
        Ok(Shares { known, base, times })
    }

    fn threads(&self) -> Result<Pair, Stop> {
        let settings = [self.timed(), self.unhurried(self.bench.two_threads)];
        let work = [const { RefCell::new(Vec::new()) }; 2];
        let mut all = self.rounds(2, |index| {
            let setting = settings[index];
            let of_tracer = setting.of_tracer(Engine::Jit, Precision::F64);
            let start = machine::process_time();
            let traced = self.trace(setting, Settings { clock: machine::time, ..of_tracer })?;
            work[index].borrow_mut().push((machine::process_time() - start).as_secs_f64());
            Ok(traced)
        })?;
        let (times, _) = all.pop().expect("two ways");
        let (base, _) = all.pop().expect("two ways");
        // Those of rounds that count.
        let work = work.map(|work| work.into_inner().split_off(self.bench.args.warmup as usize));
        Ok(Pair { pixels: self.plan.n_pixels(), base, times, work: Some(work) })
    }

    /// An item for each part that is left out besides those before it.
    fn omissions(&self) -> Vec<Item<Pair>> {
        let setting = self.timed();
        let mut steps = vec![("nothing left out", Omissions::NONE)];
        for part in Part::ALL {
            let (_, before) = steps[steps.len() - 1];
            steps.push((words(part), before.with(part)));
        }
        let measured = self.rounds(steps.len(), |index| {
            let of_tracer = setting.of_tracer(Engine::Jit, Precision::F64);
            self.trace(setting, Settings { omissions: steps[index].1, ..of_tracer })
        });
        let all = match measured {
            Ok(all) => all,
            Err(stop) => return vec![self.item(Err(stop))],
        };
        let (base, first) = &all[0];
        let item = |((name, _), (times, traced)): (&(&str, Omissions), &(Vec<f64>, Traced))| {
            let is_same = traced.picture.pixels == first.picture.pixels;
            let pair = || {
                let (base, times) = (base.clone(), times.clone());
                Outcome::Rendered(Pair { pixels: self.plan.n_pixels(), base, times, work: None })
            };
            let differs = || Outcome::Failed { reason: "the image has other bytes".to_owned() };
            let outcome = if is_same { pair() } else { differs() };
            Item { name: (*name).to_owned(), outcome }
        };
        steps.iter().zip(&all).map(item).collect()
    }

    fn dots(&self) -> Result<Dots, Stop> {
        let setting = self.timed();
        let accounts = in_time(setting, |progress| {
            let settings = setting.of_tracer(Engine::Jit, Precision::Certified);
            trace::accounts(self.job, self.plan, settings, progress)
                .map_err(|failure| Stop::Wrong(run::surface_error(failure, self.job)))
        })?;
        let channels: Vec<Account> = accounts.into_iter().flatten().flatten().collect();
        Ok(dots(&channels))
    }

    /// Where methods differ from the certified image.
    ///
    /// # Errors
    /// When there is no certified image.
    fn masks(&self) -> Result<Vec<Item<Mask>>, Box<compiler::diagnostic::Diagnostic>> {
        let unhurried = self.unhurried(self.bench.all_threads);
        let settings = unhurried.of_tracer(Engine::Jit, Precision::Certified);
        let certified = trace::trace_job(self.job, self.plan, settings, false, &|_| {})
            .map_err(|failure| run::surface_error(failure, self.job))?;
        let compared = |method: &&Method| {
            let is_certified = Render::Tracer(Engine::Jit, Precision::Certified) == method.render;
            let is_interpreted = matches!(method.render, Render::Tracer(Engine::Interp, _));
            method.diagram() == Diagram::Rounding && !is_certified && !is_interpreted
        };
        let setting = self.timed();
        let item = |method: &Method| {
            let rendered = render::render(self.job, self.plan, method.render, setting);
            let mask = rendered.map(|rendered| self.mask(&rendered.pixels, &certified));
            named(method.name, mask, setting)
        };
        Ok(METHODS.iter().filter(compared).map(item).collect())
    }

    /// `pixels` are those of the region.
    fn mask(&self, pixels: &[Light], certified: &Traced) -> Mask {
        let region = self.plan.view.region;
        let Pixels::Bytes(exact) = &certified.picture.pixels else {
            unreachable!("it is of bytes")
        };
        let certainties = certified.certainties.as_deref().unwrap_or_default();
        let width = self.plan.view.width as usize;
        let row = |(y, row): (usize, &[Light])| {
            let start = (region.y as usize + y) * width + region.x as usize;
            let mark =
                |(at, light): (usize, &Light)| mark(*light, exact[at], certainties[at]).letter();
            let marks: String = (start..).zip(row).map(mark).collect();
            marks.trim_end_matches(Mark::Same.letter()).to_owned()
        };
        Mask {
            width: region.width,
            rows: pixels.chunks(region.width as usize).enumerate().map(row).collect(),
        }
    }
}

fn named<F>(name: &str, measured: Result<F, Stop>, setting: Setting<'_>) -> Item<F> {
    let outcome = measured.map_or_else(|stop| outcome(stop, setting), Outcome::Rendered);
    Item { name: name.to_owned(), outcome }
}

/// What a part leaves out, in words.
fn words(part: Part) -> &'static str {
    match part {
        Part::Coordinates => "unread coordinates",
        Part::Eye => "moving the eye anew",
        Part::Turns => "zeros of matrices",
        Part::Planes => "rows of planes",
        Part::Lists => "lists of crossings",
        Part::Shadows => "shadows on black",
        Part::Blockers => "search for blockers",
        Part::Fading => "constant fading",
        Part::Obstacles => "planes behind lamps",
        Part::Rest => "ends of paths",
        Part::Calls => "calls one by one",
    }
}

/// How a pixel compares with the certified one.
fn mark(light: Light, exact: [u8; 3], certainty: Certainty) -> Mark {
    if light.map(<[u8; 3]>::from_linear) == Some(exact) {
        return Mark::Same;
    }
    match certainty {
        Certainty::Unknown | Certainty::Double | Certainty::DoubleDouble => Mark::Certain,
        Certainty::Rule(Doubt::Boundary) => Mark::Boundary,
        Certainty::Rule(Doubt::Light) => Mark::Light,
        Certainty::Rule(Doubt::Surface) => Mark::Surface,
        Certainty::Rule(Doubt::Color) => Mark::Color,
    }
}

/// What channels say of bounds.
fn dots(channels: &[Account]) -> Dots {
    let known: Vec<&Account> = channels.iter().filter(|a| a.bound.is_finite()).collect();
    // The exact number may be off by its own bound.
    let is_unsound = |a: &&&Account| a.error - a.exact_bound > a.bound;
    let off: Vec<_> = known.iter().filter(|a| a.error > 0.0).collect();
    let slack: Vec<f64> = off.iter().map(|a| a.bound / a.error).collect();
    let step = known.len().div_ceil(N_DOTS).max(1);
    Dots {
        channels: known.len() as u64,
        unsound: known.iter().filter(is_unsound).count() as u64,
        exact: (known.len() - off.len()) as u64,
        slack: (!slack.is_empty()).then(|| median(&slack)),
        points: known.iter().step_by(step).map(|a| [a.bound, a.error]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_that_do_not_hold_are_counted() {
        let account = |bound: f64, error: f64| Account { bound, error, exact_bound: 1e-30 };
        let unknown = account(f64::INFINITY, f64::NAN);
        let channels = [account(8e-16, 1e-16), account(4e-16, 2e-16), account(0.0, 0.0), unknown];
        let Dots { channels: n, unsound, exact, slack, points } = dots(&channels);
        assert_eq!((n, unsound, exact, points.len()), (3, 0, 1, 3));
        assert_eq!(slack, Some(f64::midpoint(8e-16 / 1e-16, 2.0)));
        assert_eq!(dots(&[account(1e-16, 2e-16), account(0.0, 1e-31)]).unsound, 1);
    }

    #[test]
    fn marks_say_why() {
        let light = Some([0.5, 0.5, 0.5]);
        let certainty = Certainty::Rule(Doubt::Surface);
        assert_eq!(mark(light, [127; 3], certainty), Mark::Same);
        assert_eq!(mark(light, [127, 127, 128], certainty), Mark::Surface);
        assert_eq!(mark(light, [0; 3], Certainty::DoubleDouble), Mark::Certain);
        assert_eq!(mark(None, [127; 3], Certainty::Double), Mark::Certain);
    }
}
