//! What the machine asks of its surroundings.

use std::sync::Arc;

use compiler::bytecode::Origin;
use compiler::diagnostic::Diagnostic;
use compiler::scalar::Point;
use glam::DVec3;
use renderer::light::{Attenuation, Light};
use renderer::object::Object;
use renderer::shade::Illumination;

use crate::program::LoadedProgram;
use crate::value::Closure;

/// The operands of one `render`. Checked: all numbers are in range, but for the limits of the host.
pub struct RenderJob<'p> {
    /// The program that the surface functions belong to.
    pub program: &'p Arc<LoadedProgram>,
    /// Ambient light.
    pub ambient: Point,
    /// Lights, in order.
    pub lights: Vec<Light>,
    /// The Chicago dialect's attenuation coefficients; none in the ICFP form.
    pub attenuation: Option<Point>,
    /// What to render.
    pub object: Object<Arc<Closure>>,
    /// Reflection depth as given, at least 0.
    pub depth: u32,
    /// Horizontal field of view in degrees, above 0 and below 180.
    pub fov_deg: f64,
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
    /// File name, as the program gives it: not trusted.
    pub name: Arc<str>,
    /// Where `render` and its operands were written.
    pub origin: Origin,
}

/// Whose rules of illumination and depth an image follows (reference 5.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dialect {
    /// Chicago's if `render` was given attenuation coefficients, ICFP's otherwise.
    #[default]
    Auto,
    /// The ICFP contest of 2000.
    Icfp,
    /// The University of Chicago's course of 2003.
    Chicago,
}

impl RenderJob<'_> {
    /// The job's light and the rules of a dialect. Attenuation coefficients count in both; the
    /// Chicago rules without any mean no attenuation.
    #[must_use]
    pub fn illumination(&self, dialect: Dialect) -> Illumination {
        let is_chicago = match dialect {
            Dialect::Auto => self.attenuation.is_some(),
            Dialect::Icfp => false,
            Dialect::Chicago => true,
        };
        let attenuation = match self.attenuation {
            Some(coefficients) => Attenuation::Polynomial(coefficients),
            None if is_chicago => Attenuation::Polynomial([1.0, 0.0, 0.0]),
            None => Attenuation::Icfp,
        };
        Illumination {
            ambient: DVec3::from_array(self.ambient),
            lights: self.lights.clone(),
            attenuation,
            tint_specular: !is_chicago,
            clamp_reflection: is_chicago,
            // Reference 4.8: Chicago counts the primary ray.
            max_bounces: if is_chicago { self.depth.saturating_sub(1) } else { self.depth },
        }
    }
}

/// Carries out what has effects outside the machine.
pub trait Host {
    /// Renders an image.
    ///
    /// # Errors
    /// What went wrong; it ends the program.
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>>;
}
