//! Exact intersection of a ray with spans on bare ground, voxel by voxel.
//!
//! ```text
//! for each size of cells that what stands is seen in, as far as bare ground is; near by they are voxels:
//! walk groups of 4 × 4 blocks along the ray; in them blocks of 8 × 8 voxels, in these voxels:
//!     the ray stays above all that stands there → the next one
//!     for each span of the voxel:
//!         stretch = the ray in the voxel ∩ inside of the wall ∩ below the upper end ∩ above the lower end
//!         it is not empty → a hit: on the face that bounds the stretch's beginning
//!     sort the voxel's hits by range; what is left behind them: 1 − opacity each, until nothing is
//! ```
//!
//! All bounds are planes, and a ray is straight within a voxel (over curved ground it rises by less than 10⁻⁸ m on the way through one), so
//! that a stretch is an intersection of half-lines. Semitransparent matter fills its voxel, or its strip, evenly: what a ray loses in it follows
//! from the length of its way (Lambert's law), so that pictures do not depend on how the grid lies.

use glam::{DVec2, DVec3};

use super::blocks::{BlockPlace, OwnBlocks, corner_on_page};
use super::{CellRect, CellStep, CellWalk, GridRay, Lattice, PageCursor, SpanBand};
use crate::voxel::{BLOCK_SIDE, BlockSpans, Cut, HeightCode, Span};
use hedgehop_base::error::Result;

/// Blocks along the side of those that are passed at once.
const GROUP: u32 = 4;

/// Distance of walls and upper ends of neighbours that are taken for one, for being stored in steps, sides of a voxel: what shows in between is
/// lit as they are.
const SEAM: f64 = Cut::BESIDE;

/// Face at which a stretch of a ray enters a span.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Face {
    /// Upper end of the span.
    Top,
    /// Wall of the span, or a side of its voxel.
    Side,
    /// Lower end of the span.
    Bottom,
}

/// A stretch of a ray within a span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidHit {
    /// Range where it begins, metres, ≥ 0.
    pub range: f64,
    /// Range where it ends, metres.
    pub end: f64,
    /// Share of the light from behind that it hides, 0…1.
    pub opacity: f64,
    /// Through which face it comes.
    pub face: Face,
    /// Unit normal of that.
    pub normal: DVec3,
    /// The span.
    pub span: Span,
    /// Place where it begins, metres in the database's system, and above the datum; within the area, if that goes on without end.
    pub place: DVec3,
}

/// Follows rays through what stands in one database.
pub struct Solids<'a> {
    /// Of voxels.
    measure: Measure,
    /// Sizes of cells by distance; none: voxels everywhere.
    bands: Vec<SpanBand>,
    blocks: OwnBlocks<'a>,
}

/// Metric values of the places and heights of spans.
#[derive(Debug, Clone, Copy)]
struct Measure {
    /// log₂ of voxels of level index 0 along a cell, which is the voxel here.
    shift: u8,
    /// The cells.
    lattice: Lattice,
    code: HeightCode,
    /// Side of a cell, metres.
    spacing: f64,
    /// South-west corner of the area, metres.
    origin: DVec2,
}

impl<'a> Solids<'a> {
    /// Solids of `source`, in the area as `cursor` has it: once, or repeated.
    pub fn new(cursor: &PageCursor<'a>) -> Self {
        let source = cursor.source();
        let header = source.header();
        let (code, spacing, origin) = (header.heights, header.grid.spacing, header.grid.origin);
        let measure = Measure { shift: 0, lattice: cursor.voxels(0), code, spacing, origin };
        Self { measure, bands: Vec::new(), blocks: OwnBlocks::new(source, Box::default()) }
    }

    /// The same in coarser cells where `bands` say so.
    pub fn in_bands(self, bands: &[SpanBand]) -> Self {
        Self { bands: bands.to_vec(), ..self }
    }

    /// The same in the area as another cursor has it.
    pub fn on(self, cursor: &PageCursor<'a>) -> Self {
        Self { bands: self.bands, ..Self::new(cursor) }
    }

    /// Returns the blocks that are kept.
    pub(super) fn blocks(&mut self) -> &mut OwnBlocks<'a> {
        &mut self.blocks
    }

    /// Appends what a ray meets between two ranges (metres), nearest first, until no more than `least` of the light behind is left. Returns that
    /// share; before them it is `left`.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn along(
        &mut self,
        ray: &GridRay,
        [start, end]: [f64; 2],
        [mut left, least]: [f64; 2],
        hits: &mut Vec<SolidHit>,
    ) -> Result<f64> {
        let whole = [SpanBand { shift: 0, start: 0.0, end: f64::INFINITY }];
        let count = self.bands.len().max(1);
        for index in 0..count {
            let band = self.bands.get(index).unwrap_or(&whole[0]);
            let measure = self.measure.of_cells(band.shift);
            let from = if index == 0 { start } else { start.max(band.start / ray.ground_cosine) };
            let until = if index + 1 == count { end } else { end.min(band.end / ray.ground_cosine) };
            if from < until && left > least {
                left = self.along_cells(&measure, ray, [from, until], [left, least], hits)?;
            }
        }
        Ok(left)
    }

    /// [`Self::along`], in cells of one size.
    fn along_cells(
        &mut self,
        measure: &Measure,
        ray: &GridRay,
        [start, end]: [f64; 2],
        [mut left, least]: [f64; 2],
        hits: &mut Vec<SolidHit>,
    ) -> Result<f64> {
        let blocks = measure.lattice.grouped(BLOCK_SIDE);
        let groups = blocks.grouped(GROUP);
        // A short way is through a group or two.
        if (end - start) * ray.slope.truncate().length() <= groups.side {
            return self.through(measure, ray, CellWalk::new(ray, blocks, start, end), [left, least], hits);
        }

        for group in CellWalk::new(ray, groups, start, end) {
            let place =
                BlockPlace { at: group.cell.map(|cell| cell * i64::from(GROUP)), shift: measure.shift };
            let (_, view) = self.blocks.page(place.first())?;
            let [x, y] = corner_on_page(place.first());
            let [_, high] = view.reach(x, y, GROUP * place.count());
            if measure.is_clear(ray, &group, high.into()) {
                continue;
            }
            let inside = CellWalk::new(ray, blocks.inside(&group, GROUP), group.enter, group.leave);
            left = self.through(measure, ray, inside, [left, least], hits)?;
            if left <= least {
                break;
            }
        }

        Ok(left)
    }

    /// [`Self::along`], of the blocks of a walk.
    fn through(
        &mut self,
        measure: &Measure,
        ray: &GridRay,
        walk: CellWalk,
        [mut left, least]: [f64; 2],
        hits: &mut Vec<SolidHit>,
    ) -> Result<f64> {
        for block in walk {
            let place = BlockPlace { at: block.cell, shift: measure.shift };
            let (_, view) = self.blocks.page(place.first())?;
            let [x, y] = corner_on_page(place.first());
            let [_, high] = view.reach(x, y, place.count());
            if measure.is_clear(ray, &block, high.into()) {
                continue;
            }
            let stands = self.blocks.get(place, &view);
            left = measure.cross(ray, &block, stands, [left, least], hits);
            if left <= least {
                break;
            }
        }
        Ok(left)
    }

    /// Returns the height of the highest span at a place in the area (units) that hides at least a share `dense` of the light through a voxel's side, metres above the
    /// datum; `None`: no such thing stands there.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn highest_at(&mut self, units: DVec2, dense: f32) -> Result<Option<f64>> {
        let Measure { lattice, spacing, .. } = self.measure;
        let (cell, within) = lattice.cell_at(units);
        let block = cell.map(|cell| cell / i64::from(BLOCK_SIDE));
        let (_, view) = self.blocks.page(block)?;
        let [x, y] = cell.map(|cell| (cell % i64::from(BLOCK_SIDE)) as u32);
        let at = within - 0.5;
        let measure = self.measure;

        let holds = |span: &&Span| {
            let half = 0.5 * (measure.height(span.high) - measure.height(span.low)) / spacing;
            span.opacity() >= dense
                && span.walls().enumerate().all(|(index, (normal, distance))| {
                    let beyond = DVec2::from(normal.map(f64::from)).dot(at) - f64::from(distance);
                    if index == 0 && span.is(Span::STRIP) { beyond.abs() <= half } else { beyond <= 0.0 }
                })
        };

        let top = |span: &Span| {
            measure.height(span.high) + DVec2::from(span.slopes().map(f64::from)).dot(at) * spacing
        };
        let spans = self.blocks.get(BlockPlace::of_voxels(block), &view).of(x, y);

        Ok(spans.iter().filter(holds).map(top).reduce(f64::max))
    }

    /// Appends and returns what [`Self::along`] does, voxel by voxel: what passing many at once is held against.
    pub fn along_each_voxel(
        &mut self,
        ray: &GridRay,
        [start, end]: [f64; 2],
        least: f64,
        hits: &mut Vec<SolidHit>,
    ) -> Result<f64> {
        let mut left = 1.0;
        for step in CellWalk::new(ray, self.measure.lattice, start, end) {
            let block = step.cell.map(|cell| cell / i64::from(BLOCK_SIDE));
            let (_, view) = self.blocks.page(block)?;
            let [x, y] = step.cell.map(|cell| (cell % i64::from(BLOCK_SIDE)) as u32);
            let spans = self.blocks.get(BlockPlace::of_voxels(block), &view).of(x, y);
            left = self.measure.meet(ray, &step, spans, [left, least], hits);
            if left <= least {
                break;
            }
        }
        Ok(left)
    }
}

impl Measure {
    /// The same of cells of `1 << shift` voxels to a side.
    fn of_cells(self, shift: u8) -> Self {
        let side = 1 << shift;
        Self { shift, lattice: self.lattice.grouped(side), spacing: self.spacing * f64::from(side), ..self }
    }

    /// Whether a ray stays above all that stands on a step's cell, of which nothing rises above this height code; 0: nothing stands there.
    fn is_clear(&self, ray: &GridRay, step: &CellStep, top: f32) -> bool {
        let height = self.code.offset + self.code.scale * f64::from(top);
        top == 0.0 || ray.lowest_between(step.enter, step.leave) > height
    }

    /// [`Self::meet`], of the voxels of a block that a ray crosses.
    fn cross(
        &self,
        ray: &GridRay,
        block: &CellStep,
        stands: &BlockSpans,
        [mut left, least]: [f64; 2],
        hits: &mut Vec<SolidHit>,
    ) -> f64 {
        let voxels = self.lattice.inside(block, BLOCK_SIDE);
        for step in CellWalk::new(ray, voxels, block.enter, block.leave) {
            let [x, y] = step.cell.map(|cell| (cell % i64::from(BLOCK_SIDE)) as u32);
            let voxel = (y * BLOCK_SIDE + x) as usize;
            if self.is_clear(ray, &step, stands.tops()[voxel]) {
                continue;
            }
            left = self.meet(ray, &step, stands.at(voxel), [left, least], hits);
            if left <= least {
                break;
            }
        }
        left
    }

    /// Appends what a ray meets of a voxel's spans, nearest first, until no more than `least` of the light behind is left. Returns that share; before the voxel
    /// it is `left`.
    fn meet(
        &self,
        ray: &GridRay,
        step: &CellStep,
        spans: &[Span],
        [mut left, least]: [f64; 2],
        hits: &mut Vec<SolidHit>,
    ) -> f64 {
        let before = hits.len();
        let passage = self.passage(ray, step);
        hits.extend(spans.iter().filter_map(|span| self.hit(ray, &passage, span)));
        hits[before..].sort_by(|a, b| a.range.total_cmp(&b.range));
        for index in before..hits.len() {
            left *= 1.0 - hits[index].opacity;
            if left <= least {
                hits.truncate(index + 1);
                break;
            }
        }
        left
    }

    /// Place of a ray at a range, east and north of a voxel's centre in units, sides of the voxel.
    fn about_centre(&self, ray: &GridRay, centre: DVec2, range: f64) -> DVec2 {
        (ray.at(range).truncate() - centre) / f64::from(1_u32 << self.shift)
    }

    /// A ray's way through the voxel of a step.
    fn passage(&self, ray: &GridRay, step: &CellStep) -> Passage {
        let CellRect { corner, extent } = self.lattice.place(step);
        let centre = corner + 0.5 * extent;
        let ranges = [step.enter, step.leave];
        let (at, heights) = (
            ranges.map(|range| self.about_centre(ray, centre, range)),
            ranges.map(|range| ray.height_at(range)),
        );
        // The side of the voxel through which the ray came is the one that it is nearest to.
        let is_east_west = at[0].x.abs() >= at[0].y.abs();
        let side = if is_east_west {
            DVec3::new(-ray.slope.x.signum(), 0.0, 0.0)
        } else {
            DVec3::new(0.0, -ray.slope.y.signum(), 0.0)
        };
        let cell = DVec2::from(step.cell.map(|cell| cell as f64 + 0.5));
        let within = self.origin + cell * self.spacing;
        Passage { ranges, at, heights, centre, within, side }
    }

    /// Height of a code, metres above the datum.
    #[inline]
    fn height(&self, code: u16) -> f64 {
        self.code.offset + self.code.scale * f64::from(code)
    }

    /// Intersects a ray with a span on its way through a voxel.
    fn hit(&self, ray: &GridRay, passage: &Passage, span: &Span) -> Option<SolidHit> {
        let (high, low) = (self.height(span.high), self.height(span.low));
        // Most spans of a wood are passed above or below.
        let (is_level, hangs) = (span.slope == [0, 0], span.low != Span::GROUND);
        let is_under = |end: f64| passage.heights.iter().all(|height| *height < end);
        let is_over = |end: f64| passage.heights.iter().all(|height| *height > end);
        if (is_level && is_over(high)) || (hangs && (is_level || !span.is(Span::PARALLEL)) && is_under(low)) {
            return None;
        }

        let mut stretch = RayStretch::new(passage, high);
        let wall = |index: usize| {
            let cut = span.cuts[index];
            cut.is_wall()
                .then(|| (index, DVec2::from(cut.normal().map(f64::from)), f64::from(cut.distance())))
        };
        let walls = [wall(0), wall(1), wall(2)];

        // The last wall that the ray came through.
        let mut through = None;
        for (index, normal, distance) in walls.into_iter().flatten() {
            let beyond = |at: DVec2| normal.dot(at) - distance;
            let before = stretch.enter;
            if index == 0 && span.is(Span::STRIP) {
                let half = 0.5 * (high - low) / self.spacing;
                stretch.cut(|at, _| beyond(at) - half, Face::Side, normal.extend(0.0));
                stretch.cut(|at, _| -beyond(at) - half, Face::Side, -normal.extend(0.0));
            } else {
                stretch.cut(|at, _| beyond(at), Face::Side, normal.extend(0.0));
            }

            if stretch.enter > before {
                through = Some((index, stretch.enter));
            }
        }

        let slope = DVec2::from(span.slopes().map(f64::from));
        let rise = |at: DVec2| slope.dot(at) * self.spacing;
        stretch.cut(|at, above| above - rise(at), Face::Top, (-slope).extend(1.0).normalize());
        if hangs {
            let down = low - high;
            if span.is(Span::PARALLEL) {
                stretch.cut(
                    |at, above| down + rise(at) - above,
                    Face::Bottom,
                    slope.extend(-1.0).normalize(),
                );
            } else {
                stretch.cut(|_, above| down - above, Face::Bottom, DVec3::NEG_Z);
            }
        }

        let RayStretch { enter, leave, mut face, mut normal, .. } = stretch;
        if enter >= leave {
            return None;
        }

        // Through a side of the voxel, or where it meets another part of the same thing.
        let is_side = enter == passage.ranges[0];
        let is_joint = through.is_some_and(|(index, at)| at == enter && span.is_joined(index));
        if is_side || is_joint {
            let (at, above) = (self.about_centre(ray, passage.centre, enter), ray.height_at(enter) - high);
            let before = |(_, normal, distance): &(usize, DVec2, f64)| distance - normal.dot(at);
            let nearest = walls.iter().flatten().min_by(|a, b| before(a).total_cmp(&before(b)));
            if is_side && span.cuts[0].is_round() {
                normal = DVec2::from(span.cuts[0].normal().map(f64::from)).extend(0.0);
            } else if is_side
                && let Some(wall) = nearest
                && before(wall) < SEAM
            {
                normal = wall.1.extend(0.0);
            }

            if rise(at) - above < SEAM * self.spacing {
                (face, normal) = (Face::Top, (-slope).extend(1.0).normalize());
            }
        }

        // An eye within a span sees it as if it were all side.
        if enter == 0.0 {
            let direction = ray.slope * DVec3::new(self.spacing, self.spacing, 1.0);
            (face, normal) = (Face::Side, -direction);
        }

        let opacity = f64::from(span.opacity());
        // A thin wire is stored as a strip that hides less: by its own width, or next to nothing would be left of it.
        let unit = match span.is(Span::STRIP) {
            true => f64::from(span.thickness()) * self.code.scale,
            false => self.spacing,
        };
        let way = (leave - enter) / unit;
        let opacity = if opacity < 1.0 { 1.0 - (1.0 - opacity).powf(way) } else { 1.0 };

        let place = passage.within + self.about_centre(ray, passage.centre, enter) * self.spacing;
        let place = place.extend(ray.height_at(enter));
        Some(SolidHit { range: enter, end: leave, opacity, face, normal, span: *span, place })
    }
}

/// A ray's way through a voxel.
struct Passage {
    /// Ranges of its ends, metres.
    ranges: [f64; 2],
    /// Places of these ends, east and north of the voxel's centre, sides of the voxel.
    at: [DVec2; 2],
    /// Heights of these ends, metres above the datum.
    heights: [f64; 2],
    /// The voxel's centre, units.
    centre: DVec2,
    /// The voxel's centre in the area, metres in the database's system.
    within: DVec2,
    /// Normal of the side through which the ray comes.
    side: DVec3,
}

/// Stretch of a ray's way through a voxel that is left.
struct RayStretch {
    enter: f64,
    leave: f64,
    /// Ray at the stretch's ends: east and north of the voxel's centre, and above a span's upper end.
    ends: [(DVec2, f64); 2],
    /// Ranges there, metres.
    ranges: [f64; 2],
    face: Face,
    normal: DVec3,
}

impl RayStretch {
    /// All of it, for a span whose upper end is so high over the centre, metres above the datum.
    fn new(passage: &Passage, high: f64) -> Self {
        let Passage { ranges, at, heights, side, .. } = passage;
        let ends = [(at[0], heights[0] - high), (at[1], heights[1] - high)];
        let [enter, leave] = *ranges;
        Self { enter, leave, ends, ranges: *ranges, face: Face::Side, normal: *side }
    }

    /// Leaves what is not beyond a plane: where `beyond`, which is linear along the ray, is not positive.
    fn cut(&mut self, beyond: impl Fn(DVec2, f64) -> f64, face: Face, normal: DVec3) {
        let [first, last] = self.ends.map(|(at, above)| beyond(at, above));
        if first <= 0.0 && last <= 0.0 {
            return;
        }
        if first > 0.0 && last > 0.0 {
            self.leave = f64::NEG_INFINITY;
            return;
        }
        let crossing = self.ranges[0] + (self.ranges[1] - self.ranges[0]) * (first / (first - last));
        if first <= 0.0 {
            self.leave = self.leave.min(crossing);
        } else if crossing > self.enter {
            (self.enter, self.face, self.normal) = (crossing, face, normal);
        }
    }
}
