//! Tiles of the image plane: rays from the eye through one tile begin their search where it is known
//! what all of them may meet.

use crate::camera::{Grid, ImagePoint};
use crate::hierarchy::Start;
use crate::numeric::real::Real;
use crate::ray::Beam;
use crate::scene::Scene;

/// Binary logarithms of a tile's width and height in halves of a cell: 16 by 8 cells. For 7381 spheres
/// half and twice as many cells take as long, within 2 %.
const LOG2_SIZE: [u32; 2] = [5, 4];

/// Columns whose tiles are kept: those of a row of 1024 cells are there when the next row is traced.
const N_COLUMNS: usize = 64;

/// Rows whose tiles are kept: a pixel of nine rows of samples lies in two at most. Of larger ones, a tile
/// that two share is made again for each.
const N_ROWS: usize = 2;

/// The tiles of one grid that a thread has traced.
#[derive(Debug)]
pub(crate) struct Tiles {
    /// Each at its column and row modulo how many are kept, with its column and row.
    kept: Vec<Option<([u64; 2], Start)>>,
    /// The index of that which is traced.
    current: usize,
}

impl Tiles {
    pub(crate) fn new() -> Self {
        Tiles {
            kept: std::iter::repeat_with(|| None).take(N_ROWS * N_COLUMNS).collect(),
            current: 0,
        }
    }

    /// Where the rays through the current tile begin, if there is one.
    #[inline(always)]
    pub(crate) fn start(&self) -> Option<&Start> {
        self.kept[self.current].as_ref().map(|(_, start)| start)
    }

    /// Makes the tile of a point the current one.
    #[inline(always)]
    pub(crate) fn enter<R: Real>(&mut self, point: ImagePoint, grid: &Grid<R>, scene: &Scene<R>) {
        let tile = [point.right >> LOG2_SIZE[0], point.below >> LOG2_SIZE[1]];
        if self.kept[self.current].as_ref().is_none_or(|(current, _)| *current != tile) {
            self.change(tile, grid, scene);
        }
    }

    #[inline(never)]
    fn change<R: Real>(&mut self, tile: [u64; 2], grid: &Grid<R>, scene: &Scene<R>) {
        let [column, row] = tile.map(|index| index as usize);
        self.current = row % N_ROWS * N_COLUMNS + column % N_COLUMNS;
        let kept = &mut self.kept[self.current];
        if kept.as_ref().is_none_or(|(known, _)| *known != tile) {
            *kept = Some((tile, start(tile, grid, scene)));
        }
    }
}

/// Where the rays through a tile begin.
fn start<R: Real>(tile: [u64; 2], grid: &Grid<R>, scene: &Scene<R>) -> Start {
    let [left, top] = [0, 1].map(|axis| tile[axis] << LOG2_SIZE[axis]);
    let [right, bottom] = [0, 1].map(|axis| ((tile[axis] + 1) << LOG2_SIZE[axis]) - 1);
    let corners = [[left, top], [right, top], [left, bottom], [right, bottom]];
    let line = |[right, below]: [u64; 2]| scene.line(&grid.ray(ImagePoint { right, below }));
    Start::new(&scene.hierarchy, Beam::between(&corners.map(line)))
}
