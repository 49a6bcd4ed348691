//! The directory of `--parts`: what is there of an image, what is to be rendered, and writing that.

use std::ops::Range;
use std::path::{Path, PathBuf};

use compiler::source::SourceMap;
use renderer::camera::{Region, View};
use renderer::image::Image;
use renderer::shade::RayCounts;
use vm::host::RenderJob;

use crate::args::{ImageFormat, Precision, RunArgs};
use crate::clean::clean;
use crate::failure::Failure;
use crate::parts::bands::bands;
use crate::parts::file::{self, Band, EXTENSION, Header, ImagePlace, Kind, Stored, Trouble};
use crate::parts::identity::Identity;
use crate::parts::shard::Shard;
use crate::report::Reporter;
use crate::run::plan::Plan;
use crate::trace::{Pieces, Render, Rendered, TraceFailure};

/// The parts of one run's images.
#[derive(Debug)]
pub(crate) struct Store {
    directory: PathBuf,
    of: Identity,
    shard: Option<Shard>,
}

/// The parts of one image.
#[derive(Debug)]
pub(crate) struct ImageParts<'s> {
    store: &'s Store,
    image: ImagePlace,
    /// Bands that are there, with their pixels unless no image is made of them.
    there: Vec<(Range<u32>, Vec<u8>)>,
    /// Bands of this run that are not.
    missing: Vec<Range<u32>>,
    /// Number of bands of the whole image.
    n_bands: usize,
    /// Why a part could not be written.
    problem: Option<Failure>,
}

/// Whether the options of a run go together with keeping parts, if it does.
///
/// # Errors
/// When they ask for what needs the whole picture at once.
pub(crate) fn check(args: &RunArgs) -> Result<(), Failure> {
    if args.parts.parts.is_some() && args.precision() == Precision::Certified {
        let message = "parts do not keep how pixels are known: `--parts` goes with the precisions \
                       f64 and dd";
        return Err(Failure::Usage(message.to_owned()));
    }
    Ok(())
}

impl Store {
    /// The store that the command line asks for, for what was read into `sources`.
    ///
    /// # Errors
    /// When the shard cannot be told, or the parts there belong to something else.
    pub(crate) fn open(args: &RunArgs, sources: &SourceMap) -> Result<Option<Self>, Failure> {
        let Some(directory) = args.parts.parts.clone() else { return Ok(None) };
        let shard = args.parts.shard.map(|choice| choice.resolve()).transpose()?;
        let store = Store { directory, of: Identity::new(args, sources), shard };
        let end = store.end_path();
        match file::read(&end) {
            Ok((header, _)) => store.check_identity(&end, &header)?,
            Err(Trouble::Absent | Trouble::Damaged(_)) => {}
            Err(Trouble::Unknown(reason)) => return Err(unusable(&end, &reason)),
        }
        Ok(Some(store))
    }

    /// The shard, if the run makes no images.
    pub(crate) fn shard(&self) -> Option<Shard> {
        self.shard
    }

    /// Looks what is there of the `number`th image of the run.
    ///
    /// # Errors
    /// When there is what belongs to something else.
    pub(crate) fn image(
        &self,
        job: &RenderJob<'_>,
        number: u64,
        view: &View,
        format: ImageFormat,
        reporter: &Reporter,
    ) -> Result<ImageParts<'_>, Failure> {
        let all_rows = view.region.y..view.region.y + view.region.height;
        let image = ImagePlace {
            number,
            name: job.name.to_string(),
            width: view.width,
            height: view.height,
            all_rows: all_rows.clone(),
            is_linear: format == ImageFormat::Pfm,
            format,
        };
        let (there, missing) = (Vec::new(), Vec::new());
        let mut parts =
            ImageParts { store: self, image, there, missing, n_bands: 0, problem: None };
        for (idx, band) in bands(view.height).enumerate() {
            let rows = band.start.max(all_rows.start)..band.end.min(all_rows.end);
            if rows.is_empty() {
                continue;
            }
            parts.n_bands += 1;
            if self.shard.is_none_or(|shard| shard.has(number, idx)) {
                parts.look(rows, reporter)?;
            }
        }
        Ok(parts)
    }

    /// Notes that the program came to its end, with so many images.
    ///
    /// # Errors
    /// When that cannot be written.
    pub(crate) fn finish(&self, images: u64) -> Result<(), Failure> {
        file::write(&self.end_path(), &self.header(Kind::End { images }), &[])
    }

    fn header(&self, part: Kind) -> Header {
        Header { of: self.of.clone(), part }
    }

    fn end_path(&self) -> PathBuf {
        self.directory.join(format!("end.{EXTENSION}"))
    }

    fn check_identity(&self, path: &Path, found: &Header) -> Result<(), Failure> {
        match self.of.difference(&found.of) {
            Some(difference) => Err(unusable(path, &format!("is {difference}"))),
            None => Ok(()),
        }
    }
}

/// The file cannot be one of this run's parts, and is not ours to replace.
fn unusable(path: &Path, why: &str) -> Failure {
    let shown = path.display().to_string();
    Failure::Usage(format!(
        "`{}` {why}; remove it, or give `--parts` another directory",
        clean(&shown)
    ))
}

impl ImageParts<'_> {
    /// Pixels that are to be rendered, of a view of this many columns.
    pub(crate) fn n_pixels(&self, view: &View) -> u64 {
        let n_rows: u64 = self.missing.iter().map(|rows| u64::from(rows.end - rows.start)).sum();
        n_rows * u64::from(view.region.width)
    }

    /// How much of the image there is, in words.
    pub(crate) fn line(&self) -> String {
        let n_mine = self.there.len() + self.missing.len();
        let mut line = format!("{n_mine} of {} bands", self.n_bands);
        if let Some(shard) = self.store.shard {
            line += &format!(", shard {shard}");
        }
        match self.there.len() {
            0 => {}
            n_there => line += &format!(", {n_there} of them there already"),
        }
        line
    }

    /// Why a part could not be written, if one could not.
    pub(crate) fn problem(self) -> Option<Failure> {
        self.problem
    }

    /// Looks whether a band is there.
    fn look(&mut self, rows: Range<u32>, reporter: &Reporter) -> Result<(), Failure> {
        let path = self.path(&rows);
        match file::read(&path) {
            Ok((found, pixels)) => {
                self.store.check_identity(&path, &found)?;
                if !self.is_mine(&found, &rows) {
                    let why = "holds another part than its name says, or linear light (PFM) in place \
                               of bytes, or bytes in place of that";
                    return Err(unusable(&path, why));
                }
                let pixels = if self.store.shard.is_some() { Vec::new() } else { pixels };
                self.there.push((rows, pixels));
            }
            Err(Trouble::Absent) => self.missing.push(rows),
            Err(Trouble::Damaged(reason)) => {
                let shown = path.display().to_string();
                reporter.note(&format!(
                    "`{}` is damaged: {reason}; its rows are rendered again",
                    clean(&shown)
                ));
                self.missing.push(rows);
            }
            Err(Trouble::Unknown(reason)) => return Err(unusable(&path, &reason)),
        }
        Ok(())
    }

    /// Whether a part is the one wanted, in whatever format the other run wanted the image.
    fn is_mine(&self, found: &Header, rows: &Range<u32>) -> bool {
        match &found.part {
            Kind::Band(band) => {
                let image = ImagePlace { format: self.image.format, ..band.image.clone() };
                image == self.image && band.rows == *rows
            }
            Kind::End { .. } => false,
        }
    }

    fn path(&self, rows: &Range<u32>) -> PathBuf {
        let name = format!("{:04}-{:06}.{EXTENSION}", self.image.number, rows.start);
        self.store.directory.join(name)
    }

    fn write<P: Stored>(&self, rows: Range<u32>, image: &Image<P>) -> Result<(), Failure> {
        let width = image.width as usize;
        let pixels = &image.pixels[rows.start as usize * width..rows.end as usize * width];
        let mut bytes = Vec::with_capacity(pixels.len() * P::N_BYTES);
        pixels.iter().for_each(|pixel| pixel.store(&mut bytes));
        let path = self.path(&rows);
        let band = Band { image: self.image.clone(), rows };
        file::write(&path, &self.store.header(Kind::Band(band)), &bytes)
    }
}

/// The missing bands are rendered one after the other, and written at once. The image is that of all
/// bands that are there then. When one cannot be written, no more are rendered.
impl<P: Stored> Pieces<P> for ImageParts<'_> {
    fn render(&mut self, plan: &Plan, render: Render<'_, P>) -> Result<Rendered<P>, TraceFailure> {
        let View { width, height, region, .. } = plan.view;
        let mut pixels = vec![P::default(); width as usize * height as usize];
        for (rows, stored) in &self.there {
            let pixels = rows_of(&mut pixels, rows, width);
            let stored = stored.chunks_exact(P::N_BYTES).map(P::load);
            pixels.iter_mut().zip(stored).for_each(|(pixel, stored)| *pixel = stored);
        }
        let mut rays = RayCounts::default();
        for rows in self.missing.clone() {
            let region = Region { y: rows.start, height: rows.end - rows.start, ..region };
            let view = View { region, ..plan.view };
            let (image, _, counts) =
                render(&Plan { view, illumination: plan.illumination.clone() })?;
            rays.add(&counts);
            let from = &image.pixels[rows.start as usize * width as usize..];
            let to = rows_of(&mut pixels, &rows, width);
            to.copy_from_slice(&from[..to.len()]);
            if let Err(failure) = self.write(rows, &image) {
                self.problem = Some(failure);
                break;
            }
        }
        Ok((Image { width, height, pixels }, None, rays))
    }
}

/// The pixels of some rows.
fn rows_of<'p, P>(pixels: &'p mut [P], rows: &Range<u32>, width: u32) -> &'p mut [P] {
    &mut pixels[rows.start as usize * width as usize..rows.end as usize * width as usize]
}
