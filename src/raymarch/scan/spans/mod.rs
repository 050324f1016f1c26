//! Spans on bare ground, drawn by sixteen planes at a time.
//!
//! ```text
//! for each size of cells that what stands is seen in, near by voxels, which cells are called below:
//! for each block of 8 × 8 voxels that some plane crosses, from the eye outward:
//!     it lies below what is hidden in every plane → next block
//!     for each of its voxels that some plane crosses and that rises above what is hidden, outward:
//!         for each of its spans, outward, in all planes at once:
//!             the part of the way within its walls
//!             its front, between the tangents of its lower and upper end there          → rows that are not hidden yet
//!             what is seen of its upper end, from the front's to the far end's tangent  → rows above
//!             or of its lower end                                                       → rows below
//! ```
//!
//! A plane sees a span as a quadrilateral, so that in a column of the picture it is an interval of tangents per face. What is nearer hides
//! what is further away: rows keep what is left of them ([`SpanCoverage`]), and the ground hides all below its *horizon*, the highest tangent
//! of its [`Profile`] so far, which also is where what stands on the ground begins. Marching columns of voxels by planes, with the
//! rows that are still open, is how voxel landscapes with overhangs were drawn before (K. Silverman's Voxlap engine, 2000); here
//! spans have planes for ends and walls, and cover shares of rows.
//!
//! Lanes are planes throughout. Neighbours soon see other voxels, but in the demo's valley twelve of them cross a block and five a
//! voxel on average; and whatever is the same for all, such as walls and light, is found once.

mod coverage;
mod crossing;
mod facade;
mod fill;
mod front;
mod horizon;
mod metric;
mod order;
mod packet;
mod plane_lanes;

#[cfg(test)]
mod tests;

use glam::DVec3;

pub use self::coverage::{RowMiddle, SpanCoverage, SpanRow};
use self::crossing::{Floor, VoxelCrossing};
use self::horizon::FloatingHorizon;
use self::metric::Metric;
pub use self::metric::{FaceDirection, FacetLight};
use self::packet::{BlockPassage, CellExtent, PlanePacket};
use self::plane_lanes::PlaneLanes;
use super::{MarchField, PlaneGroup, Profile, RowTable};
use crate::cache::Lent;
use crate::raymarch::bands::{COARSEST_CELLS, SpanBand};
use crate::raymarch::blocks::{BlockPlace, BlockTable, Blocks, corner_on_page};
use crate::simd::{Floats, Ints, Isa, Kernel, LANES, Mask, Simd};
use crate::voxel::{BLOCK_SIDE, Cut, Grid, PageId, PageSource, Span, SpansView};
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
    /// Sizes of cells that what stands there is seen in, nearest first.
    pub bands: &'f [SpanBand],
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
    /// Measures of cells, by log₂ of their side in voxels.
    metrics: Vec<Metric>,
    blocks: Blocks<'a, Lent<'a, BlockTable>>,
}

impl<'a> SpanMarch<'a> {
    /// Builds the march over `source`, for one frame; `blocks` may hold some that the one before looked at.
    pub fn new(source: &'a dyn PageSource, mut blocks: Lent<'a, BlockTable>) -> Self {
        let header = source.header();
        let (grid, code) = (header.grid, header.heights);
        let metric = |shift: u8| Metric {
            shift,
            code,
            grid,
            scale: code.scale as f32,
            spacing: (grid.spacing * f64::from(1_u32 << shift)) as f32,
            directions: std::array::from_fn(|facing| Cut::wall(facing as u8, 0).normal()),
            clearness: std::array::from_fn(|steps| (1.0 - steps as f32 / f32::from(Span::OPAQUE)).log2()),
        };
        blocks.begin_frame();
        let metrics = (0..=COARSEST_CELLS).map(metric).collect();
        Self { grid, metrics, blocks: Blocks::new(source, blocks) }
    }

    /// Finds the spans that sixteen planes see.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn see(
        &mut self,
        isa: Isa,
        scan: &SpanScan<'_>,
        light: &mut impl FacetLight,
        coverage: &mut SpanCoverage,
    ) -> Result<()> {
        coverage.begin(scan.rows, scan.has_depths);
        if scan.until <= 0.0 {
            return Ok(());
        }
        isa.run(Following { march: self, scan, light, coverage })
    }
}

/// All planes of a group on their way.
struct Following<'f, 'a, L> {
    march: &'f mut SpanMarch<'a>,
    scan: &'f SpanScan<'f>,
    light: &'f mut L,
    coverage: &'f mut SpanCoverage,
}

impl<L: FacetLight> Kernel for Following<'_, '_, L> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Result<()> {
        let Self { march, scan, light, coverage } = self;
        let lowest = scan.field.tangents[0];
        let mut floor = Floor { tangent: simd.splat(lowest), rows: simd.splat(0.0) };
        let rows = simd.splat(scan.rows as f32);
        let SpanMarch { grid, metrics, blocks } = march;

        for (index, band) in scan.bands.iter().enumerate() {
            let Some(metric) = metrics.get(usize::from(band.shift)) else { continue };
            // Cells take the place of voxels: all is counted in them.
            let side = f64::from(1_u32 << band.shift);
            let group = scan.group.in_cells(side);
            let eye = scan.eye.truncate().to_array().map(|at| at / side);
            let height = scan.eye.z - metric.code.offset;
            let from = if index == 0 { 0.0 } else { band.start / group.ground };
            let is_last = index + 1 == scan.bands.len();
            let until =
                if is_last { scan.until / side } else { (band.end / group.ground).min(scan.until / side) };
            let extent = CellExtent { grid, shift: band.shift, over: [from, until] };

            let lanes = PlaneLanes::new(simd, &group, height, metric.spacing);
            let mut walk = PacketWalk { metric, blocks, scan, light, coverage, lanes, floor };
            // Few groups have planes of both senses: those about an axis.
            for upward in [true, false] {
                let packet = PlanePacket::new(simd, &group, extent, eye, upward);
                if let Some(packet) = packet {
                    walk.follow(simd, packet)?;
                }
            }

            floor = walk.floor;
            if !floor.rows.lt(rows).any() {
                break;
            }
        }

        Ok(())
    }
}

/// Packet of planes on its way through what stands.
struct PacketWalk<'f, 'a, L, V: Simd> {
    metric: &'f Metric,
    blocks: &'f mut Blocks<'a, Lent<'a, BlockTable>>,
    scan: &'f SpanScan<'f>,
    light: &'f mut L,
    coverage: &'f mut SpanCoverage,
    lanes: PlaneLanes<V>,
    /// Floor below which the ground or nearer spans hide everything.
    floor: Floor<V>,
}

impl<L: FacetLight, V: Simd> PacketWalk<'_, '_, L, V> {
    /// Follows planes outward.
    #[inline(always)]
    fn follow(&mut self, simd: V, mut packet: PlanePacket<'_, V>) -> Result<()> {
        let mut at_column = FloatingHorizon::new(simd, self.scan.profile, self.scan.field.tangents[0]);

        for number in packet.columns() {
            let column = packet.column(simd, number);
            at_column.advance(simd, packet.planes, self.lanes.inverse(simd, simd.splat(column.start as f32)));

            for row in packet.rows(simd, &column) {
                let Some(block) = packet.block(simd, &column, row) else { continue };
                let place = BlockPlace { at: block.cell, shift: self.metric.shift };
                let (page, view) = self.blocks.page(place.first())?;
                let [x, y] = corner_on_page(place.first());
                let reach = view.reach(x, y, place.count());
                if reach[1] == 0 {
                    continue;
                }

                let entry = self.lanes.inverse(simd, block.distances(simd)[0]);
                let mut horizon = at_column;
                horizon.advance(simd, block.planes, entry);
                if self.is_hidden(simd, reach, &block, horizon.at(simd, block.planes, entry)) {
                    continue;
                }
                self.cross_block(simd, page, &view, &packet, &block, horizon);
            }

            // Planes of which all rows are hidden have ended.
            let rows = simd.splat(self.coverage.count() as f32);
            packet.planes = packet.planes & self.floor.rows.lt(rows);
            if !packet.planes.any() {
                break;
            }
        }

        Ok(())
    }

    /// Whether all that stands in a block lies below what hides it, or above what is looked at, in each plane that crosses it. `horizon`: the ground's
    /// where they enter.
    #[inline(always)]
    fn is_hidden(
        &mut self,
        simd: V,
        [lowest, highest]: [u16; 2],
        block: &BlockPassage<V>,
        horizon: V::F,
    ) -> bool {
        let distances = block.distances(simd);
        let [near, far] = [self.lanes.inverse(simd, distances[0]), self.lanes.inverse(simd, distances[1])];
        let datum = [self.lanes.datum(distances[0]), self.lanes.datum(distances[1])];
        let scale = simd.splat(self.metric.scale);
        let high = scale * simd.splat(f32::from(highest));
        let high = ((datum[0] + high) * near).max((datum[1] + high) * far);

        let mut rises = block.planes & self.floor.tangent.lt(high) & horizon.lt(high);
        if lowest != Span::GROUND {
            let low = scale * simd.splat(f32::from(lowest));
            let low = ((datum[0] + low) * near).min((datum[1] + low) * far);
            rises = rises & low.lt(simd.splat(self.scan.field.tangents[1]));
        }
        if !rises.any() {
            return true;
        }

        self.raise_floor(simd, rises, horizon);
        !(rises & self.floor.tangent.lt(high)).any()
    }

    /// Finds below which tangents all is hidden in some planes, behind ground with these horizons.
    #[inline(always)]
    fn raise_floor(&mut self, simd: V, planes: V::M, horizon: V::F) {
        let SpanScan { row_table, first, .. } = *self.scan;
        let rows = row_table.coordinate.rows_below(simd, horizon) - simd.splat(first as f32);
        let is_higher = planes & self.floor.tangent.lt(horizon);
        let hidden = self.floor.rows.max(rows).select(is_higher, self.floor.rows);
        let lowest = self.coverage.close_below(simd, planes, hidden);
        let edge = simd.gather(&row_table.edges[first..], lowest);
        self.floor = Floor {
            tangent: self.floor.tangent.max(horizon).max(edge).select(planes, self.floor.tangent),
            rows: hidden.max(lowest.to_float()).select(planes, hidden),
        };
    }

    /// Looks at the voxels of a block, from where the horizon has got to.
    #[inline(always)]
    fn cross_block(
        &mut self,
        simd: V,
        page: PageId,
        view: &SpansView<'_>,
        packet: &PlanePacket<'_, V>,
        block: &BlockPassage<V>,
        mut horizon: FloatingHorizon<'_, V>,
    ) {
        let SpanScan { row_table, first, .. } = *self.scan;
        let at = BlockPlace { at: block.cell, shift: self.metric.shift };
        let corner = corner_on_page(at.first());
        let (zero, half) = (simd.splat(0.0), simd.splat(0.5));
        let lanes = self.lanes;
        let (metric, stands) = (self.metric, self.blocks.get(at, view));
        // Voxel in a cell that stands for it.
        let middle = at.count() / 2;

        // What does not rise above a code that is linear in the major distance is hidden: `height · inverse depth ≤ floor`.
        let [from, to] = block.distances(simd);
        let per_code = simd.splat(1.0 / metric.scale);
        let per_unit = self.floor.tangent * lanes.depth * per_code;
        let base = zero - lanes.datum((from + to) * half) * per_code;
        let falls = per_unit.lt(zero);

        for number in packet.voxel_columns(simd, block) {
            let column = packet.voxel_column(simd, block, number);
            let start = simd.splat((block.start + f64::from(number)) as f32);
            horizon.advance(simd, block.planes, lanes.inverse(simd, start));

            for up in column.voxels.clone() {
                let place = packet.place(number, up);
                let top = stands.tops()[place];
                if top == 0.0 {
                    continue;
                }
                let Some(voxel) = packet.voxel(simd, block, &column, up) else { continue };

                // Whichever end it is deeper hidden at has the last word.
                let end = voxel.distances[1].select(falls, voxel.distances[0]);
                let planes = voxel.planes & end.mul_add(per_unit, base).lt(simd.splat(top));
                if !planes.any() {
                    continue;
                }

                let inverse =
                    [lanes.inverse(simd, voxel.distances[0]), lanes.inverse(simd, voxel.distances[1])];
                let above = lanes.datum((voxel.distances[0] + voxel.distances[1]) * half);
                let mut heights = [0.0; LANES];
                above.store(&mut heights);
                let (east, north) = (place as u32 % BLOCK_SIDE, place as u32 / BLOCK_SIDE);
                let mut crossing = VoxelCrossing {
                    simd,
                    page,
                    voxel: [corner[0] + east * at.count() + middle, corner[1] + north * at.count() + middle],
                    metric,
                    coverage: &mut *self.coverage,
                    light: &mut *self.light,
                    coordinate: row_table.coordinate,
                    first: first as f32,
                    centres: &row_table.centres[first..],
                    edges: &row_table.edges[first..],
                    lanes: &lanes,
                    floor: self.floor,
                    horizon: &horizon,
                    length: voxel.distances[1] - voxel.distances[0],
                    ends: packet.ends(simd, block, &voxel, [number, up]),
                    inverse,
                    above,
                    about: heights[planes.bits().trailing_zeros() as usize],
                    eye: packet.eye_from(block, [number, up]),
                };
                crossing.look_at(planes, stands.at(place));
            }
        }
    }
}
