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

use std::ops::Range;

use super::cell::{Cell, Scale};
use super::paint::PlaneLight;
use crate::raymarch::scan::{NO_SLOPE, Profile, RowTable, VisibleSegment};
use crate::simd::{Each, Floats, Ints, Isa, Kernel, LANES, Mask, Simd, Sixteen};
use crate::weather::AtmosphereLanes;

/// Least rise of a stretch, as tangent: keeps quotients finite.
const LEAST_RISE: f32 = 1.0e-20;

/// Rows to fill, from the lowest.
pub struct RowFill<'r> {
    /// Rows of the plane image.
    pub row_table: &'r RowTable,
    /// Index of the first one that is filled.
    pub first: usize,
    /// Light.
    pub cells: &'r mut [Cell],
    /// Light that the cells' codes stand for.
    pub scale: Scale,
    /// Inverse depth in the rows' middles, 1/metres, 0 for the sky; empty if nobody asks.
    pub inverse: &'r mut [Sixteen],
}

/// Memory for light below each edge, used again for every group.
pub type EdgeSums = Vec<PlaneLight>;

impl RowFill<'_> {
    /// Fills rows with what a profile of `lights` and the sky behind it send. `squares` is 1 + a² of each plane.
    pub fn fill(
        self,
        isa: Isa,
        profile: &Profile,
        lights: &[PlaneLight],
        air: &AtmosphereLanes,
        squares: &[f32; LANES],
        sums: &mut EdgeSums,
    ) {
        sums.resize(self.cells.len() + 1, PlaneLight::default());
        if air.has_fog_or_glow() {
            isa.run(RowFilling::<true> { rows: self, profile, lights, air, squares, sums });
        } else {
            isa.run(RowFilling::<false> { rows: self, profile, lights, air, squares, sums });
        }
    }

    /// Picks these rows' own edges of those that are counted from the plane image's lowest, and counts them from theirs.
    #[inline(always)]
    fn own(&self, edges: Range<usize>) -> Range<usize> {
        let own = |edge: usize| edge.saturating_sub(self.first).min(self.cells.len() + 1);
        own(edges.start)..own(edges.end)
    }
}

struct RowFilling<'f, 'r, const FOG_OR_GLOW: bool> {
    rows: RowFill<'r>,
    profile: &'f Profile,
    lights: &'f [PlaneLight],
    air: &'f AtmosphereLanes,
    squares: &'f [f32; LANES],
    sums: &'f mut [PlaneLight],
}

impl<const FOG_OR_GLOW: bool> Kernel for RowFilling<'_, '_, FOG_OR_GLOW> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { rows, profile, lights, air, squares, sums } = self;
        let edges = &rows.row_table.edges[rows.first..=rows.first + rows.cells.len()];
        let mut covering =
            Covering { simd, covered: simd.splat(edges[0]), light: [simd.splat(0.0); 3], edges, sums, rows };
        covering.close(simd.mask(u16::MAX), 0);
        let mut spans = Spans { at: 1, ..Spans::default() };

        loop {
            // Where loops end is known long before they are run: they need not wait for each other.
            spans.find(simd, &covering, profile.segments());
            for index in 0..spans.count {
                let segment = spans.segments[index];
                let (Some(segments), Some(lights)) =
                    (profile.segments().get(segment - 1..=segment), lights.get(segment - 1..=segment))
                else {
                    continue;
                };
                let stretch = RowStretch {
                    slopes: [simd.load(&segments[0].slope.0), simd.load(&segments[1].slope.0)],
                    inverse: [&segments[0].inverse, &segments[1].inverse],
                    lights: [&lights[0], &lights[1]],
                };
                let row_table = covering.rows.row_table;
                let edges = row_table.between(spans.cells[0][index], spans.cells[1][index]);
                covering.cover(&stretch, covering.rows.own(edges));
            }

            if spans.count < LANES {
                break;
            }
        }

        covering.finish::<FOG_OR_GLOW>(air, simd.load(squares));
    }
}

/// The next stretches that are in sight, and which edges they may cover.
#[derive(Default)]
struct Spans {
    /// The segments that they end in.
    segments: [usize; LANES],
    count: usize,
    /// Cells of the row table, first and last.
    cells: [[i32; LANES]; 2],
    /// The segment to look at next.
    at: usize,
}

impl Spans {
    /// Goes on to the next ones.
    #[inline(always)]
    fn find<V: Simd>(&mut self, simd: V, covering: &Covering<'_, V>, segments: &[VisibleSegment]) {
        let mut covered = covering.covered;
        let [lowest, highest] = [-NO_SLOPE, NO_SLOPE].each(|slope| simd.splat(slope));
        let mut ends = [[0.0; LANES]; 2];
        self.count = 0;

        while self.count < LANES
            && let Some(segment) = segments.get(self.at)
        {
            let high = simd.load(&segment.slope.0);
            let rises = covered.lt(high);
            if !segment.line.begins && rises.any() {
                ends[0][self.count] = covered.select(rises, lowest).least();
                ends[1][self.count] = high.select(rises, highest).greatest();
                self.segments[self.count] = self.at;
                self.count += 1;
                covered = covered.max(high);
            }
            self.at += 1;
        }

        let [low, high] = ends.each(|ends| simd.load(&ends));
        let cells = covering.rows.row_table.cells(simd, low, high);
        for (end, target) in self.cells.iter_mut().enumerate() {
            cells[end].store(target);
        }
    }
}

/// The surface from one segment to the next.
struct RowStretch<'s, V: Simd> {
    slopes: [V::F; 2],
    inverse: [&'s Sixteen; 2],
    lights: [&'s PlaneLight; 2],
}

/// Planes on their way up the rows.
struct Covering<'r, V: Simd> {
    simd: V,
    rows: RowFill<'r>,
    /// Edges of these rows.
    edges: &'r [f32],
    sums: &'r mut [PlaneLight],
    /// Tangent up to which each plane is covered, and light up to there: light times tangent.
    covered: V::F,
    light: [V::F; 3],
}

impl<V: Simd> Covering<'_, V> {
    /// Takes in a stretch, which covers no other edges than those of `span`.
    #[inline(always)]
    fn cover(&mut self, stretch: &RowStretch<'_, V>, span: Range<usize>) {
        let simd = self.simd;
        let [low, high] = stretch.slopes;
        let rises = self.covered.lt(high);
        let per_rise = (high - low).max(simd.splat(LEAST_RISE)).recip();
        if !self.rows.inverse.is_empty() {
            self.measure(stretch, rises, per_rise, span.clone());
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
        let edges = self.edges.get(span.clone()).unwrap_or_default();
        let sums = self.sums.get_mut(span).unwrap_or_default();
        for (index, sums) in sums.iter_mut().enumerate() {
            let edge = simd.splat(edges[index]);
            let passed = edge.le(high) & self.covered.lt(edge);
            let rise = edge - self.covered;
            for channel in 0..3 {
                let light =
                    half_change[channel].mul_add(rise, bottom[channel]).mul_add(rise, self.light[channel]);
                light.store_masked(passed, &mut sums[channel].0);
            }
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
    fn measure(&mut self, stretch: &RowStretch<'_, V>, rises: V::M, per_rise: V::F, span: Range<usize>) {
        let simd = self.simd;
        let [low, high] = stretch.slopes;
        let [near, far] = stretch.inverse.each(|inverse| simd.load(&inverse.0));
        let centres = &self.rows.row_table.centres[self.rows.first..];
        // The row above an edge that is not covered may be covered in its middle, and the one below.
        let rows = span.start.saturating_sub(1)..span.end.min(self.rows.inverse.len());
        for row in rows {
            let centre = simd.splat(centres[row]);
            let share = ((centre - low) * per_rise).max(simd.splat(0.0)).min(simd.splat(1.0));
            let seen = rises & centre.lt(high) & self.covered.le(centre);
            (far - near).mul_add(share, near).store_masked(seen, &mut self.rows.inverse[row].0);
        }
    }

    /// All light that came so far is below an edge.
    #[inline(always)]
    fn close(&mut self, planes: V::M, index: usize) {
        for (channel, sum) in self.sums[index].iter_mut().enumerate() {
            self.light[channel].store_masked(planes, &mut sum.0);
        }
    }

    /// Leaves what is above to the sky, and takes light from edges to rows.
    #[inline(always)]
    fn finish<const FOG_OR_GLOW: bool>(mut self, air: &AtmosphereLanes, squares: V::F) {
        let simd = self.simd;
        let least = self.covered.least();
        let open = self.edges.partition_point(|&edge| edge <= least);
        for index in open..self.edges.len() {
            let planes = self.covered.lt(simd.splat(self.edges[index]));
            self.close(planes, index);
        }

        let Self { rows, sums, covered, edges, .. } = self;
        let first_sky = (open - 1).min(rows.cells.len());
        let (ground, sky) = rows.cells.split_at_mut(first_sky);
        let row_table = rows.row_table;
        let (per_rows, centres) = (&row_table.per_row[rows.first..], &row_table.centres[rows.first..]);
        for (row, cell) in ground.iter_mut().enumerate() {
            rows.scale.encode(simd, between(simd, &sums[row..row + 2], per_rows[row])).store(&mut cell.0);
        }

        for (index, cell) in sky.iter_mut().enumerate() {
            let row = first_sky + index;
            let per_row = per_rows[row];
            let mut seen = between(simd, &sums[row..row + 2], per_row);
            let tangent = simd.splat(centres[row]);
            let sine = tangent * tangent.mul_add(tangent, squares).rsqrt();

            // What is left of the row above the surface.
            let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
            let top = simd.splat(edges[row + 1]);
            let share = ((top - covered) * simd.splat(per_row)).max(zero).min(one);
            let sky = air.sky::<V, FOG_OR_GLOW>(simd, sine);
            for (channel, seen) in seen.iter_mut().enumerate() {
                *seen = sky[channel].mul_add(share, *seen);
            }

            rows.scale.encode(simd, seen).store(&mut cell.0);
            if let Some(inverse) = rows.inverse.get_mut(row) {
                zero.store_masked(covered.lt(top) & covered.le(tangent), &mut inverse.0);
            }
        }
    }
}

/// Light of the row between two edges.
#[inline(always)]
fn between<V: Simd>(simd: V, edges: &[PlaneLight], per_row: f32) -> [V::F; 3] {
    let mut light = [simd.splat(0.0); 3];
    for (channel, light) in light.iter_mut().enumerate() {
        let (low, high) = (simd.load(&edges[0][channel].0), simd.load(&edges[1][channel].0));
        *light = (high - low) * simd.splat(per_row);
    }
    light
}
