//! Clouds over what was rendered of ground and bodies.

use std::sync::{Arc, Mutex, PoisonError};

use super::Renderer;
use crate::frame::clouds::{CloudField, CloudLattice, CloudStage};
use crate::frame::stage::Pixels;
use crate::frame::{Frame, Picture};
use crate::scene::Clouds;
use crate::space::Camera;
use crate::subimage::{Farm, Stage};
use crate::voxel::PageSource;
use hedgehop_base::error::Result;

/// Bytes of an 8-bit pixel.
const RGB: usize = 3;

/// The voxels of a renderer's clouds, made for the first frame that has them.
#[derive(Debug, Default)]
pub struct LastField(Mutex<Option<Arc<CloudField>>>);

impl LastField {
    fn get(&self, make: impl FnOnce() -> CloudField) -> Arc<CloudField> {
        let mut field = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        field.get_or_insert_with(|| Arc::new(make())).clone()
    }
}

/// Puts clouds into a picture, of which `range` tells how far is what it shows.
pub fn into_picture<S: PageSource>(
    renderer: &Renderer<'_, S>,
    camera: &Camera,
    picture: &mut Picture,
    range: &[f32],
    farm: &Farm,
) -> Result<()> {
    each_band(renderer, camera, farm, |stage| {
        let pixels = stage.band_rows() * camera.width as usize;
        picture.rgb.chunks_mut(RGB * pixels).map(Pixels::Srgb8).zip(range.chunks(pixels)).collect()
    })
}

/// Puts clouds into a frame; its ranges stay those of what is behind.
pub fn into_frame<S: PageSource>(renderer: &Renderer<'_, S>, frame: &mut Frame, farm: &Farm) -> Result<()> {
    let Frame { camera, colour, range, .. } = frame;
    each_band(renderer, camera, farm, |stage| {
        let pixels = stage.band_rows() * camera.width as usize;
        colour.chunks_mut(pixels).map(Pixels::Linear).zip(range.chunks(pixels)).collect()
    })
}

/// Fills bands of the screen's rows.
fn each_band<'b, S: PageSource>(
    renderer: &Renderer<'_, S>,
    camera: &Camera,
    farm: &Farm,
    bands: impl FnOnce(&CloudStage<'_>) -> Vec<(Pixels<'b>, &'b [f32])>,
) -> Result<()> {
    let Some(clouds) = &renderer.options.weather.clouds else { return Ok(()) };
    let (sun, header) = (renderer.options.sun, renderer.source.header());
    let field = renderer.shared.clouds.get(|| CloudField::new(clouds, sun));
    let atmosphere = renderer.options.atmosphere(header);
    let air = (&atmosphere, header.height_range.1);
    let tint = renderer.options.brightness().tint();
    let layer: (&CloudField, &Clouds) = (&field, clouds);
    let Some(stage) = CloudStage::new(renderer.isa, camera, layer, sun, air, renderer.seconds) else {
        return Ok(());
    };
    let stage = stage.tinted(tint);
    let rows = stage.band_rows();
    farm.each_with(Stage::Image, bands(&stage), CloudLattice::default, |lattice, index, (light, range)| {
        stage.fill(lattice, index * rows, light, range);
        Ok(())
    })
}
