//! Rows of a group of planes: light by the share of a row that each stretch of surface covers.
//!
//! ```text
//! for each stretch in sight, nearest first:
//!     for each row that it covers part of, from the first open one up:
//!         row's light += share of the row × light in the middle of that part
//!         the row is covered to its upper edge → it is done
//! what is left of the rows → sky
//! ```
//!
//! Rows are boxes, not points: a ridge that covers a third of a row gives it a third of its light, and what is narrower
//! than a row still counts.

use super::air::Air;
use super::paint::Light;
use crate::raymarch::scan::Profile;
use crate::simd::{Floats, Ints, Isa, Kernel, LANES, Mask, Simd, Sixteen};

/// Least rise of a stretch, as tangent: keeps quotients finite.
const LEAST_RISE: f32 = 1.0e-20;

/// Added to a code, has it rounded where it is cut.
const ROUNDING: f32 = 0.5;

/// Light of sixteen planes in one row, as whole codes: `red | green << 16`, and blue.
pub type Cell = [Sixteen; 2];

/// Rows to fill, from the lowest; all slices are of one length but `edges`, which has one more.
pub struct Rows<'r> {
    /// Tangents of elevation of the rows' edges, rising.
    pub edges: &'r [f32],
    /// Of their middles.
    pub centres: &'r [f32],
    /// 1 / (upper edge − lower edge).
    pub per_row: &'r [f32],
    /// Light.
    pub cells: &'r mut [Cell],
    /// Inverse depth in the rows' middles, 1/metres, 0 for the sky; empty if nobody asks.
    pub inverse: &'r mut [Sixteen],
}

impl Rows<'_> {
    /// Fills rows with what a profile of `lights` and the sky behind it send. `squares` is 1 + a² of each plane.
    pub fn fill(self, isa: Isa, profile: &Profile, lights: &[Light], air: &Air, squares: &[f32; LANES]) {
        isa.run(Filling { rows: self, profile, lights, air, squares });
    }
}

struct Filling<'f, 'r> {
    rows: Rows<'r>,
    profile: &'f Profile,
    lights: &'f [Light],
    air: &'f Air,
    squares: &'f [f32; LANES],
}

impl Kernel for Filling<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        // Two loops instead of a question per row.
        if self.rows.inverse.is_empty() { self.fill::<V, false>(simd) } else { self.fill::<V, true>(simd) }
    }
}

impl Filling<'_, '_> {
    #[inline(always)]
    fn fill<V: Simd, const RANGED: bool>(self, simd: V) {
        let Self { rows, profile, lights, air, squares } = self;
        let mut open = Open::<V, RANGED> {
            simd,
            next: simd.splat_int(0),
            covered: simd.splat(rows.edges[0]),
            sum: [simd.splat(ROUNDING); 3],
            rows,
        };
        let pairs = profile.sights().windows(2).zip(lights.windows(2));
        for (sights, lights) in pairs {
            if sights[1].mark.begins {
                continue;
            }
            open.cover(&Stretch {
                slopes: [simd.load(&sights[0].slope.0), simd.load(&sights[1].slope.0)],
                inverse: [&sights[0].inverse, &sights[1].inverse],
                lights: [&lights[0], &lights[1]],
            });
        }
        open.finish(air, simd.load(squares));
    }
}

/// The surface from one sight to the next.
struct Stretch<'s, V: Simd> {
    slopes: [V::F; 2],
    inverse: [&'s Sixteen; 2],
    lights: [&'s Light; 2],
}

/// The rows that are still open; `RANGED`: somebody asks for depth.
struct Open<'r, V: Simd, const RANGED: bool> {
    simd: V,
    rows: Rows<'r>,
    /// First open row of each plane.
    next: V::I,
    /// Tangent up to which each plane is covered.
    covered: V::F,
    /// Light of what covers the first open row, times its share, and what rounds it.
    sum: [V::F; 3],
}

impl<V: Simd, const RANGED: bool> Open<'_, V, RANGED> {
    #[inline(always)]
    fn cover(&mut self, stretch: &Stretch<'_, V>) {
        let simd = self.simd;
        let [low, high] = stretch.slopes;
        let risen = self.covered.lt(high);
        if !risen.any() {
            return;
        }
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let per_rise = (high - low).max(simd.splat(LEAST_RISE)).recip();
        // The middle of a part is half the sum of its ends.
        let (twice_low, half_per_rise) = (low + low, per_rise * simd.splat(0.5));
        let [mut light, mut change] = [[zero; 3]; 2];
        for channel in 0..3 {
            light[channel] = simd.load(&stretch.lights[0][channel].0);
            change[channel] = simd.load(&stretch.lights[1][channel].0) - light[channel];
        }
        // What is covered above a row, or does not rise above what is covered, covers a part of it that is not
        // positive: no other mask is needed.
        let mut row = self.next.least(risen) as usize;
        while row < self.rows.cells.len() {
            let edge = simd.splat(self.rows.edges[row + 1]);
            let top = high.min(edge);
            if RANGED {
                let centre = simd.splat(self.rows.centres[row]);
                let seen = self.covered.le(centre) & centre.lt(top);
                let share = ((centre - low) * per_rise).max(zero).min(one);
                let [near, far] = stretch.inverse.map(|inverse| simd.load(&inverse.0));
                (far - near).mul_add(share, near).store_masked(seen, &mut self.rows.inverse[row].0);
            }
            // At most 1, also where neither end is a surface: what has no weight must be finite.
            let share = ((top + self.covered - twice_low) * half_per_rise).max(zero).min(one);
            let weight = (top - self.covered).max(zero) * simd.splat(self.rows.per_row[row]);
            for channel in 0..3 {
                let seen = change[channel].mul_add(share, light[channel]);
                self.sum[channel] = weight.mul_add(seen, self.sum[channel]);
            }
            let reached = risen & edge.le(high);
            let done = reached & self.covered.lt(edge);
            self.covered = self.covered.max(top);
            if !reached.any() {
                break;
            }
            put(simd, self.sum, done, &mut self.rows.cells[row]);
            for sum in &mut self.sum {
                *sum = simd.splat(ROUNDING).select(done, *sum);
            }
            row += 1;
            self.next = simd.splat_int(row as i32).select(done, self.next);
        }
    }

    /// Leaves the rest to the sky.
    #[inline(always)]
    fn finish(self, air: &Air, squares: V::F) {
        let Self { simd, rows, next, covered, sum } = self;
        let first = next.least(simd.mask(u16::MAX)).max(0) as usize;
        for row in first..rows.cells.len() {
            let index = simd.splat_int(row as i32);
            let open = !next.gt(index);
            let tangent = simd.splat(rows.centres[row]);
            let sine = tangent * tangent.mul_add(tangent, squares).rsqrt();
            let mut seen = air.sky(simd, sine);
            let begins = next.eq(index);
            if begins.any() {
                let share = (simd.splat(rows.edges[row + 1]) - covered) * simd.splat(rows.per_row[row]);
                for channel in 0..3 {
                    let part = seen[channel].mul_add(share, sum[channel]);
                    seen[channel] = part.select(begins, seen[channel] + simd.splat(ROUNDING));
                }
            } else {
                for seen in &mut seen {
                    *seen = *seen + simd.splat(ROUNDING);
                }
            }
            put(simd, seen, open, &mut rows.cells[row]);
            if RANGED {
                let centre = simd.splat(rows.centres[row]);
                let sky = open & (!begins | covered.le(centre));
                simd.splat(0.0).store_masked(sky, &mut rows.inverse[row].0);
            }
        }
    }
}

/// Writes codes that [`ROUNDING`] was added to.
#[inline(always)]
fn put<V: Simd>(_: V, [red, green, blue]: [V::F; 3], planes: V::M, cell: &mut Cell) {
    (red.to_int() | green.to_int().shl::<16>()).as_floats().store_masked(planes, &mut cell[0].0);
    blue.to_int().as_floats().store_masked(planes, &mut cell[1].0);
}
