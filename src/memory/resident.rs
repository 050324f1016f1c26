//! Which pages are in memory, within a budget.
//!
//! ```text
//!                     the memory thread, ahead of need
//!              ┌────────────────────────────────────────────┐
//!   on disk ───┤                                            ├──▶ resident ──▶ touched
//!      ▲       └── a worker that cannot wait: demand miss ──┘        │           │
//!      └────────────── evicted, when room is needed and no frame in flight or ahead needs it
//! ```
//!
//! The database stays mapped whatever is resident: an eviction is advice to the system, and a view that outlives it reads the
//! file again. What pictures show can therefore never depend on what is in memory.

use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};
use std::time::Instant;

use super::clock::{Claim, Clock};
use super::tally::Tally;
use super::{PageFile, Paging};
use crate::error::{Error, Result};
use crate::progress::Observer;
use crate::voxel::{Header, PageId, PageSource, PageView};

/// Level index from which on pages stay once they are there: voxels of 64 units, and coarser ones. All that is known of what may
/// be hidden rests on their bounds.
const KEPT_LEVEL: u8 = 3;

/// Pages that are asked for together when all are loaded.
const LOADED_TOGETHER: usize = 64;

const MIB: u64 = 1 << 20;

/// Bits of a page's state.
mod state {
    /// It is in memory.
    pub const RESIDENT: u8 = 1;
    /// Some thread brings it there.
    pub const COMING: u8 = 2;
    /// It was touched since the clock's hand passed.
    pub const USED: u8 = 4;
    /// It was touched since it came.
    pub const TOUCHED: u8 = 8;
}

/// What is decided under one lock.
#[derive(Debug, Default)]
struct Ledger {
    clock: Clock,
    /// Bytes that are resident or coming.
    bytes: u64,
    most: u64,
    /// By page: the number of the first frame that is not known to need it any more.
    needed_until: Vec<u32>,
    /// By page: the number of the first frame that needed it; `None` if none did.
    needed_from: Vec<Option<u32>>,
    /// Frames below this number have been delivered.
    delivered: u32,
}

/// The pages of a database file, some of them in memory.
#[derive(Debug)]
pub struct ResidentPages {
    file: PageFile,
    budget: u64,
    /// By directory index.
    states: Box<[AtomicU8]>,
    ledger: Mutex<Ledger>,
    came: Condvar,
    tally: Tally,
    /// The thread that looks ahead: what it touches is no demand miss.
    manager: Mutex<Option<ThreadId>>,
}

impl ResidentPages {
    /// Pages of `file`, at most `budget` bytes of them in memory besides what stays always; `None`: as many as there are.
    pub fn new(file: PageFile, budget: Option<u64>) -> Self {
        let count = file.store().directory().len();
        let ledger =
            Ledger { needed_until: vec![0; count], needed_from: vec![None; count], ..Ledger::default() };
        Self {
            file,
            budget: budget.unwrap_or(u64::MAX),
            states: (0..count).map(|_| AtomicU8::new(0)).collect(),
            ledger: Mutex::new(ledger),
            came: Condvar::new(),
            tally: Tally::default(),
            manager: Mutex::default(),
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

    /// What paging cost so far.
    pub fn paging(&self) -> Paging {
        let ledger = self.ledger();
        Paging { resident_bytes: ledger.bytes, resident_bytes_most: ledger.most, ..self.tally.read() }
    }

    pub(super) fn tally(&self) -> &Tally {
        &self.tally
    }

    /// The calling thread looks ahead from now on.
    pub(super) fn manage(&self) {
        *self.manager.lock().unwrap_or_else(PoisonError::into_inner) = Some(thread::current().id());
    }

    /// Frames are numbered from 0 again.
    pub(super) fn begin_flight(&self) {
        let mut ledger = self.ledger();
        ledger.needed_until.fill(0);
        ledger.needed_from.fill(None);
        ledger.delivered = 0;
    }

    fn ledger(&self) -> MutexGuard<'_, Ledger> {
        self.ledger.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn index(&self, id: PageId) -> Option<usize> {
        let directory = self.file.store().directory();
        directory.get(id).and_then(|_| directory.index(id))
    }

    /// Pages that the latest flight needed, each with the number of the first frame that did, in no order.
    pub fn first_use(&self) -> Vec<(PageId, u32)> {
        let directory = self.file.store().directory();
        let ledger = self.ledger();
        let needed = ledger.needed_from.iter().enumerate();
        needed.filter_map(|(index, frame)| Some((directory.id(index), (*frame)?))).collect()
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
        let mut pages: Vec<_> = store.directory().present().map(|(id, entry)| (entry.offset, id)).collect();
        pages.sort_unstable();
        observer.begin("load", pages.len() as u64, "pages");
        for together in pages.chunks(LOADED_TOGETHER) {
            if observer.cancelled() {
                return Err(Error::Interrupted("the database was not loaded to its end".into()));
            }
            let pages: Vec<_> = together.iter().map(|(_, id)| *id).collect();
            self.bring(0, &pages, |_| true);
            // Says what is wrong with a page that did not come.
            pages.iter().try_for_each(|id| store.load(*id))?;
            observer.advance(pages.len() as u64);
        }
        observer.end();
        Ok(())
    }

    /// Whether all pages are in memory, where they stay.
    pub(super) fn is_whole(&self) -> bool {
        let directory = self.file.store().directory();
        let is_here = |id| {
            directory
                .index(id)
                .is_some_and(|index| self.states[index].load(Ordering::Acquire) & state::RESIDENT != 0)
        };
        self.bytes() <= self.budget && directory.present().all(|(id, _)| is_here(id))
    }

    /// Frames below number `delivered` need nothing any more.
    pub(super) fn deliver(&self, delivered: u32) {
        self.ledger().delivered = delivered;
    }

    /// Brings what frame `frame` needs into memory, `ahead` of it or as it begins. `false`: there is no room before
    /// frames in flight are delivered. A frame that begins gets as much as there is room for.
    pub(super) fn bring(&self, frame: u32, needs: &[PageId], behind: impl Fn(PageId) -> bool) -> bool {
        let mut missing = Vec::new();
        {
            let mut ledger = self.ledger();
            let mut bytes = 0;
            for &id in needs {
                let Some(index) = self.index(id) else { continue };
                ledger.needed_until[index] = frame + 1;
                ledger.needed_from[index].get_or_insert(frame);
                if self.states[index].load(Ordering::Acquire) & (state::RESIDENT | state::COMING) == 0 {
                    missing.push((id, index));
                    bytes += self.length(id);
                }
            }
            let has_room = self.make_room(&mut ledger, bytes, &behind);
            if !has_room && frame > ledger.delivered {
                return false;
            }
            let mut room = self.budget.saturating_sub(ledger.bytes);
            missing.retain(|&(id, index)| {
                let length = self.length(id);
                let fits = length <= room;
                if fits {
                    room -= length;
                    self.reserve(&mut ledger, id, index);
                }
                fits
            });
        }
        self.announce(&missing);
        for (id, index) in missing {
            // Whoever needs a damaged page is told so when it is touched.
            let _ = self.fetch(id, index);
        }
        true
    }

    /// Says what will be read, in stretches as long as they lie in the file.
    fn announce(&self, pages: &[(PageId, usize)]) {
        let store = self.file.store();
        let mut extents: Vec<_> = pages.iter().filter_map(|(id, _)| store.extent(*id)).collect();
        extents.sort_unstable_by_key(|extent| extent.start);
        let mut run: Option<std::ops::Range<usize>> = None;
        for extent in extents {
            run = match run.take() {
                Some(run) if extent.start <= run.end.next_multiple_of(ALIGNMENT) => {
                    Some(run.start..extent.end)
                }
                other => {
                    if let Some(run) = other {
                        store.announce(run);
                    }
                    Some(extent)
                }
            };
        }
        if let Some(run) = run {
            store.announce(run);
        }
    }

    fn length(&self, id: PageId) -> u64 {
        self.file.store().directory().get(id).map_or(0, |entry| u64::from(entry.length))
    }

    fn reserve(&self, ledger: &mut Ledger, id: PageId, index: usize) {
        self.states[index].store(state::COMING, Ordering::Relaxed);
        ledger.bytes += self.length(id);
        ledger.most = ledger.most.max(ledger.bytes);
    }

    /// Evicts until `bytes` more fit; whether they do.
    fn make_room(&self, ledger: &mut Ledger, bytes: u64, behind: &dyn Fn(PageId) -> bool) -> bool {
        while ledger.bytes.saturating_add(bytes) > self.budget {
            let Ledger { clock, needed_until, delivered, .. } = ledger;
            let directory = self.file.store().directory();
            let victim = clock.victim(|page| {
                let index = page as usize;
                let id = directory.id(index);
                if id.level >= KEPT_LEVEL || needed_until[index] > *delivered {
                    return Claim::Needed;
                }
                let before = self.states[index].fetch_and(!state::USED, Ordering::Relaxed);
                match before & state::USED != 0 {
                    true => Claim::Used,
                    false if behind(id) => Claim::None,
                    false => Claim::Ahead,
                }
            });
            let Some(page) = victim else { return false };
            self.evict(ledger, page as usize);
        }
        true
    }

    fn evict(&self, ledger: &mut Ledger, index: usize) {
        let store = self.file.store();
        let id = store.directory().id(index);
        self.states[index].store(0, Ordering::Release);
        ledger.bytes -= self.length(id);
        Tally::add(&self.tally.pages_evicted, 1);
        if let Some(extent) = store.extent(id) {
            store.forget(extent);
        }
    }

    /// Reads a page that was reserved.
    fn fetch(&self, id: PageId, index: usize) -> Result<()> {
        let outcome = self.file.store().load(id);
        let mut ledger = self.ledger();
        if outcome.is_ok() {
            Tally::add(&self.tally.pages_read, 1);
            Tally::add(&self.tally.bytes_read, self.length(id));
            if self.budget < u64::MAX {
                ledger.clock.add(index as u32);
            }
            self.states[index].store(state::RESIDENT, Ordering::Release);
        } else {
            ledger.bytes -= self.length(id);
            self.states[index].store(0, Ordering::Release);
        }
        drop(ledger);
        self.came.notify_all();
        outcome
    }

    /// Brings in a page that somebody touches, or waits for it if it is coming.
    #[cold]
    fn demand(&self, id: PageId, index: usize) -> Result<()> {
        let begun = Instant::now();
        let mut ledger = self.ledger();
        let outcome = loop {
            let now = self.states[index].load(Ordering::Acquire);
            if now & state::RESIDENT != 0 {
                drop(ledger);
                break Ok(());
            }
            if now & state::COMING == 0 {
                // With nothing to spare the budget gives way: a frame needs what it needs.
                self.make_room(&mut ledger, self.length(id), &|_| true);
                let frame = ledger.delivered;
                ledger.needed_from[index].get_or_insert(frame);
                self.reserve(&mut ledger, id, index);
                drop(ledger);
                break self.fetch(id, index);
            }
            ledger = self.came.wait(ledger).unwrap_or_else(PoisonError::into_inner);
        };
        if outcome.is_ok() {
            self.mark_used(index);
        }
        self.count_miss(begun);
        outcome
    }

    fn mark_used(&self, index: usize) {
        let before = self.states[index].fetch_or(state::USED | state::TOUCHED, Ordering::Relaxed);
        if before & state::TOUCHED == 0 {
            Tally::add(&self.tally.pages_touched, 1);
        }
    }

    fn count_miss(&self, begun: Instant) {
        let manager = *self.manager.lock().unwrap_or_else(PoisonError::into_inner);
        if manager != Some(thread::current().id()) {
            Tally::add(&self.tally.demand_misses, 1);
            Tally::add_time(&self.tally.demand_wait_ns, begun.elapsed());
        }
    }
}

/// Pages of a database begin at multiples of this in their file.
const ALIGNMENT: usize = 4096;

impl PageSource for ResidentPages {
    fn header(&self) -> &Header {
        self.file.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        let Some(index) = self.index(id) else { return Ok(None) };
        let now = self.states[index].load(Ordering::Acquire);
        if now & state::RESIDENT == 0 {
            self.demand(id, index)?;
        } else if now & state::USED == 0 {
            // Once a round: a write takes the line from all other workers.
            self.mark_used(index);
        }
        self.file.page(id)
    }

    fn has(&self, id: PageId) -> bool {
        self.file.has(id)
    }

    fn is_damaged(&self, id: PageId) -> bool {
        self.file.is_damaged(id)
    }

    fn intact(&self) -> Result<()> {
        self.file.intact()
    }
}
