//! `gmlvm chart`: measures methods, or reads measurements, and writes tables, data and charts.

use std::path::Path;

use crate::args::ChartArgs;
use crate::chart::data::{About, Chart, Data};
use crate::chart::measure::{self, Bench};
use crate::chart::page::{self, Format};
use crate::chart::table;
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
    let (thread, all_threads) = (run::threads(1)?, run::threads(0)?);
    let bench = Bench { args, thread: &thread, all_threads: &all_threads, about: &about, reporter };
    let is_shown = args.export.as_deref() != Some(Path::new("-"));
    let mut charts = Vec::new();
    let mut code = 0;
    for input in &args.scenes {
        match charts_of(input, bench) {
            Ok(new) => {
                if is_shown {
                    let text: String = new.iter().map(table::text).collect();
                    console::data(|out| out.write_all(text.as_bytes()))?;
                }
                charts.extend(new);
            }
            Err(failure) => {
                failure.message().inspect(|message| reporter.message(message));
                code = if code == 0 { failure.exit_code() } else { code };
            }
        }
    }
    if charts.is_empty() {
        return Ok(code);
    }
    let data = Data { charts };
    if let Some(path) = &args.export {
        json::write(path, &data)?;
    }
    if let (Some(path), Some(format)) = (&args.output, format) {
        draw(path, format, &data)?;
    }
    Ok(code)
}

fn draw(path: &Path, format: Format, data: &Data) -> Result<(), Failure> {
    let n = data.charts.len();
    if n > MAX_CHARTS {
        let message = format!("a drawing has room for {MAX_CHARTS} charts, and these are {n}");
        return Err(Failure::Usage(message));
    }
    page::write(path, format, data)
}

/// The charts of a scene, measured, or those of a file.
fn charts_of(input: &Path, bench: Bench<'_>) -> Result<Vec<Chart>, Failure> {
    if input.extension().is_some_and(|extension| extension == "json") {
        let Data { charts } = json::read(input, "data of a chart")?;
        if charts.is_empty() {
            let name = input.display().to_string();
            return Err(Failure::Usage(format!("`{}` holds no chart", clean(&name))));
        }
        return Ok(charts);
    }
    measure::measure(input, bench)
}
