//! Resident pages within a budget.
//!
//! ```text
//!                     the memory thread, ahead of need
//!              ┌────────────────────────────────────────────┐
//!   on disk ───┤                                            ├──▶ resident ──▶ touched
//!      ▲       └── a worker that cannot wait: demand miss ──┘        │           │
//!      └────────────── evicted, when room is needed and no frame in flight or ahead needs it
//! ```
//!
//! What comes and goes is a part of a page: its heights, its paint, or its bounds.
//!
//! The database stays mapped whatever is resident: an eviction is advice to the system, and a view that outlives it reads the
//! file again. What pictures show can therefore never depend on what is in memory.

mod eviction;
mod late;
mod reading;
mod wants;

pub(super) use eviction::PaintInSight;
pub use late::PresentPages;
pub(super) use late::Purpose;

use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::clock::{Claim, Clock};
use super::counters::PagingCounters;
use super::sync::{self, AtomicU8, Condvar, Mutex, MutexGuard, ThreadId};
use super::{PageFile, Paging};
use crate::voxel::{
    BoundsView, Header, HeightsView, PageId, PageNeeds, PagePart, PageSource, PageView, SpansView,
};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Level index from which on pages stay once they are there: voxels of 64 units, and coarser ones. All that is known of what may
/// be hidden rests on their bounds.
const KEPT_LEVEL: u8 = 3;

/// Pages that are asked for together when all are loaded.
const LOADED_TOGETHER: usize = 64;

const MIB: u64 = 1 << 20;

/// Frames behind the last one delivered that begin soon: some are in flight already.
const SOON: u32 = 2;

/// A part of a page that is to be read, and its number.
pub(super) type Expected = (PagePart, usize);

/// Bits of the state of a page's part.
mod state {
    /// Resident in memory.
    pub const RESIDENT: u8 = 1;
    /// Some thread brings it there.
    pub const COMING: u8 = 2;
    /// Touched since the clock's hand passed.
    pub const USED: u8 = 4;
    /// Touched since it came.
    pub const TOUCHED: u8 = 8;
    /// A frame that does not wait asked for it.
    pub const WANTED: u8 = 32;
    /// Read, and damaged.
    pub const FAILED: u8 = 64;
}

/// State that is decided under one lock.
#[derive(Debug, Default)]
struct Ledger {
    clock: Clock,
    /// Bytes that are resident or coming.
    bytes: u64,
    most: u64,
    /// Number of the first frame that is not known to need a part any more, by part.
    needed_until: Vec<u32>,
    /// Number of the first frame that needed a part, by part; `None` if none did.
    needed_from: Vec<Option<u32>>,
    /// Frames below this number have been delivered.
    delivered: u32,
    /// Frames from this number on have not begun.
    begun: u32,
}

/// The pages of a database file, some of them in memory.
#[derive(Debug)]
pub struct ResidentPages {
    file: PageFile,
    budget: u64,
    /// State of each [part](crate::voxel::Directory::part_index).
    states: Box<[AtomicU8]>,
    ledger: Mutex<Ledger>,
    came: Condvar,
    tally: PagingCounters,
    /// The thread that looks ahead: what it touches is no demand miss.
    manager: Mutex<Option<ThreadId>>,
    late: wants::Late,
}

impl ResidentPages {
    /// Pages of `file`, at most `budget` bytes of them in memory besides what stays always; `None`: as many as there are.
    pub fn new(file: PageFile, budget: Option<u64>) -> Self {
        let count = PagePart::COUNT * file.store().directory().len();
        let ledger =
            Ledger { needed_until: vec![0; count], needed_from: vec![None; count], ..Ledger::default() };
        Self {
            file,
            budget: budget.unwrap_or(u64::MAX),
            states: (0..count).map(|_| AtomicU8::new(0)).collect(),
            ledger: Mutex::new(ledger),
            came: Condvar::new(),
            tally: PagingCounters::default(),
            manager: Mutex::default(),
            late: wants::Late::default(),
        }
    }

    /// The file.
    pub fn file(&self) -> &PageFile {
        &self.file
    }

    /// Bytes of pages that may be in memory.
    pub fn budget(&self) -> u64 {
        self.budget
    }

    /// Returns what paging cost so far.
    pub fn paging(&self) -> Paging {
        let ledger = self.ledger();
        Paging { resident_bytes: ledger.bytes, resident_bytes_most: ledger.most, ..self.tally.read() }
    }

    pub(super) fn tally(&self) -> &PagingCounters {
        &self.tally
    }

    /// The calling thread looks ahead from now on.
    pub(super) fn manage(&self) {
        *self.manager.lock().unwrap_or_else(PoisonError::into_inner) = Some(sync::current().id());
    }

    /// Frames are numbered from 0 again.
    pub(super) fn begin_flight(&self) {
        let mut ledger = self.ledger();
        ledger.needed_until.fill(0);
        ledger.needed_from.fill(None);
        ledger.delivered = 0;
        ledger.begun = 0;
    }

    fn ledger(&self) -> MutexGuard<'_, Ledger> {
        self.ledger.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of a part of a page; `None` where the page is absent, or has no bytes that could be in memory or not.
    fn index(&self, part: PagePart) -> Option<usize> {
        self.file.store().directory().stored_part_index(part)
    }

    /// The part with a number.
    fn part(&self, index: usize) -> PagePart {
        self.file.store().directory().part(index)
    }

    /// Whether a part is in memory, or on its way.
    fn is_here_or_coming(&self, index: usize) -> bool {
        self.states[index].load(Ordering::Acquire) & (state::RESIDENT | state::COMING) != 0
    }

    /// Pages that the latest flight needed, each with the number of the first frame that did, in no order.
    pub fn first_use(&self) -> Vec<(PageId, u32)> {
        let directory = self.file.store().directory();
        let ledger = self.ledger();
        let first = |page: usize| {
            let parts = ledger.needed_from[page..].iter().step_by(directory.len());
            Some((directory.id(page), parts.flatten().copied().min()?))
        };
        (0..directory.len()).filter_map(first).collect()
    }

    /// Bytes of all pages.
    pub fn bytes(&self) -> u64 {
        self.file.store().directory().present().map(|(_, entry)| u64::from(entry.length)).sum()
    }

    /// Brings all pages into memory, in the order of the file: no flight waits for one any more.
    ///
    /// # Errors
    /// They are more than the budget; a page that is damaged; an interruption.
    pub fn load_all(&self, observer: &dyn Observer) -> Result<()> {
        let store = self.file.store();
        if self.bytes() > self.budget {
            return Err(Error::Configuration(format!(
                "{} holds {} MiB of pages, and {} MiB may be in memory: it cannot be loaded as a whole",
                self.file.path().display(),
                self.bytes().div_ceil(MIB),
                self.budget / MIB
            )));
        }

        let stored = store.directory().present().filter(|(_, entry)| entry.length > 0);
        let mut pages: Vec<_> = stored.map(|(id, entry)| (entry.offset, id)).collect();
        pages.sort_unstable();
        observer.begin("load", pages.len() as u64, "pages");

        for together in pages.chunks(LOADED_TOGETHER) {
            if observer.cancelled() {
                return Err(Error::Interrupted("the database was not loaded to its end".into()));
            }
            let parts = together.iter().flat_map(|(_, id)| PagePart::all(*id));
            let needs = PageNeeds::from(parts.collect::<Vec<_>>());
            self.read(&self.expect(0, &needs, None, |_| true).unwrap_or_default());
            // Says what is wrong with a page that did not come.
            needs.parts.iter().try_for_each(|part| store.load(*part).map(drop))?;
            observer.advance(together.len() as u64);
        }

        observer.end();
        Ok(())
    }

    /// Whether all pages are in memory, where they stay.
    pub(super) fn is_whole(&self) -> bool {
        let directory = self.file.store().directory();
        let is_here = |part| {
            self.index(part)
                .is_none_or(|index| self.states[index].load(Ordering::Acquire) & state::RESIDENT != 0)
        };
        let mut parts = directory.present().flat_map(|(id, _)| PagePart::all(id));
        self.bytes() <= self.budget && parts.all(is_here)
    }

    /// A frame begins.
    pub(super) fn begin(&self, frame: u32) {
        let mut ledger = self.ledger();
        ledger.begun = ledger.begun.max(frame + 1);
    }

    /// Frames below number `delivered` need nothing any more.
    pub(super) fn deliver(&self, delivered: u32) {
        self.ledger().delivered = delivered;
    }

    /// Reads a part that was reserved.
    fn fetch(&self, part: PagePart, index: usize) -> Result<()> {
        let store = self.file.store();
        let outcome = store.load(part);
        let mut ledger = self.ledger();
        match &outcome {
            Ok(bytes) => {
                PagingCounters::add(&self.tally.pages_read, 1);
                PagingCounters::add(&self.tally.bytes_read, *bytes);
                // What is read for a checksum alone is of use.
                PagingCounters::add(&self.tally.bytes_touched, *bytes - store.part_bytes(part));
                if self.budget < u64::MAX {
                    ledger.clock.add(index as u32);
                }
                self.states[index].store(state::RESIDENT, Ordering::Release);
                if *bytes > store.part_bytes(part) {
                    self.forget_others(part);
                }
            }
            Err(_) => {
                ledger.bytes -= store.part_bytes(part);
                self.states[index].store(state::FAILED, Ordering::Release);
            }
        }

        drop(ledger);
        self.came.notify_all();
        outcome.map(drop)
    }

    fn is_coming(&self, index: usize) -> bool {
        self.states[index].load(Ordering::Acquire) & state::COMING != 0
    }

    /// Lets go what was read of a page only because all of it was checked.
    fn forget_others(&self, part: PagePart) {
        let is_new =
            |other: &PagePart| self.index(*other).is_some_and(|index| !self.is_here_or_coming(index));
        PagePart::all(part.page()).filter(is_new).for_each(|other| self.forget(other));
    }

    /// Lets the memory of a part go that is not in memory any more.
    fn forget(&self, part: PagePart) {
        let stays = |other| {
            self.index(other).is_some_and(|index| self.is_here_or_coming(index) || self.is_leaving(index))
        };
        self.file.store().forget(part, stays);
    }

    /// Brings in a part that somebody touches, or waits for it if it is coming.
    #[cold]
    fn demand(&self, part: PagePart, index: usize) -> Result<()> {
        let begun = Instant::now();
        let mut is_miss = false;
        let mut ledger = self.ledger();

        let outcome = loop {
            let now = self.states[index].load(Ordering::Acquire);
            if now & state::RESIDENT != 0 {
                drop(ledger);
                break Ok(());
            }

            if now & state::COMING == 0 {
                // With nothing to spare the budget gives way: a frame needs what it needs.
                self.make_room(&mut ledger, self.file.store().part_bytes(part), &|_| Claim::None);
                let frame = ledger.delivered;
                ledger.needed_from[index].get_or_insert(frame);
                self.reserve(&mut ledger, part, index);
                drop(ledger);
                is_miss = true;
                self.announce(&[(part, index)]);
                break self.fetch(part, index);
            }

            ledger = self.came.wait(ledger).unwrap_or_else(PoisonError::into_inner);
        };

        if outcome.is_ok() {
            self.mark_used(index);
        }
        if !self.is_manager() {
            let counter = if is_miss { &self.tally.demand_misses } else { &self.tally.demand_waits };
            PagingCounters::add(counter, 1);
            PagingCounters::add_time(&self.tally.demand_wait_ns, begun.elapsed());
        }

        outcome
    }

    /// Notes that somebody reads a part, which is brought in if it is not there; of a page that is absent or has no bytes there is none.
    #[inline]
    fn touch(&self, part: PagePart) -> Result<()> {
        let Some(index) = self.index(part) else { return Ok(()) };
        let now = self.states[index].load(Ordering::Acquire);
        if now & state::RESIDENT == 0 {
            self.demand(part, index)?;
        } else if now & state::USED == 0 {
            // Once a round: a write takes the line from all other workers.
            self.mark_used(index);
        }
        Ok(())
    }

    fn mark_used(&self, index: usize) {
        let before = self.states[index].fetch_or(state::USED | state::TOUCHED, Ordering::Relaxed);
        if before & state::TOUCHED == 0 {
            PagingCounters::add(&self.tally.pages_touched, 1);
            PagingCounters::add(&self.tally.bytes_touched, self.file.store().part_bytes(self.part(index)));
        }
    }

    fn is_manager(&self) -> bool {
        let manager = *self.manager.lock().unwrap_or_else(PoisonError::into_inner);
        manager == Some(sync::current().id())
    }
}

impl PageSource for ResidentPages {
    fn header(&self) -> &Header {
        self.file.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        PagePart::posts(id).into_iter().try_for_each(|part| self.touch(part))?;
        self.file.page(id)
    }

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        self.touch(PagePart::Heights(id))?;
        self.file.heights(id)
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        self.touch(PagePart::Bounds(id))?;
        self.file.bounds(id)
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        if id.is_bare() {
            self.touch(PagePart::Spans(id))?;
        }
        self.file.spans(id)
    }

    fn has(&self, id: PageId) -> bool {
        self.file.has(id)
    }

    fn is_at_hand(&self, id: PageId) -> bool {
        let is_here = |index: usize| self.states[index].load(Ordering::Acquire) & state::RESIDENT != 0;
        PagePart::posts(id).into_iter().all(|part| self.index(part).is_none_or(is_here))
    }

    fn announce(&self, id: PageId) {
        let is_to_come =
            |part: &PagePart| self.index(*part).is_some_and(|index| !self.is_here_or_coming(index));
        for part in PagePart::posts(id).into_iter().filter(is_to_come) {
            self.file.store().announce(self.file.store().needed_for(part));
        }
    }

    fn bring(&self, pages: &[PageId]) {
        self.bring_in_sight(pages);
    }

    fn is_damaged(&self, id: PageId) -> bool {
        self.file.is_damaged(id)
    }

    fn intact(&self) -> Result<()> {
        self.file.intact()
    }
}
