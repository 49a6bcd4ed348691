//! How far an image is from a reference, in bytes and in linear light.

use renderer::image::Pixel;

use crate::chart::data::Errors;

/// A pixel in linear light; none where its surface function fails.
pub(super) type Light = Option<[f64; 3]>;

/// Sums over pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    errors: Errors,
    max: f64,
    squares: f64,
    n_channels: u64,
}

impl Sums {
    /// Adds the pixels of an image and of its reference.
    pub(super) fn add(&mut self, image: &[Light], reference: &[Light]) {
        for (pixel, expected) in image.iter().zip(reference) {
            self.add_pixel(pixel, expected);
        }
    }

    fn add_pixel(&mut self, pixel: &Light, expected: &Light) {
        let (Some(pixel), Some(expected)) = (pixel, expected) else {
            let is_missing = u64::from(pixel.is_some() != expected.is_some());
            self.errors.differing += is_missing;
            self.errors.gross += is_missing;
            self.errors.missing += is_missing;
            return;
        };
        let bytes = [pixel, expected].map(|light| <[u8; 3]>::from_linear(*light));
        let levels = (0..3).map(|c| bytes[0][c].abs_diff(bytes[1][c])).max().unwrap_or(0);
        self.errors.differing += u64::from(levels > 0);
        // Where the exact value is close to the edge of a byte, rounding moves it across one edge.
        self.errors.gross += u64::from(levels > 1);
        for (channel, expected) in pixel.iter().zip(expected) {
            // Infinities of one sign are the same, and NaN is as wrong as can be.
            let same = channel == expected || (channel.is_nan() && expected.is_nan());
            let difference = if same { 0.0 } else { (channel - expected).abs() };
            self.max =
                if difference > self.max || difference.is_nan() { difference } else { self.max };
            self.squares += difference * difference;
            self.n_channels += 1;
        }
    }

    /// What they come to.
    pub(super) fn errors(self) -> Errors {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let mean = self.squares / self.n_channels.max(1) as f64;
        Errors { max: finite(self.max), rms: finite(mean.sqrt()), ..self.errors }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_counted_by_kind() {
        let gray = |c: f64| Some([c; 3]);
        let reference = [0.5, 0.5, 0.5, 0.5, 2.0].map(gray);
        // Equal, within a byte, one level off, a whole colour off; and above what a byte holds.
        let mut image = [0.5, 0.5 + 1e-9, 0.5 + 1.0 / 255.0, 1.0, 3.0].map(gray);
        let mut sums = Sums::default();
        sums.add(&image, &reference);
        let errors = sums.errors();
        assert_eq!((errors.differing, errors.gross, errors.missing), (2, 1, 0));
        assert_eq!(errors.max, Some(1.0));
        let mean = (1e-18 + (1.0_f64 / 255.0).powi(2) + 0.25 + 1.0) / 5.0;
        let rms = errors.rms.expect("finite");
        // A dozen roundings.
        assert!((rms - mean.sqrt()).abs() < 12.0 * f64::EPSILON, "{rms}");

        image[0] = None;
        image[1] = gray(f64::NAN);
        let mut sums = Sums::default();
        sums.add(&image, &reference);
        let Errors { differing, gross, missing, max, rms } = sums.errors();
        assert_eq!((differing, gross, missing, max, rms), (4, 3, 1, None, None));
    }
}
