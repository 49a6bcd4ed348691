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

    /// The image plane with each pixel cut into `n` by `n` cells; `n` is at least 1.
    pub(crate) fn grid<R: Real>(&self, n: u32) -> Grid<R> {
        let (width, height) = (u64::from(self.width), u64::from(self.height));
        let (width, height) = (width * u64::from(n), height * u64::from(n));
        let (sin, cos) = Dd::sin_cos_degrees(self.fov_deg / 2.0);
        let half_cell = R::from_dd(sin / (cos * Dd::from(width as f64)));
        Grid { half_cell, width: width as f64, height: height as f64 }
    }
}

/// An image plane cut into cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid<R> {
    /// Half the size of a cell in the image plane.
    half_cell: R,
    /// Number of cells in a row.
    width: f64,
    /// Number of rows.
    height: f64,
}

/// A point of an image plane, in halves of a cell from its upper left corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImagePoint {
    /// To the right.
    pub(crate) right: u64,
    /// Down.
    pub(crate) below: u64,
}

impl ImagePoint {
    /// The centre of a cell.
    pub(crate) fn centre(column: u32, row: u32) -> Self {
        ImagePoint { right: 2 * u64::from(column) + 1, below: 2 * u64::from(row) + 1 }
    }
}

impl<R: Real> Grid<R> {
    /// The ray from the eye through a point.
    #[inline(always)]
    pub(crate) fn ray(&self, through: ImagePoint) -> Ray<R> {
        let dir = self.direction(through);
        Ray { origin: eye(), dir, on: None, medium: Medium::Unknown }
    }

    /// From the eye to such a point, not of unit length: (x, y, 1).
    ///
    /// The integer factors make the directions to mirrored points mirror images to the last bit.
    #[inline(always)]
    fn direction(&self, ImagePoint { right, below }: ImagePoint) -> Vec3<R> {
        let (across, up) = (right as f64 - self.width, self.height - below as f64);
        Vec3::new(R::from_f64(across) * self.half_cell, R::from_f64(up) * self.half_cell, R::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_those_of_the_reference() {
        let view = View::whole(4, 2, 90.0);
        let grid = view.grid::<f64>(1);
        assert_eq!(grid.half_cell, 0.25);
        assert_eq!(grid.direction(ImagePoint::centre(0, 0)), Vec3::new(-0.75, 0.25, 1.0));
        assert_eq!(grid.direction(ImagePoint::centre(3, 1)), Vec3::new(0.75, -0.25, 1.0));
    }

    #[test]
    fn cells_are_the_pixels_of_a_larger_image() {
        let (view, larger) = (View::whole(5, 3, 53.7), View::whole(35, 21, 53.7));
        let (cells, pixels) = (view.grid::<f64>(7), larger.grid::<f64>(1));
        for (column, row) in [(0, 0), (34, 20), (17, 3)] {
            let centre = ImagePoint::centre(column, row);
            assert_eq!(cells.direction(centre), pixels.direction(centre));
        }
    }

    #[test]
    fn mirrored_pixels_have_mirrored_directions() {
        let view = View::whole(47, 31, 53.7);
        for n in [1, 2, 3, 7] {
            let grid = view.grid::<f64>(n);
            let (width, height) = (2 * 47 * u64::from(n), 2 * 31 * u64::from(n));
            for right in 0..=width {
                for below in 0..=height {
                    let mirrored = ImagePoint { right: width - right, below: height - below };
                    let here = grid.direction(ImagePoint { right, below });
                    let there = grid.direction(mirrored);
                    assert_eq!((here.x, here.y), (-there.x, -there.y));
                }
            }
        }
    }
}
