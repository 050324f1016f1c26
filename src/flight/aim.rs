//! Aim: the direction that the eye of a film looks in.

use std::fmt::Debug;
use std::sync::Arc;

use glam::DVec3;

use super::spline::Spline;
use super::trajectory::Trajectory;
use crate::space::Attitude;

/// Place that a camera looks at, over time.
pub trait Subject: Debug + Send + Sync {
    /// Returns the place at a time, seconds after the flight's first fix; metres of the database's system.
    fn place_at(&self, seconds: f64) -> DVec3;
}

/// Place that stays.
#[derive(Debug)]
pub(super) struct FixedPlace(pub DVec3);

impl Subject for FixedPlace {
    fn place_at(&self, _: f64) -> DVec3 {
        self.0
    }
}

/// Place that moves along a path, whose first fix is so many seconds after the flight's.
#[derive(Debug)]
pub(super) struct MovingPlace {
    /// The path.
    pub path: Trajectory,
    /// Moment of its first fix, seconds after the flight's.
    pub from: f64,
}

impl Subject for MovingPlace {
    fn place_at(&self, seconds: f64) -> DVec3 {
        self.path.position_at((seconds - self.from).clamp(0.0, self.path.duration()))
    }
}

/// Place of a flight, some time later; behind the last fix it goes straight on.
#[derive(Debug, Clone)]
pub(super) struct PlaceAhead {
    /// The flight.
    pub flight: Arc<Trajectory>,
    /// Time by which it is ahead, seconds, ≥ 0.
    pub lead: f64,
}

impl Subject for PlaceAhead {
    fn place_at(&self, seconds: f64) -> DVec3 {
        self.flight.place_at(seconds + self.lead)
    }
}

/// A path as what is looked at.
impl Subject for Spline {
    fn place_at(&self, seconds: f64) -> DVec3 {
        self.position(seconds)
    }
}

/// Direction that the eye of a film looks in.
#[derive(Debug, Clone)]
pub(super) enum Aim {
    /// Along the nose, as the path file or the motion has it.
    Nose,
    /// Along the nose, at a pitch of [`HIGHEST`] at most.
    Lowered,
    /// The heading of the nose, at a pitch of the view's own, degrees.
    Pitch(f64),
    /// Straight down, with the top of the picture where the nose points.
    Down,
    /// At where the flight will be, with a level horizon, at a pitch of [`HIGHEST`] at most.
    Ahead(PlaceAhead),
    /// At something, with a level horizon.
    At(Arc<dyn Subject>),
}

/// Highest pitch that keeps ground in sight, degrees: of pictures 60° wide and 16 by 9, the horizon has a quarter above it.
const HIGHEST: f64 = -9.0;

/// Distance of what is looked at, metres, below which the nose decides more and more.
const NEAR: f64 = 2.0;

impl Aim {
    /// Returns the attitude of the view from `eye` at a time, seconds, where the nose has one.
    pub fn attitude(&self, eye: DVec3, seconds: f64, nose: Attitude) -> Attitude {
        match self {
            Self::Nose => nose,
            Self::Lowered => lowered(nose),
            Self::Pitch(pitch) => Attitude { pitch: *pitch, ..nose },
            Self::Down => Attitude { pitch: -90.0, roll: 0.0, ..nose },
            Self::Ahead(place) => lowered(looking_at(place.place_at(seconds), eye, nose)),
            Self::At(subject) => looking_at(subject.place_at(seconds), eye, nose),
        }
    }
}

/// Returns the attitude with a pitch of [`HIGHEST`] at most.
fn lowered(attitude: Attitude) -> Attitude {
    Attitude { pitch: attitude.pitch.min(HIGHEST), ..attitude }
}

/// Returns the level attitude from an eye towards a place; the nearer it is, the more the nose decides.
fn looking_at(place: DVec3, eye: DVec3, nose: Attitude) -> Attitude {
    let way = place - eye;
    let share = (1.0 - way.length() / NEAR).max(0.0);
    towards(way + share * NEAR * nose.world_from_view().z_axis, nose.yaw)
}

/// A level attitude along a direction; `yaw`, degrees, where that is straight up or down.
pub(super) fn towards(direction: DVec3, yaw: f64) -> Attitude {
    let across = direction.truncate().length();
    let yaw = if across > 0.0 { direction.x.atan2(direction.y).to_degrees().rem_euclid(360.0) } else { yaw };
    Attitude { yaw, pitch: direction.z.atan2(across).to_degrees(), roll: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOSE: Attitude = Attitude { yaw: 40.0, pitch: 12.0, roll: 25.0 };

    /// A place a minute's flight to the east, sinking.
    fn sinking() -> Aim {
        let places = vec![DVec3::new(0.0, 0.0, 500.0), DVec3::new(600.0, 0.0, 440.0)];
        Aim::At(Arc::new(Spline::through(vec![0.0, 60.0], places)))
    }

    #[test]
    fn a_pitch_of_its_own_leaves_heading_and_bank() {
        let aimed = |aim: Aim| aim.attitude(DVec3::ZERO, 20.0, NOSE);
        assert_eq!(aimed(Aim::Nose), NOSE);
        assert_eq!(aimed(Aim::Lowered), Attitude { pitch: HIGHEST, ..NOSE });
        let diving = Attitude { pitch: -20.0, ..NOSE };
        assert_eq!(Aim::Lowered.attitude(DVec3::ZERO, 20.0, diving), diving);
        assert_eq!(aimed(Aim::Pitch(-10.0)), Attitude { pitch: -10.0, ..NOSE });
        assert_eq!(aimed(Aim::Down), Attitude { yaw: 40.0, pitch: -90.0, roll: 0.0 });
    }

    #[test]
    fn the_subject_is_in_the_middle_of_the_picture() {
        let found = sinking().attitude(DVec3::new(100.0, 0.0, 490.0), 20.0, NOSE);
        assert!((found.yaw - 90.0).abs() < 1e-9 && found.roll == 0.0, "{found:?}");
        assert!((found.pitch + (0.1_f64).atan().to_degrees()).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn nothing_jumps_where_the_subject_comes_to_the_eye() {
        let level = Attitude { yaw: 270.0, pitch: 0.0, roll: 0.0 };
        let eye = DVec3::new(600.0, 0.0, 440.0);
        let mut before = sinking().attitude(eye, 30.0, level);
        for step in 1..4000 {
            let after = sinking().attitude(eye, 30.0 + 0.01 * f64::from(step), level);
            let turn = (after.yaw - before.yaw).abs().max((after.pitch - before.pitch).abs());
            assert!(turn < 1.0, "{turn}° at step {step}: {before:?} {after:?}");
            before = after;
        }
        assert!((before.yaw - 270.0).abs() < 1e-9 && before.pitch.abs() < 1e-9, "{before:?}");
    }
}
