//! What an image uses of the model, and what leaving out the rest saves: for `--explain`.

use compiler::diagnostic::grouped;
use jit::shaders::Evaluation;
use renderer::plan::{Omissions, Part, Use};
use renderer::shade::RayCounts;
use vm::host::RenderJob;

use crate::formats::Pixels;
use crate::measure::machine::process_time;
use crate::run::plan::Plan;
use crate::trace::{self, Settings, TraceFailure, Traced};

/// Rounds that are measured; in each, every variant runs once.
const N_ROUNDS: usize = 5;

/// An image traced with some omissions undone.
struct Variant {
    omissions: Omissions,
    /// Processor seconds, by round.
    times: Vec<f64>,
    rays: RayCounts,
}

/// Traces an image again, with each omission undone in turn, and tells in lines what the scene uses
/// and what each omission saves. `traced` is the image as it has been traced.
///
/// # Errors
/// What a surface function does wrong.
///
/// # Panics
/// If leaving out changes a byte: then a proof in the renderer is wrong.
pub(crate) fn explained(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    traced: &Traced,
) -> Result<Vec<String>, TraceFailure> {
    let mut lines = uses(traced);
    lines.extend(savings(job, plan, settings, traced)?);
    Ok(lines)
}

/// The second half of that: what each omission saves.
///
/// # Errors
/// What a surface function does wrong.
///
/// # Panics
/// If leaving out changes a byte.
pub(crate) fn savings(
    job: &RenderJob<'_>,
    plan: &Plan,
    settings: Settings<'_>,
    traced: &Traced,
) -> Result<Vec<String>, TraceFailure> {
    let omissions = Part::ALL.map(|part| Omissions::ALL.without(part));
    let mut variants: Vec<Variant> = [Omissions::ALL, Omissions::NONE]
        .into_iter()
        .chain(omissions)
        .map(|omissions| Variant { omissions, times: Vec::new(), rays: RayCounts::default() })
        .collect();
    let is_linear = matches!(traced.picture.pixels, Pixels::Linear(_));
    for _ in 0..N_ROUNDS {
        for variant in &mut variants {
            let settings = Settings { omissions: variant.omissions, ..settings };
            let start = process_time();
            let again = trace::trace_job(job, plan, settings, is_linear, &|_| {})?;
            variant.times.push((process_time() - start).as_secs_f64());
            variant.rays = again.rays;
            let is_same = again.picture.pixels == traced.picture.pixels;
            assert!(is_same, "an image with {:?} differs", variant.omissions);
        }
    }
    let mut lines = Vec::new();
    let [all, none, by_part @ ..] = &variants[..] else { unreachable!("both ends are traced") };
    let ms = 1e3 * median(all.times.clone());
    lines.push(format!("  {ms:.1} ms of processor time, the median of {N_ROUNDS}; times as much"));
    for (part, variant) in Part::ALL.into_iter().zip(by_part) {
        if let Some((name, amount)) = what(part, traced, &variant.rays) {
            lines.push(format!("  {:>8}  without {name}: {amount}", ratio(variant, all)));
        }
    }
    lines.push(format!("  {:>8}  without all of these", ratio(none, all)));
    Ok(lines)
}

/// The median of the ratios of two variants' times within the rounds.
fn ratio(variant: &Variant, base: &Variant) -> String {
    let ratios = variant.times.iter().zip(&base.times).map(|(time, base)| time / base);
    format!("{:.3}", median(ratios.collect()))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// What a scene uses of the model: the first half of what is explained, which takes no time.
pub(crate) fn uses(traced: &Traced) -> Vec<String> {
    let Use { shapes, single, unturned, carvings, planes, lights, directional, spots, fading } =
        traced.used;
    let RayCounts { primary, reflected, shadow, blocked, surface_calls } = traced.rays;
    let is_constant = |evaluation: &Evaluation| matches!(evaluation, Evaluation::Constant);
    let n_constant =
        traced.surfaces.iter().filter(|report| is_constant(&report.evaluation)).count();
    let n = |n: usize| grouped(n as u64);
    vec![
        format!(
            "  {} shapes, {} of them outside of intersections and differences, {} not turned, {} planes; {} carvings",
            n(shapes),
            n(single),
            n(unturned),
            n(planes),
            n(carvings)
        ),
        format!(
            "  {} lights, {} of them infinitely far away, {} in cones, {} fading with distance",
            n(lights),
            n(directional),
            n(spots),
            n(fading)
        ),
        format!(
            "  {} surface functions, {} of them known to be constant",
            n(traced.n_surfaces),
            n(n_constant)
        ),
        format!(
            "  {} rays from the eye, {} reflected, {} toward lights, of which {} are blocked; {} points shaded",
            grouped(primary),
            grouped(reflected),
            grouped(shadow),
            grouped(blocked),
            grouped(surface_calls)
        ),
    ]
}

/// An omission in words, and how much there is of what it leaves out; none if there is nothing.
/// `rays` are those of an image without it.
fn what(part: Part, traced: &Traced, rays: &RayCounts) -> Option<(&'static str, String)> {
    let used = &traced.used;
    let (name, amount, unit) = match part {
        Part::Coordinates => {
            ("leaving out texture coordinates", traced.rays.surface_calls, "points shaded")
        }
        Part::Eye => ("the eye in each shape's space", traced.rays.primary, "rays"),
        Part::Turns => ("leaving out zeros of matrices", used.unturned as u64, "shapes"),
        Part::Planes => ("asking one row of planes first", used.planes as u64, "planes"),
        Part::Lists => ("leaving out lists of crossings", used.carvings as u64, "carvings"),
        Part::Shadows => {
            let n_omitted = rays.shadow.saturating_sub(traced.rays.shadow);
            ("leaving out shadows on black", n_omitted, "rays toward lights")
        }
        Part::Blockers => {
            ("trying the last blocker first", traced.rays.blocked, "rays that are blocked")
        }
        Part::Fading => {
            let n_constant = used.lights - used.directional - used.fading;
            ("leaving out constant fading", n_constant as u64, "lights")
        }
        Part::Obstacles if used.lights == 0 => return None,
        Part::Obstacles => ("planes behind lamps", used.planes as u64, "planes"),
        Part::Rest => {
            let n_omitted = rays.reflected.saturating_sub(traced.rays.reflected);
            ("ending paths where the rest changes nothing", n_omitted, "reflected rays")
        }
        Part::Calls => {
            let is_batched = |evaluation: &Evaluation| {
                matches!(evaluation, Evaluation::Native { in_batches: true, .. })
            };
            let reports = traced.surfaces.iter();
            let n = reports.filter(|report| is_batched(&report.evaluation)).count();
            ("asking surface functions at many points at once", n as u64, "surface functions")
        }
    };
    (amount > 0).then(|| (name, format!("{} {unit}", grouped(amount))))
}
