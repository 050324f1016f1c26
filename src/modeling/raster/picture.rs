//! PNG and JPEG pictures, georeferenced by a world file and a `.prj` beside them.
//!
//! Both can only be decoded as a whole, so a picture is one block of the cache, and one that exceeds the cache is refused.
//! PNG samples come as stored: 16-bit heights stay 16-bit, and the transparent grey of a `tRNS` chunk is the
//! nodata value, as in GDAL. JPEG is converted to RGB by its decoder.

use std::io::{BufReader, Cursor};

use image::ImageDecoder;
use image::codecs::jpeg::JpegDecoder;

use super::blocks::{Block, BlockIndex, BlockRaster, BlockSource, block_bytes};
use super::file::InputFile;
use super::sample::ByteOrder;
use super::{OpenOptions, Raster, RasterInfo, SampleType, side};
use crate::error::{Error, Result};

const REMEDY: &str = "gdal_translate -co TILED=YES -co COMPRESS=DEFLATE IN out.tif";

struct Picture {
    file: InputFile,
    info: RasterInfo,
    decode: fn(&Picture) -> std::result::Result<Vec<u8>, String>,
}

impl BlockSource for Picture {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn decode(&self, _: BlockIndex) -> Result<Block> {
        let bytes = (self.decode)(self).map_err(|what| {
            Error::invalid(self.file.path(), format!("cannot be decoded ({what}); it is damaged"))
        })?;
        Ok(Block::Samples { bytes, stride: self.info.width })
    }
}

impl Picture {
    fn finish(mut self, options: &OpenOptions) -> Result<Box<dyn Raster>> {
        side::complete(&mut self.info)?;
        self.info.block = (self.info.width, self.info.height);
        Ok(Box::new(BlockRaster::new(self, options.cache_bytes, REMEDY)?))
    }

    /// Bytes of the decoded picture; `BlockRaster` has refused sizes beyond the cache.
    fn size(&self) -> usize {
        block_bytes(self.info.block, self.info.bands, self.info.sample).map_or(0, |bytes| bytes as usize)
    }
}

/// Opens a PNG picture.
pub(super) fn open_png(file: InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let reader = png_reader(&file, options.cache_bytes).map_err(|e| {
        Error::invalid(file.path(), format!("has a header that cannot be read ({e}); it is damaged"))
    })?;
    let header = reader.info();
    let (bands, alpha_band) = match header.color_type {
        png::ColorType::Grayscale => (1, None),
        png::ColorType::GrayscaleAlpha => (2, Some(1)),
        png::ColorType::Rgb => (3, None),
        png::ColorType::Rgba => (4, Some(3)),
        png::ColorType::Indexed => {
            let remedy = "convert it: gdal_translate -expand rgb IN out.tif";
            return Err(Error::unsupported(file.path(), "has a colour palette", remedy));
        }
    };
    let sample = match header.bit_depth {
        png::BitDepth::Eight => SampleType::U8,
        png::BitDepth::Sixteen => SampleType::U16,
        depth => {
            let what = format!("has samples of {} bits", depth as u8);
            return Err(Error::unsupported(
                file.path(),
                what,
                "convert it: gdal_translate -ot Byte IN out.tif",
            ));
        }
    };
    // `tRNS` holds one 16-bit value per band, big-endian, whatever the depth; only a single grey is a nodata value.
    let transparent = header.trns.as_deref().filter(|_| bands == 1).and_then(|trns| trns.get(..2));
    let info = RasterInfo {
        width: header.width,
        height: header.height,
        bands,
        sample,
        alpha_band,
        nodata: transparent.map(|value| ByteOrder::Big.unsigned(value) as f64),
        ..RasterInfo::blank(file.path(), "PNG")
    };
    drop(reader);
    Picture { file, info, decode: decode_png }.finish(options)
}

type PngReader = png::Reader<BufReader<std::fs::File>>;

fn png_reader(file: &InputFile, limit: u64) -> std::result::Result<PngReader, String> {
    let source = BufReader::new(file.reopen().map_err(|e| e.to_string())?);
    let limits = png::Limits { bytes: usize::try_from(limit.saturating_add(1 << 20)).unwrap_or(usize::MAX) };
    let mut decoder = png::Decoder::new_with_limits(source, limits);
    decoder.set_transformations(png::Transformations::IDENTITY);
    decoder.read_info().map_err(|e| e.to_string())
}

fn decode_png(picture: &Picture) -> std::result::Result<Vec<u8>, String> {
    let size = picture.size();
    let mut reader = png_reader(&picture.file, size as u64)?;
    if reader.output_buffer_size() != Some(size) {
        return Err("its size has changed".to_owned());
    }
    let mut bytes = vec![0; size];
    reader.next_frame(&mut bytes).map_err(|e| e.to_string())?;
    ByteOrder::Big.make_native(&mut bytes, picture.info.sample.bytes());
    Ok(bytes)
}

/// Opens a JPEG picture.
pub(super) fn open_jpeg(file: InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    if file.length() > options.cache_bytes {
        let what = format!("holds {} MiB, more than this file's share of --memory", file.length() >> 20);
        return Err(Error::unsupported(
            file.path(),
            what,
            format!("raise --memory, or convert it: {REMEDY}"),
        ));
    }
    let decoder = jpeg_decoder(&file).map_err(|e| {
        Error::invalid(file.path(), format!("has a header that cannot be read ({e}); it is damaged"))
    })?;
    let (width, height) = decoder.dimensions();
    let bands = match decoder.color_type() {
        image::ColorType::L8 => 1,
        image::ColorType::Rgb8 => 3,
        other => {
            let remedy = "convert it: gdal_translate -co PHOTOMETRIC=RGB IN out.tif";
            return Err(Error::unsupported(file.path(), format!("has pixels of type {other:?}"), remedy));
        }
    };
    let info = RasterInfo { width, height, bands, ..RasterInfo::blank(file.path(), "JPEG") };
    drop(decoder);
    Picture { file, info, decode: decode_jpeg }.finish(options)
}

fn jpeg_decoder(file: &InputFile) -> std::result::Result<JpegDecoder<Cursor<Vec<u8>>>, String> {
    let bytes = file.bytes_at(0, file.length()).map_err(|e| e.to_string())?;
    JpegDecoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())
}

fn decode_jpeg(picture: &Picture) -> std::result::Result<Vec<u8>, String> {
    let decoder = jpeg_decoder(&picture.file)?;
    if decoder.total_bytes() != picture.size() as u64 {
        return Err("its size has changed".to_owned());
    }
    let mut bytes = vec![0; picture.size()];
    decoder.read_image(&mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes)
}
