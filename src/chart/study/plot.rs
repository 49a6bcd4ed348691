//! Drawing lines over what they depend on, and dots below a diagonal.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::chart::axes::{Axis, padded, plain, range, short};
use crate::chart::draw::{Area, Drawn, Pixel, color, draw_cross, draw_mark, draw_notes, text};
use crate::chart::methods::Family;
use crate::chart::panel::{self, Frame};
use crate::chart::study::data::{Curve, Dots, Item, Panel};
use crate::chart::study::sets::{Kind, Series};
use crate::chart::study::table;

/// Half a level of a byte, which is what an error must reach to be seen.
const HALF_A_LEVEL: f64 = 0.5 / 255.0;

/// What part of a panel's height is for errors of zero.
const BAND: f64 = 0.12;

const LINE: RGBColor = RGBColor(110, 110, 110);

/// At most so many numbers stand beside an axis.
const MAX_TICKS: f64 = 8.0;

/// An axis of powers of ten.
fn decades(range: [f64; 2], from: f64, label: fn(f64) -> String) -> Axis {
    let [low, high] = [from.ceil() as i32, range[1].floor() as i32];
    let step = ((range[1] - from) / MAX_TICKS).ceil().max(1.0) as usize;
    Axis { range, ticks: (low..=high).step_by(step).map(f64::from).collect(), label }
}

/// An axis of multiples of ten.
fn tens(range: [f64; 2]) -> Axis {
    let [low, high] = range;
    let step = 10.0 * (high / (10.0 * MAX_TICKS)).ceil().max(1.0);
    let all = (0..).map(|n| f64::from(n) * step);
    let ticks = all.take_while(|tick| *tick <= high).filter(|tick| *tick >= low).collect();
    Axis { range, ticks, label: |tick| format!("{tick}") }
}

/// A power of ten, as short as it gets.
fn power(exponent: f64) -> String {
    if (-3.0..=3.0).contains(&exponent) {
        plain(10_f64.powf(exponent))
    } else {
        format!("1e{exponent}")
    }
}

/// The vertical axis for these errors, and where its band of zeros ends.
fn errors_axis(errors: [f64; 2], label: fn(f64) -> String) -> (Axis, f64) {
    let [bottom, top] = padded(errors, 1.0);
    let band = BAND / (1.0 - BAND) * (top - bottom);
    (decades([bottom - band, top], bottom, label), bottom)
}

/// The place of an error.
fn y_of(error: f64, zeros: f64, axis: [f64; 2]) -> f64 {
    if error > 0.0 { error.log10() } else { f64::midpoint(zeros, axis[0]) }
}

pub(super) fn draw_curves<B: DrawingBackend>(
    page: &Area<B>,
    area: &Area<B>,
    panel: &Panel,
    items: &[Item<Curve>],
) -> Drawn<B> {
    let curves = || items.iter().filter_map(|item| Some((series(item)?, item.figures()?)));
    let points = || curves().flat_map(|(_, curve)| curve.points.iter().copied());
    let found = range(points().filter(|[_, y]| *y > 0.0).map(|[_, y]| y.log10()));
    let percent = |tick: f64| format!("{} %", plain(10_f64.powf(tick + 2.0)));
    let (errors, label): (_, fn(f64) -> String) = match panel.kind {
        // From a line in all.
        Kind::Misses => ([found[0].min(-3.0), 0.0], percent),
        _ => (found, power),
    };
    let (y_axis, zeros) = errors_axis(errors, label);
    let is_linear = panel.kind == Kind::Bounces;
    let x_of = |x: f64| if is_linear { x } else { x.log10() };
    let [low, high] = padded(range(points().map(|[x, _]| x_of(x))), 0.0);
    let (x_axis, x_title) = if is_linear {
        (tens([low, high]), "reflections")
    } else {
        let label = |tick: f64| short(10_f64.powf(tick));
        (decades([low, high], low, label), "distance in radii")
    };
    let y_title = match panel.kind {
        Kind::Misses => "lines",
        Kind::Bounces => "error, of the width of the room",
        _ => "error",
    };
    let y_range = y_axis.range;
    let frame = Frame {
        heading: panel.heading(),
        axes: [x_axis, y_axis],
        titles: [x_title, y_title],
        zeros: Some(zeros),
    };
    let (at, notes) = panel::open(area, frame)?;
    label_zeros(page, &at, [low, f64::midpoint(zeros, y_range[0])])?;
    if panel.kind == Kind::Bounces {
        let y = HALF_A_LEVEL.log10();
        page.draw(&PathElement::new([at((low, y)), at((high, y))], LINE))?;
        let (x, y) = at((low, y));
        let style = text(10).pos(Pos::new(HPos::Left, VPos::Bottom));
        page.draw_text("half a level of a byte", &style, (x + 4, y - 2))?;
    }
    for (series, curve) in curves() {
        let place = |[x, y]: &[f64; 2]| at((x_of(*x), y_of(*y, zeros, y_range)));
        let places: Vec<Pixel> = curve.points.iter().map(place).collect();
        page.draw(&PathElement::new(places.clone(), color(series.look.family)))?;
        // Marks that touch one another hide the line.
        let step = if is_linear { 5 } else { 1 };
        let mut marks = places.into_iter().step_by(step);
        marks.try_for_each(|place| draw_mark(page, place, series.look, series.is_filled))?;
    }
    let failed = items.iter().filter(|item| item.figures().is_none()).filter_map(series);
    for (index, series) in failed.enumerate() {
        let (x, y) = at((high, y_range[1]));
        draw_cross(page, (x - 24, y + 12 + 16 * index as i32), series.look)?;
    }
    draw_notes(&notes, &table::notes(panel))
}

fn series<F>(item: &Item<F>) -> Option<&'static Series> {
    Series::named(&item.name)
}

fn label_zeros<B: DrawingBackend>(
    page: &Area<B>,
    at: &dyn Fn((f64, f64)) -> Pixel,
    [x, y]: [f64; 2],
) -> Drawn<B> {
    let (x, y) = at((x, y));
    let style = text(11).pos(Pos::new(HPos::Right, VPos::Center));
    page.draw_text("0", &style, (x - 9, y))
}

pub(super) fn draw_dots<B: DrawingBackend>(
    page: &Area<B>,
    area: &Area<B>,
    panel: &Panel,
    items: &[Item<Dots>],
) -> Drawn<B> {
    let points = || items.iter().filter_map(Item::figures).flat_map(|dots| dots.points.iter());
    // What is exact without a bound has no place.
    let shown = || points().copied().filter(|[bound, _]| *bound > 0.0);
    let bounds = padded(range(shown().map(|[bound, _]| bound.log10())), 1.0);
    let errors = range(shown().filter(|[_, y]| *y > 0.0).map(|[_, y]| y.log10()));
    let (y_axis, zeros) = errors_axis([errors[0], errors[1].max(bounds[0])], power);
    let y_range = y_axis.range;
    let frame = Frame {
        heading: panel.heading(),
        axes: [decades(bounds, bounds[0], power), y_axis],
        titles: ["off by at most", "off by"],
        zeros: Some(zeros),
    };
    let (at, notes) = panel::open(area, frame)?;
    label_zeros(page, &at, [bounds[0], f64::midpoint(zeros, y_range[0])])?;
    let ends = [bounds[0].max(zeros), bounds[1].min(y_range[1])];
    page.draw(&PathElement::new(ends.map(|end| at((end, end))), LINE))?;
    for [bound, error] in shown() {
        let is_unsound = error > bound;
        let family = if is_unsound { Family::DoubleDoubles } else { Family::Doubles };
        let place = at((bound.log10(), y_of(error, zeros, y_range)));
        page.draw(&Circle::new(place, 1, color(family).filled()))?;
    }
    if items.iter().all(|item| item.figures().is_none()) {
        let place = at((f64::midpoint(bounds[0], bounds[1]), f64::midpoint(zeros, y_range[1])));
        page.draw(&Cross::new(place, 5, color(Family::Balls).stroke_width(2)))?;
    }
    draw_notes(&notes, &table::notes(panel))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_not_crowded() {
        for width in [1.0, 8.0, 40.0, 600.0] {
            let axis = decades([-width, 0.0], -width, power);
            assert!((2..=9).contains(&axis.ticks.len()), "{width}: {:?}", axis.ticks);
        }
        for high in [1.0, 80.0, 81.0, 1e4, 1e12, f64::MAX] {
            let axis = tens([1.0, high]);
            assert!(axis.ticks.len() <= 8, "{high}: {:?}", axis.ticks);
        }
        assert_eq!(tens([1.0, 64.0]).ticks, [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]);
        assert_eq!([-17.0, -2.0, 0.0].map(power), ["1e-17", "0.01", "1"]);
    }
}
