//! Charts for readers of text.

use std::fmt::Write;

use compiler::diagnostic::grouped;

use crate::chart::data::{About, Chart, Errors, Measured, Outcome};
use crate::chart::front;
use crate::measure::statistics::median;
use crate::measure::time;

/// A table for any reader. The first and the last column are of words, the others of numbers.
#[derive(serde::Serialize)]
pub(crate) struct Table {
    pub(super) title: String,
    pub(super) headings: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
    /// Lines below.
    pub(super) notes: Vec<String>,
}

/// The headings of a chart's table.
const HEADINGS: [&str; 9] =
    ["method", "s/Mpixel", "fastest", "preparing", "differ", "gross", "max", "rms", "standing"];

impl Table {
    /// A chart's table, a row for each method.
    pub(crate) fn of(chart: &Chart) -> Table {
        let standings = standings(chart);
        let rows = chart.methods.iter().zip(standings);
        Table {
            title: title(chart),
            headings: HEADINGS.map(str::to_owned).to_vec(),
            rows: rows.map(|(m, standing)| row(chart, m, standing).to_vec()).collect(),
            notes: Vec::new(),
        }
    }

    /// The table as text.
    pub(crate) fn text(&self) -> String {
        let Table { title, headings, rows, notes } = self;
        let lines = || std::iter::once(headings).chain(rows);
        let width = |column: usize| {
            lines().map(|line| line[column].chars().count()).max().unwrap_or_default()
        };
        let last = headings.len() - 1;
        let mut text = format!("\n{title}\n");
        for line in lines() {
            let cells = line.iter().enumerate().map(|(column, cell)| match column {
                0 => format!("  {cell:<0$}", width(0)),
                _ if column == last => format!("  {cell}"),
                _ => format!("  {cell:>0$}", width(column)),
            });
            let line: String = cells.collect();
            writeln!(text, "{}", line.trim_end()).expect("a string takes all");
        }
        for note in notes {
            writeln!(text, "  {note}").expect("a string takes all");
        }
        text
    }
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
        other => other.failure().unwrap_or_default(),
    };
    chart.methods.iter().map(standing).collect()
}

impl<F> Outcome<F> {
    /// Why there is no image, if there is none.
    pub(super) fn failure(&self) -> Option<String> {
        match self {
            Outcome::Rendered(_) => None,
            Outcome::Failed { reason } => Some(format!("failed: {reason}")),
            Outcome::TimedOut { seconds } => Some(format!("took more than {}", time(*seconds))),
        }
    }
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
fn title(chart: &Chart) -> String {
    let Chart { images, pixels, methods, .. } = chart;
    let n_rounds =
        methods.iter().find_map(Measured::figures).map_or(0, |figures| figures.tracing.len());
    format!(
        "{}: {}, {}, {}; against {}",
        heading(chart),
        plural(*images, "image"),
        plural(*pixels, "pixel"),
        plural(n_rounds as u64, "round"),
        chart.diagram.reference_words(),
    )
}

/// So many of what a word says.
pub(super) fn plural(n: u64, word: &str) -> String {
    format!("{} {word}{}", grouped(n), if n == 1 { "" } else { "s" })
}

/// Where and how something was measured: a line for each place. `threads` are what it ran on.
pub(super) fn captions<'a>(all: impl IntoIterator<Item = &'a About>, threads: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for about in all {
        let line = about.line(threads);
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    lines
}

/// What nearly everything runs on.
pub(super) const ONE_THREAD: &str = "one thread";

impl About {
    /// All of it in a line.
    fn line(&self, threads: &str) -> String {
        let About { version, build, date, machine } = self;
        let cores = if machine.cores == 1 { "core" } else { "cores" };
        let load = machine.load.map(|load| format!(", load {load:.1}")).unwrap_or_default();
        format!(
            "gmlvm {version} ({build}) on {}, {} {cores}{load}; {threads}; {date}",
            machine.cpu, machine.cores
        )
    }
}
