//! Overlays: what a view shows besides the ground, and what one of them draws.

use super::canvas::Canvas;
use crate::objects::{Body, PointLight, Ribbon};
use crate::scene::Scenery;
use crate::subimage::Farm;
use crate::weather::Puff;
use hedgehop_base::error::Result;

/// Overlays that may be merged with the ground.
#[derive(Debug, Clone, Copy, Default)]
pub struct Overlays<'t> {
    /// Bodies, no two with the same id.
    pub bodies: &'t [Body],
    /// Lamps that shine.
    pub lights: &'t [PointLight],
    /// Smoke and dust.
    pub puffs: &'t [Puff],
    /// Trails of what flew.
    pub trails: &'t [Ribbon],
}

impl<'t> From<&'t [Body]> for Overlays<'t> {
    fn from(bodies: &'t [Body]) -> Self {
        Self { bodies, ..Self::default() }
    }
}

impl<'t> From<&'t Vec<Body>> for Overlays<'t> {
    fn from(bodies: &'t Vec<Body>) -> Self {
        bodies.as_slice().into()
    }
}

impl<'t> From<&'t Scenery> for Overlays<'t> {
    fn from(scenery: &'t Scenery) -> Self {
        let Scenery { bodies, lights, puffs, trails, .. } = scenery;
        Self { bodies, lights, puffs, trails }
    }
}

impl<'t, const COUNT: usize> From<&'t [Body; COUNT]> for Overlays<'t> {
    fn from(bodies: &'t [Body; COUNT]) -> Self {
        bodies.as_slice().into()
    }
}

/// Overlay that is drawn over what the passes before it left on a canvas.
pub(super) trait Pass {
    /// Draws.
    ///
    /// # Errors
    /// A page that is damaged.
    fn draw(&self, canvas: &mut Canvas, farm: &Farm) -> Result<()>;
}
