//! Heights for voids.
//!
//! Inverse-distance weighting from the nearest valid voxels in sixteen directions (as GDAL's fillnodata does, in
//! eight): `h = Σ hₖ/dₖ² / Σ 1/dₖ²`. A direction that meets nothing within [`REACH`] voxels contributes
//! the source's coarse surface (see [`crate::elevation_survey`]) at that distance. So a void's rim joins the terrain around
//! it, and the middle of a wide one follows the broad shape. A value depends only on voxels within
//! the reach: pages agree on their common samples.

use crate::mosaic::Surface;
use crate::warp::{LevelGrid, Rect};
use hedgehop::voxel::Grid;

/// Distance to which valid voxels are sought, voxels.
pub(super) const REACH: u32 = 64;

/// Finds the small voids of `rect`, a part of `surface`: all around them are heights, and they are no longer or wider than a number of voxels
/// of this level. Voxels that touch at a corner are of one void. `surface` must reach [`REACH`] voxels around `rect` or to the grid's edge; a void
/// that leaves it is too long, so that the answer is the same from whichever page a void is seen.
pub(super) fn small(surface: &Surface, rect: Rect, level: &LevelGrid) -> Vec<bool> {
    let around = surface.rect;
    let voids = surface.voids();
    let (width, height) = (around.width(), (around.y1 - around.y0) as usize);
    let most = (REACH / Grid::side_units(level.level)).max(1) as usize;
    let mut is_small = vec![false; voids.len()];
    let mut is_known = vec![false; voids.len()];
    let mut members = Vec::new();

    for first in (0..voids.len()).filter(|index| voids[*index]) {
        if is_known[first] {
            continue;
        }

        // All that hangs together with it.
        is_known[first] = true;
        members.clear();
        members.push(first);
        let ([mut west, mut south], [mut east, mut north]) = ([usize::MAX; 2], [0; 2]);
        let mut is_enclosed = true;
        let mut next = 0;

        while let Some(index) = members.get(next).copied() {
            next += 1;
            let (x, y) = (index % width, index / width);
            (west, east) = (west.min(x), east.max(x));
            (south, north) = (south.min(y), north.max(y));
            is_enclosed &= x > 0 && y > 0 && x + 1 < width && y + 1 < height;

            for y in y.saturating_sub(1)..(y + 2).min(height) {
                for x in x.saturating_sub(1)..(x + 2).min(width) {
                    let beside = y * width + x;
                    if voids[beside] && !is_known[beside] {
                        is_known[beside] = true;
                        members.push(beside);
                    }
                    // Beside all rasters there is nothing that could enclose it.
                    is_enclosed &= voids[beside] || !surface.heights[beside].is_nan();
                }
            }
        }

        if is_enclosed && east - west < most && north - south < most {
            members.iter().for_each(|index| is_small[*index] = true);
        }
    }

    rect.rows_in(around).flat_map(|row| is_small[row].to_vec()).collect()
}

/// Whether a block may have small voids: not if there are none, nor in the middle of a wide one.
pub(super) fn may_have_small(rect: Rect, voids: &[bool]) -> bool {
    let is_long = rect.x1 - rect.x0 > REACH || rect.y1 - rect.y0 > REACH;
    voids.contains(&true) && (!is_long || voids.contains(&false))
}

/// Sixteen directions, as (east, north) steps; lengths differ.
const DIRECTIONS: [(i32, i32); 16] = [
    (1, 0),
    (2, 1),
    (1, 1),
    (1, 2),
    (0, 1),
    (-1, 2),
    (-1, 1),
    (-2, 1),
    (-1, 0),
    (-2, -1),
    (-1, -1),
    (-1, -2),
    (0, -1),
    (1, -2),
    (1, -1),
    (2, -1),
];

/// Height at voxel (x, y) of `surface`, which must reach [`REACH`] voxels around it (or to the grid's edge).
/// `coarse` is the broad surface there. NaN if there is neither.
pub(super) fn interpolate(surface: &Surface, x: u32, y: u32, coarse: Option<f64>) -> f64 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for (dx, dy) in DIRECTIONS {
        let found = nearest(surface, x, y, dx, dy).or_else(|| Some((coarse?, f64::from(REACH))));
        if let Some((height, distance)) = found {
            sum += height / (distance * distance);
            weight += 1.0 / (distance * distance);
        }
    }
    if weight > 0.0 { sum / weight } else { f64::NAN }
}

/// First valid height in steps of (`dx`, `dy`) voxels, and its distance in voxels.
fn nearest(surface: &Surface, x: u32, y: u32, dx: i32, dy: i32) -> Option<(f64, f64)> {
    let rect = surface.rect;
    let length = f64::from(dx).hypot(f64::from(dy));
    let steps = (f64::from(REACH) / length) as i32;
    for step in 1..=steps {
        let x = x.checked_add_signed(dx * step).filter(|x| (rect.x0..rect.x1).contains(x))?;
        let y = y.checked_add_signed(dy * step).filter(|y| (rect.y0..rect.y1).contains(y))?;
        let height = surface.heights[rect.index(x, y)];
        if !height.is_nan() {
            return Some((height, length * f64::from(step)));
        }
    }
    None
}
