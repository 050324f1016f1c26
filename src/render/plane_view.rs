//! Views that scan planes serve, and the directions of their screens.

use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use super::unserved::Unserved;
use crate::raymarch::scan::{Directions, Panorama, PlaneArray, Refusal, Upright};
use crate::space::Camera;
use crate::subimage::{Farm, Stage};
use crate::voxel::Header;
use hedgehop_base::error::Result;

/// View of a camera as scan planes take it.
pub struct PlaneView<'c> {
    pub camera: &'c Camera,
    pub shape: PlaneArray,
    /// The eye: units, units, metres.
    pub eye: DVec3,
}

impl<'c> PlaneView<'c> {
    /// Why planes do not serve a camera; `None`: they do.
    pub fn unserved(camera: &Camera, screen: &LastScreen, farm: &Farm) -> Result<Option<Unserved>> {
        if let Some(upright) = Upright::new(camera) {
            return Ok((!PlaneArray::Upright(upright).fits()).then_some(Unserved::ManyPixels));
        }
        if let Some(why) = Panorama::refuses(camera) {
            return Ok(Some(match why {
                Refusal::NoEye => Unserved::Orthographic,
                Refusal::FinePixels => Unserved::FinePixels,
                Refusal::ManyPixels => Unserved::ManyPixels,
            }));
        }
        Ok(screen.directions(camera, farm)?.is_none().then_some(Unserved::Strewn))
    }

    /// `None`: planes do not serve this camera.
    pub fn new(
        header: &Header,
        camera: &'c Camera,
        screen: &LastScreen,
        farm: &Farm,
    ) -> Result<Option<Self>> {
        let shape = match Upright::new(camera) {
            Some(upright) => Some(PlaneArray::Upright(upright)),
            None => screen
                .directions(camera, farm)?
                .map(|directions| PlaneArray::Panorama(Panorama::new(camera, directions))),
        };
        let eye = camera.pose.eye;
        let ground = (eye.truncate() - header.grid.origin) / header.grid.spacing;
        let seen = |shape| Self { camera, shape, eye: ground.extend(eye.z) };
        Ok(shape.filter(PlaneArray::fits).map(seen))
    }
}

/// Directions of the last screen that needed a table: frames of one flight share it.
#[derive(Debug, Default)]
pub struct LastScreen(Mutex<Option<Arc<Directions>>>);

impl LastScreen {
    /// The directions of a screen's pixels; `None` where planes do not serve it.
    fn directions(&self, camera: &Camera, farm: &Farm) -> Result<Option<Arc<Directions>>> {
        if Panorama::refuses(camera).is_some() {
            return Ok(None);
        }
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let directions = match known.filter(|known| known.serve(camera)) {
            Some(known) => known,
            None => self.keep(Directions::new(camera), camera, farm)?,
        };
        Ok(Some(directions).filter(|directions| Panorama::serves(camera, directions)))
    }

    fn keep(&self, mut directions: Directions, camera: &Camera, farm: &Farm) -> Result<Arc<Directions>> {
        farm.each(Stage::March, directions.parts(), |_, part| {
            part.fill(camera);
            Ok(())
        })?;
        let directions = Arc::new(directions);
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(directions.clone());
        Ok(directions)
    }
}
