//! Lattice of a raster's posts on the ground.

use glam::DVec2;

use super::super::warp;
use crate::opened::Opened;

/// Lattice of a raster's posts on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lattice {
    /// Column and row of the origin of its reference system, so that tiles of one lattice have the same waves.
    origin: DVec2,
    /// Sides of a pixel along columns and rows, in sides of the square of its area.
    pitch: DVec2,
}

impl Lattice {
    /// Squares from the reference system's origin on.
    pub const SQUARES: Self = Self { origin: DVec2::ZERO, pitch: DVec2::ONE };

    /// Builds the lattice of a raster whose pixels are, at its centre, `sides` metres along columns and rows.
    pub fn of(raster: &Opened<f64>, sides: Option<(f64, f64)>) -> Self {
        let origin = warp::invert(&raster.geo)
            .map_or((0.0, 0.0), |pixel_from_source| warp::apply(&pixel_from_source, 0.0, 0.0));
        // The aspect is rounded to parts of 1, so that neighbouring tiles agree.
        const PARTS: f64 = 1024.0;
        let pitch = sides.map_or(DVec2::ONE, |(across, down)| {
            let aspect = ((across / down).sqrt() * PARTS).round() / PARTS;
            DVec2::new(aspect, 1.0 / aspect)
        });
        let usable = |pitch: &DVec2| pitch.is_finite() && pitch.min_element() > 0.0;
        Self { origin: origin.into(), pitch: Some(pitch).filter(usable).unwrap_or(DVec2::ONE) }
    }

    /// Place of a pixel position, whole numbers at posts, in mean distances of posts.
    pub(super) fn place(&self, column: f64, row: f64) -> DVec2 {
        (DVec2::new(column, row) + 0.5 - self.origin) * self.pitch
    }
}
