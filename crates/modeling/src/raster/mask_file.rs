//! Masks in files of their own: which pixels of the raster beside them mean anything.
//!
//! GDAL keeps a mask as a later directory of a TIFF (`read/tiff/mask.rs`) or, for a raster of any format, as a TIFF beside
//! it with `.msk` behind its name (`gdal_translate -mask`, `nearblack -setmask`); the file beside it counts where there are
//! both. 0 means that there is nothing. A mask becomes an alpha band behind the others, so that nobody has to know of it.

use std::path::{Path, PathBuf};

use super::file::InputFile;
use super::masked_raster::MaskedRaster;
use super::read::tiff;
use crate::raster::{OpenOptions, Raster, RasterInfo};
use hedgehop_base::error::{Error, Result};

/// The raster with the mask beside it, or as it is if there is none.
///
/// # Errors
/// A mask that cannot be read, or is of another size.
pub(super) fn with_mask(raster: Box<dyn Raster>, options: &OpenOptions) -> Result<Box<dyn Raster>> {
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

    Ok(Box::new(MaskedRaster::new(raster, mask)))
}

fn beside(path: &Path) -> Option<PathBuf> {
    [".msk", ".MSK"].into_iter().find_map(|extension| {
        let mut name = path.as_os_str().to_owned();
        name.push(extension);
        Some(PathBuf::from(name)).filter(|path| path.is_file())
    })
}
