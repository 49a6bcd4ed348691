//! The format of part files.
//!
//! Two lines of text, the format with its version and what the part is, as JSON; a line with the hash
//! of both and of all that follows; and the pixels of the rows, from the left, as three bytes or as
//! three 32-bit floating point numbers, little end first.

use std::fs::File;
use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;

use renderer::image::Pixel;
use serde::{Deserialize, Serialize};

use crate::args::ImageFormat;
use crate::console;
use crate::failure::Failure;
use crate::output::Target;
use crate::parts::identity::Identity;
use crate::run::digest::Digest;

/// How part files end.
pub(super) const EXTENSION: &str = "part";

/// How part files begin, and the version that is written and read here.
const MAGIC: &str = "gmlvm-part ";
const VERSION: &str = "1";

/// The lines before the pixels are shorter than this: a name has at most 4096 bytes, each of which JSON
/// may write as six.
const MAX_HEADER: u64 = 1 << 16;

/// What a part is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Header {
    pub(crate) of: Identity,
    pub(crate) part: Kind,
}

/// The two kinds of parts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    /// Rows of an image.
    Band(Band),
    /// The program came to its end, and had rendered so many images.
    End { images: u64 },
}

/// Rows of an image.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Band {
    pub(crate) image: ImagePlace,
    /// The rows whose pixels these are.
    pub(crate) rows: Range<u32>,
}

/// Which image a band belongs to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct ImagePlace {
    /// Its number in the run, from 1.
    pub(crate) number: u64,
    /// The scene's name for it: not trusted.
    pub(crate) name: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// The rows that are rendered at all; others are black.
    pub(crate) all_rows: Range<u32>,
    /// Whether pixels are linear light.
    pub(crate) is_linear: bool,
    /// The format that the run would have written.
    pub(crate) format: ImageFormat,
}

impl Band {
    /// Bytes of its pixels.
    fn n_bytes(&self) -> Option<u64> {
        let per_pixel = if self.image.is_linear { <[f32; 3]>::N_BYTES } else { <[u8; 3]>::N_BYTES };
        let n_rows = u64::from(self.rows.end.checked_sub(self.rows.start)?);
        (n_rows * u64::from(self.image.width)).checked_mul(per_pixel as u64)
    }

    /// Whether the numbers fit together.
    fn is_sound(&self) -> bool {
        let ImagePlace { width, height, ref all_rows, .. } = self.image;
        let is_within = |inner: &Range<u32>, outer: &Range<u32>| {
            outer.start <= inner.start && inner.start < inner.end && inner.end <= outer.end
        };
        width > 0 && is_within(all_rows, &(0..height)) && is_within(&self.rows, all_rows)
    }
}

/// Pixels as part files hold them.
pub(super) trait Stored: Pixel {
    /// Bytes of one.
    const N_BYTES: usize;

    /// Appends one.
    fn store(self, bytes: &mut Vec<u8>);

    /// Reads one, of so many bytes.
    fn load(bytes: &[u8]) -> Self;
}

impl Stored for [u8; 3] {
    const N_BYTES: usize = 3;

    fn store(self, bytes: &mut Vec<u8>) {
        bytes.extend(self);
    }

    fn load(bytes: &[u8]) -> Self {
        [0, 1, 2].map(|channel| bytes[channel])
    }
}

impl Stored for [f32; 3] {
    const N_BYTES: usize = 12;

    fn store(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.iter().flat_map(|channel| channel.to_le_bytes()));
    }

    fn load(bytes: &[u8]) -> Self {
        [0, 4, 8].map(|at| f32::from_le_bytes([0, 1, 2, 3].map(|offset| bytes[at + offset])))
    }
}

/// Why a file is not taken for a part.
#[derive(Debug)]
pub(crate) enum Trouble {
    /// There is no such file.
    Absent,
    /// It was one, but is not whole; says what is wrong with it.
    Damaged(&'static str),
    /// It is none that is known here, or cannot be read; says why.
    Unknown(String),
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::NotFound => Trouble::Absent,
            _ => Trouble::Unknown(format!("cannot be read: {}", console::reason(&error))),
        }
    }
}

/// Writes a part in place of one that may be there.
///
/// # Errors
/// When it cannot be written; nothing half-written is left.
pub(super) fn write(path: &Path, header: &Header, pixels: &[u8]) -> Result<(), Failure> {
    let lines = lines_of(header, pixels)
        .map_err(|error| Failure::Output(format!("could not write a part: {error}")))?;
    Target::path(path.to_owned()).write_plain(&mut |out| {
        out.write_all(lines.as_bytes())?;
        out.write_all(pixels)
    })
}

/// What comes before the pixels of a part.
pub(crate) fn lines_of(header: &Header, pixels: &[u8]) -> serde_json::Result<String> {
    let json = serde_json::to_string(header)?;
    let lines = format!("{MAGIC}{VERSION}\n{json}\n");
    let hash = hash(lines.as_bytes(), pixels);
    Ok(format!("{lines}{hash}\n"))
}

/// Reads a part, and makes sure that it is whole.
///
/// # Errors
/// Says why it is not taken.
pub(super) fn read(path: &Path) -> Result<(Header, Vec<u8>), Trouble> {
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        return Err(Trouble::Unknown("is no file".to_owned()));
    }
    whole(file, metadata.len())
}

/// Reads a part of so many bytes in all.
///
/// # Errors
/// Says why it is not taken.
pub(crate) fn whole(mut file: impl Read, length: u64) -> Result<(Header, Vec<u8>), Trouble> {
    let mut start = Vec::new();
    (&mut file).take(MAX_HEADER).read_to_end(&mut start)?;
    check_version(&start)?;
    let (n_lines, header, written_hash) = lines(&start).ok_or(CUT_SHORT)?;
    let header: Header = serde_json::from_slice(header).map_err(|_| NO_SENSE)?;
    let n_bytes = match &header.part {
        Kind::Band(band) if band.is_sound() => band.n_bytes().ok_or(NO_SENSE)?,
        Kind::Band(_) => return Err(NO_SENSE),
        Kind::End { .. } => 0,
    };
    // Memory is taken only for what is there.
    if length != n_lines as u64 + n_bytes {
        return Err(CUT_SHORT);
    }
    let mut pixels = start[n_lines..].to_vec();
    // A file may grow while it is read.
    let n_left = n_bytes.checked_sub(pixels.len() as u64).ok_or(CUT_SHORT)?;
    file.take(n_left).read_to_end(&mut pixels)?;
    let n_hashed = n_lines - written_hash.len() - 1;
    if hash(&start[..n_hashed], &pixels).as_bytes() != written_hash {
        return Err(Trouble::Damaged("its checksum is wrong"));
    }
    Ok((header, pixels))
}

const CUT_SHORT: Trouble = Trouble::Damaged("it has not the length that it should have");
const NO_SENSE: Trouble = Trouble::Damaged("its header makes no sense");

fn check_version(start: &[u8]) -> Result<(), Trouble> {
    let wanted = format!("{MAGIC}{VERSION}\n");
    if start.starts_with(wanted.as_bytes()) {
        return Ok(());
    }
    if wanted.as_bytes().starts_with(start) {
        return Err(CUT_SHORT);
    }
    Err(Trouble::Unknown(match start.strip_prefix(MAGIC.as_bytes()) {
        Some(_) => "is a part file of a format that this version of gmlvm does not know".to_owned(),
        None => "is no part file".to_owned(),
    }))
}

/// The length of the lines with their ends, the second of them, and the third.
fn lines(start: &[u8]) -> Option<(usize, &[u8], &[u8])> {
    let mut lines = start.splitn(4, |byte| *byte == b'\n');
    let [version, header, hash, _] = std::array::from_fn(|_| lines.next());
    let (version, header, hash) = (version?, header?, hash?);
    let n_lines = version.len() + header.len() + hash.len() + 3;
    (n_lines <= start.len()).then_some((n_lines, header, hash))
}

fn hash(lines: &[u8], pixels: &[u8]) -> String {
    let mut digest = Digest::default();
    digest.add(lines);
    digest.add(pixels);
    digest.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(rows: Range<u32>) -> Header {
        let of = r#"{"gmlvm":"1","scene":"2","settings":"3"}"#;
        let of = serde_json::from_str(of).expect("an identity");
        let (name, format) = ("a\n\u{1b}.ppm".to_owned(), ImageFormat::Ppm);
        let (all_rows, is_linear) = (1..7, false);
        let image =
            ImagePlace { number: 1, name, width: 5, height: 9, all_rows, is_linear, format };
        Header { of, part: Kind::Band(Band { image, rows }) }
    }

    /// Whatever single byte of a part is another, missing or too many, the part is not taken.
    #[test]
    fn damage_is_noticed() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.part");
        let (header, pixels) = (header(2..5), (0..45).collect::<Vec<u8>>());
        write(&path, &header, &pixels).expect("written");
        assert_eq!(read(&path).expect("whole"), (header, pixels));
        let whole = std::fs::read(&path).expect("there");
        let is_taken = |bytes: &[u8]| {
            std::fs::write(&path, bytes).expect("written");
            read(&path).is_ok()
        };
        for at in 0..whole.len() {
            for other in [whole[at] ^ 1, b'\n'] {
                let mut damaged = whole.clone();
                damaged[at] = other;
                assert!(other == whole[at] || !is_taken(&damaged), "byte {at} is {other}");
            }
            assert!(!is_taken(&whole[..at]), "cut at {at}");
            let mut shorter = whole.clone();
            shorter.remove(at);
            assert!(!is_taken(&shorter), "without byte {at}");
        }
        assert!(!is_taken(&[&whole[..], b"x"].concat()));
        assert!(is_taken(&whole));
    }

    #[test]
    fn headers_that_make_no_sense_are_damaged() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.part");
        for (rows, n_pixels) in [(0..5, 75), (2..8, 90), (4..4, 0), (Range { start: 5, end: 2 }, 0)]
        {
            write(&path, &header(rows), &vec![0; n_pixels]).expect("written");
            assert!(matches!(read(&path), Err(Trouble::Damaged(_))));
        }
    }
}
