//! Part files: whatever a file holds, reading it ends; and what is taken for a part was written as one.

use crate::args::ImageFormat;
use crate::fuzzed::take;
use crate::parts::file::{Band, Header, ImagePlace, Kind, Trouble, lines_of, whole};

/// Makes a file as the bytes say and reads it as a part; whether it was taken.
///
/// The first byte says what kind of file: one of any bytes; one whose header is any bytes while its
/// checksum is right; or a part that was written, with something changed, which is never taken.
///
/// # Panics
/// When a file is taken that should not be, or not read as it was written.
pub fn any_part(mut bytes: &[u8]) -> bool {
    match take(&mut bytes) % 3 {
        0 => read_any(bytes),
        1 => {
            let at = usize::from(take(&mut bytes)).min(bytes.len());
            let (header, pixels) = bytes.split_at(at);
            let header: Result<Header, _> = serde_json::from_slice(header);
            header.is_ok_and(|header| read_any(&file_of(&header, pixels)))
        }
        _ => read_written(bytes),
    }
}

fn file_of(header: &Header, pixels: &[u8]) -> Vec<u8> {
    let lines = lines_of(header, pixels).expect("headers can be written");
    [lines.as_bytes(), pixels].concat()
}

/// What is taken is sound, and is the same when it is written and read again.
fn read_any(file: &[u8]) -> bool {
    // A file may shrink or grow after its length was asked for.
    for length in [file.len() as u64 / 2, file.len() as u64 + 1, u64::MAX] {
        assert!(whole(file, length).is_err(), "taken with another length");
    }
    let Ok((header, pixels)) = whole(file, file.len() as u64) else { return false };
    if let Kind::Band(Band { image, rows }) = &header.part {
        assert!(rows.start < rows.end && rows.end <= image.height, "rows outside the image");
        let per_pixel = if image.is_linear { 12 } else { 3 };
        let n_pixels = u64::from(rows.end - rows.start) * u64::from(image.width);
        assert_eq!(pixels.len() as u64, n_pixels * per_pixel, "not its pixels");
    }
    let again = file_of(&header, &pixels);
    let read = whole(&again[..], again.len() as u64).expect("what was taken is taken again");
    assert_eq!(read, (header, pixels));
    true
}

/// A part of some small image is read as it was written, and with any change is no part.
fn read_written(mut bytes: &[u8]) -> bool {
    let mut small = |n: u8| u32::from(take(&mut bytes) % n);
    let (width, height) = (1 + small(4), 1 + small(6));
    let top = small(6).min(height - 1);
    let rows = top..top + 1 + small(6).min(height - top - 1);
    let (is_linear, change, at) = (small(2) == 1, small(4), small(255) << 8 | small(255));
    let names = ["a.ppm", "", "../\n\u{1b}", "\u{e9}\u{10ffff}\"\\"];
    let image = ImagePlace {
        number: u64::from(small(3)),
        name: names[small(4) as usize].to_owned(),
        width,
        height,
        all_rows: 0..height,
        is_linear,
        format: if is_linear { ImageFormat::Pfm } else { ImageFormat::Png },
    };
    let n_pixels = (rows.end - rows.start) * width * if is_linear { 12 } else { 3 };
    let pixels: Vec<u8> = (0..n_pixels).map(|_| take(&mut bytes)).collect();
    let of = r#"{"gmlvm":"1","scene":"2","settings":"3"}"#;
    let of = serde_json::from_str(of).expect("an identity");
    let header = Header { of, part: Kind::Band(Band { image, rows }) };
    let file = file_of(&header, &pixels);
    let read = whole(&file[..], file.len() as u64);
    assert_eq!(read.expect("what was written is taken"), (header, pixels));
    let at = at as usize % file.len();
    let mut changed = file.clone();
    match change {
        0 => changed[at] ^= 1 | take(&mut bytes),
        1 => changed.truncate(at),
        2 => drop(changed.remove(at)),
        _ => changed.insert(at, take(&mut bytes)),
    }
    let taken = whole(&changed[..], changed.len() as u64);
    let is_noticed = matches!(taken, Err(Trouble::Damaged(_) | Trouble::Unknown(_)));
    assert!(is_noticed, "{change} at {at} is not noticed");
    true
}
