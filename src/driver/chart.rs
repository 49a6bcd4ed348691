//! `gmlvm chart`: measures methods, growth or sets, or reads measurements, and writes tables, data and charts.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::args::ChartArgs;
use crate::chart::data::{About, Chart, Data};
use crate::chart::measure::{self, Bench};
use crate::chart::page::{self, Format, Sheet};
use crate::chart::scaling;
use crate::chart::scaling::data::Growth;
use crate::chart::study;
use crate::chart::study::data::Study;
use crate::chart::study::sets::{Set, Subject};
use crate::clean::clean;
use crate::console;
use crate::driver::run;
use crate::failure::Failure;
use crate::load::is_stdio;
use crate::measure::json;
use crate::report::Reporter;

/// More would make a picture that nothing can show.
const MAX_CHARTS: usize = 100;

pub(super) fn chart(args: &ChartArgs, reporter: &Reporter) -> Result<u8, Failure> {
    let format = args.output.as_deref().map(Format::of).transpose()?;
    if args.scenes.iter().any(|scene| is_stdio(scene)) {
        let message = "charts are of files, whose names they show; the standard input has none";
        return Err(Failure::Usage(message.to_owned()));
    }
    let about = About::here();
    let (thread, two_threads, all_threads) = (run::threads(1)?, run::threads(2)?, run::threads(0)?);
    let bench = Bench {
        args,
        thread: &thread,
        two_threads: &two_threads,
        all_threads: &all_threads,
        about: &about,
        reporter,
    };
    match (&args.scaling, args.set.as_deref().and_then(Set::named)) {
        (Some(words), _) => growth(words, format, bench),
        (None, Some(set)) => study(set, format, bench),
        (None, None) => methods(format, bench),
    }
}

/// Charts of a set: of files if there are any, else measured.
fn study(set: &'static Set, format: Option<Format>, bench: Bench<'_>) -> Result<u8, Failure> {
    let Bench { args, reporter, .. } = bench;
    let (files, scenes): (Vec<_>, Vec<_>) =
        args.scenes.iter().cloned().partition(|input| is_data(input));
    check_subject(set, &files, &scenes)?;
    let mut all = Study { panels: Vec::new() };
    for file in &files {
        let new: Study = json::read(file, "data of `--set`")?;
        if new.panels.is_empty() {
            return Err(holds_nothing(file));
        }
        if let Some(other) = new.panels.iter().find(|panel| panel.set().name != set.name) {
            let (file, other) = (clean(&file.display().to_string()).into_owned(), other.set().name);
            return Err(Failure::Usage(format!("`{file}` is of the set `{other}`")));
        }
        all.panels.extend(new.panels);
    }
    let mut code = 0;
    if files.is_empty() || !scenes.is_empty() {
        let mut failed = |failure: Failure| {
            failure.message().inspect(|message| reporter.message(message));
            code = if code == 0 { failure.exit_code() } else { code };
        };
        all.panels.extend(study::measure(set, &scenes, bench, &mut failed)?.panels);
    }
    if !all.panels.is_empty() {
        print(args, &all)?;
        write(args, format, &all, all.panels.len())?;
    }
    Ok(code)
}

/// Fails if a set is asked to be measured on scenes that it is not of, or on none.
fn check_subject(set: &Set, files: &[PathBuf], scenes: &[PathBuf]) -> Result<(), Failure> {
    let is_of_scenes = matches!(set.subject, Subject::Scenes(_));
    let problem = match (is_of_scenes, scenes.is_empty()) {
        (true, true) if files.is_empty() => "is measured on scenes, and there are none",
        (false, false) => "is not measured on scenes",
        _ => return Ok(()),
    };
    Err(Failure::Usage(format!("`--set {}` {problem}", set.name)))
}

/// Whether an input is a file of measurements, by its name.
fn is_data(input: &Path) -> bool {
    input.extension().is_some_and(|extension| extension == "json")
}

/// Charts of methods.
fn methods(format: Option<Format>, bench: Bench<'_>) -> Result<u8, Failure> {
    let Bench { args, reporter, .. } = bench;
    let mut charts = Vec::new();
    let mut code = 0;
    for input in &args.scenes {
        match charts_of(input, bench) {
            Ok(new) => {
                let new = Data { charts: new };
                print(args, &new)?;
                charts.extend(new.charts);
            }
            Err(failure) => {
                failure.message().inspect(|message| reporter.message(message));
                code = if code == 0 { failure.exit_code() } else { code };
            }
        }
    }
    if !charts.is_empty() {
        let n = charts.len();
        write(args, format, &Data { charts }, n)?;
    }
    Ok(code)
}

/// Charts of growth.
fn growth(words: &[String], format: Option<Format>, bench: Bench<'_>) -> Result<u8, Failure> {
    let args = bench.args;
    let mut all = Growth { series: Vec::new() };
    if args.scenes.is_empty() {
        for series in scaling::measure::asked(words) {
            let new = Growth { series: vec![scaling::measure::measure(series, bench)?] };
            print(args, &new)?;
            all.series.extend(new.series);
        }
    }
    for input in &args.scenes {
        let new: Growth = json::read(input, "data of `--scaling`")?;
        if new.series.is_empty() {
            return Err(holds_nothing(input));
        }
        print(args, &new)?;
        all.series.extend(new.series);
    }
    let n = all.series.len();
    write(args, format, &all, n)?;
    Ok(0)
}

/// Prints tables, if the standard output is not for data.
fn print(args: &ChartArgs, new: &impl Sheet) -> Result<(), Failure> {
    if args.export.as_deref() == Some(Path::new("-")) {
        return Ok(());
    }
    let text: String = new.tables().iter().map(|table| table.text()).collect();
    console::data(|out| out.write_all(text.as_bytes()))
}

/// Writes the `n` charts, and their data, where the command line asks for them.
fn write(
    args: &ChartArgs,
    format: Option<Format>,
    data: &(impl Sheet + Serialize),
    n: usize,
) -> Result<(), Failure> {
    if let Some(path) = &args.export {
        json::write(path, data)?;
    }
    let (Some(path), Some(format)) = (&args.output, format) else { return Ok(()) };
    if n > MAX_CHARTS {
        let message = format!("a drawing has room for {MAX_CHARTS} charts, and these are {n}");
        return Err(Failure::Usage(message));
    }
    page::write(path, format, data)
}

/// The charts of a scene, measured, or those of a file.
fn charts_of(input: &Path, bench: Bench<'_>) -> Result<Vec<Chart>, Failure> {
    if is_data(input) {
        let Data { charts } = json::read(input, "data of a chart")?;
        if charts.is_empty() {
            return Err(holds_nothing(input));
        }
        return Ok(charts);
    }
    measure::measure(input, bench)
}

fn holds_nothing(input: &Path) -> Failure {
    let name = input.display().to_string();
    Failure::Usage(format!("`{}` holds no chart", clean(&name)))
}
