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

    /// Draws them, with where they were measured. `told` hears where the marks are that stand for rows
    /// of tables.
    ///
    /// # Errors
    /// Those of the backend.
    fn draw<B: DrawingBackend>(&self, area: &Area<B>, told: &mut dyn FnMut(Spot)) -> Drawn<B>;

    /// The same as tables.
    fn tables(&self) -> Vec<Table>;

    /// Where they were measured: a line for each place.
    fn captions(&self) -> Vec<String>;
}

/// The place of a mark in a drawing, in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    /// The number of the table that it belongs to.
    pub(crate) table: usize,
    /// What is in the first column there.
    pub(crate) name: &'static str,
    pub(crate) at: draw::Pixel,
}

/// No drawing is higher, in pixels; one of a hundred charts of methods is half as high.
const MAX_HEIGHT: u32 = 1 << 15;

/// Writes charts.
///
/// # Errors
/// When it cannot be done, or they are too high.
pub(crate) fn write(path: &Path, format: Format, data: &impl Sheet) -> Result<(), Failure> {
    let (_, height) = data.size();
    if height > MAX_HEIGHT {
        return Err(Failure::Usage(format!(
            "the drawing would be {height} pixels high, and {MAX_HEIGHT} is the most; chart fewer \
             or lower images"
        )));
    }
    let target = Target::path(path.to_owned());
    match format {
        Format::Svg => {
            let (svg, _) = svg(data)?;
            target.write_plain(&mut |out| out.write_all(svg.as_bytes()))
        }
        Format::Png => {
            let picture = bitmap(data)?;
            target.write_plain(&mut |out| formats::write(ImageFormat::Png, &picture, out))
        }
        Format::Html => {
            let (svg, spots) = svg(data)?;
            target.write_plain(&mut |out| page(data, &svg, &spots, out))
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

/// The drawing as SVG, and its marks.
///
/// # Errors
/// When it cannot be drawn.
pub(crate) fn svg(data: &impl Sheet) -> Result<(String, Vec<Spot>), Failure> {
    register();
    let (mut svg, mut spots) = (String::new(), Vec::new());
    {
        let area = SVGBackend::with_string(&mut svg, data.size()).into_drawing_area();
        data.draw(&area, &mut |spot| spots.push(spot)).map_err(failed)?;
        area.present().map_err(failed)?;
    }
    Ok((svg, spots))
}

fn bitmap(data: &impl Sheet) -> Result<Picture, Failure> {
    register();
    let (width, height) = data.size();
    let [width, height] = [width, height].map(|length| FACTOR * length);
    let mut bytes = vec![0; 3 * width as usize * height as usize];
    {
        let area =
            Doubled(BitMapBackend::with_buffer(&mut bytes, (width, height))).into_drawing_area();
        data.draw(&area, &mut |_| {}).map_err(failed)?;
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
tr:target { background: #fe9; }
svg a { fill: transparent; }
svg a:hover, svg a:focus { stroke: #222; stroke-width: 2; outline: none; }
</style>
</head>
<body>
<h1>TITLE</h1>
";

/// What is that near a mark belongs to it, in pixels.
const RADIUS: u32 = 9;

/// A page that needs nothing from elsewhere. Marks lead to their rows.
fn page(data: &impl Sheet, svg: &str, spots: &[Spot], out: &mut dyn Write) -> io::Result<()> {
    let mut text = HEAD.replace("TITLE", data.title());
    let (drawing, end) = svg.split_at(svg.rfind("</svg>").unwrap_or(svg.len()));
    text.push_str(drawing);
    for Spot { table, name, at: (x, y) } in spots {
        let _ = writeln!(
            text,
            "<a href=\"#t{table}-{name}\"><circle cx=\"{x}\" cy=\"{y}\" r=\"{RADIUS}\"/>\
             <title>{name}</title></a>"
        );
    }
    text.push_str(end);
    for (table, Table { title, headings, rows, notes }) in data.tables().into_iter().enumerate() {
        let cells = |tag: &str, row: &[String]| {
            row.iter().fold(String::new(), |mut line, cell| {
                let _ = write!(line, "<{tag}>{}</{tag}>", escaped(cell));
                line
            })
        };
        let _ = writeln!(text, "\n<table>\n<caption>{}</caption>", escaped(&title));
        let _ = writeln!(text, "<tr>{}</tr>", cells("th", &headings));
        for row in rows {
            let spot = spots.iter().find(|spot| spot.table == table && spot.name == row[0]);
            let id = spot.map_or(String::new(), |spot| format!(" id=\"t{table}-{}\"", spot.name));
            let _ = writeln!(text, "<tr{id}>{}</tr>", cells("td", &row));
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
