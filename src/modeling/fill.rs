//! Heights for voids.
//!
//! Inverse-distance weighting from the nearest valid voxels in sixteen directions (as GDAL's fillnodata does, in
//! eight): `h = Σ hₖ/dₖ² / Σ 1/dₖ²`. A direction that meets nothing within [`REACH`] voxels contributes
//! the source's coarse surface (see [`super::scan`]) at that distance. So a void's rim joins the terrain around
//! it, and the middle of a wide one follows the broad shape. A value depends only on voxels within
//! the reach: pages agree on their common samples.

use super::mosaic::Surface;

/// How far valid voxels are looked for, voxels.
pub(super) const REACH: u32 = 64;

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
    for step in DIRECTIONS {
        let found = nearest(surface, x, y, step).or_else(|| Some((coarse?, f64::from(REACH))));
        if let Some((height, distance)) = found {
            sum += height / (distance * distance);
            weight += 1.0 / (distance * distance);
        }
    }
    if weight > 0.0 { sum / weight } else { f64::NAN }
}

/// First valid height in a direction, and its distance in voxels.
fn nearest(surface: &Surface, x: u32, y: u32, (dx, dy): (i32, i32)) -> Option<(f64, f64)> {
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
