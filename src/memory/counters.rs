//! Counts of what paging costs.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Counts since a database was opened, or between two moments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Paging {
    /// Times that a worker touched a part of a page that was not in memory.
    pub demand_misses: u64,
    /// Times that a worker waited for a page that was on its way: of a frame that began before its pages were there, since no other was
    /// in flight.
    #[serde(default)]
    pub demand_waits: u64,
    /// Time that workers waited for such pages, added up, nanoseconds.
    pub demand_wait_ns: u64,
    /// Time that frames waited for their pages before they began, nanoseconds.
    pub frame_wait_ns: u64,
    /// Parts of pages (heights, paint, bounds) brought into memory, ahead of need or on demand.
    pub pages_read: u64,
    /// Bytes that were read of these.
    pub bytes_read: u64,
    /// Parts brought in that went again, or are there still, without having been touched.
    pub pages_unused: u64,
    /// Bytes that were read for these.
    #[serde(default)]
    pub bytes_unused: u64,
    /// Parts that went to make room.
    pub pages_evicted: u64,
    /// Parts that were brought in once a frame had them in sight: it went on elsewhere, and waited for them in the end.
    #[serde(default)]
    pub pages_in_sight: u64,
    /// Parts that frames which do not wait asked for, and that were not in memory when they began; each frame counts them anew.
    #[serde(default)]
    pub pages_late: u64,
    /// Bytes of pages in memory.
    pub resident_bytes: u64,
    /// The most there ever were.
    pub resident_bytes_most: u64,
}

impl Paging {
    /// Subtracts what was counted by `before`; bytes in memory are those of now.
    pub fn since(&self, before: &Self) -> Self {
        Self {
            demand_misses: self.demand_misses - before.demand_misses,
            demand_waits: self.demand_waits - before.demand_waits,
            demand_wait_ns: self.demand_wait_ns - before.demand_wait_ns,
            frame_wait_ns: self.frame_wait_ns - before.frame_wait_ns,
            pages_read: self.pages_read - before.pages_read,
            bytes_read: self.bytes_read - before.bytes_read,
            pages_unused: self.pages_unused.saturating_sub(before.pages_unused),
            bytes_unused: self.bytes_unused.saturating_sub(before.bytes_unused),
            pages_evicted: self.pages_evicted - before.pages_evicted,
            pages_in_sight: self.pages_in_sight - before.pages_in_sight,
            pages_late: self.pages_late - before.pages_late,
            resident_bytes: self.resident_bytes,
            resident_bytes_most: self.resident_bytes_most,
        }
    }
}

/// Counters that any thread may raise.
#[derive(Debug, Default)]
pub(super) struct PagingCounters {
    pub demand_misses: AtomicU64,
    pub demand_waits: AtomicU64,
    pub demand_wait_ns: AtomicU64,
    pub frame_wait_ns: AtomicU64,
    pub pages_read: AtomicU64,
    pub bytes_read: AtomicU64,
    pub pages_touched: AtomicU64,
    /// Bytes that were read for what was touched.
    pub bytes_touched: AtomicU64,
    pub pages_evicted: AtomicU64,
    pub pages_in_sight: AtomicU64,
    pub pages_late: AtomicU64,
}

impl PagingCounters {
    pub fn add(counter: &AtomicU64, count: u64) {
        counter.fetch_add(count, Ordering::Relaxed);
    }

    pub fn add_time(counter: &AtomicU64, time: Duration) {
        Self::add(counter, u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
    }

    /// Everything so far; what lies in memory is for the caller to say.
    pub fn read(&self) -> Paging {
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Paging {
            demand_misses: of(&self.demand_misses),
            demand_waits: of(&self.demand_waits),
            demand_wait_ns: of(&self.demand_wait_ns),
            frame_wait_ns: of(&self.frame_wait_ns),
            pages_read: of(&self.pages_read),
            bytes_read: of(&self.bytes_read),
            pages_unused: of(&self.pages_read).saturating_sub(of(&self.pages_touched)),
            bytes_unused: of(&self.bytes_read).saturating_sub(of(&self.bytes_touched)),
            pages_evicted: of(&self.pages_evicted),
            pages_in_sight: of(&self.pages_in_sight),
            pages_late: of(&self.pages_late),
            ..Paging::default()
        }
    }
}
