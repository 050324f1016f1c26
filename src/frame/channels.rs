//! Channels of a rendered frame.

use std::path::Path;

use glam::DVec3;

use super::matte::Matte;
use crate::space::Camera;
use crate::voxel::{Attributes, Material};
use hedgehop_base::error::{Error, Result};

/// One rendered frame. All arrays are `[height][width]`, row 0 at the top of the screen.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Camera that looked.
    pub camera: Camera,
    /// Linear Rec. 709 radiance, display-referred: 1 is display white.
    pub colour: Vec<[f32; 3]>,
    /// Distance along the ray, metres; infinite where the sky is seen, and where the screen has no picture
    /// ([`Camera::ray`] is `None`): there the colour is black.
    pub range: Vec<f32>,
    /// Unit normal of the surface that was seen, ground or solid, in world space (x east, y north, z up); zero for the sky.
    /// Normals of crowns may look away from the eye.
    pub normal: Vec<[f32; 3]>,
    /// Level index of the surface that was seen; [`Frame::SKY_LEVEL`] for the sky, [`Frame::BODY_LEVEL`] for bodies.
    pub level: Vec<u8>,
    /// `source << 16 | material << 8 | flags` of the voxel; [`Frame::SKY_ID`] for the sky, [`Frame::body_id`] for bodies.
    pub id: Vec<u32>,
    /// Further channels that were asked for.
    pub aov: Aov,
}

/// Further values of a frame's pixels, which EXR files hold if they are there. The field calls them arbitrary output variables.
#[derive(Debug, Clone, Default)]
pub struct Aov {
    /// Share that bodies and ground have of each pixel.
    pub matte: Option<Matte>,
    /// Motion vectors: pixels to the right and up until the next frame, `[height][width]`; see [`motion()`](super::motion()).
    pub motion: Option<Vec<[f32; 2]>>,
    /// Positions on the map; see [`map_positions()`](super::map_positions()).
    pub position: Option<MapPositions>,
    /// Change of each pixel's light by detail below the finest voxel, relative to what it is without, before haze and snow, `[height][width]`: 0.2 is a fifth lighter. 0 where there is none.
    pub synthesis: Option<Vec<f32>>,
    /// Whether files get a colour for each material: [`Material::mark`] of each pixel's `id`.
    pub material: bool,
}

/// Positions on the map of a frame's pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct MapPositions {
    /// Point that positions count from, metres in the database's reference system.
    pub offset: DVec3,
    /// Metres east, north and up of the offset, `[height][width]`; infinite where no surface is seen.
    pub points: Vec<[f32; 3]>,
}

impl Frame {
    /// Level of pixels that see the sky.
    pub const SKY_LEVEL: u8 = 255;
    /// Level of pixels that see a body.
    pub const BODY_LEVEL: u8 = 254;
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
            aov: Aov::default(),
        }
    }

    /// Id of pixels that see the body of a number below 2³¹ − 1: no voxel has so high a one.
    pub fn body_id(number: u32) -> u32 {
        1 << 31 | number
    }

    /// The number of the body that an [`Self::id`] tells; `None`: of the sky, or of the ground.
    pub fn body_of(id: u32) -> Option<u32> {
        (id >> 31 == 1 && id != Self::SKY_ID).then_some(id & !(1 << 31))
    }

    /// The material that an [`Self::id`] tells; `None`: of the sky, or of a body.
    pub fn material_of(id: u32) -> Option<Material> {
        (id >> 31 == 0).then(|| Material::of_code((id >> 8) as u8))
    }

    /// Packs a voxel's attributes as they stand in [`Self::id`].
    pub fn pixel_id(attributes: Attributes) -> u32 {
        u32::from(attributes.source) << 16 | u32::from(attributes.material) << 8 | u32::from(attributes.flags)
    }

    /// Checks that every array has one value per pixel of the camera; `path` is where it was to go.
    pub(crate) fn check_lengths(&self, path: &Path) -> Result<()> {
        let (width, height) = (self.camera.width as usize, self.camera.height as usize);
        let pixels = width.checked_mul(height).filter(|&pixels| pixels > 0);
        let lengths =
            [self.colour.len(), self.range.len(), self.normal.len(), self.level.len(), self.id.len()];
        if lengths.iter().any(|&length| Some(length) != pixels) {
            let what = format!(
                "arrays of {lengths:?} values (colour, range, normal, level, id) do not make a picture of \
                 {width}×{height}; --size must be at least 1×1"
            );
            return Err(Error::invalid(path, what));
        }
        if self.aov.motion.as_ref().is_some_and(|motion| motion.len() != self.id.len()) {
            return Err(Error::invalid(path, "motion of other pixels than those of the picture"));
        }
        if self.aov.position.as_ref().is_some_and(|position| position.points.len() != self.id.len()) {
            return Err(Error::invalid(path, "positions of other pixels than those of the picture"));
        }
        Ok(())
    }
}
