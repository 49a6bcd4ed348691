//! Growth for readers of text.

use compiler::diagnostic::grouped;

use crate::chart::scaling::data::{Grown, Measured, Point, Times};
use crate::chart::table::{Table, plural};
use crate::measure::statistics::{Ratio, median};
use crate::measure::time;

/// The headings behind the sizes.
const HEADINGS: [&str; 8] =
    ["rays", "a ray", "fastest", "a pixel", "preparing", "each", "program", "outcome"];

/// Beside a size that gave an image.
const RENDERED: &str = "rendered";

/// The table of a series, a row for each size.
pub(super) fn table(measured: &Measured) -> Table {
    let mut headings = vec![measured.series().name.to_owned()];
    headings.extend(HEADINGS.map(str::to_owned));
    Table {
        title: title(measured),
        headings,
        rows: measured.points.iter().map(|point| row(measured, point)).collect(),
        notes: notes(measured),
    }
}

fn row(measured: &Measured, point: &Point) -> Vec<String> {
    let Some(times) = point.times() else {
        let mut row = vec!["–".to_owned(); HEADINGS.len() + 1];
        row[0] = grouped(point.n);
        row[HEADINGS.len()] = point.outcome.failure().unwrap_or_default();
        return row;
    };
    let Times { rays, pixels, program, preparing, tracing } = times;
    let preparing = median(preparing);
    let is_about_solids = measured.series().is_about_solids;
    let each = if is_about_solids { time(preparing / point.n as f64) } else { "–".to_owned() };
    vec![
        grouped(point.n),
        grouped(*rays),
        time(times.of_ray()),
        time(times.extent()[0]),
        time(median(tracing) / *pixels as f64),
        time(preparing),
        each,
        time(median(program)),
        RENDERED.to_owned(),
    ]
}

/// What was measured.
fn title(measured: &Measured) -> String {
    let first = measured.rendered().next().map(|(_, times)| times);
    let [n_pixels, n_rounds] =
        first.map_or([0; 2], |times| [times.pixels, times.tracing.len() as u64]);
    format!(
        "{}: {} each, {}",
        heading(measured),
        plural(n_pixels, "pixel"),
        plural(n_rounds, "round")
    )
}

/// What a series is of.
pub(super) fn heading(measured: &Measured) -> String {
    let series = measured.series();
    format!("{} {}", series.name, series.about)
}

/// How the time grows, in a line.
pub(super) fn notes(measured: &Measured) -> Vec<String> {
    let Some(Grown { from, to, of_ray, of_pixel }) = measured.grown() else { return Vec::new() };
    let name = measured.series().name;
    let [from, to] = [from, to].map(grouped);
    let line = format!(
        "from {from} to {to} {name}: {} the time for a ray, {} for a pixel",
        times(of_ray),
        times(of_pixel)
    );
    vec![line]
}

/// A ratio and, if it is known, its interval.
fn times(Ratio { estimate, interval }: Ratio) -> String {
    let digits = |ratio: f64| {
        let decimals = if ratio < 10.0 { 2 } else { 0 };
        format!("{ratio:.decimals$}")
    };
    let between = interval.map(|[low, high]| format!(" [{}, {}]", digits(low), digits(high)));
    format!("{} times{}", digits(estimate), between.unwrap_or_default())
}
