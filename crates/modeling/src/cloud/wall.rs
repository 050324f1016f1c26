//! Walls: where points of a roof end within a voxel.
//!
//! ```text
//! direction = from the middle of the points of the roof to that of the points below, both within a circle about the voxel
//! place     = where a line across that direction has fewest points on its wrong side
//! ```
//! The circle makes the direction that of the wall, wherever the wall goes through it.

use glam::{DVec2, dvec2};

use super::super::features::Wall;
use super::scene::TileScene;
use super::window::{Mark, TileVoxel};

/// Radius of the circle, sides of a voxel; no more than the voxels that are looked at reach.
const RADIUS: f64 = 2.4;
const REACH: i64 = 2;
/// Least depth below a roof of a point that is not of it, metres.
const BELOW: f64 = 0.8;
/// Points at least on either side.
const LEAST: usize = 3;
/// Share of points on the wrong side at most: corners have more.
const WRONG: f64 = 0.06;

/// Part of a voxel that a wall leaves.
pub(super) enum Side {
    /// All.
    Inside,
    /// A part.
    Cut(Wall),
    /// Nothing.
    Outside,
}

/// Finds the part of a voxel that the wall about it leaves; `None` where points show none.
pub(super) fn between(
    scene: &TileScene<'_>,
    voxel: TileVoxel,
    level: f64,
    is_same: impl Fn(&Mark) -> bool,
) -> Option<Side> {
    let (mut points, mut sums, mut counts) = (Vec::new(), [DVec2::ZERO; 2], [0; 2]);
    for ([x, y], mark) in scene.window.around(voxel, REACH) {
        let (place, is_in) = (dvec2(x, y), is_same(mark));
        if place.length() <= RADIUS && (is_in || mark.z() < level - BELOW) {
            points.push((place, is_in));
            sums[usize::from(is_in)] += place;
            counts[usize::from(is_in)] += 1;
        }
    }

    if counts.iter().any(|count| *count < LEAST) {
        return None;
    }

    let [out, within] = [0, 1].map(|side| sums[side] / counts[side] as f64);
    let normal = (out - within).try_normalize()?;
    let mut along: Vec<(f64, bool)> =
        points.iter().map(|(place, is_in)| (place.dot(normal), *is_in)).collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0));

    // With all on the outside, those of the roof are wrong; each that comes inside puts that right, or is wrong itself.
    let mut wrong = counts[1] as i64;
    let (mut fewest, mut sum, mut ties) = (i64::MAX, 0.0, 0.0);
    for pair in along.windows(2) {
        wrong += if pair[0].1 { -1 } else { 1 };
        if wrong < fewest {
            (fewest, sum, ties) = (wrong, 0.0, 0.0);
        }
        if wrong == fewest {
            (sum, ties) = (sum + pair[0].0.midpoint(pair[1].0), ties + 1.0);
        }
    }

    if fewest as f64 > WRONG * along.len() as f64 {
        return None;
    }

    let distance = sum / ties;
    let reach = 0.5 * (normal.x.abs() + normal.y.abs());
    Some(if distance >= reach {
        Side::Inside
    } else if distance <= -reach {
        Side::Outside
    } else {
        Side::Cut(Wall::Plane { facing: normal.y.atan2(normal.x), distance_m: distance * scene.spacing })
    })
}
