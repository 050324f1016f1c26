//! Writing a tiled, deflate-compressed GeoTIFF.
//!
//! The `tiff` crate's image encoder writes strips and no floating-point predictor; its directory encoder is
//! used here with tiles cut, predicted (TIFF 6.0 section 14; Technical Note 3) and compressed by this file.

use std::error::Error;
use std::io::{Cursor, Write};

use flate2::{Compression, write::ZlibEncoder};
use glam::{DVec2, dvec2};
use tiff::encoder::TiffEncoder;
use tiff::tags::Tag;

use crate::grid::{SIDE, SIZE, SPACING};

/// Side of a tile, pixels; divides the raster.
const TILE: usize = 256;
/// Easting and northing of the area's south-west corner, UTM zone 32 north.
pub const ORIGIN: DVec2 = dvec2(612_000.0, 5_241_000.0);

/// Samples of one kind, pixel-interleaved, rows from the north.
pub enum Samples<'a> {
    /// One height a pixel, metres.
    Heights(&'a [f32]),
    /// sRGB.
    Colours(&'a [[u8; 3]]),
    /// Numbers of land cover.
    Classes(&'a [u8]),
}

impl Samples<'_> {
    fn bands(&self) -> usize {
        match self {
            Self::Heights(_) | Self::Classes(_) => 1,
            Self::Colours(_) => 3,
        }
    }

    /// Bytes of one tile, predicted.
    fn tile(&self, left: usize, top: usize) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(TILE * TILE * 4);
        for row in top..top + TILE {
            let range = row * SIZE + left..row * SIZE + left + TILE;
            match self {
                Self::Heights(heights) => predict_heights(&heights[range], &mut bytes),
                Self::Colours(colours) => bytes.extend_from_slice(colours[range].as_flattened()),
                Self::Classes(classes) => bytes.extend_from_slice(&classes[range]),
            }
        }
        bytes
    }
}

/// Predictor 3: bytes of a row by significance, highest first, then each less the one before it.
fn predict_heights(row: &[f32], bytes: &mut Vec<u8>) {
    let start = bytes.len();
    for significance in 0..4 {
        bytes.extend(row.iter().map(|height| height.to_be_bytes()[significance]));
    }
    for k in (start + 1..bytes.len()).rev() {
        bytes[k] = bytes[k].wrapping_sub(bytes[k - 1]);
    }
}

/// The file's bytes.
pub fn encode(samples: &Samples<'_>) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file)?;
    let mut directory = encoder.image_directory()?;
    let (mut offsets, mut counts) = (Vec::new(), Vec::new());

    for top in (0..SIZE).step_by(TILE) {
        for left in (0..SIZE).step_by(TILE) {
            let mut deflate = ZlibEncoder::new(Vec::new(), Compression::best());
            deflate.write_all(&samples.tile(left, top))?;
            let tile = deflate.finish()?;
            counts.push(u32::try_from(tile.len())?);
            offsets.push(u32::try_from(directory.write_data(tile.as_slice())?)?);
        }
    }

    let bands = u16::try_from(samples.bands())?;
    let (bits, format, photometric, predictor) = match samples {
        Samples::Heights(_) => (32u16, 3u16, 1u16, 3u16),
        Samples::Colours(_) => (8, 1, 2, 1),
        Samples::Classes(_) => (8, 1, 1, 1),
    };
    let side = u32::try_from(SIZE)?;
    directory.write_tag(Tag::ImageWidth, side)?;
    directory.write_tag(Tag::ImageLength, side)?;
    directory.write_tag(Tag::BitsPerSample, vec![bits; samples.bands()].as_slice())?;
    directory.write_tag(Tag::Compression, 8u16)?;
    directory.write_tag(Tag::PhotometricInterpretation, photometric)?;
    directory.write_tag(Tag::SamplesPerPixel, bands)?;
    directory.write_tag(Tag::PlanarConfiguration, 1u16)?;
    directory.write_tag(Tag::Predictor, predictor)?;
    directory.write_tag(Tag::TileWidth, u32::try_from(TILE)?)?;
    directory.write_tag(Tag::TileLength, u32::try_from(TILE)?)?;
    directory.write_tag(Tag::TileOffsets, offsets.as_slice())?;
    directory.write_tag(Tag::TileByteCounts, counts.as_slice())?;
    directory.write_tag(Tag::SampleFormat, vec![format; samples.bands()].as_slice())?;
    directory.write_tag(Tag::ModelPixelScaleTag, [SPACING, SPACING, 0.0].as_slice())?;
    directory.write_tag(Tag::ModelTiepointTag, [0.0, 0.0, 0.0, ORIGIN.x, ORIGIN.y + SIDE, 0.0].as_slice())?;

    match samples {
        Samples::Heights(_) => {
            directory.write_tag(Tag::GeoKeyDirectoryTag, GEO_KEYS_HEIGHTS.as_slice())?;
            directory.write_tag(Tag::GdalNodata, "-9999")?;
        }
        Samples::Colours(_) | Samples::Classes(_) => {
            directory.write_tag(Tag::GeoKeyDirectoryTag, GEO_KEYS.as_slice())?
        }
    }

    directory.finish()?;
    Ok(file.into_inner())
}

/// Key, place (0: here), count, value: version 1.1.0, then model type projected, pixel is area, EPSG:32632, metres.
pub const GEO_KEYS: [u16; 20] = [
    1, 1, 0, 4, //
    1024, 0, 1, 1, //
    1025, 0, 1, 1, //
    3072, 0, 1, 32632, //
    3076, 0, 1, 9001,
];

/// The same, and heights above the geoid (EPSG:5773, EGM96) in metres.
const GEO_KEYS_HEIGHTS: [u16; 28] = [
    1, 1, 0, 6, //
    1024, 0, 1, 1, //
    1025, 0, 1, 1, //
    3072, 0, 1, 32632, //
    3076, 0, 1, 9001, //
    4096, 0, 1, 5773, //
    4099, 0, 1, 9001,
];
