//! Hilly ground, so large that only a part of it is seen at a time: for flights that have its pages come and go.

use std::path::Path;

use glam::DVec2;
use hedgehop::voxel::{Arrays, Grid, Metadata, write_arrays};

const SIDE: u32 = 3000;

/// Writes its database: six kilometres each way, between 116 and 284 m high.
pub fn write_hills(path: &Path) {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 2.0, origin: DVec2::ZERO };
    let posts = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (f64::from(x), f64::from(y))));
    let heights: Vec<f64> = posts
        .map(|(x, y)| {
            200.0 + 50.0 * (x / 90.0).sin() + 30.0 * (y / 70.0).cos() + 4.0 * ((x + y) / 11.0).sin()
        })
        .collect();
    let colours: Vec<_> = (0..heights.len()).map(|post| [(post / 7 % 200) as u8, 110, 80]).collect();
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    write_arrays(path, &arrays, &Metadata::default(), false).unwrap();
}
