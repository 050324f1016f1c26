//! The tasks of a stage, shared out.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use crossbeam::utils::CachePadded;

/// Tasks, and who is to do them.
pub struct Queue<T> {
    /// A lock that never waits: only the worker that drew an index opens its slot.
    slots: Vec<Mutex<Option<T>>>,
    shares: Vec<Share>,
}

impl<T> Queue<T> {
    /// Deals tasks out, a share for each of `workers`.
    pub fn new(tasks: Vec<T>, workers: usize) -> Self {
        let (count, workers) = (tasks.len(), workers.max(1));
        let share = |worker| Share::of(worker * count / workers..(worker + 1) * count / workers);
        Self {
            slots: tasks.into_iter().map(|task| Mutex::new(Some(task))).collect(),
            shares: (0..workers).map(share).collect(),
        }
    }

    /// A task for a worker whose share is the one with the index `own`.
    pub fn take(&self, own: usize) -> Option<(usize, T)> {
        let others = || (1..self.shares.len()).map(|step| &self.shares[(own + step) % self.shares.len()]);
        let index = self.shares.get(own)?.first().or_else(|| others().find_map(Share::last))?;
        let task = self.slots.get(index)?.lock().unwrap_or_else(PoisonError::into_inner).take()?;
        Some((index, task))
    }
}

/// Neighbouring tasks that nobody has taken yet: the first of them in the lower half, one beyond the last in the upper.
struct Share(CachePadded<AtomicU64>);

impl Share {
    fn of(Range { start, end }: Range<usize>) -> Self {
        Self(CachePadded::new(AtomicU64::new(end as u64 * HALF + start as u64)))
    }

    fn first(&self) -> Option<usize> {
        self.shrink(|Range { start, end }| (start, start + 1..end))
    }

    fn last(&self) -> Option<usize> {
        self.shrink(|Range { start, end }| (end - 1, start..end - 1))
    }

    /// Takes one away, if there is any.
    fn shrink(&self, take: impl Fn(Range<u64>) -> (u64, Range<u64>)) -> Option<usize> {
        let part = |both: u64| both % HALF..both / HALF;
        let rest = |both| {
            let (_, rest) = Some(part(both)).filter(|left| !left.is_empty()).map(&take)?;
            Some(rest.end * HALF + rest.start)
        };
        let before = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, rest).ok()?;
        Some(take(part(before)).0 as usize)
    }
}

/// 2³²: tasks of a stage are fewer.
const HALF: u64 = 1 << 32;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_worker_does_its_share_in_order_and_helps_from_the_far_end() {
        for (count, workers) in [(10, 3), (2, 5), (1, 1), (0, 4)] {
            let queue = Queue::new((0..count).collect(), workers);
            // The second worker never takes a task.
            let taken: Vec<usize> = std::iter::from_fn(|| queue.take(0)).map(|(_, task)| task).collect();
            let ends: Vec<usize> = (0..=workers).map(|worker| worker * count / workers).collect();
            let first = 0..ends[1];
            let others = ends[1..].windows(2).flat_map(|share| (share[0]..share[1]).rev());
            assert_eq!(taken, first.chain(others).collect::<Vec<_>>());
            assert!(queue.take(1).is_none());
        }
    }
}
