//! The first hits of many rays found ahead, so that surface functions are called at many points at once.
//!
//! What a ray shows is the same as if it were followed alone: all that is done in another order is to
//! look for first hits, which cannot fail, and to call surface functions, whose failures are seen when
//! the ray's turn comes.

use std::ops::Range;

use super::{Hit, Place, Sample, Shader};
use crate::camera::ImagePoint;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::plan::Part;
use crate::surface::{
    Locate, MAX_BATCH, Needs, SurfaceEval, SurfaceId, SurfacePoint, SurfaceSample,
};

/// Fewer points of one surface than this are no batch. A picture of nine sines at each point, in stretches
/// of so many pixels, takes with batches 1.23 times as long as without if there are 4, 1.02 times if there
/// are 6, 0.89 if there are 8, and 0.80 if there are 12.
const MIN_BATCH: usize = 8;

/// Where less than one hit in so many is part of a batch, the next pixels are looked at alone. From 2 to
/// 64, times of pictures with a small sphere of many sines differ by less than 3 %, which is noise.
const MIN_SHARE: usize = 4;

/// How many stretches of pixels are looked at alone then. With none, such pictures take 1.07 to 1.09 times
/// as long; from 3 to 40 they differ by less than 3 %.
const N_ALONE: u32 = 7;

/// A stretch of pixels in a row, whose first hits may have been found ahead.
pub(crate) struct Ahead<R> {
    row: u32,
    columns: Range<u32>,
    /// What the rays to the pixels meet, if they are looked at together: nothing, or a point.
    met: Vec<Option<Met<R>>>,
    /// How many stretches are yet to be looked at alone.
    n_alone: u32,
    /// Points of surfaces that are asked at many at once, with the index of the pixel.
    wanted: Vec<(SurfaceId, u8, SurfacePoint)>,
    points: Vec<SurfacePoint>,
    samples: Vec<Option<SurfaceSample>>,
}

/// The point that a ray has met first.
struct Met<R> {
    /// The unit vector along the ray.
    dir: Vec3<R>,
    hit: Hit<R>,
    at: Place<R>,
    surface: SurfaceId,
    /// What the surface function has answered; none if it is yet to be asked.
    sample: Option<SurfaceSample>,
}

impl<R> Ahead<R> {
    pub(crate) fn new() -> Self {
        Ahead {
            row: 0,
            columns: 0..0,
            met: Vec::new(),
            n_alone: 0,
            wanted: Vec::new(),
            points: Vec::new(),
            samples: Vec::new(),
        }
    }
}

impl<R: Real, E: SurfaceEval> Shader<'_, R, E> {
    /// As [`Shader::radiance`] at the centre of a pixel of a row that ends before a column, if its
    /// pixels are asked for from left to right.
    #[inline(always)]
    pub(crate) fn pixel_radiance(
        &mut self,
        ahead: &mut Ahead<R>,
        [column, row]: [u32; 2],
        end: u32,
    ) -> Result<Vec3<R>, E::Error> {
        if ahead.row != row || !ahead.columns.contains(&column) {
            ahead.row = row;
            ahead.columns = column..end.min(column.saturating_add(MAX_BATCH as u32));
            self.look_ahead(ahead);
        }
        if ahead.met.is_empty() {
            self.radiance(ImagePoint::centre(column, row))
        } else {
            self.met_radiance(&ahead.met[(column - ahead.columns.start) as usize])
        }
    }

    /// Finds the first hits of a stretch of pixels, if that pays.
    #[inline(never)]
    fn look_ahead(&mut self, ahead: &mut Ahead<R>) {
        ahead.met.clear();
        // What keeps account of doubts needs to know in which order they come up.
        let may_pay = !R::KEEPS_ACCOUNT && self.scene.omissions.holds(Part::Calls);
        if !may_pay || !self.surfaces.has_batches() {
            return;
        }
        if ahead.n_alone > 0 {
            ahead.n_alone -= 1;
            return;
        }
        ahead.wanted.clear();
        for column in ahead.columns.clone() {
            let met = self.meet(ImagePoint::centre(column, ahead.row));
            if let Some(met) = &met
                && let Some(needs) = self.surfaces.batch_needs(met.surface)
            {
                let all = !self.scene.omissions.holds(Part::Coordinates);
                let point = met.at.locate(if all { Needs::ALL } else { needs });
                ahead.wanted.push((met.surface, ahead.met.len() as u8, point));
            }
            ahead.met.push(met);
        }
        let n_answered = self.ask(ahead);
        if n_answered * MIN_SHARE < ahead.columns.len() {
            ahead.n_alone = N_ALONE;
        }
    }

    /// The point that a ray through a point of the image plane meets first.
    #[inline(always)]
    fn meet(&mut self, from: ImagePoint) -> Option<Met<R>> {
        let ray = self.eye_ray(from);
        let crossing = self.scene.first_hit(&ray, &mut self.workspace)?;
        let dir = ray.dir.normalized().unwrap_or(Vec3::ZERO);
        let (hit, at) = self.hit(&ray, dir, crossing);
        let surface = self.scene.details[crossing.leaf() as usize].surface;
        Some(Met { dir, hit, at, surface, sample: None })
    }

    /// Calls surface functions at all points that are wanted, where those of one are many. Returns how
    /// many have got an answer.
    fn ask(&mut self, ahead: &mut Ahead<R>) -> usize {
        let Ahead { met, wanted, points, samples, .. } = ahead;
        let mut n_answered = 0;
        wanted.sort_unstable_by_key(|&(surface, index, _)| (surface, index));
        for batch in wanted.chunk_by(|(a, ..), (b, ..)| a == b) {
            if batch.len() < MIN_BATCH {
                continue;
            }
            points.clear();
            points.extend(batch.iter().map(|(_, _, point)| *point));
            samples.clear();
            self.surfaces.eval_batch(batch[0].0, points, samples);
            for ((_, index, _), sample) in batch.iter().zip(samples.drain(..)) {
                n_answered += usize::from(sample.is_some());
                if let Some(met) = &mut met[usize::from(*index)] {
                    met.sample = sample;
                }
            }
        }
        n_answered
    }

    /// The light that arrives at the eye from a point that has been met first.
    #[inline(never)]
    fn met_radiance(&mut self, met: &Option<Met<R>>) -> Result<Vec3<R>, E::Error> {
        self.start();
        let Some(Met { dir, hit, at, surface, sample }) = met else { return Ok(Vec3::ZERO) };
        let sample = match sample {
            Some(sample) => {
                self.counts.surface_calls += 1;
                Sample::new(sample)
            }
            None => self.sample::<false>(*surface, at)?,
        };
        let (bounce, reflected) = self.lit::<false>(*dir, hit, &sample)?;
        match reflected {
            None => Ok(self.reflected(&bounce, Vec3::ZERO)),
            Some(ray) => {
                self.path.push(bounce);
                self.go_on::<false>(ray)
            }
        }
    }
}
