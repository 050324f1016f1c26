//! GDAL's internal mask: a later directory of the same size, marked as a transparency mask (TIFF 6.0, tag 254, bit 2), of 1 or 8 bits; 0
//! means transparent. It becomes an alpha band behind the others, so that nobody has to know of it.

use super::super::blocks::BlockRaster;
use super::super::file::InputFile;
use super::super::{OpenOptions, Raster, RasterInfo, SampleType, Window};
use super::chunk::ChunkedTiff;
use super::ifd::Directory;
use super::{AS_TILES, Layout, Meaning, tag};
use crate::error::Result;

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

fn open(file: &InputFile, directory: &Directory<'_>, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let layout = Layout::parse(file, directory, options, Meaning::Mask)?;
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
    Ok(Box::new(BlockRaster::new(mask, options.cache_bytes / CACHE_SHARE, AS_TILES)?))
}

/// A raster with its mask as a last band; an alpha band that it has already gives way to the mask.
pub(super) struct Masked {
    raster: Box<dyn Raster>,
    mask: Box<dyn Raster>,
    info: RasterInfo,
}

impl Masked {
    pub fn new(raster: Box<dyn Raster>, mask: Box<dyn Raster>) -> Self {
        let own = raster.info();
        let info = RasterInfo { bands: own.bands + 1, alpha_band: Some(own.bands), ..own.clone() };
        Self { raster, mask, info }
    }
}

impl Raster for Masked {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn read(&self, window: Window, bands: &[u32], samples: &mut Vec<f64>) -> Result<()> {
        let own = self.raster.info().bands;
        // The mask's place is read from the first band, then overwritten.
        let stored: Vec<u32> = bands.iter().map(|band| if *band == own { 0 } else { *band }).collect();
        self.raster.read(window, &stored, samples)?;
        let Some(place) = bands.iter().position(|band| *band == own) else { return Ok(()) };
        let mut mask = Vec::new();
        self.mask.read(window, &[0], &mut mask)?;
        // Masks of 8 bits may use 0 and 1.
        let opaque = if self.info.sample == SampleType::I8 { 127.0 } else { 255.0 };
        for (pixel, mask) in samples.chunks_exact_mut(bands.len()).zip(mask) {
            pixel[place] = if mask == 0.0 { 0.0 } else { opaque };
        }
        Ok(())
    }
}
