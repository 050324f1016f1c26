//! TIFFs that are masks: a later directory of the same size, marked as a transparency mask (TIFF 6.0, tag 254, bit 2), or the
//! first one of a file beside a raster; of 1 or 8 bits.

use super::chunk::ChunkedTiff;
use super::ifd::Directory;
use super::layout::{DirectoryMeaning, TiffLayout};
use super::tags::tag;
use crate::raster::blocks::{BlockRaster, TO_DEFLATED_TILES};
use crate::raster::file::InputFile;
use crate::raster::{OpenOptions, Raster, RasterInfo};
use hedgehop_base::error::{Error, Result};

/// Directories looked at; overviews halve the size, so no sound file has more.
const MOST_DIRECTORIES: usize = 64;
const REDUCED: u32 = 1;
const MASK: u32 = 4;
/// The mask's share of the cache, one part in so many.
const CACHE_SHARE: u64 = 8;

/// The mask of the first directory's image, if the file has one.
pub(super) fn find(
    file: &InputFile,
    first: &Directory<'_>,
    options: &OpenOptions,
) -> Result<Option<Box<dyn Raster>>> {
    let size = |directory: &Directory<'_>| {
        Ok((directory.unsigned(tag::IMAGE_WIDTH)?, directory.unsigned(tag::IMAGE_LENGTH)?))
    };
    let mut next = first.next()?;
    for _ in 0..MOST_DIRECTORIES {
        let Some(directory) = next else { return Ok(None) };
        let kind = directory.unsigned(tag::NEW_SUBFILE_TYPE)?.unwrap_or(0);
        if kind & MASK != 0 && kind & REDUCED == 0 && size(&directory)? == size(first)? {
            return open(file, &directory, options).map(Some);
        }
        next = directory.next()?;
    }
    Ok(None)
}

/// Opens a file that is a mask.
pub(in crate::raster) fn open_file(file: &InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    if !matches!(file.head(4)?[..], [b'I', b'I', 42 | 43, 0] | [b'M', b'M', 0, 42 | 43]) {
        return Err(Error::invalid(file.path(), "is no TIFF"));
    }
    open(file, &Directory::first(file)?, options)
}

fn open(file: &InputFile, directory: &Directory<'_>, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let layout = TiffLayout::parse(file, directory, options, DirectoryMeaning::Mask)?;
    let info = RasterInfo {
        width: layout.width,
        height: layout.height,
        bands: layout.bands,
        sample: layout.sample,
        block: layout.chunk,
        ..RasterInfo::blank(file.path(), "GeoTIFF mask")
    };
    let file = InputFile::open(file.path())?;
    let mask = ChunkedTiff { file, info, layout, order: directory.order };
    Ok(Box::new(BlockRaster::new(mask, options.cache_bytes / CACHE_SHARE, TO_DEFLATED_TILES)?))
}
