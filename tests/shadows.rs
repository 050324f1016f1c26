//! Shadows of the ground, in whole frames.

use glam::DVec2;
use hedgehop::frame::Frame;
use hedgehop::render::{RenderOptions, Renderer, render_reference};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::sunlight::Sun;
use hedgehop::voxel::{Grid, MemPages, Metadata, PageSource, build_in_memory};

/// Rows of steep hills, and a tower.
fn area() -> MemPages {
    let grid = Grid { nx: 900, ny: 900, spacing: 5.0, origin: DVec2::new(4.0e5, 5.0e6) };
    let posts = (0..900).flat_map(|y| (0..900).map(move |x| (5.0 * f64::from(x), 5.0 * f64::from(y))));
    let height = |(x, y): (f64, f64)| {
        let tower = if (x - 2250.0).abs() < 12.0 && (y - 1800.0).abs() < 12.0 { 60.0 } else { 0.0 };
        300.0 + 90.0 * (x / 310.0 + (y / 500.0).sin()).sin() + 25.0 * (y / 130.0).cos() + tower
    };
    let heights: Vec<f64> = posts.map(height).collect();
    build_in_memory(grid, &heights, &vec![[150, 140, 120]; heights.len()], None, &Metadata::default())
        .unwrap()
}

fn camera(area: &MemPages) -> Camera {
    let eye = (area.header().grid.origin + DVec2::new(1900.0, 900.0)).extend(560.0);
    let pose = Pose { eye, attitude: Attitude { yaw: 25.0, pitch: -14.0, roll: 0.0 }, hfov: 60.0 };
    Camera::new(pose, 320, 180)
}

fn options(shadows: bool) -> RenderOptions {
    let sun = Sun { azimuth: 280.0, elevation: 7.0 };
    RenderOptions { shadows, sun, detail: 8.0, ..RenderOptions::default() }
}

/// Mean difference of light.
fn difference(a: &Frame, b: &Frame) -> f32 {
    let pairs = a.colour.iter().flatten().zip(b.colour.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).sum::<f32>() / (3 * a.colour.len()) as f32
}

#[test]
fn planes_show_the_shadows_of_the_reference() {
    let (area, farm) = (area(), Farm::new(2).unwrap());
    let camera = camera(&area);
    let frames = |shadows| {
        let options = options(shadows);
        let truth = render_reference(&area, &camera, &options, &farm).unwrap().frame;
        [truth, Renderer::new(&area, &options).frame(&camera, &farm).unwrap().frame]
    };
    let ([lit, _], [truth, found]) = (frames(false), frames(true));
    let (shadows, apart) = (difference(&lit, &truth), difference(&truth, &found));
    assert!(shadows > 0.02, "shadows take {shadows}");
    assert!(apart < 0.1 * shadows, "engines differ by {apart} where shadows take {shadows}");
    assert!(truth.colour.iter().zip(&lit.colour).all(|(dark, light)| dark[1] <= light[1] + 1e-6));
}

#[test]
fn neither_workers_nor_what_was_kept_change_a_shadow() {
    let area = area();
    let camera = camera(&area);
    let picture = |renderer: &Renderer<'_, MemPages>, workers| {
        renderer.picture(&camera, &Farm::new(workers).unwrap()).unwrap().0.rgb
    };
    let renderer = Renderer::new(&area, &options(true));
    let first = picture(&renderer, 1);
    assert!(first == picture(&renderer, 1));
    assert!(first == picture(&Renderer::new(&area, &options(true)).with_memory(1 << 20), 3));
    assert!(first != picture(&Renderer::new(&area, &options(false)), 1));
}

#[test]
fn frames_and_pictures_show_the_same() {
    let (area, farm) = (area(), Farm::new(1).unwrap());
    let camera = camera(&area);
    let renderer = Renderer::new(&area, &options(true));
    let frame = renderer.frame(&camera, &farm).unwrap().frame;
    let rgb = renderer.picture(&camera, &farm).unwrap().0.rgb;
    // At edges of light pictures are resampled as the root of light, frames as light.
    let pixels = hedgehop::colour::srgb8_picture(&frame.colour).into_iter().zip(rgb);
    let apart: Vec<_> = pixels.map(|(a, b)| a.abs_diff(b)).collect();
    let far = apart.iter().filter(|apart| **apart > 3).count();
    assert!(far * 200 <= apart.len(), "{far} of {} differ, by up to {:?}", apart.len(), apart.iter().max());
}
