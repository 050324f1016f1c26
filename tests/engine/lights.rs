//! Lamps and stars in whole frames: as bright as their light is at the eye, hidden by what stands before them, the same bits whoever renders.

use std::sync::{Arc, LazyLock};

use glam::{DVec2, DVec3, Vec3};

use crate::scene::{Terrain, View, clear_air};
use hedgehop::frame::Frame;
use hedgehop::objects::{Beam, Body, Fixture, PointLight, Shape};
use hedgehop::render::{Engine, Overlays, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, RayTable, Screen};
use hedgehop::subimage::{Farm, TaskSize};
use hedgehop::sunlight::{Firmament, Night, Sun, illuminance};
use hedgehop::voxel::MemPages;
use hedgehop::weather::{Clouds, Weather};

static PLAIN: LazyLock<MemPages> =
    LazyLock::new(|| Terrain::new([256, 256], 20.0, |_| 100.0, |_| [90, 110, 70]).in_memory());
static FARM: LazyLock<Farm> = LazyLock::new(|| Farm::new(2).unwrap());

const NIGHT: Sun = Sun { azimuth: 200.0, elevation: -20.0 };
const LUX: f64 = 0.1;

fn options() -> RenderOptions {
    RenderOptions { sun: NIGHT, night: Night { lux: LUX, stars: None }, ..clear_air() }
}

/// An eye 120 m above the plain that looks north.
const VIEW: View =
    View { eye: DVec3::new(2000.0, 300.0, 220.0), ypr: [0.0, 0.0, 0.0], hfov: 60.0, size: [320, 180] };

fn lamp(east: f64, north: f64, up: f64, candela: f64) -> PointLight {
    let beams = vec![Beam { candela, colour: Vec3::ONE, cone: None, below: None }];
    let fixture = Arc::new(Fixture { radius: 0.0, beams });
    let position = DVec3::new(500_000.0 + east, 4_000_000.0 + north, up);
    PointLight { position, attitude: Attitude::default(), fixture, level: 1.0 }
}

fn frame(options: &RenderOptions, camera: &Camera, bodies: &[Body], lights: &[PointLight]) -> Frame {
    Renderer::new(&*PLAIN, options)
        .frame_with(camera, Overlays { bodies, lights, ..Overlays::default() }, &FARM)
        .unwrap()
        .frame
}

/// Light that lamps add to a frame, summed over its pixels.
fn added(options: &RenderOptions, camera: &Camera, bodies: &[Body], lights: &[PointLight]) -> Vec3 {
    let [with, without] = [lights, &[]].map(|lights| frame(options, camera, bodies, lights).colour);
    with.iter().zip(&without).map(|(with, without)| Vec3::from(*with) - Vec3::from(*without)).sum()
}

#[test]
fn a_lamp_is_as_bright_as_the_square_of_its_distance_and_the_air_leave_it() {
    let camera = VIEW.camera();
    // Luminance that white ground has under the night's light, and how bright a picture shows it.
    let lux = illuminance(NIGHT.elevation) + LUX;
    let per_luminance = f64::from(options().brightness().per_luminance());
    let white = (lux / (illuminance(10.0) + LUX)).powf(0.27);
    assert!((per_luminance * lux / std::f64::consts::PI / white - 1.0).abs() < 1e-5);

    for visibility in [f64::INFINITY, 8000.0, 2500.0] {
        for distance in [400.0, 1500.0, 4000.0] {
            let options = RenderOptions { visibility, ..options() };
            let lamp = lamp(2000.0, 300.0 + distance, 220.0, 300.0);
            let sum = f64::from(added(&options, &camera, &[], &[lamp]).x);
            // At the middle of a planar screen a pixel is one over the focal length wide; haze thins by the height above its base.
            let depth = -(0.05_f64.ln()) / visibility * distance * (-120.0_f64 / 2000.0).exp();
            let expected =
                300.0 / (distance * distance) * camera.focal_px().powi(2) * per_luminance * (-depth).exp();
            assert!(
                (sum / expected - 1.0).abs() < 0.04,
                "{visibility} m, {distance} m: {sum}, not {expected}"
            );
        }
    }
}

/// A post: where it stands, metres east and north of the area's corner, and how wide it is.
fn post([east, north]: [f64; 2], width: f64) -> [Body; 1] {
    [Body {
        id: 0,
        form: Shape::Box { size: DVec3::new(width, 1.0, 400.0) }.into(),
        position: DVec3::new(500_000.0 + east, 4_000_000.0 + north, 100.0),
        attitude: Attitude::default(),
        albedo: Vec3::splat(0.5),
        priority: 0,
    }]
}

/// What another channel shows tells whether the glare of a lamp that this one does not show is seen here.
#[test]
fn lamps_beside_the_screen_are_hidden_by_what_stands_before_them_alone() {
    let camera = VIEW.camera();
    let beside = [lamp(2586.0, 1300.0, 101.0, 1.0e6)];
    // The lamp's light alone: that of the pixels which no post covers.
    let glare = |bodies: &[Body]| {
        let [with, without] = [&beside[..], &[]].map(|lights| frame(&options(), &camera, bodies, lights));
        let column = |frame: &Frame| (0..180).map(|row| frame.colour[row * 320 + 316][0]).sum::<f32>();
        column(&with) - column(&without)
    };
    let free = glare(&[]);
    assert!(free > 0.5, "{free}");
    // It stands at the screen's edge, 2 pixels from the line to the lamp.
    let at_the_edge = glare(&post([2172.1, 600.0], 2.1));
    assert!((at_the_edge - free).abs() < 1e-3 * free, "{at_the_edge}, not {free}");
    // Beside the screen, before the lamp.
    assert_eq!(glare(&post([2293.0, 800.0], 6.0)), 0.0);
}

#[test]
fn lamps_are_hidden_by_ground_and_bodies_before_them_and_no_others() {
    let camera = VIEW.camera();
    let seen = |lamp: PointLight, bodies: &[Body]| added(&options(), &camera, bodies, &[lamp]).x;
    let wall = Body {
        id: 0,
        form: Shape::Box { size: DVec3::new(60.0, 10.0, 400.0) }.into(),
        position: DVec3::new(502_000.0, 4_001_000.0, 100.0),
        attitude: Attitude::default(),
        albedo: Vec3::splat(0.5),
        priority: 0,
    };

    let bright = seen(lamp(2000.0, 1300.0, 101.0, 1000.0), &[]);
    assert!(bright > 0.1, "{bright}");
    assert_eq!(seen(lamp(2000.0, 1300.0, 101.0, 1000.0), std::slice::from_ref(&wall)), 0.0);

    // In front of the wall, and beside it.
    assert!(seen(lamp(2000.0, 960.0, 101.0, 1000.0), std::slice::from_ref(&wall)) > bright);
    assert!(seen(lamp(2100.0, 1300.0, 101.0, 1000.0), std::slice::from_ref(&wall)) > 0.9 * bright);

    // Under the ground, and behind the eye.
    assert_eq!(seen(lamp(2000.0, 1300.0, 40.0, 1000.0), &[]), 0.0);
    assert_eq!(seen(lamp(2000.0, -500.0, 220.0, 1.0e6), &[]), 0.0);

    // On the ground at all distances.
    for north in [600.0, 1500.0, 2500.0, 4000.0, 4800.0] {
        assert!(seen(lamp(2050.0, north, 100.0, 1.0e5), &[]) > 0.0, "{north}");
    }
}

fn crowd() -> Vec<PointLight> {
    let place = |index: u32| {
        let (column, row) = (f64::from(index % 20), f64::from(index / 20));
        lamp(1200.0 + 80.0 * column, 700.0 + 170.0 * row, 101.0, 40.0 + 10.0 * row)
    };
    (0..400).map(place).collect()
}

fn starry() -> RenderOptions {
    let night = Night { lux: LUX, stars: Some(Firmament::default()) };
    let clouds = Clouds {
        base: 900.0,
        top: 1200.0,
        coverage: 0.4,
        visibility: 150.0,
        scale: 1000.0,
        seed: 2,
        wind: [0.0, 0.0],
    };
    let weather = Weather { clouds: Some(clouds), ..Weather::default() };
    RenderOptions { night, weather, visibility: 20_000.0, ..options() }
}

#[test]
fn neither_order_nor_workers_nor_tasks_change_a_byte() {
    let lights = crowd();
    let mut turned = lights.clone();
    turned.reverse();
    turned.rotate_left(77);
    let table = Arc::new(RayTable::of_screen(&Screen::Planar { hfov: 60.0 }, 90, 60).unwrap());
    let pose = VIEW.camera().pose;

    for screen in [
        Screen::Planar { hfov: 60.0 },
        Screen::Fisheye { fov: 190.0 },
        Screen::Cylindrical { hfov: 170.0 },
        Screen::Table(table),
    ] {
        let camera = Camera::with_screen(pose, screen, 90, 60);
        let renderer = Renderer::new(&*PLAIN, &starry());
        let see = |lights: &[PointLight], farm: &Farm| {
            let things = Overlays { lights, ..Overlays::default() };
            let (picture, _) = renderer.picture_with(&camera, things, farm).unwrap();
            (picture.rgb, renderer.frame_with(&camera, things, farm).unwrap().frame.colour)
        };
        let expected = see(&lights, &Farm::new(1).unwrap());
        assert!(see(&[], &FARM) != expected, "no lamp is seen");
        for (workers, lines, rows) in [(3, 16, 5), (2, 48, 64)] {
            let farm = Farm::new(workers).unwrap().with_task_size(TaskSize { lines, rows });
            assert!(see(&turned, &farm) == expected, "{workers} workers");
        }
    }
}

#[test]
fn engines_screens_and_outputs_agree() {
    let camera = VIEW.camera();
    let lights = crowd();
    let things = Overlays { lights: &lights, ..Overlays::default() };

    let see = |engine, camera: &Camera| {
        let renderer = Renderer::new(&*PLAIN, &RenderOptions { engine, ..options() });
        (
            renderer.frame_with(camera, things, &FARM).unwrap().frame.colour,
            renderer.picture_with(camera, things, &FARM).unwrap().0.rgb,
        )
    };

    let (planes, picture) = see(Engine::Planes, &camera);
    let (reference, _) = see(Engine::Reference, &camera);
    let sum = |colours: &[[f32; 3]]| colours.iter().map(|colour| f64::from(colour[1])).sum::<f64>();
    assert!((sum(&planes) / sum(&reference) - 1.0).abs() < 0.01);

    // What is not brighter than white is the same in a picture.
    let codes = hedgehop::colour::srgb8_picture(&planes);
    let dim = planes.iter().map(|colour| Vec3::from(*colour).max_element() < 0.98);
    let far = picture.as_chunks::<3>().0.iter().zip(codes.as_chunks::<3>().0).zip(dim);
    let worst =
        far.filter(|(_, dim)| *dim).flat_map(|((a, b), _)| (0..3).map(|at| a[at].abs_diff(b[at]))).max();
    assert!(worst.unwrap() <= 3, "{worst:?}");

    // A table of the same rays shows the same, but for what lies between its directions.
    let table = Arc::new(RayTable::of_screen(&Screen::Planar { hfov: 60.0 }, 320, 180).unwrap());
    let (by_table, _) =
        see(Engine::Reference, &Camera::with_screen(camera.pose, Screen::Table(table), 320, 180));
    assert!((sum(&by_table) / sum(&reference) - 1.0).abs() < 0.02);
}

#[test]
fn channels_that_abut_show_a_lamp_between_them_once() {
    let wide = VIEW.camera();
    let lights: Vec<_> =
        (0..9).map(|step| lamp(2000.0 + 0.9 * f64::from(step), 1300.0, 210.0, 60.0)).collect();

    let turned = |yaw: f64| {
        let channel = Attitude { yaw, ..Attitude::default() };
        let screen = Screen::Cylindrical { hfov: 30.0 };
        let camera = Camera::with_channel(wide.pose, channel, screen, 160, 180);
        frame(&options(), &camera, &[], &lights).colour
    };
    let both = Camera::with_screen(wide.pose, Screen::Cylindrical { hfov: 60.0 }, 320, 180);
    let both = frame(&options(), &both, &[], &lights).colour;
    let (left, right) = (turned(-15.0), turned(15.0));
    let mut worst: f32 = 0.0;

    for row in 0..180 {
        for column in 0..320 {
            let part = if column < 160 { left[row * 160 + column] } else { right[row * 160 + column - 160] };
            let whole = both[row * 320 + column];
            worst = worst.max((Vec3::from(part) - Vec3::from(whole)).abs().max_element());
        }
    }

    assert!(worst < 2.0e-3, "{worst}");
}

#[test]
fn stars_stand_in_the_sky_at_night_only() {
    let up = View { ypr: [0.0, 35.0, 0.0], ..VIEW }.camera();
    let count = |options: &RenderOptions| {
        let dark = RenderOptions { night: Night { stars: None, ..options.night }, ..*options };
        let [with, without] = [options, &dark].map(|options| frame(options, &up, &[], &[]).colour);
        with.iter().zip(&without).filter(|(with, without)| with != without).count()
    };
    let clear = RenderOptions { weather: Weather::default(), visibility: f64::INFINITY, ..starry() };
    let many = count(&clear);
    assert!(many > 300, "{many}");
    assert!(count(&RenderOptions { visibility: 800.0, ..clear }) < many / 4);
    assert_eq!(count(&RenderOptions { sun: Sun { elevation: 20.0, ..NIGHT }, ..clear }), 0);
    // Ground hides them.
    let down = View { ypr: [0.0, -60.0, 0.0], ..VIEW }.camera();
    let [with, without] = [&clear, &options()].map(|options| frame(options, &down, &[], &[]).colour);
    assert_eq!(with, without);
}

#[test]
fn ground_far_away_still_meets_the_sky_at_night() {
    let source = Terrain::new([128, 128], 4000.0, |_| 100.0, |_| [60, 90, 40]).in_memory();
    let eye = DVec2::new(256_000.0, 2000.0).extend(300.0);
    let camera = View { eye, ypr: [0.0, 0.0, 0.0], hfov: 3.0, size: [64, 200] }.camera();
    for elevation in [-3.0, -9.0, -20.0] {
        let options = RenderOptions { sun: Sun { elevation, ..NIGHT }, visibility: 15_000.0, ..options() };
        let picture = Renderer::new(&source, &options).picture(&camera, &FARM).unwrap().0;
        let row = |row: usize| &picture.rgb[row * 64 * 3..][..3];
        let brightest = *row(99).iter().max().unwrap();
        assert!(brightest > 4, "{elevation}: {brightest}");
        for below in 90..110 {
            let step = row(below).iter().zip(row(below + 1)).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(step <= 2, "{elevation}, row {below}: {step}");
        }
    }
}
