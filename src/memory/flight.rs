//! The memory thread: what the frames of a flight need, brought in ahead of them.
//!
//! ```text
//! for each frame, up to 30 ahead of the last one delivered:
//!     what does it need?                                  told by the caller, from the pose
//!     evict what no frame in flight or ahead needs; announce what is missing; wait until it is there
//!     the frame may begin; before its pages are there if no other is in flight: its workers then wait for each as they come to it
//! pages come from another machine:  those of frames ahead are announced before the first one is waited for
//! memory is limited:  paint, which is most of it, is left out; who renders has it brought once it is in sight
//! no room, or far enough ahead:  wait until a frame is delivered
//! ```
//!
//! After the memory management computer of Nack et al., US 5,317,689 (1994): pages for later frames are computed and brought
//! in while the present one is rendered, thirty frames ahead. A frame waits before it begins, so that no worker ever
//! stands still with half a picture; how long is counted.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::counters::PagingCounters;
use super::resident::PaintInSight;
use super::sync::{self, AtomicBool, AtomicU32, Condvar, Mutex, MutexGuard, Receiver, Sender, bounded};
use super::{Paging, ResidentPages};
use crate::voxel::{PageId, PageNeeds};
use hedgehop_base::error::{Error, Result};

/// Frames that are looked ahead.
pub const LOOKAHEAD: u32 = 30;

/// Pages that a flight's frames need.
pub trait PagePlanner: Sync {
    /// Parts of pages that a frame may touch. Bounds of coarse pages may be read for it.
    ///
    /// # Errors
    /// A page that is damaged.
    fn needs(&self, frame: u32) -> Result<PageNeeds>;

    /// Whether a page lies behind the eye at a frame.
    fn is_behind(&self, frame: u32, page: PageId) -> bool;

    /// Whether frames have paint [brought](crate::voxel::PageSource::bring) where it is in sight and not at hand: it is left out of what comes
    /// ahead of need where memory is limited.
    fn brings_paint(&self) -> bool {
        false
    }
}

/// A flight on its way, as those see it who render.
#[derive(Debug)]
pub struct Flight<'p> {
    pub(super) pages: &'p ResidentPages,
    ready: Mutex<Ready>,
    changed: Condvar,
    /// Frames below this number have been delivered.
    pub(super) delivered: AtomicU32,
    pub(super) stopped: AtomicBool,
    /// One of these changed; full if the memory thread has not looked since.
    pub(super) news: Sender<()>,
    /// Paging of each frame, in the order of delivery, counted since the one before.
    frames: Mutex<(Paging, Vec<Paging>)>,
}

#[derive(Debug, Default)]
struct Ready {
    /// Frames below this number may begin.
    frames: u32,
    /// Nobody looks ahead any more.
    ended: bool,
}

impl Flight<'_> {
    fn ready(&self) -> MutexGuard<'_, Ready> {
        self.ready.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until a frame's pages are in memory, as far as there is room.
    pub fn begin(&self, frame: u32) {
        let begun = Instant::now();
        let mut ready = self.ready();
        while ready.frames <= frame && !ready.ended {
            ready = self.changed.wait(ready).unwrap_or_else(PoisonError::into_inner);
        }
        drop(ready);
        self.pages.begin(frame);
        PagingCounters::add_time(&self.pages.tally().frame_wait_ns, begun.elapsed());
    }

    /// A frame has been delivered, and all before it: what only they needed may go.
    pub fn deliver(&self, frame: u32) {
        let now = self.pages.paging();
        {
            let mut frames = self.frames.lock().unwrap_or_else(PoisonError::into_inner);
            let since = now.since(&frames.0);
            *frames = (now, std::mem::take(&mut frames.1));
            frames.1.push(since);
        }
        self.delivered.store(frame + 1, Ordering::Release);
        self.tell();
    }

    pub(super) fn tell(&self) {
        // Full: it will look anyway.
        let _ = self.news.try_send(());
    }

    /// Lists the paging of each frame, in the order of delivery, counted since the one before it was delivered.
    pub fn frames(&self) -> Vec<Paging> {
        self.frames.lock().unwrap_or_else(PoisonError::into_inner).1.clone()
    }

    /// Frames below number `frames` may begin.
    fn let_begin(&self, frames: u32) {
        self.ready().frames = frames;
        self.changed.notify_all();
    }

    fn look_ahead(&self, count: u32, planner: &dyn PagePlanner, news: &Receiver<()>) {
        let _end = FlightEnd(self);
        if self.pages.is_whole() {
            return;
        }

        self.pages.manage();
        let mut next = 0;
        let mut needs = None;
        let mut ahead = VecDeque::new();
        let mut in_sight = PaintInSight::new();
        let leaves_paint = self.pages.budget() < u64::MAX && planner.brings_paint();

        while next < count && !self.stopped.load(Ordering::Acquire) {
            let done = self.delivered.load(Ordering::Acquire);
            self.pages.deliver(done);
            in_sight.retain(|(frame, _)| *frame >= done);
            if next < done + LOOKAHEAD {
                let foreseen = needs.get_or_insert_with(|| {
                    self.foresee(next..count.min(done + LOOKAHEAD), planner, leaves_paint, &mut ahead);
                    let mut needs = ahead.pop_front().unwrap_or_default();
                    if leaves_paint {
                        in_sight.push((next, needs.take_paint()));
                    }
                    needs
                });
                let is_behind = |page| planner.is_behind(done, page);
                if let Some(expected) =
                    self.pages.expect(next, foreseen, leaves_paint.then_some(&in_sight), is_behind)
                {
                    needs = None;
                    if next == done {
                        // Nothing else is in flight: it may begin with what comes first.
                        self.let_begin(next + 1);
                    }
                    self.pages.read(&expected);
                    next += 1;
                    self.let_begin(next);
                    continue;
                }
            }

            if news.recv().is_err() {
                return;
            }
        }
    }

    /// Foresees the first of `frames`, if it is not among the needs of those foreseen before; and more of them as long as the last one's pages come from
    /// another machine: they are announced, so that many are on their way at once. Nothing may be expected and unread meanwhile: who foresees reads
    /// bounds, and would wait for itself.
    fn foresee(
        &self,
        frames: Range<u32>,
        planner: &dyn PagePlanner,
        leaves_paint: bool,
        ahead: &mut VecDeque<PageNeeds>,
    ) {
        while ahead.back().is_none_or(|last| !self.pages.is_at_hand_for(last, leaves_paint))
            && !self.stopped.load(Ordering::Acquire)
        {
            let frame = frames.start + ahead.len() as u32;
            if frame >= frames.end {
                return;
            }
            // Who renders the frame meets the same error.
            let needs = planner.needs(frame).unwrap_or_default();
            self.pages.announce_missing(&needs, leaves_paint);
            ahead.push_back(needs);
        }
    }
}

/// Lets all frames begin once it is dropped, however that comes.
struct FlightEnd<'a, 'p>(&'a Flight<'p>);

impl Drop for FlightEnd<'_, '_> {
    fn drop(&mut self) {
        self.0.ready().ended = true;
        self.0.changed.notify_all();
    }
}

impl ResidentPages {
    /// Runs `fly` while a thread brings in what its `count` frames need. `fly` says when each of them begins and when it is
    /// delivered.
    ///
    /// # Errors
    /// No thread can be started.
    pub fn ahead_of<R>(
        &self,
        count: u32,
        planner: &dyn PagePlanner,
        fly: impl FnOnce(&Flight<'_>) -> R,
    ) -> Result<R> {
        self.fly_beside(|flight, news| flight.look_ahead(count, planner, news), fly)
    }

    /// Runs `fly` while the memory thread runs `look`, which is to end when the flight is stopped.
    pub(super) fn fly_beside<R>(
        &self,
        look: impl FnOnce(&Flight<'_>, &Receiver<()>) + Send,
        fly: impl FnOnce(&Flight<'_>) -> R,
    ) -> Result<R> {
        self.begin_flight();
        let (sender, receiver) = bounded(1);
        let flight = Flight {
            pages: self,
            ready: Mutex::default(),
            changed: Condvar::new(),
            delivered: AtomicU32::new(0),
            stopped: AtomicBool::new(false),
            news: sender,
            frames: Mutex::new((self.paging(), Vec::new())),
        };

        sync::scope(|scope| {
            let flight = &flight;
            let stop = Stop(flight);
            sync::spawn(scope, "hedgehop-memory", move || look(flight, &receiver))
                .map_err(|error| Error::Configuration(format!("cannot start the memory thread: {error}")))?;
            let result = fly(flight);
            drop(stop);
            Ok(result)
        })
    }
}

/// Has the memory thread end once it is dropped, also if a frame panics.
struct Stop<'a, 'p>(&'a Flight<'p>);

impl Drop for Stop<'_, '_> {
    fn drop(&mut self) {
        self.0.stopped.store(true, Ordering::Release);
        self.0.tell();
    }
}
