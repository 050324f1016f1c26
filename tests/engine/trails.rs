//! Trails in whole frames: hidden where a line of sight is, of the same width near and far, no surfaces, the same bits whoever renders.

use std::sync::{Arc, LazyLock};

use glam::{DVec2, DVec3, Vec3};

use crate::scene::{ORIGIN, Terrain, View, clear_air};
use hedgehop::earth::Curvature;
use hedgehop::frame::Frame;
use hedgehop::objects::{Body, ColourRamp, Ribbon, RibbonLine, RibbonSample, Shape};
use hedgehop::raymarch::ground_height;
use hedgehop::render::{Engine, Exposure, Moment, Overlays, RenderOptions, Renderer};
use hedgehop::scene::{Finish, Scenery};
use hedgehop::space::{Attitude, Camera, RayTable, Screen};
use hedgehop::subimage::{Farm, TaskSize};
use hedgehop::voxel::MemPages;
use hedgehop::weather::{Clouds, Puff, Weather};

/// Ridges across the view, and a hill before them.
static RIDGES: LazyLock<MemPages> = LazyLock::new(|| {
    let hill = |post: DVec2| 160.0 * (-(post - DVec2::new(1180.0, 900.0)).length_squared() / 9.0e4).exp();
    let ridges = |post: DVec2| 70.0 * (post.y / 190.0).sin() + 12.0 * (post.x / 130.0).sin();
    Terrain::new([512, 512], 5.0, |post| 100.0 + hill(post) + ridges(post), |_| [60, 80, 50]).in_memory()
});
static FARM: LazyLock<Farm> = LazyLock::new(|| Farm::new(2).unwrap());

const VIEW: View =
    View { eye: DVec3::new(1280.0, 150.0, 330.0), ypr: [0.0, -6.0, 0.0], hfov: 60.0, size: [320, 180] };

fn options(engine: Engine) -> RenderOptions {
    // Levels as fine as the line of sight's own.
    RenderOptions { engine, detail: 4.0, ..clear_air() }
}

/// A way through places east and north of the area's corner, and above the datum.
fn ribbon(places: impl IntoIterator<Item = DVec3>, value: impl Fn(f64) -> f32) -> Ribbon {
    let sample = |(index, place): (u32, DVec3)| {
        let time = f64::from(index);
        RibbonSample { time, position: place + ORIGIN.extend(0.0), value: value(time) }
    };
    let samples: Vec<_> = (0..).zip(places).map(sample).collect();
    let span = [0.0, samples.len() as f64 - 1.0];
    let ramp = Arc::new(ColourRamp::new(vec![Vec3::new(1.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 0.0)]));
    Ribbon { line: Arc::new(RibbonLine::new(samples)), span, ramp, width: 3.0, outline: 1.0 }
}

/// A climb in circles away from the eye, behind the hill and into the ridges.
fn flown(turn: f64) -> DVec3 {
    let (sine, cosine) = turn.sin_cos();
    DVec3::new(1230.0 + 120.0 * sine, 700.0 + 25.0 * turn + 120.0 * cosine, 150.0 + 4.0 * turn)
}

fn climb() -> Ribbon {
    ribbon((0..1200_u32).map(|step| flown(0.04 * f64::from(step))), |time| (time / 1200.0) as f32)
}

fn frame(renderer: &Renderer<'_>, camera: &Camera, trails: &[Ribbon]) -> Frame {
    let overlays = Overlays { trails, ..Overlays::default() };
    renderer.frame_with(camera, overlays, &FARM).unwrap().frame
}

/// Change of each pixel's light by trails.
fn changes(renderer: &Renderer<'_>, camera: &Camera, trails: &[Ribbon]) -> Vec<f32> {
    let [with, without] = [trails, &[]].map(|trails| frame(renderer, camera, trails).colour);
    let change = |(one, other): (&[f32; 3], &[f32; 3])| (Vec3::from(*one) - Vec3::from(*other)).length();
    with.iter().zip(&without).map(change).collect()
}

/// Whether the line from an eye to a place is above the ground all along, by steps of a metre.
fn is_in_sight(eye: DVec3, place: DVec3, curvature: Curvature) -> bool {
    let way = place - eye;
    let count = way.length() as u32;
    (1..count).all(|step| {
        let at = eye + way * (f64::from(step) / f64::from(count));
        let drop = curvature.drop_at((at - eye).truncate().length());
        ground_height(&*RIDGES, at.truncate()).unwrap().is_none_or(|ground| ground - drop < at.z)
    })
}

fn screens(size: [u32; 2]) -> Vec<Camera> {
    let pose = VIEW.camera().pose;
    let [width, height] = size;
    let banked = View { ypr: [4.0, -8.0, 35.0], size, ..VIEW }.camera();
    let screen = |screen| Camera::with_screen(pose, screen, width, height);
    let table = Arc::new(RayTable::of_screen(&Screen::Fisheye { fov: 60.0 }, width, height).unwrap());
    vec![
        View { size, ..VIEW }.camera(),
        banked,
        screen(Screen::Cylindrical { hfov: 90.0 }),
        screen(Screen::Equirectangular { hfov: 90.0, vfov: 50.0 }),
        screen(Screen::Fisheye { fov: 70.0 }),
        screen(Screen::Lens { hfov: 60.0, k: [-0.1, 0.02] }),
        screen(Screen::Table(table)),
    ]
}

/// A place of the trail, and whether an eye sees it.
struct SightedPlace {
    place: DVec3,
    is_seen: bool,
    /// Whether it would be hidden three pixels higher, too: a trail that runs along the ground is seen, though it is a little below.
    is_hidden: bool,
}

#[test]
fn trails_end_where_the_line_of_sight_does() {
    let curvature = Curvature { inverse_diameter: 1.0e-5 };
    let (eye, pixel) = (VIEW.camera().pose.eye, VIEW.camera().pixel_angle());
    let sighted = |step: u32| {
        // A line of sight bends with the ground.
        let place = flown(0.04 * f64::from(step)) + ORIGIN.extend(0.0);
        let place = place - DVec3::Z * curvature.drop_at((place - eye).truncate().length());
        let above = place + DVec3::Z * (3.0 * pixel * (place - eye).length());
        let is_seen = is_in_sight(eye, place, curvature);
        SightedPlace { place, is_seen, is_hidden: !is_seen && !is_in_sight(eye, above, curvature) }
    };
    let all: Vec<_> = (0..1200).map(sighted).collect();

    for (number, camera) in screens([320, 180]).iter().enumerate() {
        // A table has no inverse; the screen that it is of has.
        let twin = Camera::with_screen(camera.pose, Screen::Fisheye { fov: 60.0 }, 320, 180);
        let is_table = matches!(camera.screen(), Screen::Table(_));
        let position = |place: DVec3| if is_table { &twin } else { camera }.screen_from_world(place);
        let shown: Vec<(DVec2, &SightedPlace)> =
            all.iter().filter_map(|one| Some((position(one.place)?, one))).collect();

        let engine = if number == 1 { Engine::Reference } else { Engine::Planes };
        let options = RenderOptions { curvature, ..options(engine) };
        let changes = changes(&Renderer::new(&*RIDGES, &options), camera, &[climb()]);

        // Only places count whose neighbours are all seen, or all hidden.
        let (mut seen, mut hidden) = (0, 0);
        for (at, one) in &shown {
            let near = |within: f64| {
                shown.iter().filter(move |(other, _)| (other - at).length() < within).map(|(_, other)| other)
            };
            if at.cmplt(DVec2::ZERO).any() || at.x >= 320.0 || at.y >= 180.0 {
                continue;
            }
            let change = changes[at.y as usize * 320 + at.x as usize];
            if one.is_seen && near(1.5).all(|other| other.is_seen) {
                assert!(change > 0.2, "screen {number}: nothing at {at}");
                seen += 1;
            } else if one.is_hidden && near(4.5).all(|other| other.is_hidden) {
                assert_eq!(change, 0.0, "screen {number}: something at {at}");
                hidden += 1;
            }
        }
        assert!(seen > 60 && hidden > 20, "screen {number}: {seen} seen, {hidden} hidden");
    }
}

/// Light that a trail adds to the columns of a sky, as many pixels wide as that is.
fn width(camera: &Camera, trail: &Ribbon, columns: std::ops::Range<usize>) -> f64 {
    let renderer = Renderer::new(&*RIDGES, &options(Engine::Planes));
    let [with, without] = [std::slice::from_ref(trail), &[]].map(|trails| frame(&renderer, camera, trails));
    let share = |pixel: usize| {
        // Red is hidden by the trail alone, which has none.
        1.0 - f64::from(with.colour[pixel][2] / without.colour[pixel][2])
    };
    let count = columns.len() as f64;
    (0..180).flat_map(|row| columns.clone().map(move |column| row * 320 + column)).map(share).sum::<f64>()
        / count
}

#[test]
fn widths_are_the_same_near_and_far_and_wherever_between_pixels() {
    let camera = View { ypr: [0.0, 25.0, 0.0], ..VIEW }.camera();
    for (distance, shift) in [(60.0, 0.0), (60.0, 0.03), (600.0, 0.1), (600.0, 0.45), (4.0e4, 9.0)] {
        let place = |step: u32| {
            DVec3::new(
                1280.0 + distance * (0.1 * f64::from(step) - 2.0),
                150.0 + distance,
                330.0 + 0.5 * distance + shift,
            )
        };
        let level = Ribbon { outline: 0.0, ..ribbon((0..40).map(place), |_| 0.0) };
        let found = width(&camera, &level, 100..220);
        assert!((found - 3.0).abs() < 0.02, "{distance} m: {found} pixels");
        let thin = Ribbon { width: 0.4, ..level };
        let found = width(&camera, &thin, 100..220);
        assert!((found - 0.4).abs() < 0.02, "{distance} m: {found} pixels");
    }
}

#[test]
fn several_rays_a_pixel_keep_the_width() {
    let camera = View { ypr: [0.0, 25.0, 0.0], ..VIEW }.camera();
    let place = |step: u32| DVec3::new(1080.0 + 10.0 * f64::from(step), 750.0, 640.0);
    let trails = vec![Ribbon { outline: 0.0, ..ribbon((0..40).map(place), |_| 0.0) }];
    let moment = |trails: Vec<Ribbon>| Moment {
        camera: camera.clone(),
        scenery: Scenery { trails, ..Scenery::default() },
        seconds: 0.0,
    };
    let light = |antialias: u32, trails: &[Ribbon]| {
        let finish = Finish { antialias, ..Finish::default() };
        let moment = |_: f64| moment(trails.to_vec());
        let exposure = Exposure { finish: &finish, interval: 0.1, moment: &moment };
        let options = options(Engine::Planes);
        let frame = Renderer::new(&*RIDGES, &options).exposed(&exposure, &FARM).unwrap().frame;
        frame.colour.iter().map(|colour| f64::from(colour[2])).sum::<f64>()
    };
    let missing = |antialias: u32| light(antialias, &[]) - light(antialias, &trails);
    let [one, four] = [1, 4].map(missing);
    assert!((four / one - 1.0).abs() < 0.02, "{one} {four}");
}

fn cloudy() -> RenderOptions {
    let clouds = Clouds {
        base: 700.0,
        top: 1000.0,
        coverage: 0.5,
        visibility: 150.0,
        scale: 800.0,
        seed: 2,
        wind: [0.0, 0.0],
    };
    let weather = Weather { clouds: Some(clouds), ..Weather::default() };
    RenderOptions { weather, visibility: 20_000.0, ..options(Engine::Planes) }
}

/// A pillar on the way.
fn pillar() -> [Body; 1] {
    [Body {
        id: 3,
        form: Shape::Cylinder { radius: 12.0, height: 300.0 }.into(),
        position: DVec3::new(1200.0, 620.0, 60.0) + ORIGIN.extend(0.0),
        attitude: Attitude::default(),
        albedo: Vec3::splat(0.4),
        priority: 0,
    }]
}

fn smoke() -> [Puff; 1] {
    let centre = DVec3::new(1300.0, 500.0, 220.0) + ORIGIN.extend(0.0);
    [Puff { centre, radius: 20.0, depth: 0.8, albedo: Vec3::splat(0.5) }]
}

#[test]
fn trails_are_no_surfaces_and_frames_and_pictures_show_the_same() {
    let camera = VIEW.camera();
    let (trails, bodies, puffs) = ([climb()], pillar(), smoke());
    for options in [options(Engine::Planes), RenderOptions { matte: true, ..cloudy() }] {
        let renderer = Renderer::new(&*RIDGES, &options);
        let bare = Overlays { bodies: &bodies, puffs: &puffs, ..Overlays::default() };
        let all = Overlays { trails: &trails, ..bare };
        let [with, without] =
            [all, bare].map(|overlays| renderer.frame_with(&camera, overlays, &FARM).unwrap().frame);
        assert!(with.colour != without.colour);
        assert!(with.range == without.range && with.id == without.id && with.normal == without.normal);
        assert!(with.aov.matte == without.aov.matte);

        let (picture, _) = renderer.picture_with(&camera, all, &FARM).unwrap();
        let codes = hedgehop::colour::srgb8_picture(&with.colour);
        let off = picture.rgb.iter().zip(&codes).map(|(one, other)| one.abs_diff(*other));
        let far = off.filter(|off| *off > 3).count();
        assert!(far * 2000 < codes.len(), "{far} codes");
    }
}

#[test]
fn neither_workers_nor_tasks_nor_company_change_a_byte() {
    let other =
        ribbon((0..50_u32).map(|step| DVec3::new(900.0 + 16.0 * f64::from(step), 640.0, 260.0)), |_| 1.0);
    let trails = [climb(), other];
    for camera in screens([96, 54]) {
        let renderer = Renderer::new(&*RIDGES, &cloudy());
        let see = |farm: &Farm| {
            let overlays = Overlays { trails: &trails, ..Overlays::default() };
            renderer.picture_with(&camera, overlays, farm).unwrap().0.rgb
        };
        let expected = see(&Farm::new(1).unwrap());
        for (workers, lines, rows) in [(3, 16, 5), (2, 48, 64)] {
            let farm = Farm::new(workers).unwrap().with_task_size(TaskSize { lines, rows });
            assert!(see(&farm) == expected, "{:?}: {workers} workers", camera.screen());
        }
    }
}

#[test]
fn a_screen_all_around_has_no_seam() {
    // Turned by whole pixels it shows the same columns elsewhere.
    let around = |step: u32| {
        let (sine, cosine) = (0.1 * f64::from(step)).sin_cos();
        DVec3::new(1280.0 + 80.0 * sine, 150.0 + 80.0 * cosine, 330.0 + 30.0 * (0.3 * f64::from(step)).sin())
    };
    let trails = [ribbon((0..64).map(around), |_| 0.5)];
    let renderer = Renderer::new(&*RIDGES, &options(Engine::Reference));
    let turned = |yaw: f64| {
        let pose = View { ypr: [yaw, 0.0, 0.0], ..VIEW }.camera().pose;
        let camera = Camera::with_screen(pose, Screen::Equirectangular { hfov: 360.0, vfov: 90.0 }, 160, 80);
        changes(&renderer, &camera, &trails)
    };
    let (ahead, back) = (turned(0.0), turned(180.0));
    for row in 0..80 {
        for column in 0..160 {
            let [one, other] = [ahead[row * 160 + column], back[row * 160 + (column + 80) % 160]];
            assert!((one - other).abs() < 0.02, "{column}, {row}: {one} {other}");
        }
    }
}
