//! Pattern in three dimensions, for ground too steep to be seen from above.
//!
//! ```text
//! tone(i, j, k) = XOR of P(α·i + β·j + γ·k) over the directions 1,1,0 and 1,0,1 and 0,1,1
//! ```
//!
//! In each plane of two axes the directions' determinants are 1 or −1, so that walls have the pattern's full
//! contrast. A single code along i + j + k is constant on planes.
//!
//! The study of cyclic codes (AFHRL on ACTES) recommends texture on objects; the directions are ours.

use crate::code::CyclicCode;

/// Steps along a code for each cell along x, y and z; coefficients below x⁸ of its polynomial; and its place
/// at 0, 0, 0.
const LAYERS: [([i64; 3], u8, i64); 3] =
    [([1, 1, 0], 0x1d, 215), ([1, 0, 1], 0x65, 149), ([0, 1, 1], 0x8d, 163)];

/// Pattern of 255 × 255 × 255 cells, white in every plane of two axes.
#[derive(Debug, Clone)]
pub struct SolidPattern {
    codes: [CyclicCode; 3],
}

impl SolidPattern {
    /// Tone of a cell of space by its column, row and height, 0 to 255.
    pub fn tone(&self, cell: [i64; 3]) -> u8 {
        let layers = self.codes.iter().zip(LAYERS);
        let tone = |(code, (steps, _, phase)): (&CyclicCode, ([i64; 3], u8, i64))| {
            let place: i64 =
                steps.iter().zip(cell).map(|(step, cell)| step * cell.rem_euclid(code.period())).sum();
            code.tone(place + phase)
        };
        layers.map(tone).fold(0, |joined, tone| joined ^ tone) as u8
    }
}

impl Default for SolidPattern {
    fn default() -> Self {
        Self { codes: LAYERS.map(|(_, lower, _)| CyclicCode::of_degree_8(lower)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::Cells;
    use crate::spectrum::Spectrum;

    /// Planes of two axes at a few places: flat ground, walls along x, walls along y.
    fn planes(at: i64) -> [Cells; 3] {
        let solid = SolidPattern::default();
        let plane =
            |place: &dyn Fn(i64, i64) -> [i64; 3]| Cells::of(|a, b| f64::from(solid.tone(place(a, b))));
        [plane(&|a, b| [a, b, at]), plane(&|a, b| [a, at, b]), plane(&|a, b| [at, a, b])]
    }

    #[test]
    fn walls_vary_as_much_as_flat_ground() {
        for at in [0, 77, -1000] {
            let [flat, walls @ ..] = planes(at);
            for wall in walls {
                for side in [1, 4, 16] {
                    // Cells a metre or so apart: what is left after averages over squares of them.
                    let share = (wall.averaged(side).deviation() / flat.averaged(side).deviation()).powi(2);
                    assert!((share - 1.0).abs() < 0.2, "{share} of the variance over {side} cells");
                }
            }
        }
    }

    #[test]
    fn walls_do_not_streak() {
        for plane in planes(5) {
            let spectrum = Spectrum::of(&plane);
            assert!(spectrum.worst_correlation_beyond(8.0) < 0.1);
            assert!(spectrum.sector_spreads_db()[..2].iter().all(|&spread| spread < 1.5));
        }
    }
}
