//! The way of planes through the cells between two neighbouring lines, where they follow the bilinear surface itself.

use super::ground::{Crease, PlaneGround};
use super::lines::Lines;
use super::profile::{Post, SampleLine};
use crate::simd::{Floats, Mask, Simd};
use crate::voxel::Grid;

/// Parts of a near stretch, times its distance in lines; the error falls with their square.
const NEAR_PARTS: f32 = 64.0;

/// Most parts of a near stretch between lines.
pub(super) const MOST_NEAR_PARTS: f32 = 16.0;

/// Returns the parts of a stretch between lines of a level that ends at a major distance (units), by how near that is.
#[inline(always)]
pub(super) fn near_parts(level: u8, distance: f32) -> f32 {
    (NEAR_PARTS * Grid::side_units(level) as f32 / distance).clamp(1.0, MOST_NEAR_PARTS)
}

/// A way through cells, in parts.
pub(super) struct CellWay<V: Simd> {
    /// Line at its end, and major distance at which it begins, units.
    line: SampleLine,
    from: f32,
    /// Distance from line to line, units.
    side: f32,
    /// Shares of the way after which half of the parts end, 0 to 1, and how many that are.
    half_way: V::F,
    halves: i32,
}

impl<V: Simd> CellWay<V> {
    /// Plans a way of about so many `parts`. Where a plane crosses a column of posts the surface has a crease, which may be a horizon: half of the
    /// parts end there.
    #[inline(always)]
    pub fn new(ground: &PlaneGround<V>, lines: &Lines<'_>, from: f32, line: SampleLine, parts: f32) -> Self {
        let simd = ground.simd;
        let way = [simd.splat(from), simd.splat(line.distance)];
        let Crease { crosses, share, .. } = ground.crease(lines, line.level, way);
        let halves = (parts as i32 / 2).max(i32::from(crosses.any()));
        let half_way = share.select(crosses, simd.splat(0.5));
        Self { line, from, side: Grid::side_units(line.level) as f32, half_way, halves }
    }

    /// Returns the way in parts that are as long as each other.
    #[inline(always)]
    pub fn even(self, simd: V) -> Self {
        Self { half_way: simd.splat(0.5), ..self }
    }

    /// Returns the number of parts before the last one.
    #[inline(always)]
    pub fn inner_parts(&self) -> i32 {
        (2 * self.halves - 1).max(0)
    }

    /// Finds the bilinear surface at the end of one of the parts, counted from 1.
    #[inline(always)]
    pub fn post(&self, ground: &PlaneGround<V>, lines: &Lines<'_>, part: i32) -> Post<V> {
        let (simd, SampleLine { level, line, distance: to, .. }) = (ground.simd, self.line);
        let way = part as f32 / self.halves as f32;
        let beyond = simd.splat((way - 1.0).max(0.0));
        let (near, far) = (simd.splat(self.from), simd.splat(to));
        let at = self.half_way.mul_add(simd.splat(way.min(1.0)) - beyond, beyond).mul_add(far - near, near);

        let share = (at - far).mul_add(simd.splat(1.0 / self.side), simd.splat(1.0));
        let z = ground.surface(lines, level, line, at, share);
        let inverse = ground.per_depth * at.recip();
        let distance = self.from + (to - self.from) * 0.5 * way;
        let line = SampleLine { distance, share: 1.0 - (to - distance) / self.side, ..self.line };
        Post { slope: ground.slope(z, inverse), inverse, line }
    }
}
