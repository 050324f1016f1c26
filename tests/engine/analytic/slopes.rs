//! Ramp → range, step → silhouette.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

use super::judge::Judge;
use super::scene::{Terrain, View, clear_air};
use hedgehop::raymarch::Surface;
use hedgehop::render::RenderOptions;

const GREY: [u8; 3] = [128; 3];

#[test]
fn a_ramp_is_met_at_its_range_at_every_level() {
    const SPACING: f64 = 10.0;
    const SIZE: DVec2 = DVec2::new(15_360.0, 7680.0);

    let slope = DVec2::new(0.04, -0.02);
    let ramp = |position: DVec2| 400.0 + slope.dot(position);
    let terrain = Terrain::new([1536, 768], SPACING, ramp, |_| GREY);
    let world = terrain.in_memory();
    let eye = DVec3::new(1000.0, 3500.0, ramp(DVec2::new(1000.0, 3500.0)) + 900.0);
    let (mut levels, mut judge) = (BTreeSet::new(), Judge::default());

    for (size, hfov, detail) in
        [([96, 54], 100.0, 1.0), ([54, 96], 60.0, 1.0), ([80, 60], 75.0, 0.2), ([64, 64], 20.0, 4.0)]
    {
        for ypr in [
            [90.0, -4.0, 0.0],
            [90.0, -25.0, 30.0],
            [60.0, -10.0, 90.0],
            [110.0, 0.0, 0.0],
            [250.0, -60.0, 180.0],
        ] {
            let view = View { eye, ypr, hfov, size };
            let frame = view.frame(&world, &RenderOptions { detail, ..clear_air() });
            let (mut checked, mut ground) = (0, 0);
            for (index, pixel) in view.pixels().filter(|&(index, _)| frame.range[index].is_finite()) {
                ground += 1;
                let direction = view.direction(pixel);
                let exact = 900.0 / (slope.dot(direction.truncate()) - direction.z);
                let hit = eye.truncate() + direction.truncate() * exact;
                let level = frame.level[index];

                // Beyond the outermost posts, half a voxel from the edge, there is nothing to interpolate
                // with: the surface goes on level. No closed form of the ramp applies there.
                let margin = 0.5 * SPACING * 4_f64.powi(i32::from(level));
                let inside = (hit - 0.5 * SIZE).abs().cmple(0.5 * SIZE - margin).all();

                if exact > 0.0 && inside {
                    checked += 1;
                    levels.insert(level);
                    let range = f64::from(frame.range[index]);
                    judge.range(range, exact, 1e-4, (&view, pixel));
                }
            }

            assert!(checked * 100 >= ground * 85, "{view:?}: only {checked} of {ground} pixels are checked");
        }
    }

    judge.decide();
    assert_eq!(levels.into_iter().collect::<Vec<_>>(), [0, 1, 2, 3]);
}

/// A wall across the view: its upper edge is the silhouette, its foot parts the two surfaces.
fn assert_step(surface: Surface, detail: f64) {
    const TOP: f64 = 80.0;

    let (spacing, wall) = (2.0, 900.0);
    let terrain = Terrain::new([800, 600], spacing, |post| if post.x < wall { 0.0 } else { TOP }, |_| GREY);
    let world = terrain.in_memory();
    let options = RenderOptions { surface, detail, ..clear_air() };
    let mut judge = Judge::default();

    for (height, hfov, size) in
        [(40.0, 60.0, [80, 120]), (10.0, 30.0, [64, 64]), (70.0, 75.0, [120, 90]), (79.0, 20.0, [50, 50])]
    {
        for (pitch, roll) in [(0.0, 0.0), (-6.0, 0.0), (5.0, 90.0), (0.0, 30.0), (-3.0, 180.0)] {
            let eye = DVec3::new(300.0, 600.0, height);
            let view = View { eye, ypr: [90.0, pitch, roll], hfov, size };
            let frame = view.frame(&world, &options);
            let ahead = wall - eye.x;
            let above_edge = DVec3::new(ahead, 0.0, TOP - height).cross(DVec3::Y);
            let above_foot = DVec3::new(ahead, 0.0, -height).cross(DVec3::Y);

            for (index, pixel) in view.pixels() {
                let direction = view.direction(pixel);
                // Within the wall's reach to both sides, and some voxels.
                if (direction.y / direction.x * ahead).abs() > 590.0 {
                    continue;
                }

                let range = f64::from(frame.range[index]);
                let (edge, foot) = (view.distance(above_edge, pixel), view.distance(above_foot, pixel));

                // The smooth surface climbs from one post to the next; voxels fill up to a pixel.
                let slack = f64::max(spacing, range / view.focal()) / direction.x;
                if edge > 1.0 {
                    judge.sky(range, (surface, &view, pixel));
                } else if edge < -1.0 && foot > 1.0 {
                    let exact = ahead / direction.x;
                    judge.range_about(range, exact, slack, (surface, &view, pixel));
                } else if foot < -1.0 {
                    let exact = height / -direction.z;
                    judge.range(range, exact, 1e-4, (surface, &view, pixel));
                }
            }
        }
    }

    judge.decide();
}

#[test]
fn a_step_of_blocks_shows_its_silhouette_and_both_surfaces() {
    assert_step(Surface::Blocks, 1.0);
}

#[test]
fn a_step_of_the_smooth_surface_does_too() {
    assert_step(Surface::Smooth, 1.0);
    assert_step(Surface::Smooth, 4.0);
}

#[test]
fn from_above_a_step_shows_its_upper_surface_behind_the_edge() {
    let terrain = Terrain::new([800, 400], 2.0, |post| if post.x < 900.0 { 0.0 } else { 80.0 }, |_| GREY);
    let world = terrain.in_memory();
    let eye = DVec3::new(300.0, 400.0, 280.0);
    let view = View { eye, ypr: [90.0, -20.0, 0.0], hfov: 30.0, size: [60, 90] };

    for surface in [Surface::Blocks, Surface::Smooth] {
        let frame = view.frame(&world, &RenderOptions { surface, ..clear_air() });
        let edge = DVec3::new(600.0, 0.0, -200.0).cross(DVec3::Y);
        let mut behind = 0;
        for (index, pixel) in view.pixels() {
            let direction = view.direction(pixel);
            let exact = 200.0 / -direction.z;
            let hit = eye.x + direction.x * exact;
            if direction.z < 0.0 && view.distance(edge, pixel) > 1.0 && (910.0..1590.0).contains(&hit) {
                behind += 1;
                let range = f64::from(frame.range[index]);
                assert!((range / exact - 1.0).abs() < 1e-4, "{surface:?} {pixel:?}: {range} for {exact}");
            }
        }

        assert!(behind > 500, "{behind}");
    }
}
