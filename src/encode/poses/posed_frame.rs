//! A frame's camera, as files of poses tell it.

use glam::{DMat3, DQuat, DVec3};

use crate::space::{Attitude, Camera, Pose};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// A frame's camera, as its record tells it.
#[derive(Debug, Clone, Copy)]
pub struct PosedFrame<'a> {
    /// Number, absolute, from 1.
    pub number: u64,
    /// File name of its picture, relative to the folder.
    pub file: &'a str,
    /// Time since the start of the flight, seconds.
    pub seconds: f64,
    /// Eye, metres in the database's reference system.
    pub eye: DVec3,
    /// Attitude of the view itself.
    pub attitude: Attitude,
    /// [`Screen`](crate::space::Screen) as text.
    pub screen: &'a str,
    /// Pixels.
    pub size: Size,
}

/// Planar screen of a camera, with its lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Intrinsics {
    /// Pixels.
    pub size: Size,
    /// Distance of the screen from the eye, pixels.
    pub focal: f64,
    /// Coefficients k₁ and k₂ of radial distortion, as of OpenCV; 0 without a lens.
    pub k: [f64; 2],
}

impl PosedFrame<'_> {
    /// Columns: right, up, back, in world axes: OpenGL's axes of a camera.
    pub(super) fn world_from_gl(&self) -> DMat3 {
        let DMat3 { x_axis: right, y_axis: up, z_axis: forward } = self.attitude.world_from_view();
        DMat3::from_cols(right, up, -forward)
    }

    /// Columns: right, down, forward, in world axes: OpenCV's axes of a camera.
    pub(super) fn world_from_cv(&self) -> DMat3 {
        let DMat3 { x_axis: right, y_axis: up, z_axis: forward } = self.attitude.world_from_view();
        DMat3::from_cols(right, -up, forward)
    }

    /// Returns the screen as a camera of photogrammetry.
    ///
    /// # Errors
    /// [`Error::Configuration`] for a screen that is no plane.
    pub(super) fn intrinsics(&self) -> Result<Intrinsics> {
        let value = |key: &str| -> Option<f64> {
            self.screen.split(' ').find_map(|part| part.strip_prefix(key)?.strip_prefix('=')?.parse().ok())
        };
        let kind = self.screen.split(' ').next().unwrap_or_default();
        let hfov = value("hfov_deg").filter(|_| ["planar", "lens"].contains(&kind)).ok_or_else(|| {
            Error::Configuration(format!(
                "frame {} has a screen of kind {kind}, of which transforms and colmap have no camera; leave them out, or take a planar screen",
                self.number
            ))
        })?;

        let Size { width, height } = self.size;
        let pose = Pose { eye: self.eye, attitude: self.attitude, hfov };
        let focal = Camera::new(pose, width, height).focal_px();
        Ok(Intrinsics { size: self.size, focal, k: ["k1", "k2"].map(|key| value(key).unwrap_or(0.0)) })
    }
}

impl Intrinsics {
    /// Middle of the picture, pixels from its left and its top.
    pub fn middle(&self) -> [f64; 2] {
        [self.size.width, self.size.height].map(|side| 0.5 * f64::from(side))
    }

    /// Whether a lens distorts the picture.
    pub fn is_distorted(&self) -> bool {
        self.k != [0.0; 2]
    }
}

/// The unit quaternion of a rotation, of the two the one with w ≥ 0.
pub(super) fn quaternion(rotation: DMat3) -> DQuat {
    let found = DQuat::from_mat3(&rotation).normalize();
    if found.w < 0.0 { -found } else { found }
}
