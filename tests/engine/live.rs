//! Frames that never wait for pages: they begin with what is there, say how much was seen more coarsely, and refine.

use std::fs;
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{LazyLock, Mutex};
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use tempfile::TempDir;

use crate::hills::write_hills;
use hedgehop::memory::{LOOKAHEAD, PageFile, PagePlanner, Paging, ResidentPages};
use hedgehop::progress::Silent;
use hedgehop::render::{Engine, LiveFrame, LivePlan, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{Damaged, PageId, PageNeeds, PagePart, PageSource, Trust, Verify};
use hedgehop::{Error, Result};

/// Long enough for any machine to read a few megabytes.
const PATIENCE: Duration = Duration::from_secs(60);

static AREA: LazyLock<(TempDir, Vec<u8>)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    write_hills(&path);
    let bytes = fs::read(&path).unwrap();
    (folder, bytes)
});

fn open(budget: Option<u64>) -> ResidentPages {
    ResidentPages::new(PageFile::open(&AREA.0.path().join("area.hop")).unwrap(), budget)
}

fn camera(frame: u32) -> Camera {
    camera_of(frame, [320, 180])
}

fn camera_of(frame: u32, [width, height]: [u32; 2]) -> Camera {
    let eye = DVec3::new(800.0, 700.0, 330.0) + f64::from(frame) * DVec3::new(60.0, 55.0, 0.0);
    let attitude = Attitude { yaw: 47.0, pitch: -9.0, roll: 3.0 };
    Camera::new(Pose { eye, attitude, hfov: 60.0 }, width, height)
}

fn told(frame: u32, seconds: f64, camera: &Camera) -> LiveFrame {
    LiveFrame { frame, seconds, camera: camera.clone(), sky: None }
}

fn options(engine: Engine) -> RenderOptions {
    RenderOptions { engine, ..RenderOptions::default() }
}

/// The picture, and the share of it that was seen more coarsely.
fn see(renderer: &Renderer<'_>, camera: &Camera, workers: usize) -> Result<(Vec<u8>, f64)> {
    let (picture, account) = renderer.picture(camera, &Farm::new(workers).unwrap())?;
    Ok((picture.rgb, account.rays.coarser_share()))
}

/// Brings a part of a page into memory.
fn touch(pages: &ResidentPages, part: PagePart) {
    match part {
        PagePart::Heights(id) => pages.heights(id).map(drop).unwrap(),
        PagePart::Paint(id) => pages.page(id).map(drop).unwrap(),
        PagePart::Bounds(id) => pages.bounds(id).map(drop).unwrap(),
        PagePart::Spans(id) => pages.spans(id).map(drop).unwrap(),
    }
}

/// With everything in memory.
fn expected(engine: Engine, camera: &Camera) -> Vec<u8> {
    let pages = open(None);
    pages.load_all(&Silent).unwrap();
    see(&Renderer::new(&pages, &options(engine)), camera, 2).unwrap().0
}

/// Peak signal to noise of two pictures, dB.
fn psnr(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    10.0 * (255.0 * 255.0 * a.len() as f64 / squares.max(1e-9)).log10()
}

fn assert_never_waited(paging: Paging) {
    let waits = [paging.demand_misses, paging.demand_waits, paging.demand_wait_ns, paging.frame_wait_ns];
    assert_eq!(waits, [0; 4], "{paging:?}");
}

/// Says when it is asked first, and answers when it is let: the memory thread stands still meanwhile.
struct Standstill<'a> {
    plan: &'a dyn PagePlanner,
    asked: Sender<()>,
    go_on: Mutex<Receiver<()>>,
}

impl PagePlanner for Standstill<'_> {
    fn needs(&self, frame: u32) -> Result<PageNeeds> {
        let _ = self.asked.send(());
        // An error once nobody lets it wait any more.
        let _ = self.go_on.lock().unwrap().recv();
        self.plan.needs(frame)
    }

    fn is_behind(&self, frame: u32, page: PageId) -> bool {
        self.plan.is_behind(frame, page)
    }
}

fn never_waits_and_refines(engine: Engine, size: [u32; 2], least_psnr: f64) {
    let pages = open(None);
    let renderer = Renderer::new(&pages, &options(engine));
    let farm = Farm::new(1).unwrap();
    let plan = LivePlan::new(&renderer, &farm);
    let camera = camera_of(0, size);
    let expected = expected(engine, &camera);
    let ((asked, is_asked), (let_go, go_on)) = (channel(), channel());
    let standstill = Standstill { plan: &plan, asked, go_on: Mutex::new(go_on) };

    pages
        .live(&standstill, |flight| {
            plan.tell(told(0, 0.0, &camera)).unwrap();
            let begun = flight.begin(0);
            is_asked.recv().unwrap();

            // Nothing can come any more: all frames see the same.
            let (first, share) = see(&renderer.over(&begun), &camera, 1).unwrap();
            assert!(share > 0.2 && share <= 1.0, "{share}");
            let likeness = psnr(&first, &expected);
            assert!(likeness > least_psnr && first != expected, "{likeness} dB");
            drop(begun);
            flight.deliver(0);

            for workers in [1, 2, 3] {
                let present = flight.begin(1);
                let again = see(&renderer.over(&present), &camera, workers).unwrap();
                assert!(again == (first.clone(), share), "{workers} workers");
            }

            flight.deliver(1);
            assert_never_waited(pages.paging());
            assert!(pages.paging().pages_late > 0);

            // The disk answers again.
            drop(let_go);
            let since = Instant::now();
            let mut shares = vec![share];

            for frame in 2.. {
                plan.tell(told(frame, f64::from(frame), &camera)).unwrap();
                let present = flight.begin(frame);
                let (picture, share) = see(&renderer.over(&present), &camera, 2).unwrap();
                drop(present);
                flight.deliver(frame);
                shares.push(share);
                if share == 0.0 {
                    assert!(picture == expected, "all is there, and the picture is another");
                    break;
                }
                assert!(since.elapsed() < PATIENCE, "{shares:?}");
            }

            assert_never_waited(pages.paging());
            // Whoever waits sees the same, of the light that was computed meanwhile.
            assert!(see(&renderer, &camera, 2).unwrap().0 == expected);
        })
        .unwrap();
}

#[test]
fn a_frame_of_scan_planes_never_waits_and_refines() {
    never_waits_and_refines(Engine::Planes, [320, 180], 20.0);
}

#[test]
fn a_frame_of_the_reference_never_waits_and_refines() {
    never_waits_and_refines(Engine::Reference, [160, 90], 20.0);
}

#[test]
fn pictures_depend_on_the_pages_that_are_there_and_on_nothing_else() {
    let camera = camera(0);
    let pages = open(None);
    let needs = {
        let farm = Farm::new(1).unwrap();
        Renderer::new(&pages, &options(Engine::Planes)).foresee(&camera, &farm).unwrap().parts
    };

    // Every other page is there.
    let half = open(None);
    for part in needs.iter().step_by(2) {
        touch(&half, *part);
    }

    let known = Renderer::new(&pages, &options(Engine::Planes));
    let whole = see(&known, &camera, 2).unwrap();
    half.live(&Nothing, |flight| {
        let present = flight.begin(0);
        let fresh = Renderer::new(&half, &options(Engine::Planes));
        let first = see(&fresh.over(&present), &camera, 1).unwrap();
        assert!(first.1 > 0.0 && first.0 != whole.0, "{}", first.1);
        for workers in [2, 3] {
            assert!(see(&fresh.over(&present), &camera, workers).unwrap() == first, "{workers} workers");
        }
        // Light and heights of the pages that are not there are known from frames that had them.
        assert!(see(&known.over(&present), &camera, 2).unwrap() == first, "what is kept shows");
        assert!(see(&known, &camera, 2).unwrap() == whole);
    })
    .unwrap();
}

/// Foresees nothing.
struct Nothing;

impl PagePlanner for Nothing {
    fn needs(&self, _: u32) -> Result<PageNeeds> {
        Ok(PageNeeds::default())
    }

    fn is_behind(&self, _: u32, _: PageId) -> bool {
        true
    }
}

/// Flies some frames and looks at every picture.
fn fly(pages: &ResidentPages, frames: u32, mut look: impl FnMut(u32, &[u8], f64)) -> Result<Paging> {
    let renderer = Renderer::new(pages, &options(Engine::Planes)).with_memory(32 << 20);
    let farm = Farm::new(2).unwrap();
    let plan = LivePlan::new(&renderer, &farm);
    pages.live(&plan, |flight| {
        for frame in 0..frames {
            let camera = camera(frame);
            plan.tell(told(frame, f64::from(frame) / 30.0, &camera))?;
            let (picture, share) = see(&renderer.over(&flight.begin(frame)), &camera, 2)?;
            flight.deliver(frame);
            look(frame, &picture, share);
        }
        Ok(pages.paging())
    })?
}

#[test]
fn a_flight_in_far_too_little_memory_goes_on_more_coarsely() {
    let pages = open(Some(1 << 20));
    let mut shares = Vec::new();
    let paging = fly(&pages, 20, |frame, picture, share| {
        let likeness = psnr(picture, &expected(Engine::Planes, &camera(frame)));
        assert!(likeness > 20.0, "frame {frame}: {likeness} dB");
        shares.push(share);
    });
    assert_never_waited(paging.unwrap());
    assert!(shares.iter().all(|share| *share > 0.0 && *share <= 1.0), "{shares:?}");
}

#[test]
fn where_a_view_is_larger_than_memory_its_nearest_pages_stay() {
    let needed = {
        let pages = open(None);
        let renderer = Renderer::new(&pages, &options(Engine::Planes));
        let farm = Farm::new(1).unwrap();
        let needs = renderer.foresee(&camera(0), &farm).unwrap().parts;
        needs.into_iter().for_each(|part| touch(&pages, part));
        pages.paging().resident_bytes
    };

    let pages = open(Some(needed / 2));
    let renderer = Renderer::new(&pages, &options(Engine::Planes));
    let farm = Farm::new(1).unwrap();
    let plan = LivePlan::new(&renderer, &farm);
    let since = Instant::now();

    pages
        .live(&plan, |flight| {
            let (mut read, mut same) = (0, 0);
            for frame in 0.. {
                plan.tell(told(frame, f64::from(frame), &camera(0))).unwrap();
                let (_, share) = see(&renderer.over(&flight.begin(frame)), &camera(0), 1).unwrap();
                assert!(share > 0.0);
                flight.deliver(frame);
                let now = pages.paging().pages_read;
                same = if now == read { same + 1 } else { 0 };
                read = now;
                if frame > 20 && same >= 20 {
                    break;
                }
                assert!(since.elapsed() < PATIENCE, "frame {frame}: {:?}", pages.paging());
            }
        })
        .unwrap();
}

#[test]
fn a_flight_with_everything_in_memory_is_that_of_one_that_waits() {
    let pages = open(None);
    pages.load_all(&Silent).unwrap();
    let paging = fly(&pages, 4, |frame, picture, share| {
        assert_eq!(share, 0.0);
        assert!(picture == expected(Engine::Planes, &camera(frame)), "frame {frame}");
    });
    assert_never_waited(paging.unwrap());
}

#[test]
fn damaged_pages_are_errors_or_left_out_as_in_a_flight_that_waits() {
    let camera = camera(0);
    let pages = open(None);
    let renderer = Renderer::new(&pages, &options(Engine::Planes));
    let needs = renderer.foresee(&camera, &Farm::new(1).unwrap()).unwrap().parts;
    let broken = needs.iter().map(|part| part.page()).find(|id| id.level == 0).unwrap();
    let mut bytes = AREA.1.clone();
    bytes[pages.file().directory().get(broken).unwrap().offset as usize + 1000] ^= 0x40;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.hop");
    fs::write(&path, &bytes).unwrap();
    let failed = refined(&path, Damaged::Fail, &camera, &[]);
    let told = failed.unwrap_err().to_string();
    assert!(told.contains("broken.hop") && told.contains(&broken.to_string()), "{told}");
    let trust = Trust { verify: Verify::FirstTouch, damaged: Damaged::Coarser };
    let pages = ResidentPages::new(PageFile::open_trusting(&path, trust).unwrap(), None);
    let without = see(&Renderer::new(&pages, &options(Engine::Planes)), &camera, 2).unwrap().0;
    assert!(without != expected(Engine::Planes, &camera));
    refined(&path, Damaged::Coarser, &camera, &without).unwrap();
}

/// Looks until the picture is the one that is expected, or something is wrong.
fn refined(path: &Path, damaged: Damaged, camera: &Camera, expected: &[u8]) -> Result<()> {
    let trust = Trust { verify: Verify::FirstTouch, damaged };
    let pages = ResidentPages::new(PageFile::open_trusting(path, trust)?, None);
    let renderer = Renderer::new(&pages, &options(Engine::Planes));
    let farm = Farm::new(2)?;
    let plan = LivePlan::new(&renderer, &farm);
    let since = Instant::now();
    pages.live(&plan, |flight| {
        for frame in 0.. {
            plan.tell(told(frame, f64::from(frame), camera))?;
            let picture = see(&renderer.over(&flight.begin(frame)), camera, 2)?.0;
            flight.deliver(frame);
            if picture == expected {
                break;
            }
            assert!(since.elapsed() < PATIENCE);
        }
        Ok(())
    })?
}

#[test]
fn a_damaged_page_of_the_coarsest_level_ends_the_flight_before_it_begins() {
    let pages = open(None);
    let coarsest = PageId { level: pages.header().level_count - 1, px: 0, py: 0 };
    let mut bytes = AREA.1.clone();
    bytes[pages.file().directory().get(coarsest).unwrap().offset as usize + 1000] ^= 0x40;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.hop");
    fs::write(&path, &bytes).unwrap();
    let broken = ResidentPages::new(PageFile::open(&path).unwrap(), None);
    let told = broken.live(&Nothing, |_| ()).unwrap_err();
    assert!(matches!(told, Error::Invalid { .. }), "{told}");
}

fn pose(eye: DVec3, yaw: f64, pitch: f64, roll: f64) -> Pose {
    Pose { eye, attitude: Attitude { yaw, pitch, roll }, hfov: 60.0 }
}

/// At 150 m/s, 8° a second.
fn turn(seconds: f64) -> Pose {
    let (rate, radius) = (8.0_f64.to_radians(), 150.0 / 8.0_f64.to_radians());
    let (sin, cos) = (rate * seconds).sin_cos();
    let eye = DVec3::new(2900.0 - radius * cos, 2000.0 + radius * sin, 330.0);
    pose(eye, (rate * seconds).to_degrees(), -8.0, 60.0)
}

fn climb(seconds: f64) -> Pose {
    let eye = DVec3::new(900.0 + 180.0 * seconds, 1500.0, 320.0 + 12.0 * seconds * seconds);
    pose(eye, 90.0, (24.0 * seconds).atan2(180.0).to_degrees() - 15.0, 0.0)
}

#[test]
fn a_live_plan_foresees_what_the_flight_then_needs() {
    let pages = open(None);
    let renderer = Renderer::new(&pages, &options(Engine::Planes));
    let farm = Farm::new(1).unwrap();
    for (name, flown) in [("turn", turn as fn(f64) -> Pose), ("climb", climb)] {
        let seen = |frame: u32| Camera::new(flown(f64::from(frame) / 30.0), 320, 180);
        let plan = LivePlan::new(&renderer, &farm);
        assert!(plan.predict(9).is_none() && plan.needs(9).unwrap().parts.is_empty());
        const KNOWN: u32 = 20;

        for frame in 0..=KNOWN {
            plan.tell(told(frame, f64::from(frame) / 30.0, &seen(frame))).unwrap();
        }
        for ahead in [1, 10, LOOKAHEAD] {
            let camera = seen(KNOWN + ahead);
            let predicted = plan.predict(KNOWN + ahead).unwrap();
            let off = predicted.pose.eye.distance(camera.pose.eye);
            assert!(off < 1.0, "{name}, {ahead} frames ahead: {off} m");
            let (needed, foreseen) =
                (renderer.foresee(&camera, &farm).unwrap().parts, plan.needs(KNOWN + ahead).unwrap().parts);
            let missed = needed.iter().filter(|id| !foreseen.contains(id)).count();
            assert!(missed * 20 <= needed.len(), "{name}, {ahead}: {missed} of {}", needed.len());
        }

        let behind = renderer_page(&pages, seen(KNOWN).pose, -1500.0);
        let before = renderer_page(&pages, seen(KNOWN).pose, 1000.0);
        assert!(!plan.is_behind(KNOWN, before));
        assert!(plan.is_behind(KNOWN, behind), "{name}: {behind}");
        assert!(plan.tell(told(99, f64::NAN, &seen(0))).is_err());
    }
}

/// The finest page so many metres before the eye.
fn renderer_page(pages: &ResidentPages, pose: Pose, before: f64) -> PageId {
    let (sin, cos) = pose.attitude.yaw.to_radians().sin_cos();
    let place = pose.eye.truncate() + before * DVec2::new(sin, cos);
    let page = (place / pages.header().grid.spacing / 256.0).max(DVec2::ZERO);
    PageId { level: 0, px: page.x as u32, py: page.y as u32 }
}
