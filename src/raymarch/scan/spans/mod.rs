//! Spans on bare ground, drawn plane by plane.
//!
//! ```text
//! for each plane, from the eye outward:
//!     for each block of 8 × 8 voxels that it crosses:
//!         its voxels that rise above what is hidden, all at once; for each of them from near to far:
//!         for each of its spans:
//!             the part of the way within the wall, from near to far
//!             its front, between the tangents of its lower and upper end there          → rows that are not hidden yet
//!             what is seen of its upper end, from the front's to the far end's tangent  → rows above
//!             or of its lower end                                                       → rows below
//! ```
//!
//! A plane sees a span as a quadrilateral, so that in a column of the picture it is an interval of tangents per face. What is nearer hides
//! what is further away: rows keep what is left of them ([`FreeRows`]), and the ground hides all below its *horizon*, the highest tangent
//! of its [`Profile`] so far, which also is where what stands on the ground begins. Marching columns of voxels by planes, with the
//! rows that are still open, is how voxel landscapes with overhangs were drawn before (K. Silverman's Voxlap engine, 2000); here
//! spans have planes for ends and walls, and cover shares of rows.
//!
//! Planes are followed one by one, not in lockstep: neighbours soon see other voxels, and most blocks are passed over. Lanes are what one
//! plane does many times, voxels of a block and rows of the picture.

mod column;
mod crossing;
mod horizon;
mod metric;
mod voxels;
mod walk;

#[cfg(test)]
mod tests;

use glam::DVec3;

use self::column::FreeRows;
pub use self::column::SpanCoverage;
use self::crossing::VoxelCrossing;
use self::horizon::FloatingHorizon;
use self::metric::LEAST_DISTANCE;
pub use self::metric::{FaceDirection, FacetLight};
use self::voxels::{Passed, PlaneCourse, VoxelVeil};
use self::walk::{VoxelStep, Walk};
use super::{MarchField, PlaneGroup, Profile, RowTable};
use crate::raymarch::blocks::{Blocks, corner_on_page};
use crate::raymarch::scan::spans::metric::Metric;
use crate::simd::{Each, Isa, Kernel, LANES, Simd, Sixteen};
use crate::voxel::{BLOCK_SIDE, Cut, Grid, PageId, PageSource, Span, SpanBlock, SpansView};
use hedgehop_base::error::Result;

/// The planes to follow, and what is known of them.
#[derive(Clone, Copy)]
pub struct SpanScan<'f> {
    /// The eye: units, units, metres.
    pub eye: DVec3,
    /// The planes.
    pub group: &'f PlaneGroup,
    /// Visible profile of the ground.
    pub profile: &'f Profile,
    /// Major distance up to which that is bare, units.
    pub until: f64,
    /// Tangents that are of interest.
    pub field: MarchField,
    /// Rows, and which of them are filled.
    pub row_table: &'f RowTable,
    /// Index of the first one.
    pub first: usize,
    /// Number of rows.
    pub rows: usize,
    /// Whether it is of interest how far away what stands in their middles is.
    pub has_depths: bool,
}

/// Follows planes through what stands in one database.
pub struct SpanMarch<'a> {
    grid: Grid,
    metric: Metric,
    blocks: Blocks<'a>,
    passed: Passed,
    /// Tangents of the middles of rows.
    centres: Vec<Sixteen>,
    /// One for each plane of a group.
    columns: Box<[FreeRows; LANES]>,
}

/// One plane on its way.
struct Plane<'f, 'a, L> {
    march: &'f mut SpanMarch<'a>,
    standing: SpanScan<'f>,
    light: &'f mut L,
    lane: usize,
    /// Metres of depth per unit of major distance.
    depth: f64,
    /// Sides of a voxel along the ground per unit of major distance.
    ground: f32,
    /// Units eastward and northward per unit of major distance.
    way: [f64; 2],
    course: PlaneCourse,
    /// Change of units per metre of depth to the next plane.
    beside: [f32; 2],
    horizon: FloatingHorizon<'f>,
    /// Floor below which the ground or nearer spans hide everything: tangent, and rows.
    floor: f32,
    hidden: f32,
}

impl<'a> SpanMarch<'a> {
    /// Over `source`.
    pub fn new(source: &'a dyn PageSource) -> Self {
        let header = source.header();
        let (grid, code) = (header.grid, header.heights);
        let metric = Metric {
            code,
            scale: code.scale as f32,
            spacing: grid.spacing as f32,
            directions: std::array::from_fn(|facing| Cut::wall(facing as u8, 0).normal()),
            clearness: std::array::from_fn(|steps| (1.0 - steps as f32 / f32::from(Span::OPAQUE)).log2()),
        };
        Self {
            grid,
            metric,
            blocks: Blocks::new(source),
            passed: Passed::default(),
            centres: Vec::new(),
            columns: Box::default(),
        }
    }

    /// Finds what of it sixteen planes see.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn see(
        &mut self,
        isa: Isa,
        standing: &SpanScan<'_>,
        light: &mut impl FacetLight,
        cover: &mut SpanCoverage,
    ) -> Result<()> {
        cover.clear();
        if standing.until <= 0.0 {
            return Ok(());
        }
        let centres = standing.row_table.centres[standing.first..].chunks(LANES);
        let sixteen = |centres: &[f32]| {
            Sixteen(std::array::from_fn(|row| centres.get(row).copied().unwrap_or_default()))
        };
        self.centres.clear();
        self.centres.extend(centres.take(standing.rows.div_ceil(LANES)).map(sixteen));
        isa.run(Following { march: self, standing, light })?;
        cover.take(&self.columns);
        Ok(())
    }
}

/// All planes of a group, one after the other.
struct Following<'f, 'a, L> {
    march: &'f mut SpanMarch<'a>,
    standing: &'f SpanScan<'f>,
    light: &'f mut L,
}

impl<L: FacetLight> Kernel for Following<'_, '_, L> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Result<()> {
        let Self { march, standing, light } = self;
        for lane in 0..LANES {
            march.columns[lane].begin(standing.rows, standing.has_depths);
            let group = standing.group;
            let way = group.way(lane);
            let plane = Plane {
                march: &mut *march,
                standing: *standing,
                light: &mut *light,
                lane,
                depth: f64::from(group.depth[lane]),
                ground: (way[0].hypot(way[1])) as f32,
                way,
                course: PlaneCourse::new(
                    [standing.eye.truncate().to_array(), way],
                    f64::from(group.depth[lane]),
                ),
                beside: group.beside(lane),
                horizon: FloatingHorizon::new(standing.profile, lane, standing.field.tangents[0]),
                floor: standing.field.tangents[0],
                hidden: 0.0,
            };
            plane.follow(simd)?;
        }

        Ok(())
    }
}

impl<L: FacetLight> Plane<'_, '_, L> {
    #[inline(always)]
    fn column(&mut self) -> &mut FreeRows {
        &mut self.march.columns[self.lane]
    }

    #[inline(always)]
    fn follow<V: Simd>(mut self, simd: V) -> Result<()> {
        let SpanScan { eye, group, until, .. } = self.standing;
        let [enter, leave] = group.over.each(|over| f64::from(over[self.lane]));
        let (from, to) = (enter.max(LEAST_DISTANCE), leave.min(until));
        let size = [self.march.grid.nx, self.march.grid.ny].each(|side| i64::from(side) - 1);
        let blocks = size.each(|last| [0, last / i64::from(BLOCK_SIDE)]);
        let side = f64::from(BLOCK_SIDE);

        for block in Walk::new([eye.x, eye.y], self.way, side, blocks, [from, to]) {
            if self.column().is_closed() {
                break;
            }
            let (page, view) = self.march.blocks.page(block.cell)?;
            let [x, y] = corner_on_page(block.cell);
            let reach = view.block(x, y);
            if reach.high == 0 || self.is_hidden(&reach, &block) {
                continue;
            }
            self.cross_block(simd, page, &view, &block);
        }

        Ok(())
    }

    /// Height of a code above the eye at a major distance, metres.
    #[inline(always)]
    fn height(&self, code: u16, distance: f64) -> f64 {
        let drop = f64::from(self.standing.group.drop[self.lane]) * distance * distance;
        self.march.metric.code.offset + self.march.metric.code.scale * f64::from(code)
            - self.standing.eye.z
            - drop
    }

    /// Whether all that stands in a block lies below what hides it, or above what is looked at.
    #[inline(always)]
    fn is_hidden(&mut self, spans: &SpanBlock, block: &VoxelStep) -> bool {
        let tangents = |code: u16| {
            [block.enter, block.leave].each(|at| (self.height(code, at) / (self.depth * at)) as f32)
        };
        let [near, far] = tangents(spans.high);
        let high = near.max(far);
        let lowest = if spans.low == Span::GROUND {
            f32::NEG_INFINITY
        } else {
            tangents(spans.low).into_iter().fold(f32::INFINITY, f32::min)
        };
        let horizon = self.horizon.at((1.0 / (self.depth * block.enter)) as f32);
        if high <= self.floor || high <= horizon || lowest >= self.standing.field.tangents[1] {
            return true;
        }
        self.raise_floor(horizon);
        high <= self.floor
    }

    /// Finds below which tangent all is hidden, behind ground with this horizon.
    #[inline(always)]
    fn raise_floor(&mut self, horizon: f32) {
        let SpanScan { row_table, first, .. } = self.standing;
        if horizon > self.floor {
            self.hidden = self.hidden.max(row_table.rows_below(horizon) - first as f32);
        }
        let hidden = self.hidden;
        let lowest = self.column().close_below(hidden);
        let edge = row_table.edges.get(first + lowest).copied().unwrap_or(f32::INFINITY);
        self.hidden = self.hidden.max(lowest as f32);
        self.floor = self.floor.max(horizon).max(edge);
    }

    /// Looks at the voxels of a block.
    #[inline(always)]
    fn cross_block<V: Simd>(&mut self, simd: V, page: PageId, view: &SpansView<'_>, block: &VoxelStep) {
        let SpanScan { eye, row_table, first, .. } = self.standing;
        let (depth, lane) = (self.depth, self.lane);
        let drop = f64::from(self.standing.group.drop[lane]);
        let SpanMarch { blocks, metric, columns, passed, centres, .. } = &mut *self.march;
        let (corner, stands) = (corner_on_page(block.cell), blocks.get(block.cell, view));
        let datum = metric.code.offset - eye.z;
        let above = |from: f64, to: f64| datum - drop * (0.5 * (from + to)).powi(2);

        // What does not rise above a code that is linear in the major distance is hidden: `height · inverse depth ≤ floor`.
        let veil = VoxelVeil {
            base: -above(block.enter, block.leave) / metric.code.scale,
            per_unit: f64::from(self.floor) * depth / metric.code.scale,
        };
        let first_voxel = block.cell.each(|cell| cell * i64::from(BLOCK_SIDE));
        self.course.pass(simd, first_voxel, stands.tops(), [block.enter, block.leave], veil, passed);

        for voxel in passed.voxels() {
            let place = voxel.place as u32;
            let [near, far] = voxel.distances;
            let mut crossing = VoxelCrossing {
                simd,
                page,
                voxel: [corner[0] + place % BLOCK_SIDE, corner[1] + place / BLOCK_SIDE],
                metric,
                column: &mut columns[lane],
                light: &mut *self.light,
                row_table,
                first: first as f32,
                centres,
                ground: self.ground,
                level: depth as f32 / (self.ground * metric.spacing),
                ahead: self.way.each(|way| (way / depth) as f32),
                beside: self.beside,
                floor: self.floor,
                hidden: self.hidden,
                length: far - near,
                ends: voxel.at,
                inverse: voxel.inverse,
                above: above(f64::from(near), f64::from(far)) as f32,
            };

            crossing.look_at(stands.at(voxel.place), &mut self.horizon);
        }
    }
}
