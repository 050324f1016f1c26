//! Weather in whole frames: the same bits whoever renders, the same light from both engines and in both outputs, no step at the horizon.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::scene::{Terrain, View, clear_air};
use hedgehop::colour::srgb8_picture;
use hedgehop::objects::{Body, Shape};
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, RayTable, Screen};
use hedgehop::subimage::{Farm, TaskSize};
use hedgehop::sunlight::Sun;
use hedgehop::voxel::MemPages;
use hedgehop::weather::{Clouds, Fog, GroundCover, Precipitation, PrecipitationKind, Weather};

const FOG: Fog = Fog { top: 190.0, visibility: 400.0, soft: 30.0 };

const CLOUDS: Clouds = Clouds {
    base: 600.0,
    top: 900.0,
    coverage: 0.6,
    visibility: 150.0,
    scale: 1000.0,
    seed: 2,
    wind: [12.0, -4.0],
};

const ALL: Weather = Weather {
    glow: 1.0,
    fog: Some(FOG),
    clouds: Some(CLOUDS),
    precipitation: None,
    ground: GroundCover { wet: 0.0, snow: 0.0 },
};

fn hills() -> MemPages {
    let height = |post: DVec2| 150.0 + 60.0 * (post.x / 300.0).sin() * (post.y / 240.0).cos();
    let colour = |post: DVec2| [90, 120 + (post.x / 50.0) as u8 % 40, 60];
    Terrain::new([256, 256], 10.0, height, colour).in_memory()
}

fn options(engine: Engine, weather: Weather) -> RenderOptions {
    let sun = Sun { azimuth: 60.0, elevation: 20.0 };
    RenderOptions { engine, weather, sun, visibility: 15_000.0, ..clear_air() }
}

fn view(height: f64, ypr: [f64; 3], size: [u32; 2]) -> Camera {
    View { eye: DVec3::new(1300.0, 400.0, height), ypr, hfov: 60.0, size }.camera()
}

fn bodies() -> [Body; 1] {
    let position = DVec3::new(500_000.0 + 1500.0, 4_000_000.0 + 1400.0, 250.0);
    let shape = Shape::Ellipsoid { radii: DVec3::splat(120.0) };
    [Body {
        id: 0,
        form: shape.into(),
        position,
        attitude: Attitude::default(),
        albedo: glam::Vec3::splat(0.5),
        priority: 0,
    }]
}

#[test]
fn workers_tasks_and_time_decide_as_they_should() {
    let source = hills();
    let table = Arc::new(RayTable::of_screen(&Screen::Planar { hfov: 60.0 }, 50, 40).unwrap());
    let pose = view(700.0, [20.0, -10.0, 8.0], [1, 1]).pose;

    let cameras = [
        view(300.0, [20.0, 5.0, 0.0], [131, 77]),
        view(700.0, [20.0, -10.0, 8.0], [131, 77]),
        Camera::with_screen(pose, Screen::Fisheye { fov: 200.0 }, 90, 90),
        Camera::with_screen(pose, Screen::Cylindrical { hfov: 200.0 }, 120, 50),
        Camera::with_screen(pose, Screen::Table(table), 50, 40),
    ];

    for camera in &cameras {
        let renderer = Renderer::new(&source, &options(Engine::Planes, ALL)).at(30.0);
        let seen = |farm: &Farm| {
            let (picture, _) = renderer.picture_with(camera, &bodies(), farm).unwrap();
            (picture.rgb, renderer.frame_with(camera, &bodies(), farm).unwrap().frame.colour)
        };
        let one = Farm::new(1).unwrap();
        let expected = seen(&one);
        for (workers, lines, rows) in [(3, 16, 5), (2, 48, 64)] {
            let farm = Farm::new(workers).unwrap().with_task_size(TaskSize { lines, rows });
            assert!(seen(&farm) == expected, "{workers} workers");
        }

        let later = renderer.at(31.0).picture_with(camera, &bodies(), &one).unwrap().0.rgb;
        assert!(later != expected.0, "clouds stand still");

        // Where the screen has no picture all stays black.
        if let Screen::Fisheye { .. } = camera.screen() {
            assert_eq!(expected.0[..3], [0; 3]);
        }
    }
}

#[test]
fn pictures_show_what_frames_hold_and_engines_agree() {
    let source = hills();
    let farm = Farm::new(2).unwrap();
    for height in [185.0, 300.0, 700.0, 1500.0] {
        let camera = view(height, [20.0, -4.0, 0.0], [160, 90]);
        let [planes, reference] =
            [Engine::Planes, Engine::Reference].map(|engine| Renderer::new(&source, &options(engine, ALL)));
        let (picture, _) = planes.picture_with(&camera, &bodies(), &farm).unwrap();
        let frame = planes.frame_with(&camera, &bodies(), &farm).unwrap().frame;
        let far = |one: &[u8], other: &[u8], within: u8| {
            one.iter().zip(other).filter(|(one, other)| one.abs_diff(**other) > within).count()
        };
        let codes = srgb8_picture(&frame.colour);
        assert_eq!(far(&picture.rgb, &codes, 2), 0, "{height}");
        let (exact, _) = reference.picture_with(&camera, &bodies(), &farm).unwrap();
        let share = far(&picture.rgb, &exact.rgb, 6) as f64 / codes.len() as f64;
        assert!(share < 0.02, "{height}: {share}");
    }
}

#[test]
fn no_step_shows_at_the_horizon() {
    // Level ground without end, as far as haze lets anyone see.
    let source = Terrain::new([128, 128], 4000.0, |_| 100.0, |_| [60, 90, 40]).in_memory();
    let farm = Farm::new(2).unwrap();
    let in_fog = Weather { clouds: None, ..ALL };
    let below_clouds = Weather { fog: None, ..ALL };

    for (weather, height) in [(in_fog, 150.0), (in_fog, 186.0), (below_clouds, 160.0), (below_clouds, 400.0)]
    {
        let eye = DVec3::new(256_000.0, 256_000.0, height);
        let camera = View { eye, ypr: [60.0, 0.0, 0.0], hfov: 3.0, size: [48, 200] }.camera();
        let steps = |weather: Weather| {
            let renderer = Renderer::new(&source, &options(Engine::Planes, weather));
            let (picture, _) = renderer.picture(&camera, &farm).unwrap();
            let step = |row: usize| {
                let [above, below] = [row - 1, row].map(|row| &picture.rgb[row * 144..][..144]);
                above.iter().zip(below).map(|(above, below)| above.abs_diff(*below)).max().unwrap()
            };
            (90..=110).map(|row| (row, step(row))).collect::<Vec<_>>()
        };

        let (own, without) = (steps(weather), steps(Weather { clouds: None, ..weather }));
        for ((row, step), (_, ground)) in own.into_iter().zip(without) {
            if (99..=101).contains(&row) {
                assert!(step <= 2, "{weather:?} from {height} m, row {row}: {step}");
            }
            // Farther down the ground comes out of the haze by up to 5 of 255 a row, and a little faster where it is dark in clouds' shadows.
            let most = 2.max(ground + 1 + ground / 8);
            assert!(
                step <= most,
                "{weather:?} from {height} m, row {row}: {step}, the ground alone {ground}"
            );
        }
    }
}

/// Snow and rain over the hills.
fn winter(kind: PrecipitationKind) -> Weather {
    let precipitation = Precipitation { kind, rate: 4.0, wind: [3.0, 1.0] };
    Weather {
        precipitation: Some(precipitation),
        ground: GroundCover { wet: 0.7, snow: 0.9 },
        ..Weather::default()
    }
}

#[test]
fn what_falls_is_the_same_whoever_renders_and_both_engines_cover_the_ground_alike() {
    let source = hills();
    let camera = view(260.0, [20.0, -6.0, 5.0], [160, 90]);
    for kind in [PrecipitationKind::Rain, PrecipitationKind::Snow] {
        let see = |engine, farm: &Farm, velocity: f64| {
            let renderer = Renderer::new(&source, &options(engine, winter(kind)));
            let renderer = renderer.at(12.0).moving(DVec3::new(0.0, velocity, 0.0));
            (
                renderer.picture(&camera, farm).unwrap().0.rgb,
                renderer.frame(&camera, farm).unwrap().frame.colour,
            )
        };

        let expected = see(Engine::Planes, &Farm::new(1).unwrap(), 40.0);
        for (workers, lines, rows) in [(3, 16, 5), (2, 48, 64)] {
            let farm = Farm::new(workers).unwrap().with_task_size(TaskSize { lines, rows });
            assert!(see(Engine::Planes, &farm, 40.0) == expected, "{workers} workers");
        }

        let farm = Farm::new(2).unwrap();
        assert!(see(Engine::Planes, &farm, 0.0).0 != expected.0, "the eye's motion makes no difference");
        let far = |one: &[u8], other: &[u8], within: u8| {
            one.iter().zip(other).filter(|(one, other)| one.abs_diff(**other) > within).count()
        };
        assert_eq!(far(&expected.0, &srgb8_picture(&expected.1), 2), 0);
        let exact = see(Engine::Reference, &farm, 40.0).0;
        let share = far(&expected.0, &exact, 6) as f64 / exact.len() as f64;
        assert!(share < 0.02, "{share}");
    }
}

#[test]
fn snow_is_white_and_what_falls_hides_the_distance() {
    let source = hills();
    let farm = Farm::new(2).unwrap();
    let camera = view(400.0, [20.0, -25.0, 0.0], [160, 90]);

    let mean = |weather: Weather| {
        let frame =
            Renderer::new(&source, &options(Engine::Planes, weather)).frame(&camera, &farm).unwrap().frame;
        let sum: glam::Vec3 = frame.colour.iter().map(|colour| glam::Vec3::from(*colour)).sum();
        sum / frame.colour.len() as f32
    };
    let dry = mean(Weather::default());
    let cover = |wet, snow| mean(Weather { ground: GroundCover { wet, snow }, ..Weather::default() });
    let (wet, white) = (cover(1.0, 0.0), cover(0.0, 1.0));
    assert!(wet.x < 0.85 * dry.x && white.x > 2.5 * dry.x, "{dry} {wet} {white}");
    assert!((white.x / white.z - 1.0).abs() < 0.15, "{white}");
    let level = view(400.0, [20.0, -1.0, 0.0], [160, 90]);
    let through = |weather: Weather| {
        let air = options(Engine::Planes, weather).atmosphere(hedgehop::voxel::PageSource::header(&source));
        air.veil(level.pose.eye.z, glam::Vec3::Y, 800.0).through
    };
    assert!(
        through(winter(PrecipitationKind::Snow)) < 0.01 && through(winter(PrecipitationKind::Rain)) < 0.7
    );
    assert!(through(Weather::default()) > 0.8);
}

/// The upper edge of fog is as sharp on a cliff, whose posts lie far apart in height, as where rays look at it one by one.
#[test]
fn fog_ends_on_a_cliff_as_it_does_elsewhere() {
    let height = |post: DVec2| if post.y > 1400.0 { 320.0 } else { 100.0 };
    let area = Terrain::new([256, 256], 10.0, height, |_| [40, 44, 36]).in_memory();
    let fog = Fog { top: 170.0, visibility: 300.0, soft: 10.0 };
    let weather = Weather { fog: Some(fog), ..Weather::default() };
    let camera = view(230.0, [0.0, -3.0, 0.0], [160, 160]);
    let farm = Farm::new(2).unwrap();
    let [truth, found] = [Engine::Reference, Engine::Planes].map(|engine| {
        let options = options(engine, weather);
        Renderer::new(&area, &options).frame(&camera, &farm).unwrap().frame.colour
    });
    let middle = |frame: &[[f32; 3]], row: usize| frame[row * 160 + 80][1];
    let rows: Vec<_> = (0..160).map(|row| [&truth, &found].map(|frame| middle(frame, row))).collect();
    let jump = rows.windows(2).map(|rows| (rows[0][0] - rows[1][0]).abs()).fold(0.0, f32::max);
    assert!(jump > 0.05, "the fog's edge is seen: {jump}");
    for (row, [truth, found]) in rows.into_iter().enumerate() {
        // A row is a box to planes, and a point to rays.
        assert!((truth - found).abs() < 0.03 + 0.5 * jump, "row {row}: {found}, not {truth}");
    }

    let mean = truth.iter().zip(&found).map(|(a, b)| (a[1] - b[1]).abs()).sum::<f32>() / truth.len() as f32;
    assert!(mean < 0.004, "{mean}");
}
