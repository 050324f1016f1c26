//! Blocks of spans that were looked at, kept for the planes beside.
//!
//! What stands on a block is put together from the spans of its page and the objects that are placed there. Sixteen planes and their
//! neighbours pass through the same blocks one after the other, so that this is seldom done twice.

use crate::voxel::{BlockSpans, SharedObjects, SpansView};

/// Places in the table.
const PLACES: usize = 8192;

/// Blocks with the same place lie 96 blocks apart at least: planes seldom have two of them (the densest lattice of this many points).
const PER_ROW: i64 = 1307;

/// What stands on a block.
#[derive(Debug)]
struct Slot {
    at: [i64; 2],
    spans: BlockSpans,
}

/// Blocks by where they lie.
#[derive(Debug)]
pub(super) struct Blocks {
    rise: f64,
    /// Numbers of slots, one more than they are; 0 where there is none.
    table: Vec<u32>,
    slots: Vec<Slot>,
}

impl Blocks {
    /// `rise` as for [`crate::voxel::SpanTable::new`].
    pub fn new(rise: f64) -> Self {
        Self { rise, table: vec![0; PLACES], slots: Vec::new() }
    }

    /// A block by its column and row in the area, of which `corner` is a voxel on the page `view`.
    pub fn get(
        &mut self,
        at: [i64; 2],
        (view, corner): (&SpansView<'_>, [u32; 2]),
        objects: &SharedObjects,
    ) -> &BlockSpans {
        let place = at[0].wrapping_add(at[1].wrapping_mul(PER_ROW)) as usize % PLACES;
        let known = self.table[place] as usize;
        if known > 0 && self.slots[known - 1].at == at {
            return &self.slots[known - 1].spans;
        }
        let number = if known > 0 { known } else { self.slots.len() + 1 };
        if known == 0 {
            self.table[place] = number as u32;
            self.slots.push(Slot { at, spans: BlockSpans::default() });
        }
        let slot = &mut self.slots[number - 1];
        slot.at = at;
        slot.spans.gather(view, objects, corner, self.rise);
        &slot.spans
    }
}
