//! Extrapolation of a flight from its last poses: all that a simulator knows, whose pilot decides as it flies.
//!
//! ```text
//! poses of the last half second, first, middle and last of them:
//!     velocity, acceleration       divided differences of the three positions (Newton's form)
//!     rates of yaw, pitch, roll    differences of the last two, the short way round
//! position = last + velocity · t + acceleration · t² / 2,  angles = last + rate · t
//! ```
//!
//! Constant acceleration is continued exactly. Of a turn at v m/s and ω rad/s the position is off by about v ω² t³/6: 0.4 m
//! after a second at 250 m/s and 6° a second. The three poses stand as far apart as the flight kept going in one manner, not one frame: what
//! positions err is magnified by (t / interval)². Angles go on at their rates only, since nobody rolls with constant angular acceleration
//! for a second.

use std::collections::VecDeque;

use glam::DVec3;

use super::angles::short_way;
use crate::space::{Attitude, Pose};
use hedgehop_base::error::{Error, Result};

/// Poses that are looked back at: half as many as are looked ahead.
const KEPT: usize = 15;

/// A pose, with angles that go on from those before instead of wrapping.
#[derive(Debug, Clone, Copy)]
struct LatestPose {
    seconds: f64,
    eye: DVec3,
    /// Yaw, pitch and roll, degrees.
    angles: DVec3,
    hfov: f64,
}

/// Continues a flight beyond the poses that are known of it.
#[derive(Debug, Clone, Default)]
pub struct Extrapolation {
    /// The latest poses, oldest first; times rise.
    seen: VecDeque<LatestPose>,
}

/// Difference quotient of two poses' positions and angles.
fn rate(of: impl Fn(&LatestPose) -> DVec3, from: &LatestPose, to: &LatestPose) -> DVec3 {
    (of(to) - of(from)) / (to.seconds - from.seconds)
}

impl Extrapolation {
    /// The flight was at `pose` at `seconds`. A pose that is not later than the last one says nothing of what will be, and is passed over.
    ///
    /// # Errors
    /// A time or a pose that is not finite.
    pub fn observe(&mut self, seconds: f64, pose: &Pose) -> Result<()> {
        let Attitude { yaw, pitch, roll } = pose.attitude;
        let mut angles = DVec3::new(yaw, pitch, roll);
        if !(seconds.is_finite() && pose.eye.is_finite() && angles.is_finite() && pose.hfov.is_finite()) {
            return Err(Error::Configuration("a pose to predict from must be finite, and its time".into()));
        }
        if let Some(last) = self.seen.back() {
            if seconds <= last.seconds {
                return Ok(());
            }
            angles = last.angles + (angles - last.angles).map(short_way);
        }
        if self.seen.len() == KEPT {
            self.seen.pop_front();
        }
        self.seen.push_back(LatestPose { seconds, eye: pose.eye, angles, hfov: pose.hfov });
        Ok(())
    }

    /// Time of the last pose; `None` if there is none.
    pub fn last_seconds(&self) -> Option<f64> {
        self.seen.back().map(|seen| seen.seconds)
    }

    /// Predicts the pose at a time not before the last pose; `None` if no pose is known. Of one pose it stays there, of two it goes
    /// straight on. Where numbers end, at poses without any sense, it stays at the last one.
    pub fn pose_at(&self, seconds: f64) -> Option<Pose> {
        let last = self.seen.back()?;
        let ahead = (seconds - last.seconds).max(0.0);
        let (mut eye, mut angles) = (last.eye, last.angles);
        if let Some(before) = self.seen.len().checked_sub(2).map(|index| &self.seen[index]) {
            angles += rate(|seen| seen.angles, before, last) * ahead;
            let middle = &self.seen[self.seen.len() / 2];
            let middle = if middle.seconds < last.seconds { middle } else { before };
            let velocity = rate(|seen| seen.eye, middle, last);
            let first = &self.seen[0];
            let bend = if first.seconds < middle.seconds {
                (velocity - rate(|seen| seen.eye, first, middle)) / (last.seconds - first.seconds)
            } else {
                DVec3::ZERO
            };
            eye += (velocity + bend * (seconds.max(last.seconds) - middle.seconds)) * ahead;
        }

        if !(eye.is_finite() && angles.is_finite()) {
            (eye, angles) = (last.eye, last.angles);
        }
        let attitude = Attitude {
            yaw: angles.x.rem_euclid(360.0),
            pitch: angles.y.clamp(-90.0, 90.0),
            roll: short_way(angles.z),
        };

        Some(Pose { eye, attitude, hfov: last.hfov })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1.0 / 30.0;
    /// What a second ahead is.
    const AHEAD: u32 = 30;

    fn seen(count: u32, flown: impl Fn(f64) -> Pose) -> Extrapolation {
        let mut known = Extrapolation::default();
        for frame in 0..count {
            let seconds = f64::from(frame) * STEP;
            known.observe(seconds, &flown(seconds)).unwrap();
        }
        known
    }

    /// Most that positions (metres) and angles (degrees) of the next 30 frames are off, after `count` poses.
    fn errors(count: u32, flown: impl Fn(f64) -> Pose + Copy) -> [f64; 2] {
        let known = seen(count, flown);
        let mut most = [0.0_f64; 2];
        for half in 1..=2 * AHEAD {
            // Between frames too, where a turn of 360° from frame to frame would show.
            let seconds = (f64::from(count - 1) + 0.5 * f64::from(half)) * STEP;
            let (expected, got) = (flown(seconds), known.pose_at(seconds).unwrap());
            most[0] = most[0].max(expected.eye.distance(got.eye));
            let [a, b] = [expected, got].map(|pose| {
                let Attitude { yaw, pitch, roll } = pose.attitude;
                DVec3::new(yaw, pitch, roll)
            });
            most[1] = most[1].max((a - b).map(short_way).abs().max_element());
            assert!((0.0..=360.0).contains(&got.attitude.yaw), "{got:?}");
        }
        most
    }

    fn pose(eye: DVec3, yaw: f64, pitch: f64, roll: f64) -> Pose {
        Pose { eye, attitude: Attitude { yaw, pitch, roll }, hfov: 60.0 }
    }

    #[test]
    fn constant_acceleration_and_rates_are_continued_exactly() {
        let flown = |t: f64| {
            let eye =
                DVec3::new(5.0e5 + 200.0 * t + 4.0 * t * t, 4.0e6 - 90.0 * t, 300.0 + 3.0 * t - 5.0 * t * t);
            pose(eye, (358.0 + 20.0 * t).rem_euclid(360.0), 3.0 - 2.0 * t, 5.0 * t)
        };
        for count in [3, 4, 5, 14, 15, 16, 40] {
            let [metres, degrees] = errors(count, flown);
            assert!(metres < 1e-4 && degrees < 1e-9, "{count}: {metres} m, {degrees}°");
        }
    }

    #[test]
    fn a_climb_and_a_turn_are_continued_within_metres() {
        // 250 m/s, 6° a second: 26 m/s² across; through north in both directions.
        for rate in [6.0_f64, -6.0] {
            let turn = |t: f64| {
                let (radius, angle) = (250.0 / rate.to_radians(), (rate * (t - 0.6)).to_radians());
                let eye = DVec3::new(-radius * angle.cos(), radius * angle.sin(), 500.0);
                pose(eye, (rate * (t - 0.6)).rem_euclid(360.0), 0.0, 70.0_f64.copysign(rate))
            };
            let [metres, degrees] = errors(18, turn);
            assert!(metres > 0.1 && metres < 1.0 && degrees < 1e-9, "{metres} m, {degrees}°");
        }

        // A pull-up: the path bends up at 3 g until it climbs at 30°.
        let climb = |t: f64| {
            let angle = (0.15 * t).min(0.5);
            let radius = 200.0 / 0.15;
            let eye = DVec3::new(radius * angle.sin(), 0.0, 300.0 + radius * (1.0 - angle.cos()));
            pose(eye, 90.0, angle.to_degrees(), 0.0)
        };
        let [metres, degrees] = errors(20, climb);
        assert!(metres < 1.5 && degrees < 1e-6, "{metres} m, {degrees}°");
    }

    #[test]
    fn what_positions_err_is_not_magnified_beyond_use() {
        // A centimetre to and fro, as of a receiver that rounds.
        let flown = |t: f64| {
            let jitter = if (t / STEP).round() % 2.0 == 0.0 { 0.01 } else { -0.01 };
            pose(DVec3::new(100.0 * t, jitter, 200.0), 90.0, 0.0, 0.0)
        };
        let [metres, _] = errors(40, flown);
        assert!(metres < 0.8, "{metres} m");
    }

    #[test]
    fn few_poses_and_senseless_ones_predict_something() {
        let mut known = Extrapolation::default();
        assert_eq!((known.pose_at(1.0), known.last_seconds()), (None, None));
        let at = |x: f64| pose(DVec3::new(x, 0.0, 0.0), 350.0, 0.0, 0.0);
        known.observe(2.0, &at(10.0)).unwrap();
        assert_eq!(known.pose_at(3.0), Some(at(10.0)));

        // Not later: passed over.
        known.observe(2.0, &at(99.0)).unwrap();
        known.observe(1.0, &at(99.0)).unwrap();
        assert_eq!(known.pose_at(3.0), Some(at(10.0)));
        known.observe(3.0, &at(12.0)).unwrap();
        assert_eq!(known.pose_at(4.0).unwrap().eye.x, 14.0);

        // A time before the last pose is that of the last pose.
        assert_eq!(known.pose_at(0.0).unwrap().eye.x, 12.0);
        for broken in [at(f64::NAN), at(f64::INFINITY), Pose { hfov: f64::NAN, ..at(0.0) }] {
            assert!(matches!(known.observe(4.0, &broken), Err(Error::Configuration(_))));
        }

        let turned = pose(DVec3::ZERO, f64::NAN, 0.0, 0.0);
        assert!(known.observe(4.0, &turned).is_err() && known.observe(f64::NAN, &at(0.0)).is_err());
        assert_eq!(known.pose_at(4.0).unwrap().eye.x, 14.0);

        // Next to no time and a long way between them: no speed that numbers can hold.
        known.observe(3.0_f64.next_up(), &at(1e300)).unwrap();
        assert_eq!(known.pose_at(4.0).unwrap().eye.x, 1e300);
    }

    #[test]
    fn pitch_ends_at_the_zenith() {
        let known = seen(5, |t| pose(DVec3::ZERO, 0.0, 80.0 + 60.0 * t, 0.0));
        assert_eq!(known.pose_at(1.0).unwrap().attitude.pitch, 90.0);
    }
}
