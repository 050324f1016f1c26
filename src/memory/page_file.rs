//! A database file, mapped into memory.
//!
//! Reads go through the page cache without a copy, and many renderers of one machine share it. The
//! mapping is advised as random: read-ahead of the kernel (up to megabytes) would load neighbours in the file that are no
//! neighbours in the picture. Instead each page is announced as a whole before its checksum touches it.

#![expect(
    unsafe_code,
    reason = "a mapped file can change under its readers; the contract is at `PageFile::open`"
)]

use std::fs::{self, File};
use std::ops::Range;
use std::path::Path;

use memmap2::Mmap;

use crate::error::{Error, Result};
use crate::progress::Observer;
use crate::voxel::{
    FileBytes, Header, PageId, PageSource, PageStore, PageView, Touched, VerifyReport, verify,
};

/// A mapped file.
#[derive(Debug)]
struct Mapping {
    map: Mmap,
    #[cfg_attr(not(unix), expect(dead_code, reason = "advice about files is Unix's"))]
    file: File,
}

impl FileBytes for Mapping {
    fn bytes(&self) -> &[u8] {
        &self.map
    }

    fn will_need(&self, range: Range<usize>) {
        // Advice may fail without harm: the bytes are then read when they are touched.
        #[cfg(unix)]
        let _ = self.map.advise_range(memmap2::Advice::WillNeed, range.start, range.len());
        #[cfg(not(unix))]
        let _ = range;
    }

    fn forget(&self, range: Range<usize>) {
        #[cfg(unix)]
        {
            // SAFETY: the mapping is shared and read only: what is dropped is read from the file again when it is touched.
            let _ = unsafe {
                self.map.unchecked_advise_range(memmap2::UncheckedAdvice::DontNeed, range.start, range.len())
            };
            #[cfg(not(any(target_os = "macos", target_os = "ios")))]
            if let Some(length) = std::num::NonZeroU64::new(range.len() as u64) {
                // The copy that the system keeps of the file; pages that others have mapped stay.
                let advice = rustix::fs::Advice::DontNeed;
                let _ = rustix::fs::fadvise(&self.file, range.start as u64, Some(length), advice);
            }
        }
        #[cfg(not(unix))]
        let _ = range;
    }
}

/// A database file that is open for reading.
#[derive(Debug)]
pub struct PageFile {
    store: PageStore<Mapping>,
}

impl PageFile {
    /// Opens a database. Header, metadata and directory are checked now, pages when they are first touched.
    ///
    /// The file must not be truncated or written to while it is open: a truncated one ends the process with a bus
    /// error, as with every mapped file. Builds never do this; they replace a database
    /// by renaming, and the old one lives on until it is closed.
    pub fn open(path: &Path) -> Result<Self> {
        // Asked for before opening: to open a pipe would wait for its other end.
        let metadata = fs::metadata(path).map_err(|error| Error::io(path, "open it as a database", error))?;
        if metadata.is_dir() {
            return Err(Error::invalid(path, "is a folder; name a database file, like AREA.hop"));
        }
        if !metadata.is_file() {
            return Err(Error::invalid(
                path,
                "is no regular file and cannot be mapped; copy it to a disk first",
            ));
        }
        let file = File::open(path).map_err(|error| Error::io(path, "open it as a database", error))?;
        // SAFETY: the mapping is private to this value, is only read, and is never handed out beyond its life. That
        // nobody truncates or rewrites the file meanwhile is the contract of this function, see above.
        let mapping =
            unsafe { Mmap::map(&file) }.map_err(|error| Error::io(path, "map it into memory", error))?;
        #[cfg(unix)]
        let _ = mapping.advise(memmap2::Advice::Random);
        Ok(Self { store: PageStore::new(path, Mapping { map: mapping, file })? })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.store.path()
    }

    /// Bytes of the file.
    pub fn file_length(&self) -> u64 {
        self.store.bytes().len() as u64
    }

    /// Checks the whole database; see [`verify`].
    pub fn verify(&self, observer: &dyn Observer) -> Result<VerifyReport> {
        verify(&self.store, observer)
    }

    /// Its pages, and where they lie.
    pub(super) fn store(&self) -> &PageStore<impl FileBytes + std::fmt::Debug> {
        &self.store
    }

    /// Pages touched since the file was opened.
    pub fn touched(&self) -> Touched {
        self.store.touched()
    }
}

impl PageSource for PageFile {
    fn header(&self) -> &Header {
        self.store.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        self.store.page(id)
    }

    fn has(&self, id: PageId) -> bool {
        self.store.has(id)
    }
}
