//! Rows of a group of planes: light by the share of a row that each stretch of surface covers.
//!
//! ```text
//! for each chunk of segments, nearest first:
//!     light of its segments                                              paint
//!     for each stretch that is in sight:
//!         for each edge between rows that it covers:
//!             light of the row below, from where it was covered so far  →  sums[edge]
//!     for each row that all planes cover:
//!         sums[upper edge] / height  →  row's light
//! what is left above → sky
//! ```
//!
//! Near the eye a row's light is multiplied by what lies below the voxel: between the two edges, where the surface is told at each.
//!
//! A chunk's light, and the sums of rows that are not yet closed, are few: they stay in the nearest cache.
//!
//! Rows are boxes, not points: a ridge that covers a third of a row gives it a third of its light, and what is narrower
//! than a row still counts. On a stretch light is linear in the tangent, so that its mean over a part of a row is that in the part's middle. A row's light depends
//! on nothing below the row: views that have it in common agree to the bit.
//!
//! Tried without gain: sums that each part of a row is added to, without masks (half of the operations; light +8 to +15 %, it was not found why);
//! light as a square of the tangent, as it is on a straight stretch seen from near (no decibel, what is missing is what lies between lines).

use std::ops::Range;

use super::cell::{Cell, Scale};
use super::edge_marks::{EdgeMark, EdgeMarks, MarkedStretch};
use super::row_detail::{DetailedRow, RowDetail};
use super::segment_light::{COLOURS, ChunkDetail, PlaneLight};
use super::sky::SkyRows;
use crate::raymarch::scan::{NO_SLOPE, Profile, RowTable, VisibleSegment};
use crate::simd::{Each, Floats, Ints, Isa, Kernel, LANES, Mask, Simd, Sixteen};
use crate::weather::AtmosphereLanes;
use hedgehop_base::error::Result;

/// Least rise of a stretch, as tangent: keeps quotients finite.
const LEAST_RISE: f32 = 1.0e-20;

/// Segments of a chunk.
pub const CHUNK: usize = LANES;

/// Light of the row below an edge times its height, by channel.
type EdgeSum = [Sixteen; COLOURS];

/// Air that planes look through.
#[derive(Clone, Copy)]
pub struct PlaneAir<'f> {
    /// Haze and sky.
    pub air: &'f AtmosphereLanes,
    /// 1 + a² of each plane.
    pub squares: &'f [f32; LANES],
}

/// Finds the light that a profile's segments send to the eye.
pub trait SegmentLights {
    /// Begins with the first of `segments`.
    ///
    /// # Errors
    /// A page that is damaged.
    fn begin<'f, V: Simd, const FOG_OR_GLOW: bool>(
        self,
        simd: V,
        segments: &[VisibleSegment],
        plane_air: PlaneAir<'f>,
    ) -> Result<impl ChunkLights>;
}

/// Finds the light of one chunk of segments after the other.
pub trait ChunkLights {
    /// Puts that of the next `chunk` into `lights`, which are as many; `later` are the segments behind it. Returns what detail they have.
    ///
    /// # Errors
    /// A page that is damaged.
    fn next(
        &mut self,
        chunk: &[VisibleSegment],
        later: &[VisibleSegment],
        lights: &mut [PlaneLight],
    ) -> Result<ChunkDetail>;
}

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
    /// Detail below the voxel; `None`: there is none.
    pub detail: Option<RowDetail<'r>>,
}

/// Memory for what is known at edges between rows, used again for every group.
#[derive(Debug, Default)]
pub struct EdgeSums {
    sums: Vec<EdgeSum>,
    /// As many, where detail is asked for.
    marks: Vec<EdgeMark>,
}

#[cfg(test)]
impl EdgeSums {
    /// Memory in which something is.
    pub fn of(value: Sixteen, count: usize) -> Self {
        let mark = EdgeMark { ground: value, wall: value, inverse: value };
        Self { sums: vec![[value; COLOURS]; count], marks: vec![mark; count] }
    }
}

impl RowFill<'_> {
    /// Fills rows with what a profile of `lights` and the sky behind it send.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn fill(
        self,
        isa: Isa,
        profile: &Profile,
        lights: impl SegmentLights,
        plane_air: PlaneAir<'_>,
        sums: &mut EdgeSums,
    ) -> Result<()> {
        let (EdgeSums { sums, marks }, count) = (sums, self.cells.len() + 1);
        sums.resize(count, EdgeSum::default());
        if self.detail.is_some() {
            marks.resize(count, EdgeMark::default());
        }
        let marks = EdgeMarks::new(marks);
        if plane_air.air.has_fog_or_glow() {
            isa.run(RowFilling::<_, true> { rows: self, profile, lights, plane_air, sums, marks })
        } else {
            isa.run(RowFilling::<_, false> { rows: self, profile, lights, plane_air, sums, marks })
        }
    }

    /// Picks these rows' own edges of those that are counted from the plane image's lowest, and counts them from theirs.
    #[inline(always)]
    fn own(&self, edges: Range<usize>) -> Range<usize> {
        let own = |edge: usize| edge.saturating_sub(self.first).min(self.cells.len() + 1);
        own(edges.start)..own(edges.end)
    }
}

struct RowFilling<'f, 'r, L, const FOG_OR_GLOW: bool> {
    rows: RowFill<'r>,
    profile: &'f Profile,
    lights: L,
    plane_air: PlaneAir<'f>,
    sums: &'f mut [EdgeSum],
    marks: EdgeMarks<'f>,
}

impl<L: SegmentLights, const FOG_OR_GLOW: bool> Kernel for RowFilling<'_, '_, L, FOG_OR_GLOW> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Result<()> {
        let Self { rows, profile, lights: source, plane_air, sums, marks } = self;
        let edges = &rows.row_table.edges[rows.first..=rows.first + rows.cells.len()];
        // The lowest edge is covered, too, so that detail has a begin there.
        let mut covering = Covering {
            simd,
            covered: simd.splat(edges[0].next_down()),
            light: [simd.splat(0.0); COLOURS],
            squares: simd.load(plane_air.squares),
            edges,
            sums,
            marks,
            rows,
            closed: 0,
        };
        let segments = profile.segments();
        let mut source = source.begin::<V, FOG_OR_GLOW>(simd, segments, plane_air)?;
        // Before the lights of a chunk stands that of the segment before it.
        let mut lights = [PlaneLight::default(); CHUNK + 1];
        for first in (0..segments.len()).step_by(CHUNK) {
            let (chunk, later) = segments[first..].split_at(CHUNK.min(segments.len() - first));
            lights[0] = lights[CHUNK];
            let detail = source.next(chunk, later, &mut lights[1..=chunk.len()])?;
            let taken = &segments[first.saturating_sub(1)..first + chunk.len()];
            let lights = &lights[usize::from(first == 0)..];
            match detail {
                ChunkDetail::None => covering.take::<false>(taken, lights, detail),
                _ => covering.take::<true>(taken, lights, detail),
            }
            covering.close_rows();
        }

        covering.finish::<FOG_OR_GLOW>(plane_air);
        Ok(())
    }
}

/// Stretches of a chunk that are in sight, and which edges they may cover.
#[derive(Default)]
struct Stretches {
    /// The segments before those that they end in.
    segments: [usize; CHUNK],
    count: usize,
    /// Cells of the row table, first and last.
    cells: [[i32; LANES]; 2],
}

impl Stretches {
    /// Finds the stretches between neighbours of at most [`CHUNK`] + 1 segments.
    #[inline(always)]
    fn find<V: Simd>(simd: V, covering: &Covering<'_, V>, segments: &[VisibleSegment]) -> Self {
        let mut stretches = Self::default();
        let mut covered = covering.covered;
        let [lowest, highest] = [-NO_SLOPE, NO_SLOPE].each(|slope| simd.splat(slope));
        let mut ends = [[0.0; LANES]; 2];

        for (before, segment) in segments[1..].iter().enumerate() {
            let high = simd.load(&segment.slope.0);
            let rises = covered.lt(high);
            if !segment.line.begins && rises.any() {
                ends[0][stretches.count] = covered.select(rises, lowest).least();
                ends[1][stretches.count] = high.select(rises, highest).greatest();
                stretches.segments[stretches.count] = before;
                stretches.count += 1;
                covered = covered.max(high);
            }
        }

        let [low, high] = ends.each(|ends| simd.load(&ends));
        let cells = covering.rows.row_table.cells(simd, low, high);
        for (end, target) in stretches.cells.iter_mut().enumerate() {
            cells[end].store(target);
        }
        stretches
    }
}

/// The surface from one segment to the next.
struct RowStretch<'s, V: Simd> {
    slopes: [V::F; 2],
    inverse: [&'s Sixteen; 2],
    lights: &'s [PlaneLight; 2],
}

/// Planes on their way up the rows.
struct Covering<'r, V: Simd> {
    simd: V,
    rows: RowFill<'r>,
    /// Edges of these rows.
    edges: &'r [f32],
    /// 1 + a² of each plane.
    squares: V::F,
    sums: &'r mut [EdgeSum],
    marks: EdgeMarks<'r>,
    /// Tangent up to which each plane is covered, and light from the edge below up to there: light times tangent.
    covered: V::F,
    light: [V::F; COLOURS],
    /// Rows, from the lowest, that are finished.
    closed: usize,
}

impl<V: Simd> Covering<'_, V> {
    /// Takes in the stretches between neighbours of some segments, and their lights.
    #[inline(always)]
    fn take<const DETAIL: bool>(
        &mut self,
        segments: &[VisibleSegment],
        lights: &[PlaneLight],
        detail: ChunkDetail,
    ) {
        let simd = self.simd;
        // Where loops end is known long before they are run: they need not wait for each other.
        let stretches = Stretches::find(simd, self, segments);
        for (index, &before) in stretches.segments[..stretches.count].iter().enumerate() {
            let (Some([near, far]), Some(lights)) =
                (segments[before..].first_chunk(), lights[before..].first_chunk())
            else {
                continue;
            };
            let stretch = RowStretch {
                slopes: [simd.load(&near.slope.0), simd.load(&far.slope.0)],
                inverse: [&near.inverse, &far.inverse],
                lights,
            };
            let edges = self.rows.row_table.between(stretches.cells[0][index], stretches.cells[1][index]);
            self.cover::<DETAIL>(&stretch, detail, self.rows.own(edges));
        }
    }

    /// Takes in a stretch, which covers no other edges than those of `span`.
    #[inline(always)]
    fn cover<const DETAIL: bool>(
        &mut self,
        stretch: &RowStretch<'_, V>,
        detail: ChunkDetail,
        span: Range<usize>,
    ) {
        let simd = self.simd;
        let [low, high] = stretch.slopes;
        let rises = self.covered.lt(high);
        let per_rise = (high - low).max(simd.splat(LEAST_RISE)).recip();
        if !self.rows.inverse.is_empty() {
            self.measure(stretch, rises, per_rise, span.clone());
        }

        // Half the change of light per unit of tangent: the far end is where walls, which begin at no finite tangent, have theirs.
        let half_per_rise = per_rise * simd.splat(0.5);
        let (mut tops, mut half_changes) = (self.light, self.light);
        for channel in 0..COLOURS {
            tops[channel] = simd.load(&stretch.lights[1][channel].0);
            let change = tops[channel] - simd.load(&stretch.lights[0][channel].0);
            half_changes[channel] = change * half_per_rise;
        }
        if DETAIL {
            let edges = self.edges.get(span.clone()).unwrap_or_default();
            let RowStretch { lights, inverse, .. } = *stretch;
            let (covered, span) = (self.covered, span.clone());
            let marked =
                MarkedStretch { edges, span, rises, covered, high, per_rise, lights, inverse, detail };
            self.marks.mark(simd, &marked);
        }

        // Twice the way down from the top of the stretch to the middle of what lies between two tangents is their sum less twice the top's.
        let twice_top = high + high;
        let zero = simd.splat(0.0);
        // In registers: what is stored to in some lanes would be waited for.
        let (mut from, mut light) = (self.covered, self.light);
        let passable = high.select(rises, simd.splat(NO_SLOPE));
        let edges = self.edges.get(span.clone()).unwrap_or_default();
        let sums = self.sums.get_mut(span).unwrap_or_default();
        for (edge, sums) in edges.iter().zip(sums) {
            let edge = simd.splat(*edge);
            let passed = edge.le(passable) & from.lt(edge);
            let (rise, middle) = (edge - from, edge + from - twice_top);
            for channel in 0..COLOURS {
                let mean = half_changes[channel].mul_add(middle, tops[channel]);
                mean.mul_add(rise, light[channel]).store_masked(passed, &mut sums[channel].0);
                light[channel] = zero.select(passed, light[channel]);
            }
            from = edge.select(passed, from);
        }

        let (rise, middle) = (high - from, high + from - twice_top);
        for channel in 0..COLOURS {
            let mean = half_changes[channel].mul_add(middle, tops[channel]);
            light[channel] = mean.mul_add(rise, light[channel]).select(rises, light[channel]);
        }

        self.light = light;
        self.covered = self.covered.max(passable);
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

    /// Leaves light that came so far to the row below an edge, in some planes.
    #[inline(always)]
    fn close(&mut self, planes: V::M, index: usize) {
        let zero = self.simd.splat(0.0);
        for (channel, sum) in self.sums[index].iter_mut().enumerate() {
            self.light[channel].store_masked(planes, &mut sum.0);
            self.light[channel] = zero.select(planes, self.light[channel]);
        }
    }

    /// Takes light from edges to rows that all planes cover.
    #[inline(always)]
    fn close_rows(&mut self) {
        let least = self.covered.least();
        let per_rows = &self.rows.row_table.per_row[self.rows.first..];
        while self.closed < self.rows.cells.len() && self.edges[self.closed + 1] <= least {
            let (row, per_row) = (self.closed, per_rows[self.closed]);
            let mut light = mean(self.simd, &self.sums[row + 1], per_row);
            self.add_detail(row, &mut light);
            self.rows.scale.encode(self.simd, light, &mut self.rows.cells[row]);
            self.closed += 1;
        }
    }

    /// Multiplies the light of a row by what lies below the voxel, between where the surface is on its edges.
    #[inline(always)]
    fn add_detail(&self, row: usize, light: &mut [V::F; COLOURS]) {
        let simd = self.simd;
        let Some(detail) = &self.rows.detail else { return };
        let Some(marks) = self.marks.row(simd, row) else { return };
        let tangent = self.rows.row_table.centres[self.rows.first + row];
        let row = DetailedRow {
            slant_squared: self.squares + simd.splat(tangent * tangent),
            tangent,
            height: self.edges[row + 1] - self.edges[row],
            marks,
        };
        if let Some(factor) = detail.factor(simd, &row) {
            for light in light {
                *light = *light * factor;
            }
        }
    }

    /// Leaves what is above to the sky.
    #[inline(always)]
    fn finish<const FOG_OR_GLOW: bool>(mut self, plane_air: PlaneAir<'_>) {
        let simd = self.simd;
        self.close_rows();
        let open = self.closed + 1;
        // Above this edge there is nothing but sky.
        let greatest = self.covered.greatest();
        let clear = self.edges.partition_point(|&edge| edge < greatest).max(open);
        for index in open..self.edges.len().min(clear + 1) {
            let planes = self.covered.lt(simd.splat(self.edges[index]));
            self.close(planes, index);
        }

        let Self { rows, sums, covered, edges, closed, .. } = self;
        let row_table = rows.row_table;
        let (per_rows, centres) = (&row_table.per_row[rows.first..], &row_table.centres[rows.first..]);
        let squares = simd.load(plane_air.squares);
        let is_exact = !row_table.coordinate.is_projective();
        let sky = SkyRows { simd, is_exact, air: plane_air.air, squares, centres, scale: rows.scale };
        let zero = simd.splat(0.0);
        let end = clear.min(rows.cells.len());

        for row in closed..end {
            // Share of the row that the surface leaves to the sky.
            let (top, per_row) = (simd.splat(edges[row + 1]), per_rows[row]);
            let share = ((top - covered) * simd.splat(per_row)).max(zero).min(simd.splat(1.0));
            let surface = mean(simd, &sums[row + 1], per_row);
            let mut seen = sky.light::<FOG_OR_GLOW>(row);
            for (channel, seen) in seen.iter_mut().enumerate() {
                *seen = seen.mul_add(share, surface[channel]);
            }
            rows.scale.encode(simd, seen, &mut rows.cells[row]);
            if let Some(inverse) = rows.inverse.get_mut(row) {
                let is_sky = covered.lt(top) & covered.le(simd.splat(centres[row]));
                zero.store_masked(is_sky, &mut inverse.0);
            }
        }

        let first = end.max(closed);
        sky.fill::<FOG_OR_GLOW>(rows.cells, first);
        if let Some(inverse) = rows.inverse.get_mut(first..) {
            inverse.fill(Sixteen::default());
        }
    }
}

/// Light of a row, of which the sum and one by the height are given.
#[inline(always)]
fn mean<V: Simd>(simd: V, sum: &EdgeSum, per_row: f32) -> [V::F; 3] {
    let mut light = [simd.splat(0.0); 3];
    for (channel, light) in light.iter_mut().enumerate() {
        *light = simd.load(&sum[channel].0) * simd.splat(per_row);
    }
    light
}
