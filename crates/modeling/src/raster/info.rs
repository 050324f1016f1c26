//! Options of opening a raster, and its properties.

use std::path::{Path, PathBuf};

use hedgehop_base::Size;
use hedgehop_geo::{Crs, LocalSystem, VerticalCrs};

/// Options of opening a raster.
#[derive(Debug, Clone)]
pub struct OpenOptions {
    /// Budget of this raster's decoded blocks, bytes. Besides these, each reading thread holds at most one block.
    pub cache_bytes: u64,
    /// Size of a headerless file of little-endian 32-bit floats; `None`: it is square.
    pub raw: Option<RawLayout>,
    /// Samples are classes: those of a palette are taken as they are, without its colours.
    pub classes: bool,
}

impl Default for OpenOptions {
    fn default() -> Self {
        Self { cache_bytes: 64 << 20, raw: None, classes: false }
    }
}

/// Size of a headerless raster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawLayout {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// `x = c[0] + c[1]·column + c[2]·row`, `y = c[3] + c[4]·column + c[5]·row` of a pixel's north-west
/// corner, columns and rows counted from the north-west corner of the raster (GDAL's convention; pixel-is-point
/// files are already shifted by half a pixel).
pub type GeoTransform = [f64; 6];

/// Type of stored samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum SampleType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

/// Properties of a raster.
#[derive(Debug, Clone)]
pub struct RasterInfo {
    /// The file.
    pub path: PathBuf,
    /// Format for people, e.g. `GeoTIFF`, `DTED level 1`.
    pub format: &'static str,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bands.
    pub bands: u32,
    /// Sample type.
    pub sample: SampleType,
    /// Georeferencing, if the file or a side file has any.
    pub geo: Option<GeoTransform>,
    /// Horizontal CRS, if stated.
    pub crs: Option<Crs>,
    /// Why the CRS that the file states is not understood; `crs` is `None` then. A sentence to show where the user is asked for a CRS.
    pub crs_problem: Option<String>,
    /// Local system, if the file states one.
    pub local: Option<LocalSystem>,
    /// System of the heights, as far as it is stated.
    pub vertical: VerticalCrs,
    /// Value that means no data, if stated (NaN possible; NaN samples are void always).
    pub nodata: Option<f64>,
    /// Physical value = offset + scale · sample (1 and 0 if silent).
    pub scale: f64,
    /// See `scale`.
    pub offset: f64,
    /// Index (zero-based) of an alpha band, if any.
    pub alpha_band: Option<u32>,
    /// The other bands are multiplied by the alpha band.
    pub is_premultiplied: bool,
    /// Descriptions of each band; empty if nothing is said.
    pub described: Vec<Band>,
    /// A unit of heights that is stated, but not known.
    pub unknown_unit: Option<String>,
    /// Notes on the file, a sentence each, its name before it.
    pub notes: Vec<String>,
    /// Zero is white and the highest sample black (TIFF's MinIsWhite); samples are as stored.
    pub white_is_zero: bool,
    /// True: samples are stated at points (AREA_OR_POINT=Point); only informative, `geo` is corrected already.
    pub pixel_is_point: bool,
    /// Natural block for reading.
    pub block: Size,
}

impl RasterInfo {
    /// Returns columns and rows.
    pub fn size(&self) -> Size {
        Size { width: self.width, height: self.height }
    }

    /// One band of bytes with nothing stated; readers fill in what their file says.
    pub(crate) fn blank(path: &Path, format: &'static str) -> Self {
        Self {
            path: path.to_owned(),
            format,
            width: 0,
            height: 0,
            bands: 1,
            sample: SampleType::U8,
            geo: None,
            crs: None,
            crs_problem: None,
            local: None,
            vertical: VerticalCrs::default(),
            nodata: None,
            scale: 1.0,
            offset: 0.0,
            alpha_band: None,
            is_premultiplied: false,
            described: Vec::new(),
            unknown_unit: None,
            notes: Vec::new(),
            white_is_zero: false,
            pixel_is_point: false,
            block: Size { width: 512, height: 64 },
        }
    }
}

/// Meaning of a band.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// Nothing is said of it.
    #[default]
    Unknown,
    /// Red light.
    Red,
    /// Green light.
    Green,
    /// Blue light.
    Blue,
    /// Opacity.
    Alpha,
    /// Place in a palette.
    Palette,
    /// Part of a colour that is told otherwise: by hue, by inks, by brightness and two differences.
    OtherColour,
    /// None of these, as is said.
    Other,
}

/// Description of a band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Role of the band.
    pub role: Role,
    /// Physical value = offset + scale · sample.
    pub scale: f64,
    /// See `scale`.
    pub offset: f64,
    /// Value of its own for no data.
    pub nodata: Option<f64>,
}
