//! Reading voxels through the page that was read last, per level.

use crate::error::Result;
use crate::voxel::{Attributes, HeightCode, PAGE_SIDE, PageId, PageSource, PageView};

/// Reads the planes of a [`PageSource`]; looks a page up only when a read leaves the last one.
pub struct PageCursor<'a, S: PageSource> {
    source: &'a S,
    heights: HeightCode,
    slots: Vec<Slot<'a>>,
}

struct Slot<'a> {
    dims: [i64; 2],
    page: [i64; 2],
    view: Option<PageView<'a>>,
}

/// A voxel's place in a page.
struct Place<'s, 'a> {
    view: &'s PageView<'a>,
    /// Column and row within the page; −1 is the apron.
    x: i64,
    y: i64,
}

impl<'a, S: PageSource> PageCursor<'a, S> {
    /// A cursor over all levels of `source`.
    pub fn new(source: &'a S) -> Self {
        let header = source.header();
        let slots = (0..header.level_count)
            .map(|level| {
                let (nx, ny) = header.grid.dims(level);
                Slot { dims: [i64::from(nx), i64::from(ny)], page: [-1, -1], view: None }
            })
            .collect();
        Self { source, heights: header.heights, slots }
    }

    /// The source that is read.
    pub fn source(&self) -> &'a S {
        self.source
    }

    /// Voxels (eastward, northward) of a level.
    pub fn dims(&self, level: u8) -> [i64; 2] {
        self.slots[usize::from(level)].dims
    }

    /// The page of voxel `cell`, clamped into the area; `None` where the page is absent.
    fn place(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<Place<'_, 'a>>> {
        const SIDE: i64 = PAGE_SIDE as i64;
        let slot = &mut self.slots[usize::from(level)];
        let page = [0, 1].map(|axis| cell[axis].clamp(0, slot.dims[axis] - 1) / SIDE);
        if page != slot.page {
            let id = PageId { level, px: page[0] as u32, py: page[1] as u32 };
            slot.view = self.source.page(id)?;
            slot.page = page;
        }
        Ok(slot.view.as_ref().map(|view| Place { view, x: cell[0] - page[0] * SIDE, y: cell[1] - page[1] * SIDE }))
    }

    /// Upper bound of every finer surface over voxel `cell` of level index ≥ 1, metres: −∞ where
    /// there is none, +∞ where the page is absent.
    pub fn upper_bound(&mut self, level: u8, cell: [i64; 2]) -> Result<f64> {
        let heights = self.heights;
        Ok(self.place(level, cell)?.map_or(f64::INFINITY, |place| {
            let index = place.y as usize * place.view.width as usize + place.x as usize;
            heights.decode(place.view.high[index]).unwrap_or(f64::NEG_INFINITY)
        }))
    }

    /// Mean height of voxel `cell`, metres: `Some(None)` where there is no surface, `None` where the
    /// page is absent.
    pub fn height(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<Option<f64>>> {
        let heights = self.heights;
        Ok(self.place(level, cell)?.map(|place| {
            let index = (place.y + 1) as usize * apron_stride(place.view) + (place.x + 1) as usize;
            heights.decode(place.view.heights[index])
        }))
    }

    /// Heights at the corners (south-west, south-east, north-west, north-east) of the cell of the
    /// smooth surface between voxels `cell` and `cell + 1`, metres; NaN where there is no surface.
    /// `None` where the page is absent. `cell` may be −1, at the area's south or west edge.
    pub fn corners(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<[f64; 4]>> {
        let heights = self.heights;
        Ok(self.place(level, cell)?.map(|place| {
            let indices = corner_indices(&place);
            indices.map(|index| heights.decode(place.view.heights[index]).unwrap_or(f64::NAN))
        }))
    }

    /// Colours at the same corners, sRGB.
    pub fn corner_colours(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<[[u8; 3]; 4]>> {
        Ok(self
            .place(level, cell)?
            .map(|place| corner_indices(&place).map(|index| place.view.colours[index])))
    }

    /// Attributes of the voxel `cell`, clamped into the area.
    pub fn attributes(&mut self, level: u8, cell: [i64; 2]) -> Result<Option<Attributes>> {
        let dims = self.dims(level);
        let cell = [0, 1].map(|axis| cell[axis].clamp(0, dims[axis] - 1));
        Ok(self.place(level, cell)?.map(|place| place.view.attributes_at(place.x as u32, place.y as u32)))
    }
}

fn apron_stride(view: &PageView<'_>) -> usize {
    view.width as usize + 2
}

fn corner_indices(place: &Place<'_, '_>) -> [usize; 4] {
    let stride = apron_stride(place.view);
    let first = (place.y + 1) as usize * stride + (place.x + 1) as usize;
    [first, first + 1, first + stride, first + stride + 1]
}
