//! The curved Earth and the area without end: against small steps, and against copies laid out side by side.

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::tests::{hills, noise, terrain};
use super::*;
use crate::earth::Curvature;
use crate::space::{Attitude, Camera, Pose};
use crate::voxel::{MemPages, PageSource};

/// A sphere so small that a tenth of this area bends visibly.
const TIGHT: Curvature = Curvature { inverse_diameter: 1.0 / 10_000.0 };

/// Bands in which level index `level` alone is seen.
fn only(source: &MemPages, level: u8) -> LevelBands {
    LevelBands::new(&source.header().grid, level + 1, 1.0, f64::INFINITY, 1.0)
}

/// First range, up to `until` metres, at which `inside` holds: small steps, then bisection.
fn by_small_steps(until: f64, mut inside: impl FnMut(f64) -> bool) -> Option<f64> {
    let step = 0.5;
    let hit = (0..(until / step) as u32).map(|index| f64::from(index) * step).find(|&range| inside(range))?;
    let (mut out, mut within) = ((hit - step).max(0.0), hit);
    for _ in 0..60 {
        let middle = 0.5 * (out + within);
        if inside(middle) { within = middle } else { out = middle }
    }
    Some(within)
}

/// Holds a marcher's answer against that of small steps, which may jump over a corner. `above` is the ray's height
/// above the surface at a range, metres; NaN where there is none.
fn assert_same(
    found: Option<f64>,
    until: f64,
    blocks: bool,
    mut above: impl FnMut(f64) -> f64,
) -> Result<(), TestCaseError> {
    let expected = by_small_steps(until, |range| above(range) <= 0.0);
    match (found, expected) {
        (Some(found), Some(expected)) if (found - expected).abs() <= 1e-6 * expected.max(1.0) => {}
        (Some(found), _) if expected.is_none_or(|expected| found < expected) => {
            let touch = if blocks { above(found + 1e-6) } else { above(found) };
            prop_assert!(touch < 1e-6 || touch.is_nan(), "{found}: {touch} m above, {expected:?}");
        }
        (found, Some(expected)) => prop_assert!(false, "{found:?} for {expected}"),
        (_, None) => {}
    }
    Ok(())
}

/// Height of a level's surface at a position in units, NaN where there is none.
fn height(cursor: &mut PageCursor<'_>, surface: Surface, level: u8, units: DVec2) -> f64 {
    let height = match surface {
        Surface::Smooth => cursor.smooth_height(level, units).unwrap(),
        Surface::Blocks => {
            let (voxel, _) = cursor.voxels(level).cell_at(units);
            cursor.height(level, voxel).unwrap().unwrap()
        }
    };
    height.unwrap_or(f64::NAN)
}

fn direction(yaw: f64, pitch: f64) -> DVec3 {
    Attitude { yaw, pitch, roll: 0.0 }.world_from_view().z_axis
}

fn surface(blocks: bool) -> Surface {
    if blocks { Surface::Blocks } else { Surface::Smooth }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_bent_ray_ends_where_small_steps_say(
        seed in 0_u32..50, blocks: bool,
        x in 0.0..100.0_f64, y in 0.0..70.0_f64, z in -50.0..500.0_f64,
        yaw in 0.0..360.0_f64, pitch in -90.0..40.0_f64,
    ) {
        let source = terrain(100, 70, hills(seed));
        let grid = source.header().grid;
        let eye = (grid.origin + DVec2::new(x, y) * 10.0).extend(z);
        let mut marcher =
            Marcher::new(&source, LevelBands::finest_only(), surface(blocks)).curved(TIGHT);
        let ray = marcher.ray(eye, direction(yaw, pitch));
        let found = marcher.first_contact(&ray, 0.0).unwrap().map(|contact| contact.range);
        let mut cursor = PageCursor::new(&source);
        assert_same(found, 2000.0, blocks, |range| {
            let ground = eye.truncate() + direction(yaw, pitch).truncate() * range;
            let drop = ground.distance_squared(eye.truncate()) / 10_000.0;
            let there = eye.z + direction(yaw, pitch).z * range;
            let inside = grid.contains(ground);
            let units = (ground - grid.origin) / grid.spacing;
            if inside { there + drop - height(&mut cursor, surface(blocks), 0, units) } else { f64::NAN }
        })?;
    }

    #[test]
    fn every_level_of_an_endless_area_ends_where_small_steps_say(
        seed in 0_u32..50, blocks: bool, bent: bool, level in 0_u8..4,
        nx in 1_u32..150, ny in 1_u32..150,
        x in -300.0..300.0_f64, y in -300.0..300.0_f64, z in 40.0..300.0_f64,
        yaw in 0.0..360.0_f64, pitch in -60.0..20.0_f64,
    ) {
        let source = terrain(nx, ny, hills(seed));
        let curvature = if bent { TIGHT } else { Curvature::FLAT };
        endless_against_small_steps(&source, level, blocks, curvature, DVec3::new(x, y, z), direction(yaw, pitch))?;
    }

    /// One post stands out, and the ray runs or falls where the surface rises to it across the seam.
    #[test]
    fn a_peak_is_seen_across_the_seam(
        nx in 1_u32..150, ny in 1_u32..150, level in 0_u8..4, east: bool, north: bool, lone: bool,
        along in 0.0..1.0_f64, near in -0.5..0.5_f64, near_too in -0.5..0.5_f64, corner: bool,
        z in 1.0..99.0_f64, quarter in 0_u8..4, turn in -0.2..0.2_f64, steep: bool, pitch in -3.0..0.0_f64,
    ) {
        let peak = [if east { nx - 1 } else { 0 }, if north { ny - 1 } else { 0 }];
        let source =
            terrain(nx, ny, |x, y| if x == peak[0] && (y == peak[1] || !lone) { 100.0 } else { 0.0 });
        let side = 4_f64.powi(i32::from(level));
        let y = if corner { near_too * side } else { along * f64::from(ny) };
        let eye = DVec3::new(near * side, y, z);
        let pitch = if steep { -90.0 - pitch } else { pitch };
        let way = direction(90.0 * f64::from(quarter) + turn, pitch);
        endless_against_small_steps(&source, level, false, Curvature::FLAT, eye, way)?;
    }

    #[test]
    fn an_endless_area_is_its_copies_side_by_side(
        seed in 0_u32..50, blocks: bool, nx in 1_u32..90, ny in 1_u32..90,
        u in 0.0..1.0_f64, v in 0.0..1.0_f64, z in 100.0..260.0_f64,
        yaw in 0.0..360.0_f64, pitch in -60.0..5.0_f64,
    ) {
        let finest = |_: &MemPages| LevelBands::finest_only();
        compare_with_copies([nx, ny], seed, blocks, finest, [u, v], z, direction(yaw, pitch))?;
    }

    /// Whole voxels of every level: then the copies' coarser levels are the same, too.
    #[test]
    fn an_endless_area_of_whole_voxels_is_its_copies_at_every_level(
        seed in 0_u32..50, blocks: bool, wide in 1_u32..3, high in 1_u32..4,
        u in 0.0..1.0_f64, v in 0.0..1.0_f64, z in 100.0..260.0_f64,
        yaw in 0.0..360.0_f64, pitch in -60.0..5.0_f64,
    ) {
        let all = |source: &MemPages| LevelBands::new(&source.header().grid, 4, 0.5, -1.0e3, 1.0);
        compare_with_copies([64 * wide, 64 * high], seed, blocks, all, [u, v], z, direction(yaw, pitch))?;
    }

    #[test]
    fn no_level_has_a_crack_at_the_seam(
        seed in 0_u32..50, nx in 1_u32..300, ny in 1_u32..300, level in 0_u8..4,
        along in 0.0..2000.0_f64, shift in -0.5..0.5_f64, copies in -3_i32..3,
    ) {
        let source = terrain(nx, ny, |x, y| noise(x, y, seed) * 100.0);
        let mut cursor = PageCursor::new(&source).endless();
        let mut at = |x: f64, y: f64| cursor.smooth_height(level, DVec2::new(x, y)).unwrap().unwrap();
        let (step, side) = (1e-7, 4_f64.powi(i32::from(level)));
        for (period, turned) in [(f64::from(nx), false), (f64::from(ny), true)] {
            let mut at = |x: f64| if turned { at(along, x) } else { at(x, along) };
            let seam = f64::from(copies) * period;
            // The seam itself, the last post before it, the first one behind it, and anywhere between.
            for x in [seam, seam - 0.5 * side, seam + 0.5 * side, seam + shift * side] {
                // Nowhere steeper than all heights within the narrowest cell, one unit.
                let jump = (at(x + step) - at(x - step)).abs();
                prop_assert!(jump < 100.0 * 2.0 * step * 1.01 + 1e-9, "{jump} m at {x}");
                prop_assert!((at(x + 5.0 * period) - at(x)).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn range_coherence_holds_on_a_bent_endless_area(
        seed in 0_u32..20, yaw in 0.0..360.0_f64, z in 160.0..600.0_f64, nx in 40_u32..200,
    ) {
        let source = terrain(nx, 70, hills(seed));
        let grid = source.header().grid;
        let pose = Pose { eye: grid.origin.extend(z), attitude: Attitude { yaw, ..Attitude::default() }, hfov: 70.0 };
        let camera = Camera::new(pose, 24, 150);
        let bands = LevelBands::new(&grid, 4, camera.pixel_angle(), z - source.header().height_range.high, 1.0);
        let mut marcher = Marcher::new(&source, bands, Surface::Smooth).curved(TIGHT).endless(4000.0);
        for column in [0, 11, 23] {
            let coherent = march_column(&mut marcher, &camera, column).unwrap();
            for (row, contact) in coherent.iter().enumerate() {
                let ray = marcher.ray(pose.eye, camera.direction(f64::from(column) + 0.5, row as f64 + 0.5));
                match (contact, marcher.first_contact(&ray, 0.0).unwrap()) {
                    (Some(a), Some(b)) => prop_assert!((a.range - b.range).abs() <= 1e-9 * b.range, "{a:?} {b:?}"),
                    (a, b) => prop_assert!(a.is_none() && b.is_none(), "{a:?} {b:?}"),
                }
            }
        }
    }
}

/// Holds a level of an endless area against small steps, from an eye in units, units and metres.
fn endless_against_small_steps(
    source: &MemPages,
    level: u8,
    blocks: bool,
    curvature: Curvature,
    eye: DVec3,
    direction: DVec3,
) -> Result<(), TestCaseError> {
    let origin = source.header().grid.origin;
    let eye = (origin + eye.truncate() * 10.0).extend(eye.z);
    let mut marcher =
        Marcher::new(source, only(source, level), surface(blocks)).curved(curvature).endless(1500.0);
    let ray = marcher.ray(eye, direction);
    let found = marcher.first_contact(&ray, 0.0).unwrap().map(|contact| contact.range);
    let mut cursor = PageCursor::new(source).endless();
    assert_same(found, (1500.0 / ray.ground_cosine).min(3000.0), blocks, |range| {
        let point = ray.at(range);
        point.z - height(&mut cursor, surface(blocks), level, point.truncate())
    })
}

/// Holds an endless area against a database of 3 × 3 copies of it, for an eye in the middle one.
fn compare_with_copies(
    [nx, ny]: [u32; 2],
    seed: u32,
    blocks: bool,
    bands: impl Fn(&MemPages) -> LevelBands,
    [u, v]: [f64; 2],
    z: f64,
    direction: DVec3,
) -> Result<(), TestCaseError> {
    let one = terrain(nx, ny, hills(seed));
    let nine = terrain(3 * nx, 3 * ny, |x, y| hills(seed)(x % nx, y % ny));
    let eye = DVec2::new((1.0 + u) * f64::from(nx), (1.0 + v) * f64::from(ny));
    let eye = (one.header().grid.origin + eye * 10.0).extend(z);
    let mut endless = Marcher::new(&one, bands(&one), surface(blocks)).endless(1.0e4);
    let mut copies = Marcher::new(&nine, bands(&nine), surface(blocks));
    let ray = copies.ray(eye, direction);

    // Where copies end, so do their neighbours' posts.
    let is_within = |contact: &Contact| {
        let margin = 0.5 * 4_f64.powi(i32::from(contact.level)) + 1e-6;
        let at = ray.at(contact.range);
        let inside = |at: f64, side: u32| at > margin && at < f64::from(3 * side) - margin;
        inside(at.x, nx) && inside(at.y, ny)
    };
    let found = endless.first_contact(&ray, 0.0).unwrap();
    let expected = copies.first_contact(&ray, 0.0).unwrap();

    if found.iter().chain(&expected).all(is_within) {
        match (found, expected) {
            (Some(found), Some(expected)) => {
                prop_assert!(
                    (found.range - expected.range).abs() <= 1e-9 * expected.range.max(1.0),
                    "{found:?} {expected:?}"
                );
                prop_assert_eq!((found.level, found.face), (expected.level, expected.face));
            }
            (Some(found), None) => prop_assert!(false, "{:?} where the copies have none", found),
            (None, Some(expected)) => prop_assert!(false, "missed {:?}", expected),
            (None, None) => {}
        }
    }

    Ok(())
}

#[test]
fn a_bent_ray_meets_a_plane_at_the_root_of_its_parabola() {
    let source = terrain(400, 400, |_, _| 100.0);
    let c = TIGHT.inverse_diameter;
    let eye = (source.header().grid.origin + DVec2::new(55.0, 2000.0)).extend(103.0);
    let mut hits = 0;

    for tenths in 1..60 {
        let pitch = -0.1 * f64::from(tenths);
        for level in 0..4 {
            // It is lowest in the middle of a voxel more often than at its border.
            let mut marcher = Marcher::new(&source, only(&source, level), Surface::Smooth).curved(TIGHT);
            let ray = marcher.ray(eye, direction(90.0, pitch));
            let found = marcher.first_contact(&ray, 0.0).unwrap().map(|contact| contact.range);
            let slope = pitch.to_radians().tan();
            let square = slope * slope - 4.0 * c * (3.0 - source.header().heights.scale);
            if square.abs() < 1e-6 {
                continue;
            }

            let exact = (square > 0.0).then(|| (-slope - square.sqrt()) / (2.0 * c) / ray.ground_cosine);
            hits += u32::from(exact.is_some());
            match (found, exact) {
                (Some(found), Some(exact)) => {
                    assert!((found - exact).abs() < 0.1, "{pitch}: {found} {exact}")
                }
                (found, exact) => assert!(found.is_none() && exact.is_none(), "{pitch}: {found:?} {exact:?}"),
            }
        }
    }

    assert!(hits > 100 && hits < 59 * 4 - 20, "{hits}");
}

#[test]
fn a_peak_in_a_corner_is_seen_from_all_four_copies_that_meet_there() {
    for [nx, ny] in [[7, 9], [130, 70], [64, 129]] {
        for peak in [[0, 0], [nx - 1, 0], [0, ny - 1], [nx - 1, ny - 1]] {
            let source = terrain(nx, ny, |x, y| if [x, y] == peak { 100.0 } else { 0.0 });
            let mut cursor = PageCursor::new(&source).endless();
            for level in 0..4 {
                let side = 4_f64.powi(i32::from(level)).min(f64::from(nx.min(ny)));
                let top =
                    cursor.height(level, peak.map(|post| i64::from(post) / 4_i64.pow(u32::from(level))));
                for quadrant in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
                    // Level, across one quadrant around the corner, below the surface only in its middle.
                    let place = |x: f64, y: f64| DVec2::new(x * quadrant.0, y * quadrant.1) * side;
                    let (eye, way) = (place(0.4, 0.01), place(-0.39, 0.39).normalize().extend(0.0));
                    let z = 0.07 * top.as_ref().unwrap().unwrap().unwrap();
                    endless_against_small_steps(&source, level, false, Curvature::FLAT, eye.extend(z), way)
                        .unwrap();
                }
            }
        }
    }
}

#[test]
fn rays_that_never_meet_an_endless_plane_end() {
    let source = terrain(5, 3, |_, _| 100.0);
    let eye = source.header().grid.origin.extend(110.0);
    for far in [500.0, f64::INFINITY] {
        let mut marcher = Marcher::new(&source, LevelBands::finest_only(), Surface::Smooth).endless(far);
        let mut end = |pitch: f64| {
            let ray = marcher.ray(eye, direction(30.0, pitch));
            marcher.first_contact(&ray, 0.0).unwrap().map(|contact| contact.range)
        };
        assert_eq!(end(0.0), None);
        assert_eq!(end(1e-9), None);
        assert_eq!(end(90.0), None);
        assert_eq!(end(-1e-9), None, "beyond every end");
        assert_eq!(end(-1.0).is_some(), far.is_infinite(), "at 573 m");
        assert!((end(-90.0).unwrap() - 10.0).abs() < 1e-3);
        assert!((end(-2.0).unwrap() - 10.0 / 2_f64.to_radians().sin()).abs() < 0.1);
    }
}

#[test]
fn attributes_colours_and_ground_repeat_with_the_area() {
    let source = terrain(30, 20, |x, _| f64::from(x));
    let grid = source.header().grid;
    let mut filter = SurfaceFilter::new(&source, crate::space::Footprint::Angle(1e-3)).endless();
    let mut marcher = Marcher::new(&source, LevelBands::finest_only(), Surface::Smooth).endless(1e4);
    let mut seen = |x: f64| {
        let ray = marcher.ray((grid.origin + DVec2::new(x, 77.0)).extend(500.0), DVec3::NEG_Z);
        let contact = marcher.first_contact(&ray, 0.0).unwrap().unwrap();
        filter.sample(&ray, &contact).unwrap()
    };

    for x in [3.0, 150.0, 299.0] {
        let (here, there) = (seen(x), seen(x - 900.0));
        assert!((here.normal - there.normal).length() < 1e-5 && here.albedo == there.albedo);
        let place = grid.origin + DVec2::new(x, 77.0);
        let ground = |place| endless_ground_height(&source, place).unwrap().unwrap();
        assert!((ground(place) - ground(place + DVec2::new(600.0, -400.0))).abs() < 1e-6);
        assert_eq!(ground_height(&source, place + DVec2::new(600.0, 0.0)).unwrap(), None);
    }

    // From 29 m down to 0 m over the seam: halfway on it, by central differences over two voxels.
    assert!((endless_ground_height(&source, grid.origin).unwrap().unwrap() - 14.5).abs() < 1e-2);
    let tilt = seen(0.0).normal;
    assert!(tilt.x > 0.5, "{tilt}");
}
