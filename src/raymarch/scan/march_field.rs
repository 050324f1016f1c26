//! The field of view of a march: which rays it serves.

use super::PlaneGroup;

/// Share of the way to the ceiling that is passed over: the rest is for rounding.
const UNDER_CEILING: f32 = 0.999;

/// Field that a march is to see.
#[derive(Debug, Clone, Copy)]
pub struct MarchField {
    /// Tangents of elevation of the lower edge of the lowest row and of the upper edge of the highest.
    pub tangents: [f32; 2],
    /// Least height of a row, as tangent, and as angle, radians.
    pub row: [f32; 2],
    /// Factor of closeness at which the surface is looked at where it is steep, > 0.
    pub detail: f32,
}

impl MarchField {
    /// Returns the major distance up to which all rays of `group` are higher than `ceiling` (metres above the eye), 0 where they are not.
    pub(super) fn begin(&self, group: &PlaneGroup, ceiling: f64) -> f32 {
        let falls = group.depth.iter().fold(0.0_f32, |a, &b| a.max(b)) * -self.tangents[0];
        let begin = if falls > 0.0 { -ceiling as f32 / falls } else { 0.0 };
        (begin * UNDER_CEILING).max(0.0)
    }
}
