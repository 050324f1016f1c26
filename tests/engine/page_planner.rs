//! Pages that a view may touch, as foreseen, against those that it touches.

use std::collections::BTreeSet;
use std::sync::{LazyLock, Mutex};

use glam::{DVec2, DVec3};

use hedgehop::Result;
use hedgehop::raymarch::ground_height;
use hedgehop::render::{RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, Pose, Screen};
use hedgehop::subimage::Farm;
use hedgehop::sunlight::Sun;
use hedgehop::voxel::{
    BoundsView, DetailRecord, Grid, Header, HeightsView, MemPages, Metadata, PageId, PageNeeds, PagePart,
    PageSource, PageView, SpansView, build_in_memory,
};
use hedgehop_testing::Random;

/// Posts of a side, and metres between them.
const SIDE: u32 = 3000;
const SPACING: f64 = 2.0;
const FLIGHTS: usize = 1000;

/// Hills of waves from 2.5 km down to 20 m, by rows.
static HILLS: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let waves: [_; 8] = std::array::from_fn(|octave| {
        let turn = octave as f64 * 1.1;
        (2500.0 / f64::from(1 << octave), turn, turn.sin_cos())
    });
    // Each wave is a sine along one direction and a cosine across it: of sums of a part that a column has and one that a row
    // has, so that sines are taken once for each of those.
    let turned = |east: f64, north: f64, position: u32| {
        let position = f64::from(position) * SPACING;
        waves.map(|(length, turn, (sin, cos))| {
            let along = (east * cos + north * sin) * position / length * 6.3;
            let across = (north * cos - east * sin) * position / length * 5.1 + north * turn;
            (along.sin_cos(), across.sin_cos())
        })
    };
    let columns: Vec<_> = (0..SIDE).map(|x| turned(1.0, 0.0, x)).collect();

    let mut heights = Vec::with_capacity((SIDE * SIDE) as usize);
    for row in (0..SIDE).map(|y| turned(0.0, 1.0, y)) {
        heights.extend(columns.iter().map(|column| {
            let wave = |octave: usize| {
                let ((a, b), (c, d)) = (column[octave], row[octave]);
                let sine = a.0 * c.1 + a.1 * c.0;
                let cosine = b.1 * d.1 - b.0 * d.0;
                0.035 * waves[octave].0 * (sine + cosine)
            };
            400.0 + (0..8).map(wave).sum::<f64>()
        }));
    }
    heights
});

/// The hills; with a hole in the middle if `holed`.
fn area(holed: bool) -> MemPages {
    let empty_share = if holed { 0.01 } else { 0.0 };
    area_of(holed, Metadata { empty_share, ..Metadata::default() })
}

/// The hills of a database that says so of itself.
fn area_of(holed: bool, metadata: Metadata) -> MemPages {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: SPACING, origin: DVec2::new(5.0e5, 4.0e6) };
    let mut heights = HILLS.clone();
    if holed {
        for (post, height) in heights.iter_mut().enumerate() {
            let [x, y] = [post as u32 % SIDE, post as u32 / SIDE].map(|at| f64::from(at) * SPACING - 3000.0);
            if x.hypot(y) < 150.0 {
                *height = f64::NAN;
            }
        }
    }

    let colours = vec![[90, 110, 70]; heights.len()];
    build_in_memory(grid, &heights, &colours, None, &metadata).unwrap()
}

static AREA: LazyLock<MemPages> = LazyLock::new(|| area(false));

/// Notes what is asked for; some pages may be absent.
struct Watched<'a> {
    pages: &'a MemPages,
    is_absent: fn(PageId) -> bool,
    touched: Mutex<BTreeSet<PagePart>>,
}

impl PageSource for Watched<'_> {
    fn header(&self) -> &Header {
        self.pages.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        if (self.is_absent)(id) {
            return Ok(None);
        }
        self.touched.lock().unwrap().extend(PagePart::posts(id));
        self.pages.page(id)
    }

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        if (self.is_absent)(id) {
            return Ok(None);
        }
        self.touched.lock().unwrap().insert(PagePart::Heights(id));
        self.pages.heights(id)
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        if (self.is_absent)(id) {
            return Ok(None);
        }
        if id.is_bare() {
            self.touched.lock().unwrap().insert(PagePart::Spans(id));
        }
        self.pages.spans(id)
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        if (self.is_absent)(id) {
            return Ok(None);
        }
        self.touched.lock().unwrap().insert(PagePart::Bounds(id));
        self.pages.bounds(id)
    }

    fn has(&self, id: PageId) -> bool {
        !(self.is_absent)(id)
    }
}

/// Parts of pages that were foreseen, how many of them are likely, and those touched.
struct Seen {
    foreseen: Vec<PagePart>,
    likely: usize,
    touched: BTreeSet<PagePart>,
}

fn see(pages: &MemPages, is_absent: fn(PageId) -> bool, camera: &Camera) -> Seen {
    see_with(&RenderOptions::default(), pages, is_absent, camera)
}

fn see_with(
    options: &RenderOptions,
    pages: &MemPages,
    is_absent: fn(PageId) -> bool,
    camera: &Camera,
) -> Seen {
    let source = Watched { pages, is_absent, touched: Mutex::default() };
    let farm = Farm::new(1).unwrap();
    let renderer = Renderer::new(&source, options);
    let PageNeeds { parts: mut foreseen, mut likely } = renderer.foresee(camera, &farm).unwrap();
    let read = std::mem::take(&mut *source.touched.lock().unwrap());
    renderer.picture(camera, &farm).unwrap();
    let mut touched = source.touched.into_inner().unwrap();
    // What was read to foresee is there.
    touched.retain(|part| !read.contains(part) || foreseen.contains(part));
    likely -= foreseen[..likely].iter().filter(|part| is_absent(part.page())).count();
    foreseen.retain(|part| !is_absent(part.page()));
    Seen { foreseen, likely, touched }
}

/// Asserts that nothing was touched that was not foreseen.
fn assert_recalled(seen: &Seen, camera: &Camera) {
    let foreseen: BTreeSet<PagePart> = seen.foreseen.iter().copied().collect();
    assert_eq!(foreseen.len(), seen.foreseen.len());
    let missed: Vec<_> = seen.touched.difference(&foreseen).collect();
    assert!(missed.is_empty(), "{missed:?} of {:?} on {}", camera.pose, camera.screen());
}

fn camera(eye: DVec3, attitude: Attitude, screen: Screen, size: [u32; 2]) -> Camera {
    Camera::with_screen(Pose { eye, attitude, hfov: 60.0 }, screen, size[0], size[1])
}

/// `height` metres above the ground at a place in the area, metres from its corner.
fn above(pages: &MemPages, place: DVec2, height: f64) -> DVec3 {
    let place = pages.header().grid.origin + place;
    let ground = ground_height(pages, place).unwrap().unwrap_or(500.0);
    place.extend(ground + height)
}

/// An eye, an attitude and a screen, of every kind.
fn random_camera(random: &mut Random, pages: &MemPages) -> Camera {
    let side = f64::from(SIDE) * SPACING;
    let beside = if random.share() < 0.1 { 800.0 } else { 0.0 };
    let place =
        DVec2::new(random.between([-beside, side + beside]), random.between([-beside, side + beside]));
    let eye = above(pages, place, (random.between([0.0, 8.5])).exp() - 1.0);
    let steep = random.share() < 0.3;
    let pitch = if steep { random.between([-90.0, 90.0]) } else { random.between([-30.0, 15.0]) };
    let roll = if random.share() < 0.5 { 0.0 } else { random.between([-180.0, 180.0]) };
    let attitude = Attitude { yaw: random.between([0.0, 360.0]), pitch, roll };
    let hfov = random.between([3.0, 120.0]);
    let screen = match (random.share() * 6.0) as u32 {
        0 => Screen::Cylindrical { hfov },
        1 => Screen::Equirectangular { hfov, vfov: 0.6 * hfov },
        2 => Screen::Fisheye { fov: 1.6 * hfov },
        _ => Screen::Planar { hfov },
    };
    camera(eye, attitude, screen, [128, 72])
}

#[test]
fn every_page_that_is_touched_was_foreseen() {
    let mut random = Random(11);
    for _ in 0..FLIGHTS {
        let start = random_camera(&mut random, &AREA);
        let velocity = DVec3::new(
            random.between([-200.0, 200.0]),
            random.between([-200.0, 200.0]),
            random.between([-5.0, 5.0]),
        );
        let turn = random.between([-90.0, 90.0]);
        for time in [0.0, random.between([0.0, 3.0])] {
            let mut camera = start.clone();
            camera.pose.eye += velocity * time;
            camera.pose.attitude.yaw += turn * time;
            assert_recalled(&see(&AREA, |_| false, &camera), &camera);
        }
    }
}

#[test]
fn pages_of_displaced_ground_are_foreseen() {
    let detail = DetailRecord { displacement: 2.0, ..DetailRecord::default() };
    let area = area_of(false, Metadata { detail: Some(detail), ..Metadata::default() });
    let mut random = Random(19);
    for flight in 0..60 {
        let camera = random_camera(&mut random, &area);
        let is_absent: fn(PageId) -> bool = if flight % 3 == 0 {
            |id| id.level == 0 && !(id.px + id.py).is_multiple_of(3)
        } else {
            |_| false
        };
        assert_recalled(&see(&area, is_absent, &camera), &camera);
    }
}

#[test]
fn pages_that_throw_shadows_are_foreseen() {
    let mut random = Random(15);
    for flight in 0..100 {
        let camera = random_camera(&mut random, &AREA);
        let sun = Sun { azimuth: random.between([0.0, 360.0]), elevation: random.between([0.3, 70.0]) };
        let options = RenderOptions { sun, shadows: true, ..RenderOptions::default() };
        let is_absent: fn(PageId) -> bool = match flight % 3 {
            0 => |_| false,
            1 => |id| id.level == 0 && !(id.px + id.py).is_multiple_of(3),
            _ => |id| id.level < 2 && !(id.px + 2 * id.py).is_multiple_of(5),
        };
        assert_recalled(&see_with(&options, &AREA, is_absent, &camera), &camera);
    }
}

#[test]
fn holes_and_absent_pages_are_foreseen() {
    let holed = area(true);
    let mut random = Random(12);
    for flight in 0..120 {
        let camera = random_camera(&mut random, &holed);
        let is_absent: fn(PageId) -> bool = match flight % 2 {
            0 => |_| false,
            _ => |id| id.level == 0 && !(id.px + id.py).is_multiple_of(3),
        };
        assert_recalled(&see(&holed, is_absent, &camera), &camera);
    }
}

/// Behind an area's last lines planes look at these.
#[test]
fn views_from_above_edges_are_foreseen() {
    let side = f64::from(SIDE) * SPACING;
    let mut random = Random(14);
    for flight in 0..200 {
        let mut camera = random_camera(&mut random, &AREA);
        let beside = random.between([-3.0, 3.0]) * SPACING;
        let along = random.between([0.0, side]);
        let [low, high] = [beside, side + beside];
        let places = [(low, along), (high, along), (along, low), (along, high), (high, high)];
        camera.pose.eye = above(&AREA, DVec2::from(places[flight % 5]), random.between([0.0, 8.5]).exp());
        camera.pose.attitude.pitch = random.between([-90.0, -20.0]);
        let is_absent: fn(PageId) -> bool =
            if flight % 2 == 0 { |_| false } else { |id| id.level == 0 && id.px.is_multiple_of(3) };
        assert_recalled(&see(&AREA, is_absent, &camera), &camera);
    }
}

#[test]
fn what_stands_in_beside_corridors_is_foreseen() {
    // Level 1 in two rows of pages, level 4 in the one that they lie in; and level 1 in a stair, level 4 everywhere.
    let strip = |id: PageId| (id.level == 0 && !(5..7).contains(&id.py)) || (id.level == 1 && id.py != 1);
    let stair = |id: PageId| id.level == 0 && id.px.abs_diff(id.py) > 1;
    // A lone page under which all is stored, and two levels absent elsewhere.
    let island = |id: PageId| id.level < 2 && [id.px, id.py].map(|at| at >> (2 - 2 * id.level)) != [1, 1];
    let corridors: [fn(PageId) -> bool; 3] = [strip, stair, island];
    let mut random = Random(13);
    for flight in 0..450 {
        let camera = random_camera(&mut random, &AREA);
        assert_recalled(&see(&AREA, corridors[flight % 3], &camera), &camera);
    }
}

#[test]
fn most_of_what_is_foreseen_of_a_level_flight_is_touched() {
    let (mut foreseen, mut touched) = (0, 0);
    // What is likely, and the rest.
    let mut classes = [[0; 2]; 2];
    for frame in 0..40 {
        let place = DVec2::new(1000.0 + 100.0 * f64::from(frame), 900.0 + 90.0 * f64::from(frame));
        let attitude = Attitude { yaw: 48.0, pitch: -3.0, roll: 0.0 };
        let camera = camera(above(&AREA, place, 60.0), attitude, Screen::Planar { hfov: 60.0 }, [960, 540]);
        let seen = see(&AREA, |_| false, &camera);
        assert_recalled(&seen, &camera);
        foreseen += seen.foreseen.len();
        touched += seen.touched.len();

        for (index, part) in seen.foreseen.iter().enumerate() {
            let [all, of_these] = &mut classes[usize::from(index >= seen.likely)];
            *all += 1;
            *of_these += usize::from(seen.touched.contains(part));
        }
    }

    assert!(touched * 10 >= foreseen * 7, "precision: {touched} of {foreseen}");
    let [[likely, right], [others, wrong]] = classes;
    assert!(
        right * 10 >= likely * 8 && wrong * 2 < others,
        "{right} of {likely} likely ones, {wrong} of {others} others"
    );
}
