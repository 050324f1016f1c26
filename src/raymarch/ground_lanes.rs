//! Ground under sixteen rays at once: where they meet it, and how it lies there.
//!
//! ```text
//! for each page of the level that is seen where the rays are:
//!     above = ray − bilinear surface, at the range that planes found
//!     secants until it is next to nothing
//! for each page of the two levels that enclose a pixel there:
//!     gradient = central differences over two posts
//! ```
//!
//! [`SurfaceFilter`](super::SurfaceFilter) does the same for one ray in double precision. What is no plain ground is left to it: voids, absent and damaged
//! pages, the edge of the area, and rays that do not meet the surface near where it was found, or in another band of levels.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::{GridRay, LevelBands, PageCursor};
use crate::earth::Curvature;
use crate::simd::{Each, Floats, Ints, Isa, Kernel, LANES, Mask, Simd, Sixteen, math};
use crate::voxel::{APRON, Attributes, Grid, HeightCode, PAGE_SIDE, PageId, PageSource, RADIX};
use hedgehop_base::error::Result;

/// Height above the surface at which a ray has met it, metres.
pub const NEAR_ENOUGH: f64 = 2.0e-4;

/// Growth of [`NEAR_ENOUGH`] for each metre of range, metres.
pub const NEAR_ENOUGH_PER_METRE: f64 = 2.0e-5;

/// Most secants from where planes met the surface to where a ray does.
pub const MOST_SECANTS: usize = 5;

/// Farthest way from there to here, pixels wide: rays that graze more are followed.
pub const MOST_PIXELS_ALONG: f64 = 16.0;

/// Cells beside a page up to which its apron tells the surface.
const BESIDE: f32 = 2.0;

/// Rays of sixteen pixels from one eye, and the ranges that planes found for them.
#[derive(Debug, Clone, Default)]
pub struct RayLanes {
    /// Change per metre of range: units eastward, units northward, metres upward.
    pub slope: [Sixteen; 3],
    /// Range, metres, positive.
    pub range: Sixteen,
    /// Lanes that are to be looked along, by bits; the others hold nothing.
    pub lanes: u16,
}

impl RayLanes {
    /// Has a lane look along a ray for which planes found a range, metres.
    pub fn put(&mut self, lane: usize, ray: &GridRay, range: f32) {
        self.lanes |= 1 << lane;
        self.range.0[lane] = range;
        for axis in 0..3 {
            self.slope[axis].0[lane] = ray.slope[axis] as f32;
        }
    }
}

/// Ground that rays met.
#[derive(Debug, Clone, Default)]
pub struct MetGround {
    /// Lanes that met it, by bits; the others hold nothing.
    pub lanes: u16,
    /// Range, metres.
    pub range: Sixteen,
    /// Unit normal, world space (x east, y north, z up).
    pub normal: [Sixteen; 3],
    /// Level index that is seen.
    pub level: [i32; LANES],
    /// Attributes of the voxel of that level.
    pub attributes: [Attributes; LANES],
}

/// Looks along sixteen rays from one eye.
pub struct GroundLanes<'a> {
    source: &'a dyn PageSource,
    grid: Grid,
    heights: HeightCode,
    bands: LevelBands,
    /// The eye: units, units, metres.
    eye: DVec3,
    /// Angle between pixels, radians.
    pixel: f32,
    /// Fall of the ground per square of the distance, 1/metres.
    fall: f32,
    coarsest: u8,
    cursors: [PageCursor<'a>; 2],
}

/// Heights of a page, as lanes look them up.
struct PagePatch<'p> {
    heights: &'p [u16],
    /// Posts along a row and rows, aprons included.
    stride: i32,
    rows: i32,
    /// Position of the eye from the page's first post, posts.
    eye: [f32; 2],
    /// Posts per unit.
    per_unit: f32,
    /// Cells, eastward and northward, over which the surface and its gradient are known, among those that the page itself has.
    cells: [Range<i64>; 2],
    /// Code next to the eye's height, that height above the eye, metres, and a step of height.
    datum: f32,
    base: f32,
    step: f32,
}

/// Places of sixteen rays on a page: the cell's first post, and how far from it.
struct PlaceLanes<V: Simd> {
    cell: [V::F; 2],
    within: [V::F; 2],
}

impl<'a> GroundLanes<'a> {
    /// Over `source`, seen in `bands` from an eye (units, units, metres) by pixels `pixel` radians wide.
    pub fn new(
        source: &'a dyn PageSource,
        bands: LevelBands,
        curvature: Curvature,
        eye: DVec3,
        pixel: f64,
    ) -> Self {
        let header = source.header();
        let cursor = || PageCursor::new(source);
        Self {
            source,
            grid: header.grid,
            heights: header.heights,
            bands,
            eye,
            pixel: pixel as f32,
            fall: curvature.inverse_diameter as f32,
            coarsest: header.level_count - 1,
            cursors: [cursor(), cursor().on_bare_ground()],
        }
    }

    /// Finds where rays meet the ground near the ranges that planes found.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn meet(&mut self, isa: Isa, rays: &RayLanes, met: &mut MetGround) -> Result<()> {
        met.lanes = 0;
        if rays.lanes == 0 {
            return Ok(());
        }
        isa.run(Meeting { ground: self, rays, met })
    }

    /// Returns a page's heights about a cell of a level's surface; `None` where it is absent, damaged or without room for a gradient.
    fn patch(&mut self, sheet: usize, level: u8, cell: [i64; 2]) -> Result<Option<PagePatch<'a>>> {
        let cursor = &mut self.cursors[sheet];
        let dims = cursor.dims(level);
        if cell.iter().zip(dims).any(|(cell, dim)| !(0..dim).contains(cell)) {
            return Ok(None);
        }
        let Some((view, first)) = cursor.heights_about(level, cell)? else { return Ok(None) };
        let [px, py] = first.each(|at| (at / i64::from(PAGE_SIDE)) as u32);
        // The finest surface may stand in for bare ground that is damaged.
        if sheet == 1 && self.source.is_damaged(PageId { level, px, py }.bare()) {
            return Ok(None);
        }

        let side = f64::from(Grid::side_units(level));
        let stride = view.width + 2 * APRON;
        let rows = view.heights.len() as u32 / stride;
        let sizes = [view.width, rows - 2 * APRON].each(i64::from);
        let eye = self.eye.truncate().to_array();
        let HeightCode { offset, scale } = self.heights;
        let datum = ((self.eye.z - offset) / scale).round().clamp(0.0, f64::from(u16::MAX));
        // The page's own cells, but for those about which posts lie beyond the area.
        let cells =
            |axis: usize| (1 - first[axis]).max(0)..sizes[axis].min((dims[axis] - 2 - first[axis]).max(0));
        Ok(Some(PagePatch {
            heights: view.heights,
            stride: stride as i32,
            rows: rows as i32,
            eye: [0, 1].each(|axis| (eye[axis] / side - 0.5 - first[axis] as f64) as f32),
            per_unit: (1.0 / side) as f32,
            cells: [cells(0), cells(1)],
            datum: datum as f32,
            base: (offset + scale * datum - self.eye.z) as f32,
            step: scale as f32,
        }))
    }

    /// Returns the ground distances between which a level of a sheet is seen, metres.
    fn band(&self, sheet: usize, level: u8) -> [f32; 2] {
        let bare_until = self.bands.bare_until();
        let [from, until] = if sheet == 0 { [bare_until, f64::INFINITY] } else { [0.0, bare_until] };
        let own = self.bands.iter().find(|(index, ..)| *index == level);
        own.map_or([0.0; 2], |(_, start, end)| [start.max(from) as f32, end.min(until) as f32])
    }
}

impl PagePatch<'_> {
    /// Returns the places of rays at ranges.
    #[inline(always)]
    fn places<V: Simd>(&self, simd: V, slope: [V::F; 2], range: V::F) -> PlaceLanes<V> {
        let posts = range * simd.splat(self.per_unit);
        let at = [0, 1].each(|axis| slope[axis].mul_add(posts, simd.splat(self.eye[axis])));
        let cell = at.each(|at| at.floor());
        PlaceLanes { cell, within: [0, 1].each(|axis| at[axis] - cell[axis]) }
    }

    /// Lanes that are over the page's own cells, within `more` of them.
    #[inline(always)]
    fn holds<V: Simd>(&self, simd: V, places: &PlaceLanes<V>, more: f32) -> V::M {
        let [east, north] = [0, 1].each(
            #[inline(always)]
            |axis| {
                let Range { start, end } = self.cells[axis];
                let cell = places.cell[axis];
                simd.splat(start as f32 - more).le(cell) & cell.lt(simd.splat(end as f32 + more))
            },
        );
        east & north
    }

    /// Codes of two posts beside each other, from those of places `aside` posts eastward and `up` northward of a cell's first on.
    #[inline(always)]
    fn pair<V: Simd>(&self, simd: V, places: &PlaceLanes<V>, [aside, up]: [i32; 2]) -> [V::F; 2] {
        let [x, y] = places.cell.each(Floats::to_int);
        let row = y + simd.splat_int(up + APRON as i32);
        let row = row.max(simd.splat_int(0)).min(simd.splat_int(self.rows - 1));
        let index = row.mul(simd.splat_int(self.stride)) + x + simd.splat_int(aside + APRON as i32);
        let pair = simd.gather_pairs(self.heights, index);
        [(pair & simd.splat_int(0xffff)).to_float(), pair.shr::<16>().to_float()]
    }

    /// Returns heights at places, metres above the eye, and lanes where there are any.
    #[inline(always)]
    fn heights<V: Simd>(&self, simd: V, places: &PlaceLanes<V>) -> (V::F, V::M) {
        let [[sw, se], [nw, ne]] = [0, 1].each(
            #[inline(always)]
            |up| self.pair(simd, places, [0, up]),
        );
        let is_known = simd.splat(0.0).lt(sw.min(se).min(nw.min(ne)));
        let [[sw, se], [nw, ne]] =
            [[sw, se], [nw, ne]].each(|row| row.each(|code| code - simd.splat(self.datum)));
        let [u, v] = places.within;
        let south = (se - sw).mul_add(u, sw);
        let north = (ne - nw).mul_add(u, nw);
        let code = (north - south).mul_add(v, south);
        let height = code.mul_add(simd.splat(self.step), simd.splat(self.base));
        (height, is_known)
    }

    /// Returns gradients at places, codes per post eastward and northward, and lanes where there are any.
    #[inline(always)]
    fn gradients<V: Simd>(&self, simd: V, places: &PlaceLanes<V>) -> ([V::F; 2], V::M) {
        let middle = [0, 1].each(
            #[inline(always)]
            |up| (self.pair(simd, places, [-1, up]), self.pair(simd, places, [1, up])),
        );
        let [below, above] = [-1, 2].each(
            #[inline(always)]
            |up| self.pair(simd, places, [0, up]),
        );
        let [u, v] = places.within;
        let half = simd.splat(0.5);

        let east = middle.each(
            #[inline(always)]
            |([west, own], [next, after])| {
                let (here, there) = (next - west, after - own);
                (there - here).mul_add(u, here)
            },
        );
        let [own, next] = middle.each(
            #[inline(always)]
            |([_, own], [next, _])| [own, next],
        );
        let mut least = below[0].min(below[1]).min(above[0].min(above[1]));
        for ([west, own], [next, after]) in middle {
            least = least.min(west.min(own)).min(next.min(after));
        }
        let [below, own, next, above] = [below, own, next, above].each(
            #[inline(always)]
            |row| (row[1] - row[0]).mul_add(u, row[0]),
        );
        let north = [next - below, above - own];

        let gradients = [east, north].each(
            #[inline(always)]
            |[low, high]| (high - low).mul_add(v, low) * half,
        );
        (gradients, simd.splat(0.0).lt(least))
    }
}

/// Sixteen rays over a page.
struct RaysOver<V: Simd> {
    /// Change per metre of range: units eastward and northward, metres upward; and per square of it.
    ground: [V::F; 2],
    up: V::F,
    bend: V::F,
}

impl<V: Simd> RaysOver<V> {
    /// Returns how high the rays are above the surface at ranges, metres, and lanes where that is known.
    #[inline(always)]
    fn above(&self, simd: V, patch: &PagePatch<'_>, range: V::F) -> (V::F, V::M) {
        let places = patch.places(simd, self.ground, range);
        let (height, is_known) = patch.heights(simd, &places);
        let ray = range.mul_add(self.bend, self.up) * range;
        (ray - height, is_known & patch.holds(simd, &places, BESIDE))
    }
}

/// Returns heights above the surface at which rays have met it at ranges, metres.
#[inline(always)]
fn near_enough<V: Simd>(simd: V, range: V::F) -> V::F {
    range.mul_add(simd.splat(NEAR_ENOUGH_PER_METRE as f32), simd.splat(NEAR_ENOUGH as f32))
}

/// Search along sixteen rays.
struct Meeting<'m, 'a> {
    ground: &'m mut GroundLanes<'a>,
    rays: &'m RayLanes,
    met: &'m mut MetGround,
}

impl Kernel for Meeting<'_, '_> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Simd>(mut self, simd: V) -> Result<()> {
        let GroundLanes { grid, pixel, bands, coarsest, .. } = &*self.ground;
        let (spacing, pixel, coarsest) = (grid.spacing as f32, *pixel, *coarsest);
        let [east, north, _] = self.rays.slope.each_ref().each(|slope| simd.load(&slope.0));
        let range = simd.load(&self.rays.range.0);
        let cosine = east.mul_add(east, north * north).sqrt() * simd.splat(spacing);

        // Levels that are seen there.
        let distance = range * cosine;
        let mut level = simd.splat_int(0);
        for (index, start, _) in bands.iter() {
            level = simd.splat_int(i32::from(index)).select(simd.splat(start as f32).le(distance), level);
        }
        let is_bare = distance.lt(simd.splat(bands.bare_until() as f32)).bits();
        level.store(&mut self.met.level);
        range.store(&mut self.met.range.0);
        self.met.lanes = 0;
        for (sheet, lanes) in [!is_bare, is_bare].into_iter().enumerate() {
            self.meet(simd, sheet, self.rays.lanes & lanes, cosine)?;
        }

        // Blended between the two levels that enclose a pixel, as the light of the ground is.
        let width = simd.load(&self.met.range.0) * simd.splat(pixel / spacing);
        let per_level = 1.0 / f32::from(RADIX as u16).log2();
        let position = math::log2(simd, width.max(simd.splat(1.0))) * simd.splat(per_level);
        let position = position.min(simd.splat(f32::from(coarsest)));
        let fine = position.floor();
        self.lie(simd, fine, position - fine, is_bare)
    }
}

impl<'a> Meeting<'_, 'a> {
    /// Finds where `lanes` meet the surface, or bare ground, whichever the `sheet` is.
    #[inline(always)]
    fn meet<V: Simd>(&mut self, simd: V, sheet: usize, mut lanes: u16, cosine: V::F) -> Result<()> {
        let [east, north, up] = self.rays.slope.each_ref().each(|slope| simd.load(&slope.0));
        let range = simd.load(&self.rays.range.0);
        let pixel = range * simd.splat(self.ground.pixel);
        let levels = simd.load_ints(&self.met.level);

        let bend = cosine * cosine * simd.splat(self.ground.fall);
        let rays = RaysOver::<V> { ground: [east, north], up, bend };

        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let level = self.met.level[lane] as u8;
            let Some(patch) = self.patch(sheet, level, lane, self.rays.range.0[lane])? else { continue };
            let places = patch.places(simd, [east, north], range);
            let here = patch.holds(simd, &places, 0.0) & levels.eq(simd.splat_int(i32::from(level)));
            let here = here.bits() & (lanes | 1 << lane);
            lanes &= !here;

            // Secants, the first one a pixel long: on a facet the way down is nearly straight.
            let (mut at, zero) = (range, simd.splat(0.0));
            let (mut over, is_known) = rays.above(simd, &patch, at);
            let mut meets = simd.mask(here) & is_known & over.abs().le(pixel);
            let mut step = (zero - pixel).select(over.lt(zero), pixel);
            for _ in 1..MOST_SECANTS {
                let moves = meets & near_enough(simd, at).lt(over.abs());
                if !moves.any() {
                    break;
                }
                let next = at + step;
                let (next_over, is_known) = rays.above(simd, &patch, next);
                step = step * next_over / (over - next_over);
                let is_near = (next + step - range).abs().le(pixel * simd.splat(MOST_PIXELS_ALONG as f32));
                meets = meets & (!moves | (is_known & is_near));
                (at, over) = (next.select(moves, at), next_over.select(moves, over));
            }
            meets = meets & over.abs().le(near_enough(simd, at));

            // A wall may stand where the way crossed into another band of levels.
            let [from, until] = self.ground.band(sheet, level).each(|end| simd.splat(end));
            let distance = at * cosine;
            meets = meets & from.le(distance) & distance.lt(until);
            at.store_masked(meets, &mut self.met.range.0);
            self.met.lanes |= meets.bits();
        }

        Ok(())
    }

    /// Finds how the ground lies where it was met, between levels `fine` and the next coarser ones by `share`; and of what it is.
    #[inline(always)]
    fn lie<V: Simd>(&mut self, simd: V, fine: V::F, share: V::F, is_bare: u16) -> Result<()> {
        let range = simd.load(&self.met.range.0);
        let [east, north] = [0, 1].each(|axis| simd.load(&self.rays.slope[axis].0));
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let mut gradient = [zero; 2];

        for level in 0..=self.ground.coarsest {
            let is_fine = fine.to_int().eq(simd.splat_int(i32::from(level)));
            let is_coarse = fine.to_int().eq(simd.splat_int(i32::from(level) - 1));
            let weight = (one - share).select(is_fine, share.select(is_coarse, zero));
            let asked = zero.lt(weight).bits() & self.met.lanes;
            let per_code = self.ground.heights.scale / self.ground.grid.side(level);

            for (sheet, lanes) in [!is_bare, is_bare].into_iter().enumerate() {
                let mut lanes = asked & lanes;
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    let Some(patch) = self.patch(sheet, level, lane, self.met.range.0[lane])? else {
                        self.met.lanes &= !(1 << lane);
                        continue;
                    };
                    let places = patch.places(simd, [east, north], range);
                    let (found, is_known) = patch.gradients(simd, &places);
                    let here = patch.holds(simd, &places, 0.0).bits() & (lanes | 1 << lane);
                    // Rays without a gradient are left to the scalar filter, as is one that lies beside the page by rounding.
                    self.met.lanes &= !(here & !is_known.bits() | (1 << lane) & !here);
                    lanes &= !here;
                    let weight = (weight * simd.splat(per_code as f32)).select(simd.mask(here), zero);
                    gradient = [0, 1].each(|axis| found[axis].mul_add(weight, gradient[axis]));
                }
            }
        }

        let [east, north] = gradient;
        let upward = east.mul_add(east, north.mul_add(north, one)).rsqrt();
        for (normal, part) in
            self.met.normal.iter_mut().zip([(zero - east) * upward, (zero - north) * upward, upward])
        {
            part.store(&mut normal.0);
        }

        self.tell(is_bare)
    }

    /// Finds the attributes of the voxels that were met.
    #[inline(always)]
    fn tell(&mut self, is_bare: u16) -> Result<()> {
        let mut lanes = self.met.lanes;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let level = self.met.level[lane] as u8;
            let at = self.units(lane, self.met.range.0[lane]) / f64::from(Grid::side_units(level));
            let cursor = &mut self.ground.cursors[usize::from(is_bare >> lane & 1)];
            // They lie within the area, so that this rounds down.
            match cursor.stored_attributes(level, [at.x as i64, at.y as i64])? {
                Some(attributes) => self.met.attributes[lane] = attributes,
                None => self.met.lanes &= !(1 << lane),
            }
        }
        Ok(())
    }

    /// Returns where a ray is at a range, units.
    #[inline(always)]
    fn units(&self, lane: usize, range: f32) -> DVec2 {
        let [east, north] = [0, 1].each(|axis| f64::from(self.rays.slope[axis].0[lane]));
        self.ground.eye.truncate() + f64::from(range) * DVec2::new(east, north)
    }

    /// Returns the page under a lane.
    #[inline(always)]
    fn patch(&mut self, sheet: usize, level: u8, lane: usize, range: f32) -> Result<Option<PagePatch<'a>>> {
        let at = self.units(lane, range) / f64::from(Grid::side_units(level)) - 0.5;
        self.ground.patch(sheet, level, [at.x.floor() as i64, at.y.floor() as i64])
    }
}
