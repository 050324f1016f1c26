//! The visual sensor: imagery shaded by the sun from the height gradient.

use glam::Vec3;

use crate::raymarch::SurfaceSample;
use crate::simd::{Floats, Simd};
use crate::sunlight::{Daylight, Sun};
use crate::weather::GroundCover;
use hedgehop_base::colour::LUMINANCE;

/// Shades imagery so that level ground keeps its colour, whatever the sun's elevation: photographs
/// already hold the light of their hour.
#[derive(Debug, Clone, Copy)]
pub struct VisualSensor {
    daylight: Daylight,
    cover: GroundCover,
}

/// Ratio in which a film of water on the ground holds back the light that enters it: the square of its refractive index (Ångström 1925, *Geografiska Annaler* 7, 323–342).
const WATER: f32 = 1.33 * 1.33;

/// Linear Rec. 709 reflectance of fresh snow.
const SNOW: [f32; 3] = [0.84, 0.87, 0.91];

/// Upward parts of unit normals between which snow begins to hold: slopes of 58 and 38 degrees.
const HOLDS: [f32; 2] = [0.53, 0.79];

impl VisualSensor {
    /// A sensor under `sun`.
    pub fn new(sun: Sun) -> Self {
        Self { daylight: Daylight::new(sun), cover: GroundCover::default() }
    }

    /// The same over ground that is wet, or white.
    #[must_use]
    pub fn covered(self, cover: GroundCover) -> Self {
        Self { cover, ..self }
    }

    /// Reflectance of ground that would have `dry` reflectance, as wet as it is.
    pub fn wetted(&self, dry: f32) -> f32 {
        let wet = dry / (WATER * (1.0 - dry) + dry);
        dry + (wet - dry) * self.cover.wet as f32
    }

    /// Reflectances of sixteen posts that would have `dry` ones, as [`Self::wetted`] has them.
    #[inline(always)]
    pub fn wetted_posts<V: Simd>(&self, simd: V, dry: V::F) -> V::F {
        if self.cover.wet == 0.0 {
            return dry;
        }
        let wet = dry / ((simd.splat(1.0) - dry) * simd.splat(WATER) + dry);
        dry + (wet - dry) * simd.splat(self.cover.wet as f32)
    }

    /// Whether there is snow on it.
    pub fn has_snow(&self) -> bool {
        self.cover.snow > 0.0
    }

    /// Reflectances of sixteen posts with the snow that their slopes hold (how far they rise eastward and northward per unit), and the shares of their luminance
    /// that are still the ground's.
    #[inline(always)]
    pub fn snowed<V: Simd>(
        &self,
        simd: V,
        [eastward, northward]: [V::F; 2],
        bare: [V::F; 3],
    ) -> ([V::F; 3], V::F) {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let upward = one / (eastward * eastward + northward * northward + one).sqrt();
        let holds = (upward - simd.splat(HOLDS[0])) * simd.splat(1.0 / (HOLDS[1] - HOLDS[0]));
        let share = holds.max(zero).min(one) * simd.splat(self.cover.snow as f32);
        let mut covered = bare;
        let (mut ground, mut all) = (zero, simd.splat(f32::MIN_POSITIVE));
        for (channel, covered) in covered.iter_mut().enumerate() {
            let weight = simd.splat(LUMINANCE.to_array()[channel]);
            ground = covered.mul_add(weight, ground);
            *covered = (simd.splat(SNOW[channel]) - *covered).mul_add(share, *covered);
            all = covered.mul_add(weight, all);
        }
        (covered, (one - share) * ground / all)
    }

    /// Reflectance of the ground of `sample`, with what lies on it.
    fn albedo(&self, sample: &SurfaceSample) -> Vec3 {
        self.snowed_on(sample.normal, sample.albedo.map(|dry| self.wetted(dry)))
    }

    /// Reflectance of what looks along a unit normal and would have `bare` reflectance, with the snow that holds on it.
    pub fn snowed_on(&self, normal: Vec3, bare: Vec3) -> Vec3 {
        let holds = ((normal.z - HOLDS[0]) / (HOLDS[1] - HOLDS[0])).clamp(0.0, 1.0);
        bare.lerp(Vec3::from_array(SNOW), holds * self.cover.snow as f32)
    }

    /// The light that it sees by.
    pub fn daylight(&self) -> &Daylight {
        &self.daylight
    }

    /// Radiance towards the eye of something that stands on the ground, which lights it, too.
    pub fn of_solid(&self, sample: &SurfaceSample) -> Vec3 {
        self.albedo(sample) * self.daylight.on_body(sample.normal, sample.sun)
    }

    /// Radiance towards the eye, linear Rec. 709, 1 = display white.
    pub fn radiance(&self, sample: &SurfaceSample) -> Vec3 {
        self.albedo(sample) * self.daylight.on(sample.normal, sample.sun)
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
        let level =
            |elevation| VisualSensor::new(Sun { azimuth: 200.0, elevation }).radiance(&sample(Vec3::Z));
        assert!((level(20.0) - Vec3::new(0.2, 0.3, 0.4)).length() < 1e-6);
        // A low sun is warm, and as bright on grey ground.
        let low = level(5.0) / level(20.0);
        assert!(low.x > 1.05 && low.z < 0.9 && (low.dot(LUMINANCE) - 1.0).abs() < 1e-6, "{low}");
    }

    #[test]
    fn wet_ground_is_darker_and_snow_lies_where_it_is_not_steep() {
        let dry = VisualSensor::new(Sun::default());
        let wet = dry.covered(GroundCover { wet: 1.0, snow: 0.0 });
        // Ångström's figures for n = 1.33: 0.124 of 0.2.
        assert!((wet.radiance(&sample(Vec3::Z)).x - 0.1238).abs() < 1e-3);
        assert!(wet.wetted(1.0) == 1.0 && wet.wetted(0.0) == 0.0 && dry.wetted(0.3) == 0.3);
        let white = dry.covered(GroundCover { wet: 0.0, snow: 1.0 });
        assert!((white.radiance(&sample(Vec3::Z)) - Vec3::from_array(SNOW)).length() < 1e-6);
        let cliff = sample(Vec3::new(0.0, -0.9, 0.19_f32.sqrt()));
        assert_eq!(white.radiance(&cliff), dry.radiance(&cliff));
    }

    #[test]
    fn slopes_towards_the_sun_are_brighter() {
        let sensor = VisualSensor::new(Sun { azimuth: 90.0, elevation: 40.0 });
        let east = sensor.radiance(&sample(Vec3::new(0.5, 0.0, 0.75_f32.sqrt())));
        let west = sensor.radiance(&sample(Vec3::new(-0.5, 0.0, 0.75_f32.sqrt())));
        assert!(east.x > 0.2 && west.x < 0.2);
    }
}
