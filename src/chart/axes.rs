//! The axes of a panel: both logarithmic, with a band for errors of zero and a strip for methods
//! that gave no image.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use crate::chart::data::{Chart, Figures};
use crate::chart::methods::Diagram;

/// What part of an axis is kept free beyond the outermost points.
const MARGIN: f64 = 0.06;

/// What part of the vertical axis the band of zeros takes, and of the horizontal one the strip.
const BAND: f64 = 0.2;
const STRIP: f64 = 0.15;

/// The axes of a panel. All places are decimal logarithms.
pub(super) struct Axes {
    pub(super) x: [f64; 2],
    /// From the bottom of the band of zeros.
    pub(super) y: [f64; 2],
    /// Top of the band of zeros.
    pub(super) zeros: f64,
    /// Where the strip begins, if there is one.
    pub(super) strip: Option<f64>,
    /// Where all points are, if they can only be at some places.
    places: Vec<f64>,
    diagram: Diagram,
}

impl Axes {
    /// The axes that a chart's points ask for.
    pub(super) fn new(chart: &Chart) -> Self {
        let points = || chart.rendered().map(|(method, figures)| chart.point(method, figures));
        let xs = chart.rendered().flat_map(|(method, figures)| {
            let [fastest, slowest] = extent(chart, figures);
            match chart.diagram {
                Diagram::Rounding => vec![fastest, slowest, chart.cost(figures)[1]],
                Diagram::Sampling => vec![chart.point(method, figures).0],
            }
        });
        let [low, high] = padded(range(xs.map(f64::log10)), 0.0);
        let has_failures = chart.methods.iter().any(|m| m.figures().is_none());
        let right = if has_failures { high + STRIP / (1.0 - STRIP) * (high - low) } else { high };

        let pixel = -(chart.pixels as f64).log10();
        let errors = points().map(|(_, error)| error).filter(|error| *error > 0.0);
        let [bottom, top] = match chart.diagram {
            Diagram::Rounding => padded([pixel, 0.0], 0.0),
            Diagram::Sampling => padded(range(errors.map(f64::log10)), 1.0),
        };
        let has_zeros =
            chart.diagram == Diagram::Rounding || points().any(|(_, error)| error <= 0.0);
        let band = if has_zeros { BAND / (1.0 - BAND) * (top - bottom) } else { 0.0 };
        let places = match chart.diagram {
            Diagram::Rounding => Vec::new(),
            // Those of grids, whose numbers of rays are squares.
            Diagram::Sampling => points()
                .map(|(cost, _)| cost)
                .filter(|cost| cost.sqrt().fract() == 0.0)
                .map(f64::log10)
                .collect(),
        };
        Axes {
            x: [low, right],
            y: [bottom - band, top],
            zeros: bottom,
            strip: has_failures.then_some(high),
            places,
            diagram: chart.diagram,
        }
    }

    /// Whether there is a band of zeros.
    pub(super) fn has_zeros(&self) -> bool {
        self.y[0] < self.zeros
    }

    /// Where to write numbers: at those of grids of rays if there are any, else at 1, 2, 5, 10 and so
    /// on.
    fn x_ticks(&self) -> Vec<f64> {
        let high = self.strip.unwrap_or(self.x[1]);
        if self.places.is_empty() { ticks(self.x[0], high) } else { self.places.clone() }
    }

    fn y_ticks(&self) -> Vec<f64> {
        ticks(self.zeros, self.y[1])
    }

    /// Both, the horizontal one first.
    pub(super) fn both(&self) -> [Axis; 2] {
        let number = |tick: f64| plain(10_f64.powf(tick));
        let percent = |tick: f64| format!("{} %", plain(10_f64.powf(tick + 2.0)));
        let y_label = match self.diagram {
            Diagram::Rounding => percent,
            Diagram::Sampling => number,
        };
        [
            Axis { range: self.x, ticks: self.x_ticks(), label: number },
            Axis { range: self.y, ticks: self.y_ticks(), label: y_label },
        ]
    }

    /// What the axes show.
    pub(super) fn titles(&self) -> [&'static str; 2] {
        match self.diagram {
            Diagram::Rounding => {
                ["processor seconds for a million pixels", "pixels with any byte off"]
            }
            Diagram::Sampling => ["rays for each pixel", "difference in linear light (RMS)"],
        }
    }

    /// The label of the band of zeros.
    pub(super) fn zero_label(&self, chart: &Chart) -> String {
        match self.diagram {
            Diagram::Rounding => format!("0 of {}", chart.pixels),
            Diagram::Sampling => "0".to_owned(),
        }
    }

    /// The place of an error; zeros are spread over their band, this one being the `index`th of
    /// `n`, so that none hides another.
    pub(super) fn y_of(&self, error: f64, index: usize, n: usize) -> f64 {
        if error > 0.0 {
            return error.log10().min(self.y[1]);
        }
        let share = (index as f64 + 1.0) / (n as f64 + 1.0);
        self.zeros - share * (self.zeros - self.y[0])
    }

    /// The place of the `index`th of `n` crosses in the strip.
    pub(super) fn cross(&self, index: usize, n: usize) -> (f64, f64) {
        let share = (index as f64 + 1.0) / (n as f64 + 2.0);
        let x = f64::midpoint(self.strip.unwrap_or(self.x[1]), self.x[1]);
        (x, self.y[1] - share * (self.y[1] - self.zeros))
    }
}

/// One axis, for the library that draws.
#[derive(Clone)]
pub(super) struct Axis {
    pub(super) range: [f64; 2],
    pub(super) ticks: Vec<f64>,
    pub(super) label: fn(f64) -> String,
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let [low, high] = self.range;
        // No place is so far off that it could not be drawn.
        let share = ((value - low) / (high - low)).clamp(-1.0, 2.0);
        first + (share * f64::from(last - first)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, _: H) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range[0]..self.range[1]
    }
}

impl ValueFormatter<f64> for Axis {
    fn format(tick: &f64) -> String {
        plain(10_f64.powf(*tick))
    }

    fn format_ext(&self, tick: &f64) -> String {
        (self.label)(*tick)
    }
}

/// The numbers 1, 2, 5, 10 and so on in a range, or powers of ten if these are enough.
pub(super) fn ticks(low: f64, high: f64) -> Vec<f64> {
    let within = |steps: &[f64]| -> Vec<f64> {
        let decades = low.floor() as i32..=high.ceil() as i32;
        let ticks = decades.flat_map(|d| steps.iter().map(move |s| f64::from(d) + s.log10()));
        ticks.filter(|tick| (low..=high).contains(tick)).collect()
    };
    let powers = within(&[1.0]);
    if powers.len() >= 3 { powers } else { within(&[1.0, 2.0, 5.0]) }
}

/// The fastest and the slowest round, in seconds for a million pixels of tracing.
pub(super) fn extent(chart: &Chart, figures: &Figures) -> [f64; 2] {
    let all = || figures.tracing.iter().copied();
    [all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max)]
        .map(|seconds| chart.per_megapixel(seconds))
}

/// The least and the largest of some numbers; some range where there are none.
pub(super) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let finite = values.filter(|value| value.is_finite());
    let found = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    });
    if found[0] <= found[1] { found } else { [-1.0, 0.0] }
}

/// A range with margins, and no narrower than `least` and than a factor of two.
pub(super) fn padded([low, high]: [f64; 2], least: f64) -> [f64; 2] {
    let missing = (least.max(2_f64.log10()) - (high - low)).max(0.0);
    let margin = MARGIN * (high - low + missing) + missing / 2.0;
    [low - margin, high + margin]
}

/// A number of one or two digits that count, without an exponent.
pub(super) fn plain(value: f64) -> String {
    let decimals = (-(value.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$}")
}

/// A size, with k for thousands and M for millions.
pub(super) fn short(n: f64) -> String {
    let n = n.round();
    match n {
        n if n >= 1e6 => format!("{} M", n / 1e6),
        n if n >= 1e3 => format!("{} k", n / 1e3),
        n => n.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_plainly() {
        let all = [0.001, 0.02, 0.5, 1.0, 2.0, 50.0, 1000.0].map(plain);
        assert_eq!(all, ["0.001", "0.02", "0.5", "1", "2", "50", "1000"]);
    }

    #[test]
    fn ranges_have_room() {
        let [low, high] = padded([1.0, 1.0], 0.0);
        assert!(low < 1.0 - 0.15 && high > 1.0 + 0.15 && high < 1.2);
        let [low, high] = padded([-2.0, 1.0], 1.0);
        assert!(low < -2.0 && high > 1.0 && low > -2.3 && high < 1.3);
        assert_eq!(range([3.0, f64::INFINITY, -1.0].into_iter()), [-1.0, 3.0]);
        assert_eq!(range(std::iter::empty()), [-1.0, 0.0]);
    }

    #[test]
    fn sizes_are_written_shortly() {
        let all = [1.0, 30.000_000_001, 999.999_999_9, 10_000.0, 1e6].map(short);
        assert_eq!(all, ["1", "30", "1 k", "10 k", "1 M"]);
    }
}
