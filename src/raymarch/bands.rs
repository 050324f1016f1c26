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
    /// Sizes of cells of what stands there, nearest first.
    span_bands: Vec<SpanBand>,
    /// Pixels that a voxel fills at least where that is seen.
    span_pixels: f64,
}

/// Band of ground distance in which what stands is seen in cells of `1 << shift` voxels to a side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpanBand {
    /// log₂ of voxels along a cell, 2 at most.
    pub shift: u8,
    /// Ground distance from which on it is seen, metres.
    pub start: f64,
    /// Ground distance up to which it is seen, metres.
    pub end: f64,
}

/// log₂ of voxels along the coarsest cells of what stands.
pub const COARSEST_CELLS: u8 = 2;

/// Pixels that a voxel fills at least where bare ground and what stands on it is seen, unless told otherwise, and the least that may be told: further away the finest
/// level is not seen.
pub const SPAN_PIXELS: f64 = 0.25;

/// Pixels that a cell of what stands fills at most, unless it is a single voxel: there what is wider than a cell, such as a house, keeps
/// its shape to a part of a pixel.
const CELL_PIXELS: f64 = 3.0;

impl LevelBands {
    /// Bands of the levels `0..level_count` for pixels of `pixel_angle` radians (> 0), seen from
    /// `clearance` metres above the highest surface (negative: below it). `detail` (> 0) scales the
    /// thresholds: 2 keeps each level twice as far.
    pub fn new(grid: &Grid, level_count: u8, pixel_angle: f64, clearance: f64, detail: f64) -> Self {
        let threshold = |level: u8| if level == 0 { 0.0 } else { detail * grid.side(level) / pixel_angle };
        let finest = (0..level_count).rev().find(|&level| threshold(level) <= clearance).unwrap_or(0);
        let starts =
            (0..level_count).map(|level| if level <= finest { 0.0 } else { threshold(level) }).collect();
        Self { starts, finest, ..Self::finest_only() }
    }

    /// The same with another least number of pixels that a voxel fills where bare ground and spans are seen, [`SPAN_PIXELS`] or more; for
    /// [`Self::with_bare_ground`].
    #[must_use]
    pub fn with_span_pixels(self, span_pixels: f64) -> Self {
        Self { span_pixels, ..self }
    }

    /// The same where something stands: where a voxel fills some pixels, it is bare ground and spans instead of the surface.
    #[must_use]
    pub fn with_bare_ground(self, grid: &Grid, pixel_angle: f64, clearance: f64, detail: f64) -> Self {
        let end = detail * grid.spacing / (self.span_pixels.max(SPAN_PIXELS) * pixel_angle);
        if self.finest > 0 || clearance >= end {
            return self;
        }

        // From high above, coarser cells are fine enough at any distance.
        let start = |shift: u8| {
            let side = grid.spacing * f64::from(1_u32 << shift);
            let start = detail * side / (CELL_PIXELS * pixel_angle);
            if shift == 0 || start <= clearance { 0.0 } else { start }
        };
        let ends = |shift: u8| if shift == COARSEST_CELLS { end } else { start(shift + 1).min(end) };
        let bands =
            (0..=COARSEST_CELLS).map(|shift| SpanBand { shift, start: start(shift), end: ends(shift) });
        Self { bare_until: end, span_bands: bands.filter(|band| band.start < band.end).collect(), ..self }
    }

    /// Bands of what stands by the size of its cells, nearest first; they end where bare ground does.
    pub fn span_bands(&self) -> &[SpanBand] {
        &self.span_bands
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
        Self { starts: vec![0.0; usize::from(finest) + 1], finest, ..Self::finest_only() }
    }

    /// Only level 1, at any distance.
    pub fn finest_only() -> Self {
        Self {
            starts: vec![0.0],
            finest: 0,
            bare_until: 0.0,
            span_bands: Vec::new(),
            span_pixels: SPAN_PIXELS,
        }
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
    fn what_stands_is_seen_up_to_a_voxel_of_few_pixels_in_cells_of_few() {
        let grid = Grid { nx: 100_000, ny: 100_000, spacing: 1.0, origin: DVec2::ZERO };
        let pixel = 1.0e-3;
        let bands = |clearance| {
            let bands = LevelBands::new(&grid, 4, pixel, clearance, 1.0);
            bands.with_bare_ground(&grid, pixel, clearance, 1.0)
        };
        let cells = |clearance| {
            let bands = bands(clearance);
            bands.span_bands().iter().map(|band| (band.shift, band.start.round(), band.end.round())).collect()
        };
        let low: Vec<_> = cells(-50.0);
        assert_eq!(low, [(0, 0.0, 667.0), (1, 667.0, 1333.0), (2, 1333.0, 4000.0)]);
        let high: Vec<_> = cells(900.0);
        assert_eq!(high, [(1, 0.0, 1333.0), (2, 1333.0, 4000.0)]);
        assert_eq!((bands(3999.0).bare_until(), bands(4001.0).bare_until()), (4000.0, 0.0));
        assert!(bands(4001.0).span_bands().is_empty());

        let near = LevelBands::new(&grid, 4, pixel, 0.0, 1.0)
            .with_span_pixels(2.5)
            .with_bare_ground(&grid, pixel, 0.0, 1.0);
        assert_eq!(near.span_bands(), [SpanBand { shift: 0, start: 0.0, end: 400.0 }]);
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
