//! What was measured of a set: the raw data, as files keep it.

use serde::{Deserialize, Serialize};

use crate::chart::data::{About, Outcome, are_times, shown};
use crate::chart::methods::Method;
use crate::chart::study::sets::{Kind, Series, Set};
use crate::measure::statistics::{Ratio, median, paired_ratio};
use crate::run::certainty::{ByRules, Known};

/// A panel has no more items than this, and an item no more values of a kind than that.
const MAX_ITEMS: usize = 100;
const MAX_VALUES: usize = 10_000;

/// A file of measurements.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Study {
    pub(crate) panels: Vec<Panel>,
}

/// A panel: some things of one form.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub(crate) struct Panel {
    pub(crate) kind: Kind,
    /// The scene, or empty.
    pub(super) scene: String,
    #[serde(flatten)]
    pub(super) form: Form,
    /// Where this was measured.
    pub(super) about: About,
}

/// What is in a panel.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case")]
pub(super) enum Form {
    /// Of series.
    Curves { items: Vec<Item<Curve>> },
    /// Of methods, for each of these cases.
    Cells { cases: Vec<Case>, items: Vec<Item<Cells>> },
    /// Of scenes.
    Shares { items: Vec<Item<Shares>> },
    /// Of scenes, or of what is left out.
    Pairs { items: Vec<Item<Pair>> },
    /// Of one scene.
    Dots { items: Vec<Item<Dots>> },
    /// Of methods.
    Masks { items: Vec<Item<Mask>> },
}

/// Something with a name, and what came of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Item<F> {
    pub(super) name: String,
    #[serde(flatten)]
    pub(super) outcome: Outcome<F>,
}

/// A case of the stability suite.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Case {
    pub(super) name: String,
    /// Of all its images.
    pub(super) pixels: u64,
}

/// A line of a chart.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Curve {
    /// What it is over, ascending and above zero, and errors from zero up.
    pub(super) points: Vec<[f64; 2]>,
    /// Processor seconds for one intersection, by round, where that was measured.
    pub(super) times: Vec<f64>,
}

/// Numbers of wrong pixels, by case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Cells {
    pub(super) wrong: Vec<u64>,
}

/// How the pixels of an image are known, and processor seconds by round.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Shares {
    pub(super) known: Known,
    /// In plain doubles.
    pub(super) base: Vec<f64>,
    /// Certified.
    pub(super) times: Vec<f64>,
}

/// Seconds of two ways to the same image, by round.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Pair {
    pub(super) pixels: u64,
    pub(super) base: Vec<f64>,
    pub(super) times: Vec<f64>,
    /// Processor seconds of all threads, first of the base, where the others are of the day.
    pub(super) work: Option<[Vec<f64>; 2]>,
}

/// Bounds and errors of the channels of an image.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Dots {
    /// Channels of pixels whose light is known.
    pub(super) channels: u64,
    /// Of these, those that are further off than their bounds, which must be none.
    pub(super) unsound: u64,
    /// Of these, those that are exact.
    pub(super) exact: u64,
    /// The median of bound / error of the others; none if there are none.
    pub(super) slack: Option<f64>,
    /// A sample: bound and error.
    pub(super) points: Vec<[f64; 2]>,
}

/// Which pixels of an image differ from the certified one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Mask {
    pub(super) width: u32,
    /// By [`Mark`]; pixels at the end of a row that do not differ are left out.
    pub(super) rows: Vec<String>,
}

/// A pixel of a mask: a letter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Same,
    Certain,
    Boundary,
    Light,
    Surface,
    Color,
}

impl Mark {
    /// All but the one of pixels that do not differ.
    pub(super) const DIFFERENT: [Mark; 5] =
        [Mark::Certain, Mark::Boundary, Mark::Light, Mark::Surface, Mark::Color];

    pub(super) fn letter(self) -> char {
        match self {
            Mark::Same => '.',
            Mark::Certain => 'n',
            Mark::Boundary => 'b',
            Mark::Light => 'l',
            Mark::Surface => 's',
            Mark::Color => 'c',
        }
    }

    pub(super) fn of(letter: char) -> Option<Mark> {
        let mut all = Mark::DIFFERENT.into_iter().chain([Mark::Same]);
        all.find(|mark| mark.letter() == letter)
    }
}

/// A panel as a file has it.
#[derive(Deserialize)]
struct Unchecked {
    kind: Kind,
    scene: String,
    #[serde(flatten)]
    form: Form,
    about: About,
}

impl TryFrom<Unchecked> for Panel {
    type Error = String;

    fn try_from(panel: Unchecked) -> Result<Self, String> {
        let Unchecked { kind, scene, mut form, about } = panel;
        let fits = match (kind, &mut form) {
            (Kind::Misses | Kind::Points | Kind::Bounces, Form::Curves { items }) => {
                check(items, |name, curve| curve.is_sound() && Series::named(name).is_some())
            }
            (Kind::Stability, Form::Cells { cases, items }) => {
                cases.iter_mut().for_each(|case| case.name = shown(&case.name));
                cases.len() <= MAX_ITEMS
                    && check(items, |name, cells| {
                        let enough = cells.wrong.len() == cases.len();
                        enough && Method::named(name).is_some()
                    })
            }
            (Kind::Certainty, Form::Shares { items }) => check(items, |_, shares| {
                shares.known.total() > 0 && are_paired(&shares.base, &shares.times)
            }),
            (Kind::Omissions | Kind::Threads, Form::Pairs { items }) => {
                check(items, |_, Pair { pixels, base, times, work }| {
                    let is_work = |[base, work]: &[Vec<f64>; 2]| are_paired(base, work);
                    *pixels > 0 && are_paired(base, times) && work.as_ref().is_none_or(is_work)
                })
            }
            (Kind::Bounds, Form::Dots { items }) => check(items, |_, dots| dots.is_sound()),
            (Kind::Differences, Form::Masks { items }) => {
                check(items, |name, mask| mask.is_sound() && Method::named(name).is_some())
            }
            _ => false,
        };
        if !fits {
            return Err("expected what charts of this kind are made of".to_owned());
        }
        Ok(Panel { kind, scene: shown(&scene), form, about: about.shown() })
    }
}

/// Whether items can be shown, whose names are made fit for that.
fn check<F>(items: &mut [Item<F>], is_sound: impl Fn(&str, &F) -> bool) -> bool {
    for item in items.iter_mut() {
        item.name = shown(&item.name);
        item.outcome.make_shown();
    }
    let is_sound = |item: &Item<F>| item.figures().is_none_or(|f| is_sound(&item.name, f));
    (1..=MAX_ITEMS).contains(&items.len()) && items.iter().all(is_sound)
}

fn are_paired(base: &[f64], times: &[f64]) -> bool {
    let are_as_many = !base.is_empty() && base.len() == times.len();
    are_as_many && are_times(base, false) && are_times(times, false)
}

/// Whether points lie where logarithmic axes have room: from zero up on the second, and also on the first
/// if that may be.
fn are_points(points: &[[f64; 2]], may_be_zero: bool) -> bool {
    let is_first = |x: f64| x.is_finite() && (x > 0.0 || may_be_zero && x == 0.0);
    points.len() <= MAX_VALUES
        && points.iter().all(|[x, y]| is_first(*x) && y.is_finite() && *y >= 0.0)
}

impl Curve {
    fn is_sound(&self) -> bool {
        let ascends = self.points.is_sorted_by(|a, b| a[0] < b[0]);
        ascends && are_points(&self.points, false) && are_times(&self.times, false)
    }
}

impl Dots {
    fn is_sound(&self) -> bool {
        let Dots { channels, unsound, exact, slack, points } = self;
        let counts = unsound <= channels && exact <= channels;
        counts && slack.is_none_or(|s| s.is_finite() && s >= 0.0) && are_points(points, true)
    }
}

impl Mask {
    fn is_sound(&self) -> bool {
        let is_row = |row: &String| {
            row.len() <= self.width as usize && row.chars().all(|c| Mark::of(c).is_some())
        };
        let is_size = |n: usize| (1..=MAX_VALUES).contains(&n);
        is_size(self.width as usize) && is_size(self.rows.len()) && self.rows.iter().all(is_row)
    }

    /// Width and height.
    pub(super) fn size(&self) -> [u32; 2] {
        [self.width, self.rows.len() as u32]
    }

    /// The pixels that differ: column, row and why.
    pub(super) fn different(&self) -> impl Iterator<Item = (u32, u32, Mark)> {
        self.rows.iter().zip(0..).flat_map(|(row, y)| {
            let marks = row.chars().zip(0..).filter_map(|(c, x)| Some((x, Mark::of(c)?)));
            marks.filter(|(_, mark)| *mark != Mark::Same).map(move |(x, mark)| (x, y, mark))
        })
    }

    /// How many pixels have this mark.
    pub(super) fn count(&self, mark: Mark) -> usize {
        self.different().filter(|(_, _, other)| *other == mark).count()
    }
}

impl Shares {
    /// Numbers of pixels: by balls of doubles, of double-double, and by each rule.
    pub(super) fn counts(&self) -> [u64; 6] {
        let Known { f64, dd, rules: ByRules { boundary, light, surface, color } } = self.known;
        [f64, dd, boundary, light, surface, color]
    }

    /// What certainty costs, times plain doubles.
    pub(super) fn overhead(&self) -> Ratio {
        paired_ratio(&self.base, &self.times)
    }
}

impl Pair {
    /// The base's time, times the other.
    pub(super) fn gain(&self) -> Ratio {
        paired_ratio(&self.times, &self.base)
    }

    /// Processor time, times that of the base, where that was measured.
    pub(super) fn more_work(&self) -> Option<Ratio> {
        self.work.as_ref().map(|[base, work]| paired_ratio(base, work))
    }

    /// Seconds for a pixel: least, median and largest.
    pub(super) fn of_pixel(&self) -> [f64; 3] {
        spread(&self.times).map(|seconds| seconds / self.pixels as f64)
    }

    /// The least, the median and the largest of the rounds' gains.
    pub(super) fn gains(&self) -> [f64; 3] {
        let gains: Vec<_> = self.base.iter().zip(&self.times).map(|(b, t)| b / t).collect();
        spread(&gains)
    }
}

/// The least, the median and the largest.
fn spread(values: &[f64]) -> [f64; 3] {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    [least, median(values), values.iter().copied().fold(0.0, f64::max)]
}

impl<F> Item<F> {
    /// What was measured, if anything was.
    pub(super) fn figures(&self) -> Option<&F> {
        self.outcome.rendered()
    }
}

impl Panel {
    /// The set that it belongs to.
    pub(crate) fn set(&self) -> &'static Set {
        self.kind.set()
    }

    /// What it is headed with.
    pub(super) fn heading(&self) -> &str {
        self.kind.heading().unwrap_or(&self.scene)
    }
}
