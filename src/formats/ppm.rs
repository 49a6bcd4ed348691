//! PPM: a text header, then rows from the top, three channels a pixel.

use std::io::{self, Write};

use crate::formats::{Header, Raster, level, n_pixels};

pub(super) fn write(
    width: u32,
    height: u32,
    pixels: &[[u8; 3]],
    out: &mut dyn Write,
) -> io::Result<()> {
    write!(out, "P6\n# gmlvm\n{width} {height}\n255\n")?;
    out.write_all(pixels.as_flattened())
}

pub(super) fn read(bytes: &[u8]) -> Result<Raster, String> {
    let mut header = Header::new(bytes);
    let (width, height) = (header.number()?, header.number()?);
    let max: u32 = header.number()?;
    if !(1..=65535).contains(&max) {
        return Err(format!("its largest value is {max}, which must be from 1 to 65535"));
    }
    let n_channels = 3 * n_pixels(width, height)?;
    let sample_bytes = if max > 255 { 2 } else { 1 };
    let samples = header
        .rest()
        .get(..n_channels * sample_bytes)
        .ok_or("it is cut off: there are fewer pixels than its header says")?;
    let channels: Vec<f32> = if max > 255 {
        let pairs = samples.as_chunks::<2>().0.iter();
        pairs.map(|&pair| level(u16::from_be_bytes(pair).into(), max)).collect()
    } else {
        samples.iter().map(|&byte| level(byte.into(), max)).collect()
    };
    Ok(Raster { width, height, pixels: channels.as_chunks::<3>().0.to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let pixels = [[0, 1, 2], [10, b'#', 255]];
        let mut file = Vec::new();
        write(2, 1, &pixels, &mut file).expect("memory");
        assert_eq!(file, b"P6\n# gmlvm\n2 1\n255\n\x00\x01\x02\x0a#\xff");
        let raster = read(&file).expect("well formed");
        assert_eq!(raster.pixels, [[0.0, 1.0, 2.0], [10.0, 35.0, 255.0]]);
    }

    #[test]
    fn sixteen_bits_and_odd_headers() {
        let raster = read(b"P6 #a\n1#b\n 1\t65535\n\x80\x80\x00\x00\xff\xff").expect("well formed");
        assert_eq!(raster.pixels, [[128.0, 0.0, 255.0]]);
        let error = |bytes: &[u8]| read(bytes).expect_err("malformed");
        assert!(error(b"P6\n2 2\n255\nabc").contains("cut off"));
        assert!(error(b"P6\n2").contains("cut off"));
        assert!(error(b"P6\n-2 2\n255\n").contains("wrong"));
        assert!(error(b"P6\n0 2\n255\n").contains("no pixels"));
        assert!(error(b"P6\n4000000000 4000000000\n255\n").contains("more than"));
        assert!(error(b"P6\n1 1\n70000\nabcdef").contains("70000"));
    }
}
