//! A flight whose path nobody knows beforehand, and whose frames never wait.
//!
//! ```text
//! loop:
//!     a frame has begun?  what the one before wanted comes no more, unless this one wants it too
//!                         what the next one needs, as predicted, stays
//!     bring what frames want, coarsest first: it stands in for the others soonest
//!     else what the next frame needs; then what a frame farther ahead needs, one after the other
//!     nothing to do, or no room:  wait until a frame begins, wants a page or is delivered
//! ```
//!
//! To foresee all thirty frames again whenever another pose is known would take longer than a frame. The farthest names what comes
//! into sight, and as it moves with the flight it passes over all that lies between; a nearer one and the next correct it where the flight turned out
//! otherwise. What is far ahead makes room behind the eye only, what is near wherever the present frames need nothing.

use std::collections::VecDeque;
use std::sync::atomic::Ordering;

use super::flight::{Flight, LOOKAHEAD, PagePlanner};
use super::resident::{PresentPages, Purpose};
use super::sync::{AtomicU32, Receiver};
use super::{Paging, ResidentPages};
use crate::voxel::PagePart;
use hedgehop_base::error::Result;

/// Frames ahead of the next one that are foreseen in turn.
const FARTHER: [u32; 2] = [LOOKAHEAD / 4, LOOKAHEAD - 1];

/// A flight on its way whose frames never wait, as those see it who render.
#[derive(Debug)]
pub struct LiveFlight<'f, 'p> {
    flight: &'f Flight<'p>,
    /// Frames below this number have begun.
    begun: &'f AtomicU32,
}

impl LiveFlight<'_, '_> {
    /// A frame begins, with the pages that are in memory. What is known of its pose is to be told to the planner before.
    pub fn begin(&self, frame: u32) -> PresentPages<'_> {
        let present = self.flight.pages.present(&self.flight.news);
        self.begun.fetch_max(frame + 1, Ordering::Release);
        self.flight.tell();
        present
    }

    /// A frame has been delivered, and all before it: what only they needed may go.
    pub fn deliver(&self, frame: u32) {
        self.flight.deliver(frame);
    }

    /// Lists the paging of each frame, in the order of delivery, counted since the one before it was delivered.
    pub fn frames(&self) -> Vec<Paging> {
        self.flight.frames()
    }
}

/// Order in which frames farther ahead are foreseen.
#[derive(Debug, Default)]
struct Agenda {
    /// Frames below this number have begun.
    begun: u32,
    /// Index into [`FARTHER`] of the next frame that is due.
    farther_due: usize,
    place: usize,
}

impl Agenda {
    /// The next frame, if another has begun since this was asked last.
    fn next(&mut self, begun: u32) -> Option<u32> {
        let is_new = begun > self.begun;
        if is_new {
            *self = Self { begun, farther_due: FARTHER.len(), ..*self };
        }
        is_new.then_some(begun)
    }

    /// A frame farther ahead, each once; it goes on where it stopped when another frame began, so that all have their turn also where
    /// frames begin faster than they can be foreseen.
    fn farther(&mut self) -> Option<u32> {
        self.farther_due = self.farther_due.checked_sub(1)?;
        let farther = FARTHER[self.place];
        self.place = (self.place + 1) % FARTHER.len();
        Some(self.begun.saturating_add(farther))
    }
}

/// Pages that a frame needs, as far as they are still to come.
struct Errand {
    frame: u32,
    pages: VecDeque<PagePart>,
}

/// The memory thread of a live flight.
struct Thread<'a> {
    flight: &'a Flight<'a>,
    begun: &'a AtomicU32,
    planner: &'a dyn PagePlanner,
    agenda: Agenda,
    wanted: VecDeque<PagePart>,
    /// Errands for the next frame, and for one farther ahead.
    next: Option<Errand>,
    farther: Option<Errand>,
}

impl Thread<'_> {
    /// Does the most urgent thing; `false`: there is nothing to do before something happens.
    fn work(&mut self) -> bool {
        let (pages, planner) = (self.flight.pages, self.planner);
        pages.deliver(self.flight.delivered.load(Ordering::Acquire));
        if let Some(frame) = self.agenda.next(self.begun.load(Ordering::Acquire)) {
            pages.forget_wanted(self.wanted.drain(..));
            // Before anything is evicted: what was kept for the frame before is free now.
            let needs = self.foresee(frame);
            pages.keep_for(frame, &needs);
            self.next = Some(Errand { frame, pages: needs });
        }

        let mut wanted: Vec<PagePart> = self.wanted.drain(..).collect();
        pages.take_wanted(&mut wanted);

        // Workers ask in any order: heights come next to their paint.
        wanted.sort_by_key(|part| (std::cmp::Reverse(part.page().level), part.page(), *part));
        self.wanted = wanted.into();
        let now = self.agenda.begun.saturating_sub(1);
        let is_behind = |page| planner.is_behind(now, page);
        let has_room = pages.bring_some(&mut self.wanted, Purpose::Now(now, &is_behind));
        if has_room && !self.wanted.is_empty() {
            return true;
        }

        // Those for which there is no room are asked for again if they are still needed.
        pages.forget_wanted(self.wanted.drain(..));
        if self.next.is_none()
            && self.farther.is_none()
            && let Some(frame) = self.agenda.farther()
        {
            self.farther = Some(Errand { frame, pages: self.foresee(frame) });
        }

        let (errand, need): (_, fn(_, _) -> _) = match (&mut self.next, &mut self.farther) {
            (next @ Some(_), _) => (next, Purpose::Now),
            (None, farther) => (farther, Purpose::Ahead),
        };
        let Some(Errand { frame, pages: needs }) = errand else { return false };
        let has_room = pages.bring_some(needs, need(*frame, &is_behind));
        if !has_room || needs.is_empty() {
            *errand = None;
        }

        true
    }

    fn foresee(&self, frame: u32) -> VecDeque<PagePart> {
        // Who renders a frame meets the same error.
        self.planner.needs(frame).unwrap_or_default().parts.into()
    }
}

impl ResidentPages {
    /// Runs `fly` while a thread brings in what its frames want and, as `planner` predicts, are about to need. Frames begin with what is there: at first
    /// that is the coarsest level, and what was there before. No path is known: `planner` is asked for frames beyond those that have begun.
    ///
    /// # Errors
    /// A page of the coarsest level that is damaged; no thread can be started.
    pub fn live<R>(
        &self,
        planner: &dyn PagePlanner,
        fly: impl FnOnce(&LiveFlight<'_, '_>) -> R,
    ) -> Result<R> {
        // Nobody renders yet, so nobody misses what is read here.
        self.manage();
        self.bring_coarsest()?;
        let begun = AtomicU32::new(0);

        let look = |flight: &Flight<'_>, news: &Receiver<()>| {
            self.manage();
            if self.is_whole() {
                return;
            }

            let mut thread = Thread {
                flight,
                begun: &begun,
                planner,
                agenda: Agenda::default(),
                wanted: VecDeque::new(),
                next: None,
                farther: None,
            };

            while !flight.stopped.load(Ordering::Acquire) {
                if !thread.work() && news.recv().is_err() {
                    break;
                }
            }

            self.end_wanting();
        };

        self.fly_beside(look, |flight| fly(&LiveFlight { flight, begun: &begun }))
    }

    /// Nothing is wanted any more, and what left goes.
    fn end_wanting(&self) {
        let mut wanted = Vec::new();
        self.take_wanted(&mut wanted);
        self.forget_wanted(wanted.into_iter());
        self.let_go_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_farther_ahead_come_in_turn() {
        let mut agenda = Agenda::default();
        assert_eq!((agenda.next(0), agenda.farther()), (None, None), "no frame has begun");
        assert_eq!((agenda.next(1), agenda.next(1)), (Some(1), None));
        let all: Vec<_> = std::iter::from_fn(|| agenda.farther()).collect();
        assert_eq!(all, FARTHER.map(|farther| 1 + farther));
        // Frames that begin before all is foreseen: the farthest has its turn nevertheless.
        for (begun, farther) in (2..).zip([FARTHER, FARTHER].concat()) {
            assert_eq!((agenda.next(begun), agenda.farther()), (Some(begun), Some(begun + farther)));
        }
    }
}
