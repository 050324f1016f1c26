//! A code in one direction, and its exact mean over any box by four looks.
//!
//! ```text
//! p(n)    = tone(n) − 2^(m − 1)                              sums to zero over the period T
//! F(n + α) = F(n) + p(n)                                     closes after T steps, as α is coprime to T
//! G       = T·F − Σ F                                        sums to zero, too
//! Q(n + β) = Q(n) + G(n)
//! Σ p(α·i + β·j) over i ∈ [a, b), j ∈ [c, d)  =  (Q(αb + βd) − Q(αa + βd) − Q(αb + βc) + Q(αa + βc)) / T
//! ```
//!
//! All in whole numbers, without error. The study estimates these means from one tone (see
//! [`crate::GroupEstimate`]); exact ones are ours.

use hedgehop_base::error::{Error, Result};

use crate::cell_box::CellBox;
use crate::pattern::{Strand, are_coprime};

/// Greatest degree of codes whose prefix sums are kept.
const MAX_DEGREE: u32 = 16;

/// Fractional bits of a [`FixedBox`].
const FIXED_BITS: u32 = 12;

/// Box on the ground in 1/4096 cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixedBox {
    /// Western side.
    pub x0: i64,
    /// Eastern side, greater.
    pub x1: i64,
    /// Southern side.
    pub y0: i64,
    /// Northern side, greater.
    pub y1: i64,
}

impl From<CellBox> for FixedBox {
    /// Rounds corners to the nearest 1/4096 cell.
    fn from(cells: CellBox) -> Self {
        let cells = cells.ordered();
        let [x0, x1, y0, y1] = [cells.x0, cells.x1, cells.y0, cells.y1]
            .map(|side| (side * f64::from(1_u32 << FIXED_BITS)).round() as i64);
        Self { x0, x1, y0, y1 }
    }
}

/// Code in one direction with the tables of its exact means.
#[derive(Debug, Clone)]
pub struct StrandMeans {
    strand: Strand,
    /// Twofold prefix sums Q by place along the code, times the period.
    sums: Vec<i64>,
}

impl StrandMeans {
    /// Tabulates a strand of degree 8 to 16 whose steps along columns and rows are coprime to its period.
    ///
    /// # Errors
    ///
    /// The degree is greater, or a step shares a divisor with the period.
    pub fn new(strand: Strand) -> Result<Self> {
        let (degree, period) = (strand.code.degree(), strand.code.period());
        let (column, row) = (strand.direction.column, strand.direction.row);
        if degree > MAX_DEGREE {
            return Err(Error::Configuration(format!(
                "exact means of a code of degree {degree} need too large a table; want degree 8 to {MAX_DEGREE}"
            )));
        }
        if !are_coprime(column, period) || !are_coprime(row, period) {
            return Err(Error::Configuration(format!(
                "a code in the direction {column},{row} has no exact means: both must be coprime to its period \
                 {period}; want one such as 1,1 or 2,-1"
            )));
        }

        Ok(Self::tabulated(strand))
    }

    /// Tabulates a strand that is known to be of these.
    pub(crate) fn tabulated(strand: Strand) -> Self {
        let (column, row) = (strand.direction.column, strand.direction.row);
        let middle = 1_i64 << (strand.code.degree() - 1);
        let tones: Vec<i64> =
            (0..strand.code.period()).map(|n| i64::from(strand.code.tone(n)) - middle).collect();
        let first = centred(&prefix(&tones, column));
        Self { strand, sums: prefix(&first, row) }
    }

    /// The code and its direction.
    pub fn strand(&self) -> &Strand {
        &self.strand
    }

    /// Exact mean tone over a box anywhere on the ground; not a number of one without finite corners.
    pub fn mean(&self, over: CellBox) -> f64 {
        let period = self.strand.code.period() as f64;
        over.mean_from_sums(|column, row| self.sum(column, row) as f64) / period + self.middle() as f64
    }

    /// Mean tone over a box in whole numbers alone, rounded to the nearest.
    ///
    /// Exact for boxes of up to 4096 × 4096 cells; sides that are not in order give the middle tone.
    pub fn mean_fixed(&self, over: FixedBox) -> u32 {
        if over.x1 <= over.x0 || over.y1 <= over.y0 {
            return self.middle() as u32;
        }
        let one = 1_i128 << FIXED_BITS;
        let sum_to = |x: i64, y: i64| {
            let (column, row) = (x >> FIXED_BITS, y >> FIXED_BITS);
            let (along, up) = (i128::from(x) & (one - 1), i128::from(y) & (one - 1));
            let sum = |column, row| i128::from(self.sum(column, row));
            let across = |row| (one - along) * sum(column, row) + along * sum(column + 1, row);
            (one - up) * across(row) + up * across(row + 1)
        };
        let sum = sum_to(over.x1, over.y1) - sum_to(over.x0, over.y1) - sum_to(over.x1, over.y0)
            + sum_to(over.x0, over.y0);

        let area = i128::from(over.x1 - over.x0) * i128::from(over.y1 - over.y0);
        let divisor = area * i128::from(self.strand.code.period());
        let rounded = (2 * sum + divisor).div_euclid(2 * divisor);
        (i128::from(self.middle()) + rounded) as u32
    }

    /// Prefix sum at a cell of the plane, times the period.
    fn sum(&self, column: i64, row: i64) -> i64 {
        self.sums[self.strand.place(column, row) as usize]
    }

    /// Mean of all tones.
    fn middle(&self) -> i64 {
        1 << (self.strand.code.degree() - 1)
    }
}

/// Sums of all values before each place, in steps of `stride` from place 0.
fn prefix(values: &[i64], stride: i64) -> Vec<i64> {
    let period = values.len() as i64;
    let mut sums = vec![0; values.len()];
    let mut place = 0_i64;
    for _ in 1..values.len() {
        let next = (place + stride).rem_euclid(period);
        sums[next as usize] = sums[place as usize] + values[place as usize];
        place = next;
    }
    sums
}

/// Values times their number, less their sum.
fn centred(values: &[i64]) -> Vec<i64> {
    let sum: i64 = values.iter().sum();
    values.iter().map(|value| value * values.len() as i64 - sum).collect()
}

#[cfg(test)]
#[path = "strand_tests.rs"]
mod tests;
