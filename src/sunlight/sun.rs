//! Where the sun stands.

use glam::Vec3;

/// Direction to the sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Clockwise from grid north, degrees.
    pub azimuth: f64,
    /// Above the horizon, degrees, 0 < elevation ≤ 90.
    pub elevation: f64,
}

impl Default for Sun {
    /// A mid-morning sun in the south-east.
    fn default() -> Self {
        Self { azimuth: 135.0, elevation: 40.0 }
    }
}

impl Sun {
    /// Unit vector to the sun, world axes.
    pub fn direction(&self) -> Vec3 {
        let (sin_azimuth, cos_azimuth) = self.azimuth.to_radians().sin_cos();
        let (sin_elevation, cos_elevation) = self.elevation.to_radians().sin_cos();
        Vec3::new(
            (sin_azimuth * cos_elevation) as f32,
            (cos_azimuth * cos_elevation) as f32,
            sin_elevation as f32,
        )
    }
}
