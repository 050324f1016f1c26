//! Points of a flight's path, for maps and profiles.

use glam::DVec3;

/// Point of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPoint {
    /// Since the flight's first fix, seconds.
    pub seconds: f64,
    /// Place and altitude above the database's datum, metres.
    pub place: DVec3,
    /// Ground straight below, metres above the datum; `None` where there is none.
    pub ground: Option<f64>,
}

/// Returns the points that something has passed at a moment, and the place between two points where it is.
pub fn passed(points: &[TrackPoint], seconds: f64) -> (&[TrackPoint], f64) {
    let count = points.partition_point(|point| point.seconds <= seconds);
    let share = match (count.checked_sub(1).and_then(|last| points.get(last)), points.get(count)) {
        (Some(before), Some(after)) => {
            (seconds - before.seconds) / (after.seconds - before.seconds).max(1e-9)
        }
        _ => 0.0,
    };
    (&points[..count], share)
}
