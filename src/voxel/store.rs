//! A database's bytes, wherever they lie, as a page source.
//!
//! Each part of a page is *unchecked* until it is touched; then its checksum is taken once, and it is *good* from
//! then on. A bad part is never remembered as anything: it is checked again, and refused again; unless damaged pages are to be
//! left out ([`Damaged::Coarser`]), when all of a page is checked at once, and is *damaged* from then on, and absent. Otherwise what
//! is left out would depend on which part of a page is asked for first.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU8, Ordering};

use super::fixed_header::{DAMAGED, FixedHeader};
use super::page::PlanePositions;
use super::{
    AlignedBytes, BoundsView, Damaged, Directory, Header, HeightsView, PageEntry, PageId, PagePart,
    PageSource, PageView, SpansView, Trust, Verify,
};
use hedgehop_base::error::{Error, Result};

/// The bytes of a whole file. They begin at a multiple of 64 in memory and do not change.
pub trait FileBytes: Sync {
    /// All of them.
    fn bytes(&self) -> &[u8];

    /// Announces that these bytes will all be read soon.
    fn will_need(&self, range: Range<usize>) {
        let _ = range;
    }

    /// Has these bytes at hand, and waits until they are: nobody reads bytes of a part before. False: they cannot be had, and
    /// [`Self::intact`] says why.
    fn fill(&self, range: Range<usize>) -> bool {
        let _ = range;
        true
    }

    /// Whether these bytes are at hand, so that nobody waits for them to be [filled](Self::fill).
    fn is_filled(&self, range: Range<usize>) -> bool {
        let _ = range;
        true
    }

    /// Brings bytes once more whose checksum is wrong. False: there are none but these.
    fn refill(&self, range: Range<usize>) -> bool {
        let _ = range;
        false
    }

    /// Announces that these bytes will not be read for a while: their memory may go.
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

/// Counts of what has been touched so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Touched {
    /// Pages of which a part was asked for at least once and found good.
    pub pages: u64,
    /// Bytes of those parts.
    pub bytes: u64,
}

/// Knowledge of a page's part.
mod state {
    /// Nothing yet.
    pub const UNCHECKED: u8 = 0;
    /// Checked, and good.
    pub const GOOD: u8 = 1;
    /// The page is damaged, and left out.
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
    /// State of each [part](Directory::part_index). Nothing is published through these, the bytes never change:
    /// relaxed order is enough, and two threads that check the same part at once find the same.
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
    /// Reads and checks header, metadata and directory; parts of pages are checked when they are touched.
    pub fn new(name: impl Into<PathBuf>, bytes: B) -> Result<Self> {
        let path = name.into();
        let parsed = FixedHeader::parse(&path, bytes.bytes());
        bytes.intact(&path)?;
        let (header, directory) = parsed?;
        let parts = PagePart::COUNT * directory.len();
        let states = (0..parts).map(|_| AtomicU8::new(state::UNCHECKED)).collect();
        Ok(Self { path, bytes, header, directory, trust: Trust::default(), states })
    }

    /// The same, read in another way; before any page is touched.
    #[must_use]
    pub fn trusting(self, trust: Trust) -> Self {
        Self { trust, ..self }
    }

    fn is(&self, part: PagePart, state: u8) -> bool {
        let index = self.directory.part_index(part);
        index.is_some_and(|index| self.states[index].load(Ordering::Relaxed) == state)
    }

    fn set(&self, part: PagePart, state: u8) {
        if let Some(index) = self.directory.part_index(part) {
            self.states[index].store(state, Ordering::Relaxed);
        }
    }

    /// Pages that were found damaged so far and are left out, in the order of the directory, and where each begins in the file.
    pub fn damaged(&self) -> Vec<(PageId, u64)> {
        let present = self.directory.present().filter(|(id, _)| self.is_damaged(*id));
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

    /// Returns the directory: where each page lies.
    pub fn directory(&self) -> &Directory {
        &self.directory
    }

    /// Counts what was touched since the database was opened.
    pub fn touched(&self) -> Touched {
        let mut touched = Touched::default();
        for (id, _) in self.directory.present() {
            let good = PagePart::all(id).filter(|part| self.is(*part, state::GOOD));
            let bytes: u64 = good.map(|part| self.part_bytes(part)).sum();
            touched.pages += u64::from(bytes > 0);
            touched.bytes += bytes;
        }
        touched
    }

    /// Lists the parts that were asked for since the database was opened, were found good and have bytes, in the order of the directory.
    pub fn touched_parts(&self) -> Vec<PagePart> {
        let parts = self.directory.present().flat_map(|(id, _)| PagePart::all(id));
        parts.filter(|part| self.is(*part, state::GOOD) && self.part_bytes(*part) > 0).collect()
    }

    /// Finds a page in the file, bytes; `None` if it is absent, or has no bytes because it has no surface.
    pub fn extent(&self, id: PageId) -> Option<Range<usize>> {
        self.directory.get(id).filter(|entry| entry.empty().is_none()).and_then(extent_of)
    }

    /// Finds a part of a page in the file, bytes; empty if the page is absent, or has none.
    pub fn stretch(&self, part: PagePart) -> Range<usize> {
        let Some((_, entry, size)) = self.directory.locate(part.page()) else { return 0..0 };
        if entry.empty().is_some() {
            return 0..0;
        }
        let (start, range) = (entry.offset as usize, part.range(size, entry.lengths()));
        start + range.start..start + range.end
    }

    /// Bytes of a part of a page; 0 if the page is absent.
    pub fn part_bytes(&self, part: PagePart) -> u64 {
        self.stretch(part).len() as u64
    }

    /// Returns the bytes of the file that must be read to have a part of a page: all of a page that may be left out is checked at once.
    pub fn needed_for(&self, part: PagePart) -> Range<usize> {
        let is_whole = self.trust.damaged == Damaged::Coarser && self.is_to_be_checked(part);
        self.extent(part.page()).filter(|_| is_whole).unwrap_or_else(|| self.stretch(part))
    }

    fn is_to_be_checked(&self, part: PagePart) -> bool {
        self.trust.verify == Verify::FirstTouch && !self.is(part, state::GOOD)
    }

    /// Says that pages in a part of the file will all be read soon.
    pub fn announce(&self, range: Range<usize>) {
        self.bytes.will_need(range);
    }

    /// Whether bytes of the file are at hand, or must be brought from elsewhere before they can be read.
    pub fn is_filled(&self, range: Range<usize>) -> bool {
        self.bytes.is_filled(range)
    }

    /// Has bytes of the file at hand that no part of a page holds.
    ///
    /// # Errors
    /// They cannot be had.
    pub(super) fn fill(&self, range: Range<usize>) -> Result<()> {
        if self.bytes.fill(range) { Ok(()) } else { self.bytes.intact(&self.path) }
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

    /// Waits until all of a part of a page is in memory, and checks it if that was never done. Returns how many bytes were read for that.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn load(&self, part: PagePart) -> Result<u64> {
        let needed = self.needed_for(part).len() as u64;
        let is_read_for_checksum = self.is_to_be_checked(part);
        let found = self.or_left_out(part.page(), self.checked(part.page(), [part]))?;
        if found.is_some() && !is_read_for_checksum {
            let bytes = self.bytes().get(self.stretch(part)).unwrap_or_default();
            let touched = bytes.iter().step_by(LEAST_MAPPED).chain(bytes.last());
            std::hint::black_box(touched.fold(0, |sum, byte| sum ^ byte));
        }
        Ok(needed)
    }

    /// All planes of a page, its bounds, too. As [`PageSource::page`] otherwise.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn whole_page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        self.or_left_out(id, self.checked_page(id))
    }

    /// The page's bytes as they lie; `None` only if the directory's check has been bypassed.
    pub(super) fn page_bytes(&self, entry: &PageEntry) -> Option<&[u8]> {
        self.bytes().get(extent_of(entry)?)
    }

    /// All of a page after its checks, or what is wrong with it.
    pub(super) fn checked_page(&self, id: PageId) -> Result<Option<PageView<'_>>, String> {
        self.checked(id, PagePart::all(id))?.map(|planes| planes.whole()).transpose()
    }

    /// A page's planes after parts of it were checked, or what is wrong with them.
    #[inline]
    fn checked(
        &self,
        id: PageId,
        parts: impl IntoIterator<Item = PagePart>,
    ) -> Result<Option<PlanePositions<'_>>, String> {
        let Some((index, entry, size)) = self.directory.locate(id) else { return Ok(None) };
        let Some(bytes) = self.page_bytes(entry) else {
            return Err("beyond the end".into());
        };
        if self.bytes.has_failed() {
            return Err("the file cannot be read".into());
        }
        if let Some(attributes) = entry.empty() {
            return Ok(Some(PlanePositions::empty(id.level, size, attributes)));
        }

        let planes = PlanePositions::new(bytes, id.level, size, entry.spans)?;
        for part in parts {
            let known = &self.states[part.number() * self.directory.len() + index];
            match known.load(Ordering::Relaxed) {
                state::GOOD => {}
                state::DAMAGED => return Err("damaged".into()),
                _ => self.check(part, entry, &planes)?,
            }
        }

        Ok(Some(planes))
    }

    /// Checks a part of a page for the first time.
    #[cold]
    fn check(&self, part: PagePart, entry: &PageEntry, planes: &PlanePositions<'_>) -> Result<(), String> {
        let is_whole = self.trust.damaged == Damaged::Coarser;
        let marked = self.extent(part.page()).filter(|_| is_whole).unwrap_or_else(|| self.stretch(part));
        if !self.bytes.fill(marked) {
            return Err("the file cannot be read".into());
        }

        if self.trust.verify == Verify::FirstTouch {
            self.bytes.will_need(self.needed_for(part));
        }
        let parts = || PagePart::all(part.page()).filter(|other| is_whole || *other == part);
        let is_sound = |part: PagePart| planes.crc(part) == entry.crc[part.number()];
        for part in parts() {
            if self.trust.verify == Verify::FirstTouch
                && !is_sound(part)
                && !(self.bytes.refill(self.stretch(part)) && is_sound(part))
            {
                return Err("wrong checksum".into());
            }
            if let PagePart::Heights(id) = part {
                planes.check_header(id)?;
            }
        }
        parts().chain([part]).for_each(|part| self.set(part, state::GOOD));
        Ok(())
    }

    fn or_left_out<T>(&self, id: PageId, found: Result<Option<T>, String>) -> Result<Option<T>> {
        found.or_else(|what| self.leave_out(id, &what).map(|()| None))
    }

    /// Decides about a page with which something is wrong: nothing if another level is to stand in for it.
    #[cold]
    fn leave_out(&self, id: PageId, what: &str) -> Result<()> {
        if self.is_damaged(id) {
            return Ok(());
        }
        // What failed explains more than what its zeros look like.
        self.bytes.intact(&self.path)?;
        // The surface of level index 0 stands in for bare ground.
        let has_stand_in = id.is_bare() || id.level + 1 < self.header.level_count;
        let can_go = self.trust.damaged == Damaged::Coarser && has_stand_in;
        if can_go {
            PagePart::all(id).for_each(|part| self.set(part, state::DAMAGED));
            return Ok(());
        }
        let byte = self.directory.get(id).map_or(0, |entry| entry.offset);
        Err(Error::invalid(&self.path, format!("{id} at byte {byte}: {what}; {DAMAGED}")))
    }
}

/// Finds a page in the file, bytes.
fn extent_of(entry: &PageEntry) -> Option<Range<usize>> {
    let start = usize::try_from(entry.offset).ok()?;
    Some(start..start.checked_add(entry.length as usize)?)
}

impl<B: FileBytes> PageSource for PageStore<B> {
    fn header(&self) -> &Header {
        &self.header
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        let planes = self.checked(id, PagePart::posts(id));
        self.or_left_out(id, planes.and_then(|planes| planes.map(|planes| planes.posts()).transpose()))
    }

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        let planes = self.checked(id, [PagePart::Heights(id)]);
        self.or_left_out(id, planes.and_then(|planes| planes.map(|planes| planes.heights()).transpose()))
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        let planes = self.checked(id, [PagePart::Bounds(id)]);
        self.or_left_out(id, planes.and_then(|planes| planes.map(|planes| planes.bounds()).transpose()))
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        if !id.is_bare() {
            return Ok(None);
        }
        let planes = self.checked(id, [PagePart::Spans(id)]);
        self.or_left_out(id, planes.and_then(|planes| planes.map(|planes| planes.spans()).transpose()))
    }

    fn has(&self, id: PageId) -> bool {
        self.directory.get(id).is_some() && !self.is_damaged(id)
    }

    fn is_damaged(&self, id: PageId) -> bool {
        self.is(PagePart::Heights(id), state::DAMAGED)
    }

    fn intact(&self) -> Result<()> {
        self.bytes.intact(&self.path)
    }
}
