//! Meshes by size on the screen.

use std::sync::Arc;

use glam::DVec3;

use super::mesh::Mesh;

/// What a thing looks like near and far.
#[derive(Debug)]
pub struct Model {
    /// The finest first.
    levels: Vec<Level>,
}

/// A mesh, for sizes on the screen.
#[derive(Debug, Clone)]
pub struct Level {
    /// What is seen.
    pub mesh: Arc<Mesh>,
    /// Pixels, the diameter of a sphere around the finest mesh's box, below which this one is seen; of the finest infinite.
    pub below: f64,
}

impl Model {
    /// A thing that looks like `mesh`, and like one of `coarser` where it is smaller on the screen.
    pub fn new(mesh: Arc<Mesh>, coarser: impl IntoIterator<Item = Level>) -> Self {
        let mut levels = vec![Level { mesh, below: f64::INFINITY }];
        levels.extend(coarser);
        levels.sort_by(|a, b| b.below.total_cmp(&a.below));
        Self { levels }
    }

    /// Its meshes, the finest first.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// What it looks like where it is so many pixels large.
    pub fn at(&self, pixels: f64) -> &Arc<Mesh> {
        let finest = &self.levels[0];
        &self.levels.iter().rev().find(|level| pixels < level.below).unwrap_or(finest).mesh
    }

    /// Least and greatest corner of the box around all of its meshes, metres.
    pub fn corners(&self) -> [DVec3; 2] {
        let all = self.levels.iter().map(|level| level.mesh.corners().map(glam::Vec3::as_dvec3));
        all.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], [least, most]| {
            [low.min(least), high.max(most)]
        })
    }
}
