//! A white pattern of three cyclic codes.
//!
//! ```text
//! tone(i, j) = P(α₁·i + β₁·j + n₁) XOR P₂(α₂·i + β₂·j + n₂) XOR P₃(α₃·i + β₃·j + n₃)
//! ```
//!
//! One code in one direction is constant along the other, and sums of K codes keep ridges of 1/K. Exclusive
//! or multiplies the signs of the registers' bits; where the determinants of the directions, two by two, are
//! coprime to the period of 255, the products fill the plane of frequencies evenly, so that the pattern is
//! white and has no direction.
//!
//! The study of cyclic codes recommends several sequences on top of each other; exclusive or is ours.

use hedgehop_base::chance::Random;
use hedgehop_base::error::{Error, Result};

use crate::cells::{Cells, SIDE};
use crate::code::CyclicCode;

/// Codes whose patterns have the evenest spectra of 260 drawn by chance: at most 1.4 dB between eight sectors
/// of direction in each of the four finest octaves, as against 3 dB of others.
///
/// Each has the coefficients below x⁸, all of primitive polynomials, and the place along the code at cell 0,
/// 0.
const EVENEST: [[(u8, i64); 3]; 16] = [
    [(0x1d, 215), (0x65, 149), (0x8d, 163)],
    [(0x65, 243), (0x1d, 42), (0x5f, 246)],
    [(0x69, 166), (0x1d, 83), (0x8d, 213)],
    [(0x63, 118), (0x2d, 70), (0x5f, 253)],
    [(0xf5, 244), (0x69, 132), (0x87, 110)],
    [(0x87, 242), (0xa9, 131), (0x69, 142)],
    [(0x2d, 145), (0x65, 221), (0xcf, 119)],
    [(0xc3, 160), (0x63, 82), (0xf5, 7)],
    [(0x63, 4), (0x8d, 135), (0x4d, 13)],
    [(0x65, 134), (0x2d, 171), (0x69, 232)],
    [(0xa9, 51), (0x1d, 129), (0xc3, 99)],
    [(0xe7, 153), (0x87, 128), (0x71, 238)],
    [(0x63, 218), (0x87, 221), (0x1d, 192)],
    [(0x63, 104), (0xe7, 95), (0x4d, 179)],
    [(0x2b, 129), (0xc3, 174), (0x8d, 19)],
    [(0x4d, 5), (0x1d, 192), (0x8d, 151)],
];

/// Steps along a code for each cell of the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Direction {
    /// Steps for each column.
    pub column: i64,
    /// Steps for each row.
    pub row: i64,
}

impl Direction {
    /// Place along the code of a cell of the plane; wraps far beyond any ground.
    pub fn place(self, column: i64, row: i64) -> i64 {
        self.column.wrapping_mul(column).wrapping_add(self.row.wrapping_mul(row))
    }

    /// Determinant with another direction.
    fn cross(self, other: Self) -> i64 {
        self.column * other.row - self.row * other.column
    }
}

/// A code, laid over the ground in one direction.
#[derive(Debug, Clone)]
pub struct Strand {
    /// The code, of degree 8 within an [`XorPattern`].
    pub code: CyclicCode,
    /// Direction in which the code runs.
    pub direction: Direction,
    /// Place along the code at cell 0, 0.
    pub phase: i64,
}

impl Strand {
    /// Place along the code of a cell of the plane, from 0 up to the period.
    pub fn place(&self, column: i64, row: i64) -> i64 {
        let period = self.code.period();
        let direction = self.direction.place(column.rem_euclid(period), row.rem_euclid(period));
        direction.wrapping_add(self.phase).rem_euclid(period)
    }

    /// Tone of a cell of the plane.
    pub fn tone(&self, column: i64, row: i64) -> u32 {
        self.code.tone(self.place(column, row))
    }
}

/// Pattern of 255 × 255 cells: several codes of degree 8, joined by exclusive or.
#[derive(Debug, Clone)]
pub struct XorPattern {
    strands: Vec<Strand>,
}

impl XorPattern {
    /// Directions of the default pattern.
    pub const DIRECTIONS: [Direction; 3] =
        [Direction { column: 1, row: 1 }, Direction { column: 1, row: 2 }, Direction { column: 0, row: 1 }];

    /// Joins strands of degree 8 whose directions have determinants coprime to 255, two by two.
    ///
    /// # Errors
    ///
    /// A code is of another degree, or two directions have a determinant that shares a divisor with 255.
    pub fn new(strands: Vec<Strand>) -> Result<Self> {
        for (number, strand) in strands.iter().enumerate() {
            if strand.code.degree() != 8 {
                return Err(Error::Configuration(format!(
                    "code {} of a pattern is of degree {}; want 8, whose period is the pattern's side",
                    number + 1,
                    strand.code.degree()
                )));
            }
            let (own, period) = (strand.direction, SIDE as i64);
            let kin = strands[..number].iter().find(|other| !are_coprime(own.cross(other.direction), period));
            if let Some(other) = kin {
                return Err(Error::Configuration(format!(
                    "codes in the directions {},{} and {},{} streak: their determinant {} shares a divisor with 255; \
                     want directions such as 1,1 and 1,2 and 0,1",
                    other.direction.column,
                    other.direction.row,
                    own.column,
                    own.row,
                    own.cross(other.direction)
                )));
            }
        }
        Ok(Self { strands })
    }

    /// Three codes in [`Self::DIRECTIONS`] that are among the evenest; a seed says which, and where they
    /// begin.
    pub fn seeded(seed: u64) -> Self {
        let mut random = Random::stream(seed, 0);
        let [column, row] = [random.unit(), random.unit()].map(|unit| (unit * SIDE as f64) as i64);
        let drawn = EVENEST[(seed % EVENEST.len() as u64) as usize];
        let strands = drawn.iter().zip(Self::DIRECTIONS).map(|(&(lower, phase), direction)| Strand {
            code: CyclicCode::of_degree_8(lower),
            direction,
            phase: phase + direction.place(column, row),
        });
        Self { strands: strands.collect() }
    }

    /// Tone of a cell of the plane, 0 to 255.
    pub fn tone(&self, column: i64, row: i64) -> u8 {
        self.strands.iter().fold(0, |tone, strand| tone ^ strand.tone(column, row)) as u8
    }

    /// Tones of all cells as a table.
    pub fn cells(&self) -> Cells {
        Cells::of(|column, row| f64::from(self.tone(column, row)))
    }
}

impl Default for XorPattern {
    fn default() -> Self {
        Self::seeded(0)
    }
}

/// Whether two numbers have no divisor in common.
pub(crate) fn are_coprime(a: i64, b: i64) -> bool {
    let (mut a, mut b) = (a.unsigned_abs(), b.unsigned_abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Spectrum;

    #[test]
    fn pattern_is_white_and_isotropic_for_any_seed() {
        let (mut worst_sector, mut worst_correlation, mut worst_octave) = (0.0_f64, 0.0_f64, 0.0_f64);
        for seed in 100..116 {
            let spectrum = Spectrum::of(&XorPattern::seeded(seed).cells());
            worst_sector = spectrum.sector_spreads_db().into_iter().fold(worst_sector, f64::max);
            worst_correlation = worst_correlation.max(spectrum.worst_correlation_beyond(8.0));
            let densities = spectrum.octave_densities();
            worst_octave = densities
                .iter()
                .fold(worst_octave, |worst, density| worst.max((10.0 * density.log10()).abs()));
        }
        assert!(worst_sector <= 1.5, "{worst_sector} dB between sectors");
        assert!(worst_octave <= 0.5, "{worst_octave} dB from white");
        assert!(worst_correlation <= 0.05, "{worst_correlation} beyond eight cells");
    }

    #[test]
    fn polynomials_of_even_patterns_are_primitive() {
        for (lower, _) in EVENEST.into_iter().flatten() {
            assert!(CyclicCode::new(0x100 | u64::from(lower)).is_ok(), "{lower:#x}");
        }
    }

    #[test]
    fn single_code_streaks() {
        let strand = Strand { code: CyclicCode::default(), direction: XorPattern::DIRECTIONS[0], phase: 0 };
        let cells = XorPattern::new(vec![strand]).unwrap().cells();
        let spectrum = Spectrum::of(&cells);
        assert!(spectrum.sector_spreads_db()[0] > 20.0);
        assert!(spectrum.worst_correlation_beyond(8.0) > 0.999);
    }

    #[test]
    fn pattern_repeats_and_is_one_with_its_table() {
        let pattern = XorPattern::default();
        let cells = pattern.cells();
        for (column, row) in [(0, 0), (254, 3), (-1, -700), (1_000_000_007, -1 << 40), (i64::MIN, i64::MAX)] {
            assert_eq!(f64::from(pattern.tone(column, row)), cells.at(column, row));
        }
        assert!(
            (cells.mean() - 127.5).abs() < 1.0 && (cells.deviation() - 73.9).abs() < 1.0,
            "{} {}",
            cells.mean(),
            cells.deviation()
        );
        assert_ne!(XorPattern::seeded(1).cells(), cells);
    }

    #[test]
    fn directions_that_streak_are_refused() {
        let strand = |polynomial, column, row| Strand {
            code: CyclicCode::new(polynomial).unwrap(),
            direction: Direction { column, row },
            phase: 0,
        };
        let error = |strands| XorPattern::new(strands).unwrap_err().to_string();
        assert!(error(vec![strand(0x12B, 1, 1), strand(0x11D, 1, -2)]).contains("determinant 3"));
        assert!(error(vec![strand(0x12B, 1, 1), strand(0x11D, 1, 1)]).contains("determinant 0"));
        assert!(error(vec![strand(0x409, 1, 1)]).contains("degree 10"));
        assert!(XorPattern::new(vec![strand(0x12B, 1, 1), strand(0x11D, 1, 2), strand(0x14D, 0, 1)]).is_ok());
    }
}
