//! Natural ground: what rasters and clouds make of it, before features and objects.

use super::built::Tiles;
use super::warp::Rect;
use hedgehop::voxel::{Grid, HeightCode};
use hedgehop_base::error::Result;

/// Natural ground of a block of voxels.
#[derive(Debug, Clone, Copy)]
pub(super) struct NaturalBlock<'a> {
    /// The block.
    pub rect: Rect,
    /// Heights of its voxels, row-major, metres; NaN where there is none.
    pub heights: &'a [f64],
}

/// Maker of natural ground on the finest level of a database.
pub(super) trait NaturalGround {
    /// Returns the finest grid.
    fn grid(&self) -> Grid;

    /// Returns the coding of heights.
    fn code(&self) -> HeightCode;

    /// Returns the heights of the voxels of `rect`, row-major, metres, NaN where there is none.
    ///
    /// # Errors
    /// A raster that cannot be read.
    fn natural(&mut self, rect: Rect) -> Result<Vec<f64>>;

    /// Returns the squares of ground that were made last.
    fn tiles(&mut self) -> &mut Tiles;
}
