//! One page: the planes of a square block of voxels.

use super::PageId;

/// Samples around a page's voxels that repeat the neighbours' (or, at the edge of the area, the
/// page's own), so that interpolation stays inside one page.
pub const APRON: u32 = 1;

/// What a voxel is made of and where it comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Attributes {
    /// Index into [`super::Metadata::sources`] of the elevation source.
    pub source: u16,
    /// Material class, 0 = unknown.
    pub material: u8,
    /// Bits [`Self::VOID`] and [`Self::NO_IMAGERY`].
    pub flags: u8,
}

impl Attributes {
    /// The elevation source had no data here; the height was filled, or there is no surface.
    pub const VOID: u8 = 1;
    /// No imagery covered the voxel; its colour was derived from height and slope.
    pub const NO_IMAGERY: u8 = 2;
}

/// A page's planes in memory, as the modeller makes them. Row 0 is the southernmost.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageBuffer {
    /// Voxels eastward, 1..=PAGE_SIDE.
    pub width: u32,
    /// Voxels northward, 1..=PAGE_SIDE.
    pub height: u32,
    /// Mean height codes with apron, `[height + 2][width + 2]`.
    pub heights: Vec<u16>,
    /// Lower bound codes, `[height][width]`; empty at level index 0. See FORMAT.md for what is bounded.
    pub low: Vec<u16>,
    /// Upper bound codes, `[height][width]`; empty at level index 0.
    pub high: Vec<u16>,
    /// sRGB-encoded colours with apron, `[height + 2][width + 2]`.
    pub colours: Vec<[u8; 3]>,
    /// Attributes, `[height][width]`.
    pub attributes: Vec<Attributes>,
}

/// A page's bytes as they go to disk, with their checksums.
#[derive(Debug, Clone)]
pub struct EncodedPage {
    /// Which page.
    pub id: PageId,
    /// Bytes as stored.
    pub bytes: Vec<u8>,
    /// CRC-32 of `bytes`.
    pub crc: u32,
    /// First 16 bytes of BLAKE3 of `bytes`.
    pub hash: [u8; 16],
}

/// A page's planes where they lie, after validation. Shapes as in [`PageBuffer`].
#[derive(Debug, Clone, Copy)]
pub struct PageView<'a> {
    /// Voxels eastward.
    pub width: u32,
    /// Voxels northward.
    pub height: u32,
    /// Mean height codes with apron, row stride `width + 2`.
    pub heights: &'a [u16],
    /// Lower bounds, row stride `width`; empty at level index 0.
    pub low: &'a [u16],
    /// Upper bounds, row stride `width`; empty at level index 0.
    pub high: &'a [u16],
    /// sRGB colours with apron, row stride `width + 2`.
    pub colours: &'a [[u8; 3]],
    /// Attributes, row stride `width`, or one element that holds for all voxels.
    pub attributes: &'a [Attributes],
}

impl PageView<'_> {
    /// Attributes of voxel (x, y) of the page.
    pub fn attributes_at(&self, x: u32, y: u32) -> Attributes {
        match self.attributes {
            [uniform] => *uniform,
            plane => plane[(y * self.width + x) as usize],
        }
    }
}

impl PageBuffer {
    /// The page's bytes and checksums, ready to be appended.
    pub fn encode(&self, id: PageId) -> EncodedPage {
        let _ = id;
        todo!()
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
            attributes: &self.attributes,
        }
    }
}
