//! The finer voxels that a coarse page is made from.
//!
//! ```text
//! for each finer page under the coarse one, its apron and a ring around it:
//!     it is stored   → its voxels; those of its apron beside it where the neighbour is absent
//!     it is absent   → made by the stand-in, for means and slopes; or nothing, where the stand-in's coarse page says as much
//! ```
//!
//! All of it is a function of place and of which finer pages are stored, never of the page that is made: aprons agree.

use std::ops::Range;

use super::relief::half_steps;
use super::{
    APRON, AlignedBytes, Attributes, FileBytes, Grid, HeightCode, PAGE_SIDE, PageBuffer, PageId,
    PageReadback, PageStore, PageView, RADIX,
};
use hedgehop_base::Size;
use hedgehop_base::error::Result;

/// Source of finer levels' pages while coarser ones are made.
pub trait FinerPages {
    /// The page, in place or read into `scratch`; `None` if it is absent.
    fn finer_page<'a>(&'a self, id: PageId, scratch: &'a mut AlignedBytes) -> Result<Option<PageView<'a>>>;

    /// Attributes of all voxels of a page without any surface, if it is known for one without looking at it.
    fn known_empty(&self, id: PageId) -> Option<Attributes> {
        let _ = id;
        None
    }
}

impl FinerPages for PageReadback {
    fn finer_page<'a>(&'a self, id: PageId, scratch: &'a mut AlignedBytes) -> Result<Option<PageView<'a>>> {
        self.page_into(id, scratch)
    }

    fn known_empty(&self, id: PageId) -> Option<Attributes> {
        self.entry(id)?.empty().copied()
    }
}

impl<B: FileBytes> FinerPages for PageStore<B> {
    fn finer_page<'a>(&'a self, id: PageId, _: &'a mut AlignedBytes) -> Result<Option<PageView<'a>>> {
        self.whole_page(id)
    }

    fn known_empty(&self, id: PageId) -> Option<Attributes> {
        self.directory().get(id)?.empty().copied()
    }
}

/// Voxels of one level, columns `x` and rows `y` of the whole level. Planes are `[rows][columns]`.
#[derive(Debug, Clone)]
pub struct VoxelBlock {
    /// Columns, counted eastward.
    pub x: Range<u32>,
    /// Rows, counted northward.
    pub y: Range<u32>,
    /// Height codes.
    pub heights: Vec<u16>,
    /// sRGB-encoded colours.
    pub colours: Vec<[u8; 3]>,
    /// Attributes.
    pub attributes: Vec<Attributes>,
}

/// Source of a coarse page where finer ones are absent.
pub trait StandIn {
    /// Makes what the absent page `id` would say in columns `x` and rows `y` of its level; `None` where that is no more than
    /// [`Self::page`] says.
    fn finer(&mut self, id: PageId, x: Range<u32>, y: Range<u32>) -> Result<Option<VoxelBlock>>;

    /// The coarse page itself, as if there were no finer level: its heights, colours and attributes are taken where
    /// [`Self::finer`] has none, and its relief, unless that is empty.
    fn page(&mut self, id: PageId) -> Result<PageBuffer>;
}

/// Finer pages that a page of a coarser level is made from, as far as they are stored; none of level index 0 and of bare ground.
pub fn finer_pages(grid: &Grid, id: PageId) -> impl Iterator<Item = PageId> + use<> {
    WindowFootprint::new(grid, id)
        .into_iter()
        .flat_map(|footprint| footprint.finer_pages().collect::<Vec<_>>())
}

/// Knowledge of the voxels of one finer page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FinerVoxels {
    Stored,
    /// Made by the stand-in.
    Made,
    /// Nothing: the stand-in's coarse page holds.
    Unknown,
}

/// Coarse and finer voxels that a coarse page is made of and from. Ranges count over the whole level.
#[derive(Debug, Clone)]
pub(super) struct WindowFootprint {
    pub finer_level: u8,
    /// The page's own voxels.
    pub own_x: Range<u32>,
    pub own_y: Range<u32>,
    /// Coarse columns with their apron, clamped to the area.
    pub coarse_x: Range<u32>,
    pub coarse_y: Range<u32>,
    /// The finer voxels of these.
    pub finer_x: Range<u32>,
    pub finer_y: Range<u32>,
}

impl WindowFootprint {
    pub fn new(grid: &Grid, id: PageId) -> Option<Self> {
        let finer_level = id.level.checked_sub(1).filter(|_| !id.is_bare())?;
        let Size { width, height } = grid.page_size(id)?;
        let own = |page: u32, size: u32| page * PAGE_SIDE..page * PAGE_SIDE + size;
        let with_apron =
            |own: &Range<u32>, limit: u32| own.start.saturating_sub(APRON)..(own.end + APRON).min(limit);
        let finer = |coarse: &Range<u32>, limit: u32| {
            coarse.start * RADIX..coarse.end.saturating_mul(RADIX).min(limit)
        };
        let (nx, ny) = grid.dims(id.level);
        let (finer_nx, finer_ny) = grid.dims(finer_level);
        let (own_x, own_y) = (own(id.px, width), own(id.py, height));
        let (coarse_x, coarse_y) = (with_apron(&own_x, nx), with_apron(&own_y, ny));
        let (finer_x, finer_y) = (finer(&coarse_x, finer_nx), finer(&coarse_y, finer_ny));
        Some(Self { finer_level, own_x, own_y, coarse_x, coarse_y, finer_x, finer_y })
    }

    /// Finer pages under the footprint, rows from the south.
    fn finer_pages(&self) -> impl Iterator<Item = PageId> + use<> {
        let level = self.finer_level;
        let pages = |voxels: &Range<u32>| voxels.start / PAGE_SIDE..voxels.end.div_ceil(PAGE_SIDE);
        let columns = pages(&self.finer_x);
        pages(&self.finer_y).flat_map(move |py| columns.clone().map(move |px| PageId { level, px, py }))
    }

    /// Attributes of all finer voxels, if it is known that none of them has a surface, and they are all alike.
    pub fn known_empty(&self, finer: &impl FinerPages) -> Option<Attributes> {
        let mut pages = self.finer_pages().map(|page| finer.known_empty(page));
        let first = pages.next()??;
        pages.all(|attributes| attributes == Some(first)).then_some(first)
    }

    /// The part of a finer page that lies in the footprint, columns and rows of the finer level.
    fn within(&self, id: PageId, view_size: [u32; 2], margin: u32) -> [Range<u32>; 2] {
        let cut = |finer: &Range<u32>, page: u32, size: u32| {
            let first = page * PAGE_SIDE;
            finer.start.max(first.saturating_sub(margin))..finer.end.min(first + size + margin)
        };
        [cut(&self.finer_x, id.px, view_size[0]), cut(&self.finer_y, id.py, view_size[1])]
    }
}

/// The finer voxels that a coarse page is made from; planes `[rows][columns]` without apron.
#[derive(Debug)]
pub(super) struct FinerWindow {
    pub footprint: WindowFootprint,
    pub width: usize,
    pub heights: Vec<u16>,
    /// Bounds of what is stored. Empty if they are the heights: where all of level index 0 is stored.
    low: Vec<u16>,
    high: Vec<u16>,
    pub colours: Vec<[u8; 3]>,
    pub attributes: Vec<Attributes>,
    /// Parts by finer page, in the order of [`WindowFootprint::finer_pages`].
    parts: Vec<FinerVoxels>,
    parts_across: u32,
    /// The stand-in's page, if some part needs it.
    own: Option<PageBuffer>,
}

impl FinerWindow {
    /// Collects what there is, and makes the rest by `stand_in`.
    pub fn collect(
        footprint: WindowFootprint,
        grid: &Grid,
        id: PageId,
        finer: &impl FinerPages,
        stand_in: &mut impl StandIn,
    ) -> Result<Self> {
        let mut window = Self::empty(footprint);
        let pages: Vec<PageId> = window.footprint.finer_pages().collect();
        let mut scratch = AlignedBytes::default();
        for &page in &pages {
            let view = finer.finer_page(page, &mut scratch)?;
            if let Some(view) = &view {
                window.copy_page(page, view);
            }
            window.parts.push(if view.is_some() { FinerVoxels::Stored } else { FinerVoxels::Unknown });
        }

        if window.is_whole() {
            return Ok(window);
        }

        if window.low.is_empty() {
            // What is not stored is still empty.
            (window.low, window.high) = (window.heights.clone(), window.heights.clone());
        }

        for (index, &page) in pages.iter().enumerate() {
            let Size { width, height } = grid.page_size(page).unwrap_or_default();
            let [x, y] = window.footprint.within(page, [width, height], 0);
            if window.parts[index] == FinerVoxels::Unknown
                && let Some(block) = stand_in.finer(page, x, y)?
            {
                window.copy_block(&block);
                window.parts[index] = FinerVoxels::Made;
            }
        }

        for (index, &page) in pages.iter().enumerate() {
            if window.parts[index] == FinerVoxels::Stored
                && window.is_beside_absent(index)
                && let Some(view) = finer.finer_page(page, &mut scratch)?
            {
                window.copy_ring(page, &view);
            }
        }

        if window.parts.contains(&FinerVoxels::Unknown) {
            window.own = Some(stand_in.page(id)?);
        }

        Ok(window)
    }

    fn empty(footprint: WindowFootprint) -> Self {
        let width = footprint.finer_x.len();
        let voxels = width * footprint.finer_y.len();
        let bounds = if footprint.finer_level > 0 { voxels } else { 0 };
        let across = footprint.finer_x.end.div_ceil(PAGE_SIDE) - footprint.finer_x.start / PAGE_SIDE;
        Self {
            footprint,
            width,
            heights: vec![HeightCode::EMPTY; voxels],
            low: vec![HeightCode::EMPTY; bounds],
            high: vec![HeightCode::EMPTY; bounds],
            colours: vec![[0; 3]; voxels],
            attributes: vec![Attributes::default(); voxels],
            parts: Vec::new(),
            parts_across: across,
            own: None,
        }
    }

    /// Whether all finer pages are stored.
    pub fn is_whole(&self) -> bool {
        self.parts.iter().all(|part| *part == FinerVoxels::Stored)
    }

    /// Lower and upper bounds of the finer voxels that are stored.
    pub fn bounds(&self) -> (&[u16], &[u16]) {
        if self.low.is_empty() { (&self.heights, &self.heights) } else { (&self.low, &self.high) }
    }

    fn part_at(&self, x: u32, y: u32) -> FinerVoxels {
        let first = |finer: &Range<u32>| finer.start / PAGE_SIDE;
        let page = |coarse: u32| coarse * RADIX / PAGE_SIDE;
        let (column, row) =
            (page(x) - first(&self.footprint.finer_x), page(y) - first(&self.footprint.finer_y));
        self.parts[(row * self.parts_across + column) as usize]
    }

    /// Whether the finer voxels of coarse voxel (x, y) are stored.
    pub fn is_stored(&self, x: u32, y: u32) -> bool {
        self.part_at(x, y) == FinerVoxels::Stored
    }

    /// The stand-in's page if it holds at coarse voxel (x, y), and the voxel's place in its planes with an apron of `apron`.
    pub fn own_at(&self, x: u32, y: u32, apron: u32) -> Option<(&PageBuffer, usize)> {
        let own = self.own.as_ref().filter(|_| self.part_at(x, y) == FinerVoxels::Unknown)?;
        let WindowFootprint { own_x, own_y, .. } = &self.footprint;
        let (column, row) = (x + apron - own_x.start, y + apron - own_y.start);
        Some((own, (row * (own.width + 2 * apron) + column) as usize))
    }

    fn is_beside_absent(&self, index: usize) -> bool {
        let across = self.parts_across as usize;
        let (column, row) = (index % across, index / across);
        let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        let rows = self.parts.len() / across;
        around(row, rows).any(|row| {
            around(column, across).any(|column| self.parts[row * across + column] != FinerVoxels::Stored)
        })
    }

    fn at(&self, x: u32, y: u32) -> usize {
        let WindowFootprint { finer_x, finer_y, .. } = &self.footprint;
        (y - finer_y.start) as usize * self.width + (x - finer_x.start) as usize
    }

    /// Copies the part of a finer page that lies in the window, row by row.
    fn copy_page(&mut self, id: PageId, view: &PageView<'_>) {
        let (page_x, page_y) = (id.px * PAGE_SIDE, id.py * PAGE_SIDE);
        let [columns, rows] = self.footprint.within(id, [view.width, view.height], 0);
        let count = columns.len();
        for y in rows {
            let to = self.at(columns.start, y);
            let to = to..to + count;
            let (row, column) = (y - page_y, columns.start - page_x);
            let from = (row * view.width + column) as usize;
            let from = from..from + count;
            let aproned = view.sample(column, row);
            let aproned = aproned..aproned + count;
            self.heights[to.clone()].copy_from_slice(&view.heights[aproned.clone()]);
            self.colours[to.clone()].copy_from_slice(&view.colours[aproned]);
            if !self.low.is_empty() {
                self.low[to.clone()].copy_from_slice(&view.low[from.clone()]);
                self.high[to.clone()].copy_from_slice(&view.high[from.clone()]);
            }

            match view.attributes {
                [uniform] => self.attributes[to].fill(*uniform),
                plane => self.attributes[to].copy_from_slice(&plane[from]),
            }
        }
    }

    fn copy_block(&mut self, block: &VoxelBlock) {
        let count = block.x.len();
        for (row, y) in block.y.clone().enumerate() {
            let (to, from) = (self.at(block.x.start, y), row * count);
            self.heights[to..to + count].copy_from_slice(&block.heights[from..from + count]);
            self.colours[to..to + count].copy_from_slice(&block.colours[from..from + count]);
            self.attributes[to..to + count].copy_from_slice(&block.attributes[from..from + count]);
        }
    }

    /// Copies what a stored page says one voxel beside itself, where that is absent: its surface goes on to there.
    fn copy_ring(&mut self, id: PageId, view: &PageView<'_>) {
        let (page_x, page_y) = (id.px * PAGE_SIDE, id.py * PAGE_SIDE);
        let [columns, rows] = self.footprint.within(id, [view.width, view.height], 1);
        for y in rows {
            for x in columns.clone() {
                if self.is_stored(x / RADIX, y / RADIX) {
                    continue;
                }
                let (row, column) = ((y + APRON - page_y) as usize, (x + APRON - page_x) as usize);
                let (from, to) = (row * (view.width + 2 * APRON) as usize + column, self.at(x, y));
                self.heights[to] = view.heights[from];
                self.colours[to] = view.colours[from];
                (self.low[to], self.high[to]) = (view.heights[from], view.heights[from]);
            }
        }
    }

    /// Half steps of height eastward and northward at each post; the window's outermost repeat themselves beyond it, which is
    /// right where the area ends.
    pub fn steps(&self) -> Vec<[i32; 2]> {
        let (width, rows) = (self.width, self.heights.len() / self.width);
        let row = |y: usize| &self.heights[y * width..][..width];
        let mut steps = vec![[0; 2]; self.heights.len()];

        // Columns with the outermost repeated, so that all posts are alike and many are looked at at once.
        let mut columns = vec![HeightCode::EMPTY; width + 2];
        for (y, steps) in steps.chunks_exact_mut(width).enumerate() {
            let (south, here, north) = (row(y.saturating_sub(1)), row(y), row((y + 1).min(rows - 1)));
            columns[1..=width].copy_from_slice(here);
            (columns[0], columns[width + 1]) = (here[0], here[width - 1]);
            let (west, east) = (&columns[..width], &columns[2..]);
            for x in 0..width {
                steps[x] = [half_steps(here[x], west[x], east[x]), half_steps(here[x], south[x], north[x])];
            }

            // From one post to the next, not to the one after that.
            steps[0][0] *= 2;
            if width > 1 {
                steps[width - 1][0] *= 2;
            }
            if y == 0 || y + 1 == rows {
                steps.iter_mut().for_each(|step| step[1] *= 2);
            }
        }

        steps
    }

    /// Positions in the planes of the finer voxels of coarse column or row `coarse`, `ring` more to each
    /// side, as far as the window goes; `finer` is the window's extent that way.
    pub fn span(coarse: u32, ring: u32, finer: &Range<u32>) -> Range<usize> {
        let start = (coarse * RADIX).saturating_sub(ring).max(finer.start);
        let end = (coarse * RADIX).saturating_add(RADIX + ring).min(finer.end);
        (start - finer.start) as usize..(end - finer.start) as usize
    }

    /// The window's rows that coarse row `y` is made from, `ring` more to each side, of a plane.
    pub fn rows<'a, T>(
        &self,
        plane: &'a [T],
        y: u32,
        ring: u32,
    ) -> impl Iterator<Item = &'a [T]> + Clone + use<'a, T> {
        let rows = Self::span(y, ring, &self.footprint.finer_y);
        plane[rows.start * self.width..rows.end * self.width].chunks_exact(self.width)
    }
}
