//! Charts for readers of text.

use std::fmt::Write;

use compiler::diagnostic::grouped;

use crate::chart::data::{About, Chart, Data, Errors, Measured, Outcome};
use crate::chart::front;
use crate::measure::statistics::median;
use crate::measure::time;

/// The headings of a table.
pub(super) const HEADINGS: [&str; 9] =
    ["method", "s/Mpixel", "fastest", "preparing", "differ", "gross", "max", "rms", "standing"];

/// A row for each method.
pub(super) fn rows(chart: &Chart) -> Vec<[String; 9]> {
    let standings = standings(chart);
    chart.methods.iter().zip(standings).map(|(m, standing)| row(chart, m, standing)).collect()
}

fn row(chart: &Chart, measured: &Measured, standing: String) -> [String; 9] {
    let name = measured.method.clone();
    let Some(figures) = measured.figures() else {
        let none = || "–".to_owned();
        return [name, none(), none(), none(), none(), none(), none(), none(), standing];
    };
    let Errors { differing, gross, max, rms, .. } = figures.errors;
    let light = |error: Option<f64>| match error {
        None => "∞".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(error) => format!("{error:.1e}"),
    };
    let [cost, _] = chart.cost(figures);
    let fastest = figures.tracing.iter().copied().fold(f64::INFINITY, f64::min);
    [
        name,
        time(cost),
        time(chart.per_megapixel(fastest)),
        time(median(&figures.preparing)),
        differing.to_string(),
        gross.to_string(),
        light(max),
        light(rms),
        standing,
    ]
}

/// How each method compares with the others: on the front, dominated, or without an image.
fn standings(chart: &Chart) -> Vec<String> {
    let (names, points): (Vec<_>, Vec<_>) = chart
        .rendered()
        .map(|(method, figures)| (method.name, chart.point(method, figures)))
        .unzip();
    let mut dominators = front::dominators(&points).into_iter();
    let standing = |measured: &Measured| match &measured.outcome {
        Outcome::Rendered(_) => match dominators.next().flatten() {
            None => "front".to_owned(),
            Some(by) => format!("dominated by {}", names[by]),
        },
        Outcome::Failed { reason } => format!("failed: {reason}"),
        Outcome::TimedOut { seconds } => format!("took more than {}", time(*seconds)),
    };
    chart.methods.iter().map(standing).collect()
}

/// Who is on the front and who is dominated, in a line each.
pub(super) fn notes(chart: &Chart) -> Vec<String> {
    let standings = standings(chart);
    let of = |prefix: &str| -> Vec<&str> {
        let all = chart.methods.iter().zip(&standings);
        all.filter(|(_, s)| s.starts_with(prefix)).map(|(m, _)| m.method.as_str()).collect()
    };
    let line = |(title, prefix): (&str, &str)| (title.to_owned(), of(prefix));
    [("front", "front"), ("dominated", "dominated"), ("failed", "failed"), ("too slow", "took")]
        .map(line)
        .into_iter()
        .filter(|(_, names)| !names.is_empty())
        .map(|(title, names)| format!("{title}: {}", names.join(", ")))
        .collect()
}

/// Scene and diagram.
pub(super) fn heading(chart: &Chart) -> String {
    format!("{}, {}", chart.scene, chart.diagram.name())
}

/// What a chart is of.
pub(super) fn title(chart: &Chart) -> String {
    let Chart { images, pixels, methods, .. } = chart;
    let n_rounds =
        methods.iter().find_map(Measured::figures).map_or(0, |figures| figures.tracing.len());
    let plural =
        |n: u64, word: &str| format!("{} {word}{}", grouped(n), if n == 1 { "" } else { "s" });
    format!(
        "{}: {}, {}, {}; against {}",
        heading(chart),
        plural(*images, "image"),
        plural(*pixels, "pixel"),
        plural(n_rounds as u64, "round"),
        chart.diagram.reference_words(),
    )
}

/// Where and how charts were measured: a line for each place.
pub(super) fn captions(data: &Data) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for chart in &data.charts {
        let line = chart.about.line();
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    lines
}

impl About {
    /// All of it in a line.
    pub(crate) fn line(&self) -> String {
        let About { version, build, date, machine } = self;
        let cores = if machine.cores == 1 { "core" } else { "cores" };
        let load = machine.load.map(|load| format!(", load {load:.1}")).unwrap_or_default();
        format!(
            "gmlvm {version} ({build}) on {}, {} {cores}{load}; one thread; {date}",
            machine.cpu, machine.cores
        )
    }
}

/// A chart as text.
pub(crate) fn text(chart: &Chart) -> String {
    let rows = rows(chart);
    let headings = HEADINGS.map(str::to_owned);
    let width = |column: usize| {
        let cells = std::iter::once(&headings).chain(&rows).map(|row| row[column].chars().count());
        cells.max().unwrap_or(0)
    };
    let widths: [usize; 9] = std::array::from_fn(width);
    let mut text = format!("\n{}\n", title(chart));
    for row in std::iter::once(&headings).chain(&rows) {
        write!(text, "  {:<1$}", row[0], widths[0]).expect("a string takes all");
        for (cell, width) in row[1..8].iter().zip(&widths[1..8]) {
            write!(text, "  {cell:>width$}").expect("a string takes all");
        }
        writeln!(text, "  {}", row[8]).expect("a string takes all");
    }
    text
}
