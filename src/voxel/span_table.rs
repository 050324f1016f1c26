//! The spans of a page, found by voxel.
//!
//! ```text
//! block (8 × 8 voxels): which of them have spans, 64 bits; the number of the first one that has
//!     voxel's number = the block's first + bits set before its own
//!         its spans  = starts[number] .. starts[number + 1], lowest first
//! ```
//!
//! Empty blocks are passed over by one look, and a voxel costs memory only if something stands on it. A voxel of 64 is found by
//! counting bits (Jacobson, "Space-efficient static trees and graphs", 1989).

use std::ops::Range;

use super::format::{PLANE_ALIGNMENT, spans as at};
use super::{HeightCode, Span};

/// Voxels along the side of a block.
pub const BLOCK_SIDE: u32 = 8;

/// What stands on 8 × 8 voxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SpanBlock {
    /// Voxels with spans: bit `8·y + x` is that of the voxel in column x and row y of the block.
    pub occupied: u64,
    /// How many voxels of the blocks before it have spans.
    pub first: u32,
    /// Height code that nothing reaches below, where all of it hangs in the air; else [`Span::GROUND`].
    pub low: u16,
    /// Height code that nothing rises above, slopes and all.
    pub high: u16,
}

/// Spans by voxel, in memory of their own.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SpanTable {
    blocks: Vec<SpanBlock>,
    starts: Vec<u32>,
    spans: Vec<Span>,
}

/// Spans by voxel, where they lie. What contradicts itself reads as nothing.
#[derive(Debug, Clone, Copy)]
pub struct SpansView<'a> {
    blocks_across: u32,
    blocks: &'a [SpanBlock],
    starts: &'a [u32],
    spans: &'a [Span],
}

impl SpanTable {
    /// Of a page of `width` × `height` voxels: `spans_of` appends those of a voxel (x, y), lowest first. `rise` is how many steps of height the
    /// steepest slope of one step rises over half a voxel's diagonal, see [`Self::rise`].
    pub fn new(
        (width, height): (u32, u32),
        rise: f64,
        mut spans_of: impl FnMut(u32, u32, &mut Vec<Span>),
    ) -> Self {
        let mut table = Self { starts: vec![0], ..Self::default() };
        for (columns, rows) in blocks_of(width, height) {
            let mut block =
                SpanBlock { first: table.starts.len() as u32 - 1, low: u16::MAX, ..SpanBlock::default() };
            for (row, y) in rows.enumerate() {
                for (column, x) in columns.clone().enumerate() {
                    let before = table.spans.len();
                    spans_of(x, y, &mut table.spans);
                    let added = &table.spans[before..];
                    if added.is_empty() {
                        continue;
                    }
                    block.occupied |= 1 << (row as u32 * BLOCK_SIDE + column as u32);
                    for span in added {
                        let [low, high] = Self::reach(span, rise);
                        (block.low, block.high) = (block.low.min(low), block.high.max(high));
                    }
                    table.starts.push(table.spans.len() as u32);
                }
            }
            if block.occupied == 0 {
                block.low = 0;
            }
            table.blocks.push(block);
        }
        if table.spans.is_empty() { Self::default() } else { table }
    }

    /// All of them, voxel by voxel.
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// How many codes a slope of one step rises or falls over half a voxel's diagonal, if a step of height is `scale` metres and a voxel
    /// `spacing` metres wide.
    pub fn rise(code: HeightCode, spacing: f64) -> f64 {
        0.5 * spacing / f64::from(Span::SLOPE_STEPS) / code.scale
    }

    /// Codes that a span lies between, wherever in its voxel. A slope of (a, b) rises by (|a| + |b|) / 2 at a corner.
    fn reach(span: &Span, rise: f64) -> [u16; 2] {
        let steps: f64 = span.slope.iter().map(|slope| f64::from(slope.unsigned_abs())).sum();
        let room = (steps * rise).ceil().min(f64::from(u16::MAX)) as u16;
        let low = match span.low {
            Span::GROUND => Span::GROUND,
            low if span.is(Span::PARALLEL) => low.saturating_sub(room).max(1),
            low => low,
        };
        [low, span.high.saturating_add(room)]
    }

    /// Least and greatest code of upper and lower ends, but for those on the ground; `None`: nothing stands.
    pub fn codes(&self) -> Option<(u16, u16)> {
        let ends = self.spans.iter().flat_map(|span| [span.low, span.high]).filter(|code| *code > 0);
        ends.clone().min().zip(ends.max())
    }

    /// Whether nothing stands.
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// Bytes in a page: none for no spans.
    pub fn bytes(&self) -> usize {
        if self.is_empty() {
            0
        } else {
            layout(self.blocks.len(), self.starts.len() - 1, self.spans.len()).end
        }
    }

    /// Writes it into `bytes`, which are [`Self::bytes`] long.
    pub(super) fn encode(&self, bytes: &mut [u8]) {
        let Layout { blocks, starts, spans, .. } =
            layout(self.blocks.len(), self.starts.len() - 1, self.spans.len());
        at::VOXELS.put(bytes, &(self.starts.len() as u32 - 1).to_le_bytes());
        at::SPANS.put(bytes, &(self.spans.len() as u32).to_le_bytes());
        bytes[blocks].copy_from_slice(bytemuck::cast_slice(&self.blocks));
        bytes[starts].copy_from_slice(bytemuck::cast_slice(&self.starts));
        bytes[spans].copy_from_slice(bytemuck::cast_slice(&self.spans));
    }

    /// The same, borrowed; `width` is that of the page.
    pub fn view(&self, width: u32) -> SpansView<'_> {
        let Self { blocks, starts, spans } = self;
        SpansView { blocks_across: width.div_ceil(BLOCK_SIDE), blocks, starts, spans }
    }
}

/// Where the parts of a table lie in its bytes.
struct Layout {
    blocks: Range<usize>,
    starts: Range<usize>,
    spans: Range<usize>,
    end: usize,
}

fn layout(blocks: usize, voxels: usize, spans: usize) -> Layout {
    let blocks = at::SIZE..at::SIZE + blocks * size_of::<SpanBlock>();
    let starts = blocks.end..blocks.end + (voxels + 1) * size_of::<u32>();
    let first = starts.end.next_multiple_of(size_of::<Span>());
    let spans = first..first + spans * size_of::<Span>();
    Layout { blocks, starts, end: spans.end.next_multiple_of(PLANE_ALIGNMENT), spans }
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
    pub const NONE: Self = Self { blocks_across: 0, blocks: &[], starts: &[], spans: &[] };

    /// Of a page of `width` × `height` voxels, from the bytes of its table.
    pub(super) fn new(bytes: &'a [u8], (width, height): (u32, u32)) -> Result<Self, String> {
        if bytes.is_empty() {
            return Ok(Self::NONE);
        }
        let refuse = || format!("{} bytes hold no spans of {width} x {height} voxels", bytes.len());
        let head = bytes.get(..at::SIZE).ok_or_else(refuse)?;
        let (voxels, count) = (at::VOXELS.u32(head), at::SPANS.u32(head));
        let across = width.div_ceil(BLOCK_SIDE);
        let block_count = across as usize * height.div_ceil(BLOCK_SIDE) as usize;
        let Layout { blocks, starts, spans, end } = layout(block_count, voxels as usize, count as usize);
        if voxels > width * height
            || end != bytes.len()
            || at::RESERVED.bytes(head).iter().any(|&byte| byte != 0)
        {
            return Err(refuse());
        }
        Ok(Self {
            blocks_across: across,
            blocks: plane(&bytes[blocks])?,
            starts: plane(&bytes[starts])?,
            spans: plane(&bytes[spans])?,
        })
    }

    /// All blocks, row by row from the south.
    pub fn blocks(&self) -> &'a [SpanBlock] {
        self.blocks
    }

    /// All spans, block by block.
    pub fn all(&self) -> &'a [Span] {
        self.spans
    }

    /// The block of voxel (x, y); an empty one if there is none.
    #[inline]
    pub fn block(&self, x: u32, y: u32) -> SpanBlock {
        let index = y / BLOCK_SIDE * self.blocks_across + x / BLOCK_SIDE;
        self.blocks.get(index as usize).copied().unwrap_or_default()
    }

    /// Spans of voxel (x, y) of the page, which lies in `block`.
    #[inline]
    pub fn of(&self, block: &SpanBlock, x: u32, y: u32) -> &'a [Span] {
        let bit = 1_u64 << (y % BLOCK_SIDE * BLOCK_SIDE + x % BLOCK_SIDE);
        if block.occupied & bit == 0 {
            return &[];
        }
        let number = block.first as usize + (block.occupied & (bit - 1)).count_ones() as usize;
        match self.starts.get(number..=number.saturating_add(1)) {
            Some(&[start, end]) => self.spans.get(start as usize..end as usize).unwrap_or_default(),
            _ => &[],
        }
    }

    /// Spans of voxel (x, y) of the page.
    pub fn at(&self, x: u32, y: u32) -> &'a [Span] {
        self.of(&self.block(x, y), x, y)
    }

    /// What contradicts itself, if something does; `rise` as for [`SpanTable::new`].
    pub(super) fn check(&self, rise: f64) -> Option<String> {
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
                if let Some(what) = spans.iter().find_map(|span| check_span(span, block, rise)) {
                    return Some(what);
                }
            }
            first = last;
        }
        let is_whole = self.blocks.is_empty()
            || (first as usize + 1 == self.starts.len()
                && self.starts.first() == Some(&0)
                && self.starts.last() == Some(&(self.spans.len() as u32)));
        (!is_whole).then(|| "some of its spans belong to no voxel".into())
    }

    /// A copy that owns its memory.
    pub fn to_table(&self) -> SpanTable {
        SpanTable { blocks: self.blocks.to_vec(), starts: self.starts.to_vec(), spans: self.spans.to_vec() }
    }
}

fn check_span(span: &Span, block: &SpanBlock, rise: f64) -> Option<String> {
    let [low, high] = SpanTable::reach(span, rise);
    if low < block.low || high > block.high {
        return Some(format!(
            "a span from code {low} to {high} leaves its block's {} to {}",
            block.low, block.high
        ));
    }
    let known = Span::OPACITY | Span::PARALLEL | Span::STRIP;
    let is_sound =
        span.state & Span::OPACITY != 0 && span.state & !known == 0 && span.low <= span.high && span.high > 0;
    (!is_sound).then(|| format!("a span of state {} from code {} to {}", span.state, span.low, span.high))
}

fn plane<T: bytemuck::AnyBitPattern>(bytes: &[u8]) -> Result<&[T], String> {
    bytemuck::try_cast_slice(bytes).map_err(|error| format!("spans that cannot be mapped here ({error})"))
}
