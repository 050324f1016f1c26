//! Room on the disk: what a build takes of it, and whether there is as much.
//!
//! ```text
//! the file, beside the one that it replaces until it is whole
//! eight rows of pages that were made, which are set aside until their places are known
//! ```
//! Where no elevation is, pages have an entry and no bytes. How long others are shows when they are made: attributes that are all alike take next to nothing, and bare ground has pages only where
//! something stands on it. So there is a least and a most. What has not even the least is refused before a page is made; what may not
//! have the most is told in a note, and ends with the disk's error if it comes to that. Where pages of builds before are known, nothing is
//! refused: most builds change a few of them in place. Points of clouds, which lie in a file of their own, do not count.

use std::path::Path;

use super::plan::Plan;
use super::reach::Reach;
use hedgehop::voxel::{
    APRON, BLOCK_SIDE, Directory, Grid, PAGE_SIDE, PageEntry, PageId, Span, SpanBlock, most_page_bytes,
};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Pages begin at multiples of so many bytes, and the header takes as many.
const ALIGNMENT: u64 = 4096;
/// Bytes of a sample's height and colour, and of a voxel's bounds and relief on coarser levels.
const SAMPLE: u64 = 5;
const COARSE: u64 = 9;
/// Rows of pages that are set aside at a time.
const BAND: u32 = 8;

/// Files that a build writes, and where.
#[derive(Clone, Copy)]
pub(super) struct DiskSpace<'a> {
    pub plan: &'a Plan,
    pub output: &'a Path,
    /// Whether something may stand on the ground.
    pub builds: bool,
    /// Pages that have more than an entry.
    pub reach: &'a Reach,
}

/// Pages that are made, at the least.
#[derive(Debug, Clone, Copy, Default)]
struct MadeFile {
    /// Bytes of all, with the gaps between them.
    placed: u64,
    /// Bytes of those that are set aside at once.
    aside: u64,
}

impl DiskSpace<'_> {
    /// Bytes of the file at most, without objects and metadata. What stands on the ground has no most: a span on each voxel counts.
    pub fn most_bytes(&self) -> u64 {
        self.most_bytes_of(&self.counts())
    }

    fn most_bytes_of(&self, counts: &[u64]) -> u64 {
        let bare = if self.builds { self.plan.stored.count(0) } else { 0 };
        most_bytes(&self.plan.grid, |level| counts[usize::from(level)], bare)
    }

    /// Pages of each level that may have bytes. Of a grid that is far too fine they are many, and counting takes its time.
    fn counts(&self) -> Vec<u64> {
        (0..self.plan.grid.level_count()).map(|level| self.count(level)).collect()
    }

    /// Pages of a level that may have bytes.
    fn count(&self, level: u8) -> u64 {
        let Plan { grid, stored, .. } = self.plan;
        if self.reach.is_everywhere() {
            return stored.count(level);
        }
        let tasks = stored.tasks(level);
        (0..tasks.count()).filter(|task| self.reach.may_fill(grid, tasks.id(*task))).count() as u64
    }

    /// Bytes that a build takes of the disk while all is made, at least.
    pub fn least_needed(&self) -> u64 {
        let mut file = ALIGNMENT;
        let mut least = 0;
        for level in 0..self.plan.grid.level_count() {
            let made = self.made(level);
            file += made.placed;
            least = least.max(file + made.aside);
        }
        least
    }

    /// Bytes that it takes meanwhile, at most.
    pub fn most_needed(&self) -> u64 {
        let grid = &self.plan.grid;
        let (columns, _) = grid.page_dims(0);
        let bare = if self.builds { most_bare_bytes(grid) } else { 0 };
        let counts = self.counts();
        let aside = counts[0].min(u64::from(columns) * u64::from(BAND));
        self.most_bytes_of(&counts) + aside * (most_page_bytes(grid, 0) + bare)
    }

    /// Refuses a build for which there is no room, before any page is made.
    pub fn check(&self, observer: &dyn Observer) -> Result<()> {
        let Some(free) = free_bytes(self.output) else { return Ok(()) };
        let most = self.most_needed();
        if most <= free {
            return Ok(());
        }

        let least = self.least_needed();
        if least <= free {
            self.note_most(most, free, observer);
            return Ok(());
        }

        let Plan { grid, stored, .. } = self.plan;
        Err(Error::Configuration(format!(
            "{}: {} x {} voxels of {} m{} take at least {} MB while they are written, and up to {} MB, but only {} MB are free there; \
             free some, or choose a larger --spacing or a smaller --bbox",
            self.output.display(),
            grid.nx,
            grid.ny,
            grid.spacing,
            if stored.is_all() { "" } else { " in corridors" },
            megabytes(least),
            megabytes(most),
            free / MEGABYTE
        )))
    }

    fn note_most(&self, most: u64, free: u64, observer: &dyn Observer) {
        observer.note(&format!(
            "{}: takes up to {} MB while it is written, and {} MB are free there",
            self.output.display(),
            megabytes(most),
            free / MEGABYTE
        ));
    }

    /// The pages of a level.
    fn made(&self, level: u8) -> MadeFile {
        let tasks = self.plan.stored.tasks(level);
        let (mut made, mut band, mut aside) = (MadeFile::default(), 0, 0);
        for id in (0..tasks.count()).map(|task| tasks.id(task)) {
            if id.py / BAND != band {
                (band, aside) = (id.py / BAND, 0);
            }
            let grid = &self.plan.grid;
            let bytes = if self.reach.has_elevation(grid, id) { least_page_bytes(grid, id) } else { 0 };
            made.placed += bytes.next_multiple_of(ALIGNMENT);
            aside += bytes;
            made.aside = made.aside.max(aside);
        }
        made
    }
}

/// Bytes of a file at most that has so many pages of each level and of bare ground, without objects and metadata.
pub(super) fn most_bytes(grid: &Grid, pages: impl Fn(u8) -> u64, bare: u64) -> u64 {
    let surface: u64 = (0..grid.level_count()).map(|level| pages(level) * most_page_bytes(grid, level)).sum();
    // All pages of the grid have an entry.
    let (columns, rows) = grid.page_dims(0);
    let entries =
        Directory::page_count(grid).unwrap_or(0) + bare.min(1) * u64::from(columns) * u64::from(rows);
    ALIGNMENT + surface + bare * most_bare_bytes(grid) + entries * size_of::<PageEntry>() as u64
}

/// Bytes of a page of bare ground at most, with a span on each voxel.
fn most_bare_bytes(grid: &Grid) -> u64 {
    let side = u64::from(PAGE_SIDE);
    let (voxels, blocks) = (side * side, (side / u64::from(BLOCK_SIDE)).pow(2));
    // Counts, and one number more than there are voxels.
    let spans =
        16 + blocks * size_of::<SpanBlock>() as u64 + 4 * (voxels + 1) + voxels * size_of::<Span>() as u64;
    most_page_bytes(grid, 0) + spans.next_multiple_of(ALIGNMENT)
}

/// Bytes of a page with a surface at least: all of its voxels have the same attributes.
pub(super) fn least_page_bytes(grid: &Grid, id: PageId) -> u64 {
    let Size { width, height } = grid.page_size(id).unwrap_or_default();
    let samples = u64::from(width + 2 * APRON) * u64::from(height + 2 * APRON);
    let coarse = if id.level > 0 { COARSE * u64::from(width) * u64::from(height) } else { 0 };
    SAMPLE * samples + coarse
}

/// Refuses a file of so many bytes for which there is no room.
pub(super) fn check_bytes(output: &Path, bytes: u64) -> Result<()> {
    match free_bytes(output) {
        Some(free) if free < bytes => Err(Error::Configuration(format!(
            "{}: takes {} MB, but only {} MB are free there; free some, or write it elsewhere",
            output.display(),
            megabytes(bytes),
            free / MEGABYTE
        ))),
        _ => Ok(()),
    }
}

/// Bytes that a page of so many takes in a file.
pub(super) fn placed(length: u32) -> u64 {
    u64::from(length).next_multiple_of(ALIGNMENT)
}

const MEGABYTE: u64 = 1_000_000;

fn megabytes(bytes: u64) -> u64 {
    bytes.div_ceil(MEGABYTE)
}

#[cfg(test)]
thread_local! {
    /// What tests say is free.
    pub(super) static FREE: std::cell::Cell<Option<u64>> = const { std::cell::Cell::new(None) };
}

/// Free bytes where `output` will be; `None` if the system does not say.
fn free_bytes(output: &Path) -> Option<u64> {
    #[cfg(test)]
    if let Some(free) = FREE.get() {
        return Some(free);
    }
    free_of_system(output)
}

#[cfg(unix)]
fn free_of_system(output: &Path) -> Option<u64> {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let state = rustix::fs::statvfs(folder).ok()?;
    Some(state.f_bavail.saturating_mul(state.f_frsize))
}

#[cfg(not(unix))]
fn free_of_system(_output: &Path) -> Option<u64> {
    None
}
