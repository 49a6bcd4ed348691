//! Where the bands of an image begin and end.

use std::ops::Range;

/// An image has at most so many bands: enough to share out, and few enough not to litter.
const MAX_BANDS: u32 = 64;

/// No band has fewer rows, but for the last one.
const MIN_ROWS: u32 = 4;

/// The rows of each band of an image of this height, by number. This is part of the format of part
/// files: runs share work only if they agree on it.
pub(super) fn bands(height: u32) -> impl Iterator<Item = Range<u32>> {
    let n_rows = height.div_ceil(MAX_BANDS).max(MIN_ROWS);
    (0..height).step_by(n_rows as usize).map(move |first| first..(first + n_rows).min(height))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_have_all_rows_once() {
        for height in [1, 3, 4, 5, 63, 255, 256, 257, 1080, 4_000_000_000] {
            let bands: Vec<_> = bands(height).collect();
            assert!(bands.len() <= MAX_BANDS as usize);
            assert_eq!((bands[0].start, bands[bands.len() - 1].end), (0, height));
            assert!(bands.windows(2).all(|pair| pair[0].end == pair[1].start));
            assert!(bands.iter().all(|band| !band.is_empty()));
        }
    }
}
