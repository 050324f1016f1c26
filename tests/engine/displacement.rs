//! Frames of displaced ground: the same by both engines and any number of workers, and nothing of it unless it is asked for.

use glam::{DVec2, DVec3, Vec3};

use crate::scene::{Terrain, View, clear_air};
use hedgehop::frame::Frame;
use hedgehop::raymarch::Surface;
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{DetailRecord, MemPages, Metadata, build_in_memory};

/// Hills of several wavelengths, of many greens, displaced by so many metres at most; `None`: of a database that knows nothing of it.
fn hills(displacement: Option<f64>) -> MemPages {
    let height = |at: DVec2| {
        100.0
            + 12.0 * (at.x / 70.0).sin() * (at.y / 55.0).cos()
            + 2.0 * (at.x / 23.0).cos()
            + (at.y / 9.0).sin()
    };
    let colour = |at: DVec2| {
        let mixed = (at.x * 12.9898 + at.y * 78.233).sin() * 43_758.547;
        let green = 100 + (40.0 * (mixed - mixed.floor())) as u8;
        [green - 20, green, green - 60]
    };
    let Terrain { grid, heights, colours } = Terrain::new([400, 300], 1.0, height, colour);
    let detail = displacement.map(|displacement| DetailRecord { displacement, ..DetailRecord::default() });
    let metadata = Metadata { detail, ..Metadata::default() };
    build_in_memory(grid, &heights, &colours, None, &metadata).unwrap()
}

/// From a few metres above the ground, level, down and banked, and from outside the area.
const VIEWS: [View; 4] = [
    View { eye: DVec3::new(200.0, 60.0, 103.5), ypr: [20.0, -4.0, 0.0], hfov: 60.0, size: [240, 135] },
    View { eye: DVec3::new(120.0, 150.0, 93.0), ypr: [110.0, -15.0, 12.0], hfov: 75.0, size: [240, 135] },
    View { eye: DVec3::new(250.0, 180.0, 115.0), ypr: [300.0, -85.0, 0.0], hfov: 50.0, size: [240, 135] },
    View { eye: DVec3::new(200.0, -8.0, 105.0), ypr: [0.0, -8.0, 0.0], hfov: 60.0, size: [240, 135] },
];

fn see(pages: &MemPages, view: &View, options: &RenderOptions, workers: usize) -> Frame {
    let farm = Farm::new(workers).unwrap();
    Renderer::new(pages, options).frame_with(&view.camera(), &[], &farm).unwrap().frame
}

/// All that a frame says of its pixels.
fn bits(frame: &Frame) -> Vec<u32> {
    let floats = frame.colour.iter().chain(&frame.normal).flatten().chain(&frame.range);
    let levels = frame.level.iter().map(|&level| u32::from(level));
    floats.map(|value| value.to_bits()).chain(levels).chain(frame.id.iter().copied()).collect()
}

fn by(engine: Engine) -> RenderOptions {
    RenderOptions { engine, ..clear_air() }
}

#[test]
fn engines_agree_on_displaced_ground() {
    let pages = hills(Some(0.3));
    let plain = hills(None);
    for view in VIEWS {
        let [planes, exact] =
            [Engine::Planes, Engine::Reference].map(|engine| see(&pages, &view, &by(engine), 2));

        // Own ranges of pixels, and light of planes that lie up to half a pixel beside them.
        let pixels = exact.range.len() as f64;
        let is_off =
            |(one, other): &(&f32, &f32)| one != other && (*one - *other).abs() > 1e-3 * other.min(**one);
        let off = planes.range.iter().zip(&exact.range).filter(is_off).count();
        let pairs = planes.colour.iter().zip(&exact.colour);
        let light: f32 =
            pairs.map(|(one, other)| (Vec3::from(*one) - Vec3::from(*other)).abs().max_element()).sum();
        let moved = see(&plain, &view, &by(Engine::Reference), 2);
        let moved = moved.range.iter().zip(&exact.range).filter(is_off).count();

        let figures = [off as f64 / pixels, f64::from(light) / pixels, moved as f64 / pixels];

        assert!(figures[0] < 2e-3 && figures[1] < 0.02 && figures[2] > 0.2, "{view:?}: {figures:?}");
    }
}

#[test]
fn displaced_frames_do_not_depend_on_workers() {
    let pages = hills(Some(0.3));
    for view in VIEWS {
        for engine in [Engine::Planes, Engine::Reference] {
            let [one, five] = [1, 5].map(|workers| bits(&see(&pages, &view, &by(engine), workers)));
            assert!(one == five, "{engine:?} {view:?}");
        }
    }
}

#[test]
fn ground_is_displaced_where_it_is_asked_for_alone() {
    let [usual, none, displaced] = [None, Some(0.0), Some(0.3)].map(hills);
    let view = VIEWS[0];
    for engine in [Engine::Planes, Engine::Reference] {
        let seen = |pages: &MemPages, options: &RenderOptions| bits(&see(pages, &view, options, 2));
        assert!(seen(&usual, &by(engine)) == seen(&none, &by(engine)), "{engine:?}");
        assert!(seen(&usual, &by(engine)) != seen(&displaced, &by(engine)), "{engine:?}");

        // Neither without detail, nor where voxels or copies of the area are seen.
        let off = RenderOptions { detail_synthesis: 0.0, ..by(engine) };
        assert!(seen(&usual, &off) == seen(&displaced, &off), "{engine:?}");
    }
    let [blocks, endless] = [
        RenderOptions { surface: Surface::Blocks, ..by(Engine::Reference) },
        RenderOptions { tile_world: true, ..by(Engine::Reference) },
    ];
    for options in [blocks, endless] {
        let [one, other] = [&usual, &displaced].map(|pages| bits(&see(pages, &view, &options, 2)));
        assert!(one == other, "{options:?}");
    }
}

#[test]
fn displacement_ends_where_voxels_are_four_pixels_wide() {
    let [usual, displaced] = [None, Some(0.3)].map(hills);
    for view in VIEWS {
        let end = 0.25 / view.camera().pixel_angle();
        let [usual, displaced] =
            [&usual, &displaced].map(|pages| see(pages, &view, &by(Engine::Reference), 2));
        let pairs = || {
            let pairs = usual.range.iter().zip(&displaced.range);
            pairs.map(|(one, other)| (f64::from(*one), f64::from(*other)))
        };
        let is_same = |one: f64, other: f64| one == other || (one - other).abs() < 1e-6 * one;

        // Ground beyond the end is where it was, unless something nearer hides it: ranges are no less than ground distances.
        let steepest = view.ypr[1].abs().to_radians().cos().max(0.2);
        let far = |range: f64| range * steepest > 1.5 * end && range.is_finite();
        assert!(
            pairs().filter(|(one, other)| far(*one) && far(*other)).all(|(one, other)| is_same(one, other))
        );
        assert!(pairs().any(|(one, other)| !is_same(one, other)));
    }
}
