//! Sixteen planes over the ground: heights where they are.

use super::lines::{Lines, NO_CODE};
use super::profile::{NO_SLOPE, Post, SampleLine};
use crate::simd::{Floats, Simd};
use crate::voxel::Grid;

/// Height above the eye of what is no surface, metres.
pub const NOTHING: f32 = -1.0e30;

/// Codes below this are no surface's.
const LEAST_CODE: f32 = 0.0;

/// Geometry of the planes, and coding of heights.
#[derive(Clone, Copy)]
pub struct PlaneGround<V: Simd> {
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

/// Crossing of planes with a column of posts on a way within one cell's length: the surface has a crease there.
pub struct Crease<V: Simd> {
    /// Positions across where the way begins and ends, posts from the lines' first, and the columns that begin their cells.
    pub ends: [V::F; 2],
    pub cells: [V::F; 2],
    /// Planes that cross a column, which one, and at what share of the way; of others neither means anything.
    pub crosses: V::M,
    pub column: V::F,
    pub share: V::F,
}

impl<V: Simd> PlaneGround<V> {
    /// Creases on the way between two major distances.
    #[inline(always)]
    pub fn crease(&self, lines: &Lines<'_>, level: u8, way: [V::F; 2]) -> Crease<V> {
        let [a, b] = [self.across(lines, level, way[0]), self.across(lines, level, way[1])];
        let (before, behind) = (a.floor(), b.floor());
        // The column is the higher one of the two cells' first.
        let column = before.max(behind);
        let share = ((column - a) * (b - a).recip()).max(self.simd.splat(0.0)).min(self.simd.splat(1.0));
        let crosses = before.lt(behind) | behind.lt(before);
        Crease { ends: [a, b], cells: [before, behind], crosses, column, share }
    }

    /// Codes of a line where the planes are at a major distance.
    #[inline(always)]
    pub fn codes(&self, lines: &Lines<'_>, level: u8, line: i64, distance: V::F) -> V::F {
        lines.codes(self.simd, (line - lines.first[0]) as i32, self.position(lines, level, distance))
    }

    /// Returns the positions of the planes across at a major distance, posts from the lines' first.
    #[inline(always)]
    fn position(&self, lines: &Lines<'_>, level: u8, distance: V::F) -> V::F {
        let side = f64::from(Grid::side_units(level));
        let eye = self.across / side - 0.5 - lines.first[1] as f64;
        let minor = self.minor * self.simd.splat((1.0 / side) as f32);
        minor.mul_add(distance, self.simd.splat(eye as f32))
    }

    /// The same, taken into the area.
    #[inline(always)]
    pub fn across(&self, lines: &Lines<'_>, level: u8, distance: V::F) -> V::F {
        lines.within(self.simd, self.position(lines, level, distance))
    }

    /// Codes in the cells of columns `cell` between the line before `line` and it, shares of the way across and
    /// along them; [`NO_CODE`] where one of the four posts has no surface.
    #[inline(always)]
    pub fn cell(&self, lines: &Lines<'_>, line: i64, [cell, across]: [V::F; 2], along: V::F) -> V::F {
        let index = (line - lines.first[0]) as i32;
        let near = lines.cell(self.simd, index - self.forward as i32, cell, across);
        self.between(near, lines.cell(self.simd, index, cell, across), along)
    }

    /// Codes between two, [`NO_CODE`] where either is.
    #[inline(always)]
    fn between(&self, near: V::F, far: V::F, share: V::F) -> V::F {
        // On the far line these are its own, to the bit.
        let codes = (far - near).neg_mul_add(self.simd.splat(1.0) - share, far);
        self.simd.splat(NO_CODE).select(self.is_nothing(near.min(far)), codes)
    }

    /// Codes of no surface.
    #[inline(always)]
    pub fn is_nothing(&self, codes: V::F) -> V::M {
        codes.lt(self.simd.splat(LEAST_CODE))
    }

    /// Height above the eye at a major distance, metres, of a code there; far below all of [`NO_CODE`].
    #[inline(always)]
    pub fn height(&self, codes: V::F, distance: V::F) -> V::F {
        self.drop.neg_mul_add(distance * distance, codes.mul_add(self.scale, self.offset))
    }

    /// Finds the surface along a line, which the processor fetches for the next group of planes, too.
    #[inline(always)]
    pub fn line(&self, lines: &Lines<'_>, line: SampleLine) -> Post<V> {
        let at = self.simd.splat(line.distance);
        lines.prefetch(self.simd, (line.line - lines.first[0]) as i32);
        self.post(self.height(self.codes(lines, line.level, line.line, at), at), line)
    }

    /// Returns the post at height `z` above the eye, metres, on a line.
    #[inline(always)]
    pub fn post(&self, z: V::F, line: SampleLine) -> Post<V> {
        let inverse = self.per_depth * self.simd.splat(1.0 / line.distance.max(f32::MIN_POSITIVE));
        Post { slope: self.slope(z, inverse), inverse, line }
    }

    /// Returns the tangent of the elevation of height `z` above the eye, metres, at an inverse depth, 1/metres.
    #[inline(always)]
    pub fn slope(&self, z: V::F, inverse: V::F) -> V::F {
        (z * inverse).max(self.simd.splat(NO_SLOPE)).min(self.simd.splat(-NO_SLOPE))
    }

    /// Height above the eye of the bilinear surface at a major distance, `share` of the way from the line
    /// before `line` to it, metres.
    #[inline(always)]
    pub fn surface(&self, lines: &Lines<'_>, level: u8, line: i64, distance: V::F, share: V::F) -> V::F {
        let near = self.codes(lines, level, line - self.forward, distance);
        let far = self.codes(lines, level, line, distance);
        self.height(self.between(near, far, share), distance)
    }
}
