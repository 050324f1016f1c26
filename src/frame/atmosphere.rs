//! Sky by elevation angle, haze by range and height.

use glam::Vec3;

/// Contrast at which an object is taken to vanish: meteorological optical range is defined by 5 %.
const VANISHING_CONTRAST: f32 = 0.05;

/// Share of a surface's radiance that makes no difference to the eye: less than half a step of 8 bits.
const UNSEEN: f64 = 1.0 / 1024.0;

/// Height over which haze thins by the factor e, metres: aerosol of the lower air.
const SCALE_HEIGHT: f32 = 2000.0;

/// Linear Rec. 709 colours of the clear sky.
const ZENITH: Vec3 = Vec3::new(0.10, 0.22, 0.52);
const HORIZON: Vec3 = Vec3::new(0.62, 0.71, 0.80);

/// Visibility to which the colours of the sky belong, metres: they hold that much haze already.
const CLEAR_VISIBILITY: f32 = 40_000.0;

/// How fast the sky turns from the horizon's haze to blue, per sine of elevation; it begins
/// gently, over sines up to `SKY_ONSET`, so that no line shows at the horizon.
const SKY_DEPTH: f32 = 5.0;
const SKY_ONSET: f32 = 0.12;

/// Hazy air under a clear sky; the haze is thickest at a base height and thins exponentially above it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Atmosphere {
    extinction: f32,
    base: f64,
}

impl Atmosphere {
    /// Air with a meteorological visibility (optical range) of `visibility` metres, > 0, at the
    /// height `base`, metres above the datum. Infinite visibility: no haze.
    pub fn new(visibility: f64, base: f64) -> Self {
        Self { extinction: -VANISHING_CONTRAST.ln() / visibility as f32, base }
    }

    /// Radiance of the sky from height `eye` (metres above the datum) in a direction of which `up` is the
    /// sine of the elevation angle, −1…1. Below the horizon it is the haze that fills the distance.
    pub fn sky(&self, eye: f64, up: f32) -> Vec3 {
        let up = up.max(0.0);
        let clear = 1.0 - (-SKY_DEPTH * up * up / (up + SKY_ONSET)).exp();
        // Air that is hazier than a clear day's hides the blue, or a white mountain would stand before it.
        let excess = (self.extinction - -VANISHING_CONTRAST.ln() / CLEAR_VISIBILITY).max(0.0);
        let start = ((eye - self.base) as f32 / SCALE_HEIGHT).max(0.0);
        let column = excess * SCALE_HEIGHT * (-start).exp() / up.max(f32::MIN_POSITIVE);
        HORIZON.lerp(ZENITH, clear * (-column).exp())
    }

    /// Radiance that reaches an eye at height `eye` (metres above the datum) from a surface of
    /// `radiance` at `range` metres, in a direction of which `up` is the sine of the elevation angle:
    /// what the haze between lets through, and what it adds (Koschmieder 1924).
    pub fn haze(&self, radiance: Vec3, eye: f64, up: f32, range: f32) -> Vec3 {
        let through = (-self.optical_depth(eye, up, range)).exp();
        HORIZON.lerp(radiance, through)
    }

    /// Range beyond which nothing of the ground is seen from height `eye`, metres: haze lets through less than
    /// [`UNSEEN`] of a surface at any height up to `highest`. Infinite where there is no haze.
    pub fn reach(&self, eye: f64, highest: f64) -> f64 {
        let air = Self { extinction: 1.0, ..*self };
        // Level with the highest ground, or between it and the eye: the clearest way that ends on ground. The
        // depth of a way of 1 m that rises or sinks as far is that of its mean.
        let mean = air.optical_depth(eye, (highest - eye) as f32, 1.0);
        -UNSEEN.ln() / f64::from(self.extinction * mean)
    }

    /// Extinction integrated along a ray: `∫ β·exp(−h/H) ds` in closed form, `h` above the base.
    fn optical_depth(&self, eye: f64, up: f32, range: f32) -> f32 {
        let start = ((eye - self.base) as f32 / SCALE_HEIGHT).max(0.0);
        let end = (start + up * range / SCALE_HEIGHT).max(0.0);
        // From the lower end up, where nothing overflows: e^−low · (1 − e^−rise)/rise.
        let rise = (end - start).abs();
        let mean = if rise == 0.0 { 1.0 } else { -(-rise).exp_m1() / rise };
        self.extinction * range * (-start.min(end)).exp() * mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contrast_at_the_visibility_range_is_five_percent() {
        let air = Atmosphere::new(12_000.0, 300.0);
        let contrast = (air.haze(Vec3::ZERO, 300.0, 0.0, 12_000.0).x - HORIZON.x) / -HORIZON.x;
        assert!((contrast - 0.05).abs() < 1e-6);
    }

    #[test]
    fn far_ground_meets_the_sky_without_an_edge() {
        let air = Atmosphere::new(1000.0, 0.0);
        assert!((air.haze(Vec3::ONE, 0.0, 0.0, 1.0e6) - air.sky(0.0, 0.0)).length() < 1e-6);
    }

    #[test]
    fn dense_haze_hides_the_sky_behind_mountains_but_not_from_above_it() {
        let (clear, dense) = (Atmosphere::new(40_000.0, 0.0), Atmosphere::new(1500.0, 0.0));
        let mountain = dense.haze(Vec3::ZERO, 10.0, 0.1, 5000.0);
        assert!((dense.sky(10.0, 0.1) - mountain).abs().max_element() < 0.01);
        assert!((dense.sky(20_000.0, 0.5) - clear.sky(20_000.0, 0.5)).length() < 1e-3);
        assert_eq!(clear.sky(10.0, 0.0), HORIZON);
        assert_eq!(clear.sky(10.0, 1.0), Atmosphere::new(f64::INFINITY, 0.0).sky(10.0, 1.0));
    }

    #[test]
    fn beyond_reach_no_ground_differs_from_the_haze() {
        let air = Atmosphere::new(20_000.0, 100.0);
        for (eye, highest) in [(150.0, 100.0), (3000.0, 100.0), (500.0, 2500.0), (12_000.0, 4000.0)] {
            let reach = air.reach(eye, highest);
            for ground in [100.0, 0.5 * (100.0 + highest), highest] {
                let up = ((ground - eye) / reach) as f32;
                let left = air.haze(Vec3::ONE, eye, up, reach as f32) - HORIZON;
                assert!(left.length() < 1.2e-3 * (Vec3::ONE - HORIZON).length(), "{eye} {ground}: {left}");
            }
            assert!(reach > 40_000.0 && reach < 1.0e6, "{reach}");
        }
        assert_eq!(Atmosphere::new(f64::INFINITY, 0.0).reach(100.0, 50.0), f64::INFINITY);
    }

    #[test]
    fn unlimited_visibility_changes_nothing() {
        assert_eq!(Atmosphere::new(f64::INFINITY, 0.0).haze(Vec3::ONE, 500.0, -0.1, 1.0e6), Vec3::ONE);
    }

    #[test]
    fn from_space_the_haze_is_a_thin_layer() {
        let air = Atmosphere::new(40_000.0, -10_000.0);
        let depth = air.optical_depth(2.5e6, -1.0, 2.51e6);
        assert!((depth / (air.extinction * SCALE_HEIGHT) - 1.0).abs() < 1e-3, "{depth}");
    }

    #[test]
    fn depth_agrees_with_numerical_integration() {
        let air = Atmosphere::new(20_000.0, 100.0);
        for (eye, up, range) in [(150.0, 0.0, 9_000.0), (3000.0, -0.4, 6_000.0), (200.0, 0.3, 40_000.0)] {
            let steps = 100_000;
            let sum: f64 = (0..steps)
                .map(|step| {
                    let distance = f64::from(range) * (f64::from(step) + 0.5) / f64::from(steps);
                    let height = eye + f64::from(up) * distance - 100.0;
                    (-height / f64::from(SCALE_HEIGHT)).exp()
                })
                .sum();
            let expected = f64::from(air.extinction) * sum * f64::from(range) / f64::from(steps);
            let depth = f64::from(air.optical_depth(eye, up, range));
            assert!((depth / expected - 1.0).abs() < 1e-4, "{depth} {expected}");
        }
    }
}
