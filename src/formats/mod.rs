//! Image files: PPM, PNG and PFM, written from pixels and read for comparison.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use crate::args::ImageFormat;
use crate::console;

mod pfm;
mod png;
mod ppm;

/// Pixels of an image, row by row from the upper left corner.
#[derive(Debug)]
pub(crate) enum Pixels {
    /// A byte per channel.
    Bytes(Vec<[u8; 3]>),
    /// Linear light; 1 is full scale.
    Linear(Vec<[f32; 3]>),
}

/// As in a file: bit for bit, so that NaN is what it is.
impl PartialEq for Pixels {
    fn eq(&self, other: &Self) -> bool {
        let bits = |pixel: &[f32; 3]| pixel.map(f32::to_bits);
        match (self, other) {
            (Pixels::Bytes(a), Pixels::Bytes(b)) => a == b,
            (Pixels::Linear(a), Pixels::Linear(b)) => a.iter().map(bits).eq(b.iter().map(bits)),
            _ => false,
        }
    }
}

/// An image to be written.
#[derive(Debug)]
pub(crate) struct Picture {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) pixels: Pixels,
}

/// An image that was read: channels in levels, 255 for full scale.
#[derive(Debug, PartialEq)]
pub(crate) struct Raster {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) pixels: Vec<[f32; 3]>,
}

/// An image may have so many pixels to be read, which take 12 GiB of memory, beside its file.
const MAX_PIXELS: u64 = 1 << 30;

/// No image of so many pixels needs a larger file; of a file without end, no more is read.
const MAX_FILE: u64 = 13 * MAX_PIXELS;

impl ImageFormat {
    /// The usual extension.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            ImageFormat::Ppm => "ppm",
            ImageFormat::Png => "png",
            ImageFormat::Pfm => "pfm",
        }
    }
}

/// The format that a name's extension stands for.
pub(crate) fn of_name(name: &Path) -> Option<ImageFormat> {
    let extension = name.extension()?.to_str()?;
    [ImageFormat::Ppm, ImageFormat::Png, ImageFormat::Pfm]
        .into_iter()
        .find(|format| format.extension().eq_ignore_ascii_case(extension))
}

/// The format of a file, by its first two bytes.
pub(crate) fn of_start(bytes: &[u8]) -> Option<ImageFormat> {
    match bytes {
        b"P6" => Some(ImageFormat::Ppm),
        b"PF" | b"Pf" => Some(ImageFormat::Pfm),
        b"\x89P" => Some(ImageFormat::Png),
        _ => None,
    }
}

/// Writes an image. PFM holds linear light, the other formats bytes; a picture of the other kind is
/// an error.
pub(crate) fn write(format: ImageFormat, picture: &Picture, out: &mut dyn Write) -> io::Result<()> {
    let Picture { width, height, .. } = *picture;
    match (format, &picture.pixels) {
        (ImageFormat::Ppm, Pixels::Bytes(pixels)) => ppm::write(width, height, pixels, out),
        (ImageFormat::Png, Pixels::Bytes(pixels)) => png::write(width, height, pixels, out),
        (ImageFormat::Pfm, Pixels::Linear(pixels)) => pfm::write(width, height, pixels, out),
        _ => Err(io::ErrorKind::InvalidInput.into()),
    }
}

/// Reads an image; its first bytes tell the format.
///
/// # Errors
/// Says what is wrong.
pub(crate) fn read(path: &Path) -> Result<Raster, String> {
    let io_error = |error: io::Error| console::reason(&error);
    let file = File::open(path).map_err(io_error)?;
    let mut bytes = Vec::new();
    (&file).take(2).read_to_end(&mut bytes).map_err(io_error)?;
    let format = of_start(&bytes).ok_or("is not an image of the formats PPM (P6), PNG or PFM")?;
    file.take(MAX_FILE).read_to_end(&mut bytes).map_err(io_error)?;
    match format {
        ImageFormat::Ppm => ppm::read(&bytes),
        ImageFormat::Pfm => pfm::read(&bytes),
        ImageFormat::Png => png::read(&bytes),
    }
}

/// Number of pixels of an image that is read, if it is not absurd.
fn n_pixels(width: u32, height: u32) -> Result<usize, String> {
    match u64::from(width) * u64::from(height) {
        0 => Err("has no pixels".to_owned()),
        n if n > MAX_PIXELS => Err(format!("has {n} pixels, more than can be compared")),
        n => Ok(n as usize),
    }
}

/// How far two channels are apart. NaN equals itself and is far from all else.
pub(crate) fn difference(a: f64, b: f64) -> f64 {
    let difference = (a - b).abs();
    if a == b || (a.is_nan() && b.is_nan()) {
        0.0
    } else if difference.is_nan() {
        f64::INFINITY
    } else {
        difference
    }
}

/// A channel in levels, when `max` is full scale.
fn level(value: u32, max: u32) -> f32 {
    (f64::from(value) * 255.0 / f64::from(max)) as f32
}

/// Reads the words of a text header.
struct Header<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl<'b> Header<'b> {
    /// Starts behind the magic number.
    fn new(bytes: &'b [u8]) -> Self {
        Header { bytes, at: 2 }
    }

    /// The next word, and behind it the one white space character that ends it. `#` starts a
    /// comment that reaches to the end of its line.
    fn word(&mut self) -> Option<&'b str> {
        loop {
            match self.bytes.get(self.at)? {
                b'#' => self.skip(|b| b != b'\n'),
                b if b.is_ascii_whitespace() => self.at += 1,
                _ => break,
            }
        }
        let start = self.at;
        self.skip(|b| !b.is_ascii_whitespace() && b != b'#');
        let word = std::str::from_utf8(&self.bytes[start..self.at]).ok();
        self.at += usize::from(self.bytes.get(self.at) != Some(&b'#'));
        word
    }

    fn number<N: std::str::FromStr>(&mut self) -> Result<N, String> {
        let word = self.word().ok_or("its header is cut off")?;
        word.parse().map_err(|_| "its header is wrong".to_owned())
    }

    /// What follows the header.
    fn rest(&self) -> &'b [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    fn skip(&mut self, wanted: impl Fn(u8) -> bool) {
        while self.bytes.get(self.at).is_some_and(|&b| wanted(b)) {
            self.at += 1;
        }
    }
}
