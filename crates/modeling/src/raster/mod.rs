//! Rasters: elevation and imagery files behind one trait, read window by window.
//!
//! [`open`] finds the format and returns a [`Raster`]; nothing is decoded before it is asked for. Two readers do
//! the work for all formats:
//!
//! - `raw::RawRaster`: samples lie in the file as they are (uncompressed TIFF strips, `.hgt`, `.bil`, `.flt`, ENVI,
//!   headerless raw): a window is read row by row from where it lies, without a cache of its own.
//! - `blocks::BlockRaster`: everything that is decoded in blocks (TIFF tiles and strips, groups of DTED or `.bt`
//!   columns, groups of ASCII rows, whole PNG and JPEG pictures), through a cache bounded by
//!   [`OpenOptions::cache_bytes`] in which each block is decoded once, however many threads ask for it.
//!
//! [`ElevationRaster`] and [`ImageryRaster`] turn samples into metres and into colours.
//!
//! Every size that a file states is checked against the file's length or the cache before memory is allocated for it.

mod ascii;
mod band;
mod blocks;
mod bt;
mod cache;
mod columns;
#[cfg(test)]
mod damage;
mod detect;
mod dted;
mod ehdr;
mod elevation;
mod envi;
mod fields;
mod file;
mod georeference;
mod hgt;
mod imagery;
mod info;
mod mask;
mod masked;
mod nodata;
mod pam;
mod picture;
mod raw;
mod sample;
mod side;
#[cfg(test)]
pub(super) mod testing;
mod tiff;

use std::path::Path;

use hedgehop_base::error::Result;

pub use elevation::ElevationRaster;
pub(super) use file::{InputFile, read_exact_at};
pub use imagery::ImageryRaster;
pub use info::{Band, GeoTransform, OpenOptions, Raster, RasterInfo, RawLayout, Role, SampleType, Window};

/// Opens a raster of any supported format.
///
/// # Errors
/// One sentence that names the file, what is wrong or unsupported, and the command that converts it.
pub fn open(path: &Path, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    detect::open(path, options)
}
