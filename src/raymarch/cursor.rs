//! Reading voxels through the page that was read last, per level.

use glam::DVec2;

use super::walk::{Extent, Lattice};
use crate::voxel::{
    APRON, Attributes, BoundsView, Grid, HeightCode, HeightsView, PAGE_SIDE, PageId, PageSource, PageView,
};
use hedgehop_base::error::Result;

/// Reads the planes of a [`PageSource`]; looks a page up only when a read leaves the last one.
pub struct PageCursor<'a> {
    source: &'a dyn PageSource,
    heights: HeightCode,
    slots: Vec<CursorSlot<'a>>,
    endless: bool,
    /// Bare ground is read in place of the finest surface.
    bare: bool,
}

/// The pages of one level that were read last.
struct CursorSlot<'a> {
    /// Voxels (eastward, northward) of the level.
    dims: [i64; 2],
    /// Lattice of the page's voxels, and the cells between their posts.
    voxels: Lattice,
    cells: Lattice,
    /// Latest pages' heights, posts with all that is seen of them, and bounds.
    heights: LatestPage<HeightsView<'a>>,
    posts: LatestPage<PageView<'a>>,
    bounds: LatestPage<BoundsView<'a>>,
}

/// The page to read in place of `id`: of bare ground, if that `is_wanted` and there is one.
fn sheet(source: &dyn PageSource, is_wanted: bool, id: PageId) -> PageId {
    if is_wanted && id.level == 0 { source.ground_of(id.bare()) } else { id }
}

/// The page that was read last.
struct LatestPage<V> {
    /// First voxel of the page; before the area while no page has been read.
    first: [i64; 2],
    /// Voxels of the page (eastward, northward); 0 while no page has been read.
    size: [i64; 2],
    view: Option<V>,
}

/// A voxel's place in a page.
struct ApronPlace {
    /// Voxels eastward of the page.
    width: u32,
    /// Column and row within the page; −1 is the apron.
    x: i64,
    y: i64,
}

/// A plane with apron, and a voxel's place in it.
type ApronSamples<'a, T> = (&'a [T], ApronPlace);

impl<'a> CursorSlot<'a> {
    fn new(grid: &Grid, level: u8, endless: bool) -> Self {
        let (nx, ny) = grid.dims(level);
        let dims = [i64::from(nx), i64::from(ny)];
        let sides = [f64::from(grid.nx), f64::from(grid.ny)];
        let lattice = |first: i64, shift: f64| {
            let period = if endless { sides } else { [f64::INFINITY; 2] };
            let spans = [0, 1]
                .map(|axis| Extent { period: period[axis], ..Extent::once(first, dims[axis] - 1, 0.0) });
            Lattice { side: f64::from(Grid::side_units(level)), shift, spans }
        };
        let (voxels, cells) = (lattice(0, 0.0), lattice(if endless { 0 } else { -1 }, 0.5));
        Self {
            dims,
            voxels,
            cells,
            heights: LatestPage::NONE,
            posts: LatestPage::NONE,
            bounds: LatestPage::NONE,
        }
    }
}

impl<V> LatestPage<V> {
    const NONE: Self = Self { first: [-1, -1], size: [0, 0], view: None };

    /// Returns the page that holds voxel `cell`, clamped into level index `level` of `dims` voxels (eastward, northward), and the
    /// voxel's column and row in it; `find` finds another page than the last.
    #[inline]
    fn at(
        &mut self,
        level: u8,
        dims: [i64; 2],
        cell: [i64; 2],
        find: impl FnOnce(PageId) -> Result<Option<V>>,
    ) -> Result<(Option<&V>, [i64; 2])> {
        let within = |latest: &Self| [0, 1].map(|axis| cell[axis] - latest.first[axis]);
        let place = within(self);
        if [0, 1].iter().all(|&axis| (0..self.size[axis]).contains(&place[axis])) {
            return Ok((self.view.as_ref(), place));
        }
        self.turn_to(level, dims, cell, find)?;
        Ok((self.view.as_ref(), within(self)))
    }

    #[cold]
    fn turn_to(
        &mut self,
        level: u8,
        dims: [i64; 2],
        cell: [i64; 2],
        find: impl FnOnce(PageId) -> Result<Option<V>>,
    ) -> Result<()> {
        let side = i64::from(PAGE_SIDE);
        let page = [0, 1].map(|axis| cell[axis].clamp(0, dims[axis] - 1) / side);
        let first = page.map(|index| index * side);
        if first != self.first {
            self.view = find(PageId { level, px: page[0] as u32, py: page[1] as u32 })?;
            self.size = [0, 1].map(|axis| (dims[axis] - first[axis]).min(side));
            self.first = first;
        }
        Ok(())
    }
}

impl<'a> PageCursor<'a> {
    /// A cursor over all levels of `source`.
    pub fn new(source: &'a dyn PageSource) -> Self {
        let header = source.header();
        let slots =
            (0..header.level_count).map(|level| CursorSlot::new(&header.grid, level, false)).collect();
        Self { source, heights: header.heights, slots, endless: false, bare: false }
    }

    /// The same over the area repeated without end.
    pub fn endless(self) -> Self {
        let header = self.source.header();
        let slots = (0..header.level_count).map(|level| CursorSlot::new(&header.grid, level, true)).collect();
        Self { slots, endless: true, ..self }
    }

    /// The same on bare ground: at level index 0 there is nothing that stands on it.
    pub fn on_bare_ground(self) -> Self {
        let has_spans = self.source.header().has_spans;
        Self { bare: has_spans, ..self }
    }

    /// The database.
    pub fn source(&self) -> &'a dyn PageSource {
        self.source
    }

    /// Whether the area repeats.
    pub fn is_endless(&self) -> bool {
        self.endless
    }

    /// The voxels of a level.
    pub fn voxels(&self, level: u8) -> Lattice {
        self.slots[usize::from(level)].voxels
    }

    /// The cells between the posts of a level. Without repetition there is one more at each edge, over the outer
    /// halves of the outermost voxels.
    pub fn cells(&self, level: u8) -> Lattice {
        self.slots[usize::from(level)].cells
    }

    /// Voxels (eastward, northward) of a level.
    pub fn dims(&self, level: u8) -> [i64; 2] {
        self.slots[usize::from(level)].dims
    }

    /// The page of voxel `cell`, clamped into the area, and the voxel's place in it; `None` where the page is absent.
    #[inline]
    fn posts(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<(&PageView<'a>, ApronPlace)>> {
        let CursorSlot { dims, posts, .. } = &mut self.slots[usize::from(level)];
        let (view, [x, y]) =
            posts.at(level, *dims, cell, |id| self.source.page(sheet(self.source, self.bare, id)))?;
        Ok(view.map(|view| (view, ApronPlace { width: view.width, x, y })))
    }

    /// The same of its heights alone: nothing else of the page is read.
    #[inline]
    fn heights(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<ApronSamples<'a, u16>>> {
        let CursorSlot { dims, heights, .. } = &mut self.slots[usize::from(level)];
        let (view, [x, y]) =
            heights.at(level, *dims, cell, |id| self.source.heights(sheet(self.source, self.bare, id)))?;
        Ok(view.map(|view| (view.heights, ApronPlace { width: view.width, x, y })))
    }

    /// The same of its colours.
    #[inline]
    fn colours(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<ApronSamples<'a, [u8; 3]>>> {
        Ok(self.posts(level, cell)?.map(|(view, place)| (view.colours, place)))
    }

    /// Upper bound of every finer surface over voxel `cell` of level index ≥ 1, metres: −∞ where
    /// there is none, +∞ where the page is absent.
    ///
    /// In an area that repeats, a surface near the seam also depends on posts beyond it, which the stored bound
    /// does not know. They lie in the voxel there or in its ring: its bound covers them.
    #[inline]
    pub fn upper_bound(&mut self, level: u8, cell: [i64; 2]) -> Result<f64> {
        let dims = self.dims(level);
        let is_inside = |axis: usize| cell[axis] > 0 && cell[axis] < dims[axis] - 1;
        if !self.is_endless() || (is_inside(0) && is_inside(1)) {
            return self.stored_bound(level, cell);
        }
        let beyond = [0, 1].map(|axis| match cell[axis] {
            0 => dims[axis] - 1,
            index if index == dims[axis] - 1 => 0,
            index => index,
        });
        let mut bound = f64::NEG_INFINITY;
        for voxel in [cell, [beyond[0], cell[1]], [cell[0], beyond[1]], beyond] {
            bound = bound.max(self.stored_bound(level, voxel)?);
        }
        Ok(bound)
    }

    #[inline]
    fn stored_bound(&mut self, level: u8, cell: [i64; 2]) -> Result<f64> {
        let heights = self.heights;
        let CursorSlot { dims, bounds, .. } = &mut self.slots[usize::from(level)];
        let (view, [x, y]) = bounds.at(level, *dims, cell, |id| self.source.bounds(id))?;
        let Some(view) = view else { return Ok(f64::INFINITY) };
        let code = view.high[y as usize * view.width as usize + x as usize];
        Ok(heights.decode(code).unwrap_or(f64::NEG_INFINITY))
    }

    /// Mean height of voxel `cell`, metres: `Some(None)` where there is no surface, `None` where the
    /// page is absent.
    pub fn height(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<Option<f64>>> {
        let found = self.heights(level, cell)?;
        Ok(found.map(|(codes, place)| self.heights.decode(codes[place.with_apron()])))
    }

    /// Heights at the corners (south-west, south-east, north-west, north-east) of the cell of the
    /// smooth surface between voxels `cell` and `cell + 1`, metres; NaN where there is no surface.
    /// `None` where a page of it is absent. `cell` may be −1, at the area's south or west edge, unless it repeats.
    #[inline]
    pub fn corners(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<[f64; 4]>> {
        let heights = self.heights;
        let codes = self.corner_samples(level, cell, Self::heights)?;
        Ok(codes.map(|codes| codes.map(|code| heights.decode(code).unwrap_or(f64::NAN))))
    }

    /// Greatest height at the corners of the cells from `low` to `high` (column, row), metres: −∞ where there is no surface, +∞ where a page of it is absent.
    pub fn highest_corner(&mut self, level: u8, low: [i64; 2], high: [i64; 2]) -> Result<f64> {
        let apron = i64::from(APRON);
        if let Some((plane, ApronPlace { width, x, y })) = self.heights(level, low)? {
            let stride = (width + 2 * APRON) as usize;
            let [columns, rows] = [high[0] - low[0] + 2, high[1] - low[1] + 2].map(|posts| posts as usize);
            let first = [x + apron, y + apron];
            // As a rule all are posts of one page.
            if first[0] >= 0 && first[1] >= 0 && first[0] as usize + columns <= stride {
                let from = first[1] as usize * stride + first[0] as usize;
                let code = (0..rows).try_fold(HeightCode::EMPTY, |highest, row| {
                    let line = plane.get(from + row * stride..)?.get(..columns)?;
                    Some(line.iter().fold(highest, |highest, code| highest.max(*code)))
                });
                if let Some(code) = code {
                    return Ok(self.heights.decode(code).unwrap_or(f64::NEG_INFINITY));
                }
            }
        }

        let mut highest = f64::NEG_INFINITY;
        for (y, x) in (low[1]..=high[1]).flat_map(|y| (low[0]..=high[0]).map(move |x| (y, x))) {
            let corners = self.corners(level, [x, y])?.unwrap_or([f64::INFINITY; 4]);
            highest = corners.into_iter().fold(highest, f64::max);
        }
        Ok(highest)
    }

    /// Colours at the same corners, sRGB.
    pub fn corner_colours(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<[[u8; 3]; 4]>> {
        self.corner_samples(level, cell, Self::colours)
    }

    /// The page of the south-western corner of a cell, and that corner's column and row in it, of which −1 is the apron; `None` where the page is absent, and in
    /// an area that repeats where the other corners lie beyond its seam.
    pub fn page_of_cell(
        &mut self,
        level: u8,
        cell: [i64; 2],
    ) -> Result<Option<(PageId, PageView<'a>, [i64; 2])>> {
        let dims = self.dims(level);
        if self.is_endless() && (cell[0] == dims[0] - 1 || cell[1] == dims[1] - 1) {
            return Ok(None);
        }
        let Some((view, place)) = self.posts(level, cell)? else { return Ok(None) };
        let (view, corner) = (*view, [place.x, place.y]);
        let [px, py] = [0, 1].map(|axis| ((cell[axis] - corner[axis]) / i64::from(PAGE_SIDE)) as u32);
        Ok(Some((sheet(self.source, self.bare, PageId { level, px, py }), view, corner)))
    }

    /// Samples of a plane with apron at the corners of a cell.
    #[inline]
    fn corner_samples<T: Copy + 'a>(
        &mut self,
        level: u8,
        cell: [i64; 2],
        find: impl Fn(&mut Self, u8, [i64; 2]) -> Result<Option<ApronSamples<'a, T>>>,
    ) -> Result<Option<[T; 4]>> {
        if self.is_endless() {
            let dims = self.dims(level);
            if cell[0] == dims[0] - 1 || cell[1] == dims[1] - 1 {
                return self.corners_at_seam(level, cell, find);
            }
        }
        let Some((plane, place)) = find(self, level, cell)? else { return Ok(None) };
        let [south, north] = place.corner_rows(plane);
        Ok(Some([south[0], south[1], north[0], north[1]]))
    }

    /// Colour of voxel `cell`, sRGB; `None` where the page is absent.
    pub fn colour(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<[u8; 3]>> {
        Ok(self.colours(level, cell)?.map(|(colours, place)| colours[place.with_apron()]))
    }

    /// The same one by one: at the area's edge, aprons repeat the edge itself, not what lies beyond the seam.
    #[cold]
    fn corners_at_seam<T: Copy + 'a>(
        &mut self,
        level: u8,
        [west, south]: [i64; 2],
        find: impl Fn(&mut Self, u8, [i64; 2]) -> Result<Option<ApronSamples<'a, T>>>,
    ) -> Result<Option<[T; 4]>> {
        let dims = self.dims(level);
        let (east, north) = ((west + 1) % dims[0], (south + 1) % dims[1]);
        let mut sample = |voxel| -> Result<Option<T>> {
            Ok(find(self, level, voxel)?.map(|(plane, place)| plane[place.with_apron()]))
        };
        let corners =
            (sample([west, south])?, sample([east, south])?, sample([west, north])?, sample([east, north])?);
        match corners {
            (Some(sw), Some(se), Some(nw), Some(ne)) => Ok(Some([sw, se, nw, ne])),
            _ => Ok(None),
        }
    }

    /// Attributes of the voxel of a level at a position in units, clamped into the area or repeated with it; where its page is
    /// absent, of the next coarser level.
    pub fn attributes_at(&mut self, level: u8, units: DVec2) -> Result<Attributes> {
        let (voxel, _) = self.voxels(level).cell_at(units);
        match self.stored_attributes(level, voxel)? {
            Some(attributes) => Ok(attributes),
            None if usize::from(level) + 1 < self.slots.len() => self.attributes_at(level + 1, units),
            None => Ok(Attributes::default()),
        }
    }

    /// Attributes of a voxel of a level, clamped into the area; `None` where its page is absent.
    pub fn stored_attributes(&mut self, level: u8, voxel: [i64; 2]) -> Result<Option<Attributes>> {
        let found = self.posts(level, voxel)?;
        Ok(found.map(|(view, place)| view.attributes_at(place.x as u32, place.y as u32)))
    }

    /// Heights of the page of voxel `cell`, which lies within the area, and the page's first voxel; `None` where the page is absent.
    pub fn heights_about(
        &mut self,
        level: u8,
        cell: [i64; 2],
    ) -> Result<Option<(HeightsView<'a>, [i64; 2])>> {
        let CursorSlot { dims, heights, .. } = &mut self.slots[usize::from(level)];
        let (view, [x, y]) =
            heights.at(level, *dims, cell, |id| self.source.heights(sheet(self.source, self.bare, id)))?;
        Ok(view.map(|view| (*view, [cell[0] - x, cell[1] - y])))
    }

    /// Whether the page that is to be seen at a level and a position in units is damaged and was left out, so that another stands in for it.
    pub fn is_damaged_at(&mut self, level: u8, units: DVec2) -> Result<bool> {
        let (voxel, _) = self.voxels(level).cell_at(units);
        let present = self.posts(level, voxel)?.is_some();
        let [px, py] =
            self.slots[usize::from(level)].posts.first.map(|first| (first / i64::from(PAGE_SIDE)) as u32);
        let id = PageId { level, px, py };
        // For bare ground that is left out the finest surface stands in.
        let is_bare_damaged = self.bare && level == 0 && self.source.is_damaged(id.bare());
        Ok(is_bare_damaged || (!present && self.source.is_damaged(id)))
    }
}

impl ApronPlace {
    /// Voxels along a row, the apron included.
    fn stride(&self) -> usize {
        (self.width + 2 * APRON) as usize
    }

    /// Index of the voxel in a plane with apron.
    fn with_apron(&self) -> usize {
        (self.y + i64::from(APRON)) as usize * self.stride() + (self.x + i64::from(APRON)) as usize
    }

    /// The voxel and its eastern neighbour, and the two north of them, in a plane with apron.
    fn corner_rows<'p, T>(&self, plane: &'p [T]) -> [&'p [T]; 2] {
        let south = self.with_apron();
        let north = south + self.stride();
        [&plane[south..south + 2], &plane[north..north + 2]]
    }
}
