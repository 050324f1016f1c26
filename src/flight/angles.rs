//! Angles that the file gives: the short way round between fixes, and slerp where all three are there.

use glam::{DMat3, DQuat, DVec3};

use crate::space::Attitude;

/// The turn of least size that is `degrees` modulo 360: −180…180.
pub(super) fn short_way(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}

/// A quantity at some fixes, linear between them and constant beyond.
#[derive(Debug, Clone)]
pub(crate) struct Samples {
    times: Vec<f64>,
    values: Vec<f64>,
}

impl Samples {
    /// `None` if there is no value at all. Fixes without one lie on the line between their neighbours.
    pub fn new(samples: impl Iterator<Item = (f64, Option<f64>)>) -> Option<Self> {
        let (times, values): (Vec<_>, Vec<_>) =
            samples.filter_map(|(time, value)| value.map(|value| (time, value))).unzip();
        (!times.is_empty()).then_some(Self { times, values })
    }

    /// The same for angles in degrees: each goes the short way from its predecessor.
    pub fn angles(samples: impl Iterator<Item = (f64, Option<f64>)>) -> Option<Self> {
        let mut unwrapped = Self::new(samples)?;
        let mut previous = unwrapped.values[0];
        for value in &mut unwrapped.values {
            previous += short_way(*value - previous);
            *value = previous;
        }
        Some(unwrapped)
    }

    /// Fixes that have a value.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    pub fn at(&self, seconds: f64) -> f64 {
        let after = self.times.partition_point(|&time| time <= seconds);
        match (after.checked_sub(1), self.times.get(after)) {
            (None, _) => self.values[0],
            (Some(before), None) => self.values[before],
            (Some(before), Some(&next)) => {
                let u = (seconds - self.times[before]) / (next - self.times[before]);
                self.values[before] + u * (self.values[after] - self.values[before])
            }
        }
    }
}

/// Orientations at fixes, slerped between.
#[derive(Debug, Clone)]
pub(super) struct Orientations {
    times: Vec<f64>,
    world_from_body: Vec<DQuat>,
}

impl Orientations {
    pub fn new(times: &[f64], attitude: impl Fn(f64) -> Attitude) -> Self {
        let world_from_body = times.iter().map(|&time| rotation(&attitude(time))).collect();
        Self { times: times.to_owned(), world_from_body }
    }

    pub fn at(&self, seconds: f64) -> Attitude {
        let after = self.times.partition_point(|&time| time <= seconds);
        attitude(match (after.checked_sub(1), self.times.get(after)) {
            (None, _) => self.world_from_body[0],
            (Some(before), None) => self.world_from_body[before],
            (Some(before), Some(&next)) => {
                let u = (seconds - self.times[before]) / (next - self.times[before]);
                // glam takes the short way.
                self.world_from_body[before].slerp(self.world_from_body[after], u)
            }
        })
    }
}

/// Body axes: x right, y forward, z up (the view's axes in right-handed order).
fn rotation(attitude: &Attitude) -> DQuat {
    let view = attitude.world_from_view();
    DQuat::from_mat3(&DMat3::from_cols(view.x_axis, view.z_axis, view.y_axis))
}

/// Inverse of [`rotation`]; yaw is 0…360. Straight up or down, yaw and roll mean the same, and share the turn.
fn attitude(world_from_body: DQuat) -> Attitude {
    let body = DMat3::from_quat(world_from_body);
    let (right, forward) = (body.x_axis, body.y_axis);
    let yaw = forward.x.atan2(forward.y);
    let level_right = DVec3::new(yaw.cos(), -yaw.sin(), 0.0);
    let level_up = level_right.cross(forward);
    Attitude {
        yaw: yaw.to_degrees().rem_euclid(360.0),
        pitch: forward.z.clamp(-1.0, 1.0).asin().to_degrees(),
        roll: (-right.dot(level_up)).atan2(right.dot(level_right)).to_degrees(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_way_is_short() {
        for (degrees, expected) in [(0.0, 0.0), (350.0, -10.0), (-350.0, 10.0), (179.0, 179.0), (721.0, 1.0)]
        {
            assert_eq!(short_way(degrees), expected);
        }
    }

    #[test]
    fn attitude_survives_the_quaternion() {
        for yaw in [0.0, 10.0, 100.0, 190.0, 359.0] {
            for pitch in [-89.0, -45.0, 0.0, 30.0, 89.0] {
                for roll in [-179.0, -60.0, 0.0, 45.0, 170.0] {
                    let before = Attitude { yaw, pitch, roll };
                    let after = attitude(rotation(&before));
                    assert!(short_way(before.yaw - after.yaw).abs() < 1e-6, "{before:?} {after:?}");
                    assert!((before.pitch - after.pitch).abs() < 1e-6, "{before:?} {after:?}");
                    assert!(short_way(before.roll - after.roll).abs() < 1e-6, "{before:?} {after:?}");
                }
            }
        }
    }

    #[test]
    fn nadir_keeps_the_picture() {
        let before = Attitude { yaw: 40.0, pitch: -90.0, roll: 25.0 };
        let after = attitude(rotation(&before));
        let difference = before.world_from_view() - after.world_from_view();
        assert!(difference.x_axis.length() < 1e-7 && difference.z_axis.length() < 1e-7);
    }

    #[test]
    fn yaw_goes_through_north_the_short_way() {
        let given = |yaw| Attitude { yaw, pitch: 0.0, roll: 0.0 };
        let flown = Orientations::new(&[0.0, 1.0], |t| given(if t < 0.5 { 350.0 } else { 10.0 }));
        assert!(short_way(flown.at(0.5).yaw).abs() < 1e-9);
        assert!((flown.at(0.25).yaw - 355.0).abs() < 1e-9);
        let samples =
            Samples::angles([(0.0, Some(350.0)), (1.0, None), (2.0, Some(10.0))].into_iter()).unwrap();
        assert!(short_way(samples.at(1.0)).abs() < 1e-9);
    }
}
