//! A study for readers of text.

use compiler::diagnostic::grouped;

use crate::chart::study::data::{
    Case, Cells, Curve, Dots, Form, Item, Mark, Mask, Pair, Panel, Shares,
};
use crate::chart::study::sets::Kind;
use crate::chart::table::{Table, plural};
use crate::measure::statistics::{Ratio, median};
use crate::measure::time;

/// How pixels are known, in the order of [`Shares::counts`].
pub(super) const SHARES: [&str; 6] = [
    "in doubles",
    "in double-double",
    "rules: boundary",
    "rules: light",
    "rules: surface",
    "rules: colour",
];

/// Why a pixel may differ.
pub(super) fn words(mark: Mark) -> &'static str {
    match mark {
        Mark::Same => "same",
        Mark::Certain => "certain",
        Mark::Boundary => SHARES[2],
        Mark::Light => SHARES[3],
        Mark::Surface => SHARES[4],
        Mark::Color => SHARES[5],
    }
}

/// What came of what gave figures.
const MEASURED: &str = "measured";

/// The table of a panel.
pub(super) fn table(panel: &Panel) -> Table {
    let (headings, rows) = match &panel.form {
        Form::Curves { items } => curves(items),
        Form::Cells { cases, items } => cells(cases, items),
        Form::Shares { items } => shares(items),
        Form::Pairs { items } => pairs(items),
        Form::Dots { items } => dots(items),
        Form::Masks { items } => masks(items),
    };
    let set = panel.kind.set().name;
    let title = format!("{set}: {}{}", panel.heading(), rounds(panel));
    Table { title, headings, rows, notes: notes(panel) }
}

/// How many rounds there were, if times were taken.
fn rounds(panel: &Panel) -> String {
    fn first<F>(items: &[Item<F>], times: fn(&F) -> usize) -> usize {
        items.iter().find_map(Item::figures).map_or(0, times)
    }
    let n = match &panel.form {
        Form::Curves { items } => first(items, |curve| curve.times.len()),
        Form::Shares { items } => first(items, |shares| shares.times.len()),
        Form::Pairs { items } => first(items, |pair| pair.times.len()),
        Form::Cells { .. } | Form::Dots { .. } | Form::Masks { .. } => 0,
    };
    if n == 0 { String::new() } else { format!(", {}", plural(n as u64, "round")) }
}

type Cellular = (Vec<String>, Vec<Vec<String>>);

/// Rows of figures, each behind its name and before what came of it.
fn rows<F>(items: &[Item<F>], headings: &[String], row: impl Fn(&F) -> Vec<String>) -> Cellular {
    let of_item = |item: &Item<F>| {
        let none = || vec!["–".to_owned(); headings.len()];
        let mut cells = vec![item.name.clone()];
        cells.extend(item.figures().map_or_else(none, &row));
        cells.push(item.outcome.failure().unwrap_or_else(|| MEASURED.to_owned()));
        cells
    };
    let mut all = vec![String::new()];
    all.extend_from_slice(headings);
    all.push("outcome".to_owned());
    (all, items.iter().map(of_item).collect())
}

/// Errors at some of the places.
fn curves(items: &[Item<Curve>]) -> Cellular {
    const MAX_PLACES: usize = 8;
    let longest = items.iter().filter_map(Item::figures).map(|curve| &curve.points);
    let longest: &[[f64; 2]] = longest.max_by_key(|points| points.len()).map_or(&[], |p| p);
    let step = longest.len().div_ceil(MAX_PLACES).max(1);
    let places: Vec<f64> = longest.iter().step_by(step).map(|[x, _]| *x).collect();
    let mut headings: Vec<String> = places.iter().map(|x| grouped(*x as u64)).collect();
    headings.push("time".to_owned());
    rows(items, &headings, |curve| {
        let at = |place: &f64| curve.points.iter().find(|[x, _]| x == place);
        let error =
            |place: &f64| at(place).map_or("–".to_owned(), |[_, error]| scientific(*error));
        let mut row: Vec<String> = places.iter().map(error).collect();
        let has_times = !curve.times.is_empty();
        row.push(if has_times { time(median(&curve.times)) } else { "–".to_owned() });
        row
    })
}

fn scientific(error: f64) -> String {
    if error == 0.0 { "0".to_owned() } else { format!("{error:.1e}") }
}

/// Turned, so that methods are columns.
fn cells(cases: &[Case], items: &[Item<Cells>]) -> Cellular {
    let mut headings = vec!["case".to_owned(), "pixels".to_owned()];
    headings.extend(items.iter().map(|item| item.name.clone()));
    headings.push(String::new());
    let row = |(index, case): (usize, &Case)| {
        let wrong = |item: &Item<Cells>| {
            let n = item.figures().map(|cells| cells.wrong[index].to_string());
            n.or_else(|| item.outcome.failure()).unwrap_or_default()
        };
        let mut row = vec![case.name.clone(), case.pixels.to_string()];
        row.extend(items.iter().map(wrong));
        row.push(String::new());
        row
    };
    (headings, cases.iter().enumerate().map(row).collect())
}

fn shares(items: &[Item<Shares>]) -> Cellular {
    let mut headings = SHARES.map(str::to_owned).to_vec();
    headings.push("times f64".to_owned());
    rows(items, &headings, |shares| {
        let mut row: Vec<String> = shares.counts().iter().map(u64::to_string).collect();
        row.push(times(shares.overhead()));
        row
    })
}

fn pairs(items: &[Item<Pair>]) -> Cellular {
    let headings = ["a pixel", "fastest", "times as fast", "times the work"].map(str::to_owned);
    rows(items, &headings, |pair| {
        let [fastest, middle, _] = pair.of_pixel();
        let work = pair.more_work().map_or("–".to_owned(), times);
        vec![time(middle), time(fastest), times(pair.gain()), work]
    })
}

/// A ratio and, if it is known, its interval.
fn times(Ratio { estimate, interval }: Ratio) -> String {
    let between = interval.map(|[low, high]| format!(" [{low:.2}, {high:.2}]"));
    format!("{estimate:.2}{}", between.unwrap_or_default())
}

fn dots(items: &[Item<Dots>]) -> Cellular {
    let headings = ["channels", "unsound", "exact", "bound/error"].map(str::to_owned);
    rows(items, &headings, |dots| {
        let Dots { channels, unsound, exact, slack, .. } = dots;
        let slack = slack.map_or("–".to_owned(), |slack| format!("{slack:.1}"));
        vec![channels.to_string(), unsound.to_string(), exact.to_string(), slack]
    })
}

fn masks(items: &[Item<Mask>]) -> Cellular {
    let mut headings = vec!["differ".to_owned()];
    headings.extend(Mark::DIFFERENT.map(|mark| words(mark).to_owned()));
    rows(items, &headings, |mask| {
        let mut row = vec![mask.different().count().to_string()];
        row.extend(Mark::DIFFERENT.map(|mark| mask.count(mark).to_string()));
        row
    })
}

/// What a panel says in a line or two.
pub(super) fn notes(panel: &Panel) -> Vec<String> {
    match &panel.form {
        Form::Curves { items } if panel.kind == Kind::Misses => {
            let of = |item: &Item<Curve>| {
                let times = &item.figures()?.times;
                (!times.is_empty()).then(|| format!("{} {}", item.name, time(median(times))))
            };
            let all: Vec<String> = items.iter().filter_map(of).collect();
            vec![format!("a line takes: {}", all.join(", "))]
        }
        Form::Curves { items } if panel.kind == Kind::Bounces => {
            let of = |item: &Item<Curve>| {
                let growth = growth(&item.figures()?.points)?;
                Some(format!("{} {growth:.2}", item.name))
            };
            let all: Vec<String> = items.iter().filter_map(of).collect();
            vec![format!("errors grow with each reflection, times: {}", all.join(", "))]
        }
        Form::Cells { cases, items } => {
            let failed = |item: &Item<Cells>| {
                let n = item.figures()?.wrong.iter().filter(|n| **n > 0).count();
                Some(format!("{} {n}", item.name))
            };
            let all: Vec<String> = items.iter().filter_map(failed).collect();
            vec![format!("cases of {} with wrong pixels: {}", cases.len(), all.join(", "))]
        }
        Form::Dots { items } => items.iter().filter_map(note_of_dots).collect(),
        _ => Vec::new(),
    }
}

/// By what factor errors grow from one place to the next, on average, until they are as large as what they
/// are errors of; none from fewer than two places.
fn growth(points: &[[f64; 2]]) -> Option<f64> {
    const ALL_LOST: f64 = 0.1;
    let mut growing = points.iter().filter(|[_, error]| *error > 0.0 && *error < ALL_LOST);
    let ([from, first], [to, last]) = (growing.next()?, growing.next_back()?);
    Some((last / first).powf(1.0 / (to - from)))
}

fn note_of_dots(item: &Item<Dots>) -> Option<String> {
    let Dots { channels, unsound, exact, slack, .. } = item.figures()?;
    let slack = slack.map(|slack| format!("; bound / error {slack:.0} (median of the others)"));
    Some(format!(
        "{} of {} beyond their bounds; {} exact{}",
        grouped(*unsound),
        plural(*channels, "channel"),
        grouped(*exact),
        slack.unwrap_or_default()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_the_mean_factor_below_all() {
        let points = [[1.0, 0.0], [2.0, 1e-8], [3.0, 7e-8], [4.0, 4e-8], [5.0, 0.5]];
        // Two roundings, and those of a power.
        assert!((growth(&points).expect("two places") - 2.0).abs() < 8.0 * f64::EPSILON);
        assert_eq!(growth(&points[..2]), None);
    }
}
