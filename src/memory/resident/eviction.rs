//! Room for what is to come.

use std::collections::HashSet;
use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::super::clock::Claim;
use super::super::counters::PagingCounters;
use super::{Expected, KEPT_LEVEL, Ledger, ResidentPages, SOON, state};
use crate::voxel::{PageId, PageNeeds, PagePart};

/// Parts of a hundred of the budget that frames ahead may take where their paint is brought once it is in sight, which has the others.
const AHEAD_SHARE: u64 = 50;

/// Paint that frames which are not delivered yet may have in sight, with their numbers.
pub(in crate::memory) type PaintInSight = Vec<(u32, Vec<PagePart>)>;

impl ResidentPages {
    /// Makes room for what frame `frame` needs, ahead of it or as it begins, and returns what of it must be [read](Self::read): whoever
    /// touches that waits for it from now on. `None`: there is no room before frames in flight are delivered. What it is
    /// likely to read must do for a frame that begins soon; one that begins now gets as much as there is room for. `paint` that this frame and those in flight
    /// have left out of what they need, because it is brought once it is in sight, has room beside that.
    pub(in crate::memory) fn expect(
        &self,
        frame: u32,
        needs: &PageNeeds,
        paint: Option<&PaintInSight>,
        behind: impl Fn(PageId) -> bool,
    ) -> Option<Vec<Expected>> {
        let mut ledger = self.ledger();
        let is_soon = frame <= ledger.delivered + SOON;
        if frame > ledger.delivered
            && paint.is_some_and(|paint| !self.leaves_room(&ledger, needs, paint, is_soon))
        {
            return None;
        }

        let place = |page| if behind(page) { Claim::None } else { Claim::Ahead };
        let (likely, others) = needs.parts.split_at(needs.likely);
        let mut missing = self.hold(&mut ledger, frame, likely).0;
        let likely_bytes = self.bytes_of(&missing);
        let (more, held_before) = self.hold(&mut ledger, frame, others);
        let bytes = likely_bytes + self.bytes_of(&more);

        if self.make_room(&mut ledger, bytes, &place) {
            missing.extend(more);
        } else {
            for (index, until) in held_before {
                ledger.needed_until[index] = until;
            }
            if !is_soon {
                return None;
            }
            if !self.make_room(&mut ledger, likely_bytes, &place) && frame > ledger.delivered {
                return None;
            }
        }

        self.reserve_what_fits(&mut ledger, &mut missing);
        Some(missing)
    }

    /// Whether what stays, what comes and what a frame needs have room: together with all of `paint` if the frame is in flight or
    /// soon will be, or else within the share of frames ahead.
    fn leaves_room(&self, ledger: &Ledger, needs: &PageNeeds, paint: &PaintInSight, is_soon: bool) -> bool {
        let bytes = |index| self.file.store().part_bytes(self.part(index));
        let stays = |index: usize| {
            ledger.needed_until[index] > ledger.delivered || self.part(index).page().level >= KEPT_LEVEL
        };
        let here = ledger.clock.pages().map(|index| index as usize);
        let may_go: u64 = here.filter(|index| !stays(*index)).map(bytes).sum();
        let limit = if is_soon { self.budget } else { self.budget / 100 * AHEAD_SHARE };
        let paint = paint.iter().filter(|_| is_soon).flat_map(|(_, paint)| paint);
        let wanted: HashSet<_> =
            needs.parts.iter().chain(paint).filter_map(|part| self.index(*part)).collect();
        let has_room = |index: usize| self.is_coming(index) || self.is_here_or_coming(index) && stays(index);
        let more: u64 = wanted.into_iter().filter(|index| !has_room(*index)).map(bytes).sum();
        ledger.bytes + more <= limit + may_go
    }

    /// Brings what is seen of pages, heights and paint, for a frame that has begun, and waits until it is there. It stays for all frames that have.
    pub(super) fn bring_in_sight(&self, pages: &[PageId]) {
        let begun = Instant::now();
        let parts: Vec<_> = pages.iter().flat_map(|page| PagePart::posts(*page)).collect();
        let mut ledger = self.ledger();

        // It is for one of the frames in flight; beside a flight nothing says when it is needed no more.
        let (delivered, until) = (ledger.delivered, ledger.begun);
        let mut missing = Vec::new();
        for &part in &parts {
            let Some(index) = self.index(part) else { continue };
            ledger.needed_until[index] = ledger.needed_until[index].max(until);
            ledger.needed_from[index].get_or_insert(delivered);
            if !self.is_here_or_coming(index) {
                missing.push((part, index));
            }
        }

        let bytes = self.bytes_of(&missing);
        // With nothing to spare the budget gives way: a frame needs what it needs.
        self.make_room(&mut ledger, bytes, &|_| Claim::None);
        missing.iter().for_each(|(part, index)| self.reserve(&mut ledger, *part, *index));
        drop(ledger);
        PagingCounters::add(&self.tally.pages_in_sight, missing.len() as u64);
        self.read(&missing);
        let mut ledger = self.ledger();
        while parts.iter().any(|part| self.index(*part).is_some_and(|index| self.is_coming(index))) {
            ledger = self.came.wait(ledger).unwrap_or_else(PoisonError::into_inner);
        }

        drop(ledger);
        PagingCounters::add_time(&self.tally.frame_wait_ns, begun.elapsed());
    }

    /// Notes that a frame needs parts. Returns those that are neither here nor coming, and until when each was held before.
    fn hold(
        &self,
        ledger: &mut Ledger,
        frame: u32,
        parts: &[PagePart],
    ) -> (Vec<Expected>, Vec<(usize, u32)>) {
        let (mut missing, mut before) = (Vec::new(), Vec::new());
        for &part in parts {
            let Some(index) = self.index(part) else { continue };
            before.push((index, ledger.needed_until[index]));
            ledger.needed_until[index] = frame + 1;
            ledger.needed_from[index].get_or_insert(frame);
            if !self.is_here_or_coming(index) {
                missing.push((part, index));
            }
        }
        (missing, before)
    }

    pub(super) fn bytes_of(&self, parts: &[Expected]) -> u64 {
        parts.iter().map(|(part, _)| self.file.store().part_bytes(*part)).sum()
    }

    /// Reserves parts in order, as far as there is room, and leaves the others out.
    fn reserve_what_fits(&self, ledger: &mut Ledger, parts: &mut Vec<Expected>) {
        let mut room = self.budget.saturating_sub(ledger.bytes);
        parts.retain(|&(part, index)| {
            let length = self.file.store().part_bytes(part);
            let fits = length <= room;
            if fits {
                room -= length;
                self.reserve(ledger, part, index);
            }
            fits
        });
    }

    pub(super) fn reserve(&self, ledger: &mut Ledger, part: PagePart, index: usize) {
        self.states[index].store(state::COMING, Ordering::Relaxed);
        ledger.bytes += if self.come_back(index) { 0 } else { self.file.store().part_bytes(part) };
        ledger.most = ledger.most.max(ledger.bytes);
    }

    /// Evicts until `bytes` more fit, now or when frames in flight have ended; whether they do. `place` is what a page's place speaks for.
    pub(super) fn make_room(&self, ledger: &mut Ledger, bytes: u64, place: &dyn Fn(PageId) -> Claim) -> bool {
        while ledger.bytes.saturating_add(bytes) > self.budget.saturating_add(self.leaving_bytes()) {
            let Ledger { clock, needed_until, delivered, .. } = ledger;
            let victim = clock.victim(|index| {
                let index = index as usize;
                let page = self.part(index).page();
                let is_needed = page.level >= KEPT_LEVEL || needed_until[index] > *delivered;
                let place = if is_needed { Claim::Needed } else { place(page) };
                if place == Claim::Needed {
                    return place;
                }
                let before = self.states[index].fetch_and(!state::USED, Ordering::Relaxed);
                if before & state::USED != 0 { Claim::Used } else { place }
            });
            let Some(index) = victim else { return false };
            self.evict(ledger, index as usize);
        }
        true
    }

    pub(super) fn evict(&self, ledger: &mut Ledger, index: usize) {
        self.states[index].store(0, Ordering::Release);
        PagingCounters::add(&self.tally.pages_evicted, 1);
        self.leave(ledger, index);
    }
}
