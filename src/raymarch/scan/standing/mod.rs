//! What stands on bare ground, plane by plane.
//!
//! ```text
//! for each plane, from the eye outward:
//!     for each block of 8 × 8 voxels that it crosses, for each voxel of these, for each of its spans:
//!         the part of the way within the wall, from near to far
//!         its front, between the tangents of its lower and upper end there          → rows that are not hidden yet
//!         what is seen of its upper end, from the front's to the far end's tangent  → rows above
//!         or of its lower end                                                       → rows below
//! ```
//!
//! A plane sees a span as a quadrilateral, so that in a column of the picture it is an interval of tangents per face. What is nearer hides
//! what is further away: rows keep what is left of them ([`Column`]), and the ground hides all below its *crest*, the highest tangent
//! of its [`Profile`] so far, which also is where what stands on the ground begins. Marching columns of voxels by planes, with the
//! rows that are still open, is how voxel landscapes with overhangs were drawn before (K. Silverman's Voxlap engine, 2000); here
//! spans have planes for ends and walls, and cover shares of rows.
//!
//! Planes are followed one by one, not in lockstep: neighbours soon see other voxels, and most blocks are passed over.

mod column;
mod crest;
mod walk;

use glam::DVec3;

pub use self::column::Cover;
use self::column::{Column, Fill};
use self::crest::Crest;
use self::walk::{Step, Walk};
use super::{Field, Ladder, PlaneGroup, Profile};
use crate::error::Result;
use crate::simd::LANES;
use crate::voxel::{
    BARE, BLOCK_SIDE, Grid, HeightCode, PAGE_SIDE, PageId, PageSource, Span, SpanBlock, SpansView,
};

/// How far walls and upper ends of neighbours that are one may be apart, sides of a voxel; as the reference has it.
const SEAM: f32 = 0.04;

/// Spans of a voxel that are put in order.
const MOST_SORTED: usize = 16;

/// Least major distance of what is seen, units: tangents stay finite.
const LEAST_DISTANCE: f64 = 1.0e-6;

/// Which way a face looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Facet {
    /// A wall that looks in a direction, 256ths of a turn counter-clockwise from east.
    Side(u8),
    /// An upper end of some slope, as [`Span::slope`].
    Top([i8; 2]),
    /// A lower end.
    Bottom,
}

/// Finds the light of faces.
pub trait FacetLight {
    /// Radiance of a face of a span in a voxel (x, y of the page of bare ground), linear Rec. 709.
    fn light(&mut self, page: PageId, voxel: [u32; 2], span: &Span, facet: Facet) -> [f32; 3];
}

/// The planes to follow, and what is known of them.
#[derive(Clone, Copy)]
pub struct Standing<'f> {
    /// The eye: units, units, metres.
    pub eye: DVec3,
    /// The planes.
    pub group: &'f PlaneGroup,
    /// What they see of the ground.
    pub profile: &'f Profile,
    /// Major distance up to which that is bare, units.
    pub until: f64,
    /// Tangents that are of interest.
    pub field: Field,
    /// Rows, and which of them are filled.
    pub ladder: &'f Ladder,
    /// Index of the first one.
    pub first: usize,
    /// How many.
    pub rows: usize,
}

/// Follows planes through what stands in one database.
pub struct StandingMarch<'a> {
    source: &'a dyn PageSource,
    grid: Grid,
    code: HeightCode,
    /// The page that was looked up last.
    page: Option<(PageId, SpansView<'a>)>,
    column: Column,
}

/// One plane on its way.
struct Plane<'f, 'a, L> {
    march: &'f mut StandingMarch<'a>,
    standing: Standing<'f>,
    light: &'f mut L,
    lane: usize,
    /// Metres of depth, and of ground, per unit of major distance.
    depth: f64,
    ground: f32,
    /// Units eastward and northward per unit of major distance.
    way: [f64; 2],
    crest: Crest<'f>,
    /// Tangent below which all is hidden, by the ground or by what stands nearer.
    floor: f32,
}

/// A voxel's spans, where a plane crosses them.
struct Crossing<'s> {
    page: PageId,
    /// Column and row on the page.
    voxel: [u32; 2],
    step: &'s Step,
    /// Where the plane enters and leaves the voxel: from its centre, sides of it.
    ends: [[f32; 2]; 2],
    /// How much higher the eye is than the datum there, with the Earth's curvature, metres.
    above: f32,
}

impl<'a> StandingMarch<'a> {
    /// Over `source`.
    pub fn new(source: &'a dyn PageSource) -> Self {
        let header = source.header();
        Self { source, grid: header.grid, code: header.heights, page: None, column: Column::default() }
    }

    /// Finds what of it sixteen planes see.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn see(
        &mut self,
        standing: &Standing<'_>,
        light: &mut impl FacetLight,
        cover: &mut Cover,
    ) -> Result<()> {
        cover.begin(standing.rows);
        if standing.until <= 0.0 {
            return Ok(());
        }
        for lane in 0..LANES {
            self.column.begin(standing.rows);
            let group = standing.group;
            let minor = f64::from(group.minor[lane]);
            let way = if group.major == 0 { [group.forward, minor] } else { [minor, group.forward] };
            let plane = Plane {
                march: self,
                standing: *standing,
                light: &mut *light,
                lane,
                depth: f64::from(group.depth[lane]),
                ground: (way[0].hypot(way[1])) as f32,
                way,
                crest: Crest::new(standing.profile, lane, standing.field.tangents[0]),
                floor: standing.field.tangents[0],
            };
            plane.follow()?;
            self.column.put_into(lane, cover);
        }
        Ok(())
    }

    /// What stands on a page; nothing where all of it is surface.
    #[inline]
    fn spans(&mut self, id: PageId) -> Result<SpansView<'a>> {
        match self.page {
            Some((known, view)) if known == id => Ok(view),
            _ => {
                let view = if self.source.has(id) { self.source.spans(id)? } else { None };
                let view = view.unwrap_or(SpansView::NONE);
                self.page = Some((id, view));
                Ok(view)
            }
        }
    }
}

impl<L: FacetLight> Plane<'_, '_, L> {
    fn follow(mut self) -> Result<()> {
        let Standing { eye, group, until, .. } = self.standing;
        let [enter, leave] = group.over.map(|over| f64::from(over[self.lane]));
        let (from, to) = (enter.max(LEAST_DISTANCE), leave.min(until));
        let size = [self.march.grid.nx, self.march.grid.ny].map(|side| i64::from(side) - 1);
        let blocks = size.map(|last| [0, last / i64::from(BLOCK_SIDE)]);
        let side = f64::from(BLOCK_SIDE);
        for block in Walk::new([eye.x, eye.y], self.way, side, blocks, [from, to]) {
            if self.march.column.is_closed() {
                break;
            }
            let id = self.page_of(block.cell, PAGE_SIDE / BLOCK_SIDE);
            let view = self.march.spans(id)?;
            let first = block.cell.map(|cell| cell * i64::from(BLOCK_SIDE));
            let within = |axis: usize| (first[axis] % i64::from(PAGE_SIDE)) as u32;
            let spans = view.block(within(0), within(1));
            if spans.occupied == 0 || self.is_hidden(&spans, &block) {
                continue;
            }
            let ends =
                [0, 1].map(|axis| [first[axis], (first[axis] + i64::from(BLOCK_SIDE) - 1).min(size[axis])]);
            for step in Walk::new([eye.x, eye.y], self.way, 1.0, ends, [block.enter, block.leave]) {
                self.cross(id, &view, &spans, &step);
            }
        }
        Ok(())
    }

    fn page_of(&self, cell: [i64; 2], per_page: u32) -> PageId {
        let [px, py] = cell.map(|cell| (cell / i64::from(per_page)) as u32);
        PageId { level: BARE, px, py }
    }

    /// Height of a code above the eye at a major distance, metres.
    #[inline]
    fn height(&self, code: u16, distance: f64) -> f64 {
        let drop = f64::from(self.standing.group.drop[self.lane]) * distance * distance;
        self.march.code.offset + self.march.code.scale * f64::from(code) - self.standing.eye.z - drop
    }

    /// Whether all that stands in a block lies below what hides it, or above what is looked at.
    fn is_hidden(&mut self, spans: &SpanBlock, block: &Step) -> bool {
        let tangents = |code: u16| {
            [block.enter, block.leave].map(|at| (self.height(code, at) / (self.depth * at)) as f32)
        };
        let [near, far] = tangents(spans.high);
        let high = near.max(far);
        let lowest = if spans.low == Span::GROUND {
            f32::NEG_INFINITY
        } else {
            tangents(spans.low).into_iter().fold(f32::INFINITY, f32::min)
        };
        let crest = self.crest.at((1.0 / (self.depth * block.enter)) as f32);
        if high <= self.floor || high <= crest || lowest >= self.standing.field.tangents[1] {
            return true;
        }
        self.raise_floor(crest);
        high <= self.floor
    }

    /// Finds below which tangent all is hidden, behind ground with this crest.
    fn raise_floor(&mut self, crest: f32) {
        let Standing { ladder, first, .. } = self.standing;
        let hidden = if crest > self.floor { ladder.rows_below(crest) - first as f32 } else { 0.0 };
        let lowest = self.march.column.close_below(hidden);
        let edge = ladder.edges.get(first + lowest).copied().unwrap_or(f32::INFINITY);
        self.floor = self.floor.max(crest).max(edge);
    }

    /// Looks at the spans of a voxel.
    #[inline]
    fn cross(&mut self, page: PageId, view: &SpansView<'_>, block: &SpanBlock, step: &Step) {
        let voxel = step.cell.map(|cell| (cell % i64::from(PAGE_SIDE)) as u32);
        let spans = view.of(block, voxel[0], voxel[1]);
        if spans.is_empty() || step.enter >= step.leave {
            return;
        }
        let eye = [self.standing.eye.x, self.standing.eye.y];
        let from_centre =
            |axis: usize, at: f64| (eye[axis] + self.way[axis] * at - step.cell[axis] as f64 - 0.5) as f32;
        let ends = [step.enter, step.leave].map(|at| [from_centre(0, at), from_centre(1, at)]);
        let above = self.height(0, 0.5 * (step.enter + step.leave)) as f32;
        let crossing = Crossing { page, voxel, step, ends, above };
        // A ray that rises meets the lower of two first, one that falls the upper: outward from the eye's height.
        let first =
            spans.partition_point(|span| self.march.code.scale as f32 * f32::from(span.high) + above <= 0.0);
        let outward = spans[first..].iter().chain(spans[..first].iter().rev());
        let (scale, spacing) = (self.march.code.scale as f32, self.march.grid.spacing as f32);
        let inverse = [step.enter, step.leave].map(|at| (1.0 / (self.depth * at)) as f32);
        let rise_per_step = 0.5 * spacing / Span::SLOPE_STEPS;
        let steps = scale / spacing;
        let mut met = [(0.0_f32, 0.0_f32, &spans[0]); MOST_SORTED];
        let mut count = 0;
        for span in outward {
            // Most are hidden: their highest corner tells.
            let steepest = f32::from(span.slope[0].unsigned_abs()) + f32::from(span.slope[1].unsigned_abs());
            let top = scale.mul_add(f32::from(span.high), above) + steepest * rise_per_step;
            if top * inverse[usize::from(top < 0.0)] <= self.floor {
                continue;
            }
            let Some([enter, leave]) = crossing.within(span, steps) else { continue };
            if count == MOST_SORTED {
                self.meet(&crossing, span, [enter, leave]);
                continue;
            }
            // Halves of a ridge stand beside each other in one voxel: the nearer one comes first.
            let mut at = count;
            while at > 0 && met[at - 1].0 > enter {
                met[at] = met[at - 1];
                at -= 1;
            }
            met[at] = (enter, leave, span);
            count += 1;
        }
        for &(enter, leave, span) in &met[..count] {
            self.meet(&crossing, span, [enter, leave]);
        }
    }

    /// Fills what is seen of a span, of which the plane crosses a part between two shares of the way through the voxel.
    fn meet(&mut self, crossing: &Crossing<'_>, span: &Span, cut: [f32; 2]) {
        let Crossing { step, above, .. } = crossing;
        let length = step.leave - step.enter;
        let distance = cut.map(|share| step.enter + length * f64::from(share));
        let inverse = distance.map(|at| (1.0 / (self.depth * at)) as f32);
        let spacing = self.march.grid.spacing as f32;
        let at = cut.map(|share| {
            [0, 1].map(|axis| {
                crossing.ends[0][axis] + (crossing.ends[1][axis] - crossing.ends[0][axis]) * share
            })
        });
        let slope = span.slopes();
        let rise = at.map(|at| (slope[0] * at[0] + slope[1] * at[1]) * spacing);
        let scale = self.march.code.scale as f32;
        let top = scale.mul_add(f32::from(span.high), *above);
        let crest = self.crest.at(inverse[0]);
        let [top_near, top_far] = [0, 1].map(|end| (top + rise[end]) * inverse[end]);
        let [low_near, low_far] = if span.low == Span::GROUND {
            [crest; 2]
        } else {
            let low = scale.mul_add(f32::from(span.low), *above);
            let parallel = if span.is(Span::PARALLEL) { 1.0 } else { 0.0 };
            [0, 1].map(|end| rise[end].mul_add(parallel, low) * inverse[end])
        };
        let (facet, seam) = crossing.front(span, cut[0], at[0]);
        let Standing { ladder, first, .. } = self.standing;
        let row = |tangent: f32| ladder.rows_below(tangent) - first as f32;
        // The rim of the front that is lit as the upper end is.
        let rim = top_near - seam * spacing * inverse[0];
        let side = [low_near.max(crest), rim.max(low_near)];
        let upper = [rim.max(low_near).max(crest), top_near.max(top_far)];
        let lower = [low_far.max(crest), low_near];
        let opacity = span.opacity();
        let way = self.ground * (distance[1] - distance[0]) as f32;
        let level = self.depth as f32 / (self.ground * spacing);
        for (tangents, facet, inverse) in [
            (side, facet, [inverse[0]; 2]),
            (upper, Facet::Top(span.slope), [inverse[0], inverse[usize::from(top_far > top_near)]]),
            (lower, Facet::Bottom, [inverse[1], inverse[0]]),
        ] {
            let [low, high] = tangents;
            if low >= high {
                continue;
            }
            let (low, high) = (row(low), row(high));
            if low >= high || self.march.column.is_full(low, high) {
                continue;
            }
            let light = self.light.light(crossing.page, crossing.voxel, span, facet);
            let slant = (0.5 * level * (tangents[0] + tangents[1])).hypot(1.0);
            self.march.column.fill([low, high], light, &Fill { opacity, way: way * slant, inverse });
        }
    }
}

impl Crossing<'_> {
    /// Shares of the way through the voxel between which the plane lies within a span's wall; `steps`: sides of a voxel in a step of height.
    #[inline]
    fn within(&self, span: &Span, steps: f32) -> Option<[f32; 2]> {
        let Some((normal, distance)) = span.wall() else { return Some([0.0, 1.0]) };
        let beyond = self.ends.map(|at| normal[0] * at[0] + normal[1] * at[1] - distance);
        if !span.is(Span::STRIP) {
            return clip([0.0, 1.0], beyond);
        }
        let half = 0.5 * f32::from(span.high - span.low.min(span.high)) * steps;
        let within = clip([0.0, 1.0], beyond.map(|beyond| beyond - half))?;
        clip(within, beyond.map(|beyond| -beyond - half))
    }

    /// Which way the front of a span looks that begins at a share of the way, `at` from the voxel's centre, and how much of it below its upper rim is
    /// lit as the upper end, sides of a voxel.
    #[inline]
    fn front(&self, span: &Span, share: f32, at: [f32; 2]) -> (Facet, f32) {
        if share > 0.0 {
            return (Facet::Side(span.facing), 0.0);
        }
        if span.cut == Span::ROUND {
            return (Facet::Side(span.facing), SEAM);
        }
        if let Some((normal, distance)) = span.wall()
            && distance - normal[0] * at[0] - normal[1] * at[1] < SEAM
        {
            return (Facet::Side(span.facing), SEAM);
        }
        // Of the voxel's sides the one that the plane enters through.
        let facing = if at[0].abs() >= at[1].abs() {
            if at[0] > 0.0 { 0 } else { 128 }
        } else if at[1] > 0.0 {
            64
        } else {
            192
        };
        (Facet::Side(facing), SEAM)
    }
}

/// What of a range of shares lies where `beyond`, linear from share 0 to 1, is not positive.
#[inline]
fn clip([from, to]: [f32; 2], [first, last]: [f32; 2]) -> Option<[f32; 2]> {
    if first <= 0.0 && last <= 0.0 {
        return Some([from, to]);
    }
    if first > 0.0 && last > 0.0 {
        return None;
    }
    let crossing = first / (first - last);
    let clipped = if first > 0.0 { [from.max(crossing), to] } else { [from, to.min(crossing)] };
    (clipped[0] < clipped[1]).then_some(clipped)
}
