//! Result of the survey of one source of elevation.

use serde::{Deserialize, Serialize};

use super::synthetic::Energies;

/// Result of the survey of one source of elevation.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Survey {
    /// Lowest and highest sample, metres above the source's datum; `None` if all are void.
    pub range: Option<(f64, f64)>,
    /// Mean heights of cells; `None` if all are void.
    pub coarse: Option<Coarse>,
    /// Notes on what was assumed or repaired in it, one sentence each.
    pub notes: Vec<String>,
    /// Curvatures, from which detail takes its roughness; of none unless they were asked for.
    pub energies: Energies,
}

/// Means of a raster's heights on a few cells, complete.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Coarse {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Raster pixels per cell.
    pub(super) pixels: (f64, f64),
    pub(super) means: Vec<f64>,
}

impl Coarse {
    /// Height at a position in pixels (whole numbers at pixel centres), metres above the source's datum.
    pub fn at(&self, column: f64, row: f64) -> f64 {
        let place = |pixel: f64, pixels: f64, count: usize| {
            let place = ((pixel + 0.5) / pixels - 0.5).clamp(0.0, count as f64 - 1.0);
            let cell = (place as usize).min(count.saturating_sub(2));
            (cell, (cell + 1).min(count - 1), place - cell as f64)
        };
        let (west, east, u) = place(column, self.pixels.0, self.columns);
        let (north, south, v) = place(row, self.pixels.1, self.rows);
        let mean = |column: usize, row: usize| self.means[row * self.columns + column];
        (mean(west, north) * (1.0 - u) + mean(east, north) * u) * (1.0 - v)
            + (mean(west, south) * (1.0 - u) + mean(east, south) * u) * v
    }
}
