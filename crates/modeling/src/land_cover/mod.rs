//! Land cover: which material the ground of each voxel is, by maps of classes.
//!
//! ```text
//! class of a voxel of level 1  = that of the pixel under its centre, of the first raster that knows one
//! class of a coarser voxel     = the most frequent of the centres of its 4 × 4 next finer voxels
//! colour, where pixels are wider than voxels:
//!     place  = centre, moved by noise of half a pixel
//!     shares = of classes in the 3 × 3 pixels around the place, by the quadratic B-spline
//!     colour = mixed by the fifth power of these: straight borders where pixels make stairs, a third of a pixel wide
//! colour, else                 = that of the class
//! ```
//! Classes are never interpolated; colours are, since squares of ten metres are no edges of fields. Both are functions of the place alone.

mod raster;
mod sample;
mod scheme;
mod survey;

use std::path::PathBuf;

pub(super) use raster::{ClassRaster, SampleClass};
pub(super) use sample::{CoverInput, LandCover, Sampler, varied};
pub use scheme::Scheme;
pub(super) use survey::unknown;

/// A map of classes of land cover, and what it does not say of itself.
#[derive(Debug, Clone)]
pub struct LandCoverFile {
    /// The file: whole numbers of 8 or 16 bits, one band.
    pub path: PathBuf,
    /// CRS of the file, if it states none.
    pub crs: Option<String>,
    /// Scheme of its numbers.
    pub scheme: Scheme,
    /// Numbers that say nothing, besides what it declares.
    pub nodata: Vec<f64>,
}
