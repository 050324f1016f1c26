//! Flights under budgets of memory: pictures never differ, pages come in time, and no more are in memory than may.

mod hills;

use std::path::{Path, PathBuf};

use glam::DVec3;
use hedgehop::memory::{PageFile, Paging, ResidentPages};
use hedgehop::progress::Silent;
use hedgehop::render::{FlightPlan, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::{Batch, Farm};
use hills::write_hills;
use tempfile::TempDir;

const FRAMES: u32 = 24;

/// Level flight to the north-east.
fn cameras() -> Vec<(u64, Camera)> {
    let camera = |frame: u32| {
        let eye = DVec3::new(800.0, 700.0, 330.0) + f64::from(frame) * DVec3::new(120.0, 110.0, 0.0);
        let attitude = Attitude { yaw: 47.0, pitch: -4.0, roll: 0.0 };
        Camera::new(Pose { eye, attitude, hfov: 60.0 }, 320, 180)
    };
    (0..FRAMES).map(|frame| (u64::from(frame) + 1, camera(frame))).collect()
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

/// Light may be computed ahead of need if the flight `is_lit`.
fn fly(path: &Path, budget: Option<u64>, workers: usize, is_lit: bool) -> Flown {
    let pages = ResidentPages::new(PageFile::open(path).unwrap(), budget);
    let renderer = Renderer::new(&pages, &RenderOptions::default()).with_memory(2 << 20);
    let farm = Farm::new(workers).unwrap();
    let cameras = cameras();
    let plan = FlightPlan::new(&renderer, &farm, &cameras);
    let plan = if is_lit { plan.of_pictures() } else { plan };
    let plan = if is_lit { plan.of_pictures() } else { plan };
    let frames: Vec<_> =
        (0..).zip(&cameras).map(|(frame, (number, camera))| (*number, (frame, camera))).collect();
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
    let budgets = [free.total.resident_bytes, free.total.resident_bytes * 3 / 4, 1 << 20];
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
        assert!(flown.total.bytes_read <= free.total.bytes_read * 13 / 10, "{:?}", flown.total);
        assert!(budget == budgets[0] || flown.total.pages_evicted > 0);
    }
}

#[test]
fn views_that_are_more_than_the_budget_are_lit_ahead() {
    let (_folder, path) = hills();
    let free = fly(&path, None, 1, true);
    let budget = free.total.resident_bytes * 7 / 16;
    let [dark, lit] = [false, true].map(|is_lit| fly(&path, Some(budget), 2, is_lit));
    assert!(dark.pictures == free.pictures && lit.pictures == free.pictures);
    let misses = |flown: &Flown| flown.later.iter().map(|frame| frame.demand_misses).sum::<u64>();
    assert!(misses(&dark) > 0 && misses(&lit) <= misses(&dark), "{:?}, {:?}", dark.total, lit.total);
    // Paint comes for what is lit, and goes.
    assert!(lit.total.pages_evicted > 2 * dark.total.pages_evicted, "{:?}", lit.total);
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
