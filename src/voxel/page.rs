//! One page: the planes of a square block of voxels.

use std::ops::Range;

use super::format::{PLANE_ALIGNMENT, page as at};
use super::{BARE, PageEntry, PageId, Relief, SpanTable, SpansView, zeros};
use crate::voxel::{APRON, PagePart, RELIEF_APRON};
use hedgehop_base::Size;

/// Material and origin of a voxel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Attributes {
    /// Index into [`super::Metadata::sources`] of the elevation source.
    pub source: u16,
    /// Material class, 0 = unknown.
    pub material: u8,
    /// Bits [`Self::VOID`], [`Self::NO_IMAGERY`] and, never stored, [`Self::STAND_IN`].
    pub flags: u8,
}

impl Attributes {
    /// The elevation source had no data here; the height was filled, or there is no surface.
    pub const VOID: u8 = 1;
    /// No imagery covered the voxel; its colour was derived from height and slope.
    pub const NO_IMAGERY: u8 = 2;
    /// The page that should be seen here is damaged, and a coarser level stands in for it. This is said of what is seen; no page says it.
    pub const STAND_IN: u8 = 4;
}

/// A page's planes in memory, as the modeller makes them. Row 0 is the southernmost.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageBuffer {
    /// Voxels eastward, 1..=PAGE_SIDE.
    pub width: u32,
    /// Voxels northward, 1..=PAGE_SIDE.
    pub height: u32,
    /// Mean height codes with apron, `[height + 12][width + 12]`.
    pub heights: Vec<u16>,
    /// Lower bound codes, `[height][width]`; empty at level index 0. See FORMAT.md for what is bounded.
    pub low: Vec<u16>,
    /// Upper bound codes, `[height][width]`; empty at level index 0.
    pub high: Vec<u16>,
    /// sRGB-encoded colours with apron, `[height + 12][width + 12]`.
    pub colours: Vec<[u8; 3]>,
    /// Slopes under the voxels with apron, `[height + 10][width + 10]`; empty at level index 0.
    pub relief: Vec<Relief>,
    /// Attributes, `[height][width]`.
    pub attributes: Vec<Attributes>,
    /// Spans that stand on the voxels; empty but for bare ground.
    pub spans: SpanTable,
}

/// A page's bytes as they go to disk, with their checksums.
#[derive(Debug, Clone)]
pub struct EncodedPage {
    /// Number of the page.
    pub id: PageId,
    /// Bytes as stored; none of a page without any surface, of which the directory says all.
    pub bytes: Vec<u8>,
    /// Bytes among them that are spans.
    pub spans: u32,
    /// CRC-32 of each part of them, in the order of [numbers](PagePart::number); without bytes, as [`PageEntry`] has them.
    pub crc: [u32; PagePart::COUNT],
    /// First 16 bytes of BLAKE3 of `bytes`, or of the attributes.
    pub hash: [u8; 16],
}

/// A page's planes where they lie, after validation. Shapes as in [`PageBuffer`].
#[derive(Debug, Clone, Copy)]
pub struct PageView<'a> {
    /// Voxels eastward.
    pub width: u32,
    /// Voxels northward.
    pub height: u32,
    /// Mean height codes with apron, row stride `width + 12`.
    pub heights: &'a [u16],
    /// Lower bounds, and upper bounds below: of a page as a whole alone, and not at level index 0. Others ask
    /// [`super::PageSource::bounds`] for them.
    pub(super) low: &'a [u16],
    pub(super) high: &'a [u16],
    /// sRGB-encoded colours with apron, row stride `width + 12`.
    pub colours: &'a [[u8; 3]],
    /// Slopes under the voxels with apron, row stride `width + 10`; empty at level index 0.
    pub relief: &'a [Relief],
    /// Attributes, row stride `width`, or one element that holds for all voxels.
    pub attributes: &'a [Attributes],
    /// Spans: of a page as a whole alone, as bounds. Others ask [`super::PageSource::spans`].
    pub(super) spans: SpansView<'a>,
}

/// The heights of a page. Shape as in [`PageBuffer`].
#[derive(Debug, Clone, Copy)]
pub struct HeightsView<'a> {
    /// Voxels eastward.
    pub width: u32,
    /// Mean height codes with apron, row stride `width + 12`.
    pub heights: &'a [u16],
}

/// The planes of a page that bound what is finer. Shapes as in [`PageBuffer`].
#[derive(Debug, Clone, Copy)]
pub struct BoundsView<'a> {
    /// Voxels eastward.
    pub width: u32,
    /// Lower bounds, row stride `width`; empty at level index 0.
    pub low: &'a [u16],
    /// Upper bounds, row stride `width`; empty at level index 0.
    pub high: &'a [u16],
}

/// Positions of the planes in a page's bytes.
pub(super) struct PageLayout {
    heights: Range<usize>,
    pub(super) low: Range<usize>,
    high: Range<usize>,
    spans: Range<usize>,
    pub(super) colours: Range<usize>,
    relief: Range<usize>,
    attributes: Range<usize>,
}

impl PageLayout {
    /// Lays out a page of `size` voxels (at most PAGE_SIDE a side), with so many bytes of spans.
    pub(super) fn new(size: Size, flags: u32, spans: usize) -> Self {
        let Size { width, height } = size;
        let voxels = width as usize * height as usize;
        let with_apron = |apron: u32| (width + 2 * apron) as usize * (height + 2 * apron) as usize;
        let samples = with_apron(APRON);
        let is_coarse = flags & at::FLAG_BOUNDS != 0;
        let bounds = if is_coarse { voxels } else { 0 };
        let reliefs = if is_coarse { with_apron(RELIEF_APRON) } else { 0 };
        let attributes = if flags & at::FLAG_UNIFORM != 0 { 1 } else { voxels };
        let mut end = at::SIZE;
        let mut plane = |bytes: usize| {
            let start = end.next_multiple_of(PLANE_ALIGNMENT);
            end = start + bytes;
            start..end
        };

        Self {
            heights: plane(samples * size_of::<u16>()),
            low: plane(bounds * size_of::<u16>()),
            high: plane(bounds * size_of::<u16>()),
            spans: plane(spans),
            colours: plane(samples * size_of::<[u8; 3]>()),
            relief: plane(reliefs * size_of::<Relief>()),
            attributes: plane(attributes * size_of::<Attributes>()),
        }
    }

    /// Lays out a page of `length` bytes; `None`: no page is so long.
    fn of_length(level: u8, size: Size, [length, spans]: [usize; 2]) -> Option<Self> {
        if spans > length || (level != BARE && spans > 0) {
            return None;
        }
        let flags = [bounds_flag(level) | at::FLAG_UNIFORM, bounds_flag(level)];
        flags.into_iter().map(|flags| Self::new(size, flags, spans)).find(|layout| layout.length() == length)
    }

    fn length(&self) -> usize {
        self.attributes.end
    }
}

/// The most bytes that a page of this size can take, besides spans.
pub(super) fn largest_page(level: u8, width: u32, height: u32) -> usize {
    PageLayout::new(Size { width, height }, bounds_flag(level), 0).length()
}

/// Whether a page of a level and a size can have so many bytes, and so many of spans.
pub(super) fn is_page_length(level: u8, size: Size, lengths: [usize; 2]) -> bool {
    PageLayout::of_length(level, size, lengths).is_some()
}

impl PagePart {
    /// Finds the part in the `length` bytes of its page, of `size` voxels, of which `spans` are spans.
    pub(super) fn range(self, size: Size, [length, spans]: [usize; 2]) -> Range<usize> {
        let layout = PageLayout::new(size, bounds_flag(self.page().level), spans);
        match self {
            Self::Heights(_) => 0..layout.low.start,
            Self::Bounds(_) | Self::Spans(_) => layout.low.start..layout.colours.start,
            Self::Paint(_) => layout.colours.start..length,
        }
    }
}

pub(super) fn bounds_flag(level: u8) -> u32 {
    if level > 0 && level != BARE { at::FLAG_BOUNDS } else { 0 }
}

/// Positions of the planes in a page's bytes, which begin at a multiple of 64 in memory.
pub(super) struct PlanePositions<'a> {
    bytes: &'a [u8],
    size: Size,
    spans: usize,
    layout: PageLayout,
    /// Attributes of all voxels of a page that has no bytes.
    empty: Option<&'a Attributes>,
}

impl<'a> PlanePositions<'a> {
    /// Finds the planes of a page of a level and of `size` voxels, as the grid says, with so many bytes of spans, as the directory says. An error says why
    /// there is no such page.
    pub fn new(bytes: &'a [u8], level: u8, size: Size, spans: u32) -> Result<Self, String> {
        let spans = spans as usize;
        let layout = PageLayout::of_length(level, size, [bytes.len(), spans]).ok_or_else(|| {
            let Size { width, height } = size;
            format!("{} bytes hold no page of {width} x {height} voxels", bytes.len())
        })?;
        Ok(Self { bytes, size, spans, layout, empty: None })
    }

    /// Makes the planes of a page without any surface.
    pub fn empty(level: u8, size: Size, attributes: &'a Attributes) -> Self {
        let layout = PageLayout::new(size, bounds_flag(level) | at::FLAG_UNIFORM, 0);
        Self { bytes: &[], size, spans: 0, layout, empty: Some(attributes) }
    }

    /// Whether the page's header agrees with what the directory and the grid say of page `id`; an error names what contradicts.
    pub fn check_header(&self, id: PageId) -> Result<(), String> {
        let record = &self.bytes[..at::SIZE];
        let stated = (at::LEVEL.u32(record), at::PX.u32(record), at::PY.u32(record));
        if stated != (u32::from(id.level), id.px, id.py) {
            return Err(format!(
                "the page says that it is level index {}, ({}, {})",
                stated.0, stated.1, stated.2
            ));
        }

        let size = Size { width: at::WIDTH.u32(record), height: at::HEIGHT.u32(record) };
        if size != self.size {
            return Err(format!(
                "a page of {} x {} voxels, but the grid says {} x {}",
                size.width, size.height, self.size.width, self.size.height
            ));
        }

        let flags = at::FLAGS.u32(record);
        if flags & !at::FLAG_UNIFORM != bounds_flag(id.level)
            || at::RESERVED.bytes(record).iter().any(|&b| b != 0)
        {
            return Err(format!("a page with unknown planes (flags {flags})"));
        }

        let length = PageLayout::new(size, flags, self.spans).length();
        if self.bytes.len() != length {
            return Err(format!("a page of {} bytes instead of {length}", self.bytes.len()));
        }

        Ok(())
    }

    /// CRC-32 of a part.
    pub fn crc(&self, part: PagePart) -> u32 {
        part_crc(self.bytes, part, self.size, self.spans)
    }

    fn plane<T: bytemuck::AnyBitPattern>(&self, range: &Range<usize>) -> Result<&'a [T], String> {
        let bytes = if self.empty.is_some() { zeros::plane(range.len()) } else { &self.bytes[range.clone()] };
        bytemuck::try_cast_slice(bytes)
            .map_err(|error| format!("a page that cannot be mapped here ({error})"))
    }

    pub fn heights(&self) -> Result<HeightsView<'a>, String> {
        Ok(HeightsView { width: self.size.width, heights: self.plane(&self.layout.heights)? })
    }

    pub fn bounds(&self) -> Result<BoundsView<'a>, String> {
        let (low, high) = (self.plane(&self.layout.low)?, self.plane(&self.layout.high)?);
        Ok(BoundsView { width: self.size.width, low, high })
    }

    pub fn spans(&self) -> Result<SpansView<'a>, String> {
        SpansView::new(self.plane(&self.layout.spans)?, self.size)
    }

    /// Heights and paint.
    pub fn posts(&self) -> Result<PageView<'a>, String> {
        let Size { width, height } = self.size;
        Ok(PageView {
            width,
            height,
            heights: self.plane(&self.layout.heights)?,
            low: &[],
            high: &[],
            colours: self.plane(&self.layout.colours)?,
            relief: self.plane(&self.layout.relief)?,
            attributes: match self.empty {
                Some(attributes) => std::slice::from_ref(attributes),
                None => self.plane(&self.layout.attributes)?,
            },
            spans: SpansView::NONE,
        })
    }

    /// All of them.
    pub fn whole(&self) -> Result<PageView<'a>, String> {
        let BoundsView { low, high, .. } = self.bounds()?;
        Ok(PageView { low, high, spans: self.spans()?, ..self.posts()? })
    }
}

/// CRC-32 of a part of a page of `size` voxels, from the page's bytes.
pub(super) fn part_crc(bytes: &[u8], part: PagePart, size: Size, spans: usize) -> u32 {
    crc32fast::hash(&bytes[part.range(size, [bytes.len(), spans])])
}

impl<'a> PageView<'a> {
    pub(super) fn heights(&self) -> HeightsView<'a> {
        HeightsView { width: self.width, heights: self.heights }
    }

    /// Place of voxel (x, y) in the planes of heights and colours.
    pub fn sample(&self, x: u32, y: u32) -> usize {
        ((y + APRON) * (self.width + 2 * APRON) + x + APRON) as usize
    }

    /// Attributes of voxel (x, y) of the page.
    pub fn attributes_at(&self, x: u32, y: u32) -> Attributes {
        match self.attributes {
            [uniform] => *uniform,
            plane => plane[(y * self.width + x) as usize],
        }
    }

    /// A copy that owns its planes.
    pub fn to_buffer(&self) -> PageBuffer {
        let voxels = self.width as usize * self.height as usize;
        PageBuffer {
            width: self.width,
            height: self.height,
            heights: self.heights.to_vec(),
            low: self.low.to_vec(),
            high: self.high.to_vec(),
            colours: self.colours.to_vec(),
            relief: self.relief.to_vec(),
            attributes: match self.attributes {
                [uniform] => vec![*uniform; voxels],
                plane => plane.to_vec(),
            },
            spans: self.spans.to_table(),
        }
    }
}

impl PageBuffer {
    /// The page's bytes and checksums, ready to be appended: no bytes at all if there is no surface and all voxels are alike.
    ///
    /// # Panics
    ///
    /// If the planes do not have the shapes that `width`, `height` and the level ask for.
    pub fn encode(&self, id: PageId) -> EncodedPage {
        match self.entry_alone(id) {
            Some(PageEntry { spans, crc, hash, .. }) => {
                EncodedPage { id, bytes: Vec::new(), spans, crc, hash }
            }
            None => self.encode_in_full(id),
        }
    }

    /// The same with all of its bytes, whatever the page.
    pub(super) fn encode_in_full(&self, id: PageId) -> EncodedPage {
        let uniform = self.attributes.iter().all(|attributes| *attributes == self.attributes[0]);
        let flags = bounds_flag(id.level) | if uniform { at::FLAG_UNIFORM } else { 0 };
        let size = Size { width: self.width, height: self.height };
        let spans = self.spans.bytes();
        let layout = PageLayout::new(size, flags, spans);
        let mut bytes = vec![0; layout.length()];

        for (field, value) in [
            (at::LEVEL, u32::from(id.level)),
            (at::PX, id.px),
            (at::PY, id.py),
            (at::WIDTH, self.width),
            (at::HEIGHT, self.height),
            (at::FLAGS, flags),
        ] {
            field.put(&mut bytes, &value.to_le_bytes());
        }

        let attributes = if uniform { &self.attributes[..1] } else { &self.attributes[..] };
        bytes[layout.heights].copy_from_slice(bytemuck::cast_slice(&self.heights));
        bytes[layout.low].copy_from_slice(bytemuck::cast_slice(&self.low));
        bytes[layout.high].copy_from_slice(bytemuck::cast_slice(&self.high));
        if spans > 0 {
            self.spans.encode(&mut bytes[layout.spans]);
        }

        bytes[layout.colours].copy_from_slice(bytemuck::cast_slice(&self.colours));
        bytes[layout.relief].copy_from_slice(bytemuck::cast_slice(&self.relief));
        bytes[layout.attributes].copy_from_slice(bytemuck::cast_slice(attributes));
        let mut crc = [0; PagePart::COUNT];
        PagePart::all(id).for_each(|part| crc[part.number()] = part_crc(&bytes, part, size, spans));

        EncodedPage { id, spans: spans as u32, crc, hash: page_hash(&bytes), bytes }
    }

    /// The planes, borrowed.
    pub fn view(&self) -> PageView<'_> {
        PageView {
            width: self.width,
            height: self.height,
            heights: &self.heights,
            low: &self.low,
            high: &self.high,
            colours: &self.colours,
            relief: &self.relief,
            attributes: &self.attributes,
            spans: self.spans.view(self.width),
        }
    }
}

/// First 16 bytes of BLAKE3 of a page's bytes.
pub(super) fn page_hash(bytes: &[u8]) -> [u8; 16] {
    let mut hash = [0; 16];
    hash.copy_from_slice(&blake3::hash(bytes).as_bytes()[..16]);
    hash
}
