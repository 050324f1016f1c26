//! Reading of planes at equal steps of azimuth and elevation, for pixels of any screen.

use super::super::cell::{Cell, add};
use super::{AT_EYE, Among, Depths, LookUp, along_surface, cubic};
use crate::raymarch::scan::{Annulus, Between, Gaze, Panorama};
use crate::simd::{Each, Floats, Ints, LANES, Mask, Simd};

/// Looks up what planes around the eye saw.
pub struct PanoramaImage<'a, V: Simd> {
    pub simd: V,
    pub panorama: &'a Panorama,
    /// Light, group by group.
    pub cells: &'a [Cell],
    /// Distances in the same order, of inverse range.
    pub depths: Depths<'a>,
}

/// Place of sixteen pixels among planes and rows.
pub struct PanoramaPlace<V: Simd> {
    gaze: Gaze<V>,
    /// Row below each pixel, and share of the way to the next.
    below: V::I,
    rise: V::F,
}

impl<V: Simd> PanoramaImage<'_, V> {
    /// The annulus that a pixel of `left` looks into, those of them that look into the same, and planes beside them.
    #[inline(always)]
    fn next(&self, place: &PanoramaPlace<V>, left: V::M) -> (&Annulus, V::M, Between<V>) {
        let annulus = self.panorama.annulus(place.below.least(left));
        let here = left & !place.below.gt(self.simd.splat_int(annulus.rows.end as i32 - 1));
        (annulus, here, annulus.between(self.simd, place.gaze.azimuth))
    }

    /// Offset, in words, of a row; rows are taken into the sphere.
    #[inline(always)]
    fn row(&self, row: V::I) -> V::I {
        let simd = self.simd;
        let row = row.max(simd.splat_int(0)).min(simd.splat_int(self.panorama.last_row()));
        row.shl::<{ LANES.ilog2() }>()
    }
}

impl<V: Simd> LookUp<V> for PanoramaImage<'_, V> {
    type Place = PanoramaPlace<V>;
    type Strip = ();

    #[inline(always)]
    fn strip(&self) {}

    #[inline(always)]
    fn begin(&self, (): &mut (), _: usize) {}

    #[inline(always)]
    fn place(&self, column: usize, row: usize) -> PanoramaPlace<V> {
        let gaze = self.panorama.gaze(self.simd, column, row);
        // Straight up there is no next row.
        let below = gaze.row.floor().min(self.simd.splat((self.panorama.last_row() - 1) as f32));
        PanoramaPlace { rise: gaze.row - below, below: below.to_int(), gaze }
    }

    /// Cubic between rows, straight between planes, which are closer to each other; black where there is no ray.
    #[inline(always)]
    fn roots(&self, (): &mut (), place: &PanoramaPlace<V>) -> [V::F; 3] {
        let simd = self.simd;
        let mut seen = [simd.splat(0.0); 3];
        let along = cubic(simd, place.rise);
        let mut left = place.gaze.lit;

        // Usually all lanes look into one annulus.
        while left.any() {
            let (_, here, between) = self.next(place, left);
            let across = [simd.splat(1.0) - between.share, between.share];
            let mut found = [simd.splat(0.0); 3];
            for (row, &up) in along.iter().enumerate() {
                let row = self.row(place.below + simd.splat_int(row as i32 - 1));
                for (side, plane) in between.words.iter().enumerate() {
                    let codes = Cell::gather(simd, self.cells, *plane + row);
                    add(simd, &mut found, codes, across[side] * up);
                }
            }

            for (channel, seen) in seen.iter_mut().enumerate() {
                let found = found[channel];
                *seen = found.max(simd.splat(0.0)).select(here, *seen);
            }
            left = left & !here;
        }

        seen
    }

    #[inline(always)]
    fn range(&self, place: &PanoramaPlace<V>) -> (V::F, V::M) {
        let simd = self.simd;
        let zero = simd.splat(0.0);
        let along = self.panorama.harmonic(simd, place.rise);
        let mut rows = [place.below; 4];
        for (index, row) in rows.iter_mut().enumerate() {
            *row = self.row(place.below + simd.splat_int(index as i32 - 1));
        }

        let (mut inverse, mut is_outline) = (zero, simd.mask(0));
        let mut left = place.gaze.lit;
        while left.any() {
            let (_, here, between) = self.next(place, left);
            let share = between.share;
            let [west, east] = between.words;

            // Of the planes beside these two it is not known whether they were marched.
            let word = |plane: i32, row: i32| {
                if plane <= 0 { west + rows[(row + 1) as usize] } else { east + rows[(row + 1) as usize] }
            };
            let across = [simd.splat(1.0) - share, share];
            let (ground, is_edge) = along_surface(
                simd,
                #[inline(always)]
                |plane, row| self.depths.inverse(simd, word(plane, row)),
                false,
                [across, along],
            );
            let words = [rows[1], rows[2]].each(|row| [west + row, east + row]);
            let (found, standing) =
                self.depths.standing(simd, ground, &Among { words, shares: [share, place.rise] });
            inverse = found.select(here, inverse);
            is_outline = is_outline | ((standing | is_edge) & here);
            left = left & !here;
        }

        let range = zero.select(simd.splat(AT_EYE).lt(inverse), inverse.recip());
        (range.select(zero.lt(inverse), simd.splat(f32::INFINITY)), is_outline)
    }
}
