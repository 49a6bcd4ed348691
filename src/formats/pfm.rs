//! PFM: a text header, then rows from the bottom, 32-bit floating point channels.

use std::io::{self, Write};

use crate::formats::{Header, Raster, n_pixels};

pub(super) fn write(
    width: u32,
    height: u32,
    pixels: &[[f32; 3]],
    out: &mut dyn Write,
) -> io::Result<()> {
    // A negative scale says that the bytes are in little-endian order.
    write!(out, "PF\n{width} {height}\n-1.0\n")?;
    let mut row_bytes = Vec::with_capacity(width as usize * 12);
    for row in pixels.chunks_exact(width as usize).rev() {
        row_bytes.clear();
        row_bytes.extend(row.as_flattened().iter().flat_map(|channel| channel.to_le_bytes()));
        out.write_all(&row_bytes)?;
    }
    Ok(())
}

pub(super) fn read(bytes: &[u8]) -> Result<Raster, String> {
    let is_grey = bytes.starts_with(b"Pf");
    let mut header = Header::new(bytes);
    let (width, height) = (header.number()?, header.number()?);
    let scale: f64 = header.number()?;
    let n_pixels = n_pixels(width, height)?;
    let n_channels = if is_grey { n_pixels } else { 3 * n_pixels };
    let samples = header
        .rest()
        .get(..4 * n_channels)
        .ok_or("it is cut off: there are fewer pixels than its header says")?;
    let level = |&four: &[u8; 4]| {
        let value = if scale < 0.0 { f32::from_le_bytes(four) } else { f32::from_be_bytes(four) };
        value * 255.0
    };
    let channels: Vec<f32> = samples.as_chunks::<4>().0.iter().map(level).collect();
    let from_bottom: Vec<[f32; 3]> = if is_grey {
        channels.iter().map(|&channel| [channel; 3]).collect()
    } else {
        channels.as_chunks::<3>().0.to_vec()
    };
    let rows = from_bottom.chunks_exact(width as usize).rev();
    Ok(Raster { width, height, pixels: rows.flatten().copied().collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let pixels = [[0.0, 0.5, 1.0], [-1.0, 2.0, 1e30]];
        let mut file = Vec::new();
        write(1, 2, &pixels, &mut file).expect("memory");
        assert!(file.starts_with(b"PF\n1 2\n-1.0\n"));
        let raster = read(&file).expect("well formed");
        assert_eq!(raster.pixels, pixels.map(|pixel| pixel.map(|channel| channel * 255.0)));
    }

    #[test]
    fn big_endian_grey_is_read_and_short_files_are_not() {
        let raster = read(b"Pf 1 1 1.0\n\x3f\x80\x00\x00").expect("well formed");
        assert_eq!(raster.pixels, [[255.0; 3]]);
        assert!(read(b"PF 1 1 1.0\n\x3f\x80\x00\x00").is_err());
        assert!(read(b"PF 1 1 x\n").is_err());
    }
}
