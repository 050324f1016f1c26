//! What the frames of a flight need, for whoever keeps pages in memory.

use glam::DVec2;

use super::Renderer;
use crate::error::Result;
use crate::memory::Foresight;
use crate::space::Camera;
use crate::subimage::Farm;
use crate::voxel::{PAGE_SIDE, PageId, PagePart, PageSource};

/// Foresees the frames that a renderer is to render.
#[derive(Debug)]
pub struct FlightPlan<'a, S> {
    /// Who renders.
    pub renderer: &'a Renderer<'a, S>,
    /// Workers that tables of directions may be computed by.
    pub farm: &'a Farm,
    /// What sees each frame, in order.
    pub cameras: &'a [(u64, Camera)],
}

impl<S: PageSource> Foresight for FlightPlan<'_, S> {
    fn needs(&self, frame: u32) -> Result<Vec<PagePart>> {
        match self.cameras.get(frame as usize) {
            Some((_, camera)) => self.renderer.foresee(camera, self.farm),
            None => Ok(Vec::new()),
        }
    }

    fn is_behind(&self, frame: u32, page: PageId) -> bool {
        let Some((_, camera)) = self.cameras.get(frame as usize) else { return true };
        let grid = &self.renderer.source.header().grid;
        let side = grid.side(page.level) * f64::from(PAGE_SIDE);
        let [low, high] = grid.page_square(page);
        let centre = (low + high) / 2.0;
        let (sin, cos) = camera.pose.attitude.yaw.to_radians().sin_cos();
        (centre - camera.pose.eye.truncate()).dot(DVec2::new(sin, cos)) < -side
    }
}
