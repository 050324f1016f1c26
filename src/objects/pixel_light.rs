//! Ground and bodies in a pixel.

use glam::{DVec2, Vec3};

use super::view::Hit;

/// The ground in a pixel, as a plane.
#[derive(Debug, Clone, Copy, Default, bytemuck::Zeroable)]
#[repr(C)]
pub struct PixelGround {
    /// One over its range in the middle of the pixel, 1/metres; 0: sky.
    pub inverse: f32,
    /// Growth of that per pixel to the right, and per pixel down.
    pub slope: [f32; 2],
}

/// Contribution of bodies to a pixel.
#[derive(Debug, Clone, Copy)]
pub struct BodyLight {
    /// Share of the pixel that they cover, 0…1, more than 0.
    pub share: f32,
    /// Sum of colours times shares.
    pub colour: Vec3,
    /// Hit on the body that covers most of the pixel: in the pixel's middle, or in the mean of what is seen of one face of it.
    pub hit: Hit,
}

impl PixelGround {
    /// One over its range, so many pixels to the right of the middle, and below it.
    pub fn at(&self, offset: DVec2) -> f64 {
        let [across, along] = self.slope.map(f64::from);
        f64::from(self.inverse) + across * offset.x + along * offset.y
    }

    /// One over the range of its farthest point in the pixel, 1/metres.
    pub(super) fn least(&self) -> f64 {
        let [across, along] = self.slope.map(|slope| f64::from(slope).abs());
        f64::from(self.inverse) - 0.5 * (across + along)
    }

    /// One over the range of its nearest point in the pixel, 1/metres.
    pub(super) fn most(&self) -> f64 {
        let [across, along] = self.slope.map(|slope| f64::from(slope).abs());
        f64::from(self.inverse) + 0.5 * (across + along)
    }

    pub(super) fn shows(&self, hit: &Hit, offset: DVec2) -> bool {
        // At the eye both are infinite: there the ground is seen.
        hit.range * self.at(offset) < 1.0
    }
}
