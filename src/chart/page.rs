//! Charts as files: a drawing in SVG or PNG, or a page of a drawing and tables.

use std::fmt::{Display, Write as _};
use std::io::{self, Write};
use std::path::Path;
use std::sync::Once;

use plotters::prelude::{BitMapBackend, DrawingBackend, IntoDrawingArea, SVGBackend};
use plotters::style::{FontStyle, register_font};

use crate::args::ImageFormat;
use crate::chart::doubled::{Doubled, FACTOR};
use crate::chart::draw::{self, Area, Drawn};
use crate::chart::table::Table;
use crate::failure::Failure;
use crate::formats::{self, Picture, Pixels};
use crate::output::Target;

/// Roboto, by Google, under the Apache License 2.0; only what texts in English ask for. Backends take
/// it for the measure of texts, and the one for pixels draws it; what reads an SVG takes its own.
const FONT: &[u8] = include_bytes!("font/roboto-subset.ttf");

/// What a chart is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Svg,
    Png,
    Html,
}

impl Format {
    /// The format that a file's name asks for.
    ///
    /// # Errors
    /// When it is none of these.
    pub(crate) fn of(path: &Path) -> Result<Format, Failure> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => Ok(Format::Svg),
            Some("png") => Ok(Format::Png),
            Some("html") => Ok(Format::Html),
            _ => Err(Failure::Usage(format!(
                "charts are written as .svg, .png or .html, and `{}` is none of these",
                crate::clean::clean(&path.display().to_string())
            ))),
        }
    }
}

/// Measurements as they are shown.
pub(crate) trait Sheet {
    /// What they are about.
    fn title(&self) -> &'static str;

    /// The size that a drawing of them takes.
    fn size(&self) -> (u32, u32);

    /// Draws them, with where they were measured.
    ///
    /// # Errors
    /// Those of the backend.
    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B>;

    /// The same as tables.
    fn tables(&self) -> Vec<Table>;

    /// Where they were measured: a line for each place.
    fn captions(&self) -> Vec<String>;
}

/// Writes charts.
///
/// # Errors
/// When it cannot be done.
pub(crate) fn write(path: &Path, format: Format, data: &impl Sheet) -> Result<(), Failure> {
    let target = Target::path(path.to_owned());
    match format {
        Format::Svg => {
            let svg = svg(data)?;
            target.write_plain(&mut |out| out.write_all(svg.as_bytes()))
        }
        Format::Png => {
            let picture = bitmap(data)?;
            target.write_plain(&mut |out| formats::write(ImageFormat::Png, &picture, out))
        }
        Format::Html => {
            let svg = svg(data)?;
            target.write_plain(&mut |out| page(data, &svg, out))
        }
    }
}

fn failed(error: impl Display) -> Failure {
    Failure::Output(format!("could not draw the chart: {error}"))
}

fn register() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let registered = register_font(draw::FONT, FontStyle::Normal, FONT);
        assert!(registered.is_ok(), "the font is part of the program");
    });
}

/// The drawing as SVG.
///
/// # Errors
/// When it cannot be drawn.
pub(crate) fn svg(data: &impl Sheet) -> Result<String, Failure> {
    register();
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, data.size()).into_drawing_area();
        data.draw(&area).map_err(failed)?;
        area.present().map_err(failed)?;
    }
    Ok(svg)
}

fn bitmap(data: &impl Sheet) -> Result<Picture, Failure> {
    register();
    let (width, height) = data.size();
    let [width, height] = [width, height].map(|length| FACTOR * length);
    let mut bytes = vec![0; 3 * (width * height) as usize];
    {
        let area =
            Doubled(BitMapBackend::with_buffer(&mut bytes, (width, height))).into_drawing_area();
        data.draw(&area).map_err(failed)?;
        area.present().map_err(failed)?;
    }
    let (pixels, _) = bytes.as_chunks();
    Ok(Picture { width, height, pixels: Pixels::Bytes(pixels.to_vec()) })
}

/// The beginning of a page, with its title where `TITLE` is.
const HEAD: &str = "\
<!DOCTYPE html>
<html lang=\"en\">
<head>
<meta charset=\"utf-8\">
<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">
<title>gmlvm: TITLE</title>
<style>
body { font: 15px/1.4 sans-serif; color: #222; background: #fff; max-width: 60em; margin: 2em auto; padding: 0 1em; }
svg { max-width: 100%; height: auto; }
table { border-collapse: collapse; font-size: 13px; }
caption { text-align: left; font-weight: bold; padding: 1.5em 0 0.5em; }
th, td { padding: 0.2em 0.8em; text-align: right; border-bottom: 1px solid #ddd; white-space: nowrap; }
th:first-child, td:first-child, th:last-child, td:last-child { text-align: left; }
td:last-child { white-space: normal; }
</style>
</head>
<body>
<h1>TITLE</h1>
";

/// A page that needs nothing from elsewhere.
fn page(data: &impl Sheet, svg: &str, out: &mut dyn Write) -> io::Result<()> {
    let mut text = HEAD.replace("TITLE", data.title());
    text.push_str(svg);
    for Table { title, headings, rows, notes } in data.tables() {
        let cells = |tag: &str, row: &[String]| {
            row.iter().fold(String::new(), |mut line, cell| {
                let _ = write!(line, "<{tag}>{}</{tag}>", escaped(cell));
                line
            })
        };
        let _ = writeln!(text, "\n<table>\n<caption>{}</caption>", escaped(&title));
        let _ = writeln!(text, "<tr>{}</tr>", cells("th", &headings));
        for row in rows {
            let _ = writeln!(text, "<tr>{}</tr>", cells("td", &row));
        }
        text.push_str("</table>\n");
        push_paragraphs(&mut text, &notes);
    }
    push_paragraphs(&mut text, &data.captions());
    text.push_str("</body>\n</html>\n");
    out.write_all(text.as_bytes())
}

fn push_paragraphs(text: &mut String, lines: &[String]) {
    for line in lines {
        let _ = writeln!(text, "<p>{}</p>", escaped(line));
    }
}

/// A text as a page holds it.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
