//! Levels of the database by the distance at which they are seen.

use crate::voxel::Grid;

/// The bands of ground distance in which each level is marched, for one eye and field of view.
///
/// A voxel of level L fills one pixel at `TH_L = L / A_PIX` (Hughes patent: 611, 2445, 9778, 39114
/// units for 640 pixels over 60°), and level L is seen beyond it. What is compared with `TH_L` is
/// `max(ground distance, height of the eye above the highest surface)`: never more than the range,
/// so that no level is too coarse, and, for one eye, a function of ground distance alone.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelBands {
    /// Ground distance where level index `l` begins, metres; ascending.
    starts: Vec<f64>,
    /// Finest level in use.
    finest: u8,
    /// Ground distance up to which bare ground and what stands on it is seen instead of the finest surface, metres.
    bare_until: f64,
}

/// Pixels that a voxel fills where the surface takes the place of bare ground and what stands on it: there its walls, which are
/// as wide as a voxel, are still as wide as two or three pixels at most, and a pixel's footprint lies within the finest level.
const BARE_PIXELS: f64 = 2.5;

impl LevelBands {
    /// Bands of the levels `0..level_count` for pixels of `pixel_angle` radians (> 0), seen from
    /// `clearance` metres above the highest surface (negative: below it). `detail` (> 0) scales the
    /// thresholds: 2 keeps each level twice as far.
    pub fn new(grid: &Grid, level_count: u8, pixel_angle: f64, clearance: f64, detail: f64) -> Self {
        let threshold = |level: u8| if level == 0 { 0.0 } else { detail * grid.side(level) / pixel_angle };
        let finest = (0..level_count).rev().find(|&level| threshold(level) <= clearance).unwrap_or(0);
        let starts =
            (0..level_count).map(|level| if level <= finest { 0.0 } else { threshold(level) }).collect();
        Self { starts, finest, bare_until: 0.0 }
    }

    /// The same where something stands: near by, bare ground and spans are seen.
    #[must_use]
    pub fn with_bare_ground(self, grid: &Grid, pixel_angle: f64, clearance: f64, detail: f64) -> Self {
        let end = detail * grid.spacing / (BARE_PIXELS * pixel_angle);
        let is_seen = self.finest == 0 && clearance < end;
        Self { bare_until: if is_seen { end } else { 0.0 }, ..self }
    }

    /// Ground distance up to which bare ground and what stands on it is seen, metres; 0: nowhere.
    pub fn bare_until(&self) -> f64 {
        self.bare_until
    }

    /// Whether it is bare ground that is seen at a ground distance, metres ≥ 0.
    pub fn is_bare_at(&self, ground_distance: f64) -> bool {
        ground_distance < self.bare_until
    }

    /// One level for parallel rays, whose pixels are `width` metres wide (> 0) at any distance: the coarsest whose
    /// voxels are not wider than `width / detail`.
    pub fn uniform(grid: &Grid, level_count: u8, width: f64, detail: f64) -> Self {
        let fits = |level: &u8| detail * grid.side(*level) <= width;
        let finest = (0..level_count).rev().find(fits).unwrap_or(0);
        Self { starts: vec![0.0; usize::from(finest) + 1], finest, bare_until: 0.0 }
    }

    /// Only level 1, at any distance.
    pub fn finest_only() -> Self {
        Self { starts: vec![0.0], finest: 0, bare_until: 0.0 }
    }

    /// Index of the level that is seen at a ground distance, metres ≥ 0.
    pub fn level_at(&self, ground_distance: f64) -> u8 {
        let finer = |&(_, start, _): &(u8, f64, f64)| start <= ground_distance;
        self.iter().take_while(finer).last().map_or(self.finest, |(level, ..)| level)
    }

    /// Level indices with the ground distances (metres) between which they are seen, nearest first.
    pub fn iter(&self) -> impl Iterator<Item = (u8, f64, f64)> + '_ {
        (self.finest..self.starts.len() as u8).map(|level| {
            let level_index = usize::from(level);
            let end = self.starts.get(level_index + 1).copied().unwrap_or(f64::INFINITY);
            (level, self.starts[level_index], end)
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn thresholds_are_the_patents() {
        let grid = Grid { nx: 100_000, ny: 100_000, spacing: 1.0, origin: DVec2::ZERO };
        let pixel_angle = 60_f64.to_radians() / 640.0;
        let bands = LevelBands::new(&grid, 4, pixel_angle, 0.0, 1.0);
        let starts: Vec<f64> = bands.iter().map(|(_, start, _)| start.round()).collect();
        assert_eq!(starts, [0.0, 2445.0, 9778.0, 39114.0]);
    }

    #[test]
    fn parallel_rays_see_one_level() {
        let grid = Grid { nx: 100_000, ny: 100_000, spacing: 2.0, origin: DVec2::ZERO };
        for (width, level) in [(0.1, 0), (7.9, 0), (8.0, 1), (31.0, 1), (32.5, 2), (1e6, 3)] {
            let bands: Vec<_> = LevelBands::uniform(&grid, 4, width, 1.0).iter().collect();
            assert_eq!(bands, [(level, 0.0, f64::INFINITY)], "{width} m");
        }
    }

    #[test]
    fn a_high_eye_sees_no_fine_level() {
        let grid = Grid { nx: 100_000, ny: 100_000, spacing: 1.0, origin: DVec2::ZERO };
        let bands = LevelBands::new(&grid, 4, 60_f64.to_radians() / 640.0, 3000.0, 1.0);
        assert_eq!(bands.iter().next().map(|(level, start, _)| (level, start)), Some((1, 0.0)));
    }
}
