//! Images as PNG files.

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::Path;

use renderer::image::Image;

/// Reads an RGB image of 8 bits a channel; `None` if there is no such file.
pub(crate) fn read_png(path: &Path) -> Option<Image<[u8; 3]>> {
    let file = File::open(path).ok()?;
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().expect("a PNG file");
    let mut bytes = vec![0; reader.output_buffer_size().expect("fits in memory")];
    let info = reader.next_frame(&mut bytes).expect("an image");
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    let pixels = bytes.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect();
    Some(Image { width: info.width, height: info.height, pixels })
}

/// Writes an image.
pub(crate) fn write_png(path: &Path, image: &Image<[u8; 3]>) {
    let file = BufWriter::new(File::create(path).expect("a writable file"));
    let mut encoder = png::Encoder::new(file, image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let bytes: Vec<u8> = image.pixels.iter().flatten().copied().collect();
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&bytes).expect("written");
}
