//! Databases with holes: nothing is read before it was filled, and flights announce before they wait.

use std::fs::{self, File, OpenOptions};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use glam::DVec2;
use tempfile::TempDir;

use super::{HoleFiller, PageFile, PagePlanner, ResidentPages};
use crate::voxel::{
    Arrays, Damaged, FileEnds, Grid, HEADER_BYTES, Metadata, PageId, PageNeeds, PagePart, PageSource, Trust,
    Verify, write_arrays,
};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Silent;

const SIDE: u32 = 1024;

/// Fills a copy's holes from the whole file.
#[derive(Debug)]
struct Pump {
    whole: Vec<u8>,
    copy: File,
    filled: Mutex<Vec<Range<u64>>>,
    announced: AtomicUsize,
    /// Announcements that are waited for before anything is filled.
    awaited: AtomicUsize,
    fails: AtomicBool,
    /// Bytes are filled wrong so many times.
    wrong: AtomicUsize,
}

#[derive(Debug)]
struct SharedPump(Arc<Pump>);

impl HoleFiller for SharedPump {
    fn announce(&self, _: Range<u64>) {
        self.0.announced.fetch_add(1, Ordering::SeqCst);
    }

    fn fill(&self, range: Range<u64>) -> bool {
        let begun = Instant::now();
        while self.0.announced.load(Ordering::SeqCst) < self.0.awaited.load(Ordering::SeqCst) {
            assert!(begun.elapsed() < Duration::from_secs(20), "nobody announces more");
            std::thread::sleep(Duration::from_millis(1));
        }
        if self.has_failed() {
            return false;
        }
        let mut bytes = self.0.whole[range.start as usize..range.end as usize].to_vec();
        if self.0.wrong.load(Ordering::SeqCst) > 0 && !bytes.is_empty() {
            self.0.wrong.fetch_sub(1, Ordering::SeqCst);
            bytes[0] ^= 1;
        }
        write_at(&self.0.copy, &bytes, range.start);
        self.0.filled.lock().unwrap().push(range);
        true
    }

    fn is_filled(&self, range: Range<u64>) -> bool {
        let filled = self.0.filled.lock().unwrap();
        filled.iter().any(|there| there.start <= range.start && there.end >= range.end)
    }

    fn refill(&self, range: Range<u64>) -> bool {
        self.fill(range)
    }

    fn has_failed(&self) -> bool {
        self.0.fails.load(Ordering::SeqCst)
    }

    fn intact(&self) -> Result<()> {
        let failure =
            || Error::io("area.hop", "go on reading it", std::io::Error::other("it is another one"));
        if self.has_failed() { Err(failure()) } else { Ok(()) }
    }
}

#[cfg(unix)]
fn write_at(file: &File, bytes: &[u8], place: u64) {
    std::os::unix::fs::FileExt::write_all_at(file, bytes, place).unwrap();
}

#[cfg(windows)]
fn write_at(file: &File, bytes: &[u8], place: u64) {
    std::os::windows::fs::FileExt::seek_write(file, bytes, place).unwrap();
}

/// A database, and the same with holes where its pages are.
struct HolesSite {
    path: PathBuf,
    pump: Arc<Pump>,
    copy: File,
    _folder: TempDir,
}

impl HolesSite {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("area.hop");
        let grid = Grid { nx: SIDE, ny: SIDE, spacing: 1.0, origin: DVec2::ZERO };
        let heights: Vec<f64> = (0..SIDE * SIDE).map(|post| 5.0 + f64::from(post % 100)).collect();
        let colours = vec![[9; 3]; heights.len()];
        let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
        write_arrays(&path, &arrays, &Metadata::default(), false).unwrap();

        let whole = fs::read(&path).unwrap();
        let name = folder.path().join("copy");
        let copy = OpenOptions::new().read(true).write(true).create_new(true).open(name).unwrap();
        copy.set_len(whole.len() as u64).unwrap();
        let ends = FileEnds::of_start(&path, &whole[..HEADER_BYTES], whole.len() as u64).unwrap();
        for Range { start, end } in ends.stretches() {
            write_at(&copy, &whole[start as usize..end as usize], start);
        }
        let pump = Arc::new(Pump {
            whole,
            copy: copy.try_clone().unwrap(),
            filled: Mutex::default(),
            announced: AtomicUsize::new(0),
            awaited: AtomicUsize::new(0),
            fails: AtomicBool::new(false),
            wrong: AtomicUsize::new(0),
        });
        Self { path, pump, copy, _folder: folder }
    }

    fn open(&self, trust: Trust) -> PageFile {
        let filler = Box::new(SharedPump(self.pump.clone()));
        PageFile::open_sparse(Path::new("area.hop"), self.copy.try_clone().unwrap(), filler, trust).unwrap()
    }
}

/// With every trust: without checksums a hole would pass for ground.
#[test]
fn parts_are_those_of_the_file_whatever_is_asked_for_first() {
    for verify in [Verify::FirstTouch, Verify::Never] {
        for damaged in [Damaged::Fail, Damaged::Coarser] {
            for part in 0..PagePart::COUNT {
                let site = HolesSite::new();
                let (file, whole) =
                    (site.open(Trust { verify, damaged }), PageFile::open(&site.path).unwrap());
                for (id, _) in whole.directory().present() {
                    let part = PagePart::numbered(part, id);
                    if PagePart::all(id).any(|other| other == part) {
                        file.store().load(part).unwrap();
                    }
                    let (page, of_whole) =
                        (file.page(id).unwrap().unwrap(), whole.page(id).unwrap().unwrap());
                    assert!(page.heights == of_whole.heights && page.colours == of_whole.colours, "{id}");
                    assert!(page.relief == of_whole.relief, "{id}");
                    if id.level > 0 {
                        let [bounds, of_whole] =
                            [&file, &whole].map(|file| file.bounds(id).unwrap().unwrap());
                        assert!(bounds.low == of_whole.low && bounds.high == of_whole.high, "{id}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_part_alone_is_filled_alone_and_a_checked_database_as_a_whole() {
    let site = HolesSite::new();
    let file = site.open(Trust::default());
    let part = PagePart::Heights(PageId { level: 0, px: 1, py: 2 });
    file.heights(part.page()).unwrap();
    file.heights(part.page()).unwrap();
    assert_eq!(*site.pump.filled.lock().unwrap(), [file.stretch(part)]);
    assert_eq!(file.touched_parts(), [part]);
    assert!(file.verify(&Silent).unwrap().is_sound());
}

#[test]
fn wrong_bytes_are_filled_once_more() {
    let id = PageId { level: 0, px: 0, py: 0 };
    let once = HolesSite::new();
    once.pump.wrong.store(1, Ordering::SeqCst);
    once.open(Trust::default()).heights(id).unwrap();
    let always = HolesSite::new();
    always.pump.wrong.store(usize::MAX, Ordering::SeqCst);
    let refusal = always.open(Trust::default()).heights(id).unwrap_err().to_string();
    assert!(refusal.contains("wrong checksum"), "{refusal}");
}

#[test]
fn what_cannot_be_filled_is_an_error_and_no_damage() {
    for damaged in [Damaged::Fail, Damaged::Coarser] {
        let site = HolesSite::new();
        let file = site.open(Trust { damaged, verify: Verify::Never });
        let id = |px| PageId { level: 0, px, py: 0 };
        file.heights(id(0)).unwrap();
        site.pump.fails.store(true, Ordering::SeqCst);
        for page in [id(0), id(1)] {
            let refusal = file.heights(page).unwrap_err().to_string();
            assert!(refusal.contains("it is another one"), "{refusal}");
        }
        assert!(file.intact().is_err() && file.damaged().is_empty());
    }
}

/// Page whose bounds tell what frames need.
const COARSE: PageId = PageId { level: 1, px: 0, py: 0 };

/// Frames that need a page of their own each, and bounds that all need. To plan a frame but the first, bounds may be read, too: those of pages that the frames
/// before need.
struct OnePageEach<'p> {
    pages: &'p ResidentPages,
    reads_bounds: bool,
}

impl PagePlanner for OnePageEach<'_> {
    fn needs(&self, frame: u32) -> Result<PageNeeds> {
        let id = PageId { level: 0, px: frame % 4, py: frame / 4 };
        if self.reads_bounds && frame > 0 {
            self.pages.bounds(COARSE)?;
        }
        Ok(vec![PagePart::Heights(id), PagePart::Bounds(COARSE)].into())
    }

    fn is_behind(&self, _: u32, _: PageId) -> bool {
        false
    }
}

#[test]
fn frames_ahead_are_announced_before_the_first_one_waits() {
    const FRAMES: u32 = 16;
    let site = HolesSite::new();
    let pages = ResidentPages::new(site.open(Trust::default()), None);
    site.pump.awaited.store(FRAMES as usize, Ordering::SeqCst);
    let planner = OnePageEach { pages: &pages, reads_bounds: false };
    let flown = pages.ahead_of(FRAMES, &planner, |flight| {
        for frame in 0..FRAMES {
            flight.begin(frame);
            pages.heights(PageId { level: 0, px: frame % 4, py: frame / 4 }).unwrap();
            flight.deliver(frame);
        }
    });
    flown.unwrap();
    assert_eq!((pages.paging().demand_misses, pages.paging().pages_read), (0, u64::from(FRAMES) + 1));
}

#[test]
fn a_flight_that_ends_early_leaves_nothing_that_is_waited_for() {
    let site = HolesSite::new();
    let pages = ResidentPages::new(site.open(Trust::default()), None);
    let planner = OnePageEach { pages: &pages, reads_bounds: true };
    pages.ahead_of(16, &planner, |flight| flight.begin(0)).unwrap();
    // Nobody waits for ever for what is not coming any more.
    for number in 0..16 {
        pages.heights(PageId { level: 0, px: number % 4, py: number / 4 }).unwrap();
    }
    let bytes = |part| pages.file().store().part_bytes(part);
    let heights = bytes(PagePart::Heights(PageId { level: 0, px: 0, py: 0 }));
    assert_eq!(pages.paging().resident_bytes, 16 * heights + bytes(PagePart::Bounds(COARSE)));
}
