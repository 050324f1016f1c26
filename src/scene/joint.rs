//! Motion of a part on what it goes with.
//!
//! ```text
//! axes of the part = axes of what it goes with · at rest · (yaw, pitch, roll) · turn about its axis
//! ```
//!
//! Angles mean what those of a body do, as those of articulated parts in CIGI (SISO, *Common Image Generator Interface*). A turn is clockwise as it is
//! seen from the tip of its axis, so that one about the axis up is a yaw.

use glam::{DMat3, DVec3};

use super::model::Rest;
use crate::flight::{Samples, Wanted};
use crate::space::Attitude;

/// Parts of a turn that are told apart: a rotor stands after whole turns as it stood before, though seconds are rounded.
const STEPS: f64 = (1_u64 << 32) as f64;

/// Columns that a table of angles may hold, in this order.
pub(super) const COLUMNS: [Wanted; 7] = [
    Wanted { name: "yaw_deg", is_angle: true, most: 3600.0 },
    Wanted { name: "pitch_deg", is_angle: true, most: 3600.0 },
    Wanted { name: "roll_deg", is_angle: true, most: 3600.0 },
    Wanted { name: "angle_deg", is_angle: true, most: 3600.0 },
    Wanted { name: "right_m", is_angle: false, most: 10_000.0 },
    Wanted { name: "forward_m", is_angle: false, most: 10_000.0 },
    Wanted { name: "up_m", is_angle: false, most: 10_000.0 },
];

/// Something that may change with time.
#[derive(Debug, Clone)]
pub(super) enum JointCourse {
    Constant(f64),
    Given(Samples),
}

impl JointCourse {
    fn at(&self, seconds: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Given(samples) => samples.at(seconds),
        }
    }
}

/// Motion of a part.
#[derive(Debug, Clone)]
pub(super) struct Joint {
    /// Place at rest.
    pub rest: Rest,
    /// Courses by [`COLUMNS`].
    pub courses: [JointCourse; 7],
    /// Axis of its turn, in its own axes, of unit length.
    pub axis: DVec3,
    /// Turns per second.
    pub turns: f64,
    /// Begin of its table, seconds after the flight's first fix.
    pub start: f64,
    /// Whether it turns from then on only, not long before too.
    pub waits: bool,
}

/// Axes somewhere: of a body in the world, or of a part on what it goes with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    pub origin: DVec3,
    /// Columns: right, forward, up.
    pub turn: DMat3,
}

impl Axes {
    /// Returns the axes in the world of what stands at `inner` of these.
    pub fn with(&self, inner: &Self) -> Self {
        Self { origin: self.origin + self.turn * inner.origin, turn: self.turn * inner.turn }
    }

    /// Returns `other` as seen from here.
    pub fn to(&self, other: &Self) -> Self {
        let back = self.turn.transpose();
        Self { origin: back * (other.origin - self.origin), turn: back * other.turn }
    }
}

impl From<Rest> for Axes {
    fn from(rest: Rest) -> Self {
        Self { origin: rest.pivot, turn: rest.turn }
    }
}

impl Joint {
    /// Returns the part's axes then, on what it goes with.
    pub fn at(&self, seconds: f64) -> Axes {
        let seconds = seconds - self.start;
        let of = |index: usize| self.courses[index].at(seconds);
        let attitude = Attitude { yaw: of(0), pitch: of(1), roll: of(2) };
        let turning = if self.waits { seconds.max(0.0) } else { seconds };
        let turned = (self.turns * turning).rem_euclid(1.0);
        let turned = (turned * STEPS).round() / STEPS;
        // Right-handed turns are clockwise to who looks along the axis.
        let angle = -(of(3) + 360.0 * turned.fract()).to_radians();
        let turn = attitude.world_from_body() * DMat3::from_axis_angle(self.axis, angle);
        Axes::from(self.rest).with(&Axes { origin: DVec3::new(of(4), of(5), of(6)), turn })
    }
}
