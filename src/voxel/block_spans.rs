//! All that stands on the voxels of a block, placed objects included.
//!
//! ```text
//! count the spans of each voxel, own ones and those of objects  → where those of each voxel begin
//! put them there, each voxel's in the order of their heights
//! ```

use super::coarse_spans::CoarseCells;
use super::{BLOCK_SIDE, Placement, SharedObject, SharedObjects, Span, SpansView};
use crate::simd::Each;

/// More spans than this over a block are taken for damage, and read as nothing.
const MOST: u32 = 1 << 22;

const VOXELS: usize = (BLOCK_SIDE * BLOCK_SIDE) as usize;

/// Spans of 8 × 8 voxels, by voxel.
#[derive(Debug, Clone)]
pub struct BlockSpans {
    /// Starts of each voxel's spans, row by row northward, and the last one's end.
    starts: [u32; VOXELS + 1],
    /// Height codes that nothing over each voxel rises above, slopes and all; 0 where nothing stands.
    tops: [f32; VOXELS],
    spans: Vec<Span>,
}

impl Default for BlockSpans {
    fn default() -> Self {
        Self { starts: [0; VOXELS + 1], tops: [0.0; VOXELS], spans: Vec::new() }
    }
}

impl BlockSpans {
    /// Fills it with what stands on the block of voxel (x, y) of a page; `rise` as for [`super::SpanTable::new`]. Returns whether something does.
    pub fn gather(
        &mut self,
        page: &SpansView<'_>,
        objects: &SharedObjects,
        [x, y]: [u32; 2],
        rise: f64,
    ) -> bool {
        let corner = [x, y].each(|at| at / BLOCK_SIDE * BLOCK_SIDE);
        let (block, placements) = (page.block(x, y), page.placements_at(x, y));
        let own = |voxel: usize| {
            page.of(&block, corner[0] + voxel as u32 % BLOCK_SIDE, corner[1] + voxel as u32 / BLOCK_SIDE)
        };
        let placed =
            || placements.iter().filter_map(|placement| Some((*placement, objects.get(*placement)?)));
        let mut counts = [0_u32; VOXELS];
        for voxel in ones(block.occupied) {
            counts[voxel] = own(voxel).len() as u32;
        }

        for (placement, object) in placed() {
            over(placement, object, corner, |voxel, at| {
                counts[voxel] = counts[voxel].saturating_add(object.count_at(placement, at));
            });
        }

        self.spans.clear();
        (self.starts, self.tops) = ([0; VOXELS + 1], [0.0; VOXELS]);
        if counts.iter().fold(0_u32, |sum, count| sum.saturating_add(*count)) > MOST {
            return false;
        }

        // Where the next one of each voxel goes.
        let mut ends = [0; VOXELS];
        let mut end = 0;
        for voxel in 0..VOXELS {
            (self.starts[voxel], ends[voxel]) = (end, end);
            end += counts[voxel];
        }

        self.starts[VOXELS] = end;
        self.spans.resize(end as usize, Span::NONE);
        let rise = rise as f32;
        for voxel in ones(block.occupied) {
            own(voxel).iter().for_each(|span| self.put(voxel, span, &mut ends[voxel], rise));
        }

        for (placement, object) in placed() {
            over(placement, object, corner, |voxel, at| {
                let spans = object.spans_at(placement, at);
                spans.for_each(|span| self.put(voxel, span, &mut ends[voxel], rise));
            });
        }

        end > 0
    }

    /// Fills it with what stands on the block of cells of `1 << shift` voxels to a side, 2 or 4, that begins with voxel (x, y) of a page; `rise` as for
    /// [`super::SpanTable::new`].
    pub fn gather_coarse(
        &mut self,
        page: &SpansView<'_>,
        objects: &SharedObjects,
        [x, y]: [u32; 2],
        shift: u8,
        rise: f64,
    ) {
        let side = 1 << shift;
        let cells = CoarseCells { side, rise: rise as f32 };
        let (mut fine, mut pieces) = (Self::default(), Vec::new());
        for at in (0..side * side).map(|number| [number % side, number / side]) {
            let voxel = [x + at[0] * BLOCK_SIDE, y + at[1] * BLOCK_SIDE];
            if page.has_block(voxel) && fine.gather(page, objects, voxel, rise) {
                cells.cut(|voxel| fine.at(voxel), at, &mut pieces);
            }
        }

        self.spans.clear();
        (self.starts, self.tops) = ([0; VOXELS + 1], [0.0; VOXELS]);
        pieces.sort_by_key(|piece| piece.cell);
        let mut groups = pieces.chunk_by_mut(|a, b| a.cell == b.cell).peekable();
        for cell in 0..VOXELS {
            self.starts[cell] = self.spans.len() as u32;
            if let Some(group) = groups.next_if(|group| usize::from(group[0].cell) == cell) {
                cells.join(group, &mut self.spans);
            }
            let own = &self.spans[self.starts[cell] as usize..];
            self.tops[cell] =
                own.iter().map(|span| top_of(span, cells.rise * side as f32)).fold(0.0, f32::max);
        }
        self.starts[VOXELS] = self.spans.len() as u32;
    }

    /// Puts a span before those of its voxel that are higher.
    #[inline]
    fn put(&mut self, voxel: usize, span: Span, end: &mut u32, rise: f32) {
        self.tops[voxel] = self.tops[voxel].max(top_of(&span, rise));
        let mut at = *end as usize;
        let first = self.starts[voxel] as usize;
        while at > first && (self.spans[at - 1].low, self.spans[at - 1].high) > (span.low, span.high) {
            self.spans[at] = self.spans[at - 1];
            at -= 1;
        }
        self.spans[at] = span;
        *end += 1;
    }

    /// Spans of voxel (x, y) of the page, which lies in the block, lowest first.
    #[inline]
    pub fn of(&self, x: u32, y: u32) -> &[Span] {
        self.at((y % BLOCK_SIDE * BLOCK_SIDE + x % BLOCK_SIDE) as usize)
    }

    /// Spans of a voxel by its number in the block, row by row northward, lowest first.
    #[inline]
    pub fn at(&self, voxel: usize) -> &[Span] {
        &self.spans[self.starts[voxel] as usize..self.starts[voxel + 1] as usize]
    }

    /// Height codes that nothing over each voxel rises above, half a step at least; 0 where nothing stands.
    #[inline]
    pub fn tops(&self) -> &[f32; VOXELS] {
        &self.tops
    }
}

/// Height code that a span does not rise above, with room for what rounding takes.
#[inline]
fn top_of(span: &Span, rise: f32) -> f32 {
    let steps = u32::from(span.slope[0].unsigned_abs()) + u32::from(span.slope[1].unsigned_abs());
    f32::from(span.high) + steps as f32 * rise + 0.5
}

/// Iterates over the bits of a block's voxels that are set.
#[inline]
fn ones(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let first = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (first < VOXELS).then_some(first)
    })
}

/// The voxels of a block, from `corner` on, that an object lies over, each with the object's own there.
#[inline]
fn over(
    placement: Placement,
    object: &SharedObject,
    corner: [u32; 2],
    mut with: impl FnMut(usize, [u16; 2]),
) {
    let size = object.size(placement);
    let range = |axis: usize| {
        let from = i32::from(placement.first[axis]) - corner[axis] as i32;
        (from, from.max(0)..(from + i32::from(size[axis])).min(BLOCK_SIDE as i32))
    };
    let ((west, columns), (south, rows)) = (range(0), range(1));
    for row in rows {
        for column in columns.clone() {
            let voxel = (row * BLOCK_SIDE as i32 + column) as usize;
            with(voxel, [(column - west) as u16, (row - south) as u16]);
        }
    }
}
