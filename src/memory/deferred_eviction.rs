//! Pages that were evicted while frames may still read them.
//!
//! ```text
//! a frame begins:   number n; it may read what is in memory now
//! a page leaves:    frames that begin from now on do not have it; those that hold a lower number may
//! it may go:        when the last of these has ended
//! ```
//!
//! Without it a worker of a frame that never waits would find a page gone, and read the file.

use std::collections::{BTreeSet, VecDeque};

/// Frames that hold what was in memory when they began, and pages that wait for their end.
#[derive(Debug, Default)]
pub(super) struct DeferredEviction {
    next: u64,
    held: BTreeSet<u64>,
    /// Pages, and the number of the first frame that never had them; rising.
    pages: VecDeque<(u64, u32)>,
}

impl DeferredEviction {
    /// A frame begins; the number that it holds.
    pub fn begin(&mut self) -> u64 {
        self.next += 1;
        self.held.insert(self.next);
        self.next
    }

    /// The frame that holds a number has ended.
    pub fn end(&mut self, number: u64) {
        self.held.remove(&number);
    }

    /// A page leaves.
    pub fn leave(&mut self, page: u32) {
        self.pages.push_back((self.next + 1, page));
    }

    /// A page comes back; whether it had left and had not gone yet.
    pub fn come_back(&mut self, page: u32) -> bool {
        let place = self.pages.iter().position(|(_, other)| *other == page);
        place.and_then(|place| self.pages.remove(place)).is_some()
    }

    /// Takes out a page that no frame may read any more.
    pub fn gone(&mut self) -> Option<u32> {
        let oldest = self.held.first().copied().unwrap_or(u64::MAX);
        let (first_without, _) = self.pages.front()?;
        if oldest < *first_without { None } else { self.pages.pop_front().map(|(_, page)| page) }
    }

    /// Pages that wait.
    pub fn waiting(&self) -> impl Iterator<Item = u32> {
        self.pages.iter().map(|(_, page)| *page)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all_gone(deferred: &mut DeferredEviction) -> Vec<u32> {
        std::iter::from_fn(|| deferred.gone()).collect()
    }

    #[test]
    fn pages_go_when_the_last_frame_that_had_them_has_ended() {
        let mut deferred = DeferredEviction::default();
        deferred.leave(1);
        assert_eq!(all_gone(&mut deferred), [1], "nobody reads it");
        let first = deferred.begin();
        deferred.leave(2);
        let second = deferred.begin();
        deferred.leave(3);
        assert!(all_gone(&mut deferred).is_empty());
        // The second never had page 2, but page 3.
        deferred.end(first);
        assert_eq!(all_gone(&mut deferred), [2]);
        let third = deferred.begin();
        deferred.end(second);
        assert_eq!(deferred.waiting().collect::<Vec<_>>(), [3]);
        assert_eq!(all_gone(&mut deferred), [3]);
        deferred.leave(4);
        deferred.end(third);
        assert_eq!(all_gone(&mut deferred), [4]);
    }

    #[test]
    fn pages_that_come_back_wait_no_more() {
        let mut deferred = DeferredEviction::default();
        let frame = deferred.begin();
        (1..=3).for_each(|page| deferred.leave(page));
        assert!(deferred.come_back(2) && !deferred.come_back(2) && !deferred.come_back(4));
        deferred.end(frame);
        assert_eq!(all_gone(&mut deferred), [1, 3]);
    }

    #[test]
    fn frames_may_end_in_any_order() {
        let mut deferred = DeferredEviction::default();
        let [first, second] = [deferred.begin(), deferred.begin()];
        deferred.leave(1);
        deferred.end(second);
        assert!(all_gone(&mut deferred).is_empty());
        deferred.end(first);
        assert_eq!(all_gone(&mut deferred), [1]);
    }
}
