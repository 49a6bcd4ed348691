//! What was measured: the raw data of charts, as files keep it.

use serde::{Deserialize, Serialize};

use crate::chart::front::Point;
use crate::chart::methods::{Diagram, Method, Render};
use crate::clean::{clean, shortened};
use crate::measure::machine::{Machine, today};
use crate::measure::statistics::median;

/// A file of measurements.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Data {
    /// One for each scene and diagram.
    pub(crate) charts: Vec<Chart>,
}

/// Where measurements were taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct About {
    pub(crate) version: String,
    /// How the program was compiled.
    pub(crate) build: String,
    /// The day, in UTC.
    pub(crate) date: String,
    pub(crate) machine: Machine,
}

impl About {
    /// This program, here and now.
    pub(crate) fn here() -> Self {
        let profile = if cfg!(debug_assertions) { "development build" } else { "release build" };
        let features =
            [(cfg!(target_feature = "avx2"), "avx2"), (cfg!(target_feature = "fma"), "fma")];
        let features: String = features
            .iter()
            .filter(|(is_on, _)| *is_on)
            .map(|(_, name)| format!(", {name}"))
            .collect();
        About {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            build: format!("{profile}, {}{features}", std::env::consts::ARCH),
            date: today(),
            machine: Machine::here(),
        }
    }
}

impl About {
    /// What a file says, fit to be shown.
    pub(super) fn shown(self) -> Self {
        let About { version, build, date, mut machine } = self;
        machine.cpu = shown(&machine.cpu);
        About { version: shown(&version), build: shown(&build), date: shown(&date), machine }
    }
}

/// One scene's methods.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub(crate) struct Chart {
    pub(crate) scene: String,
    pub(crate) diagram: Diagram,
    pub(crate) images: u64,
    /// Of all images together, at least 1.
    pub(crate) pixels: u64,
    pub(crate) methods: Vec<Measured>,
    /// Where this was measured.
    pub(crate) about: About,
}

/// A method and what came of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Measured {
    pub(crate) method: String,
    #[serde(flatten)]
    pub(crate) outcome: Outcome<Figures>,
}

/// What came of rendering: figures, or why there are none.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "outcome", rename_all = "kebab-case")]
pub(crate) enum Outcome<F> {
    /// It gave images.
    Rendered(F),
    /// It did not.
    Failed {
        /// Why.
        reason: String,
    },
    /// It was given up.
    TimedOut {
        /// The limit for one image.
        seconds: f64,
    },
}

/// Times and errors of a method. A round is a run on each of the scene's images.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Figures {
    /// Processor seconds of tracing, a round each; at least one.
    pub(crate) tracing: Vec<f64>,
    /// The same of building the scene and compiling its surface functions.
    pub(crate) preparing: Vec<f64>,
    /// Rays from the eye for each pixel.
    pub(crate) rays: f64,
    #[serde(flatten)]
    pub(crate) errors: Errors,
}

/// How far images are from the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Errors {
    /// Pixels of which any byte is another.
    pub(crate) differing: u64,
    /// Of these, pixels with a byte off by more than one level.
    pub(crate) gross: u64,
    /// Of those, pixels that there is no colour for, since a surface function fails.
    pub(crate) missing: u64,
    /// The largest difference of a channel of linear light, before it is clamped; none if not
    /// finite.
    pub(crate) max: Option<f64>,
    /// The root of the mean square of all channels' differences; none if not finite.
    pub(crate) rms: Option<f64>,
}

/// A chart as a file has it.
#[derive(Deserialize)]
struct Unchecked {
    scene: String,
    diagram: Diagram,
    images: u64,
    pixels: u64,
    methods: Vec<Measured>,
    about: About,
}

impl TryFrom<Unchecked> for Chart {
    type Error = String;

    fn try_from(chart: Unchecked) -> Result<Self, String> {
        let Unchecked { scene, diagram, images, pixels, mut methods, about } = chart;
        if pixels == 0 || methods.is_empty() {
            return Err("expected pixels and methods in each chart".to_owned());
        }
        methods.iter().try_for_each(|measured| measured.check(diagram, pixels))?;
        methods.iter_mut().for_each(|measured| measured.outcome.make_shown());
        let scene = shown(&scene);
        Ok(Chart { scene, diagram, images, pixels, methods, about: about.shown() })
    }
}

impl<F> Outcome<F> {
    /// What was measured, if there is an image.
    pub(super) fn rendered(&self) -> Option<&F> {
        if let Outcome::Rendered(figures) = self { Some(figures) } else { None }
    }

    /// Makes the reason of a failure, which a file gives, fit to be shown.
    pub(super) fn make_shown(&mut self) {
        if let Outcome::Failed { reason } = self {
            *reason = shown(reason);
        }
    }
}

/// Whether these can be times, or also zero if `may_be_zero`.
pub(super) fn are_times(times: &[f64], may_be_zero: bool) -> bool {
    let is_time = |time: &f64| time.is_finite() && (*time > 0.0 || may_be_zero && *time == 0.0);
    times.iter().all(is_time)
}

/// A text of a file, fit to be shown.
pub(super) fn shown(text: &str) -> String {
    clean(&shortened(text)).into_owned()
}

impl Measured {
    fn check(&self, diagram: Diagram, pixels: u64) -> Result<(), String> {
        let Measured { method, outcome } = self;
        if Method::named(method).is_none_or(|method| method.diagram() != diagram) {
            return Err(format!("there is no method `{method}` in this diagram"));
        }
        let Outcome::Rendered(Figures { tracing, preparing, rays, errors }) = outcome else {
            return Ok(());
        };
        if tracing.is_empty() || tracing.len() != preparing.len() {
            return Err(format!("expected as many times of both kinds for `{method}`"));
        }
        if !(are_times(tracing, false) && are_times(preparing, true)) {
            return Err(format!("expected times above zero for `{method}`"));
        }
        if !(rays.is_finite() && *rays > 0.0) {
            return Err(format!("expected rays above zero for `{method}`"));
        }
        let Errors { differing, gross, missing, max, rms } = *errors;
        let is_error = |error: Option<f64>| error.is_none_or(|e| e.is_finite() && e >= 0.0);
        if missing > gross || gross > differing || differing > pixels {
            return Err(format!("expected fewer pixels for `{method}`"));
        }
        if !(is_error(max) && is_error(rms)) {
            return Err(format!("expected errors from zero up for `{method}`"));
        }
        Ok(())
    }

    /// The method itself.
    pub(crate) fn method(&self) -> &'static Method {
        Method::named(&self.method).expect("methods are checked when they are read")
    }

    /// Figures, if there are any.
    pub(crate) fn figures(&self) -> Option<&Figures> {
        self.outcome.rendered()
    }
}

impl Chart {
    /// Seconds for a million pixels, by the median round: tracing, and with preparing.
    pub(crate) fn cost(&self, figures: &Figures) -> [f64; 2] {
        let [tracing, preparing] = [&figures.tracing, &figures.preparing].map(|t| median(t));
        [tracing, tracing + preparing].map(|seconds| self.per_megapixel(seconds))
    }

    /// Seconds for a million pixels.
    pub(crate) fn per_megapixel(&self, seconds: f64) -> f64 {
        seconds / self.pixels as f64 * 1e6
    }

    /// Cost and error of a method, as the chart shows them.
    pub(crate) fn point(&self, method: &Method, figures: &Figures) -> Point {
        let cost = match method.render {
            Render::Tracer(..) | Render::Naive(..) => self.cost(figures)[0],
            Render::Sampled(_) => figures.rays,
        };
        (cost, self.error(&figures.errors))
    }

    /// The methods that gave images.
    pub(crate) fn rendered(&self) -> impl Iterator<Item = (&'static Method, &Figures)> {
        self.methods.iter().filter_map(|measured| Some((measured.method(), measured.figures()?)))
    }

    /// The error that the chart shows: the share of differing pixels, or the difference in linear
    /// light.
    fn error(&self, errors: &Errors) -> f64 {
        match self.diagram {
            Diagram::Rounding => errors.differing as f64 / self.pixels as f64,
            Diagram::Sampling => errors.rms.unwrap_or(f64::INFINITY),
        }
    }
}
