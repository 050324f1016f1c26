//! Spans put before the ground in the plane image.

use super::cell::{Cell, Scale};
use crate::raymarch::scan::{RowTable, SpanCoverage};
use crate::simd::{Floats, Isa, Kernel, LANES, Mask, Simd, Sixteen};
use crate::weather::AtmosphereLanes;

/// Share of a row above which it shows something.
const LEAST_SHARE: f32 = 1.0e-3;

/// Tilt of inverse depth where nothing stands.
pub const GROUND: f32 = f32::INFINITY;

/// Puts what `cover` has of a group of planes before what its rows show already, with the air before it.
pub struct SpanPaint<'r> {
    /// Rows of the plane image.
    pub row_table: &'r RowTable,
    /// Index of the first one that is filled.
    pub first: usize,
    /// Light of the rows.
    pub cells: &'r mut [Cell],
    /// Light that the cells' codes stand for.
    pub scale: Scale,
    /// Inverse depth in the rows' middles, 1/metres; empty if nobody asks.
    pub inverse: &'r mut [Sixteen],
    /// Slopes of distance where something stands: to the next plane, and for each unit of the tangent; infinite where nothing does. Empty if nobody
    /// asks.
    pub tilts: [&'r mut [Sixteen]; 2],
    /// Coverage of what stands before them.
    pub cover: &'r SpanCoverage,
    /// Haze.
    pub air: &'r AtmosphereLanes,
    /// 1 + a² of each plane.
    pub squares: &'r [f32; LANES],
}

impl SpanPaint<'_> {
    /// Does it.
    pub fn put(self, isa: Isa) {
        isa.run(self);
    }
}

impl Kernel for SpanPaint<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(mut self, simd: V) {
        let squares = simd.load(self.squares);
        for tilts in self.tilts.iter_mut() {
            tilts.fill(Sixteen([GROUND; LANES]));
        }

        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        for (row, seen, middle) in self.cover.rows() {
            let (Some(cell), Some(centre)) =
                (self.cells.get_mut(row), self.row_table.centres.get(self.first + row))
            else {
                continue;
            };
            let share = simd.load(&seen.share.0).min(one);
            let shows = simd.splat(LEAST_SHARE).lt(share);
            if !shows.any() {
                continue;
            }

            let per_share = share.max(simd.splat(LEAST_SHARE)).recip();
            let mut light = [zero; 3];
            for (channel, light) in light.iter_mut().enumerate() {
                *light = simd.load(&seen.light[channel].0) * per_share;
            }

            let inverse = (simd.load(&seen.inverse.0) * per_share).select(shows, one);
            let slope = simd.splat(*centre);
            let depth = inverse.recip();
            let slant = slope.mul_add(slope, squares).sqrt_rough();
            let near = self.air.over(simd, light, slant * depth, slope * depth);
            let mut mixed = self.scale.decode(simd, cell);
            for (channel, mixed) in mixed.iter_mut().enumerate() {
                let near = near[channel];
                *mixed = (near - *mixed).mul_add(share, *mixed);
            }

            self.scale.encode_masked(simd, mixed, shows, cell);
            if let (Some(known), Some(middle)) = (self.inverse.get_mut(row), middle) {
                let inverse = simd.load(&middle.inverse.0);
                let stands = zero.lt(inverse);
                inverse.store_masked(stands, &mut known.0);
                for (tilts, tilt) in self.tilts.iter_mut().zip(&middle.tilts) {
                    simd.load(&tilt.0).store_masked(stands, &mut tilts[row].0);
                }
            }
        }
    }
}
