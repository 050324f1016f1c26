//! Rasters: elevation and imagery files behind one trait, read window by window.
//!
//! [`open`] finds the format (`detect.rs`) and returns a [`Raster`] of its reader (`read/`); nothing is decoded before it is
//! asked for. [`FORMATS`] lists the formats. Two types do the work for all readers:
//!
//! - `raw::RawRaster`: samples lie in the file as they are: a window is read row by row from where it lies, without a cache of
//!   its own.
//! - `blocks::BlockRaster`: everything that is decoded in blocks (tiles, groups of rows or columns, whole pictures), through a
//!   cache bounded by [`OpenOptions::cache_bytes`] in which each block is decoded once, however many threads ask for it.
//!
//! [`ElevationRaster`] and [`ImageryRaster`] turn samples into metres and into colours.
//!
//! Every size that a file states is checked against the file's length or the cache before memory is allocated for it.

mod band;
mod blocks;
mod cache;
mod columns;
#[cfg(test)]
mod damage_tests;
mod decimal;
mod detect;
mod elevation;
mod file;
mod formats;
mod georeference;
mod header_fields;
mod imagery;
mod info;
mod mask_file;
mod masked_raster;
mod nodata;
mod pam;
mod raw;
mod read;
mod reader;
mod sample;
mod side_files;
#[cfg(test)]
pub(super) mod testing;

use std::path::Path;

use hedgehop_base::error::Result;

pub use elevation::ElevationRaster;
pub(super) use file::{InputFile, read_exact_at};
pub use formats::{FORMATS, RasterFormat};
pub use imagery::ImageryRaster;
pub use info::{Band, GeoTransform, OpenOptions, RasterInfo, RawLayout, Role, SampleType};
pub use reader::{Raster, Window};

/// Opens a raster of any supported format.
///
/// # Errors
/// One sentence that names the file, what is wrong or unsupported, and the command that converts it.
pub fn open(path: &Path, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    detect::open(path, options)
}
