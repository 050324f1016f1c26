//! Rasters with a mask as their last band.

use crate::raster::{Band, Raster, RasterInfo, Role, SampleType, Window};
use hedgehop_base::error::Result;

/// A raster with its mask as a last band. An alpha band that it has already gives way to the mask, unless its colours are
/// multiplied by it: then the mask takes pixels away from it.
pub(super) struct MaskedRaster {
    raster: Box<dyn Raster>,
    mask: Box<dyn Raster>,
    info: RasterInfo,
    /// Band in which the mask is told.
    place: u32,
}

impl MaskedRaster {
    pub fn new(raster: Box<dyn Raster>, mask: Box<dyn Raster>) -> Self {
        let own = raster.info();
        if let Some(place) = own.alpha_band.filter(|_| own.is_premultiplied) {
            let info = own.clone();
            return Self { raster, mask, info, place };
        }
        let place = own.bands;
        let mut info = RasterInfo { bands: own.bands + 1, alpha_band: Some(place), ..own.clone() };
        if !info.described.is_empty() {
            info.described.push(Band { role: Role::Alpha, ..Band::default() });
        }
        Self { raster, mask, info, place }
    }
}

impl Raster for MaskedRaster {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn read(&self, window: Window, bands: &[u32], samples: &mut Vec<f64>) -> Result<()> {
        let own = self.raster.info().bands;
        // The mask's place is read from the first band, then overwritten.
        let stored: Vec<u32> = bands.iter().map(|band| if *band == own { 0 } else { *band }).collect();
        self.raster.read(window, &stored, samples)?;
        let Some(place) = bands.iter().position(|band| *band == self.place) else { return Ok(()) };

        let mut mask = Vec::new();
        let layers: Vec<u32> = (0..self.mask.info().bands).collect();
        self.mask.read(window, &layers, &mut mask)?;

        // Masks of 8 bits may use 0 and 1.
        let opaque = if self.info.sample == SampleType::I8 { 127.0 } else { 255.0 };
        for (pixel, mask) in samples.chunks_exact_mut(bands.len()).zip(mask.chunks_exact(layers.len())) {
            if mask.iter().all(|mask| *mask == 0.0) {
                pixel[place] = 0.0;
            } else if self.place == own {
                pixel[place] = opaque;
            }
        }

        Ok(())
    }
}
