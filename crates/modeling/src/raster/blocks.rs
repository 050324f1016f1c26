//! Rasters that are decoded block by block through the cache.

use std::sync::Arc;

use super::cache::{BlockCache, Weigh};
use super::sample::{Pixels, Stride};
use crate::raster::{Raster, RasterInfo, SampleType, Window};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// Command that converts a file to one of small tiles.
pub(super) const TO_TILES: &str = "gdal_translate -co TILED=YES IN out.tif";
/// Command that converts a file to one of small tiles, each compressed.
pub(super) const TO_DEFLATED_TILES: &str = "gdal_translate -co TILED=YES -co COMPRESS=DEFLATE IN out.tif";

/// Position of a block in the block grid; `plane` is the band if bands lie apart, otherwise 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BlockIndex {
    pub column: u32,
    pub row: u32,
    pub plane: u32,
}

/// A decoded block; row after row, bands interleaved.
#[derive(Debug)]
pub(super) enum Block {
    /// Samples in native byte order; `stride` is the number of pixels per row.
    Samples { bytes: Vec<u8>, stride: u32 },
    /// Every sample is the same.
    Constant(f64),
}

impl Weigh for Block {
    fn weight(&self) -> u64 {
        let own = size_of::<Self>() as u64;
        match self {
            Self::Samples { bytes, .. } => own + bytes.capacity() as u64,
            Self::Constant(_) => own,
        }
    }
}

/// Decodes the blocks of one file.
pub(super) trait BlockSource: Send + Sync {
    /// Returns the raster's properties; `block` is the grid of the blocks.
    fn info(&self) -> &RasterInfo;
    /// Each band in blocks of its own (TIFF's planar configuration).
    fn planar(&self) -> bool {
        false
    }
    /// Decodes one block.
    fn decode(&self, index: BlockIndex) -> Result<Block>;
}

/// A raster over a [`BlockSource`].
pub(super) struct BlockRaster<S> {
    source: S,
    cache: BlockCache<Block>,
}

impl<S: BlockSource> BlockRaster<S> {
    /// Caches up to `cache_bytes` of decoded blocks.
    ///
    /// # Errors
    /// If a single block exceeds `cache_bytes`; `remedy` tells how to convert the file.
    pub fn new(source: S, cache_bytes: u64, remedy: &str) -> Result<Self> {
        let info = source.info();
        let bands = if source.planar() { 1 } else { info.bands };
        let bytes = block_bytes(info.block, bands, info.sample);
        if bytes.is_none_or(|bytes| bytes > cache_bytes) {
            let mebibytes = |bytes: u64| bytes.div_ceil(1 << 20);
            let need = bytes.map_or_else(|| "too many".to_owned(), |b| mebibytes(b).to_string());
            let what = format!(
                "can only be decoded in pieces of {} × {} pixels ({need} MiB), and {} MiB of --memory are this file's share",
                info.block.width,
                info.block.height,
                mebibytes(cache_bytes)
            );
            return Err(Error::unsupported(
                &info.path,
                what,
                format!("raise --memory, or convert it: {remedy}"),
            ));
        }

        Ok(Self { source, cache: BlockCache::new(cache_bytes) })
    }

    fn block(&self, index: BlockIndex) -> Result<Arc<Block>> {
        let info = self.source.info();
        let across = u64::from(info.width.div_ceil(info.block.width));
        let down = u64::from(info.height.div_ceil(info.block.height));
        // At most 2³² columns times 2³² rows of blocks per plane, and each of them has an entry in memory or a part of the
        // file; the wrapping product only matters as a key.
        let key = (u64::from(index.plane).wrapping_mul(down) + u64::from(index.row))
            .wrapping_mul(across)
            .wrapping_add(u64::from(index.column));
        self.cache.get(key, || self.source.decode(index))
    }
}

/// Bytes of one block, or `None` if that exceeds 64 bits.
pub(super) fn block_bytes(block: Size, bands: u32, sample: SampleType) -> Option<u64> {
    (u64::from(block.width) * u64::from(block.height))
        .checked_mul(u64::from(bands))?
        .checked_mul(sample.bytes() as u64)
}

/// Refuses windows and bands that the raster does not have, and sizes `samples` for the answer.
pub(super) fn prepare(
    info: &RasterInfo,
    window: Window,
    bands: &[u32],
    samples: &mut Vec<f64>,
) -> Result<()> {
    let inside = |first: u32, count: u32, size: u32| count > 0 && first < size && count <= size - first;
    if !inside(window.x, window.width, info.width) || !inside(window.y, window.height, info.height) {
        return Err(Error::invalid(
            &info.path,
            format!("has {} × {} pixels and does not hold the window {window:?}", info.width, info.height),
        ));
    }
    if let Some(band) = bands.iter().find(|band| **band >= info.bands) {
        return Err(Error::invalid(
            &info.path,
            format!("has {} bands, not {}", info.bands, u64::from(*band) + 1),
        ));
    }

    let count = (window.width as usize).checked_mul(window.height as usize);
    let Some(count) = count.and_then(|count| count.checked_mul(bands.len())) else {
        return Err(Error::invalid(&info.path, format!("the window {window:?} exceeds memory")));
    };

    samples.clear();
    samples.resize(count, 0.0);
    Ok(())
}

/// The part of a block that a window covers.
struct Overlap {
    /// First column and row in the window.
    window_x: usize,
    window_y: usize,
    /// First column and row in the block.
    block_x: usize,
    block_y: usize,
    width: usize,
    height: usize,
}

impl Overlap {
    fn new(window: Window, block: Size, column: u32, row: u32) -> Self {
        let axis = |start: u32, count: u32, size: u32, index: u32| {
            let begin = u64::from(index) * u64::from(size);
            let first = u64::from(start).max(begin);
            let end = (u64::from(start) + u64::from(count)).min(begin + u64::from(size));
            (
                (first - u64::from(start)) as usize,
                (first - begin) as usize,
                end.saturating_sub(first) as usize,
            )
        };
        let (window_x, block_x, width) = axis(window.x, window.width, block.width, column);
        let (window_y, block_y, height) = axis(window.y, window.height, block.height, row);
        Self { window_x, window_y, block_x, block_y, width, height }
    }

    /// Copies samples `bands` of each pixel, of `side_by_side` that it has in the block, to the window.
    fn copy(&self, block: &Block, sample: SampleType, bands: &[u32], side_by_side: usize, out: Rows<'_>) {
        for y in 0..self.height {
            let first = (self.window_y + y) * out.width + self.window_x;
            let target = Stride { first: first * out.step + out.position, step: out.step };
            match block {
                Block::Samples { bytes, stride } => {
                    let first = (self.block_y + y) * *stride as usize + self.block_x;
                    let pixels = Pixels { sample, bytes, first, count: self.width, samples: side_by_side };
                    pixels.widen(bands, target, out.samples);
                }
                Block::Constant(value) => {
                    let rows = out.samples.get_mut(target.first..).unwrap_or_default();
                    let pixels = rows.chunks_mut(target.step.max(1)).take(self.width);
                    pixels.for_each(|pixel| pixel.iter_mut().take(bands.len()).for_each(|at| *at = *value));
                }
            }
        }
    }
}

/// The answer, `width` pixels per row and `step` samples per pixel; what comes goes to `position` of each and behind it.
struct Rows<'a> {
    samples: &'a mut [f64],
    width: usize,
    step: usize,
    position: usize,
}

impl<S: BlockSource> Raster for BlockRaster<S> {
    fn info(&self) -> &RasterInfo {
        self.source.info()
    }

    fn read(&self, window: Window, bands: &[u32], samples: &mut Vec<f64>) -> Result<()> {
        let info = self.source.info();
        prepare(info, window, bands, samples)?;
        let planar = self.source.planar();
        let (last_x, last_y) = (window.x + (window.width - 1), window.y + (window.height - 1));

        for row in window.y / info.block.height..=last_y / info.block.height {
            for column in window.x / info.block.width..=last_x / info.block.width {
                let overlap = Overlap::new(window, info.block, column, row);
                let (width, step) = (window.width as usize, bands.len());
                if !planar {
                    let block = self.block(BlockIndex { column, row, plane: 0 })?;
                    let out = Rows { samples, width, step, position: 0 };
                    overlap.copy(&block, info.sample, bands, info.bands as usize, out);
                    continue;
                }

                for (position, &plane) in bands.iter().enumerate() {
                    let block = self.block(BlockIndex { column, row, plane })?;
                    let out = Rows { samples, width, step, position };
                    overlap.copy(&block, info.sample, &[0], 1, out);
                }
            }
        }

        Ok(())
    }
}
