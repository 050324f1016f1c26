//! Reading voxels through the page that was read last, per level.

use crate::error::Result;
use crate::voxel::{Attributes, HeightCode, PAGE_SIDE, PageId, PageSource, PageView};

/// Reads the planes of a [`PageSource`]; looks a page up only when a read leaves the last one.
pub struct PageCursor<'a, S: PageSource> {
    source: &'a S,
    heights: HeightCode,
    slots: Vec<Slot<'a>>,
}

/// The page of one level that was read last.
struct Slot<'a> {
    /// Voxels (eastward, northward) of the level.
    dims: [i64; 2],
    /// Its first voxel; before the area while no page has been read.
    first: [i64; 2],
    /// Its voxels (eastward, northward); 0 while no page has been read.
    size: [i64; 2],
    view: Option<PageView<'a>>,
}

/// A voxel's place in a page.
struct Place<'s, 'a> {
    view: &'s PageView<'a>,
    /// Column and row within the page; −1 is the apron.
    x: i64,
    y: i64,
}

impl<'a> Slot<'a> {
    /// Brings the page of a voxel (clamped into the area) into the slot.
    #[cold]
    fn turn_to<S: PageSource>(&mut self, source: &'a S, level: u8, cell: [i64; 2]) -> Result<()> {
        let side = i64::from(PAGE_SIDE);
        let page = [0, 1].map(|axis| cell[axis].clamp(0, self.dims[axis] - 1) / side);
        let first = page.map(|index| index * side);
        if first != self.first {
            let id = PageId { level, px: page[0] as u32, py: page[1] as u32 };
            self.view = source.page(id)?;
            self.size = [0, 1].map(|axis| (self.dims[axis] - first[axis]).min(side));
            self.first = first;
        }
        Ok(())
    }
}

impl<'a, S: PageSource> PageCursor<'a, S> {
    /// A cursor over all levels of `source`.
    pub fn new(source: &'a S) -> Self {
        let header = source.header();
        let slots = (0..header.level_count)
            .map(|level| {
                let (nx, ny) = header.grid.dims(level);
                Slot { dims: [i64::from(nx), i64::from(ny)], first: [-1, -1], size: [0, 0], view: None }
            })
            .collect();
        Self { source, heights: header.heights, slots }
    }

    /// Voxels (eastward, northward) of a level.
    pub fn dims(&self, level: u8) -> [i64; 2] {
        self.slots[usize::from(level)].dims
    }

    /// The page of voxel `cell`, clamped into the area; `None` where the page is absent.
    #[inline]
    fn place(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<Place<'_, 'a>>> {
        let slot = &mut self.slots[usize::from(level)];
        let inside = |axis: usize| (0..slot.size[axis]).contains(&(cell[axis] - slot.first[axis]));
        if !(inside(0) && inside(1)) {
            slot.turn_to(self.source, level, cell)?;
        }
        let (x, y) = (cell[0] - slot.first[0], cell[1] - slot.first[1]);
        Ok(slot.view.as_ref().map(|view| Place { view, x, y }))
    }

    /// Upper bound of every finer surface over voxel `cell` of level index ≥ 1, metres: −∞ where
    /// there is none, +∞ where the page is absent.
    #[inline]
    pub fn upper_bound(&mut self, level: u8, cell: [i64; 2]) -> Result<f64> {
        let heights = self.heights;
        let Some(place) = self.place(level, cell)? else { return Ok(f64::INFINITY) };
        let code = place.view.high[place.y as usize * place.view.width as usize + place.x as usize];
        Ok(heights.decode(code).unwrap_or(f64::NEG_INFINITY))
    }

    /// Mean height of voxel `cell`, metres: `Some(None)` where there is no surface, `None` where the
    /// page is absent.
    pub fn height(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<Option<f64>>> {
        let heights = self.heights;
        Ok(self.place(level, cell)?.map(|place| heights.decode(place.view.heights[place.with_apron()])))
    }

    /// Heights at the corners (south-west, south-east, north-west, north-east) of the cell of the
    /// smooth surface between voxels `cell` and `cell + 1`, metres; NaN where there is no surface.
    /// `None` where the page is absent. `cell` may be −1, at the area's south or west edge.
    #[inline]
    pub fn corners(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<[f64; 4]>> {
        let heights = self.heights;
        let Some(place) = self.place(level, cell)? else { return Ok(None) };
        let height = |code| heights.decode(code).unwrap_or(f64::NAN);
        let [south, north] = place.corner_rows(place.view.heights);
        Ok(Some([height(south[0]), height(south[1]), height(north[0]), height(north[1])]))
    }

    /// Colours at the same corners, sRGB.
    pub fn corner_colours(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<[[u8; 3]; 4]>> {
        let Some(place) = self.place(level, cell)? else { return Ok(None) };
        let [south, north] = place.corner_rows(place.view.colours);
        Ok(Some([south[0], south[1], north[0], north[1]]))
    }

    /// Colour of voxel `cell`, sRGB; `None` where the page is absent.
    pub fn colour(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<[u8; 3]>> {
        Ok(self.place(level, cell)?.map(|place| place.view.colours[place.with_apron()]))
    }

    /// Attributes of the voxel `cell`, clamped into the area.
    pub fn attributes(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<Attributes>> {
        let dims = self.dims(level);
        let cell = [0, 1].map(|axis| cell[axis].clamp(0, dims[axis] - 1));
        Ok(self.place(level, cell)?.map(|place| place.view.attributes_at(place.x as u32, place.y as u32)))
    }
}

impl Place<'_, '_> {
    /// Voxels along a row, the apron included.
    fn stride(&self) -> usize {
        self.view.width as usize + 2
    }

    /// Index of the voxel in a plane with apron.
    fn with_apron(&self) -> usize {
        (self.y + 1) as usize * self.stride() + (self.x + 1) as usize
    }

    /// The voxel and its eastern neighbour, and the two north of them, in a plane with apron.
    fn corner_rows<'p, T>(&self, plane: &'p [T]) -> [&'p [T]; 2] {
        let south = self.with_apron();
        let north = south + self.stride();
        [&plane[south..south + 2], &plane[north..north + 2]]
    }
}
