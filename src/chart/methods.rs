//! The methods that charts compare: a row each in one table.

use Engine::{Interp, Jit};
use Numbers::{F32, F64};
use Render::{Naive, Sampled, Tracer};
use renderer::sampling::Sampling::{self, Adaptive, Centre, Grid};

use crate::args::{Engine, Precision};

/// A way to render.
#[derive(Debug)]
pub(crate) struct Method {
    /// How it is called, on the command line too.
    pub(crate) name: &'static str,
    /// How its points look, with what it has in common with others.
    pub(crate) look: Look,
    /// What it does.
    pub(crate) render: Render,
}

/// What a method does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Render {
    /// The tracer, one ray through the centre of each pixel.
    Tracer(Engine, Precision),
    /// The naive tracer, in these numbers, with this epsilon.
    Naive(Numbers, f64),
    /// The tracer in doubles, with these samples of each pixel.
    Sampled(Sampling),
}

/// The numbers of the naive tracer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Numbers {
    /// Single precision, 24 bits.
    F32,
    /// Double precision, 53 bits.
    F64,
}

/// How points look: the colour tells a family, the shape a member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Look {
    pub(crate) family: Family,
    pub(crate) shape: Shape,
}

/// Methods of one colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    Doubles,
    DoubleDoubles,
    Balls,
    NaiveDoubles,
    NaiveSingles,
    Grids,
    Adaptive,
}

/// The shape of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    Circle,
    Square,
    Diamond,
    Up,
    Down,
}

/// The charts that there are. What they show must not be shown on one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Diagram {
    /// What numbers and formulas do to images of one ray for each pixel.
    Rounding,
    /// What the number of rays does.
    Sampling,
}

impl Method {
    /// Whether this word asks for it: its name, or that of its chart.
    pub(crate) fn is_meant_by(&self, word: &str) -> bool {
        word == self.name || word == self.diagram().name()
    }

    /// The words that ask for methods.
    pub(crate) fn words() -> impl Iterator<Item = &'static str> {
        Diagram::ALL.map(Diagram::name).into_iter().chain(METHODS.iter().map(|method| method.name))
    }

    /// The chart that it belongs to.
    pub(crate) fn diagram(&self) -> Diagram {
        match self.render {
            Render::Tracer(..) | Render::Naive(..) => Diagram::Rounding,
            Render::Sampled(_) => Diagram::Sampling,
        }
    }

    /// The method of a name.
    pub(crate) fn named(name: &str) -> Option<&'static Method> {
        METHODS.iter().find(|method| method.name == name)
    }
}

impl Diagram {
    /// All of them, in the order of charts.
    pub(crate) const ALL: [Diagram; 2] = [Diagram::Rounding, Diagram::Sampling];

    /// The word for it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Diagram::Rounding => "rounding",
            Diagram::Sampling => "sampling",
        }
    }

    /// What its methods are held against.
    pub(crate) fn reference(self) -> Render {
        match self {
            Diagram::Rounding => Render::Tracer(Engine::Jit, Precision::Dd),
            Diagram::Sampling => Render::Sampled(Grid(32)),
        }
    }

    /// The reference in words.
    pub(crate) fn reference_words(self) -> &'static str {
        match self {
            Diagram::Rounding => "the image in double-double",
            Diagram::Sampling => "the mean of 32x32 rays for each pixel",
        }
    }
}

const fn method(name: &'static str, family: Family, shape: Shape, render: Render) -> Method {
    Method { name, look: Look { family, shape }, render }
}

/// All methods, in the order of tables and legends.
pub(crate) const METHODS: &[Method] = &[
    method("interp-f64", Family::Doubles, Shape::Square, Tracer(Interp, Precision::F64)),
    method("jit-f64", Family::Doubles, Shape::Circle, Tracer(Jit, Precision::F64)),
    method("interp-dd", Family::DoubleDoubles, Shape::Square, Tracer(Interp, Precision::Dd)),
    method("jit-dd", Family::DoubleDoubles, Shape::Circle, Tracer(Jit, Precision::Dd)),
    method("jit-certified", Family::Balls, Shape::Circle, Tracer(Jit, Precision::Certified)),
    method("naive-f64-1e-3", Family::NaiveDoubles, Shape::Up, Naive(F64, 1e-3)),
    method("naive-f64-1e-6", Family::NaiveDoubles, Shape::Diamond, Naive(F64, 1e-6)),
    method("naive-f64-1e-9", Family::NaiveDoubles, Shape::Down, Naive(F64, 1e-9)),
    method("naive-f32-1e-3", Family::NaiveSingles, Shape::Up, Naive(F32, 1e-3)),
    method("naive-f32-1e-6", Family::NaiveSingles, Shape::Diamond, Naive(F32, 1e-6)),
    method("naive-f32-1e-9", Family::NaiveSingles, Shape::Down, Naive(F32, 1e-9)),
    method("grid-1x1", Family::Grids, Shape::Circle, Sampled(Centre)),
    method("grid-2x2", Family::Grids, Shape::Square, Sampled(Grid(2))),
    method("grid-4x4", Family::Grids, Shape::Diamond, Sampled(Grid(4))),
    method("grid-8x8", Family::Grids, Shape::Up, Sampled(Grid(8))),
    method("adaptive-1", Family::Adaptive, Shape::Circle, Sampled(Adaptive(1))),
    method("adaptive-2", Family::Adaptive, Shape::Square, Sampled(Adaptive(2))),
    method("adaptive-3", Family::Adaptive, Shape::Diamond, Sampled(Adaptive(3))),
    method("adaptive-4", Family::Adaptive, Shape::Up, Sampled(Adaptive(4))),
];
