//! The spans of a page, found by voxel.
//!
//! ```text
//! block (8 × 8 voxels): which of them have spans, 64 bits; the number of the first one that has
//!     voxel's number = the block's first + bits set before its own
//!         its spans  = starts[number] .. starts[number + 1], lowest first
//! ```
//!
//! Empty blocks are passed over by one look, and a voxel costs memory only if something stands on it. A voxel of 64 is found by
//! counting bits (Jacobson, "Space-efficient static trees and graphs", 1989). Objects that are [placed](super::Placement) on the
//! page are listed by each block that they reach; [`super::BlockSpans`] has their spans as well.

use std::ops::Range;

use super::format::{PLANE_ALIGNMENT, spans as at};
use super::stored_spans::{StoredSpan, StoredSpans};
use super::{Facade, HeightCode, Placement, SharedObjects, Span};
use crate::simd::Each;
use hedgehop_base::Size;

/// Voxels along the side of a block.
pub const BLOCK_SIDE: u32 = 8;

/// Spans on 8 × 8 voxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SpanBlock {
    /// Voxels with spans: bit `8·y + x` is that of the voxel in column x and row y of the block.
    pub occupied: u64,
    /// Number of voxels with spans in the blocks before.
    pub first: u32,
    /// Height code that nothing reaches below, where all of it hangs in the air; else [`Span::GROUND`]. Placed objects count.
    pub low: u16,
    /// Height code that nothing rises above, slopes, placed objects and all; 0 where nothing stands.
    pub high: u16,
}

/// Spans by voxel, in memory of their own.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SpanTable {
    blocks: Vec<SpanBlock>,
    starts: Vec<u32>,
    spans: Vec<StoredSpan>,
    /// Façades of these; empty if they have none.
    facades: Vec<Facade>,
    /// First placement of each block, and the last one's end; empty if there are none.
    placed: Vec<u32>,
    placements: Vec<Placement>,
}

/// Spans by voxel, where they lie. What contradicts itself reads as nothing.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(test, derive(PartialEq))]
pub struct SpansView<'a> {
    blocks_across: u32,
    blocks: &'a [SpanBlock],
    starts: &'a [u32],
    spans: StoredSpans<'a>,
    placed: &'a [u32],
    placements: &'a [Placement],
}

impl SpanTable {
    /// Makes the table of a page of `size` voxels: `spans_of` appends those of a voxel (x, y), lowest first. `rise` is how many steps of height the
    /// steepest slope of one step rises over half a voxel's diagonal, see [`Self::rise`].
    pub fn new(size: Size, rise: f64, mut spans_of: impl FnMut(u32, u32, &mut Vec<Span>)) -> Self {
        let mut table = Self { starts: vec![0], ..Self::default() };
        let mut here = Vec::new();
        for (columns, rows) in blocks_of(size.width, size.height) {
            let mut block =
                SpanBlock { first: table.starts.len() as u32 - 1, low: u16::MAX, ..SpanBlock::default() };
            for (row, y) in rows.enumerate() {
                for (column, x) in columns.clone().enumerate() {
                    here.clear();
                    spans_of(x, y, &mut here);
                    if here.is_empty() {
                        continue;
                    }

                    block.occupied |= 1 << (row as u32 * BLOCK_SIDE + column as u32);
                    for span in &here {
                        let [low, high] = span.reach(rise);
                        (block.low, block.high) = (block.low.min(low), block.high.max(high));
                        table.spans.push(StoredSpan::of(span));
                        table.facades.push(span.facade);
                    }

                    table.starts.push(table.spans.len() as u32);
                }
            }

            if block.occupied == 0 {
                block.low = 0;
            }
            table.blocks.push(block);
        }

        if table.facades.iter().all(Facade::is_none) {
            table.facades.clear();
        }
        if table.spans.is_empty() { Self::default() } else { table }
    }

    /// All of them, voxel by voxel; not those of objects.
    pub fn spans(&self) -> StoredSpans<'_> {
        StoredSpans::new(&self.spans, &self.facades)
    }

    /// Objects that stand on the page, once for each block that they reach.
    pub fn placements(&self) -> &[Placement] {
        &self.placements
    }

    /// The same with objects that stand on the page of `page_size` voxels as well; each may come more than once.
    #[must_use]
    pub fn with_objects(
        mut self,
        page_size: Size,
        objects: &SharedObjects,
        placements: &[Placement],
    ) -> Self {
        let across = page_size.width.div_ceil(BLOCK_SIDE);
        let mut by_block: Vec<(u32, Placement)> = Vec::new();
        for &placement in placements {
            let Some(object) = objects.get(placement) else { continue };
            // The blocks from one voxel to the last one of the object that lies on the page.
            let size = object.size(placement);

            let range = |axis: usize, limit: u32| {
                let first = i64::from(placement.first[axis]);
                let last = (first + i64::from(size[axis]) - 1).min(i64::from(limit) - 1);
                let is_on_page = last >= 0 && first < i64::from(limit);
                is_on_page.then(|| first.max(0) as u32 / BLOCK_SIDE..=last as u32 / BLOCK_SIDE)
            };
            let (Some(columns), Some(rows)) = (range(0, page_size.width), range(1, page_size.height)) else {
                continue;
            };
            by_block.extend(
                rows.flat_map(|row| columns.clone().map(move |column| row * across + column))
                    .map(|block| (block, placement)),
            );
        }

        if by_block.is_empty() {
            return self;
        }

        by_block.sort_unstable();
        // What stands twice in one place stands there once.
        by_block.dedup();
        let count = across as usize * page_size.height.div_ceil(BLOCK_SIDE) as usize;
        if self.blocks.is_empty() {
            (self.blocks, self.starts) = (vec![SpanBlock::default(); count], vec![0]);
        }

        self.placed = vec![0; count + 1];
        for (block, placement) in by_block {
            self.placed[block as usize + 1] += 1;
            self.placements.push(placement);
            let [low, high] = objects.get(placement).map_or([0; 2], |object| object.codes(placement.foot));
            let block = &mut self.blocks[block as usize];
            block.low = if block.high == 0 { low } else { block.low.min(low) };
            block.high = block.high.max(high);
        }

        for index in 0..count {
            self.placed[index + 1] += self.placed[index];
        }

        self
    }

    /// Returns how many codes a slope of one step rises or falls over half a voxel's diagonal, if a step of height is `scale` metres and a voxel
    /// `spacing` metres wide.
    pub fn rise(code: HeightCode, spacing: f64) -> f64 {
        0.5 * spacing / f64::from(Span::SLOPE_STEPS) / code.scale
    }

    /// Least and greatest code of upper and lower ends, but for those on the ground; `None`: nothing stands. Of placed objects those of
    /// all that they have.
    pub fn codes(&self, objects: &SharedObjects) -> Option<(u16, u16)> {
        let placed = |placement: &Placement| {
            let object = objects.get(*placement).map(|object| object.codes(placement.foot));
            object.into_iter().flatten()
        };
        let ends = self.spans().iter().flat_map(|span| [span.low, span.high]);
        let ends = ends.chain(self.placements.iter().flat_map(placed)).filter(|code| *code > 0);
        ends.clone().min().zip(ends.max())
    }

    /// Whether nothing stands.
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty() && self.placements.is_empty()
    }

    /// Bytes in a page: none for no spans.
    pub fn bytes(&self) -> usize {
        if self.is_empty() { 0 } else { self.layout().end }
    }

    fn layout(&self) -> Layout {
        let Self { blocks, starts, spans, placements, facades, .. } = self;
        layout(blocks.len(), [starts.len() - 1, spans.len(), placements.len(), facades.len()])
    }

    /// Writes it into `bytes`, which are [`Self::bytes`] long.
    pub(super) fn encode(&self, bytes: &mut [u8]) {
        let Layout { blocks, starts, spans, placed, placements, facades, .. } = self.layout();
        for (field, count) in [
            (at::VOXELS, self.starts.len() - 1),
            (at::SPANS, self.spans.len()),
            (at::PLACEMENTS, self.placements.len()),
            (at::FACADES, self.facades.len()),
        ] {
            field.put(bytes, &(count as u32).to_le_bytes());
        }
        bytes[placed].copy_from_slice(bytemuck::cast_slice(&self.placed));
        bytes[placements].copy_from_slice(bytemuck::cast_slice(&self.placements));
        bytes[blocks].copy_from_slice(bytemuck::cast_slice(&self.blocks));
        bytes[starts].copy_from_slice(bytemuck::cast_slice(&self.starts));
        bytes[spans].copy_from_slice(bytemuck::cast_slice(&self.spans));
        bytes[facades].copy_from_slice(bytemuck::cast_slice(&self.facades));
    }

    /// The same, borrowed; `width` is that of the page.
    pub fn view(&self, width: u32) -> SpansView<'_> {
        let Self { blocks, starts, placed, placements, .. } = self;
        let (blocks_across, spans) = (width.div_ceil(BLOCK_SIDE), self.spans());
        SpansView { blocks_across, blocks, starts, spans, placed, placements }
    }
}

/// Positions of a table's parts in its bytes.
struct Layout {
    blocks: Range<usize>,
    starts: Range<usize>,
    spans: Range<usize>,
    placed: Range<usize>,
    placements: Range<usize>,
    facades: Range<usize>,
    end: usize,
}

/// Lays out the parts, of so many blocks and so many of voxels, spans, placements and façades.
fn layout(blocks: usize, [voxels, spans, placements, facades]: [usize; 4]) -> Layout {
    let numbers = if placements == 0 { 0 } else { blocks + 1 };
    let blocks = at::SIZE..at::SIZE + blocks * size_of::<SpanBlock>();
    let starts = blocks.end..blocks.end + (voxels + 1) * size_of::<u32>();
    let first = starts.end.next_multiple_of(at::ALIGNMENT);
    let spans = first..first + spans * size_of::<StoredSpan>();
    let first = spans.end.next_multiple_of(size_of::<u32>());
    let placed = first..first + numbers * size_of::<u32>();
    let first = placed.end.next_multiple_of(at::ALIGNMENT);
    let placements = first..first + placements * size_of::<Placement>();
    let facades = placements.end..placements.end + facades * size_of::<Facade>();
    Layout {
        end: facades.end.next_multiple_of(PLANE_ALIGNMENT),
        blocks,
        starts,
        spans,
        placed,
        placements,
        facades,
    }
}

/// Columns and rows of the blocks of a page, row by row.
fn blocks_of(width: u32, height: u32) -> impl Iterator<Item = (Range<u32>, Range<u32>)> {
    let parts = |size: u32| {
        (0..size.div_ceil(BLOCK_SIDE)).map(move |part| part * BLOCK_SIDE..size.min((part + 1) * BLOCK_SIDE))
    };
    parts(height).flat_map(move |rows| parts(width).map(move |columns| (columns, rows.clone())))
}

impl<'a> SpansView<'a> {
    /// No spans.
    pub const NONE: Self = Self {
        blocks_across: 0,
        blocks: &[],
        starts: &[],
        spans: StoredSpans::NONE,
        placed: &[],
        placements: &[],
    };

    /// Views the bytes of a table as that of a page of `size` voxels.
    pub(super) fn new(bytes: &'a [u8], size: Size) -> Result<Self, String> {
        if bytes.is_empty() {
            return Ok(Self::NONE);
        }

        let Size { width, height } = size;
        let refuse = || format!("{} bytes hold no spans of {width} x {height} voxels", bytes.len());
        let head = bytes.get(..at::SIZE).ok_or_else(refuse)?;
        let voxels = at::VOXELS.u32(head);
        let across = width.div_ceil(BLOCK_SIDE);
        let block_count = across as usize * height.div_ceil(BLOCK_SIDE) as usize;
        let fields = [at::VOXELS, at::SPANS, at::PLACEMENTS, at::FACADES];
        let counts = fields.each(|field| field.u32(head) as usize);
        let [_, span_count, _, facade_count] = counts;
        let Layout { blocks, starts, spans, placed, placements, facades, end } = layout(block_count, counts);
        if voxels > width * height || end != bytes.len() || (facade_count > 0 && facade_count != span_count) {
            return Err(refuse());
        }

        Ok(Self {
            blocks_across: across,
            blocks: plane(&bytes[blocks])?,
            starts: plane(&bytes[starts])?,
            spans: StoredSpans::new(plane(&bytes[spans])?, plane(&bytes[facades])?),
            placed: plane(&bytes[placed])?,
            placements: plane(&bytes[placements])?,
        })
    }

    /// All blocks, row by row from the south.
    pub fn blocks(&self) -> &'a [SpanBlock] {
        self.blocks
    }

    /// All spans, block by block.
    pub fn all(&self) -> StoredSpans<'a> {
        self.spans
    }

    /// Objects that stand on the page, once for each block that they reach.
    pub fn placements(&self) -> &'a [Placement] {
        self.placements
    }

    /// Lists the placements that reach the block of voxel (x, y).
    #[inline]
    pub fn placements_at(&self, x: u32, y: u32) -> &'a [Placement] {
        self.placements_of((y / BLOCK_SIDE * self.blocks_across + x / BLOCK_SIDE) as usize)
    }

    fn placements_of(&self, block: usize) -> &'a [Placement] {
        match self.placed.get(block..=block.saturating_add(1)) {
            Some(&[start, end]) => self.placements.get(start as usize..end as usize).unwrap_or_default(),
            _ => &[],
        }
    }

    /// The block of voxel (x, y); an empty one if there is none.
    #[inline]
    pub fn block(&self, x: u32, y: u32) -> SpanBlock {
        let index = y / BLOCK_SIDE * self.blocks_across + x / BLOCK_SIDE;
        self.blocks.get(index as usize).copied().unwrap_or_default()
    }

    /// Height codes that nothing leaves in `count` × `count` blocks, of which that of voxel (x, y) is the south-west one: the lower one 0 if something stands on
    /// the ground there, both 0 where nothing stands.
    #[inline]
    pub fn reach(&self, x: u32, y: u32, count: u32) -> [u16; 2] {
        let [column, row] = [x, y].each(|at| at / BLOCK_SIDE);
        let columns = column..(column + count).min(self.blocks_across);
        let rows = (row..row + count).map_while(|row| {
            let [from, to] =
                [columns.start, columns.end].each(|column| (row * self.blocks_across + column) as usize);
            self.blocks.get(from..to)
        });
        let standing = rows.flatten().filter(|block| block.high > 0).map(|block| [block.low, block.high]);
        standing.reduce(|[low, high], other| [low.min(other[0]), high.max(other[1])]).unwrap_or_default()
    }

    /// Whether a voxel lies on the page.
    pub(super) fn has_block(&self, [x, y]: [u32; 2]) -> bool {
        x / BLOCK_SIDE < self.blocks_across
            && ((y / BLOCK_SIDE * self.blocks_across) as usize) < self.blocks.len()
    }

    /// Spans of voxel (x, y) of the page, which lies in `block`.
    #[inline]
    pub fn of(&self, block: &SpanBlock, x: u32, y: u32) -> StoredSpans<'a> {
        let bit = 1_u64 << (y % BLOCK_SIDE * BLOCK_SIDE + x % BLOCK_SIDE);
        if block.occupied & bit == 0 {
            return StoredSpans::NONE;
        }
        let number = block.first as usize + (block.occupied & (bit - 1)).count_ones() as usize;
        match self.starts.get(number..=number.saturating_add(1)) {
            Some(&[start, end]) => self.spans.get(start as usize..end as usize).unwrap_or_default(),
            _ => StoredSpans::NONE,
        }
    }

    /// Spans of voxel (x, y) of the page.
    pub fn at(&self, x: u32, y: u32) -> StoredSpans<'a> {
        self.of(&self.block(x, y), x, y)
    }

    /// Says what contradicts itself, if something does; `rise` as for [`SpanTable::new`].
    pub(super) fn check(&self, rise: f64, objects: &SharedObjects) -> Option<String> {
        let mut first = 0;
        for block in self.blocks {
            if block.first != first {
                return Some(format!("a block of spans begins with voxel {}, not {first}", block.first));
            }

            let last = first + block.occupied.count_ones();
            let Some(starts) = self.starts.get(first as usize..=last as usize) else {
                return Some("its blocks of spans say more voxels than there are".into());
            };

            for ends in starts.windows(2) {
                let Some(spans) =
                    self.spans.get(ends[0] as usize..ends[1] as usize).filter(|spans| !spans.is_empty())
                else {
                    return Some(format!("a voxel has spans {} to {}", ends[0], ends[1]));
                };
                if let Some(what) = spans.iter().find_map(|span| check_span(&span, block, rise)) {
                    return Some(what);
                }
            }

            first = last;
        }

        let is_whole = self.blocks.is_empty()
            || (first as usize + 1 == self.starts.len()
                && self.starts.first() == Some(&0)
                && self.starts.last() == Some(&(self.spans.len() as u32)));
        if !is_whole {
            return Some("some of its spans belong to no voxel".into());
        }

        self.check_placements(objects)
    }

    fn check_placements(&self, objects: &SharedObjects) -> Option<String> {
        let mut before = 0;
        for (index, block) in self.blocks.iter().enumerate().filter(|_| !self.placed.is_empty()) {
            if self.placed[index] != before {
                return Some(format!(
                    "a block of placements begins with {}, not {before}",
                    self.placed[index]
                ));
            }

            let corner = [index as u32 % self.blocks_across, index as u32 / self.blocks_across]
                .each(|at| at * BLOCK_SIDE);
            let placements = self.placements_of(index);
            for &placement in placements {
                let Some(object) = objects.get(placement) else {
                    return Some(format!("object {} is placed, but there is none", placement.number()));
                };

                let size = object.size(placement);
                let reaches = (0..2).all(|axis| {
                    let (first, corner) = (i64::from(placement.first[axis]), i64::from(corner[axis]));
                    first < corner + i64::from(BLOCK_SIDE) && first + i64::from(size[axis]) > corner
                });
                if !reaches {
                    return Some(format!("object {} is placed beside its block", placement.number()));
                }
                if let Some(what) = leaves("an object", object.codes(placement.foot), block) {
                    return Some(what);
                }
            }

            before += placements.len() as u32;
        }

        let is_whole =
            before as usize == self.placements.len() && self.placed.last().is_none_or(|end| *end == before);
        (!is_whole).then(|| "some of its placements belong to no block".into())
    }

    /// A copy that owns its memory.
    pub fn to_table(&self) -> SpanTable {
        SpanTable {
            blocks: self.blocks.to_vec(),
            starts: self.starts.to_vec(),
            spans: self.spans.own(),
            facades: self.spans.facades(),
            placed: self.placed.to_vec(),
            placements: self.placements.to_vec(),
        }
    }
}

fn check_span(span: &Span, block: &SpanBlock, rise: f64) -> Option<String> {
    leaves("a span", span.reach(rise), block).or_else(|| span.check())
}

fn leaves(what: &str, [low, high]: [u16; 2], block: &SpanBlock) -> Option<String> {
    let is_within = low >= block.low && high <= block.high;
    (!is_within).then(|| {
        format!("{what} from code {low} to {high} leaves its block's {} to {}", block.low, block.high)
    })
}

fn plane<T: bytemuck::AnyBitPattern>(bytes: &[u8]) -> Result<&[T], String> {
    bytemuck::try_cast_slice(bytes).map_err(|error| format!("spans that cannot be mapped here ({error})"))
}
