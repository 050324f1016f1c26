//! Colour: the sun's side, haze by range, and the light of what a pixel covers.

use glam::{DVec2, DVec3, Vec3};

use super::judge::by_engine;
use super::scene::{Terrain, View, clear_air};
use super::screen::is_of_one_surface;
use hedgehop::render::{Engine, RenderOptions};
use hedgehop::sunlight::Sun;

const GREY: [u8; 3] = [128; 3];

/// Linear light of an sRGB code (IEC 61966-2-1).
fn linear(code: u8) -> f64 {
    let encoded = f64::from(code) / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[test]
fn the_sun_lights_the_side_that_faces_it() {
    // A pyramid with four flanks.
    let height = |post: DVec2| 600.0 - 0.4 * (post - DVec2::splat(1280.0)).abs().max_element();
    let world = Terrain::new([256; 2], 10.0, height, |_| GREY).in_memory();
    let view =
        View { eye: DVec3::new(1280.0, 1280.0, 2500.0), ypr: [0.0, -90.0, 0.0], hfov: 50.0, size: [60, 60] };

    for (azimuth, lit) in [(0.0, DVec2::Y), (90.0, DVec2::X), (180.0, DVec2::NEG_Y), (270.0, DVec2::NEG_X)] {
        let options = RenderOptions { sun: Sun { azimuth, elevation: 35.0 }, ..clear_air() };
        let frame = view.frame(&world, &options);
        let (mut bright, mut dark, mut side) = (0, 0, 0);
        for (index, pixel) in view.pixels() {
            let hit = view.direction(pixel) * f64::from(frame.range[index]);
            let (x, y) = (hit.x.abs(), hit.y.abs());

            // Away from the ridges, where the difference of heights that makes a normal spans two flanks.
            if (x - y).abs() < 200.0 || x.max(y) < 200.0 {
                continue;
            }

            let outward = if x > y { DVec2::X * hit.x.signum() } else { DVec2::Y * hit.y.signum() };
            let normal = (outward * 0.4).extend(1.0).normalize();
            let found = Vec3::from_array(frame.normal[index]);
            assert!((found.as_dvec3() - normal).length() < 2e-3, "{pixel:?}: {found} for {normal}");
            let shade = f64::from(frame.colour[index][0]) / linear(128);

            match outward.dot(lit) {
                facing if facing > 0.5 => {
                    bright += 1;
                    assert!(shade > 1.1, "{azimuth}: {pixel:?} {shade}");
                }
                facing if facing < -0.5 => {
                    dark += 1;
                    assert!(shade < 0.8, "{azimuth}: {pixel:?} {shade}");
                }
                _ => {
                    side += 1;
                    assert!((0.8..1.0).contains(&shade), "{azimuth}: {pixel:?} {shade}");
                }
            }
        }

        assert!(bright > 300 && dark > 300 && side > 600, "{bright} {dark} {side}");
    }
}

#[test]
fn contrast_falls_to_a_twentieth_at_the_visibility_range() {
    for visibility in [800.0, 5000.0, 30_000.0] {
        let world = Terrain::new([256; 2], visibility / 20.0, |_| 300.0, |_| [0; 3]).in_memory();
        let middle = DVec2::splat(128.0 * visibility / 20.0);
        let view = View {
            eye: middle.extend(300.0 + visibility / 400.0),
            ypr: [40.0, 0.0, 0.0],
            hfov: 1.0,
            size: [16, 64],
        };
        let frame = view.frame(&world, &RenderOptions { visibility, ..clear_air() });

        // The sky just above the horizon is what distance fades into.
        let horizon = frame.colour[(31 * 16 + 8) as usize];
        let mut near_visibility = 0;
        for (index, _) in view.pixels().filter(|&(index, _)| frame.range[index].is_finite()) {
            let range = f64::from(frame.range[index]);
            for (light, sky) in frame.colour[index].into_iter().zip(horizon) {
                let contrast = f64::from((sky - light) / sky);
                let expected = 0.05_f64.powf(range / visibility);
                // The haze is a little thinner at the eye's height than at the ground.
                assert!(
                    (contrast - expected).abs() < 0.01,
                    "{range} m of {visibility}: {contrast}, {expected}"
                );
            }
            near_visibility += u32::from((range / visibility - 1.0).abs() < 0.2);
        }

        assert!(near_visibility > 0, "no pixel near {visibility} m");
    }
}

#[test]
fn the_row_of_five_percent_contrast_lies_at_the_visibility_range() {
    for visibility in [800.0, 5000.0, 30_000.0] {
        let world = Terrain::new([256; 2], visibility / 20.0, |_| 300.0, |_| [0; 3]).in_memory();
        let middle = DVec2::splat(128.0 * visibility / 20.0);

        // So low that haze is as thick at the eye as at the ground.
        let eye = middle.extend(300.0 + visibility / 4000.0);
        for engine in [Engine::Planes, Engine::Reference] {
            let view = View { eye, ypr: [40.0, 0.0, 0.0], hfov: 0.02, size: [16, 256] };
            let frame = view.frame(&world, &RenderOptions { visibility, engine, ..clear_air() });
            let light = |row: usize| f64::from(frame.colour[row * 16 + 8][1]);
            let contrast = |row: usize| 1.0 - light(row) / light(127);
            let ground = (128..256).filter(|row| frame.range[row * 16 + 8].is_finite());
            let apart = |row: &usize| (contrast(*row) / 0.05).ln().abs();
            let row = ground.min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap();

            // Contrast falls exponentially: what is left of the way to 5 % follows from that of the nearest row.
            let range = f64::from(frame.range[row * 16 + 8]) * 0.05_f64.ln() / contrast(row).ln();
            assert!(
                (range / visibility - 1.0).abs() < 0.02,
                "{engine:?}, {visibility}: {range} m, row {row}"
            );
        }
    }
}

#[test]
fn a_far_checkerboard_has_half_the_light() {
    let checkers =
        |post: DVec2| if (post / 10.0).floor().element_sum() % 2.0 == 0.0 { [0; 3] } else { [255; 3] };
    let world = Terrain::new([1024; 2], 10.0, |_| 0.0, checkers).in_memory();
    for (height, pitch, hfov, size) in [
        (3000.0, -90.0, 60.0, [64, 48]),
        (1800.0, -60.0, 50.0, [32, 32]),
        (4500.0, -75.0, 30.0, [32, 24]),
        (900.0, -25.0, 40.0, [48, 16]),
    ] {
        let view = View { eye: DVec3::new(5120.0, 2600.0, height), ypr: [0.0, pitch, 0.0], hfov, size };
        let frame = view.frame(&world, &clear_air());
        let mut coarse = 0;
        for (index, pixel) in view.pixels().filter(|&(index, _)| frame.range[index].is_finite()) {
            let covered = f64::from(frame.range[index]) / view.focal() / 10.0;
            let light = frame.colour[index][0];
            if covered >= 4.0 {
                coarse += 1;
                assert!((light - 0.5).abs() < 0.01, "{view:?} {pixel:?}: {light} over {covered} voxels");
            }
        }

        assert!(coarse > 100, "{view:?}: {coarse}");
    }

    // From so near that a pixel covers less than a voxel, black and white are seen.
    let view =
        View { eye: DVec3::new(5000.0, 5000.0, 100.0), ypr: [0.0, -90.0, 0.0], hfov: 40.0, size: [64, 64] };
    let frame = view.frame(&world, &clear_air());
    assert!(
        frame.colour.iter().any(|light| light[0] < 0.1) && frame.colour.iter().any(|light| light[0] > 0.9)
    );
}

#[test]
fn ground_of_one_colour_has_one_colour() {
    // Planes keep light as roots of it in 10 or 11 bits, up to 2.25 times display white.
    let rounding = by_engine(1e-5, 2e-3);
    let colour = [37, 142, 201];
    let exact = colour.map(linear);
    let flat = Terrain::new([700; 2], 10.0, |_| 80.0, |_| colour).in_memory();
    let hills = |post: DVec2| 150.0 + 60.0 * (post.x / 170.0).sin() * (post.y / 230.0).cos();
    let rolling = Terrain::new([700; 2], 10.0, hills, |_| colour).in_memory();

    for (ypr, hfov, size) in [
        ([0.0, -5.0, 0.0], 60.0, [64, 36]),
        ([130.0, -30.0, 40.0], 100.0, [50, 50]),
        ([200.0, -90.0, 0.0], 30.0, [32, 32]),
    ] {
        let view = View { eye: DVec3::new(3500.0, 3400.0, 400.0), ypr, hfov, size };
        for (world, level) in [(&flat, true), (&rolling, false)] {
            let frame = view.frame(world, &clear_air());
            let mut of_one_surface = 0;
            for (index, pixel) in view.pixels().filter(|&(index, _)| frame.range[index].is_finite()) {
                if !is_of_one_surface(&frame, index) {
                    continue;
                }

                of_one_surface += 1;
                let light = frame.colour[index].map(f64::from);

                // Light on a slope changes, but by the same factor in each channel.
                let shade = if level { 1.0 } else { light[2] / exact[2] };
                assert!((0.2..2.0).contains(&shade), "{view:?} {pixel:?}: {shade}");
                for (channel, exact) in exact.iter().enumerate() {
                    let wrong = (light[channel] - exact * shade).abs();
                    assert!(wrong < rounding, "{view:?} {pixel:?}: {light:?} for {exact:?}");
                }
            }

            assert!(of_one_surface > 500, "{view:?}: {of_one_surface}");
        }
    }
}
