//! What is refused, and scan planes against the reference marcher on every screen.

use std::sync::Arc;

use glam::DVec2;

use super::*;
use crate::space::{Attitude, Pose, RayTable, Screen};
use crate::voxel::{Grid, MemPages, Metadata, build_in_memory};

#[test]
fn values_that_make_no_picture_are_refused() {
    let grid = Grid { nx: 2, ny: 2, spacing: 1.0, origin: DVec2::ZERO };
    let source = build_in_memory(grid, &[0.0; 4], &[[0; 3]; 4], None, &Metadata::default()).unwrap();
    let farm = Farm::new(1).unwrap();
    let sound = (DVec3::ONE, 60.0, RenderOptions::default());
    let frame = |(eye, hfov, options): (DVec3, f64, RenderOptions)| {
        let camera = Camera::new(Pose { eye, attitude: Attitude::default(), hfov }, 2, 2);
        render_frame(&source, &camera, &options, &farm)
    };
    assert!(frame(sound).is_ok());
    let low_sun = Sun { azimuth: 0.0, elevation: 0.0 };
    for broken in [
        (DVec3::NAN, 60.0, sound.2),
        (DVec3::ONE, 180.0, sound.2),
        (DVec3::ONE, 60.0, RenderOptions { sun: low_sun, ..sound.2 }),
        (DVec3::ONE, 60.0, RenderOptions { visibility: f64::NAN, ..sound.2 }),
        (DVec3::ONE, 60.0, RenderOptions { detail: 0.0, ..sound.2 }),
    ] {
        assert!(matches!(frame(broken), Err(Error::Configuration(_))), "{broken:?}");
    }
}

/// Posts of a side.
const SIDE: u32 = 400;

/// Smooth hills, 10 m between posts.
fn hills() -> MemPages {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 10.0, origin: DVec2::new(5.0e5, 4.0e6) };
    let posts = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (f64::from(x), f64::from(y))));
    let heights: Vec<_> = posts
        .map(|(x, y)| {
            250.0 + 90.0 * (x / 31.0).sin() + 60.0 * (y / 23.0).cos() + 9.0 * (x / 7.0 + y / 5.0).sin()
        })
        .collect();
    let colours: Vec<_> = (0..heights.len()).map(|index| [(index / 9 % 256) as u8, 90, 120]).collect();
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

/// Errors of ranges, and pixels of which only one sees the sky.
#[derive(Default)]
struct Differences {
    errors: Vec<f64>,
    disagree: usize,
    pixels: usize,
}

impl Differences {
    fn add(&mut self, found: &Frame, truth: &Frame) {
        for (&found, &truth) in found.range.iter().zip(&truth.range) {
            self.pixels += 1;
            match (found.is_finite(), truth.is_finite()) {
                (true, true) => self.errors.push(f64::from((found - truth).abs() / truth)),
                (false, false) => {}
                _ => self.disagree += 1,
            }
        }
    }

    /// Error that this share of pixels does not exceed.
    fn at(&mut self, quantile: f64) -> f64 {
        self.errors.sort_by(f64::total_cmp);
        self.errors[(self.errors.len() as f64 * quantile) as usize]
    }
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

/// Pseudo-random, 0…1.
fn random(index: u32, what: u32) -> f64 {
    let mut bits = index.wrapping_mul(0x9E37_79B1) ^ what.wrapping_mul(0x85EB_CA77);
    bits = (bits ^ bits >> 15).wrapping_mul(0x2C1B_3C6D);
    bits = (bits ^ bits >> 12).wrapping_mul(0x297A_2D39);
    f64::from(bits ^ bits >> 15) / f64::from(u32::MAX)
}

#[test]
fn every_screen_and_attitude_agrees_with_the_reference() {
    let source = hills();
    let farm = Farm::new(1).unwrap();
    let corner = source.header().grid.origin;
    let options = RenderOptions {
        engine: Engine::Planes,
        detail: 1.0e3,
        visibility: f64::INFINITY,
        ..RenderOptions::default()
    };
    let renderer = Renderer::new(&source, &options);
    let mut failed = Vec::new();
    for name in ["planar", "cylindrical", "equirectangular", "fisheye", "table"] {
        let mut all = Differences::default();
        for index in 0..12 {
            let pitch = match index % 3 {
                0 => -90.0,
                1 => 90.0,
                _ => 180.0 * random(index, 1) - 90.0,
            };
            let roll = [0.0, 90.0, 180.0, 360.0 * random(index, 2)][index as usize / 3];
            let place = DVec2::new(random(index, 3), random(index, 4)) * 3000.0 + 500.0;
            let ground = crate::raymarch::ground_height(&source, corner + place).unwrap().unwrap();
            let eye = (corner + place).extend(ground + 5.0 * 400.0_f64.powf(random(index, 5)));
            let attitude = Attitude { yaw: 360.0 * random(index, 6), pitch, roll };
            let fov = 150.0_f64.powf(random(index, 7));
            let camera = Camera::with_screen(Pose { eye, attitude, hfov: fov }, screen(name, fov), 240, 180);
            let found = renderer.frame(&camera, &farm).unwrap().frame;
            let truth = render_reference(&source, &camera, &options, &farm).unwrap().frame;
            all.add(&found, &truth);
        }
        let (median, most, disagree) = (all.at(0.5), all.at(0.99), all.disagree);
        let holds =
            median <= 1.5e-4 && most <= 3e-3 && all.at(0.996) <= 1e-2 && disagree <= all.pixels / 1000;
        // A third look straight up, and a dome fills three fifths of its picture.
        assert!(all.errors.len() > all.pixels / 5, "{name}: {} pixels of ground", all.errors.len());
        if !holds {
            failed.push(format!(
                "{name}: median {median:.1e}, 99 % {most:.1e}, sky {disagree} of {}",
                all.pixels
            ));
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}
