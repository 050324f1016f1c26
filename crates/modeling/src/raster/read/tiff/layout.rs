//! Layout of a TIFF's pixels.

use super::ifd::Directory;
use super::tags::{compression, tag};
use crate::raster::blocks::TO_DEFLATED_TILES;
use crate::raster::file::InputFile;
use crate::raster::raw::{RowStarts, SamplePlacement};
use crate::raster::sample::ByteOrder;
use crate::raster::{Band, OpenOptions, Role, SampleType};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

const AS_DEFLATE: &str = "convert it: gdal_translate -co COMPRESS=DEFLATE IN out.tif";

/// Meaning of a directory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DirectoryMeaning {
    /// Heights or colours.
    Picture,
    /// Transparency, of 1 or 8 bits.
    Mask,
}

/// Layout of the pixels.
#[derive(Debug)]
pub(super) struct TiffLayout {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) bands: u32,
    pub(super) sample: SampleType,
    /// The first bands are red, green and blue.
    is_rgb: bool,
    /// Whether its first band has a colour table, whatever kind of colours it states: GDAL writes such.
    is_palette: bool,
    /// Meaning of the last bands, as TIFF's tag 338 says.
    extra: Vec<u64>,
    pub(super) white_is_zero: bool,
    /// Samples are single bits, which become 0 and 255.
    pub(super) packed: bool,
    /// Each band in chunks of its own.
    pub(super) planar: bool,
    pub(super) tiled: bool,
    /// Size of a chunk; strips end at the last row of the image, tiles are always whole.
    pub(super) chunk: Size,
    pub(super) offsets: Vec<u64>,
    /// Empty for uncompressed strips of a file that does not state them.
    pub(super) byte_counts: Vec<u64>,
    pub(super) compression: u32,
    pub(super) predictor: u32,
}

impl TiffLayout {
    pub(super) fn parse(
        file: &InputFile,
        directory: &Directory<'_>,
        options: &OpenOptions,
        meaning: DirectoryMeaning,
    ) -> Result<Self> {
        let size = |tag| match directory.unsigned(tag)? {
            Some(size) if size > 0 && size <= i32::MAX as u32 => Ok(size),
            _ => Err(directory.wrong(tag, "states no sound size")),
        };
        let (width, height) = (size(tag::IMAGE_WIDTH)?, size(tag::IMAGE_LENGTH)?);
        let bands = directory.unsigned(tag::SAMPLES_PER_PIXEL)?.unwrap_or(1);
        if bands == 0 || bands > 65_535 {
            return Err(directory.wrong(tag::SAMPLES_PER_PIXEL, "states no sound number of bands"));
        }

        let compression = directory.unsigned(tag::COMPRESSION)?.unwrap_or(compression::NONE);
        refuse_compression(file, compression)?;
        let photometric = directory.unsigned(tag::PHOTOMETRIC)?.unwrap_or(1);
        let is_palette_of_classes = options.classes && photometric == PALETTE;
        if meaning == DirectoryMeaning::Picture && !is_palette_of_classes {
            refuse_photometric(file, photometric)?;
        }

        let packed =
            meaning == DirectoryMeaning::Mask && directory.unsigned(tag::BITS_PER_SAMPLE)?.unwrap_or(1) == 1;
        if directory.unsigned(tag::FILL_ORDER)?.unwrap_or(1) != 1 {
            return Err(Error::unsupported(file.path(), "has its bits in reverse order", AS_DEFLATE));
        }

        let tiled = directory.has(tag::TILE_OFFSETS);
        let chunk = if tiled {
            Size { width: size(tag::TILE_WIDTH)?, height: size(tag::TILE_LENGTH)? }
        } else {
            let rows = directory.unsigned(tag::ROWS_PER_STRIP)?.unwrap_or(height).min(height);
            if rows == 0 {
                return Err(directory.wrong(tag::ROWS_PER_STRIP, "states strips without rows"));
            }
            Size { width, height: rows }
        };

        let mut layout = Self {
            width,
            height,
            bands,
            sample: if packed { SampleType::U8 } else { sample_type(file, directory)? },
            is_rgb: photometric == RGB,
            is_palette: directory.has(tag::COLOR_MAP),
            extra: extra(directory, bands)?,
            white_is_zero: photometric == 0,
            packed,
            planar: bands > 1 && directory.unsigned(tag::PLANAR_CONFIGURATION)?.unwrap_or(1) == 2,
            tiled,
            chunk,
            offsets: Vec::new(),
            byte_counts: Vec::new(),
            compression,
            predictor: predictor(directory, compression)?,
        };

        layout.read_table(file, directory, options)?;
        layout.check_table(file)?;
        Ok(layout)
    }

    /// Describes each band; nothing is said of bands where only greys are told, of which satellites have many.
    pub(super) fn described(&self) -> Vec<Band> {
        let first = self.bands as usize - self.extra.len();
        let role = |band: usize| match (band.checked_sub(first).map(|extra| self.extra[extra]), band) {
            (Some(ASSOCIATED | UNASSOCIATED), _) => Role::Alpha,
            (None, 0) if self.is_palette => Role::Palette,
            (None, 0) if self.is_rgb => Role::Red,
            (None, 1) if self.is_rgb => Role::Green,
            (None, 2) if self.is_rgb => Role::Blue,
            _ => Role::Unknown,
        };
        (0..self.bands as usize).map(|band| Band { role: role(band), ..Band::default() }).collect()
    }

    /// Whether the other bands are multiplied by this one.
    pub(super) fn is_associated(&self, band: u32) -> bool {
        let extra = (band as usize + self.extra.len()).checked_sub(self.bands as usize);
        extra.and_then(|extra| self.extra.get(extra)) == Some(&ASSOCIATED)
    }

    /// Chunks across, chunks down.
    pub(super) fn grid(&self) -> (u32, u32) {
        (self.width.div_ceil(self.chunk.width), self.height.div_ceil(self.chunk.height))
    }

    /// Reads where chunks lie; the table of a huge file must fit into the cache's budget too.
    fn read_table(
        &mut self,
        file: &InputFile,
        directory: &Directory<'_>,
        options: &OpenOptions,
    ) -> Result<()> {
        let (across, down) = self.grid();
        let planes = if self.planar { u64::from(self.bands) } else { 1 };
        let count = u64::from(across) * u64::from(down);

        let Some(count) = count.checked_mul(planes).filter(|n| n.saturating_mul(16) <= options.cache_bytes)
        else {
            let what = format!(
                "has chunks of only {} × {} pixels, too many for --memory",
                self.chunk.width, self.chunk.height
            );
            return Err(Error::unsupported(
                file.path(),
                what,
                format!("raise --memory, or convert it: {TO_DEFLATED_TILES}"),
            ));
        };

        let (offsets, byte_counts) = if self.tiled {
            (tag::TILE_OFFSETS, tag::TILE_BYTE_COUNTS)
        } else {
            (tag::STRIP_OFFSETS, tag::STRIP_BYTE_COUNTS)
        };

        let table = |tag| {
            if directory.count(tag) != count {
                let what = format!("lists {} chunks where {count} are needed", directory.count(tag));
                return Err(directory.wrong(tag, what));
            }
            Ok(directory.unsigneds(tag, count)?.unwrap_or_default())
        };

        self.offsets = table(offsets)?;
        if directory.has(byte_counts) || self.tiled || self.compression != compression::NONE {
            self.byte_counts = table(byte_counts)?;
        }

        Ok(())
    }

    /// Returns where rows lie, if they lie in the file as they are.
    pub(super) fn placement(&self, order: ByteOrder) -> Option<SamplePlacement> {
        let absent = self.offsets.contains(&0) || self.byte_counts.contains(&0);
        let separate = self.planar && self.offsets.len() > 1;
        if self.packed || self.tiled || self.compression != compression::NONE || absent || separate {
            return None;
        }
        let size = self.sample.bytes() as u64;
        let pixel_bytes = size * u64::from(self.bands);
        Some(SamplePlacement {
            rows: RowStarts::Strips {
                offsets: self.offsets.clone(),
                rows: self.chunk.height,
                row_bytes: pixel_bytes.checked_mul(u64::from(self.width))?,
            },
            pixel_bytes,
            band_bytes: size,
            order,
        })
    }
}

fn predictor(directory: &Directory<'_>, compression: u32) -> Result<u32> {
    // Only these codecs know predictors; with others the tag means nothing.
    let used = [compression::LZW, compression::DEFLATE, compression::OLD_DEFLATE, compression::ZSTD];
    if !used.contains(&compression) {
        return Ok(1);
    }
    match directory.unsigned(tag::PREDICTOR)?.unwrap_or(1) {
        predictor @ 1..=3 => Ok(predictor),
        other => {
            Err(directory.wrong(tag::PREDICTOR, format!("names predictor {other}, which does not exist")))
        }
    }
}

fn sample_type(file: &InputFile, directory: &Directory<'_>) -> Result<SampleType> {
    let same = |tag, default| {
        let values = directory.unsigneds(tag, 65_535)?.unwrap_or_default();
        let first = values.first().copied().unwrap_or(default);
        if values.iter().any(|value| *value != first) {
            let what = "has bands of different sample types";
            return Err(Error::unsupported(file.path(), what, "convert it: gdal_translate -b 1 IN out.tif"));
        }
        Ok(first)
    };

    match (same(tag::SAMPLE_FORMAT, 1)?, same(tag::BITS_PER_SAMPLE, 1)?) {
        (1 | 4, 8) => Ok(SampleType::U8),
        (1 | 4, 16) => Ok(SampleType::U16),
        (1 | 4, 32) => Ok(SampleType::U32),
        (2, 8) => Ok(SampleType::I8),
        (2, 16) => Ok(SampleType::I16),
        (2, 32) => Ok(SampleType::I32),
        (3, 32) => Ok(SampleType::F32),
        (3, 64) => Ok(SampleType::F64),
        (format, bits) => {
            let kind = match format {
                1 | 4 => "unsigned integers",
                2 => "signed integers",
                3 => "floating-point numbers",
                _ => "complex numbers",
            };
            let remedy = if bits < 8 { "-co NBITS=8 -ot Byte" } else { "-ot Float64" };
            let what = format!("has samples that are {kind} of {bits} bits");
            Err(Error::unsupported(
                file.path(),
                what,
                format!("convert it: gdal_translate {remedy} IN out.tif"),
            ))
        }
    }
}

/// Meanings of the last bands.
fn extra(directory: &Directory<'_>, bands: u32) -> Result<Vec<u64>> {
    let extra = directory.unsigneds(tag::EXTRA_SAMPLES, 65_535)?.unwrap_or_default();
    if extra.len() > bands as usize {
        return Err(directory.wrong(tag::EXTRA_SAMPLES, "lists more bands than there are"));
    }
    Ok(extra)
}

fn refuse_compression(file: &InputFile, code: u32) -> Result<()> {
    use super::tags::compression::{DEFLATE, LZW, NONE, OLD_DEFLATE, PACK_BITS, ZSTD};

    let name = match code {
        NONE | LZW | DEFLATE | OLD_DEFLATE | PACK_BITS | ZSTD => return Ok(()),
        2..=4 => "CCITT fax",
        6 | 7 => "JPEG",
        34676 | 34677 => "SGI LogLuv",
        34712 => "JPEG 2000",
        34887 => "LERC",
        34925 => "LZMA",
        50001 => "WebP",
        50002 | 52546 => "JPEG XL",
        _ => {
            return Err(Error::unsupported(
                file.path(),
                format!("uses the TIFF compression {code}"),
                AS_DEFLATE,
            ));
        }
    };

    Err(Error::unsupported(file.path(), format!("is compressed with {name}"), AS_DEFLATE))
}

/// Samples are red, green and blue.
const RGB: u32 = 2;

/// Samples are places in a palette.
const PALETTE: u32 = 3;

/// Extra samples that are alpha: multiplied into the colours, or not.
const ASSOCIATED: u64 = 1;
const UNASSOCIATED: u64 = 2;

fn refuse_photometric(file: &InputFile, code: u32) -> Result<()> {
    let (what, remedy) = match code {
        0..=2 => return Ok(()),
        PALETTE => ("has a colour palette", "convert it: gdal_translate -expand rgb IN out.tif"),
        4 => ("is a transparency mask", "name the raster that it belongs to"),
        5 => ("has CMYK colours", "convert it: gdal_translate -co PHOTOMETRIC=RGB IN out.tif"),
        6 => ("has YCbCr colours", AS_DEFLATE),
        8..=10 => ("has L*a*b* colours", AS_DEFLATE),
        _ => ("has an unknown kind of colours (TIFF tag 262)", AS_DEFLATE),
    };
    Err(Error::unsupported(file.path(), what, remedy))
}
