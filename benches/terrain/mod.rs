//! Synthetic terrain in memory, for all benches.

use glam::DVec2;
use hedgehop::voxel::{Grid, MemPages, Metadata, build_in_memory};

/// Voxels along a side.
pub const SIDE: u32 = 1024;
/// Names, and heights of the highest hills in metres.
pub const ROUGHNESS: [(&str, f64); 3] = [("plain", 2.0), ("hills", 80.0), ("mountains", 600.0)];

/// 5 km by 5 km of hills in five octaves, the highest of `amplitude` metres.
pub fn area(amplitude: f64) -> MemPages {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 5.0, origin: DVec2::ZERO };
    let places = || (0..SIDE * SIDE).map(|index| (f64::from(index % SIDE), f64::from(index / SIDE)));
    let heights: Vec<f64> = places().map(|(x, y)| amplitude * relief(x, y)).collect();
    let colours: Vec<[u8; 3]> =
        heights.iter().map(|height| [90, 120 + (height.abs() as u32 % 100) as u8, 60]).collect();
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).expect("a sound grid")
}

/// Sum of waves, each half as long, half as high and turned against the one before; within −1…1.
fn relief(x: f64, y: f64) -> f64 {
    let octave = |n: i32| {
        let (sin, cos) = (1.3 * f64::from(n)).sin_cos();
        let (u, v) = (cos * x - sin * y, sin * x + cos * y);
        let wave = 0.02 * 2_f64.powi(n);
        0.5_f64.powi(n + 1) * (wave * u).sin() * (0.8 * wave * v).cos()
    };
    (0..5).map(octave).sum()
}
