//! A raster of given samples, for the tests of what reads rasters.

use std::path::Path;

use crate::raster::{Raster, RasterInfo, SampleType, Window};
use hedgehop_base::error::Result;

/// What it says of itself, and its samples, interleaved by pixel.
pub struct Fixed(pub RasterInfo, pub Vec<f64>);

impl Raster for Fixed {
    fn info(&self) -> &RasterInfo {
        &self.0
    }
    fn read(&self, window: Window, bands: &[u32], samples: &mut Vec<f64>) -> Result<()> {
        samples.clear();
        for y in window.y..window.y + window.height {
            for x in window.x..window.x + window.width {
                let pixel = (y * self.0.width + x) * self.0.bands;
                samples.extend(bands.iter().map(|band| self.1[(pixel + band) as usize]));
            }
        }
        Ok(())
    }
}

/// One row of pixels.
pub fn raster(sample: SampleType, bands: u32, samples: &[f64]) -> Fixed {
    let info = RasterInfo {
        width: samples.len() as u32 / bands,
        height: 1,
        bands,
        sample,
        ..RasterInfo::blank(Path::new("a.tif"), "GeoTIFF")
    };
    Fixed(info, samples.to_vec())
}
