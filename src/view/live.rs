//! Images as they come into being: coarse ones first, then band by band.

use std::io;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use compiler::diagnostic::Diagnostic;
use rayon::ThreadPool;
use renderer::camera::{Region, View};
use renderer::image::Image;
use renderer::shade::RayCounts;
use serde_json::json;
use vm::host::{Host, RenderJob};

use crate::args::{ImageFormat, ViewArgs};
use crate::clean::{clean, shortened};
use crate::failure::Failure;
use crate::formats::{self, Picture, Pixels};
use crate::run::certainty::Known;
use crate::run::limits::Used;
use crate::run::plan::{self, Plan};
use crate::run::stats::Stats;
use crate::run::{self, economy};
use crate::trace::{self, Pieces, Render, Rendered, TraceFailure};
use crate::values::Size;
use crate::view::kept::Kept;
use crate::view::protocol::{Method, Out};
use crate::view::worker::Images;

/// A coarse pixel stands for so many in each direction: a 64th of the work for a first impression.
const COARSE: u32 = 8;

/// Bands of rows that are done are sent after this time, which the eye takes for at once.
const PERIOD: Duration = Duration::from_millis(60);

/// An image is cut into about so many bands.
const N_BANDS: u32 = 16;

/// Rows of a band are a multiple of this, within which adaptive sampling shares its samples.
const BAND_ROWS: u32 = 8;

/// The host of a worker: traces each image and sends it.
pub(super) struct Live<'a> {
    args: &'a ViewArgs,
    method: Method,
    threads: &'a ThreadPool,
    out: &'a Out,
    images: &'a Images,
    used: Used,
    n_surfaces: usize,
    /// What the images took.
    pub(super) stats: Stats,
    /// Time spent on images.
    pub(super) busy: Duration,
    /// Why the run ended, where no diagnostic can tell.
    pub(super) stopped_by: Option<Failure>,
}

impl<'a> Live<'a> {
    pub(super) fn new(
        args: &'a ViewArgs,
        method: Method,
        threads: &'a ThreadPool,
        out: &'a Out,
        images: &'a Images,
    ) -> Self {
        Live {
            args,
            method,
            threads,
            out,
            images,
            used: Used::default(),
            n_surfaces: 0,
            stats: Stats::default(),
            busy: Duration::ZERO,
            stopped_by: None,
        }
    }

    fn image(&mut self, job: &RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        let Live { args, method, threads, out, .. } = *self;
        let Size { width, height } = plan::size(job, &args.picture);
        self.used.add(width, height);
        args.limits.check(job, self.used, width, height, method.precision)?;
        let plan = Plan::new(job, &args.picture).map_err(|failure| {
            self.stopped_by = Some(failure);
            run::stopped()
        })?;
        let image = self.used.images - 1;
        let name = clean(&shortened(&job.name)).into_owned();
        out.send(json!({
            "event": "image", "image": image, "name": name, "width": width, "height": height
        }));
        let mut pieces = Progressive { out, image, sent: Instant::now() };
        let traced =
            trace::trace_bytes(job, &plan, method.settings(args, threads), &mut pieces, &|_| {})
                .map_err(|failure| run::surface_error(failure, job))?;
        let write_start = Instant::now();
        let file = png(&traced.picture);
        let write_time = write_start.elapsed();
        out.send_with(json!({ "event": "picture", "image": image }), "image/png", &file);
        let known = traced.certainties.as_ref().map(|certainties| {
            let known = Known::count(certainties);
            out.send(json!({ "event": "known", "image": image, "line": known.line() }));
            known
        });
        let lines = economy::uses(&traced);
        out.send(json!({ "event": "plan", "image": image, "lines": lines }));
        self.stats.add(run::image_stats(None, job, &plan, &traced, known, write_time));
        let n_surfaces = traced.n_surfaces;
        let kept = Kept::new(job, plan, traced, self.n_surfaces, (method, args));
        self.n_surfaces += n_surfaces;
        let kept = Arc::new(kept);
        self.images.lock().unwrap_or_else(PoisonError::into_inner).push(kept);
        Ok(())
    }
}

impl Host for Live<'_> {
    fn render(&mut self, mut job: RenderJob<'_>) -> Result<(), Box<Diagnostic>> {
        let start = Instant::now();
        job.depth = self.args.picture.depth.unwrap_or(job.depth);
        let outcome = self.image(&job);
        self.busy += start.elapsed();
        outcome
    }
}

/// A picture as the bytes of a PNG file.
pub(super) fn png(picture: &Picture) -> Vec<u8> {
    let mut file = Vec::new();
    let written: io::Result<()> = formats::write(ImageFormat::Png, picture, &mut file);
    written.expect("memory takes all, and the picture is of bytes");
    file
}

/// Sends an image while it is rendered.
struct Progressive<'o> {
    out: &'o Out,
    image: u64,
    /// When something was sent last.
    sent: Instant,
}

impl Progressive<'_> {
    fn send(&mut self, event: &str, y: u32, picture: &Picture) {
        let Picture { width, height, .. } = *picture;
        let message = json!({
            "event": event, "image": self.image, "y": y, "width": width, "height": height
        });
        self.out.send_with(message, "image/png", &png(picture));
        self.sent = Instant::now();
    }

    /// A first impression of the whole image.
    fn send_coarse(&mut self, plan: &Plan, render: Render<'_, [u8; 3]>) {
        let View { width, height, fov_deg, region } = plan.view;
        let is_whole = region == Region { x: 0, y: 0, width, height };
        if !is_whole || width.min(height) < 2 * COARSE {
            return;
        }
        let view = View::whole(width / COARSE, height / COARSE, fov_deg);
        let plan = Plan { view, illumination: plan.illumination.clone() };
        // What is wrong with a point that the image itself does not show is of no interest.
        if let Ok((image, ..)) = render(&plan) {
            self.send("coarse", 0, &picture(image));
        }
    }
}

/// Band by band. The image, and what is counted, is that of all bands.
impl Pieces<[u8; 3]> for Progressive<'_> {
    fn render(
        &mut self,
        plan: &Plan,
        render: Render<'_, [u8; 3]>,
    ) -> Result<Rendered<[u8; 3]>, TraceFailure> {
        self.send_coarse(plan, render);
        let View { width, height, region, .. } = plan.view;
        let mut pixels = vec![[0; 3]; width as usize * height as usize];
        let mut certainties = None;
        let mut counts = RayCounts::default();
        let mut first_unsent = region.y;
        let n_rows = (region.height / N_BANDS).next_multiple_of(BAND_ROWS).max(BAND_ROWS);
        let end = region.y + region.height;
        for y in (region.y..end).step_by(n_rows as usize) {
            let region = Region { y, height: n_rows.min(end - y), ..region };
            let view = View { region, ..plan.view };
            let (image, known, rays) =
                render(&Plan { view, illumination: plan.illumination.clone() })?;
            counts.add(&rays);
            let rows = range(width, y, y + region.height);
            pixels[rows.clone()].copy_from_slice(&image.pixels[rows.clone()]);
            if let Some(known) = known {
                let all = certainties.get_or_insert_with(|| known.clone());
                all[rows.clone()].copy_from_slice(&known[rows]);
            }
            let next = y + region.height;
            if next < end && self.sent.elapsed() >= PERIOD {
                let rows = pixels[range(width, first_unsent, next)].to_vec();
                let image = Image { width, height: next - first_unsent, pixels: rows };
                self.send("band", first_unsent, &picture(image));
                first_unsent = next;
            }
        }
        Ok((Image { width, height, pixels }, certainties, counts))
    }
}

/// Where the pixels of some rows are.
fn range(width: u32, first: u32, end: u32) -> std::ops::Range<usize> {
    first as usize * width as usize..end as usize * width as usize
}

fn picture(Image { width, height, pixels }: Image<[u8; 3]>) -> Picture {
    Picture { width, height, pixels: Pixels::Bytes(pixels) }
}
