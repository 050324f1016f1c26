//! Quantities that are linear along a row of the screen.

use crate::simd::{Floats, LANES, Simd};

/// Bits of the fraction in fixed point.
const FRACTION: u32 = 32;

/// Most by which rounding may set a lane's value off, in fixed point: a sixty-fourth.
const SLACK: i64 = 1 << (FRACTION - 6);

/// Quantity that is linear along a row of the screen: the planes that its columns meet, or the rows of the plane image that it crosses.
///
/// Where sixteen columns begin and end is worked out with integers: conversions of floats take longer than all of it.
#[derive(Debug, Clone, Copy)]
pub struct AlongRow {
    /// From one column to the next, and in the screen's middle.
    per_column: f32,
    middle: f32,
    /// In fixed point: from half a column to the next, and at the screen's left edge.
    per_half: i64,
    left: i64,
}

impl AlongRow {
    /// Takes what grows by `per_column` and is `middle` in the middle of a screen of `width` columns.
    pub fn new([per_column, middle]: [f64; 2], width: usize) -> Self {
        let fixed = |value: f64| (value * (1_u64 << FRACTION) as f64) as i64;
        Self {
            per_column: per_column as f32,
            middle: middle as f32,
            per_half: fixed(0.5 * per_column),
            left: fixed(middle - 0.5 * per_column * width as f64),
        }
    }

    /// Values at columns, which are counted from the screen's middle.
    #[inline(always)]
    pub fn values<V: Simd>(&self, simd: V, columns: V::F) -> V::F {
        columns.mul_add(simd.splat(self.per_column), simd.splat(self.middle))
    }

    /// Returns the least and the greatest integer at or below the values of the sixteen columns from `first` on.
    #[inline(always)]
    pub fn reach(&self, first: usize) -> [i32; 2] {
        let from = self.left + self.per_half * (2 * first as i64 + 1);
        let to = from + self.per_half * (2 * LANES as i64 - 2);
        [from.min(to) - SLACK, from.max(to) + SLACK].map(|fixed| (fixed >> FRACTION) as i32)
    }
}
