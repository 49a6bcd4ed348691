//! Drawing rows: shares, times, counts in cells, and which pixels differ.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use renderer::certify::Certainty;
use renderer::shade::Doubt;

use crate::chart::draw::{Area, Drawn, FAINT, INK, WIDTH, color, text};
use crate::chart::methods::Family;
use crate::chart::panel::FRAME_LEFT;
use crate::chart::study::data::{Case, Cells, Item, Mark, Mask, Pair, Panel, Shares};
use crate::chart::study::sets::Kind;
use crate::measure::time;
use crate::run::certainty;

/// Pixels.
const HEADING: i32 = 34;
const ROW: i32 = 18;
const CELL_ROW: i32 = 13;
/// What names take from the left, and numbers from the right.
const NAMES: i32 = 160;
const NUMBERS: i32 = 120;
const MASK_COLUMNS: usize = 4;
const MASK_GAP: i32 = 8;

/// How pixels are known, in the order of [`Shares::counts`].
pub(super) const SHARES: [RGBColor; 6] = [
    RGBColor(190, 190, 190),
    RGBColor(96, 96, 96),
    of_certainty(Certainty::Rule(Doubt::Boundary)),
    of_certainty(Certainty::Rule(Doubt::Light)),
    of_certainty(Certainty::Rule(Doubt::Surface)),
    of_certainty(Certainty::Rule(Doubt::Color)),
];

/// The colour of `--mark-uncertain`.
const fn of_certainty(certainty: Certainty) -> RGBColor {
    let [red, green, blue] = certainty::color(&certainty);
    RGBColor(red, green, blue)
}

/// The colour of a pixel that differs.
pub(super) fn color_of(mark: Mark) -> RGBColor {
    match mark {
        Mark::Same => WHITE,
        Mark::Certain => BLACK,
        Mark::Boundary => SHARES[2],
        Mark::Light => SHARES[3],
        Mark::Surface => SHARES[4],
        Mark::Color => SHARES[5],
    }
}

/// The height that so many rows take.
pub(super) fn height(n_rows: usize) -> u32 {
    (HEADING + ROW * n_rows as i32 + 14) as u32
}

pub(super) fn cells_height(n_cases: usize) -> u32 {
    (HEADING + CELL_ROW * (n_cases as i32 + 1) + 14) as u32
}

pub(super) fn masks_height(items: &[Item<Mask>]) -> u32 {
    let n_rows = items.len().div_ceil(MASK_COLUMNS) as u32;
    let tallest = items.iter().filter_map(Item::figures).map(|mask| mask_size(mask)[1]).max();
    HEADING as u32 + n_rows * (tallest.unwrap_or(0) + 2 * CELL_ROW as u32)
}

/// The area's heading.
fn head<B: DrawingBackend>(area: &Area<B>, panel: &Panel) -> Drawn<B> {
    area.draw_text(panel.heading(), &text(14), (FRAME_LEFT, 10))
}

/// The name of a row, right before its bar.
fn name<B: DrawingBackend>(area: &Area<B>, name: &str, y: i32) -> Drawn<B> {
    let style = text(11).pos(Pos::new(HPos::Right, VPos::Center));
    // The end of a path tells more than its beginning.
    let short = name.rsplit('/').next().unwrap_or(name);
    area.draw_text(short, &style, (NAMES - 8, y))
}

/// A text right of a row's bar, or where the bar would be.
fn number<B: DrawingBackend>(area: &Area<B>, number: &str, (x, y): (i32, i32)) -> Drawn<B> {
    area.draw_text(number, &text(10).pos(Pos::new(HPos::Left, VPos::Center)), (x, y))
}

fn bar<B: DrawingBackend>(
    area: &Area<B>,
    [from, to]: [i32; 2],
    y: i32,
    fill: RGBColor,
) -> Drawn<B> {
    let corners = [(from, y - ROW / 3), (to, y + ROW / 3)];
    area.draw(&Rectangle::new(corners, fill.filled()))
}

/// The middle of a row.
fn row(index: usize) -> i32 {
    HEADING + ROW * index as i32 + ROW / 2
}

/// Where bars end at most.
fn right<B: DrawingBackend>(area: &Area<B>) -> i32 {
    let (width, _) = area.dim_in_pixel();
    width as i32 - NUMBERS
}

/// A cross, and why, in the place of a bar.
fn failed<B: DrawingBackend>(area: &Area<B>, why: Option<String>, y: i32) -> Drawn<B> {
    let cross = Cross::new((NAMES + 8, y), 5, color(Family::DoubleDoubles).stroke_width(2));
    area.draw(&cross)?;
    number(area, &why.unwrap_or_default(), (NAMES + 20, y))
}

pub(super) fn draw_shares<B: DrawingBackend>(
    area: &Area<B>,
    panel: &Panel,
    items: &[Item<Shares>],
) -> Drawn<B> {
    head(area, panel)?;
    let right = right(area);
    for (index, item) in items.iter().enumerate() {
        let y = row(index);
        name(area, &item.name, y)?;
        let Some(shares) = item.figures() else {
            failed(area, item.outcome.failure(), y)?;
            continue;
        };
        let (counts, total) = (shares.counts(), shares.known.total() as f64);
        let place = |n: u64| NAMES + (f64::from(right - NAMES) * n as f64 / total).round() as i32;
        let mut before = 0;
        for (count, fill) in counts.into_iter().zip(SHARES) {
            let after = before + count;
            // What there is can be seen, however little it is.
            let ends = [place(before).min(right - 1), place(after).max(place(before) + 1)];
            if count > 0 {
                bar(area, ends, y, fill)?;
            }
            before = after;
        }
        let outline = [(NAMES, y - ROW / 3), (right, y + ROW / 3)];
        area.draw(&Rectangle::new(outline, INK))?;
        number(area, &format!("{:.1} times", shares.overhead().estimate), (right + 8, y))?;
    }
    Ok(())
}

pub(super) fn draw_pairs<B: DrawingBackend>(
    area: &Area<B>,
    panel: &Panel,
    items: &[Item<Pair>],
) -> Drawn<B> {
    head(area, panel)?;
    let right = right(area);
    let is_of_threads = panel.kind == Kind::Threads;
    let values = |pair: &Pair| if is_of_threads { pair.gains() } else { pair.of_pixel() };
    let all = || items.iter().filter_map(Item::figures).map(values);
    let longest = all().map(|[_, _, most]| most).fold(f64::MIN_POSITIVE, f64::max);
    let place = |x: f64| NAMES + (f64::from(right - NAMES) * (x / longest)).round() as i32;
    for (index, item) in items.iter().enumerate() {
        let y = row(index);
        name(area, &item.name, y)?;
        let Some(pair) = item.figures() else {
            failed(area, item.outcome.failure(), y)?;
            continue;
        };
        let [least, middle, most] = values(pair);
        bar(area, [NAMES, place(middle)], y, color(Family::Balls))?;
        area.draw(&PathElement::new([(place(least), y), (place(most), y)], INK))?;
        let times = format!("{:.2} times", pair.gain().estimate);
        let shown = match pair.more_work() {
            Some(work) => format!("{times}, work {:.2}", work.estimate),
            None => format!("{}, {times}", time(middle)),
        };
        number(area, &shown, (right + 8, y))?;
    }
    // Two threads are not worth more than two.
    let marks = if is_of_threads { vec![1.0, 2.0] } else { Vec::new() };
    for x in marks.into_iter().filter(|x| *x <= longest).map(place) {
        area.draw(&PathElement::new([(x, HEADING), (x, row(items.len()) - ROW / 2)], INK))?;
    }
    Ok(())
}

pub(super) fn draw_cells<B: DrawingBackend>(
    area: &Area<B>,
    panel: &Panel,
    cases: &[Case],
    items: &[Item<Cells>],
) -> Drawn<B> {
    head(area, panel)?;
    let width = (WIDTH as i32 - NAMES - 12) / items.len() as i32;
    let middle = Pos::new(HPos::Center, VPos::Center);
    let y = |index: usize| HEADING + CELL_ROW * index as i32;
    for (index, case) in cases.iter().enumerate() {
        let style = text(10).pos(Pos::new(HPos::Right, VPos::Center));
        let place = (NAMES - 8, y(index + 1) + CELL_ROW / 2);
        area.draw_text(&case.name, &style, place)?;
    }
    for (column, item) in items.iter().enumerate() {
        let x = NAMES + width * column as i32;
        let at = (x + width / 2, y(0) + CELL_ROW / 2);
        area.draw_text(&item.name, &text(9).pos(middle), at)?;
        let Some(cells) = item.figures() else {
            area.draw(&Cross::new((at.0, y(1) + CELL_ROW / 2), 5, INK))?;
            continue;
        };
        for (index, wrong) in cells.wrong.iter().enumerate() {
            let (fill, ink) = heat(*wrong);
            let corners = [(x, y(index + 1)), (x + width, y(index + 2))];
            area.draw(&Rectangle::new(corners, fill.filled()))?;
            area.draw(&Rectangle::new(corners, FAINT))?;
            if *wrong > 0 {
                let style = TextStyle { color: ink.to_backend_color(), ..text(9).pos(middle) };
                let place = (x + width / 2, y(index + 1) + CELL_ROW / 2);
                area.draw_text(&wrong.to_string(), &style, place)?;
            }
        }
    }
    Ok(())
}

/// From pale for one to dark for ten thousand, by the logarithm, and what can be read upon it.
fn heat(n: u64) -> (RGBColor, RGBColor) {
    if n == 0 {
        return (WHITE, INK);
    }
    let share = ((n as f64).log10() / 4.0).min(1.0);
    let between =
        |from: u8, to: u8| (f64::from(from) + share * (f64::from(to) - f64::from(from))) as u8;
    let fill = RGBColor(between(255, 140), between(225, 20), between(190, 0));
    (fill, if share > 0.5 { WHITE } else { INK })
}

/// Pixels of a drawing for one of a mask, so that four fit side by side; more than fit are left out.
fn mask_scale(mask: &Mask) -> u32 {
    let room = WIDTH / MASK_COLUMNS as u32 - 2 * MASK_GAP as u32;
    (room / mask.size()[0]).max(1)
}

fn mask_size(mask: &Mask) -> [u32; 2] {
    mask.size().map(|length| length * mask_scale(mask))
}

pub(super) fn draw_masks<B: DrawingBackend>(
    area: &Area<B>,
    panel: &Panel,
    items: &[Item<Mask>],
) -> Drawn<B> {
    head(area, panel)?;
    let tallest = items.iter().filter_map(Item::figures).map(|mask| mask_size(mask)[1]).max();
    let step = (tallest.unwrap_or(0) as i32) + 2 * CELL_ROW;
    for (index, item) in items.iter().enumerate() {
        let x = MASK_GAP + (index % MASK_COLUMNS) as i32 * (WIDTH / MASK_COLUMNS as u32) as i32;
        let y = HEADING + (index / MASK_COLUMNS) as i32 * step;
        let Some(mask) = item.figures() else {
            let why = item.outcome.failure().unwrap_or_default();
            area.draw_text(&format!("{}: {why}", item.name), &text(10), (x, y))?;
            area.draw(&Cross::new((x + 8, y + 24), 5, INK.stroke_width(2)))?;
            continue;
        };
        let n = mask.different().count();
        area.draw_text(&format!("{}: {n}", item.name), &text(10), (x, y))?;
        draw_mask(area, mask, (x, y + CELL_ROW + 2))?;
    }
    Ok(())
}

fn draw_mask<B: DrawingBackend>(area: &Area<B>, mask: &Mask, (left, top): (i32, i32)) -> Drawn<B> {
    let [width, height] = mask_size(mask).map(|length| length as i32);
    let ground = Rectangle::new([(left, top), (left + width, top + height)], FAINT.filled());
    area.draw(&ground)?;
    let scale = mask_scale(mask) as i32;
    let mut different = mask.different().peekable();
    while let Some((x, y, mark)) = different.next() {
        let mut end = x + 1;
        while different.next_if(|next| *next == (end, y, mark)).is_some() {
            end += 1;
        }
        let [from, to, y] = [x, end, y].map(|n| n as i32 * scale);
        let corners = [(left + from, top + y), (left + to, top + y + scale)];
        area.draw(&Rectangle::new(corners, color_of(mark).filled()))?;
    }
    Ok(())
}
