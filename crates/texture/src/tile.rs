//! A pattern as a tile of whole numbers, and its exact mean over any box.
//!
//! ```text
//! d = cells − means of blocks − means of rows − means of columns, all at once        255 × 255 cells, 17 × 17 blocks
//! t = d in steps of 1/4096 deviation, rounded so that blocks, rows and columns still sum to 0
//! S(i, j) = Σ t over columns 0 … i−1 and rows 0 … j−1                                256 × 256, exact in i32
//! sum over [x₀, x₁) × [y₀, y₁) = S(x₁, y₁) − S(x₀, y₁) − S(x₁, y₀) + S(x₀, y₀)
//! ```
//!
//! Because whole rows and columns sum to zero, S repeats with the tile: `S(i + 255, j) = S(i, j)`, so that
//! the four looks are exact for boxes of any size anywhere. Between whole cells S is bilinear, which is exact
//! too, as cells are constant.
//!
//! Because each block of 15 × 15 cells, a voxel, sums to zero, the tile changes no mean that a database
//! stores, and dies out by averaging alone.
//!
//! Sources: summed areas, Crow 1984 (*Summed-area tables for texture mapping*); exact averages in place of
//! the estimates of the study of cyclic codes are ours.

use hedgehop_base::error::{Error, Result};

use crate::cell_box::CellBox;
use crate::cells::{Cells, SIDE};
use crate::rounding;

/// Cells along a voxel, whose mean over them is zero.
pub const CELLS_PER_VOXEL: usize = 15;

/// Steps of one standard deviation, unless the pattern has greater peaks than eight of them.
const STEPS_PER_DEVIATION: f64 = 4096.0;

/// Greatest value before rounding, in steps; rounding moves a cell by few.
const MOST_STEPS: f64 = 32_700.0;

/// Entries of a row of the summed areas.
const SUMS_STRIDE: usize = SIDE + 1;

/// Repeating pattern of 255 × 255 cells, with zero mean over every voxel of 15 × 15 cells and unit deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    steps: Vec<i16>,
    sums: Vec<i32>,
    scale: f64,
    contrast_kept: f64,
}

impl Tile {
    /// Makes a tile of any pattern.
    ///
    /// # Errors
    ///
    /// A value is not finite, or nothing is left of the pattern without its means over voxels, rows and
    /// columns.
    pub fn new(cells: &Cells) -> Result<Self> {
        Self::with_steps(cells, STEPS_PER_DEVIATION)
    }

    /// Makes a tile of any pattern in so many steps to one standard deviation, fewer if the pattern has greater peaks: few keep summed areas small.
    ///
    /// # Errors
    ///
    /// As of [`Self::new`].
    pub fn with_steps(cells: &Cells, steps_per_deviation: f64) -> Result<Self> {
        if !cells.values().iter().all(|value| value.is_finite()) {
            return Err(Error::Configuration(
                "a texture pattern has a value that is no finite number".into(),
            ));
        }
        let balanced = without_means(cells);
        let deviation = balanced.deviation();
        let contrast_kept = deviation / cells.deviation();
        if contrast_kept.is_nan() || contrast_kept < 1e-6 {
            return Err(Error::Configuration(format!(
                "nothing is left of a texture pattern without its means over {CELLS_PER_VOXEL} × {CELLS_PER_VOXEL} \
                 cells, rows and columns; want one with finer detail that runs neither along rows nor along columns"
            )));
        }

        // Steps are as fine as the greatest peak allows.
        let peak = balanced.values().iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
        let factor = (steps_per_deviation / deviation).min(MOST_STEPS / peak);
        let values: Vec<f64> = balanced.values().iter().map(|value| value * factor).collect();
        let steps = rounding::balanced(&values, CELLS_PER_VOXEL);

        let squares: f64 = steps.iter().map(|&step| f64::from(step).powi(2)).sum();
        let scale = ((SIDE * SIDE) as f64 / squares).sqrt();
        let sums = summed(&steps);
        Ok(Self { steps: steps.iter().map(|&step| step as i16).collect(), sums, scale, contrast_kept })
    }

    /// Values of all cells in steps, row by row, 255 × 255.
    pub fn steps(&self) -> &[i16] {
        &self.steps
    }

    /// Summed areas in steps: entry 256·j + i is the sum over columns 0 to i − 1 and rows 0 to j − 1, of i
    /// and j from 0 to 255.
    ///
    /// Entries of i = 255 or j = 255 are zero as those of 0 are: whoever looks between entries needs no wrap
    /// for the second.
    pub fn sums(&self) -> &[i32] {
        &self.sums
    }

    /// Value of one step: with it, the tile's standard deviation is 1.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Share of the pattern's deviation that is left without the means over voxels, rows and columns, 0 to 1.
    pub fn contrast_kept(&self) -> f64 {
        self.contrast_kept
    }

    /// Greatest mean over any voxel, deviations; zero by construction.
    pub fn largest_voxel_mean(&self) -> f64 {
        let voxels = 0..SIDE / CELLS_PER_VOXEL;
        let places = voxels.clone().flat_map(|row| voxels.clone().map(move |column| [column, row]));
        places.fold(0.0, |largest, place| {
            let [x0, y0] = place.map(|place| (place * CELLS_PER_VOXEL) as f64);
            let side = CELLS_PER_VOXEL as f64;
            largest.max(self.mean(CellBox { x0, x1: x0 + side, y0, y1: y0 + side }).abs())
        })
    }

    /// Value of any cell of the plane, deviations.
    pub fn value(&self, column: i64, row: i64) -> f64 {
        let wrapped = |place: i64| place.rem_euclid(SIDE as i64) as usize;
        f64::from(self.steps[wrapped(row) * SIDE + wrapped(column)]) * self.scale
    }

    /// Mean over a box anywhere on the ground, deviations, exact up to rounding of the box's corners.
    ///
    /// Not a number of a box without finite corners; see [`CellBox`] for small ones.
    pub fn mean(&self, over: CellBox) -> f64 {
        let wrapped = |place: i64| place.rem_euclid(SIDE as i64) as usize;
        let sum = |column, row| f64::from(self.sums[wrapped(row) * SUMS_STRIDE + wrapped(column)]);
        over.mean_from_sums(sum) * self.scale
    }
}

/// Cells less their means over blocks, whole rows and whole columns.
///
/// The three kinds of means are projections that commute, so that one after the other leaves none of any.
fn without_means(cells: &Cells) -> Cells {
    let side = CELLS_PER_VOXEL as i64;
    let blocks = cells.averaged(CELLS_PER_VOXEL);
    let local =
        Cells::of(|column, row| cells.at(column, row) - blocks.at(column - column % side, row - row % side));

    let line = |mean: &dyn Fn(i64) -> f64| (0..SIDE as i64).map(mean).sum::<f64>() / SIDE as f64;
    let rows: Vec<f64> = (0..SIDE as i64).map(|row| line(&|column| local.at(column, row))).collect();
    let columns: Vec<f64> = (0..SIDE as i64).map(|column| line(&|row| local.at(column, row))).collect();
    Cells::of(|column, row| local.at(column, row) - rows[row as usize] - columns[column as usize])
}

/// Sums over all boxes that begin at the tile's corner.
fn summed(steps: &[i32]) -> Vec<i32> {
    let mut sums = vec![0; SUMS_STRIDE * SUMS_STRIDE];
    for row in 0..SIDE {
        let mut along = 0;
        for column in 0..SIDE {
            along += steps[row * SIDE + column];
            sums[(row + 1) * SUMS_STRIDE + column + 1] = sums[row * SUMS_STRIDE + column + 1] + along;
        }
    }
    sums
}

#[cfg(test)]
#[path = "tile_tests.rs"]
mod tests;
