//! The image stage: pictures and how they are written.

mod atmosphere;

use crate::space::Camera;
use crate::voxel::Attributes;

pub use atmosphere::Atmosphere;

/// One rendered frame. All planes are `[height][width]`, row 0 at the top of the screen.
#[derive(Debug, Clone)]
pub struct Frame {
    /// What looked.
    pub camera: Camera,
    /// Linear Rec. 709 radiance, display-referred: 1 is display white.
    pub colour: Vec<[f32; 3]>,
    /// Distance along the ray, metres; infinite where the sky is seen.
    pub range: Vec<f32>,
    /// Unit surface normal in world space (x east, y north, z up); zero for the sky.
    pub normal: Vec<[f32; 3]>,
    /// Level index of the surface that was seen; [`Frame::SKY_LEVEL`] for the sky.
    pub level: Vec<u8>,
    /// `source << 16 | material << 8 | flags` of the voxel; [`Frame::SKY_ID`] for the sky.
    pub id: Vec<u32>,
}

impl Frame {
    /// Level of pixels that see the sky.
    pub const SKY_LEVEL: u8 = 255;
    /// Id of pixels that see the sky.
    pub const SKY_ID: u32 = u32::MAX;

    /// A frame in which every pixel sees the sky, its colour still black.
    pub fn sky(camera: Camera) -> Self {
        let pixels = camera.width as usize * camera.height as usize;
        Self {
            camera,
            colour: vec![[0.0; 3]; pixels],
            range: vec![f32::INFINITY; pixels],
            normal: vec![[0.0; 3]; pixels],
            level: vec![Self::SKY_LEVEL; pixels],
            id: vec![Self::SKY_ID; pixels],
        }
    }

    /// How a voxel's attributes are packed into [`Self::id`].
    pub fn pixel_id(attributes: Attributes) -> u32 {
        u32::from(attributes.source) << 16 | u32::from(attributes.material) << 8 | u32::from(attributes.flags)
    }
}
