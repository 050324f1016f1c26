//! Checking a database from end to end: all that opening and touching leave unchecked.
//!
//! ```text
//! file:  pages do not overlap; gaps are zero; the identity is that of header, metadata and pages
//! page:  checksum, shape, hash
//!        codes within the header's range; low ≤ mean ≤ high
//!        apron = the neighbours' samples
//!        what the finer level gives = what is stored (where the finer pages are there), and bounds hold everywhere
//! ```

use std::ops::{Range, RangeInclusive};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use super::fixed_header::FixedHeader;
use super::page::page_hash;
use super::{
    APRON, Directory, FileBytes, Grid, Header, HeightCode, HeightRange, PAGE_SIDE, PageBuffer, PageEntry,
    PageId, PageSource, PageStore, PageView, RELIEF_APRON, Relief, SpanTable, StandIn, VoxelBlock,
    sparse_page,
};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Pages that are announced ahead where they come from another machine.
const ANNOUNCED: usize = 16;

/// Something that is wrong with a database.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The page, where it is one page's.
    pub page: Option<PageId>,
    /// Byte in the file: the page's first, or the place itself.
    pub byte: u64,
    /// Description of what is wrong there.
    pub what: String,
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.page {
            Some(id) => write!(f, "{id} at byte {}: {}", self.byte, self.what),
            None => write!(f, "byte {}: {}", self.byte, self.what),
        }
    }
}

/// Report of what was checked, and what was found.
#[derive(Debug, Clone)]
pub struct VerifyReport {
    /// The file.
    pub path: PathBuf,
    /// Pages that are present.
    pub pages: u64,
    /// Pages among them that have no surface, and no bytes in the file.
    pub empty: u64,
    /// Pages that the file does not store.
    pub absent: u64,
    /// Bytes of the file.
    pub bytes: u64,
    /// Problems in the order of the directory, those of the file as a whole last; empty for a sound database.
    pub problems: Vec<Problem>,
}

impl VerifyReport {
    /// Whether nothing is wrong.
    pub fn is_sound(&self) -> bool {
        self.problems.is_empty()
    }
}

/// Checks everything, on all cores. Problems are collected, not returned as errors; the only errors are
/// an interruption, and a file that changes or cannot be read meanwhile.
pub fn verify<B: FileBytes>(store: &PageStore<B>, observer: &dyn Observer) -> Result<VerifyReport> {
    let directory = store.directory();
    let mut problems = check_pages(store, observer)?;
    problems.sort_by_key(|(index, _)| *index);
    let mut problems: Vec<Problem> = problems.into_iter().map(|(_, problem)| problem).collect();
    let of_file = check_file(store);
    store.intact()?;
    problems.extend(of_file?);
    let pages = directory.present().count() as u64;
    Ok(VerifyReport {
        path: store.path().to_owned(),
        pages,
        empty: directory.present().filter(|(_, entry)| entry.empty().is_some()).count() as u64,
        absent: directory.len() as u64 - pages,
        bytes: store.bytes().len() as u64,
        problems,
    })
}

/// Problems of all pages, with the numbers of these, in any order of pages.
fn check_pages<B: FileBytes>(store: &PageStore<B>, observer: &dyn Observer) -> Result<Vec<(usize, Problem)>> {
    let total = store.directory().len();
    let next = AtomicUsize::new(0);
    let work = || {
        let mut found = Vec::new();
        while !observer.cancelled() {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= total {
                break;
            }
            announce_missing(store, index..(index + ANNOUNCED).min(total));
            let id = store.directory().id(index);
            let byte = store.directory().get(id).map_or(0, |entry| entry.offset);
            let problem = |what| (index, Problem { page: Some(id), byte, what });
            found.extend(check_page(store, id).into_iter().map(problem));
            observer.advance(1);
        }

        found
    };

    observer.begin("verify", total as u64, "pages");
    let threads = thread::available_parallelism().map_or(1, usize::from).min(total);
    let found = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .flat_map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });

    observer.end();
    if observer.cancelled() {
        return Err(Error::Interrupted("the database was not checked to its end".into()));
    }

    Ok(found)
}

/// Announces pages that must be brought from elsewhere, so that they come together.
fn announce_missing<B: FileBytes>(store: &PageStore<B>, indices: Range<usize>) {
    let extents = indices.filter_map(|index| store.extent(store.directory().id(index)));
    extents.filter(|extent| !store.is_filled(extent.clone())).for_each(|extent| store.announce(extent));
}

/// Lists what is wrong with a page; nothing if it is absent.
fn check_page<B: FileBytes>(store: &PageStore<B>, id: PageId) -> Vec<String> {
    let view = match store.checked_page(id) {
        Ok(Some(view)) => view,
        Ok(None) => return Vec::new(),
        Err(what) => return vec![what],
    };
    let header = store.header();
    let HeightRange { low, high } = header.height_range;

    // One code of slack: the range is of heights before they were rounded to codes.
    let lowest = header.heights.encode(low).saturating_sub(1).max(1);
    let codes = lowest..=header.heights.encode(high).saturating_add(1);

    let checks = [
        check_hash(store, id),
        check_range(&view, &codes),
        check_order(&view),
        check_apron(store, id, &view),
        check_spans(store, &view),
        check_finer(store, id, &view),
    ];

    checks.into_iter().flatten().collect()
}

fn check_hash<B: FileBytes>(store: &PageStore<B>, id: PageId) -> Option<String> {
    let entry = store.directory().get(id)?;
    let hash = match entry.empty() {
        Some(attributes) => PageEntry::of_empty(*attributes).hash,
        None => page_hash(store.page_bytes(entry)?),
    };
    (hash != entry.hash).then(|| "its hash is not that of the directory".into())
}

fn check_range(view: &PageView<'_>, codes: &RangeInclusive<u16>) -> Option<String> {
    let outside = |code: &u16| *code != HeightCode::EMPTY && !codes.contains(code);
    let ends = view.spans.all().iter().flat_map(|span| [span.low, span.high]);
    let code = view.heights.iter().chain(view.low).chain(view.high).copied().chain(ends).find(outside)?;
    let (low, high) = codes.clone().into_inner();
    Some(format!("height code {code}, but the header's range is that of {low} to {high}"))
}

/// Place of voxel (x, y) in a plane with apron; the apron begins at (−1, −1), given as 0 here.
fn aproned(view: &PageView<'_>, x: u32, y: u32) -> usize {
    y as usize * (view.width + 2 * APRON) as usize + x as usize
}

/// Relief at the place of a sample with apron; `None` beyond its own apron, or if there is none.
fn relief_at(view: &PageView<'_>, x: u32, y: u32) -> Option<Relief> {
    let beyond = APRON - RELIEF_APRON;
    let (x, y) = (x.checked_sub(beyond)?, y.checked_sub(beyond)?);
    let stride = view.width + 2 * RELIEF_APRON;
    let is_there = x < stride && y < view.height + 2 * RELIEF_APRON;
    is_there.then(|| view.relief.get(y as usize * stride as usize + x as usize).copied()).flatten()
}

/// The page's voxels, row by row.
fn voxels(view: &PageView<'_>) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (width, height) = (view.width, view.height);
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

fn check_order(view: &PageView<'_>) -> Option<String> {
    let ordered = |index: usize, x: u32, y: u32| {
        let (low, high) = (view.low[index], view.high[index]);
        let mean = view.heights[aproned(view, x + APRON, y + APRON)];
        let one_empty = (low == HeightCode::EMPTY) != (high == HeightCode::EMPTY);
        !one_empty && low <= high && (mean == HeightCode::EMPTY || (low..=high).contains(&mean))
    };
    let bounded = voxels(view).enumerate().take(view.low.len());
    let (_, (x, y)) = bounded.into_iter().find(|&(index, (x, y))| !ordered(index, x, y))?;
    Some(format!("low, mean and high of voxel ({x}, {y}) contradict each other"))
}

/// The apron against the neighbours' samples, at the area's edge against the page's own; sound neighbours only.
fn check_apron<B: FileBytes>(store: &PageStore<B>, id: PageId, view: &PageView<'_>) -> Option<String> {
    let grid = &store.header().grid;
    let (nx, ny) = grid.dims(id.level);

    // Of a page without bytes nobody knows what colours its voxels had, which are never seen.
    let is_empty = store.directory().is_empty_page(id);
    let clamped = |page: u32, k: u32, limit: u32| (page * PAGE_SIDE + k).saturating_sub(APRON).min(limit - 1);
    let (columns, rows) = (view.width + 2 * APRON, view.height + 2 * APRON);
    let is_own = |k: u32, size: u32| (APRON..APRON + size).contains(&k);
    let all = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let border = all.filter(|&(x, y)| !(is_own(x, view.width) && is_own(y, view.height)));
    let mut neighbour: Option<(PageId, PageView<'_>)> = None;

    for (x, y) in border {
        let (column, row) = (clamped(id.px, x, nx), clamped(id.py, y, ny));
        let owner = PageId { level: id.level, px: column / PAGE_SIDE, py: row / PAGE_SIDE };
        if neighbour.is_none_or(|(known, _)| known != owner) {
            // Where nothing stands, bare ground is the surface.
            let found = store.checked_page(owner).ok().flatten();
            let found = found.or_else(|| store.checked_page(owner.surface()).ok().flatten());
            neighbour = found.map(|view| (owner, view));
        }

        let Some((_, other)) = &neighbour else { continue };
        let there = aproned(other, column % PAGE_SIDE + APRON, row % PAGE_SIDE + APRON);
        let here = aproned(view, x, y);
        let has_colours = !(is_empty || store.directory().is_empty_page(owner));
        let differs = view.heights[here] != other.heights[there]
            || has_colours && view.colours[here] != other.colours[there]
            || relief_at(view, x, y).is_some_and(|relief| {
                relief_at(other, column % PAGE_SIDE + APRON, row % PAGE_SIDE + APRON) != Some(relief)
            });
        if differs {
            return Some(format!(
                "its apron at ({x}, {y}) is not what voxel ({column}, {row}) of the level says"
            ));
        }
    }

    None
}

/// Spans against themselves.
fn check_spans<B: FileBytes>(store: &PageStore<B>, view: &PageView<'_>) -> Option<String> {
    let Header { grid, heights, objects, .. } = store.header();
    view.spans.check(SpanTable::rise(*heights, grid.spacing), objects)
}

/// Stand-in for absent pages while a page is checked: itself, so that only its bounds are.
struct Itself<'p>(&'p PageView<'p>);

impl StandIn for Itself<'_> {
    fn finer(&mut self, _: PageId, _: Range<u32>, _: Range<u32>) -> Result<Option<VoxelBlock>> {
        Ok(None)
    }

    fn page(&mut self, _: PageId) -> Result<PageBuffer> {
        Ok(self.0.to_buffer())
    }
}

/// The page against what the next finer level makes of it, as far as that is stored. Nothing if that cannot be told: a damaged
/// finer page is a problem of its own.
fn check_finer<B: FileBytes>(store: &PageStore<B>, id: PageId, view: &PageView<'_>) -> Option<String> {
    let header = store.header();
    let expected = sparse_page(store, &mut Itself(view), &header.grid, header.heights, id).ok()?;
    let what = differing_plane(&expected, view)?;
    Some(format!("its {what} are not what level {} gives", Grid::side_units(id.level - 1)))
}

fn differing_plane(expected: &PageBuffer, view: &PageView<'_>) -> Option<&'static str> {
    // Another writer may round a mean the other way, and may bound more widely than needed.
    let near =
        |(a, b): (&u16, &u16)| (*a == HeightCode::EMPTY) == (*b == HeightCode::EMPTY) && a.abs_diff(*b) <= 1;
    let near_relief = |(a, b): (&Relief, &Relief)| {
        let pairs = |a: &[i8], b: &[i8]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1);
        pairs(&a.correction, &b.correction) && pairs(&a.spread, &b.spread)
    };
    let same = |other: u8, one: &u8| one.abs_diff(other) <= 1;
    let same_colour = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).all(|(one, other)| same(*other, one));

    if !expected.heights.iter().zip(view.heights).all(near) {
        Some("heights")
    } else if !expected.low.iter().zip(view.low).all(|(needed, low)| low <= needed) {
        Some("lower bounds")
    } else if !expected.high.iter().zip(view.high).all(|(needed, high)| high >= needed) {
        Some("upper bounds")
    } else if !expected.colours.iter().zip(view.colours).all(same_colour) {
        Some("colours")
    } else if !expected.relief.iter().zip(view.relief).all(near_relief) {
        Some("slopes")
    } else if !voxels(view)
        .zip(&expected.attributes)
        .all(|((x, y), needed)| view.attributes_at(x, y) == *needed)
    {
        Some("attributes")
    } else {
        None
    }
}

/// Problems of the file as a whole.
fn check_file<B: FileBytes>(store: &PageStore<B>) -> Result<Vec<Problem>> {
    store.fill(0..store.bytes().len())?;
    let (path, file, directory) = (store.path(), store.bytes(), store.directory());
    let mut problems = check_gaps(file, directory, FixedHeader::pages_end_of_file(path, file)?);
    if FixedHeader::identity_of_file(path, file, directory)? != store.header().content_hash {
        let what = "the identity is not that of header, metadata and pages".into();
        problems.push(Problem { page: None, byte: super::format::header::CONTENT_HASH.offset as u64, what });
    }
    Ok(problems)
}

fn check_gaps(file: &[u8], directory: &Directory, pages_end: u64) -> Vec<Problem> {
    let mut extents: Vec<_> = directory
        .present()
        .filter(|(_, entry)| entry.empty().is_none())
        .map(|(id, entry)| (entry.offset, entry.offset + u64::from(entry.length), Some(id)))
        .collect();
    extents.sort_unstable();
    extents.push((pages_end, pages_end, None));
    let mut problems = Vec::new();
    let mut end = super::format::header::SIZE as u64;

    for (start, next_end, page) in extents {
        if start < end {
            problems.push(Problem {
                page,
                byte: start,
                what: "overlaps the page before it in the file".into(),
            });
        } else if let Some(stray) = file[end as usize..start as usize].iter().position(|&byte| byte != 0) {
            let byte = end + stray as u64;
            problems.push(Problem { page: None, byte, what: "a gap between pages that is not zero".into() });
        }
        end = end.max(next_end);
    }

    problems
}
