//! What a ray meets that stands on bare ground: spans, voxel by voxel, exactly.
//!
//! ```text
//! walk the voxels of level 1 along the ray, as far as bare ground is seen:
//!     for each span of the voxel:
//!         stretch = the ray in the voxel ∩ inside of the wall ∩ below the upper end ∩ above the lower end
//!         it is not empty → a hit: on the face that bounds the stretch's beginning
//! sort the voxel's hits by range; what is left behind them: 1 − opacity each, until nothing is
//! ```
//!
//! All bounds are planes, and a ray is straight within a voxel (over curved ground it rises by less than 10⁻⁸ m on the way through one), so
//! that a stretch is an intersection of half-lines. Semitransparent matter fills its voxel, or its strip, evenly: what a ray loses in it follows
//! from the length of its way (Lambert's law), so that pictures do not depend on how the grid lies.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DVec2, DVec3};

use super::{CellStep, CellWalk, GridRay, Lattice, PageCursor};
use crate::error::Result;
use crate::voxel::{
    BARE, BLOCK_SIDE, BlockSpans, Cut, HeightCode, PAGE_SIDE, PageId, PageSource, SharedObjects, Span,
    SpanTable, SpansView,
};

/// Blocks whose spans are kept; more begin anew.
const BLOCKS: usize = 8192;

/// Share of light behind solids that counts as none.
const NOTHING_LEFT: f64 = 1.0 / 512.0;

/// How far walls and upper ends of neighbours that are one may be apart, for being stored in steps, sides of a voxel: what shows in between is
/// lit as they are.
const SEAM: f64 = Cut::BESIDE;

/// Where a stretch of a ray enters a span.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Face {
    /// Its upper end.
    Top,
    /// Its wall, or a side of its voxel.
    Side,
    /// Its lower end.
    Bottom,
}

/// A stretch of a ray within a span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidHit {
    /// Range where it begins, metres, ≥ 0.
    pub range: f64,
    /// Share of the light from behind that it hides, 0…1.
    pub opacity: f64,
    /// Through which face it comes.
    pub face: Face,
    /// Unit normal of that.
    pub normal: DVec3,
    /// The span.
    pub span: Span,
}

/// Follows rays through what stands in one database.
pub struct Solids<'a, S: PageSource> {
    source: &'a S,
    /// Level index 0 as a lattice.
    lattice: Lattice,
    code: HeightCode,
    spacing: f64,
    objects: &'a SharedObjects,
    /// What stands on blocks by where they lie, and the one that was asked for last.
    blocks: HashMap<[i64; 2], Rc<BlockSpans>>,
    latest: Option<([i64; 2], Rc<BlockSpans>)>,
}

/// Column and row of a voxel on its page.
fn within_page(cell: [i64; 2]) -> [u32; 2] {
    cell.map(|cell| (cell % i64::from(PAGE_SIDE)) as u32)
}

impl<'a, S: PageSource> Solids<'a, S> {
    /// Solids of `source`, in the area as `cursor` has it: once, or repeated.
    pub fn new(cursor: &PageCursor<'a, S>) -> Self {
        let source = cursor.source();
        let header = source.header();
        let (code, spacing) = (header.heights, header.grid.spacing);
        let objects = &*header.objects;
        let (blocks, latest) = (HashMap::new(), None);
        Self { source, lattice: cursor.voxels(0), code, spacing, objects, blocks, latest }
    }

    /// Appends what a ray meets between two ranges (metres), nearest first, until nothing of the light behind is left. Returns that share.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn along(&mut self, ray: &GridRay, start: f64, end: f64, hits: &mut Vec<SolidHit>) -> Result<f64> {
        let mut left = 1.0;
        for step in CellWalk::new(ray, self.lattice, start, end) {
            let block = self.block(step.cell)?;
            let [x, y] = within_page(step.cell);
            let spans = block.of(x, y);
            let before = hits.len();
            hits.extend(spans.iter().filter_map(|span| self.hit(ray, &step, span)));
            hits[before..].sort_by(|a, b| a.range.total_cmp(&b.range));
            for index in before..hits.len() {
                left *= 1.0 - hits[index].opacity;
                if left < NOTHING_LEFT {
                    hits.truncate(index + 1);
                    return Ok(0.0);
                }
            }
        }
        Ok(left)
    }

    /// What stands on the block of a voxel.
    fn block(&mut self, cell: [i64; 2]) -> Result<Rc<BlockSpans>> {
        let at = cell.map(|cell| cell / i64::from(BLOCK_SIDE));
        if let Some((known, block)) = &self.latest
            && *known == at
        {
            return Ok(Rc::clone(block));
        }
        let block = match self.blocks.get(&at) {
            Some(block) => Rc::clone(block),
            None => self.gathered(cell)?,
        };
        if self.blocks.len() >= BLOCKS {
            self.blocks.clear();
        }
        self.blocks.insert(at, Rc::clone(&block));
        self.latest = Some((at, Rc::clone(&block)));
        Ok(block)
    }

    fn gathered(&self, cell: [i64; 2]) -> Result<Rc<BlockSpans>> {
        let [px, py] = cell.map(|cell| (cell / i64::from(PAGE_SIDE)) as u32);
        let view = self.source.spans(PageId { level: BARE, px, py })?.unwrap_or(SpansView::NONE);
        let mut block = BlockSpans::default();
        let rise = SpanTable::rise(self.code, self.spacing);
        block.gather(&view, self.objects, within_page(cell), rise);
        Ok(Rc::new(block))
    }

    /// What a ray meets of a span on its way through a voxel.
    fn hit(&self, ray: &GridRay, step: &CellStep, span: &Span) -> Option<SolidHit> {
        let height = |code: u16| self.code.offset + self.code.scale * f64::from(code);
        // From the voxel's centre, in sides of it; heights in metres above the centre's upper end.
        let (corner, extent) = self.lattice.place(step);
        let centre = corner + 0.5 * extent;
        let place =
            |range: f64| (ray.at(range).truncate() - centre, ray.height_at(range) - height(span.high));
        let mut stretch = Stretch::new(ray, step, place);
        let wall = |index: usize| {
            let cut = span.cuts[index];
            let (normal, distance) = (DVec2::from(cut.normal().map(f64::from)), f64::from(cut.distance()));
            cut.is_wall().then_some((index, normal, distance))
        };
        let walls = [0, 1, 2].map(wall);
        // The last wall that the ray came through.
        let mut through = None;
        for (index, normal, distance) in walls.into_iter().flatten() {
            let beyond = |at: DVec2| normal.dot(at) - distance;
            let before = stretch.enter;
            if index == 0 && span.is(Span::STRIP) {
                let half = 0.5 * (height(span.high) - height(span.low)) / self.spacing;
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
        if span.low != Span::GROUND {
            let down = height(span.low) - height(span.high);
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
        let Stretch { enter, leave, mut face, mut normal, .. } = stretch;
        if enter >= leave {
            return None;
        }
        // Through a side of the voxel, or where it meets another part of the same thing.
        let is_side = enter == step.enter;
        let is_joint = through.is_some_and(|(index, at)| at == enter && span.is_joined(index));
        if is_side || is_joint {
            let (at, above) = place(enter);
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
        Some(SolidHit { range: enter, opacity, face, normal, span: *span })
    }
}

/// What is left of a ray's way through a voxel.
struct Stretch {
    enter: f64,
    leave: f64,
    /// Where the ray is at the voxel's ends: east and north of its centre, and above a span's upper end.
    ends: [(DVec2, f64); 2],
    /// Ranges there, metres.
    ranges: [f64; 2],
    face: Face,
    normal: DVec3,
}

impl Stretch {
    fn new(ray: &GridRay, step: &CellStep, place: impl Fn(f64) -> (DVec2, f64)) -> Self {
        let ends = [place(step.enter), place(step.leave)];
        // The side of the voxel through which the ray came is the one that it is nearest to.
        let at = ends[0].0;
        let is_east_west = at.x.abs() >= at.y.abs();
        let normal = if is_east_west {
            DVec3::new(-ray.slope.x.signum(), 0.0, 0.0)
        } else {
            DVec3::new(0.0, -ray.slope.y.signum(), 0.0)
        };
        let ranges = [step.enter, step.leave];
        Self { enter: step.enter, leave: step.leave, ends, ranges, face: Face::Side, normal }
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
