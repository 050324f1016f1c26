//! The curved Earth against its closed forms: what a wall at sea shows, and where the horizon stands.

use glam::DVec3;

use super::scene::{Terrain, View, clear_air};
use super::screen::FARM;
use hedgehop::earth::Curvature;
use hedgehop::raymarch::Surface;
use hedgehop::render::{RenderOptions, render_frame};
use hedgehop::voxel::{Grid, MemPages, Metadata, PageSource, build_in_memory};

/// 7/6 of the Earth's mean radius, metres.
const RADIUS: f64 = 7.0 / 6.0 * 6_371_008.8;
const WALL_AT: f64 = 51_200.0;

/// Height in the database of the lowest pixel that sees the wall, in the column that looks due east, and the
/// height that a pixel covers there.
fn foot_of_wall(eye_height: f64, surface: Surface, curvature: Curvature) -> (f64, f64) {
    let spacing = 50.0;
    let height = |place: glam::DVec2| if place.x < WALL_AT { 0.0 } else { 400.0 };
    let sea = Terrain::new([1088, 64], spacing, height, |_| [90; 3]).in_memory();

    let view = View {
        eye: DVec3::new(1e-3, 0.5 * 64.0 * spacing, eye_height),
        ypr: [90.0, 0.0, 0.0],
        hfov: 0.02,
        size: [3, 901],
    };
    let options = RenderOptions { surface, curvature, ..clear_air() };
    let frame = view.frame(&sea, &options);

    // The smooth surface begins to climb half a voxel before the wall.
    let is_wall = |index: usize| match surface {
        Surface::Blocks => frame.normal[index][2] == 0.0,
        Surface::Smooth => f64::from(frame.range[index]) > WALL_AT - 0.5 * spacing,
    };
    let wall = view.pixels().filter(|&(index, pixel)| {
        pixel[0] == 1 && f64::from(frame.range[index]) > WALL_AT - 50.0 && is_wall(index)
    });
    let heights = wall.map(|(index, pixel)| {
        let range = f64::from(frame.range[index]);
        eye_height + view.direction(pixel).z * range + curvature.drop_at(range)
    });

    (heights.fold(f64::INFINITY, f64::min), WALL_AT / view.focal())
}

#[test]
fn the_sea_hides_what_the_closed_form_says() {
    for surface in [Surface::Blocks, Surface::Smooth] {
        for eye_height in [2.0, 10.0, 50.0, 120.0] {
            let horizon = (2.0 * RADIUS * eye_height).sqrt();
            let hidden = (WALL_AT - horizon).powi(2) / (2.0 * RADIUS);
            let (foot, pixel) = foot_of_wall(eye_height, surface, Curvature::standard());
            assert!(
                foot > hidden - 0.01 && foot < hidden + 1.1 * pixel,
                "{surface:?} {eye_height} m: {foot} for {hidden}"
            );
            // Flat, it is seen from its foot; without refraction less of it.
            let (flat, _) = foot_of_wall(eye_height, surface, Curvature::FLAT);
            assert!(flat < 1.1 * pixel, "{surface:?} {flat}");
            let (bare, _) = foot_of_wall(eye_height, surface, Curvature::refracted(0.0));
            assert!(bare > foot + 1.0, "{surface:?} {bare} {foot}");
        }
    }
}

#[test]
fn the_horizon_dips_by_the_closed_form() {
    // A small sea that repeats without end, and one that reaches beyond the horizon.
    for (size, spacing, tile_world) in [([64, 48], 100.0, true), ([600, 600], 1000.0, false)] {
        let sea = Terrain::new(size, spacing, |_| 0.0, |_| [90; 3]).in_memory();
        let middle = 0.5 * spacing * glam::DVec2::from(size.map(f64::from));
        assert_horizon_dips(&sea, middle, tile_world);
    }
}

fn assert_horizon_dips(sea: &MemPages, middle: glam::DVec2, tile_world: bool) {
    for eye_height in [20.0, 500.0, 3000.0] {
        let dip = (2.0 * eye_height / RADIUS).sqrt();
        for (roll, hfov) in [(0.0, 4.0), (25.0, 9.0)] {
            let view = View {
                eye: middle.extend(eye_height),
                ypr: [70.0, -dip.to_degrees(), roll],
                hfov,
                size: [60, 60],
            };
            let curvature = Curvature::standard();
            let options = RenderOptions { curvature, tile_world, ..clear_air() };
            let frame = view.frame(sea, &options);
            let (mut ground, mut sky) = (0, 0);

            for (index, pixel) in view.pixels() {
                let above = (view.direction(pixel).z.asin() + dip) * view.focal();
                let is_sky = frame.range[index].is_infinite();
                assert!(
                    above.abs() < 0.02 || is_sky == (above > 0.0),
                    "{view:?}: {pixel:?} {above} {is_sky}"
                );
                *(if is_sky { &mut sky } else { &mut ground }) += 1;
            }

            assert!(ground > 1000 && sky > 1000);
        }
    }
}

#[test]
fn a_place_on_earth_is_curved_and_local_metres_are_flat() {
    let grid = Grid { nx: 8, ny: 8, spacing: 10.0, origin: glam::DVec2::ZERO };
    let proj = Some("+proj=utm +zone=33 +datum=WGS84".to_owned());
    for (crs_proj, radius) in [(None, None), (proj, Some(RADIUS))] {
        let metadata = Metadata { crs_proj, ..Metadata::default() };
        let area = build_in_memory(grid, &[0.0; 64], &[[0; 3]; 64], None, &metadata).unwrap();
        let found = RenderOptions::of(area.header()).curvature.radius();
        assert_eq!(found.map(f64::round), radius.map(f64::round));
        let camera = View { eye: DVec3::Z, ypr: [0.0; 3], hfov: 60.0, size: [2, 2] }.camera();
        for inverse_diameter in [-1.0, f64::NAN, f64::INFINITY] {
            let options = RenderOptions { curvature: Curvature { inverse_diameter }, ..clear_air() };
            assert!(render_frame(&area, &camera, &options, &FARM).is_err());
        }
    }
}
