//! Joining parts into images.

use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use compiler::diagnostic::grouped;

use crate::args::ImageFormat;
use crate::clean::clean;
use crate::console;
use crate::failure::Failure;
use crate::formats::{Picture, Pixels};
use crate::parts::file::{self, Band, EXTENSION, Header, ImagePlace, Kind, Stored, Trouble};

/// The parts of all images of a run.
#[derive(Debug)]
pub(crate) struct Parts {
    images: BTreeMap<u64, ImageBands>,
}

/// The bands of an image, in order.
#[derive(Debug)]
struct ImageBands {
    image: ImagePlace,
    bands: BTreeMap<u32, (PathBuf, Header)>,
}

/// An image joined of its parts.
pub(crate) struct Merged {
    /// Its number in the run, from 1.
    pub(crate) number: u64,
    /// The scene's name for it: not trusted.
    pub(crate) name: String,
    /// The format that the run would have written.
    pub(crate) format: ImageFormat,
    pub(crate) picture: Picture,
    /// Rows that are black because they are not there.
    pub(crate) n_missing: u64,
}

impl Parts {
    /// Finds the part files among `inputs`, which are such files and directories of them.
    ///
    /// # Errors
    /// When a file is no whole part, when parts do not belong together, or when images are missing
    /// and not `allow_missing`.
    pub(crate) fn find(inputs: &[PathBuf], allow_missing: bool) -> Result<Self, Failure> {
        let mut images: BTreeMap<u64, ImageBands> = BTreeMap::new();
        let mut first: Option<(PathBuf, Header)> = None;
        let mut n_images = None;
        for path in part_files(inputs)? {
            let (header, _) = file::read(&path).map_err(|trouble| unusable(&path, &trouble))?;
            let (first_path, of) = first.get_or_insert_with(|| (path.clone(), header.clone()));
            if let Some(difference) = of.of.difference(&header.of) {
                return Err(unequal(first_path, &path, difference));
            }
            match header.part.clone() {
                Kind::End { images } => n_images = Some(images),
                Kind::Band(Band { image, rows }) => {
                    let of = images.entry(image.number).or_insert_with(|| ImageBands {
                        image: image.clone(),
                        bands: BTreeMap::new(),
                    });
                    of.add(&path, header, image, rows)?;
                }
            }
        }
        let parts = Parts { images };
        if !allow_missing {
            parts.check_numbers(n_images)?;
        }
        Ok(parts)
    }

    /// Number of images.
    pub(crate) fn n_images(&self) -> usize {
        self.images.len()
    }

    /// The numbers of the images, in order.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = u64> {
        self.images.keys().copied()
    }

    /// Fails if it is not certain that there is something of each image.
    fn check_numbers(&self, n_images: Option<u64>) -> Result<(), Failure> {
        let message = match n_images {
            None => {
                "no run has come to its end, so there may be more images than there are parts of"
                    .to_owned()
            }
            Some(n) => match (1..=n).find(|number| !self.images.contains_key(number)) {
                Some(number) => format!("there is no part of image {number} of {n}"),
                None => return Ok(()),
            },
        };
        Err(incomplete(&message))
    }

    /// Joins an image.
    ///
    /// # Errors
    /// When it is too large, has changed meanwhile, or rows are missing and not `allow_missing`.
    pub(crate) fn join(
        &self,
        number: u64,
        max_pixels: u64,
        allow_missing: bool,
    ) -> Result<Merged, Failure> {
        let ImageBands { image, bands } = &self.images[&number];
        let ImagePlace { width, height, .. } = *image;
        let n_pixels = u64::from(width) * u64::from(height);
        if n_pixels > max_pixels {
            let (shown, limit) = (grouped(n_pixels), grouped(max_pixels));
            return Err(Failure::Limit(format!(
                "image {number} has {width} x {height} = {shown} pixels; the limit is {limit}; raise it \
                 with `--max-pixels N`"
            )));
        }
        let missing = missing(image, bands.values().map(|(_, header)| header));
        if let Some(rows) = missing.first().filter(|_| !allow_missing) {
            let more = if missing.len() > 1 { ", and more" } else { "" };
            return Err(incomplete(&format!(
                "of image {number}, `{}`, rows {} to {}{more} are missing",
                clean(&image.name),
                rows.start,
                rows.end - 1
            )));
        }
        let pixels = if image.is_linear {
            Pixels::Linear(pixels(image, bands.values())?)
        } else {
            Pixels::Bytes(pixels(image, bands.values())?)
        };
        Ok(Merged {
            number,
            name: image.name.clone(),
            format: image.format,
            picture: Picture { width, height, pixels },
            n_missing: missing.iter().map(|rows| u64::from(rows.end - rows.start)).sum(),
        })
    }
}

impl ImageBands {
    fn add(
        &mut self,
        path: &Path,
        header: Header,
        image: ImagePlace,
        rows: Range<u32>,
    ) -> Result<(), Failure> {
        if image != (ImagePlace { format: image.format, ..self.image.clone() }) {
            let (other, _) = self.bands.values().next().expect("made for a band");
            return Err(unequal(other, path, "of the same image, but in other pixels"));
        }
        // The same band twice is one, since bands do not depend on who renders them.
        self.bands.entry(rows.start).or_insert_with(|| (path.to_owned(), header));
        Ok(())
    }
}

/// Rows of an image that no band has.
fn missing<'h>(image: &ImagePlace, headers: impl Iterator<Item = &'h Header>) -> Vec<Range<u32>> {
    let mut missing = Vec::new();
    let mut next = image.all_rows.start;
    let bands = headers.filter_map(|header| match &header.part {
        Kind::Band(band) => Some(band.rows.clone()),
        Kind::End { .. } => None,
    });
    let end = image.all_rows.end..image.all_rows.end;
    for rows in bands.chain([end]) {
        if rows.start > next {
            missing.push(next..rows.start);
        }
        next = next.max(rows.end);
    }
    missing
}

/// All pixels of an image; black where there are none.
fn pixels<'p, P: Stored>(
    image: &ImagePlace,
    bands: impl Iterator<Item = &'p (PathBuf, Header)>,
) -> Result<Vec<P>, Failure> {
    let width = image.width as usize;
    let mut pixels = vec![P::default(); width * image.height as usize];
    for (path, header) in bands {
        let (again, bytes) = file::read(path).map_err(|trouble| unusable(path, &trouble))?;
        let (Kind::Band(Band { rows, .. }), true) = (&again.part, again == *header) else {
            return Err(unusable(path, &Trouble::Damaged("it has changed meanwhile")));
        };
        let place = &mut pixels[rows.start as usize * width..rows.end as usize * width];
        let stored = bytes.chunks_exact(P::N_BYTES).map(P::load);
        place.iter_mut().zip(stored).for_each(|(pixel, stored)| *pixel = stored);
    }
    Ok(pixels)
}

/// The part files that are meant, sorted.
fn part_files(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for input in inputs {
        if !input.is_dir() {
            files.push(input.clone());
            continue;
        }
        let unreadable = |error| {
            let shown = input.display().to_string();
            let reason = console::reason(&error);
            Failure::Usage(format!("cannot read `{}`: {reason}", clean(&shown)))
        };
        for entry in fs::read_dir(input).map_err(unreadable)? {
            let path = entry.map_err(unreadable)?.path();
            if path.extension().is_some_and(|extension| extension == EXTENSION) {
                files.push(path);
            }
        }
    }
    if files.is_empty() {
        return Err(Failure::Usage("there are no part files".to_owned()));
    }
    files.sort();
    Ok(files)
}

fn unusable(path: &Path, trouble: &Trouble) -> Failure {
    let shown = path.display().to_string();
    let shown = clean(&shown);
    Failure::Usage(match trouble {
        Trouble::Absent => format!("there is no `{shown}`"),
        Trouble::Damaged(reason) => format!(
            "`{shown}` is damaged: {reason}; the `run` that made it, once more, makes it anew"
        ),
        Trouble::Unknown(reason) => format!("`{shown}` {reason}"),
    })
}

fn unequal(first: &Path, other: &Path, difference: &str) -> Failure {
    let (first, other) = (first.display().to_string(), other.display().to_string());
    Failure::Usage(format!(
        "parts do not belong together: held against `{}`, `{}` is {difference}",
        clean(&first),
        clean(&other)
    ))
}

fn incomplete(what: &str) -> Failure {
    Failure::Usage(format!(
        "{what}; `run` with the same `--parts` renders what is missing, and `--allow-missing` does \
         without"
    ))
}
