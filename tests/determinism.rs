//! The same frame, bit by bit, whoever renders it, how often, and wherever its pages come from.

#[path = "common/scene.rs"]
mod scene;

use glam::{DVec2, DVec3};
use hedgehop::frame::{Frame, FrameInfo, encode_frame};
use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::raymarch::Surface;
use hedgehop::render::{RenderOptions, render_frame};
use hedgehop::subimage::{Batch, Farm, TaskSize};
use hedgehop::voxel::{Arrays, Metadata, PageSource, write_arrays};
use scene::{Terrain, View, clear_air};

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

fn views() -> impl Iterator<Item = (View, RenderOptions)> {
    let attitudes = [[40.0, 0.0, 0.0], [130.0, -15.0, 25.0], [300.0, -90.0, 0.0], [0.0, -2.0, 90.0]];
    // Widths that are and are not whole tasks.
    let screens = [([64, 36], 60.0), ([61, 47], 95.0), ([3, 50], 20.0), ([1, 1], 45.0)];
    attitudes.into_iter().flat_map(move |ypr| {
        screens.into_iter().flat_map(move |(size, hfov)| {
            [Surface::Smooth, Surface::Blocks].map(|surface| {
                let view = View { eye: DVec3::new(1800.0, 1300.0, 420.0), ypr, hfov, size };
                (view, RenderOptions { surface, visibility: 9000.0, ..clear_air() })
            })
        })
    })
}

/// All planes as bits.
fn bits(frame: &Frame) -> Vec<u32> {
    let floats = frame.colour.iter().chain(&frame.normal).flatten().chain(&frame.range);
    let levels = frame.level.iter().map(|&level| u32::from(level));
    floats.map(|value| value.to_bits()).chain(levels).chain(frame.id.iter().copied()).collect()
}

fn render<S: PageSource>(source: &S, view: &View, options: &RenderOptions, farm: &Farm) -> Frame {
    render_frame(source, &view.camera(), options, farm).unwrap().frame
}

#[test]
fn frames_do_not_depend_on_the_number_of_workers() {
    let world = terrain().in_memory();
    let farms = [1, 2, 3, 5].map(|workers| Farm::new(workers).unwrap());
    for (view, options) in views() {
        let expected = bits(&render(&world, &view, &options, &farms[0]));
        for farm in &farms {
            for time in 0..2 {
                let found = bits(&render(&world, &view, &options, farm));
                assert!(found == expected, "{view:?}: {} workers, time {time}", farm.workers());
            }
        }
    }
}

#[test]
fn frames_do_not_depend_on_the_size_of_tasks() {
    let world = terrain().in_memory();
    let farm = Farm::new(3).unwrap();
    for (view, options) in views() {
        let expected = bits(&render(&world, &view, &options, &farm));
        for (lines, rows) in [(1, 1), (3, 7), (16, 2), (u32::MAX, u32::MAX), (0, 0)] {
            let farm = farm.with_task_size(TaskSize { lines, rows });
            let found = bits(&render(&world, &view, &options, &farm));
            assert!(found == expected, "{view:?}: tasks of {lines} lines and {rows} rows");
        }
    }
}

#[test]
fn frames_do_not_depend_on_how_many_are_in_flight() {
    let world = terrain().in_memory();
    let views: Vec<_> = (1..).zip(views()).collect();
    let one = Farm::new(1).unwrap();
    let expected: Vec<_> =
        views.iter().map(|(_, (view, options))| bits(&render(&world, view, options, &one))).collect();
    for workers in [1, 2, 3, 5] {
        let farm = Farm::new(workers).unwrap();
        for in_flight in 1..=3 {
            let batch = Batch { frames: &views, in_flight, observer: &Silent };
            let mut found = Vec::new();
            farm.fly(
                &batch,
                |farm, (view, options)| Ok(render(&world, view, options, farm)),
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
    for (view, options) in views() {
        let expected = bits(&render(&world, &view, &options, &farm));
        assert!(bits(&render(&warm, &view, &options, &farm)) == expected, "{view:?} from a file");
        let cold = PageFile::open(&path).unwrap();
        assert!(bits(&render(&cold, &view, &options, &farm)) == expected, "{view:?} from a file just opened");
    }
}

#[test]
fn encoded_frames_are_the_same_bytes() {
    let world = terrain().in_memory();
    let (view, options) = views().next().unwrap();
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
            let frame = render(&world, &view, &options, &Farm::new(workers).unwrap());
            encode_frame(name.as_ref(), &frame, &info).unwrap()
        };
        assert!(encode(1) == encode(3), "{name}");
    }
}
