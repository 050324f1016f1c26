//! Meshes by size on the screen.

use std::sync::Arc;

use glam::DVec3;

use super::mesh::Mesh;

/// Levels of detail of a thing's mesh.
#[derive(Debug)]
pub struct Model {
    /// The finest first.
    levels: Vec<Level>,
    /// Pixels below which nothing is seen.
    least: f64,
    /// Metres of what is to be as large on the screen as levels say; `None`: the diameter of the sphere around the box.
    size: Option<f64>,
}

/// A mesh, for sizes on the screen.
#[derive(Debug, Clone)]
pub struct Level {
    /// Mesh of the level.
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
        Self { levels, least: 0.0, size: None }
    }

    /// The same, of which nothing is seen where it is smaller than so many pixels on the screen; it goes on to cast a shadow.
    #[must_use]
    pub fn hidden_below(self, pixels: f64) -> Self {
        Self { least: pixels, ..self }
    }

    /// The same as part of something so many metres large, more than 0, whose size on the screen says which level is seen.
    #[must_use]
    pub fn seen_with(self, metres: f64) -> Self {
        Self { size: Some(metres), ..self }
    }

    /// Returns the meshes, the finest first.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Chooses the mesh for where the thing is so many pixels large; `None`: it is not seen.
    pub fn at(&self, pixels: f64) -> Option<&Arc<Mesh>> {
        let finest = &self.levels[0];
        let level = self.levels.iter().rev().find(|level| pixels < level.below).unwrap_or(finest);
        (pixels >= self.least).then_some(&level.mesh)
    }

    /// Metres of what has the size on the screen that says which level is seen.
    pub fn size(&self) -> f64 {
        self.size.unwrap_or_else(|| {
            let [low, high] = self.corners();
            (high - low).length()
        })
    }

    /// Least and greatest corner of the box around all of its meshes, metres.
    pub fn corners(&self) -> [DVec3; 2] {
        let all = self.levels.iter().map(|level| level.mesh.corners().map(glam::Vec3::as_dvec3));
        all.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], [least, most]| {
            [low.min(least), high.max(most)]
        })
    }
}
