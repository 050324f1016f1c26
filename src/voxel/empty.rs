//! Pages without any surface: their entry in the directory says all that there is to say of them, and they have no bytes.
//!
//! ```text
//! heights, bounds, colours, slopes:  zeros, the same for all such pages: no surface, black, level
//! attributes:                        one value for all voxels, in the entry
//! ```
//! Colours of voxels without a surface are never seen: means leave them out, and so does light. Pages beside such a page have their own in their aprons.

use super::page::page_hash;
use super::{
    APRON, Attributes, BARE, HeightCode, PageBuffer, PageEntry, PageId, PagePart, RELIEF_APRON, Relief,
    SpanTable,
};
use hedgehop_base::Size;

/// The part whose checksum gives its place to the attributes.
const ATTRIBUTES: usize = 2;

impl PageEntry {
    /// Builds the entry of a page without any surface, whose voxels all have these attributes.
    pub(super) fn of_empty(attributes: Attributes) -> Self {
        Self { hash: page_hash(bytemuck::bytes_of(&attributes)), ..Self::without_hash(attributes) }
    }

    /// Attributes of all voxels of a page without any surface, of which the file has nothing but this entry; `None`: the file has bytes of it.
    #[inline]
    pub fn empty(&self) -> Option<&Attributes> {
        (self.length == 0).then(|| bytemuck::cast_ref(&self.crc[ATTRIBUTES]))
    }

    /// Whether it can be the entry of page `id` as one without any surface; its hash is not looked at.
    pub(super) fn can_be_empty(&self, id: PageId) -> bool {
        let Some(attributes) = self.empty() else { return false };
        let plain = Self { hash: self.hash, ..Self::without_hash(*attributes) };
        id.level != BARE && attributes.is_known() && *self == plain
    }

    fn without_hash(attributes: Attributes) -> Self {
        let mut crc = [0; PagePart::COUNT];
        crc[ATTRIBUTES] = u32::from_le_bytes(bytemuck::cast(attributes));
        Self { crc, ..Self::default() }
    }
}

impl Attributes {
    /// Whether its flags are among those that are stored.
    fn is_known(self) -> bool {
        self.flags & !(Self::VOID | Self::NO_IMAGERY) == 0
    }
}

impl PageBuffer {
    /// A page of `size` voxels without any surface.
    pub fn empty(id: PageId, size: Size, attributes: Attributes) -> Self {
        let Size { width, height } = size;
        let with_apron = |apron: u32| (width + 2 * apron) as usize * (height + 2 * apron) as usize;
        let voxels = with_apron(0);
        let is_coarse = id.level > 0 && !id.is_bare();
        let (bounds, reliefs) = if is_coarse { (voxels, with_apron(RELIEF_APRON)) } else { (0, 0) };
        Self {
            width,
            height,
            heights: vec![HeightCode::EMPTY; with_apron(APRON)],
            low: vec![HeightCode::EMPTY; bounds],
            high: vec![HeightCode::EMPTY; bounds],
            colours: vec![[0; 3]; with_apron(APRON)],
            relief: vec![Relief::default(); reliefs],
            attributes: vec![attributes; voxels],
            spans: SpanTable::default(),
        }
    }

    /// The entry that says all of the page, if it has no surface, nothing finer has one, and its voxels are all alike.
    pub(super) fn entry_alone(&self, id: PageId) -> Option<PageEntry> {
        let attributes = *self.attributes.first()?;
        let is_empty = |codes: &[u16]| codes.iter().all(|code| *code == HeightCode::EMPTY);
        let is_alone = !id.is_bare()
            && attributes.is_known()
            && is_empty(&self.heights)
            && is_empty(&self.low)
            && is_empty(&self.high)
            && self.relief.iter().all(|relief| *relief == Relief::default())
            && self.attributes.iter().all(|other| *other == attributes)
            && self.spans.bytes() == 0;
        is_alone.then(|| PageEntry::of_empty(attributes))
    }
}
