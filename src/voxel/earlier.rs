//! Pages of files that were written before, for a file that is to have the same ones.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use super::assembly::Storage;
use super::fixed_header::FixedHeader;
use super::format::{MAGIC, VERSION, header as at};
use super::page::{is_page_length, part_crc};
use super::{ContentHash, Grid, PageEntry, PageId, PagePart, open_to_read};

/// A file that pages are taken from: a database, or what is left of one that was not finished. While it is open nobody changes it in place.
#[derive(Debug, Clone)]
pub struct EarlierFile(Arc<File>);

/// A page of it that is as it was written.
#[derive(Debug, Clone)]
pub struct EarlierPage {
    /// Identity of the page.
    pub id: PageId,
    /// Position of the page, and its checksums.
    pub entry: PageEntry,
    file: EarlierFile,
}

impl EarlierPage {
    pub(super) fn file(&self) -> &File {
        self.file.file()
    }
}

impl EarlierFile {
    /// Opens a database; `None` if there is none that can be read.
    pub fn open(path: &Path) -> Option<Self> {
        // To open a pipe would wait for its other end.
        std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
        open_to_read(path).ok().map(|file| Self(Arc::new(file)))
    }

    /// Opens what is left of a file that a [`super::PageWriter`] wrote; `None` if there is none, or one that writes it still.
    pub fn open_abandoned(path: &Path) -> Option<Self> {
        std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
        let file = File::open(path).ok()?;
        file.try_lock_shared().is_ok().then(|| Self(Arc::new(file)))
    }

    pub(super) fn file(&self) -> &File {
        &self.0
    }

    /// Returns the content hash that a finished database states; `None` if it is none of this version.
    pub fn content_hash(&self) -> Option<ContentHash> {
        let mut record = [0; at::SIZE];
        self.0.read_at(0, &mut record).ok()?;
        let length = self.0.metadata().ok()?.len();
        let header = FixedHeader::decode_start(Path::new(""), &record, length).ok()?;
        (header.version == VERSION).then_some(header.content_hash)
    }

    /// The same of older versions, too, unchecked: enough to know a file again, not to read it. All versions have it at one place.
    pub fn identity(&self) -> Option<ContentHash> {
        let mut record = [0; at::SIZE];
        self.0.read_at(0, &mut record).ok()?;
        let is_older = record.starts_with(&MAGIC) && (1..VERSION).contains(&at::VERSION.u32(&record));
        if is_older { Some(ContentHash(at::CONTENT_HASH.array(&record))) } else { self.content_hash() }
    }

    /// A page of a grid that lies where `entry` says; `None` if what lies there is not what was written. `scratch` is for its bytes.
    pub fn page(
        &self,
        grid: &Grid,
        id: PageId,
        entry: &PageEntry,
        scratch: &mut Vec<u8>,
    ) -> Option<EarlierPage> {
        let (page, size) = (self.page_as_left(grid, id, entry)?, grid.page_size(id)?);
        if let Some(attributes) = entry.empty() {
            return (entry.hash == PageEntry::of_empty(*attributes).hash).then_some(page);
        }
        scratch.resize(entry.length as usize, 0);
        self.0.read_at(entry.offset, scratch).ok()?;
        let is_good =
            |part: PagePart| part_crc(scratch, part, size, entry.spans as usize) == entry.crc[part.number()];
        PagePart::all(id).all(is_good).then_some(page)
    }

    /// The same of a file that nobody changed: nothing of it is read. `None` if there can be no such page.
    pub fn page_as_left(&self, grid: &Grid, id: PageId, entry: &PageEntry) -> Option<EarlierPage> {
        let is_possible =
            entry.can_be_empty(id) || is_page_length(id.level, grid.page_size(id)?, entry.lengths());
        is_possible.then(|| EarlierPage { id, entry: *entry, file: self.clone() })
    }
}
