//! `gmlvm stability`: the table of the stability suite, for people and for programs.

use serde::Serialize;

use crate::args::{Precision, StabilityArgs};
use crate::console;
use crate::driver::run;
use crate::failure::Failure;
use crate::report::Reporter;
use crate::stability::{self, Method, Row};

pub(super) fn stability(args: &StabilityArgs, reporter: &Reporter) -> Result<u8, Failure> {
    let of_precision = |&precision: &Precision| {
        args.engines.iter().map(move |&engine| Method { engine, precision })
    };
    let methods: Vec<_> = args.precisions.iter().flat_map(of_precision).collect();
    let threads = run::threads(args.threads.map_or(0, usize::from))?;
    let show = |line: &str| console::data(|out| writeln!(out, "{line}"));
    if !args.json {
        show(&heading(&methods))?;
    }
    let mut rows = Vec::new();
    for row in stability::rows(&methods, &threads, reporter) {
        let row = row?;
        if !args.json {
            show(&line(&row))?;
        }
        rows.push(row);
    }
    show(&if args.json { json(&methods, &rows) } else { summary(&rows) })?;
    Ok(verdict(&rows, reporter))
}

/// The exit code, having said which cases are beyond their bounds.
fn verdict(rows: &[Row], reporter: &Reporter) -> u8 {
    let beyond: Vec<_> = rows.iter().filter(|row| !row.holds()).map(|row| row.case.name).collect();
    if beyond.is_empty() {
        return 0;
    }
    reporter.message(&format!("beyond the bound: {}", beyond.join(", ")));
    1
}

fn heading(methods: &[Method]) -> String {
    let methods: String = methods.iter().map(|method| format!(" {:>9}", method.name())).collect();
    format!("{:<22} {:>7} {:>7}{methods} {:>6}  what fails", "case", "pixels", "naive", "bound")
}

fn line(row: &Row) -> String {
    let Row { case, n_pixels, naive, ours } = row;
    let ours: String = ours.iter().map(|error| format!(" {error:>9}")).collect();
    format!(
        "{:<22} {n_pixels:>7} {naive:>7}{ours} {:>6}  {}",
        case.name,
        case.bound,
        case.failure()
    )
}

fn summary(rows: &[Row]) -> String {
    let n_failed = rows.iter().filter(|row| row.naive > row.case.bound).count();
    let n_held = rows.iter().filter(|row| row.holds()).count();
    let n_cases = rows.len();
    format!(
        "{n_held} of {n_cases} cases are within their bounds; the naive renderer fails {n_failed}"
    )
}

/// The table for programs.
#[derive(Serialize)]
struct Table {
    version: &'static str,
    cases: Vec<Case>,
}

#[derive(Serialize)]
struct Case {
    name: &'static str,
    failure: &'static str,
    pixels: u64,
    naive: u64,
    ours: Vec<Ours>,
    bound: u64,
}

#[derive(Serialize)]
struct Ours {
    method: String,
    error: u64,
}

fn json(methods: &[Method], rows: &[Row]) -> String {
    let ours = |row: &Row| {
        methods
            .iter()
            .zip(&row.ours)
            .map(|(method, &error)| Ours { method: method.name(), error })
            .collect()
    };
    let cases = rows
        .iter()
        .map(|row| Case {
            name: row.case.name,
            failure: row.case.failure(),
            pixels: row.n_pixels,
            naive: row.naive,
            ours: ours(row),
            bound: row.case.bound,
        })
        .collect();
    let table = Table { version: env!("CARGO_PKG_VERSION"), cases };
    serde_json::to_string_pretty(&table).expect("numbers and texts are JSON")
}

#[cfg(test)]
mod tests {
    use crate::args::{ColorChoice, Common, Engine, MessageFormat};
    use crate::stability::CASES;

    use super::*;

    #[test]
    fn a_case_beyond_its_bound_ends_with_1() {
        let options = Common {
            quiet: true,
            verbose: false,
            color: ColorChoice::Never,
            message_format: MessageFormat::Human,
        };
        let reporter = Reporter::new(&options);
        let row =
            |ours: [u64; 2]| Row { case: &CASES[0], n_pixels: 9, naive: 5, ours: ours.into() };
        assert_eq!(verdict(&[row([0, 0]), row([0, 0])], &reporter), 0);
        assert_eq!(verdict(&[row([0, 0]), row([0, CASES[0].bound + 1])], &reporter), 1);
        assert!(summary(&[row([0, 0]), row([1, 0])]).starts_with("1 of 2"));
        let methods =
            [Engine::Interp, Engine::Jit].map(|engine| Method { engine, precision: Precision::Dd });
        assert_eq!(
            heading(&methods).find("bound"),
            line(&row([0, 0])).find(" 0  b").map(|at| at - 3)
        );
    }
}
