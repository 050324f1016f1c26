//! Single voxels that stand out.
//!
//! ```text
//! stands out   s = height − highest of the 8 neighbours, or lowest of them − height
//! roughness    r = 1.4826 · median of |height − plane| over the 24 voxels around; the plane by least squares
//! a spike or pit: s > k · max(r, 1/20 of a voxel's side, 2 steps of height)
//! ```
//!
//! The median leaves out other spikes nearby (Hampel, "The influence curve and its role in robust estimation", JASA 69, 1974); the plane, slopes. Without
//! the least roughness each pebble on level ground would be one.

use crate::continuity::Fault;
use crate::continuity::found::{Found, Patch};

/// Least roughness, in sides of a voxel and in steps of height.
const LEAST_SIDES: f64 = 0.05;
const LEAST_STEPS: f64 = 2.0;

/// Ratio of a standard deviation to a median of absolute deviations.
const DEVIATION: f64 = 1.4826;

pub(super) fn find(patch: &Patch, factor: f64, found: &mut Found) {
    let least = (LEAST_SIDES * patch.side).max(LEAST_STEPS * patch.code.scale);
    for (x, y) in (0..patch.size[1]).flat_map(|y| (0..patch.size[0]).map(move |x| (x, y))) {
        let Some((fault, out)) = standing_out(patch, x, y) else { continue };
        if out > factor * least && roughness(patch, x, y).is_some_and(|rough| out > factor * rough) {
            found.add(patch.finding(fault, x, y, out));
        }
    }
}

/// Whether a voxel is above or below all of its neighbours, and by how much.
fn standing_out(patch: &Patch, x: i64, y: i64) -> Option<(Fault, f64)> {
    let own = patch.height(x, y);
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    for (right, up) in around(1) {
        let height = patch.height(x + right, y + up);
        // Also where one of both has no surface.
        if height.is_nan() || own.is_nan() {
            return None;
        }
        (low, high) = (low.min(height), high.max(height));
    }
    if own > high {
        Some((Fault::Spike, f64::from(own - high)))
    } else if own < low {
        Some((Fault::Pit, f64::from(low - own)))
    } else {
        None
    }
}

/// Returns how far the voxels around leave a plane; of the 8 nearest where others have no surface.
fn roughness(patch: &Patch, x: i64, y: i64) -> Option<f64> {
    [2, 1].into_iter().find_map(|reach| {
        let samples: Vec<[f64; 3]> = around(reach)
            .map(|(right, up)| [right as f64, up as f64, f64::from(patch.height(x + right, y + up))])
            .collect();
        if samples.iter().any(|[.., height]| height.is_nan()) {
            return None;
        }

        // Places lie evenly about the middle, so that mean and slopes do not depend on each other.
        let count = samples.len() as f64;
        let squares: f64 = samples.iter().map(|[right, ..]| right * right).sum();
        let mean = samples.iter().map(|[.., height]| height).sum::<f64>() / count;
        let slope =
            |axis: usize| samples.iter().map(|sample| sample[axis] * sample[2]).sum::<f64>() / squares;
        let (east, north) = (slope(0), slope(1));
        let mut off: Vec<f64> = samples
            .iter()
            .map(|[right, up, height]| (height - mean - east * right - north * up).abs())
            .collect();
        off.sort_unstable_by(f64::total_cmp);
        let middle = off.len() / 2;

        Some(DEVIATION * 0.5 * (off[middle - 1] + off[middle]))
    })
}

/// Offsets within a reach, without the middle.
fn around(reach: i64) -> impl Iterator<Item = (i64, i64)> {
    (-reach..=reach)
        .flat_map(move |up| (-reach..=reach).map(move |right| (right, up)))
        .filter(|offset| *offset != (0, 0))
}
