//! Where objects go that go on beyond an end of their track, and keep to the ground there.

use glam::DVec2;

use super::slope::Slope;
use crate::space::{Attitude, Pose};

/// Time and way from pose to pose at most, seconds and metres.
const EVERY: f64 = 0.2;
const APART: f64 = 10.0;

/// Time over which the ground is known, seconds, and poses at most.
const LONGEST: f64 = 600.0;
const MOST: f64 = 10_000.0;

/// Poses along a straight way over the ground.
#[derive(Debug, Clone)]
pub(super) struct Onward {
    /// The first is that at the track's end.
    poses: Vec<Pose>,
    /// Time from one to the next, seconds.
    every: f64,
    /// Metres from one to the next.
    step: DVec2,
}

impl Onward {
    /// The way on from the pose at a track's end, so many metres a second: as high above the ground as there, or leaning as that does. It ends where the ground
    /// does, and goes on level from there.
    pub fn bind(
        end: Pose,
        velocity: DVec2,
        slope: Option<&Slope>,
        ground: &dyn Fn(DVec2) -> Option<f64>,
    ) -> Self {
        let every = EVERY.min(APART / velocity.length());
        let step = velocity * every;
        let mut poses = vec![end];
        let below = |place| ground(place).filter(|height| height.is_finite());
        let (Some(first), true) = (below(end.eye.truncate()), step != DVec2::ZERO) else {
            return Self { poses, every, step };
        };
        let above = end.eye.z - first;
        // Both limits are small numbers.
        for index in 1..(LONGEST / every).min(MOST) as u32 {
            let place = end.eye.truncate() + f64::from(index) * step;
            let Some(height) = below(place) else { break };
            let pose = Pose { eye: place.extend(height + above), ..end };
            poses.push(slope.map_or(pose, |slope| slope.lay(pose, above, ground)));
        }
        Self { poses, every, step }
    }

    /// The pose so many seconds, ≥ 0, after the end.
    pub fn pose_at(&self, seconds: f64) -> Pose {
        let steps = seconds / self.every;
        let before = (steps as usize).min(self.poses.len() - 1);
        let (one, part) = (self.poses[before], steps - before as f64);
        let Some(other) = self.poses.get(before + 1) else {
            return Pose { eye: one.eye + (self.step * part).extend(0.0), ..one };
        };
        let turned = |one: f64, other: f64| one + part * (other - one);
        let attitude = Attitude {
            pitch: turned(one.attitude.pitch, other.attitude.pitch),
            roll: turned(one.attitude.roll, other.attitude.roll),
            ..one.attitude
        };
        Pose { eye: one.eye.lerp(other.eye, part), attitude, ..one }
    }
}
