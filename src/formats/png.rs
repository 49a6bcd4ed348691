//! PNG, by way of the `png` crate.

use std::io::{self, Cursor, Write};

use png::{BitDepth, ColorType, Decoder, Encoder, Limits, Transformations};

use crate::formats::{Raster, level, n_pixels};

pub(super) fn write(
    width: u32,
    height: u32,
    pixels: &[[u8; 3]],
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(io_error)?;
    writer.write_image_data(pixels.as_flattened()).map_err(io_error)?;
    writer.finish().map_err(io_error)
}

fn io_error(error: png::EncodingError) -> io::Error {
    match error {
        png::EncodingError::IoError(error) => error,
        other => io::Error::other(other.to_string()),
    }
}

/// Deflated data are at least a byte for so many: a code of one bit and another stand for 258.
const MAX_RATIO: u64 = 258 * 8 / 2;

pub(super) fn read(bytes: &[u8]) -> Result<Raster, String> {
    let wrong = |error: png::DecodingError| format!("is no proper PNG file: {error}");
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: usize::MAX });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(wrong)?;
    let (width, height) = (reader.info().width, reader.info().height);
    n_pixels(width, height)?;
    // Memory is taken for what the file holds, not for what its header says.
    let n_bytes = u64::from(height).saturating_mul(reader.info().raw_row_length() as u64);
    if n_bytes > MAX_RATIO * bytes.len() as u64 {
        return Err("it is cut off: there are fewer pixels than its header says".to_owned());
    }
    let (color, depth) = reader.output_color_type();
    let mut pixels = Vec::new();
    if reader.info().interlaced {
        let size = reader.output_buffer_size().ok_or("has more pixels than memory")?;
        let mut samples = vec![0; size];
        reader.next_frame(&mut samples).map_err(wrong)?;
        add_pixels(&samples, color, depth, &mut pixels);
    } else {
        while let Some(row) = reader.next_row().map_err(wrong)? {
            add_pixels(row.data(), color, depth, &mut pixels);
        }
    }
    Ok(Raster { width, height, pixels })
}

/// Adds the pixels whose samples these are.
fn add_pixels(samples: &[u8], color: ColorType, depth: BitDepth, pixels: &mut Vec<[f32; 3]>) {
    let n_channels = color.samples();
    let pixel = |channel: &dyn Fn(usize) -> f32| match n_channels {
        3.. => [0, 1, 2].map(channel),
        _ => [channel(0); 3],
    };
    if depth == BitDepth::Sixteen {
        let level = |pair: [u8; 2]| level(u16::from_be_bytes(pair).into(), 65535);
        let all = samples.as_chunks::<2>().0.chunks_exact(n_channels);
        pixels.extend(all.map(|channels| pixel(&|at| level(channels[at]))));
    } else {
        let all = samples.chunks_exact(n_channels);
        pixels.extend(all.map(|channels| pixel(&|at| channels[at].into())));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let pixels = [[0, 1, 2], [253, 254, 255], [7, 7, 7], [0, 0, 0]];
        let mut file = Vec::new();
        write(2, 2, &pixels, &mut file).expect("memory");
        let raster = read(&file).expect("well formed");
        assert_eq!(raster.pixels, pixels.map(|pixel| pixel.map(f32::from)));
        for length in 0..file.len() {
            let _ = read(&file[..length]);
        }
        assert!(read(&file[..file.len() / 2]).is_err());
    }

    #[test]
    fn all_kinds_of_samples_are_read() {
        let read_as = |color, depth, samples: &[u8]| {
            let mut file = Vec::new();
            let mut encoder = Encoder::new(&mut file, 2, 1);
            encoder.set_color(color);
            encoder.set_depth(depth);
            encoder.set_palette(&[1, 2, 3, 4, 5, 6][..]);
            let mut writer = encoder.write_header().expect("memory");
            writer.write_image_data(samples).expect("memory");
            writer.finish().expect("memory");
            read(&file).expect("well formed").pixels
        };
        use BitDepth::{Eight, One, Sixteen};
        let grey = [[7.0; 3], [9.0; 3]];
        assert_eq!(read_as(ColorType::Grayscale, Eight, &[7, 9]), grey);
        assert_eq!(read_as(ColorType::GrayscaleAlpha, Eight, &[7, 1, 9, 1]), grey);
        assert_eq!(read_as(ColorType::Grayscale, Sixteen, &[7, 7, 9, 9]), grey);
        assert_eq!(read_as(ColorType::Grayscale, One, &[0x40]), [[0.0; 3], [255.0; 3]]);
        let colors = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        assert_eq!(read_as(ColorType::Rgba, Eight, &[1, 2, 3, 0, 4, 5, 6, 0]), colors);
        let twice = [1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6];
        assert_eq!(read_as(ColorType::Rgb, Sixteen, &twice), colors);
        assert_eq!(read_as(ColorType::Indexed, One, &[0x40]), colors);
    }

    /// A header alone asks for no memory.
    #[test]
    fn more_pixels_than_a_file_can_hold_are_not_read() {
        for (width, height) in [(8192, 8192), (1 << 30, 1), (1, 1 << 30)] {
            let mut file = Vec::new();
            let mut encoder = Encoder::new(&mut file, width, height);
            encoder.set_color(ColorType::Rgba);
            encoder.set_depth(BitDepth::Sixteen);
            let writer = encoder.write_header().expect("memory");
            drop(writer);
            // An empty chunk of data in place of the end, which has twelve bytes.
            file.truncate(file.len() - 12);
            file.extend(*b"\0\0\0\0IDAT\x35\xaf\x06\x1e");
            let error = read(&file).expect_err("there are no pixels");
            assert!(error.contains("cut off"), "{error}");
        }
    }
}
