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

pub(super) fn read(bytes: &[u8]) -> Result<Raster, String> {
    let wrong = |error: png::DecodingError| format!("is no proper PNG file: {error}");
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: usize::MAX });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(wrong)?;
    let (width, height) = (reader.info().width, reader.info().height);
    n_pixels(width, height)?;
    let size = reader.output_buffer_size().ok_or("has more pixels than memory")?;
    let mut samples = Vec::new();
    samples.try_reserve_exact(size).map_err(|_| "has more pixels than memory")?;
    samples.resize(size, 0);
    reader.next_frame(&mut samples).map_err(wrong)?;
    let (color, depth) = reader.output_color_type();
    let levels: Vec<f32> = match depth {
        BitDepth::Sixteen => {
            let pairs = samples.as_chunks::<2>().0.iter();
            pairs.map(|&pair| level(u16::from_be_bytes(pair).into(), 65535)).collect()
        }
        _ => samples.iter().map(|&byte| f32::from(byte)).collect(),
    };
    let n_channels = color.samples();
    let pixel = |channels: &[f32]| match channels {
        [red, green, blue, ..] => [*red, *green, *blue],
        [grey, ..] => [*grey; 3],
        [] => [0.0; 3],
    };
    Ok(Raster { width, height, pixels: levels.chunks_exact(n_channels).map(pixel).collect() })
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
}
