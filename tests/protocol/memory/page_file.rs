//! A database in memory that stands for one on a disk: it knows what was read and what was let go, and whoever reads it lets others go on first.

use std::collections::BTreeSet;
use std::ops::{Deref, Range};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::Ordering;

use hedgehop::Result;
use hedgehop::voxel::{
    AlignedBytes, BoundsView, Directory, FileBytes, Header, HeightsView, PageId, PagePart, PageSource,
    PageStore, PageView, SpansView,
};

use super::sync::AtomicU32;

/// The bytes of a file. To ask whether they have failed, as everybody does who looks at a page, gives way to other threads.
#[derive(Debug)]
pub struct Disk {
    bytes: &'static AlignedBytes,
    turns: AtomicU32,
}

impl FileBytes for Disk {
    fn bytes(&self) -> &[u8] {
        self.bytes.as_slice()
    }

    fn will_need(&self, _: Range<usize>) {
        self.turns.fetch_add(1, Ordering::Relaxed);
    }

    fn has_failed(&self) -> bool {
        self.turns.fetch_add(1, Ordering::Relaxed) == u32::MAX
    }
}

/// What is in memory, and what was read that was not.
#[derive(Debug, Default)]
struct Seen {
    here: BTreeSet<PagePart>,
    strays: BTreeSet<PagePart>,
}

/// The pages of a file.
#[derive(Debug)]
pub struct Store {
    pages: PageStore<Disk>,
    /// The standard library's: to look at it changes nobody's turn.
    seen: Mutex<Seen>,
}

impl Deref for Store {
    type Target = PageStore<Disk>;

    fn deref(&self) -> &Self::Target {
        &self.pages
    }
}

impl Store {
    /// As [`PageStore::load`], and noted.
    pub fn load(&self, part: PagePart) -> Result<u64> {
        let bytes = self.pages.load(part)?;
        self.seen.lock().unwrap().here.insert(part);
        Ok(bytes)
    }

    /// As [`PageStore::forget`], and noted.
    pub fn forget(&self, part: PagePart, _: impl Fn(PagePart) -> bool) {
        self.seen.lock().unwrap().here.remove(&part);
    }

    /// Bytes in memory.
    pub fn bytes_here(&self) -> u64 {
        self.seen.lock().unwrap().here.iter().map(|part| self.part_bytes(*part)).sum()
    }

    /// Parts that somebody read when they were not in memory: a real disk would have been waited for.
    pub fn strays(&self) -> Vec<PagePart> {
        self.seen.lock().unwrap().strays.iter().copied().collect()
    }

    fn look_at(&self, part: PagePart) {
        let mut seen = self.seen.lock().unwrap();
        if !seen.here.contains(&part) {
            seen.strays.insert(part);
        }
    }
}

/// What stands for a file.
#[derive(Debug)]
pub struct PageFile {
    store: Store,
}

impl PageFile {
    pub fn new(bytes: &'static AlignedBytes) -> Self {
        let disk = Disk { bytes, turns: AtomicU32::new(0) };
        let pages = PageStore::new("area.hop", disk).expect("a database");
        Self { store: Store { pages, seen: Mutex::default() } }
    }

    pub fn path(&self) -> &Path {
        self.store.path()
    }

    pub fn store(&self) -> &Store {
        &self.store
    }

    pub fn directory(&self) -> &Directory {
        self.store.directory()
    }
}

impl PageSource for PageFile {
    fn header(&self) -> &Header {
        self.store.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        let page = self.store.page(id)?;
        if page.is_some() {
            PagePart::posts(id).into_iter().for_each(|part| self.store.look_at(part));
        }
        Ok(page)
    }

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        let heights = self.store.heights(id)?;
        heights.iter().for_each(|_| self.store.look_at(PagePart::Heights(id)));
        Ok(heights)
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        let spans = self.store.spans(id)?;
        spans.iter().for_each(|_| self.store.look_at(PagePart::Spans(id)));
        Ok(spans)
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        let bounds = self.store.bounds(id)?;
        bounds.iter().for_each(|_| self.store.look_at(PagePart::Bounds(id)));
        Ok(bounds)
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
