//! The trait that all readers implement, and the windows that they read.

use super::info::RasterInfo;
use hedgehop_base::error::Result;

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
    /// Returns the properties.
    fn info(&self) -> &RasterInfo;

    /// Raw samples (before scale, offset, nodata) of zero-based `bands`, pixel-interleaved, rows from the north:
    /// `[window.height][window.width][bands.len()]`, replacing what `samples` held.
    fn read(&self, window: Window, bands: &[u32], samples: &mut Vec<f64>) -> Result<()>;
}
