//! Blocks of spans that were looked at, kept for the rays and planes beside.
//!
//! What stands on a block is put together from the spans of its page and the objects that are placed there. Neighbours pass through the
//! same blocks one after the other, and frames those of the frame before, so that this is seldom done twice. How high a block reaches is
//! known without it. Blocks of coarser cells are kept beside those of voxels, which they are made of.

use std::ops::DerefMut;

use super::{Lattice, PageCursor};
use crate::simd::Each;
use crate::voxel::{
    BARE, BLOCK_SIDE, BlockSpans, PAGE_SIDE, PageId, PageSource, SharedObjects, SpanTable, SpansView,
};
use hedgehop_base::error::Result;

/// Places in the table: a picture of 1920 × 1080 looks at 12,000 blocks and more.
const PLACES: usize = 16384;

/// Blocks with the same place lie 137 blocks apart at least: planes seldom have two of them (the densest lattice of this many points).
const PER_ROW: i64 = 1435;

/// Places from a block to the one of coarser cells of the same column and row.
const PER_SHIFT: i64 = 5461;

/// Column and row of a block among those of cells of `1 << shift` voxels to a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BlockPlace {
    pub at: [i64; 2],
    pub shift: u8,
}

impl BlockPlace {
    /// A block of voxels.
    pub fn of_voxels(at: [i64; 2]) -> Self {
        Self { at, shift: 0 }
    }

    /// Column and row of the south-west one of the blocks of voxels that it lies over.
    #[inline(always)]
    pub fn first(self) -> [i64; 2] {
        self.at.each(|at| at << self.shift)
    }

    /// How many of them lie along each side.
    #[inline(always)]
    pub fn count(self) -> u32 {
        1 << self.shift
    }

    /// Number of its place in a table.
    #[inline]
    fn place(self) -> usize {
        let Self { at, shift } = self;
        let place = at[0].wrapping_add(at[1].wrapping_mul(PER_ROW));
        place.wrapping_add(i64::from(shift) * PER_SHIFT) as usize % PLACES
    }
}

/// Spans of a block that is kept.
#[derive(Debug)]
struct BlockSlot {
    at: BlockPlace,
    /// Whether this frame looked at it.
    is_used: bool,
    spans: BlockSpans,
}

/// Spans of blocks, by column and row in the area: what one worker looked at in this frame and the one before.
#[derive(Debug)]
pub struct BlockTable {
    /// Numbers of slots, one more than they are; 0 where there is none.
    places: Vec<u32>,
    slots: Vec<BlockSlot>,
}

/// Blocks of one database, with a table of their own.
pub(super) type OwnBlocks<'a> = Blocks<'a, Box<BlockTable>>;

/// Blocks of one database, kept in a table.
pub(super) struct Blocks<'a, T> {
    source: &'a dyn PageSource,
    objects: &'a SharedObjects,
    /// Rise of spans, as for [`SpanTable::new`].
    rise: f64,
    /// The page that was looked up last.
    page: Option<(PageId, SpansView<'a>)>,
    table: T,
}

/// Column and row of a block's south-west voxel on its page.
#[inline(always)]
pub(super) fn corner_on_page(block: [i64; 2]) -> [u32; 2] {
    block.each(|at| (at * i64::from(BLOCK_SIDE) % i64::from(PAGE_SIDE)) as u32)
}

impl Default for BlockTable {
    fn default() -> Self {
        Self { places: vec![0; PLACES], slots: Vec::new() }
    }
}

impl BlockTable {
    /// Begins a frame: what the one before did not look at goes.
    pub fn begin_frame(&mut self) {
        self.slots.retain(|slot| slot.is_used);
        self.places.fill(0);
        for (number, slot) in (1..).zip(&mut self.slots) {
            slot.is_used = false;
            self.places[slot.at.place()] = number;
        }
    }

    /// Returns the spans of a block, which is put together unless it is here.
    #[inline]
    fn get(&mut self, block: BlockPlace, gather: impl FnOnce(&mut BlockSpans)) -> &BlockSpans {
        let place = block.place();
        let mut known = self.places[place] as usize;
        if known == 0 {
            self.slots.push(BlockSlot { at: block, is_used: true, spans: BlockSpans::default() });
            known = self.slots.len();
            self.places[place] = known as u32;
        } else if self.slots[known - 1].at == block {
            self.slots[known - 1].is_used = true;
            return &self.slots[known - 1].spans;
        }

        let slot = &mut self.slots[known - 1];
        (slot.at, slot.is_used) = (block, true);
        gather(&mut slot.spans);
        &slot.spans
    }
}

impl<'a, T: DerefMut<Target = BlockTable>> Blocks<'a, T> {
    /// Builds the blocks of `source`; `table` holds none or some of them.
    pub fn new(source: &'a dyn PageSource, table: T) -> Self {
        let header = source.header();
        Self {
            source,
            objects: &header.objects,
            rise: SpanTable::rise(header.heights, header.grid.spacing),
            page: None,
            table,
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
        let corner = corner_on_page(block);
        if view.block(corner[0], corner[1]).high == 0 {
            return Ok(0.0);
        }
        let [x, y] = voxel.each(|at| (at % i64::from(BLOCK_SIDE)) as usize);
        Ok(self.get(BlockPlace::of_voxels(block), &view).tops()[y * BLOCK_SIDE as usize + x])
    }

    /// Returns the spans of a block of the page `view`. Something stands there: a table must not take what an absent page does not show on to
    /// frames that have the page.
    pub fn get(&mut self, block: BlockPlace, view: &SpansView<'_>) -> &BlockSpans {
        let (objects, rise) = (self.objects, self.rise);
        let corner = corner_on_page(block.first());
        self.table.get(block, |spans| match block.shift {
            0 => drop(spans.gather(view, objects, corner, rise)),
            shift => spans.gather_coarse(view, objects, corner, shift, rise),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks at a block, and tells whether it had to be put together.
    fn look(table: &mut BlockTable, block: [i64; 2]) -> bool {
        let mut is_new = false;
        table.get(BlockPlace::of_voxels(block), |_| is_new = true);
        is_new
    }

    #[test]
    fn a_frame_keeps_what_the_one_before_looked_at() {
        let mut table = BlockTable::default();
        let blocks: Vec<_> = (0..60).flat_map(|x| (0..60).map(move |y| [x, y])).collect();
        let new = blocks.iter().filter(|block| look(&mut table, **block)).count();
        assert!(new == blocks.len() && blocks.iter().all(|block| !look(&mut table, *block)));

        table.begin_frame();
        let (east, west): (Vec<_>, Vec<_>) = blocks.into_iter().partition(|[x, _]| *x >= 30);
        assert!(east.iter().all(|block| !look(&mut table, *block)));
        table.begin_frame();
        assert_eq!(table.slots.len(), east.len());
        assert!(east.iter().all(|block| !look(&mut table, *block)));
        assert!(west.iter().all(|block| look(&mut table, *block)));
    }

    #[test]
    fn blocks_of_one_place_follow_each_other() {
        let mut table = BlockTable::default();
        let [one, other] = [[5, 7], [5 + PLACES as i64, 7]];
        for _ in 0..3 {
            assert!(look(&mut table, one) && !look(&mut table, one));
            assert!(look(&mut table, other) && !look(&mut table, other));
        }
        assert_eq!(table.slots.len(), 1);
    }
}
