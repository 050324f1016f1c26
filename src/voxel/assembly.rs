//! Putting a database together: pages in the order of their coming, then directory, metadata and,
//! last, the header. Where the bytes go is behind [`Storage`], so that a database in memory
//! and one on disk are the same byte for byte.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use super::fixed_header::{FixedHeader, Section};
use super::format::{PAGE_ALIGNMENT, PLANE_ALIGNMENT, VERSION, header as at};
use super::page::{PlanePositions, largest_page};
use super::{
    AlignedBytes, Attributes, ContentHash, Directory, EncodedPage, Grid, HeightCode, HeightRange, Metadata,
    PageBuffer, PageEntry, PageId, PagePart, PageView, SharedObjects,
};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// Bytes that are written and read by position, from any thread. What has not been written is zero.
pub(super) trait Storage: Send + Sync {
    fn write_at(&self, offset: u64, bytes: &[u8]) -> io::Result<()>;
    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()>;
    /// Writes so many bytes of a file, from `from` on, at `offset`.
    fn copy_from(&self, offset: u64, file: &File, from: u64, length: usize) -> io::Result<()> {
        let mut bytes = vec![0; length];
        file.read_at(from, &mut bytes)?;
        self.write_at(offset, &bytes)
    }
    /// Waits until everything is on the disk.
    fn flush(&self) -> io::Result<()>;
}

/// Storage of a database in memory.
#[derive(Debug, Default)]
pub(super) struct MemoryStorage(Mutex<AlignedBytes>);

impl MemoryStorage {
    pub fn take(&self) -> AlignedBytes {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Storage for MemoryStorage {
    fn write_at(&self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        let start = usize::try_from(offset).map_err(io::Error::other)?;
        let mut memory = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if memory.as_slice().len() < start + bytes.len() {
            memory.resize(start + bytes.len());
        }
        memory.as_mut_slice()[start..start + bytes.len()].copy_from_slice(bytes);
        Ok(())
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        let start = usize::try_from(offset).map_err(io::Error::other)?;
        let memory = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let stored = memory.as_slice().get(start..start + bytes.len());
        bytes.copy_from_slice(stored.ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        Ok(())
    }
}

struct AssemblyState {
    /// Path that errors name.
    path: PathBuf,
    storage: Arc<dyn Storage>,
    grid: Grid,
    directory: RwLock<Directory>,
}

impl std::fmt::Debug for AssemblyState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shared").field("path", &self.path).field("grid", &self.grid).finish_non_exhaustive()
    }
}

/// A database that is being put together.
#[derive(Debug)]
pub(super) struct Assembly {
    shared: Arc<AssemblyState>,
    heights: HeightCode,
    /// First byte behind the last page.
    end: u64,
    /// Bytes that all pages may come to.
    most: u64,
}

impl Assembly {
    pub fn new(path: &Path, storage: Arc<dyn Storage>, grid: Grid, heights: HeightCode) -> Result<Self> {
        let invalid = |what| Error::invalid(path, what);
        grid.check().and_then(|()| heights.check()).map_err(invalid)?;
        let directory = RwLock::new(Directory::empty(&grid).map_err(invalid)?);
        let shared = AssemblyState { path: path.to_owned(), storage, grid, directory };
        let most = largest_file(&grid);
        Ok(Self { shared: Arc::new(shared), heights, end: PAGE_ALIGNMENT, most })
    }

    /// See [`super::PageWriter::append`].
    pub fn append(&mut self, page: &EncodedPage) -> Result<()> {
        let EncodedPage { id, spans, crc, hash, .. } = *page;
        let length = u32::try_from(page.bytes.len())
            .map_err(|_| Error::invalid(&self.shared.path, format!("{id}: too long")))?;
        let entry = PageEntry { offset: 0, length, spans, crc, hash };
        self.append_with(id, entry, |storage, offset| storage.write_at(offset, &page.bytes))
    }

    /// Appends a page that lies in a file: `entry` says where.
    pub fn append_copy(&mut self, id: PageId, entry: PageEntry, file: &File) -> Result<()> {
        let PageEntry { offset: from, length, .. } = entry;
        let length = length as usize;
        self.append_with(id, entry, |storage, offset| storage.copy_from(offset, file, from, length))
    }

    /// Appends a page whose bytes `write` puts where it is told.
    fn append_with(
        &mut self,
        id: PageId,
        entry: PageEntry,
        write: impl FnOnce(&dyn Storage, u64) -> io::Result<()>,
    ) -> Result<()> {
        let AssemblyState { path, grid, storage, .. } = &*self.shared;
        let refuse = |what: &str| Error::invalid(path, format!("{id}: {what}"));
        let size = grid.page_size(id).ok_or_else(|| refuse("the grid has no such page"))?;
        let [length, spans] = entry.lengths();
        if length > largest_page(id.level, size.width, size.height) + spans.next_multiple_of(PLANE_ALIGNMENT)
        {
            return Err(refuse("its planes are larger than the grid says"));
        }

        let mut directory = self.shared.directory.write().unwrap_or_else(PoisonError::into_inner);
        if id.is_bare() {
            directory.extend_to_bare();
        }

        let index = directory.index(id).ok_or_else(|| refuse("the grid has no such page"))?;
        if directory.get(id).is_some() {
            return Err(refuse("appended twice"));
        }
        if length == 0 {
            let entry = PageEntry { offset: 0, ..entry };
            if !entry.can_be_empty(id) {
                return Err(refuse("a page without bytes"));
            }
            directory.set(index, entry);
            return Ok(());
        }

        let offset = self.end.next_multiple_of(PAGE_ALIGNMENT);
        write(&**storage, offset)
            .map_err(|error| self.storage_error(&format!("write {length} bytes at byte {offset}"), error))?;
        self.end = offset + length as u64;
        directory.set(index, PageEntry { offset, ..entry });

        Ok(())
    }

    /// See [`super::PageWriter::expect`].
    pub fn expect(&mut self, bytes: u64) {
        self.most = PAGE_ALIGNMENT + bytes;
    }

    pub fn readback(&self) -> PageReadback {
        PageReadback { shared: Arc::clone(&self.shared) }
    }

    /// Writes what follows the pages, waits for the disk, then writes the header and waits again.
    /// Returns identity and bytes.
    pub fn seal(
        &self,
        metadata: &Metadata,
        objects: &SharedObjects,
        height_range: HeightRange,
    ) -> Result<(ContentHash, u64)> {
        let invalid = |what: String| Error::invalid(&self.shared.path, what);
        let directory = self.shared.directory.read().unwrap_or_else(PoisonError::into_inner);
        let json = metadata.to_json().map_err(invalid)?;
        let entries = directory.encode();
        let end = self.end.next_multiple_of(PLANE_ALIGNMENT as u64);
        let objects = objects.to_bytes();
        let objects_section =
            if objects.is_empty() { Section::default() } else { Section::of(end, &objects) };
        let section = Section::of(end + objects.len() as u64, &entries);
        let json_section = Section::of(section.offset + section.length, &json);

        let mut header = FixedHeader {
            version: VERSION,
            grid: self.shared.grid,
            heights: self.heights,
            height_range,
            content_hash: ContentHash([0; 32]),
            directory: section,
            metadata: json_section,
            objects: objects_section,
            file_length: json_section.offset + json_section.length,
        };

        header.content_hash = header.identity(&json, &objects, &directory);
        self.write(end, &objects)?;
        self.write(section.offset, &entries)?;
        self.write(json_section.offset, &json)?;
        self.flush()?;
        let record = header.encode();
        header.check_written(&record, &directory).map_err(invalid)?;
        self.write(0, &record)?;
        self.flush()?;

        Ok((header.content_hash, header.file_length))
    }

    fn flush(&self) -> Result<()> {
        self.shared.storage.flush().map_err(|error| self.storage_error("write it to the disk", error))
    }

    fn write(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        let attempt = self.shared.storage.write_at(offset, bytes);
        attempt.map_err(|error| {
            self.storage_error(&format!("write {} bytes at byte {offset}", bytes.len()), error)
        })
    }

    /// A full disk is told with what the database will need.
    pub fn storage_error(&self, action: &str, error: io::Error) -> Error {
        let path = &self.shared.path;
        match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Error::io(
                path,
                format!(
                    "write more than {} bytes (the database may need up to {} bytes: free that much, or name another \
                     place with -o)",
                    self.end, self.most
                ),
                error,
            ),
            _ => Error::io(path, action, error),
        }
    }
}

/// The most bytes that a page of a level can take, the gap behind it included.
pub fn most_page_bytes(grid: &Grid, level: u8) -> u64 {
    let Size { width, height } = grid.page_size(PageId { level, px: 0, py: 0 }).unwrap_or_default();
    (largest_page(level, width, height) as u64).next_multiple_of(PAGE_ALIGNMENT)
}

/// The most bytes that the pages of a grid can take, gaps and header included.
fn largest_file(grid: &Grid) -> u64 {
    let level_bytes = |level| {
        let (pages_x, pages_y) = grid.page_dims(level);
        let size = |px, py| grid.page_size(PageId { level, px, py }).unwrap_or_default();
        let Size { width, height } = size(0, 0);
        let Size { width: last_width, height: last_height } = size(pages_x - 1, pages_y - 1);
        let bytes =
            |width, height| (largest_page(level, width, height) as u64).next_multiple_of(PAGE_ALIGNMENT);
        let (whole_x, whole_y) = (u64::from(pages_x - 1), u64::from(pages_y - 1));
        whole_x * whole_y * bytes(width, height)
            + whole_y * bytes(last_width, height)
            + whole_x * bytes(width, last_height)
            + bytes(last_width, last_height)
    };
    PAGE_ALIGNMENT + (0..grid.level_count()).map(level_bytes).sum::<u64>()
}

impl FixedHeader {
    /// Checks that a reader will accept what is written, before the header goes down.
    fn check_written(&self, record: &[u8; at::SIZE], directory: &Directory) -> Result<(), String> {
        self.check(record)?;
        let coarsest = self.grid.level_count() - 1;
        match directory.ids().find(|id| id.level == coarsest && directory.get(*id).is_none()) {
            Some(missing) => Err(format!("{missing} is missing, but the coarsest level must be complete")),
            None => Ok(()),
        }
    }
}

/// Reads back pages of a database that is still being written.
#[derive(Debug, Clone)]
pub struct PageReadback {
    shared: Arc<AssemblyState>,
}

impl PageReadback {
    /// The page, or `None` if it has not been appended.
    pub fn page(&self, id: PageId) -> Result<Option<PageBuffer>> {
        let mut scratch = AlignedBytes::default();
        Ok(self.page_into(id, &mut scratch)?.map(|view| view.to_buffer()))
    }

    /// Finds the page's place in the file, or `None` if it has not been appended.
    pub fn entry(&self, id: PageId) -> Option<PageEntry> {
        let directory = self.shared.directory.read().unwrap_or_else(PoisonError::into_inner);
        directory.get(id).copied()
    }

    /// Reads a page without a copy, as [`Self::page`] does with one: the page's bytes are read into `scratch`.
    pub fn page_into<'a>(&self, id: PageId, scratch: &'a mut AlignedBytes) -> Result<Option<PageView<'a>>> {
        let AssemblyState { path, storage, directory, .. } = &*self.shared;
        let invalid = |what| Error::invalid(path, format!("{id}: {what}"));
        let located = {
            let directory = directory.read().unwrap_or_else(PoisonError::into_inner);
            directory.locate(id).map(|(_, entry, size)| (*entry, size))
        };
        let Some((entry, size)) = located else { return Ok(None) };
        if let Some(attributes) = entry.empty() {
            scratch.resize(size_of::<Attributes>());
            scratch.as_mut_slice().copy_from_slice(bytemuck::bytes_of(attributes));
            let attributes = bytemuck::from_bytes(scratch.as_slice());
            return PlanePositions::empty(id.level, size, attributes).whole().map(Some).map_err(invalid);
        }

        scratch.resize(entry.length as usize);
        let read = storage.read_at(entry.offset, scratch.as_mut_slice());
        read.map_err(|error| Error::io(path, format!("read {id} back"), error))?;
        let refuse = |what: &str| Error::invalid(path, format!("{id} at byte {}: {what}", entry.offset));
        let planes = PlanePositions::new(scratch.as_slice(), id.level, size, entry.spans)
            .map_err(|what| refuse(&what))?;
        if PagePart::all(id).any(|part| planes.crc(part) != entry.crc[part.number()]) {
            return Err(refuse("read back with a wrong checksum; check the disk, and build again"));
        }

        planes.whole().map(Some).map_err(|what| refuse(&what))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::voxel::SpanTable;
    use crate::voxel::limits::MOST_VOXELS;

    /// Refuses to write, with a given kind of error.
    struct Failing(io::ErrorKind);

    impl Storage for Failing {
        fn write_at(&self, _: u64, _: &[u8]) -> io::Result<()> {
            Err(self.0.into())
        }
        fn read_at(&self, _: u64, _: &mut [u8]) -> io::Result<()> {
            Err(self.0.into())
        }
        fn flush(&self) -> io::Result<()> {
            Err(self.0.into())
        }
    }

    fn one_page(grid: &Grid) -> EncodedPage {
        let id = PageId { level: 0, px: 0, py: 0 };
        let Size { width, height } = grid.page_size(id).unwrap();
        let samples = ((width + 2 * crate::voxel::APRON) * (height + 2 * crate::voxel::APRON)) as usize;
        let page = PageBuffer {
            width,
            height,
            heights: vec![1; samples],
            low: Vec::new(),
            high: Vec::new(),
            colours: vec![[0; 3]; samples],
            relief: Vec::new(),
            attributes: vec![crate::voxel::Attributes::default(); (width * height) as usize],
            spans: SpanTable::default(),
        };
        page.encode(id)
    }

    #[test]
    fn a_full_disk_is_told_with_the_bytes_that_are_needed() {
        let grid = Grid { nx: 300, ny: 20, spacing: 1.0, origin: DVec2::ZERO };
        let code = HeightCode::spanning(0.0, 1.0);
        let append = |kind| {
            let path = Path::new("area.hop");
            let mut assembly = Assembly::new(path, Arc::new(Failing(kind)), grid, code).unwrap();
            assembly.append(&one_page(&grid)).unwrap_err().to_string()
        };
        let full = append(io::ErrorKind::StorageFull);
        let expected = format!("may need up to {} bytes", largest_file(&grid));
        assert!(full.starts_with("area.hop: cannot write more") && full.contains(&expected), "{full}");
        assert!(full.contains(&io::Error::from(io::ErrorKind::StorageFull).to_string()), "{full}");
        let other = append(io::ErrorKind::PermissionDenied);
        assert!(other.starts_with("area.hop: cannot write") && other.contains("at byte 4096"), "{other}");
    }

    #[test]
    fn the_largest_file_is_never_exceeded() {
        for (nx, ny) in [(1, 1), (300, 20), (513, 1030)] {
            let grid = Grid { nx, ny, spacing: 1.0, origin: DVec2::ZERO };
            let sized = |id: PageId| {
                let Size { width, height } = grid.page_size(id).unwrap();
                (largest_page(id.level, width, height) as u64).next_multiple_of(PAGE_ALIGNMENT)
            };
            let pages: u64 = Directory::empty(&grid).unwrap().ids().map(sized).sum();
            assert_eq!(largest_file(&grid), PAGE_ALIGNMENT + pages);
        }
    }

    #[test]
    fn a_grid_of_too_many_pages_is_refused() {
        let grid = Grid { nx: MOST_VOXELS, ny: MOST_VOXELS, spacing: 0.001, origin: DVec2::ZERO };
        let storage = Arc::new(MemoryStorage::default());
        let error =
            Assembly::new(Path::new("a.hop"), storage, grid, HeightCode::spanning(0.0, 1.0)).unwrap_err();
        assert!(error.to_string().contains("--spacing"), "{error}");
    }
}
