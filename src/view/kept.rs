//! What is kept of an image that has been rendered, to tell what its pixels are about.

use std::sync::{Arc, OnceLock};

use compiler::bytecode::Origin;
use compiler::scalar::Point;
use compiler::source::SourceMap;
use glam::DVec3;
use rayon::ThreadPool;
use renderer::camera::{Region, View};
use renderer::certify::Certainty;
use renderer::image::{Image, Pixel};
use renderer::light::Light;
use renderer::object::Object;
use renderer::probe::{Cost, Seen, costs, probe};
use renderer::sampling::Sampling;
use renderer::scene::Scene;
use renderer::surface::{Locate, SurfaceEval, SurfaceId, SurfaceSample};
use serde_json::{Value, json};
use vm::error::Error;
use vm::host::RenderJob;
use vm::machine::Limits;
use vm::program::LoadedProgram;
use vm::surfaces::{self, InterpSurfaces};
use vm::value::Closure;

use crate::args::{LimitArgs, Precision, ViewArgs};
use crate::clean::clean;
use crate::driver;
use crate::formats::Pixels;
use crate::listing::text::evaluation;
use crate::run::certainty::words;
use crate::run::limits::Used;
use crate::run::plan::Plan;
use crate::run::stats::Rays;
use crate::trace::{self, Traced};
use crate::view::protocol::Method;

/// An image, and what it was made from.
pub(super) struct Kept {
    program: Arc<LoadedProgram>,
    ambient: Point,
    lights: Vec<Light>,
    attenuation: Option<Point>,
    object: Object<Arc<Closure>>,
    depth: u32,
    fov_deg: f64,
    size: [u32; 2],
    name: Arc<str>,
    origin: Origin,
    pub(super) plan: Plan,
    pub(super) traced: Traced,
    pub(super) method: Method,
    /// How many surface functions the images before have.
    first_surface: usize,
    /// The options, for tracing again.
    args: ViewArgs,
    /// What is traced, and its surface functions, made when first asked for.
    scene: OnceLock<(Scene, Vec<Arc<Closure>>)>,
}

impl Kept {
    pub(super) fn new(
        job: &RenderJob<'_>,
        plan: Plan,
        traced: Traced,
        first_surface: usize,
        (method, args): (Method, &ViewArgs),
    ) -> Self {
        Kept {
            program: job.program.clone(),
            ambient: job.ambient,
            lights: job.lights.clone(),
            attenuation: job.attenuation,
            object: job.object.clone(),
            depth: job.depth,
            fov_deg: job.fov_deg,
            size: [job.width, job.height],
            name: job.name.clone(),
            origin: job.origin,
            plan,
            traced,
            method,
            first_surface,
            args: args.clone(),
            scene: OnceLock::new(),
        }
    }

    /// The job that the image is of.
    pub(super) fn job(&self) -> RenderJob<'_> {
        RenderJob {
            program: &self.program,
            ambient: self.ambient,
            lights: self.lights.clone(),
            attenuation: self.attenuation,
            object: self.object.clone(),
            depth: self.depth,
            fov_deg: self.fov_deg,
            width: self.size[0],
            height: self.size[1],
            name: self.name.clone(),
            origin: self.origin,
        }
    }

    /// What there is to know of a pixel; nothing if there is no such pixel, or its surface function
    /// fails at its centre.
    pub(super) fn pixel(
        &self,
        x: u32,
        y: u32,
        sources: &SourceMap,
        limits: LimitArgs,
    ) -> Option<Value> {
        let View { width, region, .. } = self.plan.view;
        let is_there = |at: u32, first: u32, n: u32| at >= first && at - first < n;
        if !(is_there(x, region.x, region.width) && is_there(y, region.y, region.height)) {
            return None;
        }
        let Pixels::Bytes(pixels) = &self.traced.picture.pixels else { return None };
        let color = pixels[y as usize * width as usize + x as usize];
        let (scene, functions) = self.scene();
        let counting = Counting::new(&self.program, functions, limits.machine());
        let Plan { view, illumination } = &self.plan;
        let work = |counting: &Counting<'_>| counting.instructions;
        let found = probe(scene, illumination, view, [x, y], counting, work).ok()?;
        let seen =
            found.seen.map(|seen| self.seen(&seen, &functions[seen.surface.0 as usize], sources));
        Some(json!({
            "color": color,
            "seen": seen,
            "rays": Rays::from(found.rays),
            "instructions": found.work,
            "certainty": self.certainty(x, y).as_ref().map(words),
        }))
    }

    fn seen(&self, seen: &Seen, closure: &Closure, sources: &SourceMap) -> Value {
        let program = &self.program.bytecode;
        let span = program.functions[closure.function as usize].span;
        let function = sources.file_of(span).map(|file| {
            let n_lines = sources.text(span).matches('\n').count();
            let line = file.line_column(span).line;
            json!({ "file": clean(&file.name), "line": line, "end": line + n_lines })
        });
        let report = self.traced.surfaces.get(seen.surface.0 as usize);
        let how = report.map_or("interpreted".to_owned(), |r| evaluation(&r.evaluation, sources));
        let DVec3 { x, y, z } = seen.point;
        json!({
            "kind": format!("{:?}", seen.kind).to_lowercase(),
            "shape": seen.shape,
            "face": seen.at.face,
            "u": seen.at.u,
            "v": seen.at.v,
            "point": [x, y, z],
            "distance": seen.distance,
            "surface": self.first_surface + seen.surface.0 as usize,
            "title": clean(&compiler::disasm::title(program, closure.function)),
            "function": function,
            "how": how,
        })
    }

    /// What is traced, and its surface functions.
    fn scene(&self) -> &(Scene, Vec<Arc<Closure>>) {
        self.scene.get_or_init(|| surfaces::scene(&self.object))
    }

    /// What a plan says of the same job, traced again; none if a surface function fails, or the scene is
    /// beyond a limit for these numbers.
    pub(super) fn retraced<P: Pixel>(
        &self,
        plan: &Plan,
        method: Method,
        threads: &ThreadPool,
    ) -> Option<Traced<Image<P>>> {
        let (job, View { width, height, .. }) = (self.job(), plan.view);
        self.args.limits.check(&job, Used::default(), width, height, method.precision).ok()?;
        let settings = method.settings(&self.args, threads);
        trace::trace_pixels(&job, plan, settings, &|_| {}).ok()
    }

    /// What the centres of all pixels take, on these threads; none if a surface function fails.
    pub(super) fn costs(&self, threads: &ThreadPool) -> Option<Vec<Cost>> {
        let Plan { view, illumination } = &self.plan;
        let limits = self.args.limits.machine();
        threads.install(|| {
            let (scene, functions) = self.scene();
            let worker = || Counting::new(&self.program, functions, limits);
            costs(scene, illumination, view, worker, |counting| counting.instructions).ok()
        })
    }

    /// How the pixel's centre is known: found now, if the image is not of such pixels.
    fn certainty(&self, x: u32, y: u32) -> Option<Certainty> {
        let View { width, .. } = self.plan.view;
        if let Some(known) = &self.traced.certainties {
            return known.get(y as usize * width as usize + x as usize).copied();
        }
        let threads = driver::threads(1).ok()?;
        let method =
            Method { precision: Precision::Certified, sampling: Sampling::Centre, ..self.method };
        let view = View { region: Region { x, y, width: 1, height: 1 }, ..self.plan.view };
        let plan = Plan { view, illumination: self.plan.illumination.clone() };
        let traced = self.retraced::<[u8; 3]>(&plan, method, &threads)?;
        traced.certainties?.get(y as usize * width as usize + x as usize).copied()
    }
}

/// An interpreter of surface functions that adds up the instructions it takes.
struct Counting<'p> {
    inner: InterpSurfaces<'p>,
    instructions: u64,
}

impl<'p> Counting<'p> {
    fn new(program: &'p Arc<LoadedProgram>, functions: &'p [Arc<Closure>], limits: Limits) -> Self {
        Counting { inner: InterpSurfaces::new(program, functions, limits), instructions: 0 }
    }
}

impl SurfaceEval for Counting<'_> {
    type Error = Box<Error>;

    fn eval(&mut self, surface: SurfaceId, at: &impl Locate) -> Result<SurfaceSample, Box<Error>> {
        let sample = self.inner.eval(surface, at);
        self.instructions += self.inner.fuel_used();
        sample
    }
}
