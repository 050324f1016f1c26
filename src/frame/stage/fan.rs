//! What pixels see of the fan of planes: inverse depth between planes.

use std::ops::Range;

use crate::raymarch::scan::{EDGE_STEPS, LevelRow, Upright};
use crate::simd::{Floats, Ints, LANES, Mask, Simd, Sixteen};

/// Inverse depths of neighbouring planes that differ by more than this share belong to two surfaces.
const EDGE: f32 = 0.06;

/// Sixteen pixels, looked up.
pub struct Seen<V: Simd> {
    /// Inverse depth, 1/metres; 0: sky.
    pub inverse: V::F,
    /// Depth and range, metres; of no particular value for the sky.
    pub depth: V::F,
    /// Range, metres.
    pub range: V::F,
    /// Ground metres eastward and northward, and metres upward, per metre of depth.
    pub slope: [V::F; 3],
    /// Depth per range.
    pub per_slant: V::F,
    /// Sixteenths of the way from the row below to this one at which that one's surface ends; 0: it goes on.
    edge: V::I,
}

impl<V: Simd> Seen<V> {
    /// Shares of these pixels that the surface of the row below covers, and of the row below that
    /// this surface is seen in; `None` if no edge lies between them.
    #[inline(always)]
    pub fn edges(&self, simd: V) -> Option<[V::F; 2]> {
        let cut = self.edge.gt(simd.splat_int(0));
        if !cut.any() {
            return None;
        }
        let (zero, half) = (simd.splat(0.0), simd.splat(0.5));
        let reach = self
            .edge
            .to_float()
            .mul_add(simd.splat(1.0 / EDGE_STEPS as f32), simd.splat(0.5 / EDGE_STEPS as f32));
        let above = (reach - half).select(cut, zero);
        Some([above.max(zero), (zero - above).max(zero)])
    }
}

/// The fan, and how the screen lies in it.
pub struct Fan<'a, V: Simd> {
    simd: V,
    upright: &'a Upright,
    /// `[group][row][lane]`.
    inverse: &'a [Sixteen],
    columns: V::F,
    axes: [[f32; 2]; 2],
    /// First row of `levels`.
    first: usize,
    /// Rows of an unrolled screen; none of a rolled one.
    levels: Vec<LevelRow>,
}

impl<'a, V: Simd> Fan<'a, V> {
    /// Over inverse depth as it was marched, for `rows` of the screen, one before and two behind them.
    #[inline(always)]
    pub fn new(simd: V, upright: &'a Upright, inverse: &'a [Sixteen], rows: Range<usize>) -> Self {
        let first = rows.start.saturating_sub(1);
        let levels = (first..rows.end + 2).map_while(|row| upright.level_row(row as f32 + 0.5)).collect();
        let mut columns = [0.0; LANES];
        columns.iter_mut().enumerate().for_each(|(lane, column)| *column = lane as f32 + 0.5);
        Self { simd, upright, inverse, columns: simd.load(&columns), axes: upright.axes(), first, levels }
    }

    /// Sixteen pixels from `column` of a screen's `row` on.
    #[inline(always)]
    pub fn see(&self, column: usize, row: usize) -> Seen<V> {
        let simd = self.simd;
        let columns = self.columns + simd.splat(column as f32);
        match self.levels.get(row - self.first) {
            Some(level) => {
                let across = columns.mul_add(simd.splat(level.across[0]), simd.splat(level.across[1]));
                let tangent = simd.splat(level.tangent);
                let (inverse, edge) = self.between_planes(level, columns, column);
                self.seen(inverse, edge, across, tangent)
            }
            None => {
                let look = self.upright.look(simd, columns, row as f32 + 0.5);
                let inverse = self.between_planes_and_rows(look.plane, look.row);
                self.seen(inverse, simd.splat_int(0), look.across, look.tangent)
            }
        }
    }

    #[inline(always)]
    fn seen(&self, inverse: V::F, edge: V::I, across: V::F, tangent: V::F) -> Seen<V> {
        let simd = self.simd;
        let [ahead, right] = self.axes;
        let east = across.mul_add(simd.splat(right[0]), simd.splat(ahead[0]));
        let north = across.mul_add(simd.splat(right[1]), simd.splat(ahead[1]));
        let slant = across.mul_add(across, tangent.mul_add(tangent, simd.splat(1.0)));
        let per_slant = slant.rsqrt();
        let depth = inverse.recip();
        Seen {
            inverse,
            depth,
            range: depth * slant * per_slant,
            slope: [east, north, tangent],
            per_slant,
            edge,
        }
    }

    /// On an unrolled screen rows are rows of the fan.
    #[inline(always)]
    fn between_planes(&self, level: &LevelRow, columns: V::F, column: usize) -> (V::F, V::I) {
        let simd = self.simd;
        let plane = columns.mul_add(simd.splat(level.plane[0]), simd.splat(level.plane[1]));
        let whole = plane.floor();
        let share = plane - whole;
        let [planes, rows] = self.upright.size;
        let row = level.row.clamp(0, rows as i32 - 1);
        // Two groups hold all sixteen, unless planes are much closer than pixels.
        let first = (column as f32 + 0.5).mul_add(level.plane[0], level.plane[1]).floor() as i32;
        let last =
            (column as f32 + LANES as f32 - 0.5).mul_add(level.plane[0], level.plane[1]).floor() as i32 + 2;
        let group = first.div_euclid(LANES as i32);
        let (left, right) = if group >= 0 && last < (group + 2) * LANES as i32 && last < planes as i32 {
            let at = group as usize * rows + row as usize;
            let low = simd.load(&self.inverse[at].0);
            let high = simd.load(&self.inverse[at + rows].0);
            let index = whole.to_int() - simd.splat_int(group * LANES as i32);
            (simd.permute2(low, high, index), simd.permute2(low, high, index + simd.splat_int(1)))
        } else {
            let plane = whole.to_int();
            let row = simd.splat_int(row);
            (self.at(plane, row), self.at(plane + simd.splat_int(1), row))
        };
        let near = share.lt(simd.splat(0.5));
        let nearest = left.select(near, right);
        let edge = nearest.to_bits() & simd.splat_int(EDGE_STEPS - 1);
        let (left, right) = (self.depth_bits(left), self.depth_bits(right));
        let smooth = (right - left).abs().le((left + right) * simd.splat(EDGE));
        let between = (right - left).mul_add(share, left);
        (between.select(smooth, self.depth_bits(nearest)), edge)
    }

    #[inline(always)]
    fn between_planes_and_rows(&self, plane: V::F, row: V::F) -> V::F {
        let simd = self.simd;
        let (left, below) = (plane.floor(), row.floor());
        let (share, rise) = (plane - left, row - below);
        let (left, below) = (left.to_int(), below.to_int());
        let (right, above) = (left + simd.splat_int(1), below + simd.splat_int(1));
        let a = self.depth_bits(self.at(left, below));
        let b = self.depth_bits(self.at(right, below));
        let c = self.depth_bits(self.at(left, above));
        let d = self.depth_bits(self.at(right, above));
        let (low, high) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        let (lower, upper) = ((b - a).mul_add(share, a), (d - c).mul_add(share, c));
        let half = simd.splat(0.5);
        let (near_left, near_below) = (share.lt(half), rise.lt(half));
        let nearest = a.select(near_left, b).select(near_below, c.select(near_left, d));
        let smooth = (high - low).le((high + low) * simd.splat(EDGE));
        (upper - lower).mul_add(rise, lower).select(smooth, nearest)
    }

    /// Inverse depth without what its last bits tell.
    #[inline(always)]
    fn depth_bits(&self, inverse: V::F) -> V::F {
        (inverse.to_bits() & self.simd.splat_int(!(EDGE_STEPS - 1))).as_floats()
    }

    /// What a plane saw in a row; both are taken into the fan.
    #[inline(always)]
    fn at(&self, plane: V::I, row: V::I) -> V::F {
        let simd = self.simd;
        let [planes, rows] = self.upright.size;
        let plane = plane.max(simd.splat_int(0)).min(simd.splat_int(planes as i32 - 1));
        let row = row.max(simd.splat_int(0)).min(simd.splat_int(rows as i32 - 1));
        let group = plane.shr::<4>().mul(simd.splat_int((rows * LANES) as i32));
        simd.gather(
            bytemuck::cast_slice(self.inverse),
            group + (plane & simd.splat_int(LANES as i32 - 1)) + row.shl::<4>(),
        )
    }
}
