//! Choice of the engine for a view.

use super::options::Engine;
use super::plane_view::PlaneView;
use super::renderer::Renderer;
use super::unserved::Unserved;
use crate::space::Camera;
use crate::subimage::Farm;
use hedgehop_base::error::Result;

impl Renderer<'_> {
    /// The engine that renders what `camera` sees: that of the options, or the reference where it does not serve.
    ///
    /// # Errors
    /// As of [`Farm::new`].
    pub fn engine_for(&self, camera: &Camera) -> Result<Engine> {
        let by_reference = self.options.engine == Engine::Reference || self.unserved(camera)?.is_some();
        Ok(if by_reference { Engine::Reference } else { Engine::Planes })
    }

    /// Why scan planes would not serve what `camera` sees; `None`: they would.
    ///
    /// # Errors
    /// As of [`Farm::new`].
    pub fn unserved(&self, camera: &Camera) -> Result<Option<Unserved>> {
        match Unserved::of(&self.options) {
            Some(why) => Ok(Some(why)),
            None => PlaneView::unserved(camera, &self.shared.screen, &Farm::new(1)?),
        }
    }

    /// Whether the options are for scan planes.
    fn takes_planes(&self) -> bool {
        self.options.engine == Engine::Planes && Unserved::of(&self.options).is_none()
    }

    /// Chooses how scan planes see what the camera sees; `None` where they do not serve.
    pub(super) fn planes<'c>(&self, camera: &'c Camera, farm: &Farm) -> Result<Option<PlaneView<'c>>> {
        if !self.takes_planes() {
            return Ok(None);
        }
        PlaneView::new(self.source.header(), camera, &self.shared.screen, farm)
    }
}
