//! Objects that lean as the ground below them does (conformal clamping, as CIGI calls it).
//!
//! ```text
//! along the track: 5 × 5 places of the object's length and width, turned as it is ──▶ plane of least squares
//! at any time:     the planes before and behind, blended                          ──▶ height, pitch, roll
//! ```
//!
//! A plane over its whole length and width follows the ground as wheels do: a post more or less below it moves it a little. Planes an eighth of its size apart
//! and blended between leave no jump from frame to frame, and on a plane all of it is exact.

use glam::{DMat3, DVec2, DVec3};

use crate::flight::{Samples, Track, Trajectory};
use crate::space::{Attitude, Pose};

/// Places along each side of what an object stands on.
const PLACES: i32 = 5;

/// Parts of an object's shorter side that planes along its track are apart.
const APART: f64 = 8.0;

/// Least side that a plane is found over, metres: less says nothing of slopes.
const LEAST: f64 = 0.5;

/// Degrees of a turn from plane to plane at most.
const TURN: f64 = 5.0;

/// Planes along a track besides those at its fixes.
const MOST_PLANES: f64 = 20_000.0;

/// The ground below an object, at any time of its track.
#[derive(Debug, Clone)]
pub(super) struct Slope {
    base: Base,
    times: Vec<f64>,
    planes: Vec<Option<SlopePlane>>,
    /// Height above the ground, metres.
    above: Option<Samples>,
}

/// Ground as flat as it is there.
#[derive(Debug, Clone, Copy)]
struct SlopePlane {
    at: DVec2,
    /// Metres.
    height: f64,
    /// Metres per metre to the east and the north.
    rise: DVec2,
}

impl SlopePlane {
    fn height(&self, place: DVec2) -> f64 {
        self.height + self.rise.dot(place - self.at)
    }
}

/// Base of an object: the middle (right, forward) and half the sides of its length and width, metres.
#[derive(Debug, Clone, Copy)]
struct Base {
    middle: DVec2,
    half: DVec2,
}

impl Base {
    /// The plane below it, of an object at `pose`.
    fn plane(&self, pose: &Pose, ground: &dyn Fn(DVec2) -> Option<f64>) -> Option<SlopePlane> {
        let (sin, cos) = pose.attitude.yaw.to_radians().sin_cos();
        let (right, forward) = (DVec2::new(cos, -sin), DVec2::new(sin, cos));
        let at = pose.eye.truncate();
        let place = |own: DVec2| at + right * own.x + forward * own.y;

        // Where the ground ends, it goes on level.
        let middle = ground(place(self.middle)).or_else(|| ground(at)).filter(|height| height.is_finite())?;
        let (mut sum, mut slope, mut squares) = (0.0, DVec2::ZERO, DVec2::ZERO);
        let steps = -(PLACES / 2)..=PLACES / 2;

        for (across, along) in
            steps.clone().flat_map(|across| steps.clone().map(move |along| (across, along)))
        {
            let part = DVec2::new(f64::from(across), f64::from(along)) / f64::from(PLACES / 2);
            let own = part * self.half;
            let height = ground(place(self.middle + own)).filter(|height| height.is_finite());
            let height = height.unwrap_or(middle) - middle;
            sum += height;
            slope += own * height;
            squares += own * own;
        }

        // The places lie evenly about the middle, so that mean and slopes do not mix.
        let own = slope / squares;
        let mean = middle + sum / f64::from(PLACES * PLACES);

        Some(SlopePlane { at, height: mean - own.dot(self.middle), rise: right * own.x + forward * own.y })
    }
}

impl Slope {
    /// The ground along a track, below an object with these least and greatest corners, metres.
    pub fn bind(
        track: &Track,
        trajectory: &Trajectory,
        [low, high]: [DVec3; 2],
        ground: &dyn Fn(DVec2) -> Option<f64>,
    ) -> Self {
        let [low, high] = [low.truncate(), high.truncate()];
        let base =
            Base { middle: 0.5 * (low + high), half: (0.5 * (high - low)).max(DVec2::splat(0.5 * LEAST)) };
        let times = times(track, trajectory, 2.0 * base.half.min_element() / APART);
        let planes = times.iter().map(|time| base.plane(&trajectory.pose_at(*time), ground)).collect();
        let above = track.fixes.iter().map(|fix| (fix.time, Some(fix.altitude.metres)));
        Self { base, times, planes, above: Samples::new(above) }
    }

    /// Returns the object's height above the ground so many seconds after its track begins, metres.
    pub fn above(&self, seconds: f64) -> f64 {
        self.above.as_ref().map_or(0.0, |above| above.at(seconds))
    }

    /// `pose` as it leans on the ground below it, `above` metres higher; as it is where there is none.
    pub fn lay(&self, pose: Pose, above: f64, ground: &dyn Fn(DVec2) -> Option<f64>) -> Pose {
        let Some(plane) = self.base.plane(&pose, ground) else { return pose };
        let place = pose.eye.truncate();
        let attitude = lean(pose.attitude.yaw, plane.rise);
        Pose { eye: place.extend(plane.height(place) + above), attitude, ..pose }
    }

    /// The pose of the object that many seconds after its track begins, of which `pose` says place and yaw.
    pub fn stand(&self, pose: Pose, seconds: f64) -> Pose {
        let next = self.times.partition_point(|time| *time <= seconds);
        let [before, behind] = [next.saturating_sub(1), next.min(self.times.len() - 1)];
        let (one, other) = match (self.planes[before], self.planes[behind]) {
            (Some(one), Some(other)) => (one, other),
            (Some(one), None) | (None, Some(one)) => (one, one),
            (None, None) => return pose,
        };
        let length = self.times[behind] - self.times[before];
        let part = if length > 0.0 { (seconds - self.times[before]) / length } else { 0.0 };
        let place = pose.eye.truncate();
        let height = one.height(place) + part * (other.height(place) - one.height(place));
        let rise = one.rise.lerp(other.rise, part);
        let above = self.above(seconds);
        Pose { eye: place.extend(height + above), attitude: lean(pose.attitude.yaw, rise), ..pose }
    }
}

/// Returns the times at which planes are found: at the fixes, and between them where they are farther apart than `spacing` metres, or it turns.
fn times(track: &Track, trajectory: &Trajectory, spacing: f64) -> Vec<f64> {
    let poses: Vec<Pose> = track.fixes.iter().map(|fix| trajectory.pose_at(fix.time)).collect();
    let way = |pair: &[Pose]| (pair[1].eye - pair[0].eye).truncate().length();
    let total: f64 = poses.windows(2).map(way).sum();
    let spacing = spacing.max(total / MOST_PLANES);
    let most_turns = MOST_PLANES / poses.len() as f64;
    let mut times = Vec::new();
    for (fixes, pair) in track.fixes.windows(2).zip(poses.windows(2)) {
        let turn = (pair[1].attitude.yaw - pair[0].attitude.yaw + 180.0).rem_euclid(360.0) - 180.0;
        let turns = (turn.abs() / TURN).min(most_turns);
        let parts = (way(pair) / spacing).max(turns).ceil().clamp(1.0, MOST_PLANES) as u32;
        let [from, to] = [fixes[0].time, fixes[1].time];
        let between = (0..parts).map(|part| from + f64::from(part) / f64::from(parts) * (to - from));
        times.extend(between);
    }
    times.extend(track.fixes.last().map(|fix| fix.time));
    times
}

/// The attitude of what stands on a slope (metres per metre to the east and the north), and whose front is at `yaw` on a map.
fn lean(yaw: f64, rise: DVec2) -> Attitude {
    let (sin, cos) = yaw.to_radians().sin_cos();
    let ahead = DVec2::new(sin, cos);
    let forward = ahead.extend(ahead.dot(rise)).normalize();
    let up = (-rise).extend(1.0).normalize();
    Attitude::of_body(DMat3::from_cols(forward.cross(up), forward, up))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_on_a_slope_has_its_up_for_its_own() {
        // It faces east and up a slope that rises by a third northward too.
        let rise = DVec2::new(0.5, 1.0 / 3.0);
        let axes = lean(90.0, rise).world_from_body();
        assert!((axes.z_axis - (-rise).extend(1.0).normalize()).length() < 1e-12);
        assert!((axes.y_axis - DVec3::new(1.0, 0.0, 0.5).normalize()).length() < 1e-12, "{axes}");
        let level = lean(200.0, DVec2::ZERO);
        assert!((level.yaw - 200.0).abs() < 1e-9 && level.pitch == 0.0 && level.roll.abs() < 1e-12);
        let ahead = lean(0.0, DVec2::new(0.0, 0.25));
        assert!((ahead.pitch - 0.25_f64.atan().to_degrees()).abs() < 1e-12 && ahead.roll.abs() < 1e-12);
        // The ground rises to the left, so that the right side is lower.
        assert!(lean(0.0, DVec2::new(-0.2, 0.0)).roll > 11.0);
    }

    #[test]
    fn a_bump_within_its_length_leans_it_less_than_the_bump_is_steep() {
        let base = Base { middle: DVec2::new(0.0, 1.0), half: DVec2::new(1.0, 3.0) };
        let pose = Pose { eye: DVec3::new(50.0, 20.0, 0.0), attitude: Attitude::default(), hfov: 60.0 };
        let plane = |ground: &dyn Fn(DVec2) -> Option<f64>| base.plane(&pose, ground).unwrap();
        let even = plane(&|place| Some(7.0 + 0.2 * place.x - 0.1 * place.y));
        assert!((even.rise - DVec2::new(0.2, -0.1)).length() < 1e-12 && (even.height - 15.0).abs() < 1e-12);
        let step = plane(&|place| Some(if place.y > 21.0 { 1.0 } else { 0.0 }));
        assert!(step.rise.y > 0.1 && step.rise.y < 0.3 && step.rise.x.abs() < 1e-12, "{step:?}");
        // Where the ground ends, what is left of it says how it leans.
        assert!(plane(&|place| (place.y < 22.0).then_some(5.0)).rise.length() < 1e-12);
        assert!(base.plane(&pose, &|_| None).is_none());
    }
}
