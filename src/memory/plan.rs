//! Page plan: a flight's needs of a database, before it is flown.
//!
//! ```text
//! for each frame:  which pages does it need?             told by the planner
//!     needed for the first time:                         read, whatever the memory
//!     last needed more than 30 frames ago:               read again if no more is kept than what is known to be needed
//! pages of 30 frames ahead, together:                    what must fit into memory for a flight that never waits
//! ```

use std::collections::{HashMap, HashSet};
use std::time::{Duration, Instant};

use super::{LOOKAHEAD, PageFile, PagePlanner};
use crate::voxel::{PageId, PagePart};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Needs of one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct FrameNeeds {
    /// Pages that it may touch.
    pub pages: u64,
    /// Bytes of those parts of them that it may touch.
    pub bytes: u64,
    /// Bytes that are read for what no frame before needed: of pages of which nothing was, all.
    pub first_bytes: u64,
    /// Bytes that none of the frames looked ahead from the one before needed: what is read for it if nothing else
    /// is kept.
    pub read_bytes: u64,
    /// Bytes that it and those up to [`LOOKAHEAD`] frames later need together.
    pub ahead_bytes: u64,
}

/// The needs of a flight.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PagePlan {
    /// Needs of each frame, in order.
    pub frames: Vec<FrameNeeds>,
    /// Each part of a page that some frame needs, with the index of the first one, in the order of need.
    pub first_use: Vec<(PagePart, u32)>,
}

impl PagePlan {
    /// Plans `count` frames over a file.
    ///
    /// # Errors
    /// A page that is damaged; an interruption.
    pub fn new(
        file: &PageFile,
        count: u32,
        planner: &dyn PagePlanner,
        observer: &dyn Observer,
    ) -> Result<Self> {
        observer.begin("plan", u64::from(count), "frames");
        let mut plan = Self::default();
        let mut last_needed = HashMap::new();
        let mut known = HashSet::new();

        // Bytes that come to be needed ahead of each frame, less those that no longer are.
        let mut changes = vec![0_i64; count as usize + 1];
        for frame in 0..count {
            if observer.cancelled() {
                return Err(Error::Interrupted("the flight was not planned to its end".into()));
            }

            let mut needs = FrameNeeds::default();
            known.clear();
            for part in planner.needs(frame)?.parts {
                // What is absent or has no bytes is never read.
                if file.directory().stored_part_index(part).is_none() {
                    continue;
                }

                let bytes = file.store().part_bytes(part);
                let before = last_needed.insert(part, frame);
                needs.pages += u64::from(known.insert(part.page()));
                needs.bytes += bytes;
                if before.is_none() {
                    needs.first_bytes += bytes;
                    plan.first_use.push((part, frame));
                }

                if before.is_some_and(|before| frame - before > LOOKAHEAD) {
                    needs.read_bytes += bytes;
                }
                let known_from = frame.saturating_sub(LOOKAHEAD);
                let from = before.map_or(known_from, |before| known_from.max(before + 1));
                changes[from as usize] += bytes as i64;
                changes[frame as usize + 1] -= bytes as i64;
            }

            needs.read_bytes += needs.first_bytes;
            plan.frames.push(needs);
            observer.advance(1);
        }

        let mut ahead = 0;
        for (needs, change) in plan.frames.iter_mut().zip(changes) {
            ahead += change;
            needs.ahead_bytes = u64::try_from(ahead).unwrap_or(0);
        }

        observer.end();
        Ok(plan)
    }

    /// Each page of which something is needed, with the index of the first frame that does, in the order of need.
    pub fn pages(&self) -> Vec<(PageId, u32)> {
        let mut known = HashSet::new();
        let pages = self.first_use.iter().map(|(part, frame)| (part.page(), *frame));
        pages.filter(|(page, _)| known.insert(*page)).collect()
    }

    /// The most bytes that `frames` frames in a row read, the first frame of all not counted: it is waited for.
    pub fn read_within(&self, frames: usize) -> u64 {
        let later: Vec<_> = self.frames.iter().skip(1).map(|needs| needs.read_bytes).collect();
        let frames = frames.clamp(1, later.len().max(1));
        later.windows(frames).map(|window| window.iter().sum()).max().unwrap_or(0)
    }
}

impl PageFile {
    /// Reads pages from the disk, those of `pages` that come first for as long as `limit`; returns bytes and time. What the system keeps
    /// of them in memory is let go before, as far as nobody else uses it.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn time_reading(&self, pages: &[PageId], limit: Duration) -> Result<(u64, Duration)> {
        /// Pages that are asked for together, as for a frame.
        const TOGETHER: usize = 64;
        let store = self.store();
        let extents: Vec<_> = pages.iter().filter_map(|id| store.extent(*id).map(|at| (*id, at))).collect();
        pages.iter().flat_map(|id| PagePart::all(*id)).for_each(|part| store.forget(part, |_| false));
        let begun = Instant::now();
        let mut bytes = 0;
        for together in extents.chunks(TOGETHER) {
            together.iter().for_each(|(_, extent)| store.announce(extent.clone()));
            for (id, extent) in together {
                store.load(PagePart::Heights(*id))?;
                bytes += extent.len() as u64;
            }
            if begun.elapsed() > limit {
                break;
            }
        }
        Ok((bytes, begun.elapsed()))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::voxel::{Arrays, Grid, Metadata, PageNeeds, write_arrays};
    use hedgehop_base::progress::Silent;

    /// Frames that need these columns of the finest pages.
    struct Columns(Vec<Vec<u32>>);

    impl PagePlanner for Columns {
        fn needs(&self, frame: u32) -> Result<PageNeeds> {
            let posts = |&px| PagePart::posts(PageId { level: 0, px, py: 0 });
            Ok(self.0[frame as usize].iter().flat_map(posts).collect::<Vec<_>>().into())
        }

        fn is_behind(&self, _: u32, _: PageId) -> bool {
            false
        }
    }

    #[test]
    fn what_is_needed_again_after_long_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("area.hop");
        let grid = Grid { nx: 1024, ny: 256, spacing: 1.0, origin: DVec2::ZERO };
        let posts = 1024 * 256;
        let (heights, colours) = (vec![3.0; posts], vec![[9; 3]; posts]);
        let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
        write_arrays(&path, &arrays, &Metadata::default(), false).unwrap();
        let file = PageFile::open(&path).unwrap();
        let page = file.directory().get(PageId { level: 0, px: 0, py: 0 }).unwrap().length;
        let page = u64::from(page);

        // One page that comes again too late to be kept for it, one that does in time, and one that is not there.
        let mut needs = vec![vec![]; 100];
        needs[0] = vec![0, 1, 70];
        needs[20] = vec![1];
        needs[31] = vec![0];
        needs[99] = vec![2];
        let plan = PagePlan::new(&file, 100, &Columns(needs), &Silent).unwrap();
        let at = |frame: usize| plan.frames[frame];
        assert_eq!((at(0).pages, at(0).bytes, at(0).first_bytes), (2, 2 * page, 2 * page));
        assert_eq!((at(20).first_bytes, at(20).read_bytes), (0, 0));
        assert_eq!((at(31).first_bytes, at(31).read_bytes), (0, page));
        let ahead = |frame: usize| at(frame).ahead_bytes / page;
        let known = [0, 1, 20, 21, 31, 32, 68, 69, 99].map(ahead);
        assert_eq!(known, [2, 2, 2, 1, 1, 0, 0, 1, 1]);
        let first: Vec<_> = plan.pages().iter().map(|(id, frame)| (id.px, *frame)).collect();
        assert_eq!(first, [(0, 0), (1, 0), (2, 99)]);
        assert_eq!((plan.read_within(10), plan.read_within(1000)), (page, 2 * page));
        let all: Vec<_> = plan.pages().iter().map(|(id, _)| *id).collect();
        assert_eq!(file.time_reading(&all, Duration::from_secs(60)).unwrap().0, 3 * page);
    }
}
