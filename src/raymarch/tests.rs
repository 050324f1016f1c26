//! The marcher against closed forms and against a naive oracle.

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::*;
use crate::space::{Attitude, Camera, Footprint, Pose};
use crate::voxel::{Attributes, Grid, HeightCode, MemPages, Metadata, PageSource, build_in_memory};

pub(super) fn terrain(nx: u32, ny: u32, height: impl Fn(u32, u32) -> f64) -> MemPages {
    terrain_of(nx, ny, &height)
}

/// Builds a terrain; compiled once for all closures.
fn terrain_of(nx: u32, ny: u32, height: &dyn Fn(u32, u32) -> f64) -> MemPages {
    let grid = Grid { nx, ny, spacing: 10.0, origin: DVec2::new(500_000.0, 4_000_000.0) };
    let heights: Vec<f64> =
        (0..ny).flat_map(|y| (0..nx).map(move |x| (x, y))).map(|(x, y)| height(x, y)).collect();
    let colours = vec![[128; 3]; heights.len()];
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

/// A repeatable number in 0..1 for integers.
pub(super) fn noise(x: u32, y: u32, seed: u32) -> f64 {
    let mut bits = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    bits = (bits ^ bits >> 15).wrapping_mul(0x2C1B_3C6D);
    bits = (bits ^ bits >> 12).wrapping_mul(0x297A_2D39);
    f64::from(bits ^ bits >> 15) / f64::from(u32::MAX)
}

pub(super) fn hills(seed: u32) -> impl Fn(u32, u32) -> f64 {
    move |x, y| {
        let broad = noise(x / 16, y / 16, seed) * 150.0;
        if noise(x, y, seed ^ 7) > 0.985 { f64::NAN } else { broad + noise(x, y, seed) * 40.0 }
    }
}

/// How far along a ray the oracle looks, in metres: past the area for all but rays that fall through a void.
const REACH: f64 = 3000.0;

/// First range up to [`REACH`] at which the ray is on or under level 1's surface: small steps, then bisection.
fn naive_contact(source: &MemPages, surface: Surface, ray: &GridRay) -> Option<f64> {
    let header = source.header();
    let mut cursor = PageCursor::new(source);
    let size = DVec2::new(f64::from(header.grid.nx), f64::from(header.grid.ny));

    let mut inside = |range: f64| {
        let point = ray.at(range);
        if point.cmplt(DVec3::new(0.0, 0.0, f64::MIN)).any() || point.x > size.x || point.y > size.y {
            return false;
        }

        let height = match surface {
            Surface::Smooth => cursor.smooth_height(0, point.truncate()).unwrap(),
            Surface::Blocks => {
                let cell = [point.x, point.y].map(|position| position.floor() as i64);
                let cell = [0, 1].map(|axis| cell[axis].min(cursor.dims(0)[axis] - 1));
                cursor.height(0, cell).unwrap().unwrap()
            }
        };

        height.is_some_and(|height| point.z <= height)
    };

    let step = 0.05 * header.grid.spacing;
    let mut range = 0.0;
    while range < REACH {
        if inside(range) {
            let (mut out, mut within) = ((range - step).max(0.0), range);
            for _ in 0..60 {
                let middle = 0.5 * (out + within);
                if inside(middle) { within = middle } else { out = middle }
            }
            return Some(within);
        }
        range += step;
    }

    None
}

fn contact(source: &MemPages, surface: Surface, ray: &GridRay) -> Option<f64> {
    let mut marcher = Marcher::new(source, LevelBands::finest_only(), surface);
    marcher.first_contact(ray, 0.0).unwrap().map(|contact| contact.range)
}

/// Returns the height of a place on a ray above the smooth surface, metres; `None` in a void and beside the area.
fn clearance(source: &MemPages, ray: &GridRay, range: f64) -> Option<f64> {
    let grid = source.header().grid;
    let (point, size) = (ray.at(range), DVec2::new(f64::from(grid.nx), f64::from(grid.ny)));
    let units = point.truncate();
    if units.cmplt(DVec2::ZERO).any() || units.cmpgt(size).any() {
        return None;
    }
    PageCursor::new(source).smooth_height(0, units).unwrap().map(|height| point.z - height)
}

/// How far in metres a ray stays above the surface up to [`REACH`]; small: it grazes, and small steps may miss it.
fn least_clearance(source: &MemPages, ray: &GridRay) -> f64 {
    let mut cursor = PageCursor::new(source);
    (0..2000)
        .map(|index| REACH * f64::from(index) / 2000.0)
        .filter_map(|range| {
            let point = ray.at(range);
            cursor.smooth_height(0, point.truncate()).unwrap().map(|height| point.z - height)
        })
        .fold(f64::INFINITY, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn agrees_with_the_naive_oracle(
        seed in 0_u32..50,
        blocks: bool,
        x in -20.0..120.0_f64, y in -20.0..90.0_f64, z in -50.0..500.0_f64,
        yaw in 0.0..360.0_f64, pitch in -90.0..40.0_f64,
    ) {
        let source = terrain(100, 70, hills(seed));
        let grid = source.header().grid;
        let eye = DVec3::new(grid.origin.x + x * 10.0, grid.origin.y + y * 10.0, z);
        let direction = Attitude { yaw, pitch, roll: 0.0 }.world_from_view().z_axis;
        let ray = GridRay::new(&grid, eye, direction);
        let surface = if blocks { Surface::Blocks } else { Surface::Smooth };

        // A steep ray through a void can meet the far wall below what the oracle walks.
        let found = contact(&source, surface, &ray).filter(|&range| range < REACH);
        let expected = naive_contact(&source, surface, &ray);
        match (found, expected) {
            // The oracle's steps of half a metre can jump over a corner that the marcher sees: the ray comes under the surface there, through it, or through
            // a wall beside a void or beside the area.
            (Some(found), Some(expected)) if found < expected - 1e-6 => {
                if blocks {
                    return Ok(());
                }
                let [before, after] = [found - 1e-6, found + 1e-6].map(|range| clearance(&source, &ray, range));
                prop_assert!(before.is_none_or(|above| above > -1e-6), "{before:?} above at {found}, {expected}");
                prop_assert!(after.is_some_and(|above| above < 1e-6), "{after:?} above at {found}, {expected}");
            }
            (Some(found), Some(expected)) => prop_assert!((found - expected).abs() < 1e-6 * expected.max(1.0)),
            (Some(_), None) => prop_assert!(blocks || least_clearance(&source, &ray) < 5.0),
            (None, Some(expected)) => prop_assert!(false, "missed the surface at {expected}"),
            (None, None) => {}
        }
    }

    #[test]
    fn range_coherence_changes_nothing(seed in 0_u32..20, yaw in 0.0..360.0_f64, hfov in 20.0..110.0_f64, z in 160.0..600.0_f64) {
        let source = terrain(300, 200, hills(seed));
        let grid = source.header().grid;
        let eye = (grid.origin + DVec2::new(1500.0, 1000.0)).extend(z);
        let camera = Camera::new(Pose { eye, attitude: Attitude { yaw, ..Attitude::default() }, hfov }, 24, 200);
        let bands = LevelBands::new(&grid, 4, camera.pixel_angle(), z - source.header().height_range.high, 1.0);
        let mut marcher = Marcher::new(&source, bands, Surface::Smooth);
        for column in [0, 11, 23] {
            let coherent = march_column(&mut marcher, &camera, column).unwrap();
            for (row, contact) in coherent.iter().enumerate() {
                let direction = camera.direction(f64::from(column) + 0.5, row as f64 + 0.5);
                let alone = marcher.first_contact(&GridRay::new(&grid, eye, direction), 0.0).unwrap();
                match (contact, alone) {
                    (Some(a), Some(b)) => prop_assert!((a.range - b.range).abs() <= 1e-9 * b.range, "{a:?} {b:?}"),
                    (a, b) => prop_assert!(a.is_none() && b.is_none(), "{a:?} {b:?}"),
                }
            }
        }
    }
}

#[test]
fn a_plane_is_hit_at_the_closed_form() {
    let source = terrain(2000, 2000, |_, _| 120.0);
    let grid = source.header().grid;
    let eye = (grid.origin + DVec2::splat(10_000.0)).extend(320.0);
    let camera = Camera::new(
        Pose { eye, attitude: Attitude { yaw: 77.0, pitch: -8.0, roll: 15.0 }, hfov: 60.0 },
        160,
        90,
    );
    let bands = LevelBands::new(&grid, 4, camera.pixel_angle(), 200.0, 1.0);
    let mut marcher = Marcher::new(&source, bands, Surface::Smooth);
    for (column, row) in [(3.5, 80.5), (80.5, 45.5), (155.5, 60.5), (80.5, 89.5)] {
        let direction = camera.direction(column, row);
        let range = marcher.first_contact(&GridRay::new(&grid, eye, direction), 0.0).unwrap().unwrap().range;
        let exact = 200.0 / -direction.z;
        assert!((range / exact - 1.0).abs() < 1e-6, "{range} {exact}");
    }
}

#[test]
fn a_ramp_is_hit_at_the_closed_form_at_every_level() {
    let (east, north) = (0.05, -0.02);
    let source = terrain(4000, 300, |x, y| {
        200.0 + east * (f64::from(x) + 0.5) * 10.0 + north * (f64::from(y) + 0.5) * 10.0
    });
    let grid = source.header().grid;
    let local = DVec2::new(500.0, 1500.0);
    let eye = (grid.origin + local).extend(600.0);
    let mut levels = std::collections::BTreeSet::new();

    for pitch in [-80.0, -40.0, -20.0, -10.0, -5.0, -1.0, 0.5] {
        let direction = Attitude { yaw: 90.0, pitch, roll: 0.0 }.world_from_view().z_axis;
        let bands = LevelBands::new(&grid, 4, 0.02, -100.0, 1.0);
        let mut marcher = Marcher::new(&source, bands, Surface::Smooth);
        let contact = marcher.first_contact(&GridRay::new(&grid, eye, direction), 0.0).unwrap().unwrap();
        levels.insert(contact.level);
        let above = 600.0 - (200.0 + east * local.x + north * local.y);
        let exact = above / (east * direction.x + north * direction.y - direction.z);
        assert!((contact.range / exact - 1.0).abs() < 1e-4, "pitch {pitch}: {} {exact}", contact.range);
    }

    assert!(levels.len() >= 3, "the ramp was seen at levels {levels:?} only");
}

#[test]
fn an_eye_under_the_surface_sees_it_at_range_zero() {
    let source = terrain(64, 64, |_, _| 100.0);
    let grid = source.header().grid;
    let eye = (grid.origin + DVec2::splat(300.0)).extend(90.0);
    for pitch in [-90.0, -10.0, 0.0, 60.0, 90.0] {
        let direction = Attitude { yaw: 10.0, pitch, roll: 0.0 }.world_from_view().z_axis;
        assert_eq!(contact(&source, Surface::Smooth, &GridRay::new(&grid, eye, direction)), Some(0.0));
    }
}

#[test]
fn a_vertical_ray_ends_on_the_ground_or_passes_through_a_hole() {
    let source = terrain(64, 64, |x, _| if (20..40).contains(&x) { f64::NAN } else { 50.0 });
    let grid = source.header().grid;
    let down = |x: f64| {
        let eye = (grid.origin + DVec2::new(x, 105.0)).extend(450.0);
        contact(&source, Surface::Smooth, &GridRay::new(&grid, eye, DVec3::NEG_Z))
    };
    let code = HeightCode::spanning(50.0, 50.0);
    assert!((down(105.0).unwrap() - 400.0).abs() <= code.scale);
    assert_eq!(down(305.0), None);
}

#[test]
fn a_step_casts_its_silhouette_where_geometry_says() {
    let source = terrain(400, 100, |x, _| if x < 200 { 0.0 } else { 80.0 });
    let grid = source.header().grid;
    let eye = (grid.origin + DVec2::new(500.0, 500.0)).extend(40.0);
    let camera = Camera::new(
        Pose { eye, attitude: Attitude { yaw: 90.0, ..Attitude::default() }, hfov: 60.0 },
        100,
        200,
    );
    let mut marcher = Marcher::new(&source, LevelBands::finest_only(), Surface::Blocks);
    let column = march_column(&mut marcher, &camera, 50).unwrap();
    let first_ground = column.iter().position(|contact| contact.is_some()).unwrap() as f64;
    // The wall stands 1500 m ahead and rises 40 m above the eye.
    let edge = camera.screen_from_world(eye + DVec3::new(1500.0, 0.0, 40.0)).unwrap().y;
    assert!((first_ground - edge).abs() <= 1.0, "{first_ground} {edge}");
}

#[test]
fn a_ray_that_starts_outside_meets_the_side_of_the_area() {
    let source = terrain(64, 64, |_, _| 100.0);
    let grid = source.header().grid;
    let eye = (grid.origin + DVec2::new(-200.0, 300.0)).extend(20.0);
    let range = contact(&source, Surface::Smooth, &GridRay::new(&grid, eye, DVec3::X)).unwrap();
    assert!((range - 200.0).abs() < 1e-9);
}

#[test]
fn a_wall_has_the_attributes_of_its_own_voxel() {
    let grid = Grid { nx: 20, ny: 20, spacing: 10.0, origin: DVec2::ZERO };
    // A pillar of 4 × 4 voxels.
    let is_pillar = |voxel: u32| (8..12).contains(&(voxel % 20)) && (8..12).contains(&(voxel / 20));
    let heights: Vec<f64> = (0..400).map(|voxel| if is_pillar(voxel) { 90.0 } else { 0.0 }).collect();
    let attributes: Vec<Attributes> = (0..400)
        .map(|voxel| Attributes { source: u16::from(is_pillar(voxel)), ..Attributes::default() })
        .collect();
    let colours = vec![[128; 3]; heights.len()];
    let source = build_in_memory(grid, &heights, &colours, Some(&attributes), &Metadata::default()).unwrap();
    let mut marcher = Marcher::new(&source, LevelBands::finest_only(), Surface::Blocks);
    let mut filter = SurfaceFilter::new(&source, Footprint::Angle(0.001));
    for direction in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y] {
        let ray = GridRay::new(&grid, DVec3::new(101.0, 101.0, 40.0) - 90.0 * direction, direction);
        let contact = marcher.first_contact(&ray, 0.0).unwrap().unwrap();
        assert_eq!(contact.face, Some(-direction), "{direction}");
        assert_eq!(filter.sample(&ray, &contact).unwrap().attributes.source, 1, "{direction}");
    }
}

#[test]
fn bands_of_levels_that_the_database_lacks_show_its_coarsest() {
    let source = terrain(64, 64, |_, _| 100.0);
    let grid = source.header().grid;
    let bands = LevelBands::new(&grid, grid.level_count() + 2, 1.0, -1.0, 1.0e-3);
    let mut marcher = Marcher::new(&source, bands, Surface::Smooth);
    let eye = (grid.origin + DVec2::new(5.0, 320.0)).extend(130.0);
    let direction = Attitude { yaw: 90.0, pitch: -4.0, roll: 0.0 }.world_from_view().z_axis;
    let contact = marcher.first_contact(&GridRay::new(&grid, eye, direction), 0.0).unwrap().unwrap();
    assert_eq!(contact.level, grid.level_count() - 1);
}

#[test]
fn a_ramp_has_one_normal_up_to_the_edge_of_the_area() {
    let source = terrain(64, 64, |x, _| 3.0 * f64::from(x));
    let grid = source.header().grid;
    let mut filter = SurfaceFilter::new(&source, Footprint::Angle(1.0e-3));
    for x in [0.2, 4.0, 100.0, 320.0, 636.0, 639.9] {
        let eye = (grid.origin + DVec2::new(x, 333.0)).extend(400.0);
        let ray = GridRay::new(&grid, eye, DVec3::NEG_Z);
        let range = contact(&source, Surface::Smooth, &ray).unwrap();
        let sample =
            filter.sample(&ray, &Contact { range, level: 0, wanted: 0, face: None, bare: false }).unwrap();
        let expected = DVec3::new(-0.3, 0.0, 1.0).normalize().as_vec3();
        assert!((sample.normal - expected).length() < 1e-3, "{x}: {:?}", sample.normal);
    }
}
