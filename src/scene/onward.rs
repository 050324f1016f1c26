//! Courses of objects that go on beyond an end of their track, and keep to the ground there.

use glam::DVec2;

use super::slope::Slope;
use crate::space::{Attitude, Pose};

/// Time and way from pose to pose at most, seconds and metres.
const EVERY: f64 = 0.2;
const APART: f64 = 10.0;

/// Time over which the ground is known, seconds, and how often all objects of a scene together may ask for it.
const LONGEST: f64 = 600.0;
const MOST_ASKED: u32 = 4_000_000;

/// Number of questions about the ground that one place of an object asks, and one that leans.
const ASKED: u32 = 1;
const ASKED_LEANING: u32 = 26;

/// Reach up to which all objects of a scene know their ways.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reach {
    asked: u32,
}

impl Reach {
    /// Adds one more object that goes on.
    pub fn with(self, leans: bool) -> Self {
        Self { asked: self.asked + if leans { ASKED_LEANING } else { ASKED } }
    }

    /// Places each way of each object.
    fn places(self) -> u32 {
        MOST_ASKED / 2 / self.asked.max(1)
    }
}

/// Height and lean of an object at a place.
#[derive(Debug, Clone, Copy)]
struct Lie {
    height: f64,
    /// Pitch and roll, degrees.
    angles: [f32; 2],
}

impl Lie {
    fn of(pose: &Pose) -> Self {
        let Attitude { pitch, roll, .. } = pose.attitude;
        Self { height: pose.eye.z, angles: [pitch as f32, roll as f32] }
    }
}

/// A straight way over the ground.
#[derive(Debug, Clone)]
pub(super) struct Onward {
    /// At the track's end.
    end: Pose,
    /// Heights and leans from there on.
    lies: Vec<Lie>,
    /// Time from one to the next, seconds.
    every: f64,
    /// Metres from one to the next.
    step: DVec2,
}

impl Onward {
    /// The way on from the pose at a track's end, so many metres a second: as high above the ground as there, or with a slope and a height above it leaning as the
    /// ground does. It ends where the ground does, and goes on level from there.
    pub fn bind(
        end: Pose,
        velocity: DVec2,
        slope: Option<(&Slope, f64)>,
        reach: Reach,
        ground: &dyn Fn(DVec2) -> Option<f64>,
    ) -> Self {
        let every = EVERY.min(APART / velocity.length());
        let (step, mut lies) = (velocity * every, vec![Lie::of(&end)]);
        let below = |place| ground(place).filter(|height| height.is_finite());
        let (Some(first), true) = (below(end.eye.truncate()), step != DVec2::ZERO) else {
            return Self { end, lies, every, step };
        };
        // A float converts saturating.
        for index in 1..((LONGEST / every) as u32).min(reach.places()) {
            let place = end.eye.truncate() + f64::from(index) * step;
            let Some(height) = below(place) else { break };
            let pose = Pose { eye: place.extend(height + end.eye.z - first), ..end };
            lies.push(Lie::of(&slope.map_or(pose, |(slope, above)| slope.lay(pose, above, ground))));
        }
        Self { end, lies, every, step }
    }

    /// The pose so many seconds, ≥ 0, after the end.
    pub fn pose_at(&self, seconds: f64) -> Pose {
        let steps = seconds / self.every;
        let before = (steps as usize).min(self.lies.len() - 1);
        let one = self.lies[before];
        let other = self.lies.get(before + 1).copied().unwrap_or(one);
        let part = (steps - before as f64).min(1.0);
        let mix = |one: f64, other: f64| one + part * (other - one);
        let [pitch, roll] = [0, 1].map(|axis| mix(one.angles[axis].into(), other.angles[axis].into()));
        let place = self.end.eye.truncate() + steps * self.step;
        let attitude = Attitude { pitch, roll, ..self.end.attitude };
        Pose { eye: place.extend(mix(one.height, other.height)), attitude, ..self.end }
    }
}
