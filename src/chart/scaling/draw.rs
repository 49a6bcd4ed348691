//! Drawing growth: a panel for each series, both axes logarithmic.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::chart::axes::{Axis, padded, plain, range, short, ticks};
use crate::chart::draw::{
    self, Area, Drawn, FAINT, Foot, Layout, Sign, color, draw_mark, draw_notes, text,
};
use crate::chart::methods::{Family, Look, Shape};
use crate::chart::page::{Sheet, Spot};
use crate::chart::panel::{self, Frame};
use crate::chart::scaling::data::{Growth, Measured, Times};
use crate::chart::scaling::table;
use crate::chart::table::{ONE_THREAD, Table, captions};
use crate::measure::statistics::median;

/// The vertical axis spans at least this many powers of ten: what hardly grows should look so.
const LEAST_DECADES: f64 = 1.5;

/// What part of a panel's height is kept free above for crosses, if there are any.
const STRIP: f64 = 0.15;

const NANOSECONDS: f64 = 1e9;

/// What is drawn over the sizes: a line each.
struct Quantity {
    name: &'static str,
    look: Look,
    is_filled: bool,
    /// Whether it is drawn for series about solids only.
    is_of_solids: bool,
    /// Nanoseconds, by the median round, and from the least to the largest, of `n`.
    of: fn(u64, &Times) -> (f64, [f64; 2]),
}

const QUANTITIES: [Quantity; 3] = [
    Quantity {
        name: "tracing a ray",
        look: Look { family: Family::Doubles, shape: Shape::Circle },
        is_filled: true,
        is_of_solids: false,
        of: |_, times| in_nanoseconds(times.of_ray(), times.extent(), 1),
    },
    Quantity {
        name: "preparing a solid",
        look: Look { family: Family::DoubleDoubles, shape: Shape::Square },
        is_filled: false,
        is_of_solids: true,
        of: |n, times| of_each(&times.preparing, n),
    },
    Quantity {
        name: "the program, a solid",
        look: Look { family: Family::NaiveDoubles, shape: Shape::Diamond },
        is_filled: false,
        is_of_solids: true,
        of: |n, times| of_each(&times.program, n),
    },
];

fn of_each(seconds: &[f64], n: u64) -> (f64, [f64; 2]) {
    let all = || seconds.iter().copied();
    let extent = [all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max)];
    in_nanoseconds(median(seconds), extent, n)
}

fn in_nanoseconds(median: f64, extent: [f64; 2], n: u64) -> (f64, [f64; 2]) {
    let each = |seconds: f64| seconds / n as f64 * NANOSECONDS;
    (each(median), extent.map(each))
}

impl Sheet for Growth {
    fn title(&self) -> &'static str {
        "Growth"
    }

    fn size(&self) -> (u32, u32) {
        let n_panels = self.series.len();
        draw::size(n_panels, Layout::of(n_panels), &self.foot())
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>, _: &mut dyn FnMut(Spot)) -> Drawn<B> {
        draw::draw(area, &self.series, Layout::of(self.series.len()), draw_panel, &self.foot())
    }

    fn tables(&self) -> Vec<Table> {
        self.series.iter().map(table::table).collect()
    }

    fn captions(&self) -> Vec<String> {
        captions(self.series.iter().map(|measured| &measured.about), ONE_THREAD)
    }
}

/// What marks mean.
const KEY: &str = "medians of processor time, with a bar from the fastest to the slowest round; rays \
                   of all kinds; doubles, the engine auto; cross: no image";

impl Growth {
    fn foot(&self) -> Foot {
        let is_shown = |quantity: &&Quantity| {
            self.series.iter().any(|measured| quantity.is_shown_in(measured))
        };
        let shown = QUANTITIES.iter().filter(is_shown);
        let mut lines = vec![KEY.to_owned()];
        lines.extend(self.captions());
        Foot { legend: shown.map(|q| (Sign::Mark(q.look, q.is_filled), q.name)).collect(), lines }
    }
}

impl Quantity {
    fn is_shown_in(&self, measured: &Measured) -> bool {
        measured.series().is_about_solids || !self.is_of_solids
    }
}

/// A line of points: places, which are decimal logarithms, and how far each reaches up and down.
type Line = Vec<((f64, f64), [f64; 2])>;

/// The points of a quantity; times of zero, which the clock may give, have no place.
fn line(quantity: &Quantity, measured: &Measured) -> Line {
    let point = |(n, times): (u64, &Times)| {
        let (median, extent) = (quantity.of)(n, times);
        let is_drawn = median > 0.0 && extent[0] > 0.0;
        is_drawn.then(|| (((n as f64).log10(), median.log10()), extent.map(f64::log10)))
    };
    measured.rendered().filter_map(point).collect()
}

/// Draws a panel. `page` is the area of the whole drawing.
fn draw_panel<B: DrawingBackend>(page: &Area<B>, panel: &Area<B>, measured: &Measured) -> Drawn<B> {
    let lines: Vec<_> = QUANTITIES
        .iter()
        .filter(|quantity| quantity.is_shown_in(measured))
        .map(|quantity| (quantity, line(quantity, measured)))
        .collect();
    let failed: Vec<_> =
        measured.points.iter().filter(|point| point.times().is_none()).map(|p| p.n).collect();
    let [x_axis, y_axis] = axes(measured, &lines, !failed.is_empty());
    let top = y_axis.range[1];
    let strip = top - STRIP * (top - y_axis.range[0]);
    let [left, right] = x_axis.range;
    let heading = table::heading(measured);
    let titles = [measured.series().name, "nanoseconds"];
    let axes = [x_axis, y_axis];
    let frame = Frame { heading: &heading, axes, titles, zeros: None };
    let (at, notes) = panel::open(panel, frame)?;
    for (quantity, line) in &lines {
        draw_line(page, quantity, line, &at)?;
    }
    if !failed.is_empty() {
        page.draw(&PathElement::new([at((left, strip)), at((right, strip))], FAINT))?;
        let (x, y) = at((left, top));
        let style = text(10).pos(Pos::new(HPos::Left, VPos::Top));
        page.draw_text("no image", &style, (x + 4, y + 3))?;
    }
    for n in failed {
        let place = at(((n as f64).log10(), f64::midpoint(strip, top)));
        let style = color(QUANTITIES[0].look.family).stroke_width(2);
        page.draw(&Cross::new(place, 5, style))?;
    }
    draw_notes(&notes, &table::notes(measured))
}

fn draw_line<B: DrawingBackend>(
    page: &Area<B>,
    quantity: &Quantity,
    line: &Line,
    at: &dyn Fn((f64, f64)) -> draw::Pixel,
) -> Drawn<B> {
    let color = color(quantity.look.family);
    let places: Vec<_> = line.iter().map(|(place, _)| at(*place)).collect();
    page.draw(&PathElement::new(places.clone(), color.mix(0.5)))?;
    for ((x, _), extent) in line {
        page.draw(&PathElement::new(extent.map(|y| at((*x, y))), color))?;
    }
    let mut marks = places.into_iter();
    marks.try_for_each(|place| draw_mark(page, place, quantity.look, quantity.is_filled))
}

/// The axes that lines ask for, the horizontal one first; with a strip above for crosses.
fn axes(measured: &Measured, lines: &[(&Quantity, Line)], has_strip: bool) -> [Axis; 2] {
    let xs = measured.points.iter().map(|point| (point.n as f64).log10());
    let x = padded(range(xs.clone()), 0.0);
    let ys = lines.iter().flat_map(|(_, line)| line.iter().flat_map(|(_, extent)| *extent));
    let [bottom, highest] = padded(range(ys), LEAST_DECADES);
    let top =
        if has_strip { highest + STRIP / (1.0 - STRIP) * (highest - bottom) } else { highest };
    [
        Axis { range: x, ticks: xs.collect(), label: |tick| short(10_f64.powf(tick)) },
        Axis {
            range: [bottom, top],
            ticks: ticks(bottom, highest),
            label: |tick| plain(10_f64.powf(tick)),
        },
    ]
}
