//! A database file, mapped into memory.
//!
//! Reads go through the page cache without a copy, and many renderers of one machine share it. The
//! mapping is advised as random: read-ahead of the kernel (up to megabytes) would load neighbours in the file that are no
//! neighbours in the picture. Instead each part of a page is announced as a whole before its checksum touches it.

#![expect(
    unsafe_code,
    reason = "a mapped file can change under its readers; the contract is at `PageFile::open`"
)]

use std::fs::{self, File};
use std::io;
use std::ops::Range;
use std::path::Path;
use std::time::SystemTime;

use memmap2::Mmap;

use super::guard::Watch;
use super::hole_filler::HoleFiller;
use crate::voxel::{
    BoundsView, Directory, FileBytes, FileEnds, Header, HeightsView, PageId, PagePart, PageSource, PageStore,
    PageView, SpansView, Touched, Trust, VerifyReport, open_to_read, verify,
};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Advice about a database that changed under its readers.
const LEAVE_ALONE: &str = "leave a database alone while it is in use (`build --overwrite` and renaming are safe), \
                           and repeat the command";

/// A mapped file.
#[derive(Debug)]
struct FileMapping {
    /// Before the mapping: it is dropped first.
    watch: Watch,
    map: Mmap,
    file: File,
    /// Time of the last change before it was opened, if the system tells.
    modified: Option<SystemTime>,
    /// Fills the holes of a sparse copy. After the mapping: who fills may let parts of the copy go when it is dropped.
    filler: Option<Box<dyn HoleFiller>>,
}

impl FileMapping {
    fn new(path: &Path, file: File, filler: Option<Box<dyn HoleFiller>>) -> Result<Self> {
        let modified = file.metadata().and_then(|metadata| metadata.modified()).ok();
        // SAFETY: the mapping is private to this value, is only read, and is never handed out beyond its life. That
        // nobody truncates or rewrites the file meanwhile is the contract of `PageFile::open`; who fills holes writes only what
        // nobody has read.
        let map =
            unsafe { Mmap::map(&file) }.map_err(|error| Error::io(path, "map it into memory", error))?;
        #[cfg(unix)]
        let _ = map.advise(memmap2::Advice::Random);
        #[cfg(unix)]
        // SAFETY: all of the mapping, of the file from its first byte, is only read, and fields are dropped in order.
        let watch = unsafe { Watch::new(&map) };
        #[cfg(not(unix))]
        let watch = Watch;
        Ok(Self { watch, map, file, modified, filler })
    }

    /// Why a byte could not be read.
    fn failure(&self, byte: u64) -> io::Error {
        match self.file.metadata() {
            Ok(metadata) if metadata.len() < self.map.len() as u64 => {
                let (length, was) = (metadata.len(), self.map.len());
                let what =
                    format!("it was cut short from {was} to {length} bytes while it was open; {LEAVE_ALONE}");
                io::Error::new(io::ErrorKind::UnexpectedEof, what)
            }
            _ => io::Error::other(format!(
                "the disk or its file system failed at byte {byte}; check it, or copy the file elsewhere"
            )),
        }
    }
}

impl FileBytes for FileMapping {
    fn bytes(&self) -> &[u8] {
        &self.map
    }

    #[inline]
    fn has_failed(&self) -> bool {
        self.watch.failed().is_some() || self.filler.as_ref().is_some_and(|filler| filler.has_failed())
    }

    fn intact(&self, path: &Path) -> Result<()> {
        if let Some(byte) = self.watch.failed() {
            return Err(Error::io(path, format!("read byte {byte}"), self.failure(byte)));
        }
        if let Some(filler) = &self.filler {
            filler.intact()?;
        }
        // Bytes that are read anew would be those of another database.
        let metadata = self.file.metadata().map_err(|error| Error::io(path, "examine it", error))?;
        let is_written = self.filler.is_none() && metadata.modified().ok() != self.modified;
        if metadata.len() != self.map.len() as u64 || is_written {
            let what = format!("it was changed while it was open; {LEAVE_ALONE}");
            return Err(Error::io(path, "go on reading it", io::Error::other(what)));
        }
        Ok(())
    }

    fn fill(&self, range: Range<usize>) -> bool {
        self.filler.as_ref().is_none_or(|filler| filler.fill(wide(&range)))
    }

    fn is_filled(&self, range: Range<usize>) -> bool {
        self.filler.as_ref().is_none_or(|filler| filler.is_filled(wide(&range)))
    }

    fn refill(&self, range: Range<usize>) -> bool {
        self.filler.as_ref().is_some_and(|filler| filler.refill(wide(&range)))
    }

    fn will_need(&self, range: Range<usize>) {
        if let Some(filler) = self.filler.as_ref().filter(|filler| !filler.is_filled(wide(&range))) {
            filler.announce(wide(&range));
            return;
        }
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

fn wide(range: &Range<usize>) -> Range<u64> {
    range.start as u64..range.end as u64
}

/// A database file that is open for reading.
#[derive(Debug)]
pub struct PageFile {
    store: PageStore<FileMapping>,
}

impl PageFile {
    /// Opens a database. What a build that was killed left half changed is what it was before first. Header, metadata and directory are checked now, pages when they are first touched.
    ///
    /// The file must not be truncated or written to while it is open. Builds never do this: they change a database in place only if nobody has it
    /// open, which a lock tells them; otherwise they replace it by renaming, and the old one lives on until it is closed. A file that changes nevertheless makes [`PageSource::intact`] an error,
    /// which whoever renders asks after every frame; one that is cut short ends the process with a bus error, as with every mapped
    /// file, unless [`guard_mapped_files`](super::guard_mapped_files) was called.
    pub fn open(path: &Path) -> Result<Self> {
        Self::open_trusting(path, Trust::default())
    }

    /// Opens a database with pages checked otherwise than by [`Self::open`], or with damaged ones left out.
    pub fn open_trusting(path: &Path, trust: Trust) -> Result<Self> {
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
        let mapping = FileMapping::new(path, open_to_read(path)?, None)?;
        Ok(Self { store: PageStore::new(path, mapping)?.trusting(trust) })
    }

    /// Opens a sparse copy of a database whose name is `name`, and whose holes are filled as its pages are needed. What holds no pages is there
    /// already: the header, and what lies behind the pages.
    ///
    /// Nobody truncates the copy while it is open, and only holes are written to, by fillers of the same database.
    ///
    /// # Errors
    /// The bytes are those of no database, or damaged; the copy cannot be mapped.
    #[doc(hidden)]
    pub fn open_sparse(name: &Path, copy: File, filler: Box<dyn HoleFiller>, trust: Trust) -> Result<Self> {
        let mapping = FileMapping::new(name, copy, Some(filler))?;
        Ok(Self { store: PageStore::new(name, mapping)?.trusting(trust) })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.store.path()
    }

    /// Bytes of the file.
    pub fn file_length(&self) -> u64 {
        self.store.bytes().len() as u64
    }

    /// Finds a part of a page in the file, bytes; empty if the page is absent, or has none.
    #[doc(hidden)]
    pub fn stretch(&self, part: PagePart) -> Range<u64> {
        wide(&self.store.stretch(part))
    }

    /// Lists the stretches of the file that hold no pages, and that are read when it is opened.
    ///
    /// # Errors
    /// The header cannot be read any more.
    #[doc(hidden)]
    pub fn ends(&self) -> Result<[Range<u64>; 2]> {
        Ok(FileEnds::of_start(self.path(), self.store.bytes(), self.file_length())?.stretches())
    }

    /// Checks the whole database; see [`verify`].
    pub fn verify(&self, observer: &dyn Observer) -> Result<VerifyReport> {
        verify(&self.store, observer)
    }

    /// Reads these parts of pages and compares their checksums.
    ///
    /// # Errors
    /// A page that is damaged; an interruption.
    pub fn check(&self, parts: &[PagePart], observer: &dyn Observer) -> Result<()> {
        /// Parts that are asked for together.
        const TOGETHER: usize = 64;
        observer.begin("check", parts.len() as u64, "parts of pages");
        for together in parts.chunks(TOGETHER) {
            if observer.cancelled() {
                return Err(Error::Interrupted("the database was not checked to its end".into()));
            }
            together.iter().for_each(|part| self.store.announce(self.store.stretch(*part)));
            together.iter().try_for_each(|part| self.store.load(*part).map(drop))?;
            observer.advance(together.len() as u64);
        }
        observer.end();
        self.intact()
    }

    /// Returns the pages, and where they lie.
    pub(super) fn store(&self) -> &PageStore<impl FileBytes + std::fmt::Debug> {
        &self.store
    }

    /// Pages that were found damaged so far and are left out, and where each begins in the file.
    pub fn damaged(&self) -> Vec<(PageId, u64)> {
        self.store.damaged()
    }

    /// Returns the directory of pages: where each lies, and which ones are absent.
    pub fn directory(&self) -> &Directory {
        self.store.directory()
    }

    /// Lists the parts of pages that were touched since the file was opened, and that have bytes.
    #[doc(hidden)]
    pub fn touched_parts(&self) -> Vec<PagePart> {
        self.store.touched_parts()
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

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        self.store.heights(id)
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        self.store.bounds(id)
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        self.store.spans(id)
    }

    fn has(&self, id: PageId) -> bool {
        self.store.has(id)
    }

    fn is_damaged(&self, id: PageId) -> bool {
        self.store.is_damaged(id)
    }

    fn intact(&self) -> Result<()> {
        self.store.intact()
    }
}
