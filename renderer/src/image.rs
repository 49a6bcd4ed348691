//! Images, and the encoding of colours as pixels.

/// What a colour is stored as.
pub trait Pixel: Copy + Send + Sync + Default + PartialEq {
    /// Encodes linear red, green and blue, of any size.
    fn from_linear(color: [f64; 3]) -> Self;

    /// As much of a colour as a pixel can show, in linear light: what means are made of.
    fn shown(color: [f64; 3]) -> [f64; 3];
}

/// Bytes: floor(255 c), with c clamped to [0, 1] and NaN black (reference 4.9).
impl Pixel for [u8; 3] {
    fn from_linear(color: [f64; 3]) -> Self {
        // `as` rounds toward 0, which is down here, clamps, and takes NaN to 0.
        color.map(|c| (255.0 * c) as u8)
    }

    #[inline]
    fn shown(color: [f64; 3]) -> [f64; 3] {
        color.map(|c| if c.is_nan() { 0.0 } else { c.clamp(0.0, 1.0) })
    }
}

/// Linear light, not clamped. There is one zero and one NaN: the sign of a zero hangs on whether a
/// light without effect was added, and the bits of a NaN on what computed it.
impl Pixel for [f32; 3] {
    fn from_linear(color: [f64; 3]) -> Self {
        color.map(|c| if c.is_nan() { f32::NAN } else { 0.0 + c as f32 })
    }

    #[inline]
    fn shown(color: [f64; 3]) -> [f64; 3] {
        color
    }
}

/// The same in full, for differences that are smaller than 32 bits show.
impl Pixel for [f64; 3] {
    fn from_linear(color: [f64; 3]) -> Self {
        color
    }

    #[inline]
    fn shown(color: [f64; 3]) -> [f64; 3] {
        color
    }
}

/// Pixels, row by row from the upper left; `pixels.len() == width * height`.
#[derive(Clone, Debug, PartialEq)]
pub struct Image<P> {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The pixels.
    pub pixels: Vec<P>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_rounded_down_and_clamped() {
        let cases = [
            (0.0, 0),
            (0.5, 127),
            (0.6, 153),
            (1.0, 255),
            (0.999_999, 254),
            (-1.0, 0),
            (7.0, 255),
            (f64::NAN, 0),
            (f64::INFINITY, 255),
            (f64::NEG_INFINITY, 0),
        ];
        for (value, byte) in cases {
            assert_eq!(<[u8; 3]>::from_linear([value; 3]), [byte; 3], "{value}");
            let shown = <[u8; 3]>::shown([value; 3]);
            assert_eq!(<[u8; 3]>::from_linear(shown), [byte; 3], "{value}");
            assert!(shown.iter().all(|c| (0.0..=1.0).contains(c)), "{value}");
        }
    }

    #[test]
    fn zeros_and_nans_are_of_one_kind() {
        let bits = |color| <[f32; 3]>::from_linear(color).map(f32::to_bits);
        assert_eq!(bits([0.0, -0.0, -1e-300]), [0; 3]);
        let other = f64::from_bits(f64::NAN.to_bits() | 1 << 63 | 1 << 40);
        assert_eq!(bits([f64::NAN, -f64::NAN, other]), [0x7fc0_0000; 3]);
        assert_eq!(bits([-1.0, 0.5, f64::INFINITY]), [0xbf80_0000, 0x3f00_0000, 0x7f80_0000]);
    }
}
