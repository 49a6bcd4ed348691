//! How the pixels of an image are known: counted, in words, and as a picture.

use std::path::Path;

use compiler::diagnostic::{Diagnostic, grouped};
use renderer::certify::Certainty;
use renderer::shade::Doubt;
use serde::{Deserialize, Serialize};
use vm::host::RenderJob;

use crate::args::ImageFormat;
use crate::failure::Failure;
use crate::formats::{self, Picture, Pixels};
use crate::output::{Existing, Problem, Target};
use crate::run::naming;

/// Numbers of pixels by how they are known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Known {
    /// By bounds in doubles.
    pub(crate) f64: u64,
    /// By bounds in double-double.
    pub(crate) dd: u64,
    /// By the rules for ties.
    pub(crate) rules: ByRules,
}

/// Numbers of pixels that hang on rules, by what is left open first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct ByRules {
    pub(crate) boundary: u64,
    pub(crate) light: u64,
    pub(crate) surface: u64,
    pub(crate) color: u64,
}

impl Known {
    /// Counts the pixels that were traced.
    pub(crate) fn count(certainties: &[Certainty]) -> Self {
        let mut known = Known::default();
        for certainty in certainties {
            let number = match certainty {
                Certainty::Unknown => continue,
                Certainty::Double => &mut known.f64,
                Certainty::DoubleDouble => &mut known.dd,
                Certainty::Rule(Doubt::Boundary) => &mut known.rules.boundary,
                Certainty::Rule(Doubt::Light) => &mut known.rules.light,
                Certainty::Rule(Doubt::Surface) => &mut known.rules.surface,
                Certainty::Rule(Doubt::Color) => &mut known.rules.color,
            };
            *number += 1;
        }
        known
    }

    /// Of all pixels.
    pub(crate) fn total(&self) -> u64 {
        let ByRules { boundary, light, surface, color } = self.rules;
        [self.f64, self.dd, boundary, light, surface, color]
            .iter()
            .fold(0, |n, m| n.saturating_add(*m))
    }

    /// A line that says it.
    pub(crate) fn line(&self) -> String {
        let ByRules { boundary, light, surface, color } = self.rules;
        let by_rules = boundary + light + surface + color;
        let certain = self.f64 + self.dd;
        let mut line = format!(
            "{} of {} pixels are certain, {} of them in doubles",
            grouped(certain),
            grouped(certain + by_rules),
            grouped(self.f64)
        );
        if by_rules > 0 {
            let kinds = [
                (boundary, "boundary"),
                (light, "light"),
                (surface, "surface function"),
                (color, "colour"),
            ];
            let kinds = kinds.iter().filter(|(n, _)| *n > 0);
            let kinds: Vec<String> =
                kinds.map(|(n, name)| format!("{name} {}", grouped(*n))).collect();
            line +=
                &format!("; {} by the rules for ties ({})", grouped(by_rules), kinds.join(", "));
        }
        line
    }
}

/// Whether a file may be that of marks.
///
/// # Errors
/// When it is no PNG file, or has a placeholder that does not exist.
pub(crate) fn check_name(file: &Path, has_frames: bool) -> Result<(), Failure> {
    if formats::of_name(file) != Some(ImageFormat::Png) {
        let shown = file.display();
        return Err(Failure::Usage(format!(
            "`--mark-uncertain {shown}`: the name must end in .png"
        )));
    }
    naming::check_placeholders("--mark-uncertain", &file.to_string_lossy(), has_frames)
}

/// Writes the picture of how the pixels of an image are known.
///
/// # Errors
/// When it cannot be written.
pub(super) fn write_marks(
    target: &Target,
    certainties: &[Certainty],
    picture: &Picture,
    existing: Existing,
) -> Result<(), Problem> {
    let marks = marks(certainties, picture);
    target.write(existing, &mut |out| formats::write(ImageFormat::Png, &marks, out))
}

/// The error that says why the picture of marks of a job's image is not written.
pub(super) fn unwritable(problem: Problem, job: &RenderJob<'_>, file: &Path) -> Box<Diagnostic> {
    let directory = file.parent().filter(|parent| !parent.as_os_str().is_empty());
    super::unwritable(problem, job, &file.to_string_lossy(), directory.unwrap_or(Path::new(".")))
}

/// The picture of how the pixels of another are known.
pub(crate) fn marks(certainties: &[Certainty], picture: &Picture) -> Picture {
    let Picture { width, height, .. } = *picture;
    let pixels = Pixels::Bytes(certainties.iter().map(color).collect());
    Picture { width, height, pixels }
}

/// How a pixel is known, in words.
pub(crate) fn words(certainty: &Certainty) -> &'static str {
    match certainty {
        Certainty::Unknown => "not known",
        Certainty::Double => "certain in doubles",
        Certainty::DoubleDouble => "certain in double-double",
        Certainty::Rule(Doubt::Boundary) => "by the rules for ties: which boundary is first",
        Certainty::Rule(Doubt::Light) => "by the rules for ties: whether light arrives",
        Certainty::Rule(Doubt::Surface) => "by the rules for ties: what the surface function does",
        Certainty::Rule(Doubt::Color) => "by the rules for ties: the colour as bytes",
    }
}

/// The colour that stands for a certainty; those of doubts can be told apart with any colour vision.
pub(crate) const fn color(certainty: &Certainty) -> [u8; 3] {
    match certainty {
        Certainty::Unknown | Certainty::Double => [0, 0, 0],
        Certainty::DoubleDouble => [96, 96, 96],
        Certainty::Rule(Doubt::Boundary) => [213, 94, 0],
        Certainty::Rule(Doubt::Light) => [240, 228, 66],
        Certainty::Rule(Doubt::Surface) => [0, 114, 178],
        Certainty::Rule(Doubt::Color) => [255, 255, 255],
    }
}
