//! The sets of charts that there are: a row each in one table.

use serde::{Deserialize, Serialize};

use crate::chart::measure::Bench;
use crate::chart::methods::{Family, Look, Shape};
use crate::chart::study::data::Panel;
use crate::chart::study::{distance, own};
use crate::failure::Failure;

/// Charts that belong together.
#[derive(Debug)]
pub(crate) struct Set {
    /// How it is called, on the command line too.
    pub(crate) name: &'static str,
    /// Its title.
    pub(super) title: &'static str,
    /// What it is of.
    pub(crate) subject: Subject,
    /// What marks mean.
    pub(super) key: &'static str,
}

/// What a set is measured on.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Subject {
    /// Scenes that are named: a panel of this kind for each image, or a row of one.
    Scenes(Kind),
    /// What is part of the program, and measured so.
    Own(fn(Bench<'_>) -> Result<Vec<Panel>, Failure>),
}

/// All sets, in the order of the documentation.
pub(crate) const SETS: &[Set] = &[
    Set {
        name: "distance",
        title: "A sphere from afar",
        subject: Subject::Own(distance::measure),
        key: "ways to intersect a line and the unit sphere, from more and more far away; lines are \
              exact in single precision",
    },
    Set {
        name: "stability",
        title: "Scenes that break tracers",
        subject: Subject::Own(own::suite),
        key: "wrong pixels of each case of the stability suite; white: none; colours: decimal \
              logarithm of their number",
    },
    Set {
        name: "certainty",
        title: "How pixels are known",
        subject: Subject::Scenes(Kind::Certainty),
        key: "certified pixels by how they are known; number: processor time, times that of plain \
              doubles, the median ratio of the rounds",
    },
    Set {
        name: "bounces",
        title: "Errors grow with reflections",
        subject: Subject::Own(own::bounces),
        key: "texture coordinates where a path ends after so many reflections: the median pixel's \
              error, against double-double, or its proven bound",
    },
    Set {
        name: "bounds",
        title: "How tight bounds are",
        subject: Subject::Scenes(Kind::Bounds),
        key: "linear light of pixels in balls of doubles: how far off it may be, and is; nothing may \
              be above the line",
    },
    Set {
        name: "omissions",
        title: "No more than a scene needs",
        subject: Subject::Scenes(Kind::Omissions),
        key: "processor time of tracing for a pixel, medians with a bar from the fastest to the \
              slowest round; each line leaves out one part more; all images are the same bytes",
    },
    Set {
        name: "differences",
        title: "Where bytes differ",
        subject: Subject::Scenes(Kind::Differences),
        key: "pixels of which any byte is not that of the certified image, by how the certified one \
              is known there",
    },
    Set {
        name: "threads",
        title: "Two threads",
        subject: Subject::Scenes(Kind::Threads),
        key: "time of the day for tracing with one thread, times that with two: medians of the \
              rounds' ratios, with a bar from the least to the largest; work: processor time of two, times \
              that of one",
    },
];

impl Set {
    /// The set of a name.
    pub(crate) fn named(name: &str) -> Option<&'static Set> {
        SETS.iter().find(|set| set.name == name)
    }
}

/// What a panel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Kind {
    /// Which lines meet the sphere.
    Misses,
    /// Where they meet it.
    Points,
    Stability,
    Certainty,
    Bounces,
    Bounds,
    Omissions,
    Differences,
    Threads,
}

impl Kind {
    /// The set that it belongs to.
    pub(super) fn set(self) -> &'static Set {
        let name = match self {
            Kind::Misses | Kind::Points => "distance",
            Kind::Stability => "stability",
            Kind::Certainty => "certainty",
            Kind::Bounces => "bounces",
            Kind::Bounds => "bounds",
            Kind::Omissions => "omissions",
            Kind::Differences => "differences",
            Kind::Threads => "threads",
        };
        Set::named(name).expect("each kind is of a set of the table")
    }

    /// What its panels are headed with; none if that is what they are of.
    pub(super) fn heading(self) -> Option<&'static str> {
        match self {
            Kind::Misses => Some("lines taken for hits or misses wrongly"),
            Kind::Points => Some("the point that is met: largest error, in radii"),
            Kind::Stability => Some("wrong pixels"),
            Kind::Certainty => Some("share of pixels"),
            Kind::Bounces => Some("a room of mirrors around a mirrored sphere"),
            Kind::Threads => Some("one thread / two threads"),
            Kind::Bounds | Kind::Omissions | Kind::Differences => None,
        }
    }
}

/// A line of a chart.
pub(super) struct Series {
    pub(super) name: &'static str,
    pub(super) look: Look,
    pub(super) is_filled: bool,
}

const fn series(name: &'static str, family: Family, shape: Shape, is_filled: bool) -> Series {
    Series { name, look: Look { family, shape }, is_filled }
}

/// All lines of charts, in the order of legends.
pub(super) const SERIES: &[Series] = &[
    series("textbook-f32", Family::NaiveSingles, Shape::Circle, true),
    series("perpendicular-f32", Family::NaiveSingles, Shape::Square, true),
    series("moment-f32", Family::NaiveSingles, Shape::Diamond, false),
    series("textbook-f64", Family::NaiveDoubles, Shape::Circle, true),
    series("kahan-f64", Family::NaiveDoubles, Shape::Up, true),
    series("perpendicular-f64", Family::NaiveDoubles, Shape::Square, true),
    series("gmlvm-f64", Family::Doubles, Shape::Diamond, true),
    series("gmlvm-dd", Family::DoubleDoubles, Shape::Diamond, true),
    series("naive-f32-1e-3", Family::NaiveSingles, Shape::Circle, true),
    series("naive-f64-1e-9", Family::NaiveDoubles, Shape::Circle, true),
    series("jit-f64", Family::Doubles, Shape::Circle, true),
    series("bound of doubles", Family::Balls, Shape::Circle, false),
];

impl Series {
    /// The series of a name.
    pub(super) fn named(name: &str) -> Option<&'static Series> {
        SERIES.iter().find(|series| series.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique() {
        let mut names: Vec<_> = SETS.iter().map(|set| set.name).collect();
        names.extend(SERIES.iter().map(|series| series.name));
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]));
    }
}
