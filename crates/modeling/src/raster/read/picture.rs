//! PNG and JPEG pictures, georeferenced by a world file and a `.prj` beside them.
//!
//! Both can only be decoded as a whole, so a picture is one block of the cache, and one that exceeds the cache is refused.
//! PNG samples come as stored: 16-bit heights stay 16-bit, and the transparent grey of a `tRNS` chunk is the
//! nodata value, as in GDAL; a transparent colour becomes alpha. JPEG is converted to RGB by its decoder.

use crate::raster::blocks::{Block, BlockIndex, BlockRaster, BlockSource, TO_DEFLATED_TILES};
use crate::raster::file::InputFile;
use crate::raster::{Band, OpenOptions, Raster, RasterInfo, Role, SampleType, side_files};
use hedgehop_assets::picture::{self, Fault, Format, Header, Transparency};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

struct Picture {
    file: InputFile,
    info: RasterInfo,
}

/// Opens a PNG or JPEG picture.
pub(in crate::raster) fn open(file: InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    if file.length() > options.cache_bytes {
        let what = format!("holds {} MiB, more than this file's share of --memory", file.length() >> 20);
        return Err(Error::unsupported(
            file.path(),
            what,
            format!("raise --memory, or convert it: {TO_DEFLATED_TILES}"),
        ));
    }

    let bytes = file.bytes_at(0, file.length())?;
    let header = picture::header(&bytes, Transparency::Value).map_err(|fault| wrong(&file, fault))?;
    if header.is_palette {
        let remedy = "convert it: gdal_translate -expand rgb IN out.tif";
        return Err(Error::unsupported(file.path(), "has a colour palette", remedy));
    }
    if header.stored_bits < 8 {
        let what = format!("has samples of {} bits", header.stored_bits);
        return Err(Error::unsupported(file.path(), what, "convert it: gdal_translate -ot Byte IN out.tif"));
    }

    let format = if header.format == Format::Png { "PNG" } else { "JPEG" };
    let mut info = RasterInfo {
        width: header.width,
        height: header.height,
        bands: header.bands,
        sample: if header.is_wide { SampleType::U16 } else { SampleType::U8 },
        described: described(&header),
        nodata: header.transparent_grey.map(f64::from),
        block: Size { width: header.width, height: header.height },
        ..RasterInfo::blank(file.path(), format)
    };

    side_files::complete(&mut info)?;
    Ok(Box::new(BlockRaster::new(Picture { file, info }, options.cache_bytes, TO_DEFLATED_TILES)?))
}

impl BlockSource for Picture {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn decode(&self, _: BlockIndex) -> Result<Block> {
        let bytes = self.file.bytes_at(0, self.file.length())?;
        let changed = || Error::invalid(self.file.path(), "has changed while it was read");
        let header = picture::header(&bytes, Transparency::Value).map_err(|_| changed())?;
        if (header.width, header.height, header.bands) != (self.info.width, self.info.height, self.info.bands)
        {
            return Err(changed());
        }
        let bytes = picture::decode(&bytes, Transparency::Value).map_err(|fault| wrong(&self.file, fault))?;
        Ok(Block::Samples { bytes, stride: self.info.width })
    }
}

fn described(header: &Header) -> Vec<Band> {
    let colours = if header.bands < 3 { [Role::Unknown; 3] } else { [Role::Red, Role::Green, Role::Blue] };
    let role = |band: u32| match colours.get(band as usize) {
        _ if header.has_alpha && band + 1 == header.bands => Role::Alpha,
        role => role.copied().unwrap_or_default(),
    };
    (0..header.bands).map(|band| Band { role: role(band), ..Band::default() }).collect()
}

fn wrong(file: &InputFile, fault: Fault) -> Error {
    match fault {
        Fault::Damaged(_) => Error::invalid(file.path(), format!("cannot be decoded: {fault}")),
        Fault::Unsupported(what) => {
            let remedy = "convert it: gdal_translate -co PHOTOMETRIC=RGB IN out.tif";
            Error::unsupported(file.path(), format!("cannot be decoded: {what}"), remedy)
        }
    }
}
