//! Tiles of the image plane: rays from the eye through one tile begin their search where it is known
//! what all of them may meet.

use crate::camera::{Grid, ImagePoint};
use crate::hierarchy::Start;
use crate::numeric::real::Real;
use crate::ray::Beam;
use crate::scene::Scene;

/// The size of a tile in halves of a cell, across and down, as powers of 2: 16 by 8 cells. For 7381
/// spheres half and twice as many take as long, within 2 %.
const SIZE: [u32; 2] = [5, 4];

/// Tiles that are kept, by column: those of a row of 1024 cells are there when the next row is traced.
const N_KEPT: usize = 64;

/// The tiles of one grid that a thread has traced.
#[derive(Debug)]
pub(crate) struct Tiles {
    /// Each at its column modulo the length, with its column and row.
    kept: Vec<Option<([u64; 2], Start)>>,
    /// The index of that which is traced.
    current: usize,
}

impl Tiles {
    pub(crate) fn new() -> Self {
        Tiles { kept: std::iter::repeat_with(|| None).take(N_KEPT).collect(), current: 0 }
    }

    /// Where the rays through the current tile begin, if there is one.
    #[inline(always)]
    pub(crate) fn start(&self) -> Option<&Start> {
        self.kept[self.current].as_ref().map(|(_, start)| start)
    }

    /// Makes the tile of a point the current one.
    #[inline(always)]
    pub(crate) fn enter<R: Real>(&mut self, point: ImagePoint, grid: &Grid<R>, scene: &Scene<R>) {
        let tile = [point.right >> SIZE[0], point.below >> SIZE[1]];
        if self.kept[self.current].as_ref().is_none_or(|(current, _)| *current != tile) {
            self.change(tile, grid, scene);
        }
    }

    #[inline(never)]
    fn change<R: Real>(&mut self, tile: [u64; 2], grid: &Grid<R>, scene: &Scene<R>) {
        self.current = tile[0] as usize % N_KEPT;
        let kept = &mut self.kept[self.current];
        if kept.as_ref().is_none_or(|(known, _)| *known != tile) {
            *kept = Some((tile, start(tile, grid, scene)));
        }
    }
}

/// Where the rays through a tile begin.
fn start<R: Real>(tile: [u64; 2], grid: &Grid<R>, scene: &Scene<R>) -> Start {
    let [left, top] = [0, 1].map(|axis| tile[axis] << SIZE[axis]);
    let [right, bottom] = [0, 1].map(|axis| ((tile[axis] + 1) << SIZE[axis]) - 1);
    let corners = [[left, top], [right, top], [left, bottom], [right, bottom]];
    let line = |[right, below]: [u64; 2]| scene.line(&grid.ray(ImagePoint { right, below }));
    Start::new(&scene.hierarchy, Beam::between(&corners.map(line)))
}
