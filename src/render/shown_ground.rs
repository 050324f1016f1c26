//! Ground behind a pixel, as the ranges of a canvas show it.

use crate::objects::PixelGround;

/// Inverse ranges of neighbouring pixels that differ by more than this share belong to two surfaces.
const EDGE: f32 = 0.06;

/// The ground that a frame shows.
pub(super) struct ShownGround<'r> {
    pub range: &'r [f32],
    pub width: usize,
}

impl ShownGround<'_> {
    /// The ground in a pixel: its slope is that to neighbours that show the same surface.
    pub fn ground(&self, column: usize, row: usize) -> PixelGround {
        let (at, width, height) = (row * self.width + column, self.width, self.range.len() / self.width);
        let own = 1.0 / self.range[at];
        // No neighbour is of no surface.
        let inverse = |exists: bool, at: usize| if exists { 1.0 / self.range[at] } else { f32::NAN };
        let slope = |before: f32, after: f32| {
            let same = |step: f32| if step.abs() <= EDGE * own { (step, 1.0) } else { (0.0, 0.0_f32) };
            let (before, after) = (same(own - before), same(after - own));
            (before.0 + after.0) / (before.1 + after.1).max(1.0)
        };
        let across = slope(inverse(column > 0, at.wrapping_sub(1)), inverse(column + 1 < width, at + 1));
        let along = slope(inverse(row > 0, at.wrapping_sub(width)), inverse(row + 1 < height, at + width));
        PixelGround { inverse: own, slope: [across, along] }
    }
}
