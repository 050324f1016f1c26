//! Shares of the bytes that a build may hold; the only place that decides it.

use super::options::BuildOptions;
use super::workers::AHEAD;
use hedgehop::voxel::{APRON, PAGE_SIDE};
use hedgehop_base::error::{Error, Result};

const MIB: u64 = 1 << 20;
/// The program, thread stacks, a directory of some pages.
const FIXED: u64 = 24 * MIB;
/// One part of so many of the memory is for the directory of an area with corridors, most of whose pages are absent.
const DIRECTORY_SHARE: u64 = 8;
/// Bytes of a page's entry in memory, and of the same as it is written.
const ENTRY: u64 = 64;
/// Bytes that the process holds for one of a cached block: blocks come and go among short-lived
/// buffers, and the allocator keeps much of what was freed between them (measured 1.4).
const KEPT: u64 = 2;
/// A page's planes while it is made: positions, sums, heights with the fill's margin, colours, bytes.
const PAGE_WORK: u64 = 10 * MIB;
/// The same where some finer pages are absent: the finer voxels under a page as well, with their slopes.
const SPARSE_PAGE_WORK: u64 = 44 * MIB;
/// An encoded page: heights, colours, attributes, bounds and slopes of every voxel.
const PAGE_BYTES: u64 = (PAGE_SIDE as u64 + 2 * APRON as u64).pow(2) * 18;
/// Most bytes of new pages that wait to be written into a database in place, and which part of the memory they may be.
const MOST_CHANGES: u64 = 64 * MIB;
const CHANGES_SHARE: u64 = 8;
/// Least worth having for one window, and for all decoded blocks together.
const LEAST_WINDOW: u64 = MIB / 4;
const LEAST_CACHE: u64 = 16 * MIB;

/// Shares of the memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Budget {
    /// Decoded blocks of all rasters, bytes.
    pub cache: u64,
    /// Largest window of samples that a worker holds, bytes.
    pub window: usize,
    /// Workers that fit.
    pub threads: usize,
    /// New pages that wait to be written into a database in place, bytes.
    pub changes: u64,
    /// Bytes of all of it.
    memory: u64,
}

impl Budget {
    /// Splits what a build may hold.
    pub fn of(options: &BuildOptions) -> Result<Self> {
        let BuildOptions { memory, threads, .. } = *options;
        let budget = if options.corridors.is_empty() {
            Self::split(memory, threads, PAGE_WORK)?
        } else {
            let spared = memory - memory / DIRECTORY_SHARE;
            Self { memory, ..Self::split(spared, threads, SPARSE_PAGE_WORK)? }
        };
        Ok(if options.steps { budget.with_changes() } else { budget })
    }

    /// Takes what changes may be from the cache, as far as that can do without.
    fn with_changes(self) -> Self {
        let spare = self.cache.saturating_sub(LEAST_CACHE);
        let taken = (MOST_CHANGES.min(self.memory / CHANGES_SHARE) / KEPT).min(spare);
        Self { cache: self.cache - taken, changes: taken * KEPT, ..self }
    }

    /// Refuses a directory of so many pages, most of them absent, that it does not fit.
    pub fn check_directory(&self, pages: u64) -> Result<()> {
        let least = pages * ENTRY * DIRECTORY_SHARE;
        if least <= self.memory {
            return Ok(());
        }
        Err(Error::Configuration(format!(
            "--memory of {} MiB is too little for the directory of {pages} pages, which takes a part of {DIRECTORY_SHARE} of it; \
             give at least {} MiB, or a larger --spacing",
            self.memory / MIB,
            least.div_ceil(MIB)
        )))
    }

    /// Splits `memory` bytes for up to `threads` workers, which hold `page_work` bytes each while they make a page.
    fn split(memory: u64, threads: usize, page_work: u64) -> Result<Self> {
        let threads = threads.max(1) as u64;
        // One window of heights and one of colours.
        let worker_with = |window: u64| 2 * window + page_work + AHEAD * PAGE_BYTES;
        let shared = memory.saturating_sub(FIXED);
        let Some(spare) = shared.checked_sub(worker_with(LEAST_WINDOW) + KEPT * LEAST_CACHE) else {
            let least = FIXED + worker_with(LEAST_WINDOW) + KEPT * LEAST_CACHE;
            return Err(Error::Configuration(format!(
                "--memory of {} MiB is too little; a build takes at least {} MiB",
                memory / MIB,
                least.div_ceil(MIB)
            )));
        };
        let window = (memory / 16 / threads).clamp(LEAST_WINDOW, 8 * MIB).min(LEAST_WINDOW + spare / 2);
        let worker = worker_with(window);
        // Workers beyond a third of what is left would only take turns to decode the same blocks.
        let threads = threads.min((shared / 3 / worker).max(1));
        let cache = (shared - threads * worker) / KEPT;
        Ok(Self { cache, window: window as usize, threads: threads as usize, changes: 0, memory })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_never_exceed_the_memory() {
        for memory in [80, 128, 512, 4096].map(|mib| mib * MIB) {
            for threads in [1, 2, 16, 256] {
                let budget = Budget::split(memory, threads, PAGE_WORK).unwrap();
                let workers =
                    budget.threads as u64 * (2 * budget.window as u64 + PAGE_WORK + AHEAD * PAGE_BYTES);
                assert!(budget.threads >= 1 && budget.threads <= threads);
                assert!(FIXED + workers + KEPT * budget.cache <= memory);
                let changing = budget.with_changes();
                assert!(KEPT * changing.cache + changing.changes <= KEPT * budget.cache);
                assert!(changing.changes <= MOST_CHANGES && changing.cache >= LEAST_CACHE);
            }
        }
    }

    #[test]
    fn too_little_is_refused_with_the_least() {
        let error = Budget::split(20 * MIB, 1, PAGE_WORK).unwrap_err().to_string();
        assert!(error.contains("--memory of 20 MiB") && error.contains("at least"), "{error}");
        let least: Option<u64> = error.split_whitespace().rev().find_map(|word| word.parse().ok());
        assert!(Budget::split(least.unwrap() * MIB, 64, PAGE_WORK).is_ok(), "{error}");
    }

    #[test]
    fn a_directory_that_does_not_fit_is_refused_with_the_least() {
        let budget = |memory: u64| Budget { memory, ..Budget::split(512 * MIB, 1, PAGE_WORK).unwrap() };
        let error = budget(512 * MIB).check_directory(2_000_000).unwrap_err().to_string();
        assert!(error.contains("at least 977 MiB"), "{error}");
        assert!(budget(977 * MIB).check_directory(2_000_000).is_ok());
    }
}
