//! Aim: the direction that the eye of a flight looks in.

use glam::DVec3;

use super::spline::Spline;
use crate::space::Attitude;

/// Direction that the eye of a flight looks in.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Aim {
    /// Along the nose, as the path file or the motion has it.
    #[default]
    Nose,
    /// The heading of the nose, at a pitch of the view's own, degrees.
    Pitch(f64),
    /// At the place of the flight so many seconds later, above 0, with a level horizon.
    Ahead(f64),
    /// Straight down, with the top of the picture where the nose points.
    Down,
}

/// Distance of the place ahead, metres, below which the nose decides more and more.
const NEAR: f64 = 2.0;

impl Aim {
    /// Returns the attitude of the view, where the nose has one at a time of the flight, seconds.
    pub(super) fn attitude(self, flight: &Spline, seconds: f64, nose: Attitude) -> Attitude {
        match self {
            Self::Nose => nose,
            Self::Pitch(pitch) => Attitude { pitch, ..nose },
            Self::Down => Attitude { pitch: -90.0, roll: 0.0, ..nose },
            Self::Ahead(lead) => {
                let way = place_at(flight, seconds + lead) - flight.position(seconds);
                let share = (1.0 - way.length() / NEAR).max(0.0);
                towards(way + share * NEAR * nose.world_from_view().z_axis, nose.yaw)
            }
        }
    }
}

/// Place at a time, seconds; beyond the last fix the flight goes straight on.
fn place_at(flight: &Spline, seconds: f64) -> DVec3 {
    let end = flight.duration();
    let beyond = (seconds - end).max(0.0);
    flight.position(seconds.min(end)) + beyond * flight.velocity(end)
}

/// A level attitude along a direction; `yaw`, degrees, where that is straight up or down.
fn towards(direction: DVec3, yaw: f64) -> Attitude {
    let across = direction.truncate().length();
    let yaw = if across > 0.0 { direction.x.atan2(direction.y).to_degrees().rem_euclid(360.0) } else { yaw };
    Attitude { yaw, pitch: direction.z.atan2(across).to_degrees(), roll: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOSE: Attitude = Attitude { yaw: 40.0, pitch: 12.0, roll: 25.0 };

    /// Straight to the east at 10 m/s, and sinking by 1 m/s, for a minute; then it stands for another.
    fn flight() -> Spline {
        let times: Vec<f64> = (0..=12).map(|fix| 10.0 * f64::from(fix)).collect();
        let at = |time: f64| DVec3::new(10.0 * time, 0.0, 500.0 - time);
        let points = times.iter().map(|time| at(time.min(60.0))).collect();
        Spline::through(times, points)
    }

    #[test]
    fn a_pitch_of_its_own_leaves_heading_and_bank() {
        let aimed = |aim: Aim| aim.attitude(&flight(), 20.0, NOSE);
        assert_eq!(aimed(Aim::Nose), NOSE);
        assert_eq!(aimed(Aim::Pitch(-10.0)), Attitude { pitch: -10.0, ..NOSE });
        assert_eq!(aimed(Aim::Down), Attitude { yaw: 40.0, pitch: -90.0, roll: 0.0 });
    }

    #[test]
    fn the_place_ahead_is_in_the_middle_of_the_picture() {
        let found = Aim::Ahead(10.0).attitude(&flight(), 20.0, NOSE);
        assert!((found.yaw - 90.0).abs() < 1e-9 && found.roll == 0.0, "{found:?}");
        assert!((found.pitch + (0.1_f64).atan().to_degrees()).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn who_stands_looks_along_the_nose_and_nothing_jumps() {
        let flight = flight();
        let level = Attitude { yaw: 90.0, pitch: 0.0, roll: 0.0 };
        let standing = Aim::Ahead(5.0).attitude(&flight, 100.0, level);
        assert!((standing.yaw - 90.0).abs() < 1e-9 && standing.pitch.abs() < 1e-9, "{standing:?}");
        let mut before = Aim::Ahead(5.0).attitude(&flight, 30.0, level);
        for step in 1..9000 {
            let after = Aim::Ahead(5.0).attitude(&flight, 30.0 + 0.01 * f64::from(step), level);
            let turn = (after.yaw - before.yaw).abs().max((after.pitch - before.pitch).abs());
            assert!(turn < 1.0, "{turn}° at step {step}: {after:?}");
            before = after;
        }
    }
}
