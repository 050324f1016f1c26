//! Imagery that patterns below the voxel are matched from.

use std::path::PathBuf;

/// Fine pictures of such ground.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TextureExamples {
    /// Pictures; without any, the build's own imagery.
    pub files: Vec<PathBuf>,
    /// Side of their pixels, metres, where they do not say it themselves.
    pub pixel_m: Option<f64>,
    /// Seed that picks one of all patterns alike.
    pub seed: u64,
}
