//! The visual sensor: imagery shaded by the sun from the height gradient.

use glam::Vec3;

use crate::raymarch::SurfaceSample;
use crate::sunlight::{Daylight, Sun};

/// Shades imagery so that level ground keeps its colour, whatever the sun's elevation: photographs
/// already hold the light of their hour.
#[derive(Debug, Clone, Copy)]
pub struct VisualSensor {
    daylight: Daylight,
}

impl VisualSensor {
    /// A sensor under `sun`.
    pub fn new(sun: Sun) -> Self {
        Self { daylight: Daylight::new(sun) }
    }

    /// The light that it sees by.
    pub fn daylight(&self) -> &Daylight {
        &self.daylight
    }

    /// Radiance towards the eye, linear Rec. 709, 1 = display white.
    pub fn radiance(&self, sample: &SurfaceSample) -> Vec3 {
        sample.albedo * self.daylight.on(sample.normal, sample.sun)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::Attributes;

    fn sample(normal: Vec3) -> SurfaceSample {
        SurfaceSample {
            range: 1.0,
            level: 0,
            albedo: Vec3::new(0.2, 0.3, 0.4),
            normal,
            attributes: Attributes::default(),
            sun: 1.0,
        }
    }

    #[test]
    fn level_ground_keeps_its_colour() {
        let sensor = VisualSensor::new(Sun { azimuth: 200.0, elevation: 12.0 });
        assert!((sensor.radiance(&sample(Vec3::Z)) - Vec3::new(0.2, 0.3, 0.4)).length() < 1e-6);
    }

    #[test]
    fn slopes_towards_the_sun_are_brighter() {
        let sensor = VisualSensor::new(Sun { azimuth: 90.0, elevation: 40.0 });
        let east = sensor.radiance(&sample(Vec3::new(0.5, 0.0, 0.75_f32.sqrt())));
        let west = sensor.radiance(&sample(Vec3::new(-0.5, 0.0, 0.75_f32.sqrt())));
        assert!(east.x > 0.2 && west.x < 0.2);
    }
}
