//! Masks: which pixels of a raster mean anything.
//!
//! GDAL keeps a mask as a later directory of a TIFF (`tiff::mask`) or, for a raster of any format, as a TIFF beside it with `.msk`
//! behind its name (`gdal_translate -mask`, `nearblack -setmask`); the file beside it counts where there are both. 0 means that
//! there is nothing. A mask becomes an alpha band behind the others, so that nobody has to know of it.

use std::path::{Path, PathBuf};

use super::band::{Band, Role};
use super::file::InputFile;
use super::{OpenOptions, Raster, RasterInfo, SampleType, Window, tiff};
use hedgehop_base::error::{Error, Result};

/// A raster with its mask as a last band. An alpha band that it has already gives way to the mask, unless its colours are
/// multiplied by it: then the mask takes pixels away from it.
pub(super) struct Masked {
    raster: Box<dyn Raster>,
    mask: Box<dyn Raster>,
    info: RasterInfo,
    /// Band in which the mask is told.
    place: u32,
}

impl Masked {
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

impl Raster for Masked {
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

/// The raster with the mask beside it, or as it is if there is none.
///
/// # Errors
/// A mask that cannot be read, or is of another size.
pub(super) fn with_file(raster: Box<dyn Raster>, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let Some(path) = beside(&raster.info().path) else { return Ok(raster) };
    let mask = tiff::open_mask(&InputFile::open(&path)?, options).map_err(|error| {
        let told = error.to_string();
        let what = told.strip_prefix(&format!("{}: ", path.display())).unwrap_or(&told);
        Error::invalid(
            &path,
            format!("is the mask of the raster beside it, and {what}; write it anew, or remove it"),
        )
    })?;

    let size = |info: &RasterInfo| (info.width, info.height);
    let (own, wanted) = (size(mask.info()), size(raster.info()));
    if own != wanted {
        let what = format!(
            "has {} × {} pixels, and the raster that it is the mask of {} × {}; write it anew, or remove it",
            own.0, own.1, wanted.0, wanted.1
        );
        return Err(Error::invalid(&path, what));
    }

    Ok(Box::new(Masked::new(raster, mask)))
}

fn beside(path: &Path) -> Option<PathBuf> {
    [".msk", ".MSK"].into_iter().find_map(|extension| {
        let mut name = path.as_os_str().to_owned();
        name.push(extension);
        Some(PathBuf::from(name)).filter(|path| path.is_file())
    })
}
