//! Reading of the planes down the columns of a screen that is rolled a little, sixteen columns at a time.
//!
//! ```text
//! for each row of the plane image that the columns come to, from the top:
//!     its codes where the columns cross it: cubic between planes                → kept
//! for each row of the screen:
//!     codes between the kept rows about its pixels: cubic between rows
//! ```
//!
//! All columns take the same rows, some more than each of them needs: codes of a row are neighbours in memory, which are loaded and permuted.

use super::plane_rows::PlaneRows;
use super::{AlongRow, cubic};
use crate::raymarch::scan::Upright;
use crate::simd::{Floats, Ints, LANES, Simd, Sixteen};

/// Rows that are kept: sixteen columns have fewer about them, at the steepest roll that is read so.
const KEPT: usize = LANES;

/// Planes where the screen's columns cross rows of the plane image.
pub struct Crossings {
    /// The first of these rows.
    first: i32,
    along: Vec<AlongRow>,
}

impl Crossings {
    /// Takes the rows that are crossed about rows of the screen, whose places among them are `slants`.
    pub fn new<'s>(upright: &Upright, slants: impl Iterator<Item = &'s AlongRow>) -> Self {
        let (mut low, mut high) = (i32::MAX, 0);
        for along in slants {
            for column in [0, upright.width()] {
                let [lowest, highest] = along.reach(column);
                (low, high) = (low.min(lowest - 1), high.max(highest + 2));
            }
        }
        let last = upright.size[1] as i32 - 1;
        let crossed = low.clamp(0, last)..=high.clamp(0, last);
        let first = *crossed.start();
        let along = crossed.map(|row| AlongRow::new(upright.crossings(row), upright.width())).collect();
        Self { first, along }
    }

    /// Returns planes along a row, or along the nearest one that is crossed, and that row.
    #[inline(always)]
    fn at(&self, row: i32) -> (&AlongRow, usize) {
        let index = (row - self.first).clamp(0, self.along.len() as i32 - 1);
        (&self.along[index as usize], (self.first + index) as usize)
    }
}

/// Sixteen columns of a rolled screen on their way down.
pub struct RolledColumns {
    /// The first one.
    first: usize,
    /// The lowest row that they came to.
    lowest: i32,
    /// Codes where columns cross rows; that of a row is at its number modulo [`KEPT`].
    rows: [[Sixteen; 3]; KEPT],
}

impl RolledColumns {
    /// Has no columns yet.
    pub fn new() -> Self {
        Self { first: 0, lowest: i32::MAX, rows: [[Sixteen::default(); 3]; KEPT] }
    }

    /// Begins other columns, from `first` on.
    pub fn begin(&mut self, first: usize) {
        (self.first, self.lowest) = (first, i32::MAX);
    }

    /// Codes along a row of the screen, whose places among the rows of the plane image are `along`: cubic between the four rows about each.
    #[inline(always)]
    pub fn codes<V: Simd>(
        &mut self,
        plane_rows: &PlaneRows<'_, V>,
        crossings: &Crossings,
        along: &AlongRow,
    ) -> [V::F; 3] {
        let simd = plane_rows.simd();
        let reach = along.reach(self.first);
        let [lowest, highest] = [reach[0] - 1, reach[1] + 2];
        debug_assert!(((highest - lowest) as usize) < KEPT);
        for row in (lowest..self.lowest.min(highest + 1)).rev() {
            let (planes, known) = crossings.at(row);
            let codes = plane_rows.cubic(planes, self.first, known);
            for (kept, codes) in self.rows[row as usize % KEPT].iter_mut().zip(codes) {
                codes.store(&mut kept.0);
            }
        }
        self.lowest = self.lowest.min(lowest);

        let row = along.values(simd, plane_rows.columns(self.first));
        let below = row.floor();
        let weights = cubic(simd, row - below);
        let below = below.to_int();

        // Columns that are above another row than the first take theirs instead.
        let mut taps = self.rows_from(simd, lowest);
        for above in reach[0] + 1..=reach[1] {
            let taken = below.eq(simd.splat_int(above));
            for (own, other) in taps.iter_mut().zip(self.rows_from(simd, above - 1)) {
                for (own, other) in own.iter_mut().zip(other) {
                    *own = other.select(taken, *own);
                }
            }
        }

        let mut codes = [simd.splat(0.0); 3];
        for (tap, weight) in taps.into_iter().zip(weights) {
            for (code, tap) in codes.iter_mut().zip(tap) {
                *code = tap.mul_add(weight, *code);
            }
        }
        codes
    }

    /// Codes of four rows from one on.
    #[inline(always)]
    fn rows_from<V: Simd>(&self, simd: V, first: i32) -> [[V::F; 3]; 4] {
        let mut taps = [[simd.splat(0.0); 3]; 4];
        for (index, tap) in taps.iter_mut().enumerate() {
            let kept = &self.rows[(first as usize).wrapping_add(index) % KEPT];
            for (tap, kept) in tap.iter_mut().zip(kept) {
                *tap = simd.load(&kept.0);
            }
        }
        taps
    }
}
