//! What the machine asks of its surroundings.

use std::sync::Arc;

use compiler::bytecode::Origin;
use compiler::diagnostic::Diagnostic;
use compiler::scalar::Point;
use renderer::light::Light;
use renderer::object::Object;

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

/// Carries out what has effects outside the machine.
pub trait Host {
    /// Renders an image.
    ///
    /// # Errors
    /// What went wrong; it ends the program.
    fn render(&mut self, job: RenderJob<'_>) -> Result<(), Box<Diagnostic>>;
}
