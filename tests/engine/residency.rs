//! Flights under budgets of memory: pictures never differ, pages come in time, and no more are in memory than may.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use glam::DVec3;
use tempfile::TempDir;

use crate::hills::write_hills;
use hedgehop::Result;
use hedgehop::memory::{PageFile, Paging, ResidentPages};
use hedgehop::progress::Silent;
use hedgehop::render::{FlightPlan, NumberedCamera, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::{Batch, Farm};
use hedgehop::voxel::{BoundsView, Header, HeightsView, PageId, PagePart, PageSource, PageView, SpansView};

const FRAMES: u32 = 24;

/// Level flight to the north-east.
fn cameras() -> Vec<NumberedCamera> {
    let camera = |frame: u32| {
        let eye = DVec3::new(800.0, 700.0, 330.0) + f64::from(frame) * DVec3::new(120.0, 110.0, 0.0);
        let attitude = Attitude { yaw: 47.0, pitch: -4.0, roll: 0.0 };
        Camera::new(Pose { eye, attitude, hfov: 60.0 }, 320, 180)
    };
    (0..FRAMES)
        .map(|frame| NumberedCamera { number: u64::from(frame) + 1, camera: camera(frame), sky: None })
        .collect()
}

struct Flown {
    pictures: Vec<Vec<u8>>,
    /// Since the first frame was delivered.
    later: Vec<Paging>,
    total: Paging,
}

/// A database of hills, and the folder that it goes with.
fn hills() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    write_hills(&path);
    (folder, path)
}

/// Within a budget paint is left out of what comes ahead of need, if the flight `brings` it.
fn fly(path: &Path, budget: Option<u64>, workers: usize, brings: bool) -> Flown {
    let pages = ResidentPages::new(PageFile::open(path).unwrap(), budget);
    let renderer = Renderer::new(&pages, &RenderOptions::default()).with_memory(2 << 20);
    let farm = Farm::new(workers).unwrap();
    let cameras = cameras();
    let plan = FlightPlan::new(&renderer, &farm, &cameras);
    let plan = if brings { plan.of_pictures() } else { plan };
    let frames: Vec<_> =
        (0..).zip(&cameras).map(|(frame, seen)| (seen.number, (frame, &seen.camera))).collect();
    let mut pictures = Vec::new();

    let later = pages
        .ahead_of(FRAMES, &plan, |flight| {
            let batch = Batch { frames: &frames, in_flight: 2, observer: &Silent };
            let render = |farm: &Farm, &(frame, camera): &(u32, &Camera)| {
                flight.begin(frame);
                Ok(renderer.picture(camera, farm)?.0.rgb)
            };
            let mut delivered = 0;

            farm.fly(&batch, render, |_, picture| {
                pictures.push(picture);
                flight.deliver(delivered);
                delivered += 1;
                Ok(())
            })
            .unwrap();

            flight.frames()
        })
        .unwrap();

    Flown { pictures, later, total: pages.paging() }
}

#[test]
fn pictures_are_the_same_under_every_budget_and_pages_come_in_time() {
    let (_folder, path) = hills();
    let free = fly(&path, None, 1, true);
    assert_eq!((free.total.demand_misses, free.total.pages_evicted), (0, 0));
    assert!(free.total.resident_bytes_most == free.total.resident_bytes);
    let budgets = [free.total.resident_bytes, free.total.resident_bytes * 5 / 8, 1 << 20];

    for (budget, workers) in budgets.into_iter().flat_map(|budget| [(budget, 1), (budget, 2)]) {
        let flown = fly(&path, Some(budget), workers, true);
        assert!(flown.pictures == free.pictures, "{budget} bytes, {workers} workers");
        if budget < 2 << 20 {
            // Too little for a frame: it is rendered all the same.
            assert!(flown.total.demand_misses > 0);
            continue;
        }

        let misses: u64 = flown.later.iter().map(|frame| frame.demand_misses).sum();
        assert_eq!(misses, 0, "{budget} bytes, {workers} workers: {:?}", flown.total);
        assert!(flown.total.resident_bytes_most <= budget, "{:?}", flown.total);
        let touched = flown.total.bytes_read - flown.total.bytes_unused;
        assert!(flown.total.bytes_read <= touched * 13 / 10, "{:?}", flown.total);
        assert!(budget == budgets[0] || flown.total.pages_evicted > 0);
    }
}

#[test]
fn within_a_budget_paint_comes_once_it_is_in_sight() {
    let (_folder, path) = hills();
    let free = fly(&path, None, 1, true);
    assert_eq!(free.total.pages_in_sight, 0, "{:?}", free.total);
    let misses = |flown: &Flown| flown.later.iter().map(|frame| frame.demand_misses).sum::<u64>();
    for (sixteenths, most) in [(7, u64::MAX), (8, 0), (10, 0)] {
        let budget = free.total.resident_bytes * sixteenths / 16;
        let [ahead, in_sight] = [false, true].map(|brings| fly(&path, Some(budget), 2, brings));
        assert!(ahead.pictures == free.pictures && in_sight.pictures == free.pictures);
        assert!(in_sight.total.pages_in_sight > ahead.total.pages_in_sight, "{:?}", in_sight.total);
        assert!(misses(&in_sight) <= most.min(misses(&ahead)), "{:?}, {:?}", ahead.total, in_sight.total);
        assert!(most > 0 || in_sight.total.resident_bytes_most <= budget, "{:?}", in_sight.total);
    }
}

/// A database of which nothing is at hand before it was brought.
struct Distant<'p> {
    pages: &'p PageFile,
    brought: Mutex<HashSet<PageId>>,
    /// Pages whose paint was read before they were brought.
    early: Mutex<HashSet<PageId>>,
    /// In the order of asking, some of them several times.
    announced: Mutex<Vec<PageId>>,
}

impl<'p> Distant<'p> {
    fn new(pages: &'p PageFile) -> Self {
        Self { pages, brought: Mutex::default(), early: Mutex::default(), announced: Mutex::default() }
    }
}

impl PageSource for Distant<'_> {
    fn header(&self) -> &Header {
        self.pages.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        // The height above ground is that above a coarse level.
        if id.level < 3 && !self.is_at_hand(id) {
            self.early.lock().unwrap().insert(id);
        }
        self.pages.page(id)
    }

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        self.pages.heights(id)
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        self.pages.spans(id)
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        self.pages.bounds(id)
    }

    fn has(&self, id: PageId) -> bool {
        self.pages.has(id)
    }

    fn is_at_hand(&self, id: PageId) -> bool {
        self.brought.lock().unwrap().contains(&id)
    }

    fn announce(&self, id: PageId) {
        self.announced.lock().unwrap().push(id);
    }

    fn bring(&self, pages: &[PageId]) {
        let mut brought = self.brought.lock().unwrap();
        for page in pages {
            assert!(brought.insert(*page), "{page} is brought twice");
        }
    }
}

#[test]
fn frames_wait_only_for_pages_whose_paint_they_have_in_sight() {
    let (_folder, path) = hills();
    let pages = PageFile::open(&path).unwrap();
    let plain = Renderer::new(&pages, &RenderOptions::default());
    let distant = Distant::new(&pages);
    let renderer = Renderer::new(&distant, &RenderOptions::default());
    let mut seen = 0;

    for (index, NumberedCamera { camera, .. }) in cameras().iter().enumerate().step_by(6) {
        let farm = Farm::new(1 + index % 3).unwrap();
        let picture = renderer.picture(camera, &farm).unwrap().0;
        assert!(picture == plain.picture(camera, &farm).unwrap().0, "frame {index}");
        assert_eq!(*distant.early.lock().unwrap(), HashSet::new(), "frame {index}");
        let mut announced = std::mem::take(&mut *distant.announced.lock().unwrap());
        let brought = distant.brought.lock().unwrap().len();
        announced.sort_unstable();
        announced.dedup();
        assert_eq!(announced.len(), brought - seen, "frame {index}: each is announced, and nothing else");
        seen = brought;
    }

    assert!(seen > 10, "{seen} pages");
}

#[test]
fn what_a_frame_has_in_sight_was_foreseen() {
    let (_folder, path) = hills();
    let pages = PageFile::open(&path).unwrap();
    let farm = Farm::new(1).unwrap();
    for NumberedCamera { camera, .. } in cameras().iter().step_by(6) {
        let distant = Distant::new(&pages);
        let renderer = Renderer::new(&distant, &RenderOptions::default());
        renderer.picture(camera, &farm).unwrap();
        let foreseen: HashSet<_> = renderer.foresee(camera, &farm).unwrap().parts.into_iter().collect();
        for page in distant.brought.into_inner().unwrap() {
            assert!(foreseen.contains(&PagePart::Paint(page)), "{page}");
        }
    }
}

#[test]
fn a_whole_database_is_loaded_only_where_it_fits() {
    let (_folder, path) = hills();
    let open = |budget| ResidentPages::new(PageFile::open(&path).unwrap(), budget);
    let whole = open(None);
    whole.load_all(&Silent).unwrap();
    let loaded = whole.paging();
    assert_eq!((loaded.resident_bytes, loaded.bytes_read), (whole.bytes(), whole.bytes()));
    let just = open(Some(whole.bytes()));
    just.load_all(&Silent).unwrap();
    assert_eq!(just.paging().resident_bytes, whole.bytes());
    let small = open(Some(whole.bytes() - 1));
    let refusal = small.load_all(&Silent).unwrap_err().to_string();
    assert!(refusal.contains("area.hop") && refusal.contains("cannot be loaded as a whole"), "{refusal}");
    assert_eq!(small.paging().pages_read, 0);
}
