//! Rows of a group of planes: light by the share of a row that each stretch of surface covers.
//!
//! ```text
//! for each stretch in sight, nearest first:
//!     for each edge between rows that it covers:
//!         light from the lowest edge up to there  →  sums[edge]
//! what is left above → sky
//! for each row:
//!     (sums[upper edge] − sums[lower edge]) / height  →  row's light
//! ```
//!
//! Rows are boxes, not points: a ridge that covers a third of a row gives it a third of its light, and what is narrower
//! than a row still counts. On a stretch light is linear in the tangent, so that its integral is a parabola.

use super::air::Air;
use super::cell::{Cell, Scale};
use super::paint::Light;
use crate::raymarch::scan::{NO_SLOPE, Profile};
use crate::simd::{Floats, Ints, Isa, Kernel, LANES, Mask, Simd, Sixteen};

/// Least rise of a stretch, as tangent: keeps quotients finite.
const LEAST_RISE: f32 = 1.0e-20;

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
    /// What the cells' codes stand for.
    pub scale: Scale,
    /// Inverse depth in the rows' middles, 1/metres, 0 for the sky; empty if nobody asks.
    pub inverse: &'r mut [Sixteen],
}

/// Memory for light below each edge, used again for every group.
pub type Sums = Vec<Light>;

impl Rows<'_> {
    /// Fills rows with what a profile of `lights` and the sky behind it send. `squares` is 1 + a² of each plane.
    pub fn fill(
        self,
        isa: Isa,
        profile: &Profile,
        lights: &[Light],
        air: &Air,
        squares: &[f32; LANES],
        sums: &mut Sums,
    ) {
        sums.resize(self.edges.len(), Light::default());
        isa.run(Filling { rows: self, profile, lights, air, squares, sums });
    }
}

struct Filling<'f, 'r> {
    rows: Rows<'r>,
    profile: &'f Profile,
    lights: &'f [Light],
    air: &'f Air,
    squares: &'f [f32; LANES],
    sums: &'f mut [Light],
}

impl Kernel for Filling<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { rows, profile, lights, air, squares, sums } = self;
        let zero = simd.splat(0.0);
        let mut covering = Covering {
            simd,
            next: simd.splat_int(1),
            covered: simd.splat(rows.edges[0]),
            light: [zero; 3],
            sums,
            rows,
        };
        covering.close(simd.mask(u16::MAX), 0);
        let pairs = profile.sights().windows(2).zip(lights.windows(2));
        for (sights, lights) in pairs {
            if !sights[1].mark.begins {
                covering.cover(&Stretch {
                    slopes: [simd.load(&sights[0].slope.0), simd.load(&sights[1].slope.0)],
                    inverse: [&sights[0].inverse, &sights[1].inverse],
                    lights: [&lights[0], &lights[1]],
                });
            }
        }
        covering.finish(air, simd.load(squares));
    }
}

/// The surface from one sight to the next.
struct Stretch<'s, V: Simd> {
    slopes: [V::F; 2],
    inverse: [&'s Sixteen; 2],
    lights: [&'s Light; 2],
}

/// Planes on their way up the rows.
struct Covering<'r, V: Simd> {
    simd: V,
    rows: Rows<'r>,
    sums: &'r mut [Light],
    /// First edge of each plane that is not covered.
    next: V::I,
    /// Tangent up to which each plane is covered, and light up to there: light times tangent.
    covered: V::F,
    light: [V::F; 3],
}

impl<V: Simd> Covering<'_, V> {
    #[inline(always)]
    fn cover(&mut self, stretch: &Stretch<'_, V>) {
        let simd = self.simd;
        let [low, high] = stretch.slopes;
        let rises = self.covered.lt(high);
        if !rises.any() {
            return;
        }
        let per_rise = (high - low).max(simd.splat(LEAST_RISE)).recip();
        if !self.rows.inverse.is_empty() {
            self.measure(stretch, rises, per_rise);
        }
        // Light at the bottom of what is in sight, and half its change per unit of tangent: the far end is where walls,
        // which begin at no finite tangent, have theirs.
        let unseen = (high - self.covered) * per_rise;
        let half_per_rise = per_rise * simd.splat(0.5);
        let (mut bottom, mut half_change) = (self.light, self.light);
        for channel in 0..3 {
            let top = simd.load(&stretch.lights[1][channel].0);
            let change = top - simd.load(&stretch.lights[0][channel].0);
            bottom[channel] = change.neg_mul_add(unseen, top);
            half_change[channel] = change * half_per_rise;
        }
        let high = high.select(rises, simd.splat(NO_SLOPE));
        let mut index = self.next.least(rises) as usize;
        while let Some(&edge) = self.rows.edges.get(index) {
            let edge = simd.splat(edge);
            let below = edge.le(high);
            if !below.any() {
                break;
            }
            let passed = below & self.covered.lt(edge);
            let rise = edge - self.covered;
            for channel in 0..3 {
                let light =
                    half_change[channel].mul_add(rise, bottom[channel]).mul_add(rise, self.light[channel]);
                light.store_masked(passed, &mut self.sums[index][channel].0);
            }
            index += 1;
            self.next = simd.splat_int(index as i32).select(passed, self.next);
        }
        let rise = high - self.covered;
        for channel in 0..3 {
            let light =
                half_change[channel].mul_add(rise, bottom[channel]).mul_add(rise, self.light[channel]);
            self.light[channel] = light.select(rises, self.light[channel]);
        }
        self.covered = self.covered.max(high);
    }

    /// Inverse depth in the middles of rows that a stretch covers.
    #[inline(always)]
    fn measure(&mut self, stretch: &Stretch<'_, V>, rises: V::M, per_rise: V::F) {
        let simd = self.simd;
        let [low, high] = stretch.slopes;
        let [near, far] = stretch.inverse.map(|inverse| simd.load(&inverse.0));
        let first = (self.next.least(rises) - 1) as usize;
        for (centre, inverse) in self.rows.centres.iter().zip(&mut *self.rows.inverse).skip(first) {
            let centre = simd.splat(*centre);
            let below = rises & centre.lt(high);
            if !below.any() {
                break;
            }
            let share = ((centre - low) * per_rise).max(simd.splat(0.0)).min(simd.splat(1.0));
            let seen = below & self.covered.le(centre);
            (far - near).mul_add(share, near).store_masked(seen, &mut inverse.0);
        }
    }

    /// All light that came so far is below an edge.
    #[inline(always)]
    fn close(&mut self, planes: V::M, index: usize) {
        for (light, sum) in self.light.iter().zip(&mut self.sums[index]) {
            light.store_masked(planes, &mut sum.0);
        }
    }

    /// Leaves what is above to the sky, and takes light from edges to rows.
    #[inline(always)]
    fn finish(mut self, air: &Air, squares: V::F) {
        let simd = self.simd;
        let open = self.next.least(simd.mask(u16::MAX)) as usize;
        for index in open..self.rows.edges.len() {
            let planes = !self.next.gt(simd.splat_int(index as i32));
            self.close(planes, index);
        }
        let Self { rows, sums, covered, next, .. } = self;
        let first_sky = (open - 1).min(rows.cells.len());
        let [ground, sky] = {
            let (ground, sky) = rows.cells.split_at_mut(first_sky);
            [ground, sky]
        };
        let edges = sums.windows(2);
        for ((edges, per_row), cell) in edges.zip(rows.per_row).zip(ground) {
            rows.scale.encode(simd, between(simd, edges, *per_row)).store(&mut cell.0);
        }
        for (row, cell) in (first_sky..).zip(sky) {
            let per_row = rows.per_row[row];
            let mut seen = between(simd, &sums[row..row + 2], per_row);
            let tangent = simd.splat(rows.centres[row]);
            let sine = tangent * tangent.mul_add(tangent, squares).rsqrt();
            // What is left of the row above the surface.
            let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
            let share = (simd.splat(rows.edges[row + 1]) - covered) * simd.splat(per_row);
            let share = share.max(zero).min(one);
            for (seen, sky) in seen.iter_mut().zip(air.sky(simd, sine)) {
                *seen = sky.mul_add(share, *seen);
            }
            rows.scale.encode(simd, seen).store(&mut cell.0);
            if let Some(inverse) = rows.inverse.get_mut(row) {
                let open = !next.gt(simd.splat_int(row as i32 + 1));
                zero.store_masked(open & covered.le(tangent), &mut inverse.0);
            }
        }
    }
}

/// Light of the row between two edges.
#[inline(always)]
fn between<V: Simd>(simd: V, edges: &[Light], per_row: f32) -> [V::F; 3] {
    let mut light = [simd.splat(0.0); 3];
    for (channel, light) in light.iter_mut().enumerate() {
        let (low, high) = (simd.load(&edges[0][channel].0), simd.load(&edges[1][channel].0));
        *light = (high - low) * simd.splat(per_row);
    }
    light
}
