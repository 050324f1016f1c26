//! Light of a fine picture over what voxels of it would show.
//!
//! ```text
//! posts     means of cells over voxels; what detail makes of them: luminance that keeps means, and relative deviations
//! value     (light / light between posts − 1) / relative deviation          of each cell
//! ```

use crate::drape::Pigment;
use glam::Vec3;
use hedgehop::detail::PostLight;
use hedgehop_base::colour::LUMINANCE;
use hedgehop_texture::{CELLS_PER_VOXEL, Swatch};

/// Voxels along a window.
pub(super) const WINDOW_VOXELS: usize = INNER_VOXELS + 2 * (PostLight::MARGIN + 1);

/// Voxels along the part of a window that patterns take.
const INNER_VOXELS: usize = 20;

/// Opacity from which on a cell has a colour.
const OPAQUE: f32 = 0.999;

/// Least light, of white, and least relative deviation that values are relative to.
const LEAST_LIGHT: f32 = 1.0e-3;
const LEAST_DEVIATION: f32 = 0.02;

/// Greatest value: single glints and cars say little of ground.
const MOST_VALUE: f32 = 5.0;

/// Cells along a window.
const SIDE: usize = WINDOW_VOXELS * CELLS_PER_VOXEL;

/// Values of a window.
pub(super) struct FineWindow {
    /// Light over what voxels show, per relative deviation that they foretell.
    pub swatch: Swatch,
    /// Relative deviations of its voxels, row by row.
    roughness: Vec<f32>,
}

impl FineWindow {
    /// Takes cells of [`WINDOW_VOXELS`] voxels along either axis; `None` where some have no colour.
    pub fn new(cells: &[Pigment]) -> Option<Self> {
        if cells.len() != SIDE * SIDE || cells.iter().any(|cell| cell.alpha < OPAQUE) {
            return None;
        }
        let light: Vec<f32> = cells.iter().map(|cell| Vec3::from_array(cell.linear).dot(LUMINANCE)).collect();
        let posts = PostLight::of(&posts(&light), [WINDOW_VOXELS; 2]);

        // The first post of these lies a voxel before the first voxel that is taken.
        let first = (PostLight::MARGIN + 1) * CELLS_PER_VOXEL;
        let inner = INNER_VOXELS * CELLS_PER_VOXEL;
        let mut values = Vec::with_capacity(inner * inner);
        for row in 0..inner {
            for column in 0..inner {
                let at = PostPlace::of(column, row, posts.size[0]);
                let shown = at.between(&posts.luminance).max(LEAST_LIGHT);
                let deviation = at.between(&posts.deviations).max(LEAST_DEVIATION);
                let change = light[(first + row) * SIDE + first + column] / shown - 1.0;
                values.push((change / deviation).clamp(-MOST_VALUE, MOST_VALUE));
            }
        }
        let inner_posts = posts.deviations.chunks_exact(posts.size[0]).skip(1).take(INNER_VOXELS);
        let roughness = inner_posts.flat_map(|row| row[1..=INNER_VOXELS].to_vec()).collect();
        Some(Self { swatch: Swatch::new(INNER_VOXELS, values)?, roughness })
    }

    /// Relative deviations of voxels, row by row.
    pub fn roughness(&self) -> &[f32] {
        &self.roughness
    }

    /// Mean relative deviation of a square of voxels.
    pub fn roughness_of(&self, [x, y]: [usize; 2], side: usize) -> f32 {
        let rows = (y..y + side).map(|row| &self.roughness[row * INNER_VOXELS + x..][..side]);
        rows.flatten().sum::<f32>() / (side * side) as f32
    }

    /// Squares of changes of light below voxels of relative deviations within bounds, and of these.
    pub fn energies(&self, least: f32, below: f32) -> ChangeEnergies {
        let mut energies = ChangeEnergies::default();
        for (voxel, &roughness) in self.roughness.iter().enumerate() {
            if !(least <= roughness && roughness < below) {
                continue;
            }
            let [x, y] = [voxel % INNER_VOXELS, voxel / INNER_VOXELS].map(|at| at * CELLS_PER_VOXEL);
            let (mut sum, mut squares) = (0.0, 0.0);
            for row in y..y + CELLS_PER_VOXEL {
                for column in x..x + CELLS_PER_VOXEL {
                    let value = f64::from(self.swatch.at([column, row]));
                    sum += value;
                    squares += value * value;
                }
            }
            let count = (CELLS_PER_VOXEL * CELLS_PER_VOXEL) as f64;
            let weight = f64::from(roughness.max(LEAST_DEVIATION)).powi(2);
            energies.changes += weight * (squares / count - (sum / count).powi(2));
            energies.foretold += weight;
        }
        energies
    }
}

/// Sums of squares over voxels.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ChangeEnergies {
    /// Changes of light, about the mean of their voxel.
    pub changes: f64,
    /// Relative deviations that voxels foretell.
    pub foretold: f64,
}

/// Means over voxels.
fn posts(light: &[f32]) -> Vec<f32> {
    let mut posts = vec![0.0; WINDOW_VOXELS * WINDOW_VOXELS];
    for (index, light) in light.iter().enumerate() {
        let [x, y] = [index % SIDE, index / SIDE].map(|cell| cell / CELLS_PER_VOXEL);
        posts[y * WINDOW_VOXELS + x] += light / (CELLS_PER_VOXEL * CELLS_PER_VOXEL) as f32;
    }
    posts
}

/// Place of a cell among posts.
struct PostPlace {
    /// Index of the post before it along both axes, and posts of a row.
    before: usize,
    stride: usize,
    /// Shares of the way to the next.
    share: [f32; 2],
}

impl PostPlace {
    /// Finds the place of a cell, counted from one voxel behind the first post's.
    fn of(column: usize, row: usize, stride: usize) -> Self {
        let at = [column, row].map(|cell| (cell as f32 + 0.5) / CELLS_PER_VOXEL as f32 + 0.5);
        let [x, y] = at.map(|at| at.floor());
        Self { before: y as usize * stride + x as usize, stride, share: [at[0] - x, at[1] - y] }
    }

    /// Value between posts.
    fn between(&self, posts: &[f32]) -> f32 {
        let along = |first: usize| posts[first] + (posts[first + 1] - posts[first]) * self.share[0];
        let (south, north) = (along(self.before), along(self.before + self.stride));
        south + (north - south) * self.share[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(light: impl Fn(usize, usize) -> f32) -> Option<FineWindow> {
        let cell = |index: usize| Pigment { linear: [light(index % SIDE, index / SIDE); 3], alpha: 1.0 };
        FineWindow::new(&(0..SIDE * SIDE).map(cell).collect::<Vec<_>>())
    }

    #[test]
    fn slopes_of_light_leave_nothing() {
        // Voxels show a slope as it is.
        let slope = window(|column, row| 0.2 + 0.4 * (column + row) as f32 / (2 * SIDE) as f32).unwrap();
        for row in 0..300 {
            for column in 0..300 {
                assert!(slope.swatch.at([column, row]).abs() < 0.02);
            }
        }
        assert_eq!(slope.roughness().len(), 400);
    }

    #[test]
    fn stripes_below_the_voxel_are_left_as_they_are() {
        // Three cells dark, three bright, and voxels of two brightnesses, so that there is roughness.
        let stripes = window(|column, row| {
            let voxel = (column / CELLS_PER_VOXEL + row / CELLS_PER_VOXEL) % 2;
            (0.3 + 0.02 * voxel as f32) * if column / 3 % 2 == 0 { 0.9 } else { 1.1 }
        });
        let stripes = stripes.unwrap();
        let roughness = stripes.roughness_of([5, 5], 5);
        // Along a column light changes with the voxel alone; across, by a fifth.
        let values: Vec<f32> =
            (100..190).map(|column| stripes.swatch.at([column, 150]) * roughness).collect();
        let span =
            values.iter().fold(f32::MIN, |a, b| a.max(*b)) - values.iter().fold(f32::MAX, |a, b| a.min(*b));
        assert!((span - 0.2).abs() < 0.12, "{span}");
        assert!(roughness > 0.1, "{roughness}");
    }

    #[test]
    fn gaps_have_no_window() {
        let cell = |index: usize| Pigment { linear: [0.5; 3], alpha: if index == 777 { 0.0 } else { 1.0 } };
        assert!(FineWindow::new(&(0..SIDE * SIDE).map(cell).collect::<Vec<_>>()).is_none());
        assert!(FineWindow::new(&[]).is_none());
    }
}
