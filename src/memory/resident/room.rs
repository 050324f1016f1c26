//! Room for what is to come.

use std::sync::atomic::Ordering;

use super::super::clock::Claim;
use super::super::tally::Tally;
use super::{Expected, KEPT_LEVEL, Ledger, ResidentPages, SOON, state};
use crate::voxel::{PageId, PageNeeds, PagePart};

/// Of the budget, what but paint is in memory may take so many fifths where light is computed ahead of need: light takes much of the rest, and
/// there must be room for some paint.
const OTHERS_FIFTHS: u64 = 2;

/// Parts that are needed, by number, and before which frame they were needed no more until then.
pub(in crate::memory) type Held = Vec<(usize, u32)>;

impl ResidentPages {
    /// Others use so many bytes of the budget.
    pub(in crate::memory) fn lend(&self, bytes: u64) {
        self.ledger().lent = bytes;
    }

    /// Bytes that pages may take now.
    pub(super) fn limit(&self, ledger: &Ledger) -> u64 {
        self.budget.saturating_sub(ledger.lent)
    }

    /// Makes room for what frame `frame` needs, ahead of it or as it begins, and returns what of it must be [read](Self::read): whoever
    /// touches that waits for it from now on. `None`: there is no room before frames in flight are delivered. For a frame that begins soon, what it
    /// is likely to read must do; one that begins now gets as much as there is room for.
    pub(in crate::memory) fn expect(
        &self,
        frame: u32,
        needs: &PageNeeds,
        behind: impl Fn(PageId) -> bool,
    ) -> Option<Vec<Expected>> {
        let mut ledger = self.ledger();
        let place = |page| if behind(page) { Claim::None } else { Claim::Ahead };
        let (likely, others) = needs.parts.split_at(needs.likely);
        let mut missing = self.hold(&mut ledger, frame, likely).0;
        let likely_bytes = self.bytes_of(&missing);
        let (more, held_before) = self.hold(&mut ledger, frame, others);
        let bytes = likely_bytes + self.bytes_of(&more);
        if self.make_room(&mut ledger, bytes, &place) {
            missing.extend(more);
        } else {
            release(&mut ledger, held_before);
            if frame > ledger.delivered + SOON {
                return None;
            }
            if !self.make_room(&mut ledger, likely_bytes, &place) && frame > ledger.delivered {
                return None;
            }
        }
        let mut room = self.limit(&ledger).saturating_sub(ledger.bytes);
        missing.retain(|&(part, index)| {
            let length = self.file.store().part_bytes(part);
            let fits = length <= room;
            if fits {
                room -= length;
                self.reserve(&mut ledger, part, index);
            }
            fits
        });
        Some(missing)
    }

    /// As [`Self::expect`], all of it or, if there is no room for it now, nothing; and what it was that is needed besides from now on.
    pub(in crate::memory) fn expect_all(
        &self,
        frame: u32,
        parts: &[PagePart],
        behind: impl Fn(PageId) -> bool,
    ) -> Option<(Vec<Expected>, Held)> {
        let mut ledger = self.ledger();
        let (missing, before) = self.hold(&mut ledger, frame, parts);
        let bytes = self.bytes_of(&missing);
        let place = |page| if behind(page) { Claim::None } else { Claim::Ahead };
        if !self.has_room(&ledger, bytes) || !self.make_room(&mut ledger, bytes, &place) {
            release(&mut ledger, before);
            return None;
        }
        for &(part, index) in &missing {
            self.reserve(&mut ledger, part, index);
        }
        Some((missing, before))
    }

    /// Whether all that a frame needs is more than may be in memory together, and leaves enough room without its paint.
    pub(in crate::memory) fn needs_no_paint(&self, parts: &[PagePart]) -> bool {
        let bytes = |parts: &mut dyn Iterator<Item = &PagePart>| -> u64 {
            parts.map(|part| self.file.store().part_bytes(*part)).sum()
        };
        let mut others = parts.iter().filter(|part| !matches!(part, PagePart::Paint(_)));
        bytes(&mut parts.iter()) > self.budget && bytes(&mut others) <= self.budget / 5 * OTHERS_FIFTHS
    }

    /// What was held is needed no longer than before.
    pub(in crate::memory) fn let_go_of(&self, held: Held) {
        release(&mut self.ledger(), held);
    }

    /// Notes that a frame needs parts. Returns those that are neither here nor coming, and until when each was held before.
    fn hold(&self, ledger: &mut Ledger, frame: u32, parts: &[PagePart]) -> (Vec<Expected>, Held) {
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

    pub(super) fn reserve(&self, ledger: &mut Ledger, part: PagePart, index: usize) {
        self.states[index].store(state::COMING, Ordering::Relaxed);
        ledger.bytes += if self.come_back(index) { 0 } else { self.file.store().part_bytes(part) };
        ledger.most = ledger.most.max(ledger.bytes);
    }

    /// Evicts until `bytes` more fit, now or when frames in flight have ended; whether they do. `place` is what a page's place speaks for.
    pub(super) fn make_room(&self, ledger: &mut Ledger, bytes: u64, place: &dyn Fn(PageId) -> Claim) -> bool {
        while ledger.bytes.saturating_add(bytes) > self.limit(ledger).saturating_add(self.leaving_bytes()) {
            let Ledger { clock, needed_until, delivered, lent, .. } = ledger;
            let victim = clock.victim(|index| {
                let index = index as usize;
                let id = self.part(index).page();
                if id.level >= KEPT_LEVEL || needed_until[index] > *delivered {
                    return Claim::Needed;
                }
                // Where memory is lent to light, what is lit already needs no paint.
                if *lent > 0 && matches!(self.part(index), PagePart::Paint(_)) {
                    return Claim::None;
                }
                let place = place(id);
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

    /// Whether so many bytes more fit if all goes that nobody needs.
    fn has_room(&self, ledger: &Ledger, bytes: u64) -> bool {
        let goes = |index: usize| {
            self.part(index).page().level < KEPT_LEVEL && ledger.needed_until[index] <= ledger.delivered
        };
        let parts = ledger.clock.pages().map(|index| index as usize).filter(|index| goes(*index));
        let most: u64 = parts.map(|index| self.file.store().part_bytes(self.part(index))).sum();
        ledger.bytes.saturating_sub(most).saturating_add(bytes)
            <= self.limit(ledger).saturating_add(self.leaving_bytes())
    }

    pub(super) fn evict(&self, ledger: &mut Ledger, index: usize) {
        self.states[index].store(0, Ordering::Release);
        Tally::add(&self.tally.pages_evicted, 1);
        self.leave(ledger, index);
    }
}

fn release(ledger: &mut Ledger, held: Held) {
    for (index, until) in held.into_iter().rev() {
        ledger.needed_until[index] = until;
    }
}
