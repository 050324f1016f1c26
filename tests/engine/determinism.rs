//! The same frame, bit by bit, whoever renders it, how often, and wherever its pages come from.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::scene::{Terrain, View, clear_air};
use hedgehop::encode::{FrameInfo, encode_frame};
use hedgehop::frame::Frame;
use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::raymarch::Surface;
use hedgehop::render::{Engine, RenderOptions, Renderer, render_frame};
use hedgehop::space::{Camera, RayTable, Screen};
use hedgehop::subimage::{Batch, Farm, TaskSize};
use hedgehop::voxel::{Arrays, Metadata, PageSource, write_arrays};

/// Rough hills of many colours over several pages, with a hole.
fn terrain() -> Terrain {
    let height = |post: DVec2| {
        let hole = (post - DVec2::new(2000.0, 1500.0)).length() < 60.0;
        let hills =
            60.0 * (post.x / 130.0).sin() + 40.0 * (post.y / 70.0).cos() + 5.0 * (post.x * post.y).sin();
        if hole { f64::NAN } else { 200.0 + hills }
    };
    let colour = |post: DVec2| [(post.x / 3.0) as u8, (post.y / 7.0) as u8, ((post.x + post.y) / 5.0) as u8];
    Terrain::new([600, 520], 8.0, height, colour)
}

/// Attitudes on all kinds of screens, and on planar ones as each engine sees each surface.
fn views() -> Vec<(Camera, RenderOptions)> {
    let attitudes = [[40.0, 0.0, 0.0], [130.0, -15.0, 25.0], [300.0, -90.0, 0.0], [0.0, -2.0, 90.0]];
    let table = RayTable::of_screen(&Screen::Planar { hfov: 60.0 }, 50, 40).unwrap();

    // Widths that are and are not whole tasks.
    let screens = [
        ([64, 36], Screen::Planar { hfov: 60.0 }),
        ([61, 47], Screen::Planar { hfov: 95.0 }),
        ([3, 50], Screen::Planar { hfov: 20.0 }),
        ([1, 1], Screen::Planar { hfov: 45.0 }),
        ([61, 47], Screen::Cylindrical { hfov: 200.0 }),
        ([64, 32], Screen::Equirectangular { hfov: 360.0, vfov: 180.0 }),
        ([50, 50], Screen::Fisheye { fov: 200.0 }),
        ([50, 40], Screen::Table(Arc::new(table))),
    ];

    let mut views = Vec::new();
    for (ypr, ([width, height], screen)) in
        attitudes.into_iter().flat_map(|ypr| screens.iter().map(move |screen| (ypr, screen)))
    {
        let view = View { eye: DVec3::new(1800.0, 1300.0, 420.0), ypr, hfov: 60.0, size: [1, 1] };
        let camera = Camera::with_screen(view.camera().pose, screen.clone(), *width, *height);
        let engines = [
            (Engine::Planes, Surface::Smooth),
            (Engine::Reference, Surface::Smooth),
            (Engine::Reference, Surface::Blocks),
        ];
        let engines = if matches!(screen, Screen::Planar { .. }) { &engines[..] } else { &engines[..1] };
        for &(engine, surface) in engines {
            let options = RenderOptions { engine, surface, visibility: 9000.0, ..clear_air() };
            views.push((camera.clone(), options));
        }
    }

    views
}

/// Some of each kind: their kinds repeat every sixteen.
fn some_views() -> Vec<(Camera, RenderOptions)> {
    views().into_iter().step_by(3).collect()
}

/// A view, for people.
fn named(camera: &Camera, options: &RenderOptions) -> String {
    format!("{:?} {:?} {} {:?}", options.engine, options.surface, camera.screen(), camera.pose.attitude)
}

/// All planes as bits.
fn bits(frame: &Frame) -> Vec<u32> {
    let floats = frame.colour.iter().chain(&frame.normal).flatten().chain(&frame.range);
    let levels = frame.level.iter().map(|&level| u32::from(level));
    floats.map(|value| value.to_bits()).chain(levels).chain(frame.id.iter().copied()).collect()
}

fn render(source: &dyn PageSource, camera: &Camera, options: &RenderOptions, farm: &Farm) -> Frame {
    render_frame(source, camera, options, farm).unwrap().frame
}

#[test]
fn planes_render_what_is_asked_of_them() {
    let world = terrain().in_memory();
    for (camera, options) in views() {
        let engine = Renderer::new(&world, &options).engine_for(&camera).unwrap();
        assert_eq!(engine, options.engine, "{}", named(&camera, &options));
    }
}

#[test]
fn frames_do_not_depend_on_the_number_of_workers() {
    let world = terrain().in_memory();
    let [one, two, five] = [1, 2, 5].map(|workers| Farm::new(workers).unwrap());
    for (camera, options) in views() {
        let expected = bits(&render(&world, &camera, &options, &one));
        for farm in [&two, &five] {
            let found = bits(&render(&world, &camera, &options, farm));
            assert!(found == expected, "{}: {} workers", named(&camera, &options), farm.workers());
        }
    }
}

#[test]
fn frames_do_not_depend_on_the_size_of_tasks() {
    let world = terrain().in_memory();
    let farm = Farm::new(3).unwrap();
    for (camera, options) in some_views() {
        let expected = bits(&render(&world, &camera, &options, &farm));
        for (lines, rows) in [(1, 1), (3, 7), (16, 2), (u32::MAX, u32::MAX), (0, 0)] {
            let farm = farm.with_task_size(TaskSize { lines, rows });
            let found = bits(&render(&world, &camera, &options, &farm));
            assert!(
                found == expected,
                "{}: tasks of {lines} lines and {rows} rows",
                named(&camera, &options)
            );
        }
    }
}

#[test]
fn frames_do_not_depend_on_how_many_are_in_flight() {
    let world = terrain().in_memory();
    let views: Vec<_> = (1_u64..).zip(some_views()).collect();
    let one = Farm::new(1).unwrap();
    let expected: Vec<_> =
        views.iter().map(|(_, (camera, options))| bits(&render(&world, camera, options, &one))).collect();

    for workers in [1, 2, 5] {
        let farm = Farm::new(workers).unwrap();
        for in_flight in 1..=3 {
            let batch = Batch { frames: &views, in_flight, observer: &Silent };
            let mut found = Vec::new();
            farm.fly(
                &batch,
                |farm, (camera, options)| Ok(render(&world, camera, options, farm)),
                |_, frame| {
                    found.push(bits(&frame));
                    Ok(())
                },
            )
            .unwrap();

            assert!(found == expected, "{workers} workers, {in_flight} frames in flight");
        }
    }
}

/// Frames of one renderer share memory and tables: any subset of them, in any order, has the same bits.
#[test]
fn frames_do_not_depend_on_which_others_are_rendered() {
    let world = terrain().in_memory();
    let farm = Farm::new(2).unwrap();
    let (cameras, options): (Vec<_>, Vec<_>) =
        views().into_iter().filter(|(_, options)| options.engine == Engine::Planes).unzip();
    let all = Renderer::new(&world, &options[0]);
    let frames: Vec<_> =
        cameras.iter().map(|camera| bits(&all.frame(camera, &farm).unwrap().frame)).collect();
    let some = Renderer::new(&world, &options[0]);
    for (index, camera) in cameras.iter().enumerate().rev().filter(|(index, _)| index % 5 != 1) {
        let found = bits(&some.frame(camera, &farm).unwrap().frame);
        assert!(found == frames[index], "{}", named(camera, &options[0]));
        let picture = |renderer: &Renderer<'_>| renderer.picture(camera, &farm).unwrap().0.rgb;
        assert!(picture(&some) == picture(&all), "{}", named(camera, &options[0]));
    }
}

#[test]
fn frames_do_not_depend_on_where_pages_come_from_or_which_were_touched_before() {
    let terrain = terrain();
    let world = terrain.in_memory();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hills.hop");
    let arrays =
        Arrays { grid: terrain.grid, heights: &terrain.heights, colours: &terrain.colours, attributes: None };
    write_arrays(&path, &arrays, &Metadata::default(), false).unwrap();
    let farm = Farm::new(2).unwrap();
    let warm = PageFile::open(&path).unwrap();

    for (camera, options) in some_views() {
        let expected = bits(&render(&world, &camera, &options, &farm));
        assert!(
            bits(&render(&warm, &camera, &options, &farm)) == expected,
            "{} from a file",
            named(&camera, &options)
        );
        let cold = PageFile::open(&path).unwrap();
        assert!(
            bits(&render(&cold, &camera, &options, &farm)) == expected,
            "{} from a file just opened",
            named(&camera, &options)
        );
    }
}

#[test]
fn encoded_frames_are_the_same_bytes() {
    let world = terrain().in_memory();
    let (camera, options) = views().swap_remove(0);
    let info = FrameInfo {
        frame: 1,
        seconds: 0.0,
        database_hash: world.header().content_hash.to_string(),
        database_file: "hills.hop".into(),
        crs_name: "local".into(),
        vertical_datum: "mean sea level".into(),
        settings_digest: "none".into(),
        writer: "a test".into(),
    };

    for name in ["frame.png", "frame.exr"] {
        let encode = |workers| {
            let frame = render(&world, &camera, &options, &Farm::new(workers).unwrap());
            encode_frame(name.as_ref(), &frame, &info).unwrap()
        };
        assert!(encode(1) == encode(3), "{name}");
    }
}
