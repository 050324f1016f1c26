//! Walls of rock: detail that lies over them, by both engines.

use glam::DVec2;

use hedgehop::frame::Frame;
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{Grid, MemPages, Metadata, build_in_memory};
use hedgehop_testing::Random;

/// Posts of a side, a metre apart.
const SIDE: u32 = 160;
/// Where the wall's foot is, how wide it is as a map shows it, and how high, metres.
const FOOT: f64 = 100.0;
const WIDTH: f64 = 20.0;
const HEIGHT: f64 = 100.0;
const SIZE: [u32; 2] = [240, 160];

/// A wall that faces west, or south, of imagery that differs from voxel to voxel.
fn wall(axis: usize) -> MemPages {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 1.0, origin: DVec2::ZERO };
    let mut random = Random(7);
    let (mut heights, mut colours) = (Vec::new(), Vec::new());
    for (y, x) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
        let across = f64::from([x, y][axis]);
        heights.push(HEIGHT * ((across - FOOT) / WIDTH).clamp(0.0, 1.0));
        colours.push([(90.0 + 80.0 * random.share()) as u8; 3]);
    }
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

/// The wall's middle, seen from 60 m before it.
fn seen(area: &MemPages, axis: usize, engine: Engine, detail_synthesis: f64) -> Frame {
    let options = RenderOptions { engine, detail_synthesis, ..RenderOptions::default() };
    let mut eye = DVec2::splat(80.0);
    eye[axis] = FOOT - 50.0;
    let attitude = Attitude { yaw: [90.0, 0.0][axis], pitch: 0.0, roll: 0.0 };
    let camera = Camera::new(Pose { eye: eye.extend(50.0), attitude, hfov: 30.0 }, SIZE[0], SIZE[1]);
    Renderer::new(area, &options).frame(&camera, &Farm::new(1).unwrap()).unwrap().frame
}

/// Mean of the magnitude of what changes from a pixel to the next one, to the right and down.
fn changes(values: &[f32]) -> [f64; 2] {
    let [width, height] = SIZE.map(|side| side as usize);
    let mut sums = [0.0; 2];
    for (row, column) in (0..height - 1).flat_map(|row| (0..width - 1).map(move |column| (row, column))) {
        let at = row * width + column;
        for (sum, beside) in sums.iter_mut().zip([at + 1, at + width]) {
            *sum += f64::from((values[beside] - values[at]).abs());
        }
    }
    sums.map(|sum| sum / (width * height) as f64)
}

#[test]
fn walls_have_detail_without_curtains_and_engines_agree() {
    for axis in [0, 1] {
        let area = wall(axis);
        let green = |engine, detail: f64| -> Vec<f32> {
            seen(&area, axis, engine, detail).colour.iter().map(|colour| colour[1]).collect()
        };
        let (plain, planes) = (green(Engine::Planes, 0.0), green(Engine::Planes, 1.0));
        let reference = green(Engine::Reference, 1.0);
        let mean = plain.iter().map(|&light| f64::from(light)).sum::<f64>() / plain.len() as f64;

        // Imagery alone is calm there, and what is added varies as much along the wall as up.
        let curtains = changes(&plain).map(|change| change / mean);
        assert!(curtains[0] < 0.006, "axis {axis}: {curtains:?}");
        let added: Vec<f32> = planes.iter().zip(&plain).map(|(planes, plain)| planes - plain).collect();
        let [along, up] = changes(&added);
        assert!(
            along > 0.01 * mean && (0.6..1.6).contains(&(up / along)),
            "axis {axis}: {along} {up} of {mean}"
        );

        let difference =
            planes.iter().zip(&reference).map(|(planes, reference)| (planes - reference).powi(2));
        let error = f64::from(difference.sum::<f32>() / planes.len() as f32).sqrt();
        let spread = added.iter().map(|&added| f64::from(added).powi(2)).sum::<f64>() / added.len() as f64;
        assert!(error < 0.1 * spread.sqrt(), "axis {axis}: {error} of {}", spread.sqrt());
    }
}
