//! The view: pixels to rays (reference 4.1).

use crate::numeric::dd::Dd;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::ray::{Medium, Ray};

/// The part of an image to render, in pixels from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

/// What is seen of a scene: the eye is at (0, 0, -1) and looks along +z, world space being
/// left-handed with y up; the image lies in the plane z = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Width of the whole image in pixels, at least 1.
    pub width: u32,
    /// Height of the whole image in pixels, at least 1.
    pub height: u32,
    /// Horizontal field of view in degrees, above 0 and below 180.
    pub fov_deg: f64,
    /// The pixels to render; all others stay black.
    pub region: Region,
}

/// Where the eye is.
pub(crate) fn eye<R: Real>() -> Vec3<R> {
    Vec3::new(R::ZERO, R::ZERO, -R::ONE)
}

impl View {
    /// A view of the whole image.
    #[must_use]
    pub fn whole(width: u32, height: u32, fov_deg: f64) -> Self {
        View { width, height, fov_deg, region: Region { x: 0, y: 0, width, height } }
    }

    /// The ray from the eye through the centre of a pixel.
    #[inline]
    pub(crate) fn ray<R: Real>(&self, half_pixel: R, column: u32, row: u32) -> Ray<R> {
        let dir = self.direction(half_pixel, column, row);
        Ray { origin: eye(), dir, on: None, medium: Medium::Unknown }
    }

    /// Half the size of a pixel in the image plane.
    pub(crate) fn half_pixel<R: Real>(&self) -> R {
        let (sin, cos) = Dd::sin_cos_degrees(self.fov_deg / 2.0);
        R::from_dd(sin / (cos * Dd::from(f64::from(self.width))))
    }

    /// From the eye through the centre of a pixel, not of unit length: (x, y, 1).
    ///
    /// The integer factors make the directions of mirrored pixels mirror images to the last bit.
    pub(crate) fn direction<R: Real>(&self, half_pixel: R, column: u32, row: u32) -> Vec3<R> {
        let across = 2.0 * f64::from(column) + 1.0 - f64::from(self.width);
        let up = f64::from(self.height) - 1.0 - 2.0 * f64::from(row);
        Vec3::new(R::from_f64(across) * half_pixel, R::from_f64(up) * half_pixel, R::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_those_of_the_reference() {
        let view = View::whole(4, 2, 90.0);
        let half = view.half_pixel::<f64>();
        assert_eq!(half, 0.25);
        assert_eq!(view.direction(half, 0, 0), Vec3::new(-0.75, 0.25, 1.0));
        assert_eq!(view.direction(half, 3, 1), Vec3::new(0.75, -0.25, 1.0));
    }

    #[test]
    fn mirrored_pixels_have_mirrored_directions() {
        let view = View::whole(47, 31, 53.7);
        let half = view.half_pixel::<f64>();
        for column in 0..47 {
            for row in 0..31 {
                let here = view.direction(half, column, row);
                let there = view.direction(half, 46 - column, 30 - row);
                assert_eq!((here.x, here.y), (-there.x, -there.y));
            }
        }
    }
}
