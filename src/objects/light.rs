//! Lamps: how much light a lamp sends which way.
//!
//! A fixture is what lamps of one kind have in common: beams, each with an intensity at its middle that falls off to the sides by Gauss's
//! curve, as the cones of aeronautical lamps do, and which may have another colour seen from below an angle (VASI and PAPI).

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};

use crate::space::Attitude;

/// Share of a beam's light below which it is none.
const UNSEEN: f64 = 1.0e-4;

/// Light that goes one way, or all around.
#[derive(Debug, Clone, PartialEq)]
pub struct Beam {
    /// Luminous intensity in its middle, candela.
    pub candela: f64,
    /// Linear Rec. 709 of luminance 1.
    pub colour: Vec3,
    /// Middle and width of the beam; `None`: all around alike.
    pub cone: Option<Cone>,
    /// Appearance from below; `None`: as from above.
    pub below: Option<Below>,
}

/// Directions of a beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Azimuth clockwise from the lamp's front, and elevation, degrees.
    pub middle: DVec2,
    /// Angles sideways and upward from the middle at which half of its intensity is left, degrees, > 0.
    pub half: DVec2,
}

/// Another colour below an elevation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Below {
    /// Elevation at which one colour becomes the other, degrees.
    pub elevation: f64,
    /// Over how much, degrees, > 0.
    pub over: f64,
    /// Linear Rec. 709 of luminance 1.
    pub colour: Vec3,
    /// Share of the beam's intensity, 0…1: coloured filters take light.
    pub share: f32,
}

/// Properties that lamps of one kind share.
#[derive(Debug, Clone, PartialEq)]
pub struct Fixture {
    /// Radius of what shines, metres, ≥ 0.
    pub radius: f64,
    /// Beams of the lamp.
    pub beams: Vec<Beam>,
}

/// A lamp that shines at some moment.
#[derive(Debug, Clone)]
pub struct PointLight {
    /// Metres (x east, y north, z above the datum).
    pub position: DVec3,
    /// Attitude of the front.
    pub attitude: Attitude,
    /// Kind of lamp.
    pub fixture: Arc<Fixture>,
    /// Share of its intensity, 0…1: lamps flash.
    pub level: f32,
}

impl Cone {
    /// Share of the intensity, 0…1, towards an azimuth and an elevation, degrees.
    fn share(&self, towards: DVec2) -> f64 {
        let mut off = towards - self.middle;
        off.x -= 360.0 * (off.x / 360.0).round();
        let off = off / self.half;
        (-std::f64::consts::LN_2 * off.length_squared()).exp()
    }
}

impl Beam {
    /// Intensity towards an azimuth and an elevation (degrees): candela, by channel.
    fn towards(&self, towards: DVec2) -> Vec3 {
        let share = self.cone.map_or(1.0, |cone| cone.share(towards));
        if share < UNSEEN {
            return Vec3::ZERO;
        }
        let colour = match &self.below {
            Some(below) => {
                let above = ((towards.y - below.elevation) / below.over + 0.5).clamp(0.0, 1.0);
                (below.colour * below.share).lerp(self.colour, above as f32)
            }
            None => self.colour,
        };
        colour * (self.candela * share) as f32
    }
}

impl PointLight {
    /// Luminous intensity towards a point of the world that is not its place: candela times linear Rec. 709 of luminance 1.
    pub fn towards(&self, point: DVec3) -> Vec3 {
        let beams = &self.fixture.beams;
        let towards = if beams.iter().all(|beam| beam.cone.is_none() && beam.below.is_none()) {
            DVec2::ZERO
        } else {
            let view = self.attitude.world_from_view().transpose() * (point - self.position);
            DVec2::new(view.x.atan2(view.z), view.y.atan2(view.x.hypot(view.z))).map(f64::to_degrees)
        };
        self.level * beams.iter().map(|beam| beam.towards(towards)).sum::<Vec3>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Vec3 = Vec3::ONE;
    const RED: Vec3 = Vec3::new(4.7, 0.0, 0.0);

    fn lamp(beam: Beam, yaw: f64) -> PointLight {
        let fixture = Arc::new(Fixture { radius: 0.1, beams: vec![beam] });
        let attitude = Attitude { yaw, ..Attitude::default() };
        PointLight { position: DVec3::new(1000.0, 2000.0, 50.0), attitude, fixture, level: 1.0 }
    }

    /// Seen from so far away in a compass direction, so many degrees above.
    fn seen(lamp: &PointLight, azimuth: f64, elevation: f64) -> Vec3 {
        let (east, north) = azimuth.to_radians().sin_cos();
        let up = elevation.to_radians().tan();
        lamp.towards(lamp.position + 3000.0 * DVec3::new(east, north, up))
    }

    #[test]
    fn beams_have_half_of_their_intensity_at_their_half_widths() {
        let cone = Cone { middle: DVec2::new(0.0, 4.0), half: DVec2::new(5.0, 3.0) };
        let lamp = lamp(Beam { candela: 8000.0, colour: WHITE, cone: Some(cone), below: None }, 120.0);
        let near = |a: f32, b: f32| (a / b - 1.0).abs() < 1e-4;
        assert!(near(seen(&lamp, 120.0, 4.0).x, 8000.0));
        assert!(near(seen(&lamp, 125.0, 4.0).x, 4000.0) && near(seen(&lamp, 115.0, 4.0).x, 4000.0));
        assert!(near(seen(&lamp, 120.0, 7.0).x, 4000.0) && near(seen(&lamp, 120.0, 1.0).x, 4000.0));
        assert_eq!(seen(&lamp, 300.0, 4.0), Vec3::ZERO);
    }

    #[test]
    fn colours_change_over_their_angle() {
        let below = Below { elevation: 3.0, over: 0.05, colour: RED, share: 0.2 };
        let lamp = lamp(Beam { candela: 100.0, colour: WHITE, cone: None, below: Some(below) }, 0.0);
        assert_eq!(seen(&lamp, 77.0, 3.026), 100.0 * WHITE);
        assert!((seen(&lamp, 77.0, 2.974) - 20.0 * RED).length() < 1e-3);
        let between = seen(&lamp, 77.0, 3.0);
        assert!((between - 0.5 * (100.0 * WHITE + 20.0 * RED)).length() < 0.1, "{between}");
    }

    #[test]
    fn lamps_all_around_shine_all_around_and_flash() {
        let mut lamp = lamp(Beam { candela: 100.0, colour: WHITE, cone: None, below: None }, 10.0);
        assert!([0.0, 90.0, 200.0].into_iter().all(|azimuth| seen(&lamp, azimuth, 80.0) == 100.0 * WHITE));
        lamp.level = 0.25;
        assert_eq!(seen(&lamp, 0.0, 0.0), 25.0 * WHITE);
    }
}
