//! Frames that never wait: each sees the pages that are in memory when it begins, and wants the others.
//!
//! ```text
//! a frame begins ──▶ PresentPages: which pages are in memory, frozen ──▶ workers
//!                                     │ asked for, not there: absent for this frame, so that a coarser level stands in
//!                                     ▼
//!                                   wanted ──▶ memory thread ──▶ there for the next frame
//! ```
//!
//! All workers of a frame see the same pages, whatever comes or goes meanwhile: what is evicted stays readable until the last frame that
//! had it has ended.

use std::collections::VecDeque;
use std::sync::atomic::Ordering;

use super::super::sync::{AtomicU8, AtomicU64, Sender};
use super::{Claim, Expected, Ledger, PagingCounters, ResidentPages, state};
use crate::voxel::{BoundsView, Header, HeightsView, PageId, PagePart, PageSource, PageView, SpansView};
use hedgehop_base::error::Result;

/// Pages that are brought together before others may come first.
const TOGETHER: usize = 4;

/// The pages of a database that were in memory when a frame began; others are absent, and wanted.
///
/// To ask for a page never waits and never reads the disk, as long as the system keeps what was read.
#[derive(Debug)]
pub struct PresentPages<'f> {
    pages: &'f ResidentPages,
    /// Parts that are present, 64 to a word.
    here: Box<[u64]>,
    /// Parts that this frame asked for in vain, in the same way.
    missed: Box<[AtomicU64]>,
    /// Number of the frame among those that defer eviction ([`DeferredEviction::begin`](super::super::deferred_eviction::DeferredEviction::begin)).
    number: u64,
    /// Wakes the memory thread.
    news: &'f Sender<()>,
}

impl PresentPages<'_> {
    fn is_here(&self, index: usize) -> bool {
        self.here[index / 64] >> (index % 64) & 1 != 0
    }

    /// Whether a page has no bytes that would have to come.
    fn is_empty_page(&self, id: PageId) -> bool {
        self.pages.file.store().directory().is_empty_page(id)
    }

    /// Pages that are here.
    pub fn count(&self) -> u32 {
        self.here.iter().map(|word| word.count_ones()).sum()
    }

    /// Whether a part is here; notes that it is used, or wanted.
    #[inline]
    fn touch(&self, part: PagePart) -> Result<bool> {
        let Some(index) = self.pages.index(part) else { return Ok(self.is_empty_page(part.page())) };
        if !self.is_here(index) {
            return self.want(part, index).map(|()| false);
        }
        let now = self.pages.states[index].load(Ordering::Relaxed);
        if now & state::RESIDENT != 0 && now & state::USED == 0 {
            self.pages.mark_used(index);
        }
        Ok(true)
    }

    /// Whether a page's heights and paint are here: a surface is not painted with another level's colours. Both are wanted if both are absent.
    #[inline]
    fn has_posts(&self, id: PageId) -> Result<bool> {
        let [heights, paint] = PagePart::posts(id).map(|part| self.touch(part));
        Ok(heights? & paint?)
    }

    /// Notes that a part was asked for that is not here. One that was found damaged is told.
    #[cold]
    fn want(&self, part: PagePart, index: usize) -> Result<()> {
        let known = &self.pages.states[index];
        let before = known.load(Ordering::Acquire);
        if before & state::FAILED != 0 {
            return self.pages.file.store().load(part).map(drop);
        }
        let bit = 1 << (index % 64);
        if self.missed[index / 64].fetch_or(bit, Ordering::Relaxed) & bit == 0 {
            PagingCounters::add(&self.pages.tally.pages_late, 1);
        }
        let is_new = before & (state::WANTED | state::COMING | state::RESIDENT) == 0
            && known.fetch_or(state::WANTED, Ordering::Relaxed) & state::WANTED == 0;
        if is_new {
            self.pages.late.wanted.push(part);
            // Full: it will look anyway.
            let _ = self.news.try_send(());
        }
        Ok(())
    }
}

impl Drop for PresentPages<'_> {
    fn drop(&mut self) {
        self.pages.late.deferred().end(self.number);
    }
}

impl PageSource for PresentPages<'_> {
    fn header(&self) -> &Header {
        self.pages.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        if self.has_posts(id)? { self.pages.file.page(id) } else { Ok(None) }
    }

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        if self.has_posts(id)? { self.pages.file.heights(id) } else { Ok(None) }
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        if self.touch(PagePart::Bounds(id))? { self.pages.file.bounds(id) } else { Ok(None) }
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        if id.is_bare() && self.touch(PagePart::Spans(id))? { self.pages.file.spans(id) } else { Ok(None) }
    }

    fn has(&self, id: PageId) -> bool {
        let is_here = |part| self.pages.index(part).is_some_and(|index| self.is_here(index));
        let is_here = PagePart::posts(id).into_iter().all(is_here) || self.is_empty_page(id);
        is_here && self.pages.file.has(id)
    }

    fn is_damaged(&self, id: PageId) -> bool {
        self.pages.file.is_damaged(id)
    }

    fn intact(&self) -> Result<()> {
        self.pages.file.intact()
    }
}

/// Frame for which pages are brought, and what may go for them.
#[derive(Clone, Copy)]
pub(in crate::memory) enum Purpose<'a> {
    /// A frame that has begun or is about to: all that no such frame needs may go.
    Now(u32, &'a dyn Fn(PageId) -> bool),
    /// A frame far ahead: only what lies behind the eye may go.
    Ahead(u32, &'a dyn Fn(PageId) -> bool),
}

impl Purpose<'_> {
    /// Returns the claim that the place of a page makes when room is made.
    fn against(&self, page: PageId) -> Claim {
        match self {
            Self::Now(_, is_behind) | Self::Ahead(_, is_behind) if is_behind(page) => Claim::None,
            Self::Now(..) => Claim::Ahead,
            Self::Ahead(..) => Claim::Needed,
        }
    }
}

impl ResidentPages {
    /// Takes what is in memory now, for a frame that begins.
    pub(in crate::memory) fn present<'f>(&'f self, news: &'f Sender<()>) -> PresentPages<'f> {
        // First: what leaves from now on stays for this frame.
        let number = self.late.deferred().begin();
        let is_here = |page: &AtomicU8| u64::from(page.load(Ordering::Acquire) & state::RESIDENT != 0);
        let word = |pages: &[_]| pages.iter().rev().fold(0, |word, page| word << 1 | is_here(page));
        let here: Box<[u64]> = self.states.chunks(64).map(word).collect();
        let missed = here.iter().map(|_| AtomicU64::new(0)).collect();
        PresentPages { pages: self, here, missed, number, news }
    }

    /// Brings the coarsest level, which stands in for all others where nothing else can.
    ///
    /// # Errors
    /// A page of it that is damaged.
    pub(in crate::memory) fn bring_coarsest(&self) -> Result<()> {
        let coarsest = self.header().level_count - 1;
        let mut pages = self.file.directory().present().filter(|(id, _)| id.level == coarsest);
        pages.try_for_each(|(id, _)| self.page(id).and_then(|_| self.bounds(id)).map(drop))
    }

    /// Adds what frames asked for and did not have since this was asked last.
    pub(in crate::memory) fn take_wanted(&self, into: &mut Vec<PagePart>) {
        into.extend(std::iter::from_fn(|| self.late.wanted.pop()));
    }

    /// Pages are not wanted any more, until somebody asks for them again.
    pub(in crate::memory) fn forget_wanted(&self, parts: impl Iterator<Item = PagePart>) {
        for index in parts.filter_map(|part| self.index(part)) {
            self.states[index].fetch_and(!state::WANTED, Ordering::Relaxed);
        }
    }

    /// Keeps what `frame` needs until it is delivered.
    pub(in crate::memory) fn keep_for(&self, frame: u32, needs: &VecDeque<PagePart>) {
        let mut ledger = self.ledger();
        for index in needs.iter().filter_map(|part| self.index(*part)) {
            ledger.needed_until[index] = ledger.needed_until[index].max(frame + 1);
        }
    }

    /// Brings some of `parts`, first ones first, as far as there is room, and takes them off the list with those that are there already.
    /// `false`: there is no room for the next one before frames end.
    pub(in crate::memory) fn bring_some(&self, parts: &mut VecDeque<PagePart>, need: Purpose<'_>) -> bool {
        let (Purpose::Now(frame, _) | Purpose::Ahead(frame, _)) = need;
        let mut coming = Vec::new();
        let mut has_room = true;
        {
            let mut ledger = self.ledger();
            self.let_go(&mut ledger);
            while coming.len() < TOGETHER
                && let Some(&first) = parts.front()
            {
                // Heights are of no use without the paint.
                let has_paint = parts.get(1) == Some(&PagePart::Paint(first.page()));
                let count = if first == PagePart::Heights(first.page()) && has_paint { 2 } else { 1 };
                let known = parts.range(..count).filter_map(|part| Some((*part, self.index(*part)?)));
                let is_there = |index: usize| {
                    let there = state::RESIDENT | state::COMING | state::FAILED;
                    self.states[index].load(Ordering::Acquire) & there != 0
                };
                let missing: Vec<Expected> = known.filter(|(_, index)| !is_there(*index)).collect();
                has_room = missing.is_empty() || self.make_room_for(&mut ledger, &missing, need);
                if !has_room {
                    break;
                }

                for &(part, index) in &missing {
                    ledger.needed_from[index].get_or_insert(frame);
                    self.reserve(&mut ledger, part, index);
                }

                coming.extend(missing);
                parts.drain(..count);
            }
        }

        self.announce(&coming);
        for (part, index) in coming {
            // Whoever asks for a damaged page is told so then.
            let _ = self.fetch(part, index);
        }

        has_room
    }

    /// Evicts what may go for parts; whether there is room for them now. What frames in flight hold leaves later.
    fn make_room_for(&self, ledger: &mut Ledger, parts: &[Expected], need: Purpose<'_>) -> bool {
        let length = self.bytes_of(parts);
        self.make_room(ledger, length, &|page| need.against(page))
            && ledger.bytes.saturating_add(length) <= self.budget
    }

    /// Bytes that will be free when frames in flight have ended.
    pub(super) fn leaving_bytes(&self) -> u64 {
        let store = self.file.store();
        self.late.deferred().waiting().map(|index| store.part_bytes(self.part(index as usize))).sum()
    }

    /// A part that was evicted goes when no frame may read it any more.
    pub(super) fn leave(&self, ledger: &mut Ledger, index: usize) {
        self.late.deferred().leave(index as u32);
        self.let_go(ledger);
    }

    /// Whether a part was evicted that frames may still read.
    pub(super) fn is_leaving(&self, index: usize) -> bool {
        self.late.deferred().waiting().any(|waiting| waiting as usize == index)
    }

    /// A part comes that frames may still hold from before: it is in memory once and counts once. Whether it is so.
    pub(super) fn come_back(&self, index: usize) -> bool {
        self.late.deferred().come_back(index as u32)
    }

    /// Lets the memory of pages go that have left and that no frame may read any more.
    pub(in crate::memory) fn let_go_all(&self) {
        self.let_go(&mut self.ledger());
    }

    fn let_go(&self, ledger: &mut Ledger) {
        let store = self.file.store();
        let next = || self.late.deferred().gone();
        for index in std::iter::from_fn(next).map(|index| index as usize) {
            let part = self.part(index);
            ledger.bytes -= store.part_bytes(part);
            self.forget(part);
        }
    }

    /// Evicts a part, whatever speaks for it.
    #[cfg(test)]
    pub(in crate::memory) fn evict_now(&self, part: PagePart) {
        let mut ledger = self.ledger();
        let goes = |index: u32| if self.part(index as usize) == part { Claim::None } else { Claim::Needed };
        let victim = ledger.clock.victim(goes);
        self.evict(&mut ledger, victim.expect("the part is in memory") as usize);
    }
}
