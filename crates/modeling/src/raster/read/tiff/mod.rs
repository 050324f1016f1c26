//! GeoTIFF and COG (Adobe, *TIFF 6.0*, 1992; OGC 19-008r4 *GeoTIFF 1.1*; GDAL's tags 42112 and 42113).
//!
//! ```text
//! first directory → layout (size, bands, sample type, chunks) or a refusal with the command that converts
//!                 → place (scale and tie point, or matrix; half a pixel back if pixels are points), CRS, nodata, scale
//! uncompressed strips  → rows are read from where they lie (raster/raw.rs), so that strips of any size are bounded
//! anything else        → chunk by chunk through the cache (chunk.rs)
//! ```
//! Of the later directories only GDAL's transparency mask is used (mask.rs); overviews are not. Samples come as stored: MinIsWhite is reported, not inverted. What would
//! give wrong colours without a word (JPEG's YCbCr, palettes, CMYK, Lab) is refused.

mod chunk;
mod codec;
mod ifd;
mod layout;
mod mask;
mod metadata;
mod table;
mod tags;

use crate::raster::blocks::{BlockRaster, TO_DEFLATED_TILES};
use crate::raster::file::InputFile;
use crate::raster::masked_raster::MaskedRaster;
use crate::raster::raw::RawRaster;
use crate::raster::{OpenOptions, Raster, RasterInfo, side_files};
use chunk::ChunkedTiff;
use hedgehop_base::Size;
use hedgehop_base::error::Result;
use ifd::Directory;
use layout::{DirectoryMeaning, TiffLayout};
pub(in crate::raster) use mask::open_file as open_mask;

/// Opens a file.
pub(in crate::raster) fn open(file: InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let directory = Directory::first(&file)?;
    let layout = TiffLayout::parse(&file, &directory, options, DirectoryMeaning::Picture)?;
    let mask = mask::find(&file, &directory, options)?;

    let mut info = RasterInfo {
        width: layout.width,
        height: layout.height,
        bands: layout.bands,
        sample: layout.sample,
        described: layout.described(),
        white_is_zero: layout.white_is_zero,
        block: layout.chunk,
        ..RasterInfo::blank(file.path(), "GeoTIFF")
    };

    metadata::fill(&mut info, &directory)?;
    side_files::complete(&mut info)?;
    info.is_premultiplied = info.alpha_band.is_some_and(|band| layout.is_associated(band));
    let order = directory.order;
    drop(directory);

    let raster: Box<dyn Raster> = match layout.placement(order) {
        Some(placement) => {
            info.block = Size { width: info.width, height: info.block.height.min(64) };
            Box::new(RawRaster::new(file, info, placement)?)
        }
        None => Box::new(BlockRaster::new(
            ChunkedTiff { file, info, layout, order },
            options.cache_bytes,
            TO_DEFLATED_TILES,
        )?),
    };

    Ok(match mask {
        Some(mask) => Box::new(MaskedRaster::new(raster, mask)),
        None => raster,
    })
}

#[cfg(test)]
mod tests;
