//! Rows of the sky above all that planes see.
//!
//! ```text
//! every fourth row:   light of a clear sky in its middle     roots
//! rows between:       on a straight line between the roots
//! ```
//!
//! Fog and glow change faster: with them each row is looked up. So it is in panoramas, where rows that two views have in common are the same to the
//! bit, whatever row either begins with.

use super::cell::{Cell, Scale};
use crate::simd::{Floats, Simd};
use crate::weather::AtmosphereLanes;

/// Rows from one that is looked up to the next.
const STEP: usize = 4;

/// Greatest rise between them, as tangent: roots of a clear sky are linear over it within 0.01 of an 8-bit code.
const MOST_RISE: f32 = 0.0035;

/// Sky in rows of a plane image.
pub struct SkyRows<'r, V: Simd> {
    pub simd: V,
    /// Whether each row is looked up.
    pub is_exact: bool,
    /// Light of the sky.
    pub air: &'r AtmosphereLanes,
    /// 1 + a² of each plane.
    pub squares: V::F,
    /// Tangents of the rows' middles.
    pub centres: &'r [f32],
    /// Light that the cells' codes stand for.
    pub scale: Scale,
}

impl<V: Simd> SkyRows<'_, V> {
    /// Finds the light in the middle of a row.
    #[inline(always)]
    pub fn light<const FOG_OR_GLOW: bool>(&self, row: usize) -> [V::F; 3] {
        let tangent = self.simd.splat(self.centres[row]);
        let sine = tangent * tangent.mul_add(tangent, self.squares).rsqrt();
        self.air.sky::<V, FOG_OR_GLOW>(self.simd, sine)
    }

    #[inline(always)]
    fn roots<const FOG_OR_GLOW: bool>(&self, row: usize) -> [V::F; 3] {
        self.scale.roots(self.simd, self.light::<FOG_OR_GLOW>(row))
    }

    /// Fills the cells from a row on.
    #[inline(always)]
    pub fn fill<const FOG_OR_GLOW: bool>(&self, cells: &mut [Cell], first: usize) {
        let mut row = first;
        let mut below = None;
        while let Some(cell) = cells.get_mut(row) {
            let from = match below {
                Some(roots) => roots,
                None => self.roots::<FOG_OR_GLOW>(row),
            };
            if FOG_OR_GLOW || self.is_exact || !self.is_straight(row) {
                cell.put(self.simd, from);
                (row, below) = (row + 1, None);
                continue;
            }

            let to = self.roots::<FOG_OR_GLOW>(row + STEP);
            for (step, cell) in cells[row..].iter_mut().take(STEP).enumerate() {
                let share = self.simd.splat(step as f32 / STEP as f32);
                let mut roots = from;
                for (channel, root) in roots.iter_mut().enumerate() {
                    *root = (to[channel] - *root).mul_add(share, *root);
                }
                cell.put(self.simd, roots);
            }
            (row, below) = (row + STEP, Some(to));
        }
    }

    /// Whether a row and the one a step above are so near that roots lie on a straight line between them.
    #[inline(always)]
    fn is_straight(&self, row: usize) -> bool {
        self.centres.get(row + STEP).is_some_and(|above| above - self.centres[row] <= MOST_RISE)
    }
}
