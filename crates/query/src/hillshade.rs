//! Relief by light: how much of the sun's light ground receives by its slope.
//!
//! ```text
//! slopes   east  p = ((ne + 2e + se) − (nw + 2w + sw)) / 8d          (Horn 1981, p. 18)
//!          north q = ((nw + 2n + ne) − (sw + 2s + se)) / 8d
//! light    cos i = (s.z − s.x·p − s.y·q) / √(1 + p² + q²), not below 0; s points to the sun
//! ```
//!
//! B. K. P. Horn, "Hill shading and the reflectance map", Proceedings of the IEEE 69 (1), 1981. Beside the area and voids the ground goes on as it
//! does on the other side of the pixel, so that a plane has one shade up to its edge. Ground throws no shadows here.

use std::ops::Range;

use glam::DVec3;

use super::map::GroundMap;
use hedgehop::sunlight::Sun;
use hedgehop_base::error::Result;

/// A light and how much ground is raised under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hillshade {
    /// Direction to the sun; of length 1.
    towards: DVec3,
    /// Factor on heights.
    exaggeration: f64,
}

impl Hillshade {
    /// Builds the hillshade of a sun above the horizon; heights are multiplied by `exaggeration` > 0.
    pub fn new(sun: Sun, exaggeration: f64) -> Self {
        let (azimuth, elevation) = (sun.azimuth.to_radians(), sun.elevation.to_radians());
        let level = elevation.cos();
        let towards = DVec3::new(azimuth.sin() * level, azimuth.cos() * level, elevation.sin());
        Self { towards, exaggeration }
    }

    /// Light of level ground, 0…1.
    pub fn of_level_ground(&self) -> f64 {
        self.towards.z
    }

    /// Light of ground with these slopes (rise over run, eastward and northward), 0…1.
    pub fn of_slopes(&self, [east, north]: [f64; 2]) -> f64 {
        let (p, q) = (east * self.exaggeration, north * self.exaggeration);
        let light = self.towards.dot(DVec3::new(-p, -q, 1.0)) / (1.0 + p * p + q * q).sqrt();
        light.max(0.0)
    }

    /// Light of pixels of a map, `[rows][columns]`, the northernmost row first, 0…1; NaN where there is no surface.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn light(&self, map: &GroundMap<'_>, columns: Range<i64>, rows: Range<i64>) -> Result<Vec<f32>> {
        let heights = map.heights(columns.start - 1..columns.end + 1, rows.start - 1..rows.end + 1)?;
        let width = (columns.end - columns.start) as usize;
        let stride = width + 2;
        let mut light = Vec::with_capacity(width * (rows.end - rows.start) as usize);
        for above in 0..(rows.end - rows.start) as usize {
            let row = |down: usize| &heights[(above + down) * stride..(above + down + 1) * stride];
            let rows = [row(0), row(1), row(2)];
            for column in 0..width {
                let around = rows.map(|row| [row[column], row[column + 1], row[column + 2]]);
                light.push(match slopes(&around, map.extent().pixel) {
                    Some(slopes) => self.of_slopes(slopes) as f32,
                    None => f32::NAN,
                });
            }
        }
        Ok(light)
    }
}

/// Slopes eastward and northward of the pixel in the middle of nine, rows from the north; `None` where it has no surface.
fn slopes(around: &[[f64; 3]; 3], side: f64) -> Option<[f64; 2]> {
    let middle = around[1][1];
    if middle.is_nan() {
        return None;
    }

    let known = |row: usize, column: usize| {
        let (own, opposite) = (around[row][column], around[2 - row][2 - column]);
        match (own.is_nan(), opposite.is_nan()) {
            (false, _) => Some(own),
            (true, false) => Some(2.0 * middle - opposite),
            (true, true) => None,
        }
    };

    let beside = |row: usize, column: usize| known(row, column).unwrap_or(middle);
    // Where two edges meet, a corner goes on as the two pixels beside it do.
    let at = |row: usize, column: usize| {
        known(row, column).unwrap_or_else(|| beside(row, 1) + beside(1, column) - middle)
    };
    let east = (at(0, 2) + 2.0 * at(1, 2) + at(2, 2)) - (at(0, 0) + 2.0 * at(1, 0) + at(2, 0));
    let north = (at(0, 0) + 2.0 * at(0, 1) + at(0, 2)) - (at(2, 0) + 2.0 * at(2, 1) + at(2, 2));

    Some([east, north].map(|rise| rise / (8.0 * side)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAP_SUN: Sun = Sun { azimuth: 315.0, elevation: 45.0 };

    #[test]
    fn planes_have_the_light_of_their_normal() {
        let shade = Hillshade::new(MAP_SUN, 1.0);
        assert!((shade.of_level_ground() - 0.5_f64.sqrt()).abs() < 1e-12);
        // A plane that rises to the south-east by 45° looks at the sun.
        let half = 0.5_f64.sqrt();
        assert!((shade.of_slopes([half, -half]) - 1.0).abs() < 1e-12);
        assert_eq!(shade.of_slopes([-2.0, 2.0]), 0.0);
        let raised = Hillshade::new(MAP_SUN, 2.0);
        assert_eq!(raised.of_slopes([0.1, 0.2]), shade.of_slopes([0.2, 0.4]));
    }

    #[test]
    fn slopes_of_a_plane_go_on_to_its_edges() {
        let plane = |missing: &dyn Fn(usize, usize) -> bool| {
            let mut around = [[0.0; 3]; 3];
            for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
                let height = 3.0 * column as f64 - 2.0 * row as f64;
                around[row][column] = if missing(row, column) { f64::NAN } else { height };
            }
            slopes(&around, 10.0)
        };

        for missing in [
            &(|_, _| false) as &dyn Fn(usize, usize) -> bool,
            &|row, _| row == 0,
            &|_, column| column == 2,
            &|row, column| row == 2 || column == 0,
        ] {
            let [east, north] = plane(missing).unwrap();
            assert!((east - 0.3).abs() < 1e-12 && (north - 0.2).abs() < 1e-12, "{east} {north}");
        }

        assert_eq!(plane(&|row, column| row == 1 && column == 1), None);
        assert_eq!(plane(&|row, column| (row, column) != (1, 1)), Some([0.0, 0.0]));
    }
}
