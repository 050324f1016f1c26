//! Pages that planes may touch, told from the coarse levels alone.
//!
//! ```text
//! for each wedge of neighbouring groups of planes:
//!     for each ring, as long as the blocks of lines that are read there, nearest first:
//!         its highest surface lies below the horizon, and so did the last ring's → nothing of it is touched
//!         else its pages are needed, at every level that some plane may read there
//!         the lowest surface of each strip of it, a quarter as long, may raise the horizon
//! ```
//!
//! It is the march of [`super::march`] with bounds in place of heights: `low` lies below the surface that a plane will find, so this
//! horizon is never above the plane's, and what this passes over the march passes over too. Rings begin and end where
//! blocks of the march do. What is read to know what to read are bounds of levels from 16 on, most of which the march needs too.

mod needs;
mod ring;
mod surface;

use glam::DVec3;

use self::needs::{Need, Needs, What};
pub use self::ring::FootprintGroup;
use self::ring::{Ring, Rings, Sides, Wedge, edges_after};
use self::surface::{CoarseSurface, range_on_page};
use super::Strides;
use super::march::MOST_VOXELS;
use crate::detail::Displacement;
use crate::voxel::{Grid, HeightCode, PageId, PageNeeds, PageSource};
use hedgehop_base::error::Result;

/// Groups of planes that are looked at together: one takes five thirds of the time, and names 4 to 6 % fewer bytes.
const WEDGE: usize = 2;

/// Lines before a ring that are read where a segment or a stride begins, and posts around it that interpolation takes.
const MARGINS: [f64; 2] = [5.0, 2.0];

/// Share of the way from the lowest surface of a strip to the highest that it is likely to hide as much as.
const LIKELY: f64 = 0.67;

/// Sides of a voxel that a strip must have for the march to read a line in it for sure.
const SURE: f64 = 9.0;

/// Collects parts of pages that planes may touch.
pub struct PageFootprint<'a> {
    /// Sides of voxels, by level.
    sides: Vec<Sides>,
    heights: HeightCode,
    strides: Strides,
    /// Ground distance up to which bare ground is seen, metres.
    bare_until: f64,
    /// Height that no surface reaches, metres above the datum.
    ceiling: f64,
    /// Every ray that goes down meets the surface: no voxel of the area is empty.
    is_opaque: bool,
    surface: CoarseSurface<'a>,
    needs: Needs<'a>,
    displacement: Option<&'a Displacement>,
}

/// Slopes below which nothing is seen behind a ring, metres of height per unit of major distance.
#[derive(Debug, Clone, Copy)]
struct Horizon {
    /// Tangent of the lowest surface that may be there.
    sure: f64,
    /// Tangent of a surface [so far](LIKELY) from the lowest to the highest.
    likely: f64,
}

/// Whether something of a ring is seen.
#[derive(Debug, Clone, Copy)]
struct FootprintSegment {
    /// Whether the surface may rise above the sure horizon.
    may_be: bool,
    /// And above the likely one.
    is_likely: bool,
}

impl<'a> PageFootprint<'a> {
    /// Builds the footprint of planes over `source` that read lines as far apart as `strides` says, and see bare ground up to a ground distance, metres.
    pub fn new(source: &'a dyn PageSource, strides: Strides, bare_until: f64) -> Self {
        let header = source.header();
        Self {
            sides: (0..header.level_count).map(|level| Sides::new(&header.grid, level)).collect(),
            heights: header.heights,
            strides,
            bare_until,
            ceiling: header.height_range.high + header.heights.scale,
            is_opaque: header.metadata.empty_share == 0.0,
            surface: CoarseSurface::new(source),
            needs: Needs::new(source),
            displacement: None,
        }
    }

    /// The same over displaced ground.
    #[must_use]
    pub fn displaced(self, displacement: Option<&'a Displacement>) -> Self {
        let ceiling = self.ceiling + displacement.map_or(0.0, |displacement| displacement.bound(0.0));
        Self { displacement, ceiling, ..self }
    }

    /// Returns a bound of how far ground is displaced at a major distance or beyond, metres.
    fn lift(&self, distance: f64) -> f64 {
        self.displacement.map_or(0.0, |displacement| displacement.bound(distance))
    }

    /// Adds what groups of planes, neighbours in order, may touch from `eye` (units, units, metres).
    ///
    /// # Errors
    /// A page with bounds that is damaged.
    pub fn add(&mut self, eye: DVec3, groups: &[FootprintGroup]) -> Result<()> {
        let is_same = |a: &FootprintGroup, b: &FootprintGroup| {
            a.group.major == b.group.major && a.group.forward == b.group.forward
        };
        for side in groups.chunk_by(is_same) {
            for groups in side.chunks(WEDGE) {
                let wedge = Wedge::new(groups, self.ceiling - eye.z);
                self.needs.next_wedge();
                self.sweep(eye, &wedge)?;
            }
        }
        Ok(())
    }

    /// Adds pages whose materials are looked at before planes march.
    pub fn add_materials(&mut self, pages: &[PageId]) {
        self.needs.add_materials(pages);
    }

    /// The parts of pages as planes come to them: those that are likely to be touched, then the others; of both wedge by wedge, and the nearest of
    /// each first.
    pub fn into_needs(mut self) -> PageNeeds {
        self.needs.add_coarsest_bounds();
        self.needs.into_page_needs()
    }

    fn sweep(&mut self, eye: DVec3, wedge: &Wedge) -> Result<()> {
        let (nearest, farthest) = (wedge.over[0].max(wedge.begin), wedge.over[1]);
        let ceiling = self.ceiling - eye.z;
        let top = wedge.slopes[1];
        let coarsest = self.coarsest();
        let mut horizon = Horizon { sure: wedge.slopes[0], likely: wedge.slopes[0] };
        let mut before = FootprintSegment { may_be: true, is_likely: true };
        let mut at = nearest;
        let strides = self.strides.clone();
        let mut rings = Rings::new(&strides, eye, wedge, nearest);

        while at < farthest {
            if horizon.sure >= top || horizon.sure >= 0.0 && ceiling < horizon.sure * at {
                break;
            }

            let ring = rings.next_ring();
            let skip_level = ring.skip_level.min(coarsest);
            let segment = self.segment(eye, wedge, &ring, horizon)?;

            // A segment that ends in a hidden block began before.
            if segment.may_be || before.may_be {
                for level in ring.levels[0]..=ring.levels[1] {
                    let [from, to] = rings.part_of_level(&ring, level);
                    let is_likely = segment.is_likely || before.is_likely;
                    let need = Need { level, what: What::Posts, from, to, margins: MARGINS, is_likely };
                    self.needs.add(eye, wedge, &self.sides, need);
                }
            }

            // What stands may rise above all surfaces, and bare ground lies below them.
            let is_bare = ring.from * wedge.ground[0] < self.bare_until && ring.levels[0] == 0;
            if is_bare {
                let Ring { from, to, .. } = ring;
                let need =
                    Need { level: 0, what: What::Standing, from, to, margins: MARGINS, is_likely: true };
                self.needs.add(eye, wedge, &self.sides, need);
            }

            // Whose bounds the march looks at.
            for level in (ring.levels[0] + 2).min(skip_level)..=skip_level {
                let Ring { from, to, .. } = ring;
                let need = Need { level, what: What::Bounds, from, to, margins: MARGINS, is_likely: true };
                self.needs.add(eye, wedge, &self.sides, need);
            }

            before = segment;
            // What lies below the horizon does not raise it.
            if segment.may_be && self.is_opaque && !is_bare {
                horizon = self.raised(eye, wedge, &ring, horizon)?;
            }

            at = ring.to;
        }

        Ok(())
    }

    /// Index of the coarsest level.
    fn coarsest(&self) -> u8 {
        self.sides.len() as u8 - 1
    }

    fn height(&self, code: u16) -> f64 {
        self.heights.offset + self.heights.scale * f64::from(code)
    }

    /// Whether something in a ring may rise above the horizon, and whether it is likely to, seen with the march's own bounds.
    fn segment(
        &mut self,
        eye: DVec3,
        wedge: &Wedge,
        ring: &Ring,
        horizon: Horizon,
    ) -> Result<FootprintSegment> {
        let unknown = FootprintSegment { may_be: true, is_likely: true };
        let level = ring.skip_level.min(self.coarsest());
        if ring.block > MOST_VOXELS as f64 * f64::from(Grid::side_units(level)) {
            return Ok(unknown);
        }
        let Some([_, high]) = self.range(eye, wedge, [ring.from, ring.to], level)? else {
            return Ok(unknown);
        };
        let z = self.height(high) + self.lift(ring.from) - eye.z;
        let rises = |horizon: f64| {
            let above = |distance: f64| z - wedge.drop[0] * distance * distance >= horizon * distance;
            high != HeightCode::EMPTY && (above(ring.from) || above(ring.to))
        };
        Ok(FootprintSegment { may_be: rises(horizon.sure), is_likely: rises(horizon.likely) })
    }

    /// The horizon behind a ring: the lowest surface of each strip of some lines stands before it, and likely one between lowest and highest.
    fn raised(&mut self, eye: DVec3, wedge: &Wedge, ring: &Ring, horizon: Horizon) -> Result<Horizon> {
        let mut horizon = horizon;
        let level = (ring.levels[0] + 2).min(self.coarsest());
        let side = f64::from(Grid::side_units(level));
        let least = SURE * f64::from(Grid::side_units(ring.levels[1]));
        let below = self.heights.offset - eye.z;
        let own = self.sides[usize::from(level)];
        let page = self.surface.page_of(level, wedge.voxels(eye, &own, [ring.from, ring.to], [0.0; 2]))?;
        let mut from = ring.from;
        let mut by_from = 1.0 / from.max(f64::MIN_POSITIVE);

        for edge in edges_after(eye[wedge.major], wedge.forward, side, from) {
            let to = edge.min(ring.to);
            let by_to = 1.0 / to;
            let is_sure = to - from >= least && from >= wedge.inner[0] && to <= wedge.inner[1];
            let voxels = wedge.voxels_of_strip(eye, &own, [from, to]);

            if is_sure
                && let Some([low, high]) = match page {
                    Some(page) => range_on_page(&page, voxels),
                    None => self.surface.range(level, voxels)?,
                }
                && low != HeightCode::EMPTY
            {
                let drop = below - self.lift(from) - wedge.drop[1] * to * to;
                let slope = |code: f64| {
                    let z = self.heights.scale * code + drop;
                    (z * by_from).min(z * by_to)
                };
                let [low, high] = [low, high].map(f64::from);
                horizon.sure = horizon.sure.max(slope(low));
                horizon.likely = horizon.likely.max(slope((high - low).mul_add(LIKELY, low)));
            }

            if to >= ring.to {
                break;
            }

            (from, by_from) = (to, by_to);
        }

        Ok(horizon)
    }

    /// Least lower and greatest upper bound between two major distances, of voxels of `level`; `None` where not all are known.
    fn range(&mut self, eye: DVec3, wedge: &Wedge, ends: [f64; 2], level: u8) -> Result<Option<[u16; 2]>> {
        let voxels = wedge.voxels(eye, &self.sides[usize::from(level)], ends, [0.0; 2]);
        self.surface.range(level, voxels)
    }
}
