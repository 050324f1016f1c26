//! Blocks of spans that were looked at, kept for the rays and planes beside.
//!
//! What stands on a block is put together from the spans of its page and the objects that are placed there. Neighbours pass through the
//! same blocks one after the other, so that this is seldom done twice. How high a block reaches is known without it.

use super::{Lattice, PageCursor};
use crate::simd::Each;
use crate::voxel::{
    BARE, BLOCK_SIDE, BlockSpans, PAGE_SIDE, PageId, PageSource, SharedObjects, SpanTable, SpansView,
};
use hedgehop_base::error::Result;

/// Places in the table.
const PLACES: usize = 8192;

/// Blocks with the same place lie 96 blocks apart at least: planes seldom have two of them (the densest lattice of this many points).
const PER_ROW: i64 = 1307;

/// Spans of a block that is kept.
struct BlockSlot {
    at: [i64; 2],
    spans: BlockSpans,
}

/// Blocks of one database by their column and row in the area.
pub(super) struct Blocks<'a> {
    source: &'a dyn PageSource,
    objects: &'a SharedObjects,
    /// Rise of spans, as for [`SpanTable::new`].
    rise: f64,
    /// The page that was looked up last.
    page: Option<(PageId, SpansView<'a>)>,
    /// Numbers of slots, one more than they are; 0 where there is none.
    table: Vec<u32>,
    slots: Vec<BlockSlot>,
}

/// Column and row of a block's south-west voxel on its page.
#[inline(always)]
pub(super) fn corner_on_page(block: [i64; 2]) -> [u32; 2] {
    block.each(|at| (at * i64::from(BLOCK_SIDE) % i64::from(PAGE_SIDE)) as u32)
}

impl<'a> Blocks<'a> {
    /// None yet of those of `source`.
    pub fn new(source: &'a dyn PageSource) -> Self {
        let header = source.header();
        Self {
            source,
            objects: &header.objects,
            rise: SpanTable::rise(header.heights, header.grid.spacing),
            page: None,
            table: vec![0; PLACES],
            slots: Vec::new(),
        }
    }

    /// The page that a block lies on, and what stands there; nothing where all of it is surface.
    ///
    /// # Errors
    /// A page that is damaged.
    #[inline]
    pub fn page(&mut self, block: [i64; 2]) -> Result<(PageId, SpansView<'a>)> {
        let [px, py] = block.each(|at| (at / i64::from(PAGE_SIDE / BLOCK_SIDE)) as u32);
        let id = PageId { level: BARE, px, py };
        if let Some((known, view)) = self.page
            && known == id
        {
            return Ok((id, view));
        }
        let view = if self.source.has(id) { self.source.spans(id)? } else { None };
        let view = view.unwrap_or(SpansView::NONE);
        self.page = Some((id, view));
        Ok((id, view))
    }

    /// Returns the voxels of the area, on which it all stands.
    pub fn voxels(&self) -> Lattice {
        PageCursor::new(self.source).voxels(0)
    }

    /// Height code that nothing over a voxel of the area rises above, half a step at least; 0 where nothing stands.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn top_at(&mut self, voxel: [i64; 2]) -> Result<f32> {
        let block = voxel.each(|at| at / i64::from(BLOCK_SIDE));
        let (_, view) = self.page(block)?;
        let [x, y] = voxel.each(|at| (at % i64::from(BLOCK_SIDE)) as usize);
        Ok(self.get(block, &view).tops()[y * BLOCK_SIDE as usize + x])
    }

    /// Returns the spans of a block of the page `view`.
    pub fn get(&mut self, block: [i64; 2], view: &SpansView<'_>) -> &BlockSpans {
        let place = block[0].wrapping_add(block[1].wrapping_mul(PER_ROW)) as usize % PLACES;
        let known = self.table[place] as usize;
        if known > 0 && self.slots[known - 1].at == block {
            return &self.slots[known - 1].spans;
        }
        let number = if known > 0 { known } else { self.slots.len() + 1 };
        if known == 0 {
            self.table[place] = number as u32;
            self.slots.push(BlockSlot { at: block, spans: BlockSpans::default() });
        }
        let slot = &mut self.slots[number - 1];
        slot.at = block;
        slot.spans.gather(view, self.objects, corner_on_page(block), self.rise);
        &slot.spans
    }
}
