//! Smaller images: each pixel is the mean of the light of those that it covers.

use std::ops::Range;

use renderer::image::Pixel;

use crate::formats::{Picture, Pixels};

/// The image in another size, of at least one pixel and at most its own.
///
/// Screens show bytes by the curve of sRGB, so the light of several pixels is the mean of what the curve
/// makes of their bytes, as the eye would see them from afar. A pixel that is covered in part counts for
/// the part.
pub(super) fn scaled(picture: &Picture, width: u32, height: u32) -> Vec<[u8; 3]> {
    let light: Vec<f64> = (0..=255).map(light).collect();
    let columns: Vec<_> = (0..width).map(|x| covered(x, width, picture.width)).collect();
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    let mut sums = vec![[0.0; 3]; width as usize];
    for y in 0..height {
        sums.fill([0.0; 3]);
        for (row, share) in covered(y, height, picture.height).pixels() {
            for (sum, columns) in sums.iter_mut().zip(&columns) {
                for (column, part) in columns.pixels() {
                    let bytes =
                        bytes(picture, row as usize * picture.width as usize + column as usize);
                    for (sum, byte) in sum.iter_mut().zip(bytes) {
                        *sum += share * part * light[usize::from(byte)];
                    }
                }
            }
        }
        pixels.extend(sums.iter().map(|sum| sum.map(byte)));
    }
    pixels
}

/// What a pixel covers along one axis, in pixels of the larger image.
struct Covered {
    from: f64,
    to: f64,
}

fn covered(index: u32, n_small: u32, n_large: u32) -> Covered {
    let place = |index: u32| f64::from(index) * f64::from(n_large) / f64::from(n_small);
    Covered { from: place(index), to: place(index + 1).min(f64::from(n_large)) }
}

impl Covered {
    /// The pixels, each with its share in the whole.
    fn pixels(&self) -> impl Iterator<Item = (u32, f64)> {
        let Covered { from, to } = *self;
        let pixels: Range<u32> = from.floor() as u32..to.ceil() as u32;
        let part = move |pixel: u32| to.min(f64::from(pixel + 1)) - from.max(f64::from(pixel));
        pixels.map(move |pixel| (pixel, part(pixel) / (to - from)))
    }
}

/// A pixel as bytes; of linear light those that a file of bytes would have.
fn bytes(picture: &Picture, index: usize) -> [u8; 3] {
    match &picture.pixels {
        Pixels::Bytes(pixels) => pixels[index],
        Pixels::Linear(pixels) => <[u8; 3]>::from_linear(pixels[index].map(f64::from)),
    }
}

/// The light of a byte on a screen (IEC 61966-2-1); 1 is full scale.
fn light(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// The byte whose light comes nearest.
fn byte(light: f64) -> u8 {
    let c =
        if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    (c * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(width: u32, bytes: &[u8]) -> Picture {
        let pixels = Pixels::Bytes(bytes.iter().map(|&byte| [byte; 3]).collect());
        Picture { width, height: bytes.len() as u32 / width, pixels }
    }

    fn scaled_gray(picture: &Picture, width: u32, height: u32) -> Vec<u8> {
        scaled(picture, width, height).into_iter().map(|[gray, ..]| gray).collect()
    }

    /// Black and white make the gray that they are from afar, which is 188, not 128.
    #[test]
    fn light_is_averaged_not_bytes() {
        let checkers = gray(4, &[0, 255, 0, 255, 255, 0, 255, 0]);
        assert_eq!(scaled_gray(&checkers, 2, 1), [188, 188]);
        assert_eq!(scaled_gray(&checkers, 4, 2), [0, 255, 0, 255, 255, 0, 255, 0]);
        let linear =
            Picture { width: 2, height: 1, pixels: Pixels::Linear(vec![[-1.0; 3], [7.0; 3]]) };
        assert_eq!(scaled_gray(&linear, 1, 1), [188]);
    }

    /// Of three pixels the middle one counts for half in either of two: (1 + 1/2 · 0) / (3/2) of the light.
    #[test]
    fn parts_of_pixels_count_for_parts() {
        let gray = gray(3, &[255, 0, 255]);
        assert_eq!(scaled_gray(&gray, 2, 1), [byte(2.0 / 3.0); 2]);
        assert_eq!(byte(2.0 / 3.0), 213);
    }

    #[test]
    fn one_colour_stays_itself() {
        for byte in 0..=255 {
            assert_eq!(scaled_gray(&gray(7, &[byte; 35]), 3, 2), [byte; 6], "{byte}");
        }
    }
}
