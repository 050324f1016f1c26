//! Small areas, and the edges of larger ones, against the reference marcher.

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::profiles::{ALL, ROWS, Sparse, View, compare, noise};
use hedgehop::simd::{Isa, LANES};
use hedgehop::voxel::{Grid, MemPages, Metadata, PageSource, build_in_memory};

/// Relative error of a range that counts as one: silhouettes before farther ground.
const WRONG: f64 = 0.02;

/// Hills over a few voxels of 2 m, from 0 to 14 m.
fn area(nx: u32, ny: u32, seed: u32) -> MemPages {
    let grid = Grid { nx, ny, spacing: 2.0, origin: DVec2::new(500.0, 400.0) };
    let posts = (0..nx * ny).map(|post| (f64::from(post % nx), f64::from(post / nx)));
    let heights: Vec<f64> =
        posts.map(|(x, y)| 12.0 * noise(x / 5.0, y / 5.0, seed) + 2.0 * noise(x, y, seed ^ 3)).collect();
    let colours = vec![[128; 3]; heights.len()];
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

/// Share of the pixels of a view of an area that are wrong. Place: units from the south-west corner.
fn wrong(source: &impl PageSource, place: DVec2, z: f64, yaw: f64, elevations: [f64; 2]) -> f64 {
    let grid = source.header().grid;
    let eye: DVec3 = (grid.origin + place * grid.spacing).extend(z);
    let view = View { eye, yaw, elevations, pixel: 0.0006 };
    let (errors, disagree) = compare(&view.march(source, Isa::best()), &view.truth(source));
    let off = errors.iter().filter(|&&error| error > WRONG).count();
    disagree + off as f64 / (ROWS * LANES) as f64
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn small_areas_are_seen_up_to_their_edges(
        nx in 1_u32..=16, ny in 1_u32..=16, seed in 0_u32..100, at in (-0.2..1.2_f64, -0.2..1.2_f64),
        z in 14.5..200.0_f64, yaw in 0.0..360.0_f64, low in 0.0..60.0_f64, extent in 3.0..40.0_f64,
    ) {
        let source = area(nx, ny, seed);
        let place = DVec2::new(at.0 * f64::from(nx), at.1 * f64::from(ny));
        let wrong = wrong(&source, place, z, yaw, [low - 89.9, low - 89.9 + extent]);
        prop_assert!(wrong <= 0.04, "{wrong}");
    }

    /// The eye beside one of four edges or corners, by at most a voxel.
    #[test]
    fn edges_are_seen_from_above_them(
        seed in 0_u32..100, edge in (0..3, 0..3), beside in (-1.0..1.0_f64, -1.0..1.0_f64), along in 0.0..1.0_f64,
        height in 0.0..1.0_f64, yaw in 0.0..360.0_f64, low in 0.0..1.0_f64, extent in 3.0..40.0_f64,
    ) {
        let (nx, ny) = (90, 70);
        let source = area(nx, ny, seed);
        // Low above the ground, and straight down, more often than not.
        let (z, low) = (14.5 + 45.0 * height.powi(3), 60.0 * low.powi(3));
        let beside_of = |edge: i32, size: u32, beside: f64| match edge {
            0 => beside,
            1 => f64::from(size) * along,
            _ => f64::from(size) + beside,
        };
        let place = DVec2::new(beside_of(edge.0, nx, beside.0), beside_of(edge.1, ny, beside.1));
        let wrong = wrong(&source, place, z, yaw, [low - 89.9, low - 89.9 + extent]);
        prop_assert!(wrong <= 0.04, "{wrong}");
    }

    /// Where coarser voxels stand in, half of one is several units.
    #[test]
    fn edges_of_coarse_areas_are_seen_from_above_them(
        nx in 17_u32..200, ny in 17_u32..200, at in (0.0..1.0_f64, 0.0..1.0_f64),
        z in 14.5..200.0_f64, yaw in 0.0..360.0_f64, low in 0.0..60.0_f64, extent in 3.0..40.0_f64,
    ) {
        let all = area(nx, ny, 1);
        let source = Sparse { all: &all, hidden: ALL };
        let place = DVec2::new(at.0 * f64::from(nx), at.1 * f64::from(ny));
        let wrong = wrong(&source, place, z, yaw, [low - 89.9, low - 89.9 + extent]);
        prop_assert!(wrong <= 0.04, "{wrong}");
    }
}
