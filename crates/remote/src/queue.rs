//! Order in which blocks are fetched, and in which pieces.
//!
//! ```text
//! announced, sorted:   ▓▓▓▓░░▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓░░░░░░░░░░░▓▓▓▓▓
//! requests:            └──────────┘└──────────┘             └───┘     at most MOST each; a small gap is fetched, too
//! ```
//! Somebody waits for what is urgent: it comes first. Gaps are fetched as long as they are few: a server is asked less often then, and bytes are not
//! wasted.

use std::collections::VecDeque;
use std::ops::Range;

use super::blocks::BlockSet;

/// Blocks that are fetched by one request at most: 1 MiB.
const MOST: u64 = 256;
/// Blocks of the widest gap that is fetched with its neighbours: 64 KiB.
const WIDEST_GAP: u64 = 16;
/// Blocks that were wanted for each one of a gap.
const WANTED_PER_GAP: u64 = 25;

/// Blocks that are to be fetched, and those that are being fetched.
#[derive(Debug)]
pub(crate) struct FetchQueue {
    urgent: VecDeque<Range<u64>>,
    ahead: VecDeque<Range<u64>>,
    /// Blocks of `ahead`.
    announced: BlockSet,
    /// Blocks of requests that are on their way.
    flying: BlockSet,
    /// Blocks that were taken so far because somebody wants them, and those of gaps.
    wanted: u64,
    gaps: u64,
}

impl FetchQueue {
    /// Makes an empty queue for a file of `length` bytes.
    pub fn new(length: u64) -> Self {
        Self {
            urgent: VecDeque::new(),
            ahead: VecDeque::new(),
            announced: BlockSet::empty(length),
            flying: BlockSet::empty(length),
            wanted: 0,
            gaps: 0,
        }
    }

    /// Adds blocks that somebody waits for.
    pub fn push_urgent(&mut self, blocks: Range<u64>) {
        self.urgent.push_back(blocks);
    }

    /// Adds blocks that somebody will read.
    pub fn push_ahead(&mut self, blocks: Range<u64>) {
        if !self.announced.has_all(blocks.clone()) {
            self.announced.insert(blocks.clone());
            self.ahead.push_back(blocks);
        }
    }

    /// Takes the next run of blocks to be fetched in one request; `None`: there is none. `is_here` tells blocks that nobody need fetch.
    pub fn take(&mut self, is_here: impl Fn(u64) -> bool) -> Option<Range<u64>> {
        let mut urgent = std::mem::take(&mut self.urgent);
        let run = self.take_from(&mut urgent, &is_here);
        self.urgent = urgent;
        run.or_else(|| {
            let mut ahead = std::mem::take(&mut self.ahead);
            let run = self.take_from(&mut ahead, &is_here);
            self.ahead = ahead;
            run
        })
    }

    fn take_from(
        &mut self,
        queue: &mut VecDeque<Range<u64>>,
        is_here: &impl Fn(u64) -> bool,
    ) -> Option<Range<u64>> {
        let mut run: Option<Range<u64>> = None;
        while let Some(next) = queue.pop_front() {
            let is_free = |block: u64| !self.flying.has(block) && !is_here(block);
            let Some(start) = next.clone().find(|block| is_free(*block)) else {
                self.announced.remove(next);
                continue;
            };

            let most = run.as_ref().map_or(start + MOST, |run| run.start + MOST);
            let end = next.end.min(most);
            let end = (start..end).find(|block| !is_free(*block)).unwrap_or(end);
            let follows = run.as_ref().is_none_or(|run| {
                let gap = start.saturating_sub(run.end);
                let affordable = (self.gaps + gap) * WANTED_PER_GAP <= self.wanted;
                let is_cheap = gap == 0 || gap <= WIDEST_GAP && affordable && (run.end..start).all(is_free);
                start >= run.end && end > start && is_cheap
            });
            if !follows {
                queue.push_front(next);
                break;
            }

            let from = run.as_ref().map_or(start, |run| run.end);
            self.wanted += end - start;
            self.gaps += start - from;
            self.flying.insert(from..end);
            self.announced.remove(next.start..end);
            if end < next.end {
                queue.push_front(end..next.end);
            }
            run = Some(run.map_or(start, |run| run.start)..end);
        }
        run
    }

    /// Notes that a run that was taken is there, or will not come.
    pub fn end(&mut self, run: Range<u64>) {
        self.flying.remove(run);
    }
}

#[cfg(test)]
mod tests {
    use super::super::blocks::BLOCK;
    use super::*;

    fn queue() -> FetchQueue {
        FetchQueue::new(100_000 * BLOCK)
    }

    fn all(queue: &mut FetchQueue) -> Vec<Range<u64>> {
        std::iter::from_fn(|| queue.take(|_| false)).collect()
    }

    #[test]
    fn neighbours_come_together_and_long_ones_in_pieces() {
        let mut queue = queue();
        for range in [0..100, 100..140, 200..900] {
            queue.push_ahead(range);
        }
        assert_eq!(all(&mut queue), [0..140, 200..456, 456..712, 712..900]);
    }

    #[test]
    fn small_gaps_are_fetched_as_long_as_they_are_few() {
        let mut queue = queue();
        for range in [0..100, 104..150, 153..160, 161..170, 200..210] {
            queue.push_ahead(range);
        }
        // Four blocks for a hundred, but not three more for 146; one more for 153, and none that is wide.
        assert_eq!(all(&mut queue), [0..150, 153..170, 200..210]);
    }

    #[test]
    fn what_is_urgent_comes_first_and_once() {
        let mut queue = queue();
        queue.push_ahead(0..300);
        queue.push_ahead(10..200);
        queue.push_urgent(290..310);
        assert_eq!(all(&mut queue), [290..310, 0..256, 256..290]);
        queue.push_urgent(5..6);
        assert_eq!(queue.take(|_| false), None, "it is on its way");
        queue.end(0..256);
        queue.push_urgent(5..7);
        assert_eq!(queue.take(|block| block == 5), Some(6..7));
    }

    #[test]
    fn blocks_that_are_here_are_not_fetched_and_can_be_announced_again() {
        let mut queue = queue();
        queue.push_ahead(0..10);
        assert_eq!(queue.take(|block| block != 3 && block != 7), Some(3..4));
        assert_eq!(queue.take(|block| block != 3 && block != 7), Some(7..8));
        assert_eq!(queue.take(|block| block != 3 && block != 7), None);
        queue.end(3..8);
        queue.push_ahead(0..10);
        assert_eq!(queue.take(|_| false), Some(0..10));
    }
}
