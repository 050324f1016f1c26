//! Overhead wires: strips along lines through their points.
//!
//! ```text
//! points within two voxels, cut wherever a gap in height is wide
//! line = direction in which they spread most; cut again wherever a gap beside it is wide
//! a line that goes through the voxel, where there are points on it, is a strip in it
//! ```

use glam::{DVec2, dvec2};

use super::super::features::{Solid, Wall};
use super::class::PointKind;
use super::fit::FittedPlane;
use super::scene::TileScene;
use super::window::{Mark, TileVoxel};

/// Voxels about one whose points are asked for.
pub(super) const REACH: i64 = 2;
/// Gaps between wires, metres: in height and beside each other.
const GAPS: [f64; 2] = [0.7, 0.6];
/// Points of a line at least.
const LEAST: usize = 3;
/// Distance between points along the line within which they may lie beside a voxel, sides of a voxel.
const BEYOND: f64 = 0.6;
/// Thickness, metres.
const THICKNESS: f64 = 0.05;

/// A point of a wire: place from the voxel's middle, sides of a voxel, and height.
type WirePoint = (DVec2, f64);

/// Strips of wires over a voxel.
pub(super) fn strips(scene: &TileScene<'_>, voxel: TileVoxel, out: &mut Vec<Solid>) {
    let about = scene.window.around(voxel, REACH).filter(|(_, mark)| mark.kind() == PointKind::Wire);
    let points: Vec<(WirePoint, &Mark)> =
        about.map(|(place, mark)| ((place.into(), mark.z()), mark)).collect();
    if points.len() < LEAST {
        return;
    }

    let counts = |mark: &Mark| mark.kind() == PointKind::Wire;
    let own = PointKind::Wire.paint();
    let colour = scene.colour(voxel, counts).unwrap_or(own.colour);
    let points = points.into_iter().map(|(point, _)| point).collect();

    for level in cut(points, GAPS[0], |point| point.1) {
        let Some((_, along)) = line(&level) else { continue };
        let beside = along.perp();
        for wire in cut(level, GAPS[1] / scene.spacing, |point| point.0.dot(beside)) {
            let Some(strip) = strip(scene, &wire) else { continue };
            let paint = super::super::features::Paint { colour, ..own };
            let (plane, wall) = strip;
            let solid = scene.solid(Some(plane.height - THICKNESS), &plane, paint);
            out.push(Solid { side: colour, wall, parallel: true, strip: true, ..solid });
        }
    }
}

/// Groups of points, sorted by a number and cut wherever it leaps.
fn cut(mut points: Vec<WirePoint>, gap: f64, by: impl Fn(&WirePoint) -> f64) -> Vec<Vec<WirePoint>> {
    points.sort_by(|a, b| by(a).total_cmp(&by(b)));
    let mut groups: Vec<Vec<WirePoint>> = Vec::new();
    for point in points {
        match groups.last_mut().filter(|group| group.last().is_some_and(|last| by(&point) - by(last) <= gap))
        {
            Some(group) => group.push(point),
            None => groups.push(vec![point]),
        }
    }
    groups.retain(|group| group.len() >= LEAST);
    groups
}

/// Middle and direction of points; `None` where they spread in none.
fn line(points: &[WirePoint]) -> Option<(DVec2, DVec2)> {
    let count = points.len() as f64;
    let middle = points.iter().map(|point| point.0).sum::<DVec2>() / count;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (place, _) in points {
        let from = *place - middle;
        (xx, xy, yy) = (xx + from.x * from.x, xy + from.x * from.y, yy + from.y * from.y);
    }
    let spread = (0.5 * (xx - yy)).hypot(xy);
    let (most, least) = (0.5 * (xx + yy) + spread, 0.5 * (xx + yy) - spread);
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    (most > 9.0 * least.max(0.0) && most > 0.25).then(|| (middle, dvec2(angle.cos(), angle.sin())))
}

/// Upper end and wall of a wire in the voxel, if it goes through.
fn strip(scene: &TileScene<'_>, points: &[WirePoint]) -> Option<(FittedPlane, Wall)> {
    let (middle, along) = line(points)?;
    let normal = along.perp();
    let distance = middle.dot(normal);
    let reach = 0.5 * (normal.x.abs() + normal.y.abs());

    // Where the line passes the voxel's middle, from the points' middle.
    let here = -middle.dot(along);
    let far = |sign: f64| {
        points.iter().map(|(place, _)| sign * (*place - middle).dot(along)).fold(f64::MIN, f64::max)
    };
    if distance.abs() > reach || here > far(1.0) + BEYOND || -here > far(-1.0) + BEYOND {
        return None;
    }

    let count = points.len() as f64;
    let mean = points.iter().map(|point| point.1).sum::<f64>() / count;
    let (mut tt, mut tz) = (0.0, 0.0);
    for (place, z) in points {
        let t = (*place - middle).dot(along);
        (tt, tz) = (tt + t * t, tz + t * (z - mean));
    }

    let rise = tz / tt.max(f64::MIN_POSITIVE);
    let plane = FittedPlane { height: mean + rise * here + 0.5 * THICKNESS, rise: (along * rise).into() };
    let wall = Wall::Plane { facing: normal.y.atan2(normal.x), distance_m: distance * scene.spacing };

    Some((plane, wall))
}
