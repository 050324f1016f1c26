//! A code's means over 1, 4, 16 and 64 cells along a side, by the place of their first.
//!
//! ```text
//! S₁(n) = tone(n)      S₄ₖ(n) = Σ Sₖ(n + k·(α·u + β·v)) over u, v = 0 … 3      A(n) = S(n)/side²
//! level of a footprint of f cells = log₄ f; between levels, a blend of the two
//! ```
//!
//! Sums are whole numbers, so that a parent is the mean of its sixteen children without error: the levels of
//! voxels.
//!
//! Averages by footprint are the study's (AFHRL on ACTES); tables of levels and blends are ours.

use crate::pattern::Strand;

/// Cells along a side at each level.
const SIDES: [i64; 4] = [1, 4, 16, 64];

/// Sums of a strand's tones over squares of 1, 4, 16 and 64 cells along a side.
#[derive(Debug, Clone)]
pub struct LevelTables {
    strand: Strand,
    sums: [Vec<u64>; 4],
}

impl LevelTables {
    /// Tabulates a strand; its tables have as many entries as its period.
    pub fn new(strand: Strand) -> Self {
        let period = strand.code.period();
        let mut sums = [(); 4].map(|()| Vec::new());
        sums[0] = (0..period).map(|n| u64::from(strand.code.tone(n))).collect();
        for level in 1..SIDES.len() {
            let children = &sums[level - 1];
            let child = |n: i64, u: i64, v: i64| {
                let place = n + strand.direction.place(u, v) * SIDES[level - 1];
                children[place.rem_euclid(period) as usize]
            };
            let parent = |n| (0..16).map(|number| child(n, number % 4, number / 4)).sum();
            sums[level] = (0..period).map(parent).collect();
        }
        Self { strand, sums }
    }

    /// Sum of tones over a square of a level, 0 to 3, by its column and row among squares of that level.
    pub fn sum(&self, level: usize, column: i64, row: i64) -> u64 {
        let side = SIDES[level];
        let place = self.strand.place(column.wrapping_mul(side), row.wrapping_mul(side));
        self.sums[level][place as usize]
    }

    /// Mean tone about a place, in cells, as seen by a footprint of so many cells: a blend of two levels.
    pub fn tone(&self, x: f64, y: f64, footprint: f64) -> f64 {
        let level = footprint.max(1.0).log(4.0).min(3.0);
        let at = |level: usize| {
            let side = SIDES[level] as f64;
            let sum = self.sum(level, (x / side).floor() as i64, (y / side).floor() as i64);
            sum as f64 / (side * side)
        };
        let (below, share) = (level.floor(), level.fract());
        let fine = at(below as usize);
        if share > 0.0 { fine + share * (at(below as usize + 1) - fine) } else { fine }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_box::CellBox;
    use crate::code::CyclicCode;
    use crate::estimate::group_means;
    use crate::pattern::Direction;
    use crate::strand::StrandMeans;

    fn strand(column: i64, row: i64) -> Strand {
        Strand { code: CyclicCode::default(), direction: Direction { column, row }, phase: 5 }
    }

    #[test]
    fn parents_are_the_means_of_their_children_without_error() {
        for (column, row) in [(1, 1), (2, -1), (0, 1)] {
            let tables = LevelTables::new(strand(column, row));
            for level in 1..4 {
                for (i, j) in [(0, 0), (-3, 17), (1_000_000, -1_000_001), (40, 9)] {
                    let child = |number: i64| tables.sum(level - 1, 4 * i + number % 4, 4 * j + number / 4);
                    assert_eq!(tables.sum(level, i, j), (0..16).map(child).sum::<u64>());
                }
            }
        }
    }

    #[test]
    fn levels_are_the_exact_means() {
        let tables = LevelTables::new(strand(1, 1));
        let means = StrandMeans::new(strand(1, 1)).unwrap();
        let along = group_means(&CyclicCode::default(), 16);
        for (i, j) in [(0, 0), (-7, 3), (12, 900)] {
            for (level, side) in SIDES.into_iter().enumerate() {
                let [x0, y0] = [i, j].map(|place| (place * side) as f64);
                let over = CellBox { x0, x1: x0 + side as f64, y0, y1: y0 + side as f64 };
                let mean = tables.sum(level, i, j) as f64 / (side * side) as f64;
                assert!((means.mean(over) - mean).abs() < 1e-9);
            }
            let first = (16 * i + 16 * j + 5_i64).rem_euclid(255) as usize;
            assert!((along[first] - tables.sum(2, i, j) as f64 / 256.0).abs() < 1e-12);
        }
    }

    #[test]
    fn no_step_in_a_slow_zoom_exceeds_a_grey() {
        let tables = LevelTables::new(strand(1, 1));
        for place in 0..60 {
            let (x, y) = (f64::from(place) * 3.7 - 40.0, f64::from(place) * -1.9);
            let mut before = tables.tone(x, y, 0.5);
            // A tenth of a percent a frame, from half a cell to beyond the coarsest level.
            for frame in 1..6000 {
                let now = tables.tone(x, y, 0.5 * 1.001_f64.powi(frame));
                assert!((now - before).abs() <= 1.0, "{before} to {now}");
                before = now;
            }
        }
    }
}
