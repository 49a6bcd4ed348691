//! Images of which a pixel is the mean of many samples.
//!
//! Samples are taken at points that depend on the pixel alone, and mirror images of points are points:
//! so an image is the same every time, and one of a symmetric scene is symmetric. Means are made of what
//! samples show as pixels, in linear light: a bright highlight that covers a tenth of a pixel weighs
//! as much as what is seen of it, a tenth. So the edges of bright things are as smooth as others, and
//! the image is that of `n` times the size, made smaller.
//!
//! Where it is decided how finely a pixel is looked at, the samples are at its corners, which
//! neighbours share. Where the four corners of a square have the same [signature](crate::signature),
//! its colour is their mean; elsewhere it is that of its quarters. What is so small that it lies
//! between the corners of a pixel is not found.

use crate::camera::{ImagePoint, View};
use crate::image::{Image, Pixel};
use crate::numeric::dd::Dd;
use crate::numeric::real::Real;
use crate::numeric::vec3::Vec3;
use crate::render::{Failure, pixels, render};
use crate::scene::Scene;
use crate::shade::{Illumination, RayCounts, Shader};
use crate::signature::Signature;
use crate::surface::SurfaceEval;

/// Which points of the image plane make a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Its centre.
    #[default]
    Centre,
    /// The centres of so many cells in each direction, at least 1.
    Grid(u32),
    /// The corners of squares: of the pixel, and of quarters of squares whose corners look different,
    /// down to quarters of quarters so deep.
    Adaptive(u32),
}

impl Sampling {
    /// The most cells of a pixel in each direction.
    pub const MAX_GRID: u32 = 64;

    /// The most times that a pixel is divided: into as many parts as cells.
    pub const MAX_DEPTH: u32 = Self::MAX_GRID.ilog2();
}

/// Linear red, green and blue.
type Color = [f64; 3];

/// Rows of pixels that one thread samples in a row, and so shares corners between: so many that the
/// corners of the first, which are shared with nobody, are an eighth more.
const ROWS_OF_BAND: u32 = 8;

/// So many corners of a row are kept at most, which takes 5 MiB for each thread. In wider images some
/// corners are sampled twice.
const MAX_CORNERS: usize = 1 << 16;

/// Renders an image as [`render`] does, from other samples than those at the centres.
///
/// # Errors
/// The failure of the first pixel, in reading order, that has one.
pub fn sample<R: Real, E: SurfaceEval + Send, P: Pixel>(
    scene: &Scene<R>,
    illumination: &Illumination,
    view: &View,
    sampling: Sampling,
    worker: impl Fn() -> E + Sync,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<(Image<P>, RayCounts), Failure<E::Error>> {
    let shader = |grid| Shader::new(scene, grid, illumination, worker());
    let (pixels, counts) = match sampling {
        Sampling::Centre => return render(scene, illumination, view, worker, progress),
        Sampling::Grid(n) => {
            let n = n.clamp(1, Sampling::MAX_GRID);
            let make = || shader(view.grid(n));
            let cells = |shader: &mut _, column, row| cells::<_, _, P>(shader, n, [column, row]);
            let (pixels, shaders) = pixels(view, 1, make, progress, cells)?;
            (pixels, shaders.iter().map(|shader| shader.counts).sum())
        }
        Sampling::Adaptive(depth) => {
            let size = 1 << depth.min(Sampling::MAX_DEPTH);
            let make = || Dividing::new(shader(view.grid(size)), view, size);
            let square = |dividing: &mut Dividing<_, _>, column, row| {
                dividing.pixel::<P>(column, row).map(P::from_linear)
            };
            let (pixels, all) = pixels(view, ROWS_OF_BAND as usize, make, progress, square)?;
            (pixels, all.iter().map(|dividing| dividing.shader.counts).sum())
        }
    };
    Ok((Image { width: view.width, height: view.height, pixels }, counts))
}

/// What a sample shows as a pixel.
fn shown<R: Real, P: Pixel>(light: Vec3<R>) -> Color {
    P::shown(light.map(R::to_f64).into())
}

/// A pixel from `n` by `n` cells.
fn cells<R: Real, E: SurfaceEval, P: Pixel>(
    shader: &mut Shader<'_, R, E>,
    n: u32,
    [column, row]: [u32; 2],
) -> Result<P, E::Error> {
    let [left, top] = [column, row].map(|at| 2 * u64::from(at) * u64::from(n) + 1);
    let middle = |cell: u32| 2 * u64::from(cell);
    let mut rows = [[Dd::ZERO; 3]; Sampling::MAX_GRID as usize];
    for (below, sum) in (0..n).zip(&mut rows) {
        let mut cells = [[Dd::ZERO; 3]; Sampling::MAX_GRID as usize];
        for (right, cell) in (0..n).zip(&mut cells) {
            let centre = ImagePoint { right: left + middle(right), below: top + middle(below) };
            let light = shader.radiance(centre)?;
            *cell = shown::<R, P>(light).map(Dd::from);
        }
        *sum = folded_sum(&cells[..n as usize]);
    }
    let n_cells = Dd::from(f64::from(n * n));
    let sum = folded_sum(&rows[..n as usize]);
    Ok(P::from_linear(sum.map(|sum| (sum / n_cells).to_f64())))
}

/// The sum of colours, which is the same to the last bit for those in reverse. In double-double, the
/// mean of equal colours is that colour.
fn folded_sum(colors: &[[Dd; 3]]) -> [Dd; 3] {
    let n = colors.len();
    let mut sum = if n % 2 == 1 { colors[n / 2] } else { [Dd::ZERO; 3] };
    for (one, other) in colors[..n / 2].iter().zip(colors.iter().rev()) {
        sum = std::array::from_fn(|channel| sum[channel] + (one[channel] + other[channel]));
    }
    sum
}

/// What was seen at a point.
#[derive(Clone, Copy)]
struct Sample {
    color: Color,
    /// That of no decisions where nobody compares it.
    signature: Signature,
}

/// Samples pixels by dividing them, for one thread.
struct Dividing<'s, R, E> {
    /// Of the smallest squares.
    shader: Shader<'s, R, E>,
    /// How many of them are a pixel, in each direction.
    size: u32,
    /// The first row of the first band.
    first_row: u32,
    /// The row of the pixel sampled last.
    row: Option<u32>,
    /// The corners of pixels that are known, above that row and below it, with their columns: each is
    /// kept at its column modulo the length.
    corners: [Vec<Option<(u32, Sample)>>; 2],
    /// The points of a pixel that are known, row by row.
    points: Vec<Option<Sample>>,
}

/// A square within a pixel.
#[derive(Clone, Copy)]
struct Square {
    /// The column and row of the pixel.
    pixel: [u32; 2],
    /// The upper left corner within the pixel, to the right and below, in smallest squares.
    at: [u32; 2],
    /// Length of a side, in smallest squares.
    size: u32,
}

impl<'s, R: Real, E: SurfaceEval> Dividing<'s, R, E> {
    fn new(shader: Shader<'s, R, E>, view: &View, size: u32) -> Self {
        let n_corners = (view.width as usize + 1).min(MAX_CORNERS);
        let n_points = (size as usize + 1) * (size as usize + 1);
        Dividing {
            shader,
            size,
            first_row: view.region.y,
            row: None,
            corners: [vec![None; n_corners], vec![None; n_corners]],
            points: vec![None; n_points],
        }
    }

    /// The mean over a pixel.
    fn pixel<P: Pixel>(&mut self, column: u32, row: u32) -> Result<Color, E::Error> {
        self.enter(row);
        let corners = [
            self.corner::<P>(column, row, 0)?,
            self.corner::<P>(column + 1, row, 0)?,
            self.corner::<P>(column, row, 1)?,
            self.corner::<P>(column + 1, row, 1)?,
        ];
        if self.size > 1 && !are_alike(&corners) {
            self.points.fill(None);
        }
        let all = Square { pixel: [column, row], at: [0, 0], size: self.size };
        self.square::<P>(all, &corners)
    }

    /// Begins a row of pixels, unless it has begun. Its upper corners are the lower ones of the row
    /// above, except in the first row of a band: the number of samples must not depend on which threads
    /// got which bands.
    fn enter(&mut self, row: u32) {
        if self.row == Some(row) {
            return;
        }
        self.corners.swap(0, 1);
        let is_first = (row - self.first_row).is_multiple_of(ROWS_OF_BAND);
        if is_first {
            self.corners[0].fill(None);
        }
        self.corners[1].fill(None);
        self.row = Some(row);
    }

    /// A corner of pixels, above the current row (0) or below it (1).
    fn corner<P: Pixel>(&mut self, column: u32, row: u32, below: u32) -> Result<Sample, E::Error> {
        let place = column as usize % self.corners[0].len();
        match self.corners[below as usize][place] {
            Some((known, corner)) if known == column => Ok(corner),
            _ => {
                let corner = self.point::<P>([column, row + below], [0, 0])?;
                self.corners[below as usize][place] = Some((column, corner));
                Ok(corner)
            }
        }
    }

    /// The mean over a square with these corners: upper left, upper right, lower left, lower right.
    fn square<P: Pixel>(
        &mut self,
        square: Square,
        corners: &[Sample; 4],
    ) -> Result<Color, E::Error> {
        if square.size == 1 || are_alike(corners) {
            return Ok(mean(corners.map(|corner| corner.color)));
        }
        let half = square.size / 2;
        let [above_left, above_right, below_left, below_right] = *corners;
        let above = self.inner_point::<P>(square, [half, 0])?;
        let left = self.inner_point::<P>(square, [0, half])?;
        let middle = self.inner_point::<P>(square, [half, half])?;
        let right = self.inner_point::<P>(square, [square.size, half])?;
        let below = self.inner_point::<P>(square, [half, square.size])?;
        let mut quarter = |[right, below]: [u32; 2], corners| {
            let at = [square.at[0] + right, square.at[1] + below];
            self.square::<P>(Square { at, size: half, ..square }, corners)
        };
        Ok(mean([
            quarter([0, 0], &[above_left, above, left, middle])?,
            quarter([half, 0], &[above, above_right, middle, right])?,
            quarter([0, half], &[left, middle, below_left, below])?,
            quarter([half, half], &[middle, right, below, below_right])?,
        ]))
    }

    /// A point of the current pixel, by its place within a square.
    fn inner_point<P: Pixel>(
        &mut self,
        Square { pixel, at, .. }: Square,
        [right, below]: [u32; 2],
    ) -> Result<Sample, E::Error> {
        let at = [at[0] + right, at[1] + below];
        let index = (at[1] * (self.size + 1) + at[0]) as usize;
        if let Some(point) = self.points[index] {
            return Ok(point);
        }
        let point = self.point::<P>(pixel, at)?;
        self.points[index] = Some(point);
        Ok(point)
    }

    /// A new sample, at a point that lies so far to the right of a pixel's upper left corner and below
    /// it.
    fn point<P: Pixel>(
        &mut self,
        [column, row]: [u32; 2],
        [right, below]: [u32; 2],
    ) -> Result<Sample, E::Error> {
        let place = |pixel: u32, within: u32| {
            2 * (u64::from(pixel) * u64::from(self.size) + u64::from(within))
        };
        let at = ImagePoint { right: place(column, right), below: place(row, below) };
        // Only the smallest squares have corners at odd places.
        let is_compared = right % 2 == 0 && below % 2 == 0;
        let (light, signature) = if is_compared {
            self.shader.signed_radiance(at)?
        } else {
            (self.shader.radiance(at)?, Signature::NONE)
        };
        Ok(Sample { color: shown::<R, P>(light), signature })
    }
}

fn are_alike(corners: &[Sample; 4]) -> bool {
    corners[1..].iter().all(|corner| corner.signature == corners[0].signature)
}

/// The mean of four colours in two rows, which is the same to the last bit if the rows or their ends
/// change places.
fn mean([a, b, c, d]: [Color; 4]) -> Color {
    std::array::from_fn(|channel| 0.25 * ((a[channel] + b[channel]) + (c[channel] + d[channel])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of sizes so different that the order of sums matters.
    const NUMBERS: [f64; 10] = [0.1, 1.0, 1e-17, 0.7, 3e-9, 0.3, 1e-16, 0.9, 5e-13, 0.2];

    #[test]
    fn means_do_not_depend_on_what_is_left_or_above() {
        for numbers in NUMBERS.windows(4) {
            let of = |order: [usize; 4]| mean(order.map(|index| [numbers[index]; 3]));
            let one = of([0, 1, 2, 3]);
            assert_eq!(of([1, 0, 3, 2]), one, "from side to side");
            assert_eq!(of([2, 3, 0, 1]), one, "upside down");
        }
    }

    #[test]
    fn sums_are_the_same_from_either_end() {
        for n in 1..=NUMBERS.len() {
            let mut colors: Vec<[Dd; 3]> =
                NUMBERS[..n].iter().map(|&x| [Dd::from(x) / Dd::from(3.0); 3]).collect();
            let sum = folded_sum(&colors);
            colors.reverse();
            assert_eq!(folded_sum(&colors), sum);
            let plain: f64 = NUMBERS[..n].iter().sum();
            // The plain sum rounds at each step, by half a unit of at most the sum.
            let tolerance = n as f64 * f64::EPSILON * plain;
            assert!((3.0 * sum[0].to_f64() - plain).abs() <= tolerance);
        }
    }
}
