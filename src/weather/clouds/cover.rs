//! Layer of clouds about an eye.

use crate::weather::clouds::CloudField;

/// Steps of a ray through the layer.
pub(super) const STEPS: usize = 48;

/// The layer about an eye.
pub(super) struct CloudCover<'c> {
    pub(super) field: &'c CloudField,
    /// Place of the eye among the voxels, eastward and northward.
    pub(super) eye: [f32; 2],
    /// Base and top above the eye, metres.
    pub(super) heights: [f32; 2],
    /// Voxels per metre eastward and northward, and layers' depths per metre upward.
    pub(super) per_voxel: f32,
    pub(super) per_depth: f32,
    /// Extinction where clouds are densest, 1/metres.
    pub(super) extinction: f32,
    /// Linear Rec. 709, 1 for white; 0 by night.
    pub(super) sunlight: [f32; 3],
    /// Share of the light on ground that clouds may keep from it.
    pub(super) shadowed: f32,
    /// Unit vector to the sun, and the direction that shadows follow.
    pub(super) to_sun: [f32; 3],
    pub(super) shadows: [f32; 3],
}
