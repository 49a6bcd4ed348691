//! Scene to image, rows in parallel.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::camera::{View, eye};
use crate::image::{Image, Pixel};
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::ray::{Medium, Ray};
use crate::scene::Scene;
use crate::shade::{Illumination, RayCounts, Shader};
use crate::surface::SurfaceEval;

/// A surface function had no answer.
#[derive(Clone, Debug)]
pub struct Failure<E> {
    /// Column of the pixel.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// What went wrong.
    pub error: E,
}

/// Renders an image on the current rayon thread pool. `worker` makes what one thread evaluates
/// surfaces with; `progress` is told how many pixels have been added.
///
/// A pixel depends on the scene and its coordinates alone: the image is the same for any number of
/// threads.
///
/// # Errors
/// The failure of the first pixel, in reading order, that has one.
pub fn render<R: Real, E: SurfaceEval + Send, P: Pixel>(
    scene: &Scene<R>,
    illumination: &Illumination,
    view: &View,
    worker: impl Fn() -> E + Sync,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<(Image<P>, RayCounts), Failure<E::Error>> {
    let width = view.width as usize;
    let mut pixels = vec![P::default(); width * view.height as usize];
    let job = Job { view, half_pixel: view.half_pixel(), failure: Failures::new() };
    let shaders = Shaders::new(|| Shader::new(scene, illumination, worker()));
    let rows = view.region.y as usize..(view.region.y + view.region.height) as usize;
    let region = &mut pixels[rows.start * width..rows.end * width];
    region.par_chunks_mut(width).zip(rows).with_max_len(1).for_each(|(pixels, row)| {
        shaders.with(|shader| job.row(row as u32, pixels, shader));
        progress(u64::from(view.region.width));
    });
    let counts = shaders.counts();
    match job.failure.first.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(failure) => Err(failure),
        None => Ok((Image { width: view.width, height: view.height, pixels }, counts)),
    }
}

/// The shaders of the threads, made when first needed. A thread's own is never waited for.
struct Shaders<'s, R, E, F> {
    by_thread: Vec<Mutex<Option<Shader<'s, R, E>>>>,
    make: F,
}

impl<'s, R: Real, E: SurfaceEval, F: Fn() -> Shader<'s, R, E>> Shaders<'s, R, E, F> {
    fn new(make: F) -> Self {
        let by_thread = (0..rayon::current_num_threads()).map(|_| Mutex::new(None)).collect();
        Shaders { by_thread, make }
    }

    fn with(&self, work: impl FnOnce(&mut Shader<'s, R, E>)) {
        let thread = rayon::current_thread_index().unwrap_or(0);
        let mut shader = self.by_thread[thread].lock().unwrap_or_else(PoisonError::into_inner);
        work(shader.get_or_insert_with(&self.make));
    }

    fn counts(self) -> RayCounts {
        let mut sum = RayCounts::default();
        for shader in self.by_thread {
            if let Some(shader) = shader.into_inner().unwrap_or_else(PoisonError::into_inner) {
                sum.add(&shader.counts);
            }
        }
        sum
    }
}

struct Job<'s, R, E> {
    view: &'s View,
    half_pixel: R,
    failure: Failures<E>,
}

impl<R: Real, E: Send> Job<'_, R, E> {
    fn row<S: SurfaceEval<Error = E>, P: Pixel>(
        &self,
        row: u32,
        pixels: &mut [P],
        shader: &mut Shader<'_, R, S>,
    ) {
        let region = &self.view.region;
        for column in region.x..region.x + region.width {
            if !self.failure.is_before(column, row) {
                return;
            }
            let dir = self.view.direction(self.half_pixel, column, row);
            match shader.radiance(Ray { origin: eye(), dir, on: None, medium: Medium::Unknown }) {
                Ok(Vec3 { x, y, z }) => {
                    pixels[column as usize] = P::from_linear([x, y, z].map(R::to_f64));
                }
                Err(error) => return self.failure.report(Failure { x: column, y: row, error }),
            }
        }
    }
}

/// The first failure in reading order. Pixels behind a failure need not be rendered; those before it
/// must be, since they may fail too.
struct Failures<E> {
    first: Mutex<Option<Failure<E>>>,
    /// Place of the first failure, row in the upper half.
    place: AtomicU64,
}

impl<E> Failures<E> {
    fn new() -> Self {
        Failures { first: Mutex::new(None), place: AtomicU64::new(u64::MAX) }
    }

    /// Whether a pixel comes before the first failure known.
    fn is_before(&self, column: u32, row: u32) -> bool {
        place(column, row) < self.place.load(Ordering::Relaxed)
    }

    fn report(&self, failure: Failure<E>) {
        let mut first = self.first.lock().unwrap_or_else(PoisonError::into_inner);
        let here = place(failure.x, failure.y);
        if first.as_ref().is_none_or(|known| here < place(known.x, known.y)) {
            self.place.store(here, Ordering::Relaxed);
            *first = Some(failure);
        }
    }
}

fn place(column: u32, row: u32) -> u64 {
    u64::from(row) << 32 | u64::from(column)
}
