//! Drawing: a panel for each chart, what its marks mean, and where it was measured.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::chart::axes::{Axes, extent};
use crate::chart::data::{Chart, Data, Figures};
use crate::chart::front;
use crate::chart::methods::{Diagram, Family, Look, METHODS, Method, Shape};
use crate::chart::page::{Sheet, Spot};
use crate::chart::panel::{self, Frame};
use crate::chart::table::{self, ONE_THREAD, Table};

/// Pixels.
pub(super) const WIDTH: u32 = 800;
pub(super) const PANEL_HEIGHT: u32 = 360;
pub(super) const NOTES_HEIGHT: u32 = 58;
const LINE_HEIGHT: i32 = 15;
const LEGEND_COLUMNS: usize = 5;

pub(super) const FONT: &str = "sans-serif";
pub(super) const INK: RGBColor = RGBColor(34, 34, 34);
pub(super) const FAINT: RGBColor = RGBColor(221, 221, 221);
const FRONT: RGBColor = RGBColor(110, 110, 110);

pub(crate) type Area<B> = DrawingArea<B, Shift>;
/// From the left, and from above.
pub(crate) type Pixel = (i32, i32);
pub(crate) type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// Colours that those tell apart who see some colours alike (Okabe and Ito, "Color Universal
/// Design", 2008).
pub(super) fn color(family: Family) -> RGBColor {
    match family {
        Family::Doubles => RGBColor(0, 114, 178),
        Family::DoubleDoubles => RGBColor(213, 94, 0),
        Family::Balls => RGBColor(86, 180, 233),
        Family::NaiveDoubles => RGBColor(0, 158, 115),
        Family::NaiveSingles => RGBColor(204, 121, 167),
        Family::Grids => RGBColor(0, 0, 0),
        Family::Adaptive => RGBColor(0, 114, 178),
    }
}

impl Sheet for Data {
    fn title(&self) -> &'static str {
        "Work and precision"
    }

    fn size(&self) -> (u32, u32) {
        let n_panels = self.charts.len();
        size(n_panels, Layout::of(n_panels), &foot(self))
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>, told: &mut dyn FnMut(Spot)) -> Drawn<B> {
        let charts: Vec<_> = self.charts.iter().enumerate().collect();
        let draw_panel = |page: &Area<B>, panel: &Area<B>, (table, chart): &(usize, &Chart)| {
            draw_panel(page, panel, chart, &mut |name, at| told(Spot { table: *table, name, at }))
        };
        draw(area, &charts, Layout::of(charts.len()), draw_panel, &foot(self))
    }

    fn tables(&self) -> Vec<Table> {
        self.charts.iter().map(Table::of).collect()
    }

    fn captions(&self) -> Vec<String> {
        table::captions(self.charts.iter().map(|chart| &chart.about), ONE_THREAD)
    }
}

/// What something is drawn as, in legends.
pub(super) enum Sign {
    /// A mark, and whether it is filled.
    Mark(Look, bool),
    /// An area of a colour.
    Swatch(RGBColor),
}

/// How panels are laid out, all of one size.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub(super) n_columns: usize,
    /// In pixels.
    pub(super) panel_height: u32,
}

impl Layout {
    /// That of so many panels with axes.
    pub(super) fn of(n_panels: usize) -> Layout {
        Layout { n_columns: n_columns(n_panels), panel_height: PANEL_HEIGHT }
    }
}

/// What stands below all panels.
pub(super) struct Foot {
    pub(super) legend: Vec<(Sign, &'static str)>,
    pub(super) lines: Vec<String>,
}

impl Foot {
    fn height(&self) -> u32 {
        let n_lines = self.legend.len().div_ceil(LEGEND_COLUMNS) + self.lines.len();
        n_lines as u32 * LINE_HEIGHT as u32 + 20
    }
}

/// The size that a drawing of so many panels takes.
pub(super) fn size(n_panels: usize, layout: Layout, foot: &Foot) -> (u32, u32) {
    let n_rows = n_panels.div_ceil(layout.n_columns);
    let panels = (n_rows as u32).saturating_mul(layout.panel_height);
    (WIDTH, panels.saturating_add(foot.height()))
}

/// How many panels with axes stand side by side.
pub(super) fn n_columns(n_panels: usize) -> usize {
    n_panels.clamp(1, 2)
}

/// Draws all panels. `draw_panel` gets the area of the whole drawing, its own, and what to draw there.
///
/// # Errors
/// Those of the backend.
pub(super) fn draw<B: DrawingBackend, P>(
    area: &Area<B>,
    all: &[P],
    layout: Layout,
    mut draw_panel: impl FnMut(&Area<B>, &Area<B>, &P) -> Drawn<B>,
    foot: &Foot,
) -> Drawn<B> {
    area.fill(&WHITE)?;
    let (_, height) = area.dim_in_pixel();
    let (panels, foot_area) = area.split_vertically(height.saturating_sub(foot.height()));
    let n_rows = all.len().div_ceil(layout.n_columns);
    for (panel, of) in panels.split_evenly((n_rows.max(1), layout.n_columns)).iter().zip(all) {
        draw_panel(area, panel, of)?;
    }
    draw_foot(&foot_area, foot)
}

pub(super) fn text(size: u32) -> TextStyle<'static> {
    (FONT, size).into_font().color(&INK)
}

/// Draws a panel. `page` is the area of the whole drawing; `told` hears where the mark of each method is.
fn draw_panel<B: DrawingBackend>(
    page: &Area<B>,
    panel: &Area<B>,
    chart: &Chart,
    told: &mut dyn FnMut(&'static str, Pixel),
) -> Drawn<B> {
    let axes = Axes::new(chart);
    let heading = table::heading(chart);
    let zeros = Some(axes.zeros);
    let frame = Frame { heading: &heading, axes: axes.both(), titles: axes.titles(), zeros };
    let (at, notes) = panel::open(panel, frame)?;
    let left = axes.x[0];
    let small = text(10).pos(Pos::new(HPos::Left, VPos::Bottom));
    let label = |text: &str, place: (f64, f64)| {
        let (x, y) = at(place);
        page.draw_text(text, &small, (x + 4, y - 3))
    };
    if axes.has_zeros() {
        let (x, y) = at((left, f64::midpoint(axes.y[0], axes.zeros)));
        let style = text(11).pos(Pos::new(HPos::Right, VPos::Center));
        page.draw_text(&axes.zero_label(chart), &style, (x - 9, y))?;
    }
    if let Some(strip) = axes.strip {
        let ends = [axes.y[0], axes.y[1]].map(|y| at((strip, y)));
        page.draw(&PathElement::new(ends, FAINT))?;
        label("no image", (strip, axes.y[0]))?;
    }
    let points = points(chart, &axes);
    draw_points(page, &points, &at)?;
    points.iter().for_each(|point| told(point.method.name, at(point.place)));
    let failed: Vec<_> = chart.methods.iter().filter(|m| m.figures().is_none()).collect();
    for (index, measured) in failed.iter().enumerate() {
        let place = at(axes.cross(index, failed.len()));
        draw_cross(page, place, measured.method().look)?;
        told(measured.method().name, place);
    }
    draw_notes(&notes, &table::notes(chart))
}

fn draw_points<B: DrawingBackend>(
    page: &Area<B>,
    points: &[Point],
    at: &dyn Fn((f64, f64)) -> Pixel,
) -> Drawn<B> {
    let costs: Vec<_> = points.iter().map(|point| (point.cost, point.error)).collect();
    let front: Vec<_> =
        front::front(&costs).into_iter().map(|index| at(points[index].place)).collect();
    let step = |pair: &[Pixel]| [pair[0], (pair[1].0, pair[0].1), pair[1]];
    let stairs: Vec<_> = front.windows(2).flat_map(step).collect();
    page.draw(&PathElement::new(stairs, FRONT.stroke_width(2)))?;
    for Point { method, place: (x, y), extent, prepared, .. } in points {
        let color = color(method.look.family);
        page.draw(&PathElement::new(extent.map(|x| at((x, *y))), color))?;
        if prepared > x {
            let ends = [*x, *prepared].map(|x| at((x, *y)));
            page.draw(&PathElement::new(ends, color.mix(0.5)))?;
            draw_mark(page, ends[1], method.look, false)?;
        }
    }
    points.iter().try_for_each(|point| draw_mark(page, at(point.place), point.method.look, true))
}

/// A method's place in a panel.
struct Point {
    method: &'static Method,
    cost: f64,
    error: f64,
    place: (f64, f64),
    /// The fastest and the slowest round, and the cost with preparing, as places.
    extent: [f64; 2],
    prepared: f64,
}

fn points(chart: &Chart, axes: &Axes) -> Vec<Point> {
    let is_zero = |(method, figures)| chart.point(method, figures).1 <= 0.0;
    let n_zeros = chart.rendered().filter(|rendered| is_zero(*rendered)).count();
    let mut zeros = 0..;
    let point = |(method, figures): (&'static Method, &Figures)| {
        let (cost, error) = chart.point(method, figures);
        let index = if error > 0.0 { 0 } else { zeros.next().unwrap_or(0) };
        let y = axes.y_of(error, index, n_zeros);
        let (extent, prepared) = match chart.diagram {
            Diagram::Rounding => (extent(chart, figures), chart.cost(figures)[1]),
            Diagram::Sampling => ([cost; 2], cost),
        };
        Point {
            method,
            cost,
            error,
            place: (cost.log10(), y),
            extent: extent.map(f64::log10),
            prepared: prepared.log10(),
        }
    };
    chart.rendered().map(point).collect()
}

/// A mark around a place; hollow ones are white inside.
pub(super) fn draw_mark<B: DrawingBackend>(
    page: &Area<B>,
    (x, y): Pixel,
    look: Look,
    is_filled: bool,
) -> Drawn<B> {
    let color = color(look.family);
    let inside = if is_filled { color } else { WHITE };
    // Corners of marks of about one area.
    let corners: &[Pixel] = match look.shape {
        Shape::Circle => {
            page.draw(&Circle::new((x, y), 5, inside.filled()))?;
            return page.draw(&Circle::new((x, y), 5, color));
        }
        Shape::Square => &[(-4, -4), (4, -4), (4, 4), (-4, 4)],
        Shape::Diamond => &[(0, -6), (6, 0), (0, 6), (-6, 0)],
        Shape::Up => &[(0, -6), (6, 5), (-6, 5)],
        Shape::Down => &[(0, 6), (-6, -5), (6, -5)],
    };
    let mut outline: Vec<_> = corners.iter().map(|(right, down)| (x + right, y + down)).collect();
    page.draw(&Polygon::new(outline.clone(), inside.filled()))?;
    outline.push(outline[0]);
    page.draw(&PathElement::new(outline, color))
}

/// A cross for a method without an image, with its mark beside it.
pub(super) fn draw_cross<B: DrawingBackend>(page: &Area<B>, (x, y): Pixel, look: Look) -> Drawn<B> {
    page.draw(&Cross::new((x - 9, y), 5, color(look.family).stroke_width(2)))?;
    draw_mark(page, (x + 9, y), look, false)
}

/// Lines below a panel.
pub(super) fn draw_notes<B: DrawingBackend>(notes: &Area<B>, lines: &[String]) -> Drawn<B> {
    // Who reads an SVG may have a wider font.
    let (width, _) = notes.dim_in_pixel();
    let style = text(10);
    let mut y = 4;
    for line in lines {
        for part in wrapped(notes, line, &style, width * 5 / 6)? {
            notes.draw_text(&part, &style, (12, y))?;
            y += 13;
        }
    }
    Ok(())
}

/// A text in lines of a width.
fn wrapped<B: DrawingBackend>(
    area: &Area<B>,
    text: &str,
    style: &TextStyle<'_>,
    width: u32,
) -> Result<Vec<String>, DrawingAreaErrorKind<B::ErrorType>> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().expect("never empty");
        let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if line.is_empty() || area.estimate_text_size(&longer, style)?.0 <= width {
            *line = longer;
        } else {
            lines.push(word.to_owned());
        }
    }
    Ok(lines)
}

/// All methods that a drawing shows, in order.
fn shown_methods(data: &Data) -> Vec<&'static Method> {
    let is_shown = |method: &&Method| {
        data.charts.iter().flat_map(|chart| &chart.methods).any(|m| m.method == method.name)
    };
    METHODS.iter().filter(is_shown).collect()
}

fn foot(data: &Data) -> Foot {
    let legend =
        shown_methods(data).into_iter().map(|method| (Sign::Mark(method.look, true), method.name));
    let mut lines = vec![KEY.to_owned()];
    lines.extend(data.captions());
    Foot { legend: legend.collect(), lines }
}

fn draw_foot<B: DrawingBackend>(area: &Area<B>, foot: &Foot) -> Drawn<B> {
    let style = text(11);
    let mut y = 8;
    for entries in foot.legend.chunks(LEGEND_COLUMNS) {
        for (column, (sign, name)) in entries.iter().enumerate() {
            let x = 20 + column as i32 * (WIDTH as i32 - 20) / LEGEND_COLUMNS as i32;
            match sign {
                Sign::Mark(look, is_filled) => draw_mark(area, (x, y + 5), *look, *is_filled)?,
                Sign::Swatch(color) => {
                    let corners = [(x - 5, y), (x + 5, y + 10)];
                    area.draw(&Rectangle::new(corners, color.filled()))?;
                    area.draw(&Rectangle::new(corners, INK))?;
                }
            }
            area.draw_text(name, &style, (x + 12, y))?;
        }
        y += LINE_HEIGHT;
    }
    for line in &foot.lines {
        area.draw_text(line, &text(10), (12, y + 4))?;
        y += LINE_HEIGHT;
    }
    Ok(())
}

/// What marks mean.
const KEY: &str = "filled: tracing, with a bar from the fastest to the slowest round; hollow: with \
                   preparing; line: Pareto front; cross: no image";
