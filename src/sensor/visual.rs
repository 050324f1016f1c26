//! The visual sensor: imagery shaded by the sun from the height gradient.

use glam::Vec3;

use crate::raymarch::SurfaceSample;
use crate::simd::{Floats, Simd};
use crate::sunlight::Sun;

/// Share of the light on level ground that comes from the sky.
const SKY_SHARE: f32 = 0.35;

/// Sine of the sun's elevation below which the light on a wall no longer grows against that on level ground: half a degree, the sun's own
/// width.
const LOWEST: f32 = 0.0087;

/// Shades imagery so that level ground keeps its colour, whatever the sun's elevation: photographs
/// already hold the light of their hour.
#[derive(Debug, Clone, Copy)]
pub struct VisualSensor {
    /// Direction to the sun; its third component is no less than [`LOWEST`].
    to_sun: Vec3,
}

impl VisualSensor {
    /// A sensor under `sun`.
    pub fn new(sun: Sun) -> Self {
        let to_sun = sun.direction();
        Self { to_sun: to_sun.with_z(to_sun.z.max(LOWEST)) }
    }

    /// Radiance towards the eye, linear Rec. 709, 1 = display white.
    pub fn radiance(&self, sample: &SurfaceSample) -> Vec3 {
        sample.albedo * self.light(sample.normal, sample.sun)
    }

    /// Light on a surface of unit `normal` that sees a share `sun` (0…1) of the sun's disc, 1 on level ground that sees all of it: Lambert's law for the
    /// sun, and a uniform sky that a slope sees less of (half of it on a wall).
    #[inline]
    pub fn light(&self, normal: Vec3, sun: f32) -> f32 {
        let direct = normal.dot(self.to_sun).max(0.0) / self.to_sun.z;
        let sky = 0.5 + 0.5 * normal.z;
        SKY_SHARE * sky + (1.0 - SKY_SHARE) * direct * sun
    }

    /// The same for sixteen surfaces that rise `eastward` and `northward` by so much per unit.
    #[inline(always)]
    pub fn light_on<V: Simd>(&self, simd: V, [eastward, northward]: [V::F; 2], sun: V::F) -> V::F {
        let one = simd.splat(1.0);
        let upward = one / (eastward * eastward + northward * northward + one).sqrt();
        let [east, north] = [self.to_sun.x, self.to_sun.y].map(|share| simd.splat(share / self.to_sun.z));
        // Of the normal's upward part, like all that is multiplied by it.
        let direct = (one - eastward * east - northward * north).max(simd.splat(0.0));
        let sky = simd.splat(0.5 * SKY_SHARE);
        sky + upward * (sky + direct * simd.splat(1.0 - SKY_SHARE) * sun)
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
