//! A database's bytes, wherever they lie, as a page source.
//!
//! Each page is *unchecked* until it is touched; then its checksum is taken once, and it is *good* from
//! then on. A bad page is never remembered as anything: it is checked again, and refused again.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use super::fixed_header::{DAMAGED, FixedHeader};
use super::{AlignedBytes, Directory, Header, PageEntry, PageId, PageSource, PageView};
use crate::error::{Error, Result};

/// The bytes of a whole file. They begin at a multiple of 64 in memory and do not change.
pub trait FileBytes: Sync {
    /// All of them.
    fn bytes(&self) -> &[u8];

    /// These will all be read soon.
    fn will_need(&self, range: Range<usize>) {
        let _ = range;
    }

    /// These will not be read for a while: their memory may go.
    fn forget(&self, range: Range<usize>) {
        let _ = range;
    }
}

impl FileBytes for AlignedBytes {
    fn bytes(&self) -> &[u8] {
        self.as_slice()
    }
}

/// Bytes that memory comes in, at least.
const LEAST_MAPPED: usize = 4096;

/// What has been touched so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Touched {
    /// Pages that were asked for at least once and found good.
    pub pages: u64,
    /// Bytes of them.
    pub bytes: u64,
}

/// A database over the bytes of its file.
#[derive(Debug)]
pub struct PageStore<B> {
    path: PathBuf,
    bytes: B,
    header: Header,
    directory: Directory,
    /// By directory index. Nothing is published through these flags, the bytes never change:
    /// relaxed order is enough, and two threads that check the same page at once find the same.
    good: Box<[AtomicBool]>,
}

/// A database in memory.
pub type MemPages = PageStore<AlignedBytes>;

impl PageStore<AlignedBytes> {
    /// A file's bytes, copied; `name` stands for the file in errors.
    pub fn from_bytes(name: impl Into<PathBuf>, bytes: &[u8]) -> Result<Self> {
        Self::new(name, AlignedBytes::copy_of(bytes))
    }
}

impl<B: FileBytes> PageStore<B> {
    /// Reads and checks header, metadata and directory; pages are checked when they are touched.
    pub fn new(name: impl Into<PathBuf>, bytes: B) -> Result<Self> {
        let path = name.into();
        let (header, directory) = FixedHeader::parse(&path, bytes.bytes())?;
        let good = (0..directory.len()).map(|_| AtomicBool::new(false)).collect();
        Ok(Self { path, bytes, header, directory, good })
    }

    /// The file, or what stands for it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file's bytes.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.bytes()
    }

    /// Where each page lies.
    pub fn directory(&self) -> &Directory {
        &self.directory
    }

    /// Pages touched since the database was opened.
    pub fn touched(&self) -> Touched {
        let mut touched = Touched::default();
        for (id, entry) in self.directory.present() {
            let good = self.directory.index(id).is_some_and(|index| self.good[index].load(Ordering::Relaxed));
            touched.pages += u64::from(good);
            touched.bytes += if good { u64::from(entry.length) } else { 0 };
        }
        touched
    }

    /// Where a page lies in the file, bytes; `None` if it is absent.
    pub fn extent(&self, id: PageId) -> Option<Range<usize>> {
        self.directory.get(id).and_then(|entry| self.page_bytes(entry)).map(|(range, _)| range)
    }

    /// Says that pages in a part of the file will all be read soon.
    pub fn announce(&self, range: Range<usize>) {
        self.bytes.will_need(range);
    }

    /// Lets the memory of a part of the file go; whoever still reads it has it read again.
    pub fn forget(&self, range: Range<usize>) {
        self.bytes.forget(range);
    }

    /// Waits until all of a page is in memory, and checks it if that was never done.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn load(&self, id: PageId) -> Result<()> {
        let is_good = self.directory.index(id).is_some_and(|index| self.good[index].load(Ordering::Relaxed));
        if is_good && let Some(range) = self.extent(id) {
            let bytes = self.bytes().get(range).unwrap_or_default();
            let touched = bytes.iter().step_by(LEAST_MAPPED).fold(0, |sum, byte| sum ^ byte);
            std::hint::black_box(touched);
            return Ok(());
        }
        self.page(id).map(drop)
    }

    /// The page's bytes as they lie; `None` only if the directory's check has been bypassed.
    pub(super) fn page_bytes(&self, entry: &PageEntry) -> Option<(Range<usize>, &[u8])> {
        let start = usize::try_from(entry.offset).ok()?;
        let range = start..start.checked_add(entry.length as usize)?;
        Some((range.clone(), self.bytes().get(range)?))
    }

    /// A page after its checks, or what is wrong with it.
    #[inline]
    pub(super) fn checked_page(&self, id: PageId) -> Result<Option<PageView<'_>>, String> {
        let Some((index, entry, size)) = self.directory.locate(id) else {
            return Ok(None);
        };
        let Some((range, bytes)) = self.page_bytes(entry) else {
            return Err("beyond the end".into());
        };
        let good = &self.good[index];
        if good.load(Ordering::Relaxed) {
            return PageView::decode(bytes, id, size).map(Some);
        }
        self.bytes.will_need(range);
        if crc32fast::hash(bytes) != entry.crc {
            return Err("wrong checksum".into());
        }
        let view = PageView::decode(bytes, id, size)?;
        good.store(true, Ordering::Relaxed);
        Ok(Some(view))
    }

    #[cold]
    fn refuse(&self, id: PageId, what: &str) -> Error {
        let byte = self.directory.get(id).map_or(0, |entry| entry.offset);
        Error::invalid(&self.path, format!("{id} at byte {byte}: {what}; {DAMAGED}"))
    }
}

impl<B: FileBytes> PageSource for PageStore<B> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        self.checked_page(id).map_err(|what| self.refuse(id, &what))
    }

    fn has(&self, id: PageId) -> bool {
        self.directory.get(id).is_some()
    }
}
