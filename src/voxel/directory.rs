//! Position of each page in a file.

use super::format::{EMPTY_SINCE, Field, PAGE_ALIGNMENT, PAGE_LIMIT, entry};
use super::page::is_page_length;
use super::{BARE, Grid, PAGE_SIDE, PageId, PagePart};
use crate::voxel::PageEntry;
use hedgehop_base::Size;

/// Bytes that a page's entry takes in a file.
pub const ENTRY_BYTES: usize = entry::SIZE;

/// Fields of an entry for the checksums of a page's parts.
pub(super) const CRC: [Field; PagePart::COUNT] = [entry::HEIGHTS_CRC, entry::SECOND_CRC, entry::PAINT_CRC];

impl PageEntry {
    /// Returns the lengths of the page and of its spans, bytes.
    pub(super) fn lengths(&self) -> [usize; 2] {
        [self.length as usize, self.spans as usize]
    }

    /// Whether there is no such page; all fields are zero then.
    pub fn is_absent(&self) -> bool {
        *self == Self::default()
    }

    fn decode(record: &[u8]) -> Self {
        Self {
            offset: entry::OFFSET.u64(record),
            length: entry::LENGTH.u32(record),
            spans: entry::SPANS.u32(record),
            crc: CRC.map(|field| field.u32(record)),
            hash: entry::HASH.array(record),
        }
    }

    fn encode(&self, record: &mut [u8]) {
        entry::OFFSET.put(record, &self.offset.to_le_bytes());
        entry::LENGTH.put(record, &self.length.to_le_bytes());
        entry::SPANS.put(record, &self.spans.to_le_bytes());
        CRC.iter().zip(self.crc).for_each(|(field, crc)| field.put(record, &crc.to_le_bytes()));
        entry::HASH.put(record, &self.hash);
    }
}

#[derive(Debug, Clone, Copy)]
struct LevelPages {
    /// Number of the first one.
    first: usize,
    voxels: (u32, u32),
    pages_x: u32,
    pages_y: u32,
}

impl LevelPages {
    fn count(&self) -> usize {
        self.pages_x as usize * self.pages_y as usize
    }
}

/// One entry per page: level by level, rows from south to north, within a row from west to east; then, if something stands in the area,
/// the pages of bare ground.
#[derive(Debug, Clone)]
pub struct Directory {
    levels: Vec<LevelPages>,
    /// Whether there are entries for it or not.
    bare: LevelPages,
    entries: Vec<PageEntry>,
}

impl Directory {
    /// Pages of all levels together, bare ground apart, or what is wrong with a grid of so many.
    pub fn page_count(grid: &Grid) -> Result<u64, String> {
        let pages_of = |level| {
            let (x, y) = grid.page_dims(level);
            u64::from(x) * u64::from(y)
        };
        let pages = (0..grid.level_count()).map(pages_of).sum();
        if pages > PAGE_LIMIT {
            return Err(format!(
                "a grid of {} x {} voxels has {pages} pages, more than the {PAGE_LIMIT} that a database may \
                 have; take a larger --spacing or a smaller --bbox",
                grid.nx, grid.ny
            ));
        }
        Ok(pages)
    }

    /// A directory in which every page is absent.
    pub(super) fn empty(grid: &Grid) -> Result<Self, String> {
        let total = Self::page_count(grid)?;
        let mut first = 0;
        let mut pages_of = |level| {
            let (pages_x, pages_y) = grid.page_dims(level);
            let pages = LevelPages { first, voxels: grid.dims(level), pages_x, pages_y };
            first += pages.count();
            pages
        };
        let levels = (0..grid.level_count()).map(&mut pages_of).collect();
        Ok(Self { levels, bare: pages_of(BARE), entries: vec![PageEntry::default(); total as usize] })
    }

    /// Whether there are entries for bare ground.
    pub(super) fn has_bare(&self) -> bool {
        self.entries.len() > self.bare.first
    }

    /// Makes entries for bare ground.
    pub(super) fn extend_to_bare(&mut self) {
        self.entries.resize(self.bare.first + self.bare.count(), PageEntry::default());
    }

    /// Bytes that the entries of a grid take: without those for bare ground, and with them.
    pub(super) fn sizes(grid: &Grid) -> Result<[u64; 2], String> {
        let pages = Self::page_count(grid)?;
        let (x, y) = grid.page_dims(BARE);
        Ok([pages, pages + u64::from(x) * u64::from(y)].map(|pages| pages * entry::SIZE as u64))
    }

    /// Decodes the directory from a file of a version, whose length and checksum have been checked; pages lie between the
    /// fixed header and `pages_end`.
    pub(super) fn decode(grid: &Grid, bytes: &[u8], pages_end: u64, version: u32) -> Result<Self, String> {
        let mut directory = Self::empty(grid)?;
        if bytes.len() > directory.entries.len() * entry::SIZE {
            directory.extend_to_bare();
        }
        for (index, record) in bytes.chunks_exact(entry::SIZE).enumerate() {
            directory.entries[index] = PageEntry::decode(record);
        }
        for id in directory.ids() {
            directory.check(id, pages_end, version).map_err(|what| format!("directory, {id}: {what}"))?;
        }
        Ok(directory)
    }

    fn check(&self, id: PageId, pages_end: u64, version: u32) -> Result<(), String> {
        let Some((_, entry, size)) = self.locate(id) else {
            let coarsest = usize::from(id.level) + 1 == self.levels.len();
            return if coarsest { Err("the coarsest level must be complete".into()) } else { Ok(()) };
        };
        if version >= EMPTY_SINCE && entry.can_be_empty(id) {
            return Ok(());
        }

        let end = entry.offset.checked_add(u64::from(entry.length));
        let inside = entry.offset >= PAGE_ALIGNMENT && end.is_some_and(|end| end <= pages_end);
        if !inside
            || !entry.offset.is_multiple_of(PAGE_ALIGNMENT)
            || !is_page_length(id.level, size, entry.lengths())
        {
            return Err(format!("no page can lie at byte {}, length {}", entry.offset, entry.length));
        }

        let second = PagePart::numbered(1, id);
        if PagePart::all(id).all(|part| part != second) && entry.crc[second.number()] != 0 {
            return Err("a checksum of bounds, but the level has none".into());
        }

        Ok(())
    }

    pub(super) fn encode(&self) -> Vec<u8> {
        let mut bytes = vec![0; self.entries.len() * entry::SIZE];
        for (entry, record) in self.entries.iter().zip(bytes.chunks_exact_mut(entry::SIZE)) {
            entry.encode(record);
        }
        bytes
    }

    #[inline]
    fn level(&self, level: u8) -> Option<&LevelPages> {
        if level == BARE {
            return Some(&self.bare).filter(|_| self.has_bare());
        }
        self.levels.get(usize::from(level))
    }

    /// Number of a page in the order of the directory; `None` if the grid has no such page.
    #[inline]
    pub fn index(&self, id: PageId) -> Option<usize> {
        let level = self.level(id.level)?;
        (id.px < level.pages_x && id.py < level.pages_y)
            .then(|| level.first + id.py as usize * level.pages_x as usize + id.px as usize)
    }

    /// Entry of a page; `None` if it is absent.
    #[inline]
    pub fn get(&self, id: PageId) -> Option<&PageEntry> {
        self.index(id).map(|index| &self.entries[index]).filter(|entry| !entry.is_absent())
    }

    /// Number, entry and size in voxels of a page that is present.
    #[inline]
    pub(super) fn locate(&self, id: PageId) -> Option<(usize, &PageEntry, Size)> {
        let index = self.index(id)?;
        let (nx, ny) = self.level(id.level)?.voxels;
        let size = Size {
            width: (nx - id.px * PAGE_SIDE).min(PAGE_SIDE),
            height: (ny - id.py * PAGE_SIDE).min(PAGE_SIDE),
        };
        let entry = &self.entries[index];
        (!entry.is_absent()).then_some((index, entry, size))
    }

    /// Number of a page's part, below [`PagePart::COUNT`] times [`Self::len`]; `None` if the page is absent.
    #[inline]
    pub fn part_index(&self, part: PagePart) -> Option<usize> {
        let (page, ..) = self.locate(part.page())?;
        Some(part.number() * self.len() + page)
    }

    /// The same of a page that has bytes in the file; `None` for all others.
    #[inline]
    pub fn stored_part_index(&self, part: PagePart) -> Option<usize> {
        let (page, entry, _) = self.locate(part.page())?;
        (entry.length > 0).then(|| part.number() * self.len() + page)
    }

    /// Whether a page is stored, and has no bytes in the file because it has no surface.
    #[inline]
    pub fn is_empty_page(&self, id: PageId) -> bool {
        self.get(id).is_some_and(|entry| entry.empty().is_some())
    }

    /// The part with this number.
    pub fn part(&self, index: usize) -> PagePart {
        PagePart::numbered(index / self.len(), self.id(index % self.len()))
    }

    pub(super) fn set(&mut self, index: usize, entry: PageEntry) {
        self.entries[index] = entry;
    }

    /// Pages of the grid, present or not; those of bare ground are among them if one is present.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Never: every grid has pages.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The page with this number; numbers are below [`Self::len`].
    pub fn id(&self, index: usize) -> PageId {
        let (level, pages) = if index >= self.bare.first {
            (BARE, &self.bare)
        } else {
            let level = self.levels.partition_point(|level| level.first <= index) - 1;
            (level as u8, &self.levels[level])
        };
        let across = pages.pages_x as usize;
        let (row, column) = ((index - pages.first) / across, (index - pages.first) % across);
        PageId { level, px: column as u32, py: row as u32 }
    }

    /// All pages of the grid in order.
    pub fn ids(&self) -> impl Iterator<Item = PageId> {
        (0..self.len()).map(|index| self.id(index))
    }

    /// Present pages in order, with their entries.
    pub fn present(&self) -> impl Iterator<Item = (PageId, &PageEntry)> {
        self.ids().zip(&self.entries).filter(|(_, entry)| !entry.is_absent())
    }
}
