//! Shadows of the ground, in whole frames.

use glam::{DVec2, Vec3};

use hedgehop::frame::Frame;
use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::render::{RenderOptions, Renderer, render_reference};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::sunlight::{Daylight, Sun};
use hedgehop::voxel::{Grid, MemPages, Metadata, PageSource, build_in_memory};
use hedgehop_modeling::{Baking, bake_shadows};

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

/// How much of the light of a high sun, which has 65 % of all, a shadow can take of level ground under this one, in the mean of red, green and blue.
fn sunlight() -> f32 {
    let options = options(true);
    let [lit, dark] = [1.0, 0.0].map(|sun| Daylight::new(options.sun).on(Vec3::Z, sun));
    ((lit - dark) * options.brightness().tint()).element_sum() / (3.0 * 0.65)
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
    assert!(shadows > 0.02 * sunlight(), "shadows take {shadows}");
    assert!(apart < 0.1 * shadows, "engines differ by {apart} where shadows take {shadows}");
    assert!(truth.colour.iter().zip(&lit.colour).all(|(dark, light)| dark[1] <= light[1] + 1e-6));
}

#[test]
fn neither_workers_nor_what_was_kept_change_a_shadow() {
    let area = area();
    let camera = camera(&area);
    let picture = |renderer: &Renderer<'_>, workers| {
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

/// Shares of pixels that show no other light than `truth` to within a step of 3 of 255, of those with ground.
fn agreement(found: &[u8], truth: &[u8], range: &[f32]) -> f64 {
    let pixels = found.chunks(3).zip(truth.chunks(3)).zip(range).filter(|(_, range)| range.is_finite());
    let same = |(a, b): (&[u8], &[u8])| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 3);
    let (mut all, mut alike) = (0, 0);
    for (pair, _) in pixels {
        (all, alike) = (all + 1, alike + u32::from(same(pair)));
    }
    f64::from(alike) / f64::from(all)
}

#[test]
fn baked_shadows_look_like_live_ones_and_are_sound() {
    let (bare, farm) = (area(), Farm::new(2).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.hop");
    let live = options(true);

    let baking = Baking {
        source: &bare,
        directory: bare.directory(),
        sun: live.sun,
        output: &path,
        overwrite: false,
        steps: false,
        threads: 2,
    };

    bake_shadows(&baking, &Silent).unwrap();
    let baked = PageFile::open(&path).unwrap();
    assert!(baked.verify(&Silent).unwrap().problems.is_empty());
    assert_eq!(baked.header().metadata.baked_sun, Some([280.0, 7.0]));
    let (source, directory, output) = (&baked, baked.directory(), &folder.path().join("b.hop"));
    let twice = bake_shadows(&Baking { source, directory, output, ..baking }, &Silent);
    assert!(twice.unwrap_err().to_string().contains("already"));

    for detail in [1.0, 8.0] {
        let camera = camera(&bare);
        let truth = Renderer::new(&bare, &RenderOptions { detail, ..live });
        let [frame, lit] = [true, false].map(|shadows| {
            let options = RenderOptions { detail, ..options(shadows) };
            Renderer::new(&bare, &options).frame(&camera, &farm).unwrap().frame
        });
        assert!(difference(&frame, &lit) > 0.015 * sunlight());
        let [truth, bright] = [&truth, &Renderer::new(&bare, &options(false))]
            .map(|renderer| renderer.picture(&camera, &farm).unwrap().0.rgb);
        let options = RenderOptions { detail, ..options(false) };
        let found = Renderer::new(&baked, &options).picture(&camera, &farm).unwrap().0.rgb;
        let agree = agreement(&found, &truth, &frame.range);
        assert!(agree >= 0.99, "{agree} of the pixels agree at detail {detail}");
        assert!(agreement(&bright, &truth, &frame.range) < 0.9, "there are shadows to agree upon");
    }
}
