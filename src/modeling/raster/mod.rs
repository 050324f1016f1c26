//! Rasters: elevation and imagery files behind one trait, read window by window.

use std::path::PathBuf;

use crate::error::Result;
use crate::geo::{Crs, VerticalDatum};

/// `x = c[0] + c[1]·column + c[2]·row`, `y = c[3] + c[4]·column + c[5]·row` of a pixel's north-west
/// corner, columns and rows counted from the north-west corner of the raster (GDAL's convention; pixel-is-point
/// files are already shifted by half a pixel).
pub type GeoTransform = [f64; 6];

/// Type of stored samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum SampleType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

/// What a raster is.
#[derive(Debug, Clone)]
pub struct RasterInfo {
    /// The file.
    pub path: PathBuf,
    /// Format for people, e.g. `GeoTIFF`, `DTED level 1`.
    pub format: &'static str,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bands.
    pub bands: u32,
    /// Sample type.
    pub sample: SampleType,
    /// Georeferencing, if the file or a side file has any.
    pub geo: Option<GeoTransform>,
    /// Horizontal CRS, if stated.
    pub crs: Option<Crs>,
    /// Vertical datum, if stated.
    pub vertical_datum: Option<VerticalDatum>,
    /// Metres per vertical unit (0.3048 for feet), 1 if silent.
    pub metres_per_unit: f64,
    /// Value that means no data, if stated (NaN possible; NaN samples are void always).
    pub nodata: Option<f64>,
    /// Physical value = offset + scale · sample (1 and 0 if silent).
    pub scale: f64,
    /// See `scale`.
    pub offset: f64,
    /// Index (zero-based) of an alpha band, if any.
    pub alpha_band: Option<u32>,
    /// True: samples are stated at points (AREA_OR_POINT=Point); only informative, `geo` is corrected already.
    pub pixel_is_point: bool,
    /// Natural block (columns, rows) for reading.
    pub block: (u32, u32),
}

/// Part of a raster, in pixels; lies within it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns, ≥ 1.
    pub width: u32,
    /// Rows, ≥ 1.
    pub height: u32,
}

/// A raster file, readable from many threads; decoded blocks are cached within the bytes given when it was opened.
pub trait Raster: Send + Sync {
    /// What it is.
    fn info(&self) -> &RasterInfo;

    /// Raw samples (before scale, offset, nodata) of zero-based `bands`, pixel-interleaved, rows from the north:
    /// `[window.height][window.width][bands.len()]`, replacing what `samples` held.
    fn read(&self, window: Window, bands: &[u32], samples: &mut Vec<f64>) -> Result<()>;
}
