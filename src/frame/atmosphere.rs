//! Sky by elevation angle, haze by range.

use glam::Vec3;

/// Contrast at which an object at the visibility range vanishes (meteorological optical range is defined by
/// 5 %, Koschmieder's visual range by 2 %).
const VANISHING_CONTRAST: f32 = 0.05;

/// Linear Rec. 709 colours of the clear sky.
const ZENITH: Vec3 = Vec3::new(0.10, 0.22, 0.52);
const HORIZON: Vec3 = Vec3::new(0.62, 0.71, 0.80);

/// How fast the sky turns from the horizon's haze to blue, per sine of elevation; it begins
/// gently, over sines up to `SKY_ONSET`, so that no line shows at the horizon.
const SKY_DEPTH: f32 = 5.0;
const SKY_ONSET: f32 = 0.12;

/// Air of uniform haze under a clear sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Atmosphere {
    extinction: f32,
}

impl Atmosphere {
    /// Air with a meteorological visibility (optical range) of `visibility` metres, > 0; infinite for none.
    pub fn new(visibility: f64) -> Self {
        Self { extinction: -VANISHING_CONTRAST.ln() / visibility as f32 }
    }

    /// Radiance of the sky in a direction of which `up` is the sine of the elevation angle, −1…1.
    /// Below the horizon it is the haze that fills the distance.
    pub fn sky(&self, up: f32) -> Vec3 {
        let up = up.max(0.0);
        let clear = 1.0 - (-SKY_DEPTH * up * up / (up + SKY_ONSET)).exp();
        HORIZON.lerp(ZENITH, clear)
    }

    /// Radiance that reaches the eye from a surface of `radiance` at `range` metres: what the haze
    /// between lets through, and what it adds (Koschmieder 1924).
    pub fn haze(&self, radiance: Vec3, range: f32) -> Vec3 {
        let through = (-self.extinction * range).exp();
        HORIZON.lerp(radiance, through)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contrast_at_the_visibility_range_is_five_percent() {
        let air = Atmosphere::new(12_000.0);
        let contrast = (air.haze(Vec3::ZERO, 12_000.0).x - HORIZON.x) / -HORIZON.x;
        assert!((contrast - 0.05).abs() < 1e-6);
    }

    #[test]
    fn far_ground_meets_the_sky_without_an_edge() {
        let air = Atmosphere::new(1000.0);
        assert!((air.haze(Vec3::ONE, 1.0e6) - air.sky(0.0)).length() < 1e-6);
    }

    #[test]
    fn unlimited_visibility_changes_nothing() {
        assert_eq!(Atmosphere::new(f64::INFINITY).haze(Vec3::ONE, 1.0e6), Vec3::ONE);
    }
}
