//! Scene to image, rows in parallel.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::camera::View;
use crate::image::{Image, Pixel};
use crate::numeric::real::Real;
use crate::scene::Scene;
use crate::shade::{Ahead, Illumination, RayCounts, Shader};
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
    let grid = view.grid(1);
    let make =
        || (Shader::new(scene, grid, illumination, worker()).for_pixels::<P>(), Ahead::new());
    let end = view.region.x + view.region.width;
    let (pixels, workers) = pixels(view, 1, make, progress, |(shader, ahead), column, row| {
        let light = shader.pixel_radiance(ahead, [column, row], end)?;
        Ok(P::from_linear(light.map(R::to_f64).into()))
    })?;
    let counts = workers.iter().map(|(shader, _)| shader.counts).sum();
    Ok((Image { width: view.width, height: view.height, pixels }, counts))
}

/// Finds the pixels of a view in parallel; those outside its region have the default. `make` makes what
/// one thread works with, all of which is returned; `pixel` finds the pixel at a column and row. Each
/// `n_rows` rows of the region, from its first, are found by one thread in reading order.
pub(crate) fn pixels<W: Send, T: Copy + Default + Send + Sync, X: Send>(
    view: &View,
    n_rows: usize,
    make: impl Fn() -> W + Sync,
    progress: &(dyn Fn(u64) + Sync),
    pixel: impl Fn(&mut W, u32, u32) -> Result<T, X> + Sync,
) -> Result<(Vec<T>, Vec<W>), Failure<X>> {
    let width = view.width as usize;
    let mut pixels = vec![T::default(); width * view.height as usize];
    let failures = Failures::new();
    let workers = Workers::new(make);
    let rows = view.region.y as usize..(view.region.y + view.region.height) as usize;
    let columns = view.region.x..view.region.x + view.region.width;
    let region = &mut pixels[rows.start * width..rows.end * width];
    let bands = region.par_chunks_mut(n_rows * width).zip(rows.into_par_iter().step_by(n_rows));
    bands.with_max_len(1).for_each(|(pixels, first)| {
        workers.with(|worker| {
            for (pixels, row) in pixels.chunks_mut(width).zip(first as u32..) {
                for column in columns.clone() {
                    if !failures.is_before(column, row) {
                        return;
                    }
                    match pixel(worker, column, row) {
                        Ok(found) => pixels[column as usize] = found,
                        Err(error) => {
                            return failures.report(Failure { x: column, y: row, error });
                        }
                    }
                }
                progress(u64::from(view.region.width));
            }
        });
    });
    match failures.first.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(failure) => Err(failure),
        None => Ok((pixels, workers.all())),
    }
}

/// What the threads work with, made when first needed. A thread's own is never waited for.
struct Workers<W, F> {
    by_thread: Vec<Own<W>>,
    make: F,
}

/// A thread's own, in cache lines of its own, as many as are fetched at once: if two threads write to
/// parts of one line, each write waits for the other.
#[repr(align(128))]
struct Own<W>(Mutex<Option<W>>);

impl<W, F: Fn() -> W> Workers<W, F> {
    fn new(make: F) -> Self {
        let by_thread = (0..rayon::current_num_threads()).map(|_| Own(Mutex::new(None))).collect();
        Workers { by_thread, make }
    }

    fn with(&self, work: impl FnOnce(&mut W)) {
        let thread = rayon::current_thread_index().unwrap_or(0);
        let Own(own) = &self.by_thread[thread];
        let mut worker = own.lock().unwrap_or_else(PoisonError::into_inner);
        work(worker.get_or_insert_with(&self.make));
    }

    /// Those that were made.
    fn all(self) -> Vec<W> {
        let slots = self.by_thread.into_iter();
        slots.filter_map(|Own(w)| w.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
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
