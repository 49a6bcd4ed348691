//! Surface functions by interpretation.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use renderer::numeric::real::Real;
use renderer::object::Object;
use renderer::scene::Scene;
use renderer::surface::{SurfaceEval, SurfaceId, SurfacePoint, SurfaceSample};

use crate::error::{Error, Problem};
use crate::machine::{Limits, Machine};
use crate::program::LoadedProgram;
use crate::value::{Closure, Value};

/// The scene to trace, and its surface functions by [`SurfaceId`]. Shapes that were given the same
/// closure share its number.
#[must_use]
pub fn scene<R: Real>(object: &Object<Arc<Closure>>) -> (Scene<R>, Vec<Arc<Closure>>) {
    let mut surfaces: Vec<Arc<Closure>> = Vec::new();
    let mut ids = HashMap::new();
    let scene = Scene::new(object, |closure: &Arc<Closure>| {
        *ids.entry(Arc::as_ptr(closure)).or_insert_with(|| {
            surfaces.push(closure.clone());
            SurfaceId(surfaces.len() as u32 - 1)
        })
    });
    (scene, surfaces)
}

/// Evaluates the surface functions of a scene, for one thread.
pub struct InterpSurfaces<'p> {
    machine: Machine<'p>,
    surfaces: &'p [Arc<Closure>],
}

impl<'p> InterpSurfaces<'p> {
    /// The functions by [`SurfaceId`]; each call may use up the limits anew.
    #[must_use]
    pub fn new(
        program: &'p Arc<LoadedProgram>,
        surfaces: &'p [Arc<Closure>],
        limits: Limits,
    ) -> Self {
        InterpSurfaces { machine: Machine::new(program, limits), surfaces }
    }
}

impl SurfaceEval for InterpSurfaces<'_> {
    type Error = Box<Error>;

    fn eval(&mut self, surface: SurfaceId, at: SurfacePoint) -> Result<SurfaceSample, Box<Error>> {
        self.machine.surface(self.surfaces[surface.0 as usize].clone(), at)
    }
}

impl Machine<'_> {
    /// Calls a surface function on a stack with nothing but face, u and v.
    ///
    /// # Errors
    /// What the function does wrong, or that it leaves anything but a colour, kd, ks and n.
    pub fn surface(
        &mut self,
        closure: Arc<Closure>,
        at: SurfacePoint,
    ) -> Result<SurfaceSample, Box<Error>> {
        self.reset();
        for argument in [Value::Int(i64::from(at.face)), Value::Real(at.u), Value::Real(at.v)] {
            self.stack.push_copy(&argument);
        }
        let function = closure.function;
        self.call(closure, None)?;
        if let [Value::Point(color), Value::Real(kd), Value::Real(ks), Value::Real(phong_exp)] =
            self.stack.as_slice()[..]
        {
            return Ok(SurfaceSample { color: DVec3::from_array(color), kd, ks, phong_exp });
        }
        self.stopped_at = (function, 0);
        let found = self.stack.as_slice().iter().map(Value::type_of).collect();
        Err(self.error(Problem::SurfaceResult(found)))
    }
}
