//! Scan planes against the reference marcher: any attitude, field of view, height and screen.

use std::f64::consts::TAU;
use std::sync::{Arc, LazyLock};

use glam::{DVec2, DVec3};

use hedgehop::frame::Frame;
use hedgehop::raymarch::ground_height;
use hedgehop::render::{Engine, RenderOptions, Renderer, render_reference};
use hedgehop::space::{Attitude, Camera, Pose, RayTable, Screen};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{Grid, MemPages, Metadata, PageSource, build_in_memory};
use hedgehop_testing::Random;

/// Posts of a side, and metres between them.
const SIDE: u32 = 600;
const SPACING: f64 = 10.0;
/// Heights above the ground, posts apart.
const HEIGHTS: [f64; 2] = [0.5, 50_000.0];
/// Degrees.
const FIELDS_OF_VIEW: [f64; 2] = [1.0, 150.0];
const SIZE: [u32; 2] = [240, 180];

/// Poses on each screen.
const POSES: usize = 40;
/// Relative error of range of half, 99 % and 99.6 % of the pixels, and share of those where only one sees the sky.
const BOUNDS: [f64; 4] = [1.5e-4, 3e-3, 1e-2, 1e-3];

/// Hills with long and short waves.
static AREA: LazyLock<MemPages> = LazyLock::new(|| {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: SPACING, origin: DVec2::new(5.0e5, 4.0e6) };
    let posts = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (f64::from(x), f64::from(y))));
    let heights: Vec<_> = posts
        .map(|(x, y)| {
            250.0 + 90.0 * (x / 31.0).sin() + 60.0 * (y / 23.0).cos() + 9.0 * (x / 7.0 + y / 5.0).sin()
        })
        .collect();
    let colours: Vec<_> = (0..heights.len()).map(|index| [(index / 9 % 256) as u8, 90, 120]).collect();
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
});

/// As often in each decade.
fn of_any_size(random: &mut Random, range: [f64; 2]) -> f64 {
    random.between(range.map(f64::ln)).exp()
}

fn screen(name: &str, fov: f64) -> Screen {
    match name {
        "planar" => Screen::Planar { hfov: fov },
        "cylindrical" => Screen::Cylindrical { hfov: 2.4 * fov },
        "equirectangular" => Screen::Equirectangular { hfov: 2.4 * fov, vfov: 1.2 * fov },
        "fisheye" => Screen::Fisheye { fov: 2.4 * fov },
        _ => {
            let table = RayTable::of_screen(&Screen::Planar { hfov: fov }, 40, 30).unwrap();
            Screen::Table(Arc::new(table))
        }
    }
}

/// An eye over the area. Every other one looks at a place in it; from high up, others see hardly any ground.
fn pose(random: &mut Random, looks_at_ground: bool) -> Pose {
    let corner = AREA.header().grid.origin;
    let mut place = || corner + DVec2::new(random.share(), random.share()) * f64::from(SIDE) * SPACING;
    let (here, there) = (place(), place());
    let ground = |place: DVec2| place.extend(ground_height(&*AREA, place).unwrap().unwrap());
    let eye = ground(here) + DVec3::Z * SPACING * of_any_size(random, HEIGHTS);
    let ahead = ground(there) - eye;
    let mut attitude = Attitude {
        yaw: random.between([0.0, 360.0]),
        pitch: random.between([-90.0, 90.0]),
        roll: random.between([-180.0, 180.0]),
    };
    if looks_at_ground {
        attitude.yaw = ahead.x.atan2(ahead.y).rem_euclid(TAU).to_degrees();
        attitude.pitch = ahead.z.atan2(ahead.truncate().length()).to_degrees();
    }

    // The corners of all cases.
    match (4.0 * random.share()) as u32 {
        0 => attitude.roll = 90.0 * (4.0 * random.share()).floor(),
        1 => attitude.pitch = [-90.0, 0.0, 90.0][(3.0 * random.share()) as usize],
        _ => {}
    }

    Pose { eye, attitude, hfov: of_any_size(random, FIELDS_OF_VIEW) }
}

/// Relative errors of range, and pixels of which only one engine sees the sky.
#[derive(Default)]
struct Differences {
    errors: Vec<f64>,
    apart: usize,
    pixels: usize,
}

impl Differences {
    fn add(&mut self, found: &Frame, truth: &Frame) {
        for (&found, &truth) in found.range.iter().zip(&truth.range) {
            self.pixels += 1;
            match (found.is_finite(), truth.is_finite()) {
                (true, true) => self.errors.push(f64::from((found - truth).abs() / truth)),
                (false, false) => {}
                _ => self.apart += 1,
            }
        }
    }

    /// Median, 99 % and 99.6 % of the errors, and share of the pixels that are apart.
    fn figures(&mut self) -> [f64; 4] {
        let mut at = |share: f64| {
            let index = (self.errors.len() as f64 * share) as usize;
            *self.errors.select_nth_unstable_by(index, f64::total_cmp).1
        };
        [at(0.5), at(0.99), at(0.996), self.apart as f64 / self.pixels as f64]
    }
}

/// What planes and rays see must be within the bounds of a fast engine, over all pixels of 40 poses on each kind of screen.
fn assert_alike(detail: f64, seed: u64) {
    let farm = Farm::new(2).unwrap();
    let options = RenderOptions {
        engine: Engine::Planes,
        detail,
        visibility: f64::INFINITY,
        ..RenderOptions::default()
    };
    let renderer = Renderer::new(&*AREA, &options);
    let mut random = Random(seed);
    let mut failed = Vec::new();

    for name in ["planar", "cylindrical", "equirectangular", "fisheye", "table"] {
        let mut all = Differences::default();
        let mut by_planes = 0;
        for index in 0..POSES {
            let pose = pose(&mut random, index % 2 == 0);
            let camera = Camera::with_screen(pose, screen(name, pose.hfov), SIZE[0], SIZE[1]);
            let found = renderer.frame(&camera, &farm).unwrap().frame;
            let truth = render_reference(&*AREA, &camera, &options, &farm).unwrap().frame;
            all.add(&found, &truth);
            by_planes += usize::from(renderer.engine_for(&camera).unwrap() == Engine::Planes);
        }

        assert_eq!(by_planes, POSES, "{name}");
        assert!(all.errors.len() > all.pixels / 5, "{name}: {} pixels of ground", all.errors.len());
        let figures = all.figures();
        if figures.iter().zip(BOUNDS).any(|(figure, bound)| *figure > bound) {
            failed.push((name, figures));
        }
    }

    assert!(failed.is_empty(), "more than {BOUNDS:?}: {failed:?}");
}

/// Degrees of planar screens, up to where they nearly are half of all around; and those of which every other pose is.
const ALL_FIELDS_OF_VIEW: [f64; 2] = [0.1, 175.0];
const WIDE_FIELDS_OF_VIEW: [f64; 2] = [150.0, 179.0];

/// What [`BOUNDS`] are for all pixels together, for those of one pose: a single crest is a larger share of them.
const POSE_BOUNDS: [f64; 4] = [5e-4, 3e-2, 5e-2, 2e-3];

/// Pixels of ground of one pose, less than which tell nothing.
const LEAST_GROUND: usize = 400;

/// Planar screens of any field of view, pose by pose; `HEDGEHOP_POSES` says how many (default: few), `HEDGEHOP_SEED` which.
#[test]
#[expect(clippy::print_stdout, reason = "the figures are what documents say")]
fn every_field_of_view_is_seen_as_rays_do() {
    let number = |name: &str, default: u64| {
        let stated = std::env::var(name).ok().filter(|value| !value.is_empty());
        stated.map_or(default, |value| value.parse().unwrap_or_else(|_| panic!("{name}: no number: {value}")))
    };
    let poses = number("HEDGEHOP_POSES", 24);
    let farm = Farm::new(2).unwrap();
    let options = RenderOptions { detail: 1.0e3, visibility: f64::INFINITY, ..RenderOptions::default() };
    let renderer = Renderer::new(&*AREA, &options);
    let mut random = Random(number("HEDGEHOP_SEED", 3));
    let (mut all, mut off, mut by_planes) = (Differences::default(), Vec::new(), 0);

    for index in 0..poses {
        let mut pose = pose(&mut random, index % 4 < 2);
        pose.hfov = match index % 2 {
            0 => of_any_size(&mut random, ALL_FIELDS_OF_VIEW),
            _ => random.between(WIDE_FIELDS_OF_VIEW),
        };
        let camera = Camera::new(pose, SIZE[0], SIZE[1]);
        let found = renderer.frame(&camera, &farm).unwrap().frame;
        let truth = render_reference(&*AREA, &camera, &options, &farm).unwrap().frame;
        by_planes += u64::from(renderer.engine_for(&camera).unwrap() == Engine::Planes);
        all.add(&found, &truth);

        let mut own = Differences::default();
        own.add(&found, &truth);
        let figures = if own.errors.len() < LEAST_GROUND { [0.0; 4] } else { own.figures() };
        if figures.iter().zip(POSE_BOUNDS).any(|(figure, bound)| *figure > bound) {
            off.push(format!("{figures:?}: {index}: {pose:?}"));
        }
    }

    let figures = all.figures();
    println!("{poses} poses, {by_planes} by planes, {} off, all together {figures:?}", off.len());
    assert!(off.is_empty(), "more than {POSE_BOUNDS:?}:\n{}", off.join("\n"));
    assert!(figures.iter().zip(BOUNDS).all(|(figure, bound)| *figure <= bound), "{figures:?}");
}

#[test]
fn planes_see_the_finest_surface_as_rays_do() {
    assert_alike(1.0e3, 1);
}

/// Levels change at the same places for both.
#[test]
fn planes_see_coarse_levels_as_rays_do() {
    assert_alike(1.0, 2);
}

/// A slope with ridges of one post, along both axes and across: what is near the eye there has creases and crests within cells.
static RIDGES: LazyLock<MemPages> = LazyLock::new(|| {
    let side = 96;
    let grid = Grid { nx: side, ny: side, spacing: 30.0, origin: DVec2::ZERO };
    let posts = (0..side * side).map(|post| (post % side, post / side));
    let is_ridge = |x: u32, y: u32| x == 48 || y == 48 || x == y;
    let height = |(x, y): (u32, u32)| f64::from(x) * 9.0 + if is_ridge(x, y) { 100.0 } else { 0.0 };
    let heights: Vec<f64> = posts.map(height).collect();
    build_in_memory(grid, &heights, &vec![[128; 3]; heights.len()], None, &Metadata::default()).unwrap()
});

#[test]
fn crests_beside_the_eye_stand_where_rays_meet_them() {
    let farm = Farm::new(2).unwrap();
    let options = RenderOptions { detail: 1.0e3, visibility: f64::INFINITY, ..RenderOptions::default() };
    let renderer = Renderer::new(&*RIDGES, &options);
    let mut all = Differences::default();
    for index in 0..48 {
        // On a slope of 0.3, from 1 m above it.
        let place = DVec2::new(1290.0 + 11.0 * f64::from(index % 7), 1580.0 + 13.0 * f64::from(index % 5));
        let eye = place.extend(0.3 * place.x + 1.0 + f64::from(index % 3) * 12.0);
        let attitude =
            Attitude { yaw: f64::from(index) * 45.0, pitch: f64::from(index % 4) * 10.0, roll: 0.0 };
        let camera = Camera::new(Pose { eye, attitude, hfov: 60.0 }, SIZE[0], SIZE[1]);
        let found = renderer.frame(&camera, &farm).unwrap().frame;
        all.add(&found, &render_reference(&*RIDGES, &camera, &options, &farm).unwrap().frame);
    }
    let figures = all.figures();
    assert!(figures.iter().zip(BOUNDS).all(|(figure, bound)| *figure <= bound), "{figures:?}");
}

#[test]
fn what_needs_too_many_planes_is_left_to_the_reference() {
    let renderer = Renderer::new(&*AREA, &RenderOptions::default());
    let by = |screen: Screen, [width, height]: [u32; 2]| {
        let pose = Pose { eye: DVec3::new(0.0, 0.0, 900.0), attitude: Attitude::default(), hfov: 60.0 };
        renderer.engine_for(&Camera::with_screen(pose, screen, width, height)).unwrap()
    };
    let planar = Screen::Planar { hfov: 60.0 };
    assert_eq!(by(planar.clone(), [8192, 8192]), Engine::Planes);
    assert_eq!(by(planar, [20_000, 20_000]), Engine::Reference);
    let narrow = RayTable::of_screen(&Screen::Planar { hfov: 2.0 }, 64, 64).unwrap();
    let mut directions: Vec<[f32; 3]> = narrow.directions().iter().map(|it| it.to_array()).collect();
    assert_eq!(by(Screen::Table(Arc::new(narrow)), [64, 64]), Engine::Planes);
    directions[777] = [0.0, 0.0, -1.0];
    let stray = RayTable::new(64, 64, directions).unwrap();
    assert_eq!(by(Screen::Table(Arc::new(stray)), [64, 64]), Engine::Reference);
}

/// A pixel whose ray goes straight up, or down, to the last bit, where there is no next row.
#[test]
fn pixels_at_the_poles_are_seen() {
    let farm = Farm::new(1).unwrap();
    // Between posts light is even.
    let options = RenderOptions { engine: Engine::Planes, detail_synthesis: 0.0, ..RenderOptions::default() };
    let renderer = Renderer::new(&*AREA, &options);
    let corner = AREA.header().grid.origin;
    for (pitch, sees_sky) in [(90.0, true), (-90.0, false)] {
        let attitude = Attitude { yaw: 0.0, pitch, roll: 0.0 };
        let eye = (corner + DVec2::splat(2500.0)).extend(600.0);
        let camera = Camera::new(Pose { eye, attitude, hfov: 60.0 }, 97, 61);
        let frame = renderer.frame(&camera, &farm).unwrap().frame;
        assert!(frame.range.iter().all(|range| range.is_infinite() == sees_sky), "{pitch}°");
        let [middle, beside] =
            [30 * 97 + 48, 30 * 97 + 49].map(|pixel| DVec3::from(frame.colour[pixel].map(f64::from)));
        assert!((middle - beside).length() < 0.1 * beside.length(), "{pitch}°: {middle} beside {beside}");
    }
}
