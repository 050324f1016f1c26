//! Place and checksums of a page.

use super::PagePart;

/// Place and checksums of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PageEntry {
    /// First byte in the file.
    pub offset: u64,
    /// Bytes; 0 of a page without any surface, which has none in the file.
    pub length: u32,
    /// Length of the spans within the page, bytes; 0 but for pages of bare ground.
    pub spans: u32,
    /// CRC-32 of each of its parts, in the order of their [numbers](PagePart::number); of a page without bytes the last one are the
    /// attributes of all its voxels.
    pub crc: [u32; PagePart::COUNT],
    /// First 16 bytes of BLAKE3 of the page, or of these attributes.
    pub hash: [u8; 16],
}
