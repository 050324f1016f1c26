//! Sixteen planes over the ground: heights where they are.

use super::lines::Lines;
use crate::simd::{Floats, Simd};
use crate::voxel::{Grid, HeightCode};

/// Height above the eye of what is no surface, metres.
pub const NOTHING: f32 = -1.0e30;

/// Codes below this are no surface's.
const NO_CODE: f32 = HeightCode::EMPTY as f32 + 0.5;

/// How the planes lie, and how heights are coded.
#[derive(Clone, Copy)]
pub struct Ground<V: Simd> {
    pub simd: V,
    /// The eye across the planes, units.
    pub across: f64,
    /// Sense along the major axis, +1 or −1.
    pub forward: i64,
    /// Metres of depth, units across and (per square) metres of curvature per unit of major distance.
    pub depth: V::F,
    /// Units of major distance per metre of depth.
    pub per_depth: V::F,
    pub minor: V::F,
    pub drop: V::F,
    /// Metres per step of a height code, and height of code 0 above the eye, metres.
    pub scale: V::F,
    pub offset: V::F,
}

impl<V: Simd> Ground<V> {
    /// Codes of a line where the planes are at a major distance.
    #[inline(always)]
    pub fn codes(&self, lines: &Lines<'_>, level: u8, line: i64, distance: V::F) -> V::F {
        let side = f64::from(Grid::side_units(level));
        let eye = self.across / side - 0.5 - lines.first[1] as f64;
        let minor = self.minor * self.simd.splat((1.0 / side) as f32);
        let post = minor.mul_add(distance, self.simd.splat(eye as f32));
        lines.codes(self.simd, (line - lines.first[0]) as i32, post)
    }

    /// Height above the eye at a major distance, metres, of a code there.
    #[inline(always)]
    pub fn height(&self, codes: V::F, distance: V::F) -> V::F {
        let z = self.drop.neg_mul_add(distance * distance, codes.mul_add(self.scale, self.offset));
        self.simd.splat(NOTHING).select(codes.lt(self.simd.splat(NO_CODE)), z)
    }

    /// Height above the eye of the bilinear surface at a major distance, `share` of the way from the line
    /// before `line` to it, metres.
    #[inline(always)]
    pub fn surface(&self, lines: &Lines<'_>, level: u8, line: i64, distance: V::F, share: f32) -> V::F {
        let near = self.codes(lines, level, line - self.forward, distance);
        let far = self.codes(lines, level, line, distance);
        let nothing = near.min(far).lt(self.simd.splat(NO_CODE));
        let codes = (far - near).mul_add(self.simd.splat(share), near);
        self.height(self.simd.splat(0.0).select(nothing, codes), distance)
    }
}
