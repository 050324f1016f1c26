//! Several codes on top of each other, each in a direction of its own.
//!
//! ```text
//! tone(i, j) = mean of tone_k(α_k·i + β_k·j + n_k) over k = 1 … K
//! ```
//!
//! Each code keeps a ridge along which it is constant: the sum's greatest correlation far off is about 1/K.
//! Means over boxes are those of the codes, exact. [`crate::XorPattern`] has no ridges.
//!
//! The study of cyclic codes (AFHRL on ACTES) recommends it; directions are ours.

use crate::cell_box::CellBox;
use crate::code::CyclicCode;
use crate::pattern::{Direction, Strand};
use crate::strand::StrandMeans;

/// Directions, and coefficients below x⁸ of primitive polynomials, of up to eight codes.
const LAYERS: [(Direction, u8); 8] = [
    (Direction { column: 1, row: 1 }, 0x2b),
    (Direction { column: 1, row: -1 }, 0x1d),
    (Direction { column: 1, row: 2 }, 0x4d),
    (Direction { column: 2, row: -1 }, 0x5f),
    (Direction { column: 2, row: 1 }, 0x63),
    (Direction { column: 1, row: -2 }, 0x69),
    (Direction { column: 1, row: 4 }, 0x87),
    (Direction { column: 4, row: -1 }, 0xa9),
];

/// Mean of several codes in several directions.
#[derive(Debug, Clone)]
pub struct Superimposed {
    layers: Vec<StrandMeans>,
}

impl Superimposed {
    /// Greatest number of codes.
    pub const MAX_CODES: usize = LAYERS.len();

    /// Takes the first of eight codes of degree 8, at least one and at most all; phases spread them along
    /// themselves.
    pub fn new(codes: usize) -> Self {
        let taken = LAYERS.iter().take(codes.max(1)).zip(0..);
        let layers = taken.map(|(&(direction, lower), number)| {
            StrandMeans::tabulated(Strand {
                code: CyclicCode::of_degree_8(lower),
                direction,
                phase: 97 * number,
            })
        });
        Self { layers: layers.collect() }
    }

    /// Mean tone of a cell of the plane.
    pub fn tone(&self, column: i64, row: i64) -> f64 {
        let tones: u32 = self.layers.iter().map(|layer| layer.strand().tone(column, row)).sum();
        f64::from(tones) / self.layers.len() as f64
    }

    /// Exact mean tone over a box; not a number of one without finite corners.
    pub fn mean(&self, over: CellBox) -> f64 {
        self.layers.iter().map(|layer| layer.mean(over)).sum::<f64>() / self.layers.len() as f64
    }

    /// The codes.
    pub(crate) fn layers(&self) -> &[StrandMeans] {
        &self.layers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_box::brute_force;
    use crate::cells::{Cells, SIDE};
    use crate::spectrum::Spectrum;

    /// Greatest correlation at shifts of 8 to 12 cells.
    fn worst_correlation(codes: usize) -> f64 {
        let codes = Superimposed::new(codes);
        let correlations = Spectrum::of(&Cells::of(|column, row| codes.tone(column, row))).correlations();
        let shift = |place: usize| place.min(SIDE - place) as f64;
        let at = |number: usize| shift(number % SIDE).hypot(shift(number / SIDE));
        let near = correlations.iter().enumerate().filter(|&(number, _)| (8.0..=12.0).contains(&at(number)));
        near.fold(0.0, |worst, (_, value)| worst.max(value.abs()))
    }

    #[test]
    fn eight_codes_hide_the_ridges_of_one() {
        assert!(worst_correlation(1) > 0.999);
        let (four, eight) = (worst_correlation(4), worst_correlation(8));
        assert!(four < 0.35 && eight <= 0.2, "{four} {eight}");
    }

    #[test]
    fn directions_have_exact_means() {
        for (direction, lower) in LAYERS {
            let code = CyclicCode::new(0x100 | u64::from(lower)).unwrap();
            assert!(StrandMeans::new(Strand { code, direction, phase: 0 }).is_ok());
        }
    }

    #[test]
    fn means_are_exact() {
        let codes = Superimposed::new(8);
        for (x0, y0) in [(3.25, -700.5), (-1e6, 12.75)] {
            let over = CellBox { x0, x1: x0 + 33.125, y0, y1: y0 + 5.5 };
            let brute = brute_force(|column, row| codes.tone(column, row), over);
            assert!((codes.mean(over) - brute).abs() < 1e-9);
        }
        assert_eq!(Superimposed::new(99).layers().len(), Superimposed::MAX_CODES);
    }
}
