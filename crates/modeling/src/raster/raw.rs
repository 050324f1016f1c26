//! Rasters whose samples lie in the file as they are: a window is read row by row from where it lies.

use super::blocks::prepare;
use super::file::InputFile;
use super::sample::{ByteOrder, Pixels, Stride};
use crate::raster::{Raster, RasterInfo, Window};
use hedgehop_base::error::{Error, Result};

/// Placement of the samples. The sample of a column, row and band begins at
/// `row_start(row) + band · band_bytes + column · pixel_bytes`.
#[derive(Debug)]
pub(super) struct SamplePlacement {
    pub rows: RowStarts,
    /// Bytes from one pixel of a row to the next.
    pub pixel_bytes: u64,
    /// Bytes from one band to the next, the same row and column.
    pub band_bytes: u64,
    pub order: ByteOrder,
}

/// Begins of rows.
#[derive(Debug)]
pub(super) enum RowStarts {
    /// Evenly spaced from `first` on.
    Even { first: u64, row_bytes: u64 },
    /// Strips of `rows` rows; `offsets[strip]` is where one begins.
    Strips { offsets: Vec<u64>, rows: u32, row_bytes: u64 },
}

impl RowStarts {
    fn start(&self, row: u32) -> Option<u64> {
        match self {
            Self::Even { first, row_bytes } => first.checked_add(row_bytes.checked_mul(u64::from(row))?),
            Self::Strips { offsets, rows, row_bytes } => {
                let begin = offsets.get((row / rows) as usize)?;
                begin.checked_add(row_bytes.checked_mul(u64::from(row % rows))?)
            }
        }
    }
}

/// A raster of samples that lie in the file as they are.
#[derive(Debug)]
pub(super) struct RawRaster {
    file: InputFile,
    info: RasterInfo,
    placement: SamplePlacement,
}

impl RawRaster {
    /// Checks that the file holds the corners of every band's last row, then reads windows.
    pub fn new(file: InputFile, info: RasterInfo, placement: SamplePlacement) -> Result<Self> {
        if info.width == 0 || info.height == 0 || info.bands == 0 {
            return Err(Error::invalid(&info.path, "states a size of zero; its header is damaged"));
        }
        let raster = Self { file, info, placement };
        let end = raster.offset(raster.info.width - 1, raster.info.height - 1, raster.info.bands - 1);
        let end = end.and_then(|end| end.checked_add(raster.info.sample.bytes() as u64));
        if end.is_none_or(|end| end > raster.file.length()) {
            let what = format!(
                "is said to hold {} × {} pixels of {} in {} band(s), but ends at byte {}; it is cut short or its header is wrong",
                raster.info.width,
                raster.info.height,
                raster.info.sample.name(),
                raster.info.bands,
                raster.file.length()
            );
            return Err(Error::invalid(&raster.info.path, what));
        }
        Ok(raster)
    }

    /// Whether the bands of a pixel lie side by side: one read brings them all.
    fn is_interleaved(&self) -> bool {
        let size = self.info.sample.bytes() as u64;
        let SamplePlacement { pixel_bytes, band_bytes, .. } = self.placement;
        band_bytes == size && u64::from(self.info.bands) * size <= pixel_bytes
    }

    fn offset(&self, column: u32, row: u32, band: u32) -> Option<u64> {
        let start = self.placement.rows.start(row)?;
        let band = self.placement.band_bytes.checked_mul(u64::from(band))?;
        let column = self.placement.pixel_bytes.checked_mul(u64::from(column))?;
        start.checked_add(band)?.checked_add(column)
    }
}

impl Raster for RawRaster {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn read(&self, window: Window, bands: &[u32], samples: &mut Vec<f64>) -> Result<()> {
        prepare(&self.info, window, bands, samples)?;
        let (sample, size) = (self.info.sample, self.info.sample.bytes());
        let per_pixel = (self.placement.pixel_bytes as usize / size).max(1);
        let count = window.width as usize;
        let mut bytes = Vec::new();

        for y in 0..window.height {
            let mut position = y as usize * count * bands.len();
            for group in bands.chunks(if self.is_interleaved() { bands.len().max(1) } else { 1 }) {
                let (low, high) = group.iter().fold((u32::MAX, 0), |(l, h), b| (l.min(*b), h.max(*b)));
                let offset = self.offset(window.x, window.y + y, low).ok_or_else(|| {
                    Error::invalid(&self.info.path, format!("row {} lies beyond the file", window.y + y))
                })?;
                bytes.resize(((count - 1) * per_pixel + (high - low) as usize + 1) * size, 0);
                self.file.read_at(&mut bytes, offset)?;
                self.placement.order.make_native(&mut bytes, size);
                let pixels = Pixels { sample, bytes: &bytes, first: 0, count, samples: per_pixel };
                let within: Vec<u32> = group.iter().map(|band| band - low).collect();
                pixels.widen(&within, Stride { first: position, step: bands.len() }, samples);
                position += group.len();
            }
        }

        Ok(())
    }
}
