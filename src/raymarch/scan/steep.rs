//! Rises over which a stretch between two lines is too steep to be straight.

use super::march_field::MarchField;
use crate::simd::{Each, Floats, Mask, Simd};

/// Most parts of a steep stretch.
pub(super) const MOST_STEEP_PARTS: f32 = 32.0;

/// Rows that a stretch may rise over, and radians, before the lines between its ends, or the surface between neighbouring ones, are looked at: lines
/// are several pixels apart, which is a greater share of range the wider pixels are. From 0.7 mrad a pixel on radians are what counts.
const STEEP_ROWS: f32 = 2.3;
const STEEP_ANGLE: f32 = 0.0016;

/// Tangents that a stretch may rise over before the surface between its ends is looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct SteepRise {
    /// Least such rise, at any elevation.
    pub least: f32,
    /// Rise at level sight, from where it grows as the tangent of an angle does.
    level: f32,
}

impl SteepRise {
    /// Finds the tangents for a field.
    pub fn new(field: &MarchField) -> Self {
        let [lowest, highest] = field.tangents;
        let flattest = 0.0_f32.max(lowest).min(highest);
        let [row, angle] = field.row.each(|row| STEEP_ROWS * row);
        let least = row.min(STEEP_ANGLE * flattest.mul_add(flattest, 1.0)) / field.detail;
        Self { least, level: angle.min(STEEP_ANGLE) / field.detail }
    }

    /// Whether some plane sees a stretch rise from `begin` to `slope` by more than `times` as much.
    #[inline(always)]
    pub fn is_passed<V: Simd>(self, simd: V, [begin, slope]: [V::F; 2], times: f32) -> bool {
        let [least, level] = [self.least, self.level].each(|rise| simd.splat(times * rise));
        // The flattest line of sight along the stretch: the limit grows with its tangent.
        let flattest = begin.max(simd.splat(0.0) - slope).max(simd.splat(0.0));
        let steep = least.max((flattest * flattest).mul_add(level, level));
        steep.lt(slope - begin).any()
    }

    /// Returns the parts that a steep stretch across a stride of `lines` (2 or 4) is divided into by lines that the stride leaves out.
    #[inline(always)]
    pub fn divisions<V: Simd>(self, simd: V, stretch: [V::F; 2], lines: i64) -> i64 {
        if self.is_passed(simd, stretch, 2.0) { lines } else { 2 }
    }

    /// Returns the parts of a steep stretch, of which none rises by much more.
    #[inline(always)]
    pub fn parts<V: Simd>(self, simd: V, stretch: [V::F; 2]) -> f32 {
        let mut parts = 2.0;
        while parts < MOST_STEEP_PARTS && self.is_passed(simd, stretch, parts) {
            parts *= 2.0;
        }
        parts
    }
}
