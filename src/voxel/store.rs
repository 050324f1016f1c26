//! A database's bytes, wherever they lie, as a page source.
//!
//! Each page is *unchecked* until it is touched; then its checksum is taken once, and it is *good* from
//! then on. A bad page is never remembered as anything: it is checked again, and refused again; unless damaged pages are to be
//! left out ([`Damaged::Coarser`]), when it is *damaged* from then on, and absent.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU8, Ordering};

use super::fixed_header::{DAMAGED, FixedHeader};
use super::{
    AlignedBytes, BoundsView, Damaged, Directory, Header, PageEntry, PageId, PagePart, PageSource, PageView,
    Trust, Verify,
};
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

    /// Whether some byte could not be read so far; zeros may stand for all of them since. It stays so.
    fn has_failed(&self) -> bool {
        false
    }

    /// Whether what was read so far was what the file `path` held when it was opened.
    ///
    /// # Errors
    /// It was not, or may not have been.
    fn intact(&self, path: &Path) -> Result<()> {
        let _ = path;
        Ok(())
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

/// What is known of a page.
mod state {
    /// Nothing yet.
    pub const UNCHECKED: u8 = 0;
    /// It was checked, and is good.
    pub const GOOD: u8 = 1;
    /// It is damaged, and left out.
    pub const DAMAGED: u8 = 2;
}

/// A database over the bytes of its file.
#[derive(Debug)]
pub struct PageStore<B> {
    path: PathBuf,
    bytes: B,
    header: Header,
    directory: Directory,
    trust: Trust,
    /// By directory index. Nothing is published through these, the bytes never change:
    /// relaxed order is enough, and two threads that check the same page at once find the same.
    states: Box<[AtomicU8]>,
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
        let parsed = FixedHeader::parse(&path, bytes.bytes());
        bytes.intact(&path)?;
        let (header, directory) = parsed?;
        let states = (0..directory.len()).map(|_| AtomicU8::new(state::UNCHECKED)).collect();
        Ok(Self { path, bytes, header, directory, trust: Trust::default(), states })
    }

    /// The same, read in another way; before any page is touched.
    #[must_use]
    pub fn trusting(self, trust: Trust) -> Self {
        Self { trust, ..self }
    }

    fn is(&self, id: PageId, state: u8) -> bool {
        self.directory.index(id).is_some_and(|index| self.states[index].load(Ordering::Relaxed) == state)
    }

    /// Pages that were found damaged so far and are left out, in the order of the directory, and where each begins in the file.
    pub fn damaged(&self) -> Vec<(PageId, u64)> {
        let present = self.directory.present().filter(|(id, _)| self.is(*id, state::DAMAGED));
        present.map(|(id, entry)| (id, entry.offset)).collect()
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
            let good = self.is(id, state::GOOD);
            touched.pages += u64::from(good);
            touched.bytes += if good { u64::from(entry.length) } else { 0 };
        }
        touched
    }

    /// Where a page lies in the file, bytes; `None` if it is absent.
    pub fn extent(&self, id: PageId) -> Option<Range<usize>> {
        self.directory.get(id).and_then(|entry| self.page_bytes(entry)).map(|(range, _)| range)
    }

    /// Where a part of a page lies in the file, bytes; empty if the page is absent.
    pub fn stretch(&self, part: PagePart) -> Range<usize> {
        let Some((_, entry, size)) = self.directory.locate(part.page()) else { return 0..0 };
        let (start, range) = (entry.offset as usize, part.range(size, entry.length as usize));
        start + range.start..start + range.end
    }

    /// Bytes of a part of a page; 0 if the page is absent.
    pub fn part_bytes(&self, part: PagePart) -> u64 {
        self.stretch(part).len() as u64
    }

    /// What must be read of the file to have a part of a page, bytes: its checksum is that of all of the page.
    pub fn needed_for(&self, part: PagePart) -> Range<usize> {
        let whole = self.extent(part.page()).filter(|_| self.is_to_be_checked(part.page()));
        whole.unwrap_or_else(|| self.stretch(part))
    }

    fn is_to_be_checked(&self, id: PageId) -> bool {
        self.trust.verify == Verify::FirstTouch && !self.is(id, state::GOOD)
    }

    /// Says that pages in a part of the file will all be read soon.
    pub fn announce(&self, range: Range<usize>) {
        self.bytes.will_need(range);
    }

    /// Lets the memory of a part of a page go, but for what it shares with parts that stay; whoever still reads it has it read again.
    pub fn forget(&self, part: PagePart, stays: impl Fn(PagePart) -> bool) {
        let Some(extent) = self.extent(part.page()) else { return };
        let stretch = self.stretch(part);
        if stretch.is_empty() {
            return;
        }
        let up = |byte: usize| byte.next_multiple_of(LEAST_MAPPED);
        let down = |byte: usize| byte / LEAST_MAPPED * LEAST_MAPPED;
        // Pages share nothing with one another.
        let (mut start, mut end) = (down(stretch.start), up(stretch.end).min(extent.end));
        for other in PagePart::all(part.page()).filter(|other| *other != part && stays(*other)) {
            let other = self.stretch(other);
            if other.end <= stretch.start && other.end > start {
                start = up(stretch.start);
            } else if other.start >= stretch.end && other.start < end {
                end = down(stretch.end);
            }
        }
        if start < end {
            self.bytes.forget(start..end);
        }
    }

    /// Waits until all of a part of a page is in memory, and checks the page if that was never done, of which all is read then. Returns
    /// whether it was.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn load(&self, part: PagePart) -> Result<bool> {
        let is_whole = self.is_to_be_checked(part.page());
        if self.page(part.page())?.is_some() && !is_whole {
            let bytes = self.bytes().get(self.stretch(part)).unwrap_or_default();
            let touched = bytes.iter().step_by(LEAST_MAPPED).chain(bytes.last());
            std::hint::black_box(touched.fold(0, |sum, byte| sum ^ byte));
        }
        Ok(is_whole)
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
        if self.bytes.has_failed() {
            return Err("the file cannot be read".into());
        }
        match self.states[index].load(Ordering::Relaxed) {
            state::GOOD => return PageView::decode(bytes, id, size).map(Some),
            state::DAMAGED => return Err("damaged".into()),
            _ if self.trust.verify == Verify::FirstTouch => self.bytes.will_need(range),
            _ => {}
        }
        if self.trust.verify == Verify::FirstTouch && crc32fast::hash(bytes) != entry.crc {
            return Err("wrong checksum".into());
        }
        let view = PageView::decode(bytes, id, size)?;
        self.states[index].store(state::GOOD, Ordering::Relaxed);
        Ok(Some(view))
    }

    /// What becomes of a page with which something is wrong: nothing if another level is to stand in for it.
    #[cold]
    fn leave_out(&self, id: PageId, what: &str) -> Result<()> {
        if self.is(id, state::DAMAGED) {
            return Ok(());
        }
        // What failed explains more than what its zeros look like.
        self.bytes.intact(&self.path)?;
        let can_go = self.trust.damaged == Damaged::Coarser && id.level + 1 < self.header.level_count;
        if can_go && let Some(index) = self.directory.index(id) {
            self.states[index].store(state::DAMAGED, Ordering::Relaxed);
            return Ok(());
        }
        let byte = self.directory.get(id).map_or(0, |entry| entry.offset);
        Err(Error::invalid(&self.path, format!("{id} at byte {byte}: {what}; {DAMAGED}")))
    }
}

impl<B: FileBytes> PageSource for PageStore<B> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        self.checked_page(id).or_else(|what| self.leave_out(id, &what).map(|()| None))
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        Ok(self.page(id)?.map(|view| view.bounds()))
    }

    fn has(&self, id: PageId) -> bool {
        self.directory.get(id).is_some() && !self.is(id, state::DAMAGED)
    }

    fn is_damaged(&self, id: PageId) -> bool {
        self.is(id, state::DAMAGED)
    }

    fn intact(&self) -> Result<()> {
        self.bytes.intact(&self.path)
    }
}
