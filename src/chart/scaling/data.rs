//! What was measured of growth: the raw data, as files keep it.

use serde::{Deserialize, Serialize};

use crate::chart::data::{About, Outcome, are_times};
use crate::chart::scaling::series::{MAX_SIZE, Series};
use crate::measure::statistics::{Ratio, median, paired_ratio};

/// A file of measurements.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Growth {
    /// In the order of tables and panels.
    pub(crate) series: Vec<Measured>,
}

/// A series and what came of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub(crate) struct Measured {
    pub(super) series: String,
    /// By size, ascending; at least one.
    pub(super) points: Vec<Point>,
    /// Where this was measured.
    pub(super) about: About,
}

/// A size and what came of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Point {
    /// From 1 to [`MAX_SIZE`].
    pub(super) n: u64,
    #[serde(flatten)]
    pub(super) outcome: Outcome<Times>,
}

/// What an image took: processor seconds of one thread, a round each.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Times {
    /// Rays of all kinds, from the eye, reflected and toward lights: at least one for each pixel.
    pub(super) rays: u64,
    /// Pixels, at least 1.
    pub(super) pixels: u64,
    /// Compiling and running the program, and freeing what it made.
    pub(super) program: Vec<f64>,
    /// Building the scene and compiling its surface functions.
    pub(super) preparing: Vec<f64>,
    /// Tracing the rays.
    pub(super) tracing: Vec<f64>,
}

/// A series as a file has it.
#[derive(Deserialize)]
struct Unchecked {
    series: String,
    points: Vec<Point>,
    about: About,
}

impl TryFrom<Unchecked> for Measured {
    type Error = String;

    fn try_from(measured: Unchecked) -> Result<Self, String> {
        let Unchecked { series, mut points, about } = measured;
        if Series::named(&series).is_none() {
            return Err("expected the name of a series".to_owned());
        }
        let sizes_ascend = points.is_sorted_by(|a, b| a.n < b.n);
        let are_sizes = points.iter().all(|point| (1..=MAX_SIZE).contains(&point.n));
        if points.is_empty() || !sizes_ascend || !are_sizes {
            return Err(format!("expected sizes from 1 to {MAX_SIZE} that ascend in `{series}`"));
        }
        points.iter_mut().try_for_each(Point::check)?;
        let rounds = |point: &Point| point.times().map(|times| times.tracing.len());
        let mut all = points.iter().filter_map(rounds);
        if all.next().is_some_and(|first| all.any(|n| n != first)) {
            return Err(format!("expected as many rounds of all sizes in `{series}`"));
        }
        Ok(Measured { series, points, about: about.shown() })
    }
}

impl Point {
    fn check(&mut self) -> Result<(), String> {
        self.outcome.make_shown();
        let Some(Times { rays, pixels, program, preparing, tracing }) = self.times() else {
            return Ok(());
        };
        if *pixels == 0 || rays < pixels {
            return Err("expected pixels, and at least as many rays".to_owned());
        }
        if tracing.is_empty() || [program, preparing].iter().any(|t| t.len() != tracing.len()) {
            return Err("expected as many times of all kinds".to_owned());
        }
        if !(are_times(tracing, false) && are_times(program, true) && are_times(preparing, true)) {
            return Err("expected times above zero".to_owned());
        }
        Ok(())
    }

    /// What it took, if it gave an image.
    pub(super) fn times(&self) -> Option<&Times> {
        self.outcome.rendered()
    }
}

impl Times {
    /// Seconds of tracing for one ray, by the median round.
    pub(super) fn of_ray(&self) -> f64 {
        median(&self.tracing) / self.rays as f64
    }

    /// The same of the fastest and the slowest round.
    pub(super) fn extent(&self) -> [f64; 2] {
        let all = || self.tracing.iter().copied();
        [all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max)]
            .map(|seconds| seconds / self.rays as f64)
    }
}

/// How many times as long something takes at a larger size as at a smaller one.
pub(super) struct Grown {
    pub(super) from: u64,
    pub(super) to: u64,
    pub(super) of_ray: Ratio,
    pub(super) of_pixel: Ratio,
}

impl Measured {
    /// The series itself.
    pub(super) fn series(&self) -> &'static Series {
        Series::named(&self.series).expect("names are checked when they are read")
    }

    /// The points that gave images.
    pub(super) fn rendered(&self) -> impl Iterator<Item = (u64, &Times)> {
        self.points.iter().filter_map(|point| Some((point.n, point.times()?)))
    }

    /// How the time grows from where the series is compared, or the first size above, to the last
    /// size; none if these are one.
    pub(super) fn grown(&self) -> Option<Grown> {
        let from = self.series().from;
        let (to, last) = self.rendered().last()?;
        let is_start = |(n, _): &(u64, &Times)| *n >= from && *n < to;
        let (from, first) = self.rendered().find(is_start).or_else(|| self.rendered().next())?;
        let ratio = |divisor: fn(&Times) -> u64| {
            let each = |times: &Times| -> Vec<f64> {
                times.tracing.iter().map(|time| time / divisor(times) as f64).collect()
            };
            paired_ratio(&each(first), &each(last))
        };
        let (of_ray, of_pixel) = (ratio(|times| times.rays), ratio(|times| times.pixels));
        (from < to).then_some(Grown { from, to, of_ray, of_pixel })
    }
}

#[cfg(test)]
mod tests {
    use crate::chart::data::About;

    use super::*;

    fn measured(points: &[(u64, &[f64])]) -> Measured {
        let point = |(n, tracing): &(u64, &[f64])| Point {
            n: *n,
            outcome: Outcome::Rendered(Times {
                rays: 4,
                pixels: 2,
                program: vec![1.0; tracing.len()],
                preparing: vec![1.0; tracing.len()],
                tracing: tracing.to_vec(),
            }),
        };
        Measured {
            series: "spheres".to_owned(),
            points: points.iter().map(point).collect(),
            about: About::here(),
        }
    }

    /// Each round is compared with itself, from the size that the series names.
    #[test]
    fn growth_is_by_rounds() {
        let all: [(u64, &[f64]); 4] =
            [(1, &[9.0; 3]), (1000, &[1.0, 2.0, 3.0]), (10_000, &[5.0; 3]), (MAX_SIZE, &[3.0; 3])];
        let grown = measured(&all).grown().expect("two sizes");
        assert_eq!((grown.from, grown.to), (1000, MAX_SIZE));
        assert_eq!((grown.of_ray.estimate, grown.of_pixel.estimate), (1.5, 1.5));
        let grown = measured(&all[..2]).grown().expect("two sizes");
        assert_eq!((grown.from, grown.to), (1, 1000));
        assert!(measured(&all[..1]).grown().is_none());
    }
}
