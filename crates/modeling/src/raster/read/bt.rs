//! VTP `.bt` (Virtual Terrain Project, *The BT format*, version 1.3): a header of 256 bytes, then columns from the west, each
//! from south to north, little-endian.
//!
//! ```text
//! 0 "binterr1.3"  10 columns i32  14 rows i32  18 bytes per sample i16  20 floating point i16  22 units i16 (0 degrees,
//! 1 metres, 2 feet, 3 US survey feet)  24 UTM zone i16 (negative: south)  26 datum i16  28 left f64  36 right f64
//! 44 bottom f64  52 top f64  60 projection in .prj i16  62 metres per vertical unit f32
//! ```

use crate::raster::blocks::{BlockRaster, TO_TILES};
use crate::raster::columns::{GROUP, RasterColumns, plain_little_endian};
use crate::raster::file::InputFile;
use crate::raster::sample::ByteOrder;
use crate::raster::{OpenOptions, Raster, RasterInfo, SampleType, georeference, side_files};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Crs, VerticalCrs};

const HEADER: u64 = 256;

/// Opens a terrain.
pub(in crate::raster) fn open(file: InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let header = file.bytes_at(0, HEADER)?;
    let unsigned = |at: usize, size: usize| ByteOrder::Little.unsigned(&header[at..at + size]);
    let short = |at: usize| i64::from(unsigned(at, 2) as u16 as i16);
    let double = |at: usize| f64::from_bits(unsigned(at, 8));
    let invalid = |what: String| Error::invalid(file.path(), what);

    let size = |at: usize, what: &str| match i32::try_from(unsigned(at, 4)) {
        Ok(size) if size > 0 => Ok(size as u32),
        _ => Err(invalid(format!("states no sound number of {what} at byte {at}; it is damaged"))),
    };
    let (width, height) = (size(10, "columns")?, size(14, "rows")?);

    let sample = match (short(18), short(20)) {
        (2, 0) => SampleType::I16,
        (4, 0) => SampleType::I32,
        (4, 1) => SampleType::F32,
        (bytes, float) => {
            return Err(invalid(format!(
                "states samples of {bytes} bytes, float {float}, at byte 18; it is damaged"
            )));
        }
    };

    let (left, right, bottom, top) = (double(28), double(36), double(44), double(52));
    let geo = [left, (right - left) / f64::from(width), 0.0, top, 0.0, (bottom - top) / f64::from(height)];
    if !georeference::is_sound(&geo) {
        return Err(invalid("states no sound extent at bytes 28 to 59; it is damaged".to_owned()));
    }

    let vertical = f32::from_bits(unsigned(62, 4) as u32);
    let mut info = RasterInfo {
        width,
        height,
        sample,
        geo: Some(geo),
        vertical: VerticalCrs {
            metres_per_unit: (vertical.is_finite() && vertical > 0.0).then_some(f64::from(vertical)),
            ..VerticalCrs::default()
        },
        nodata: Some(-32768.0),
        block: Size { width: GROUP.min(width), height },
        ..RasterInfo::blank(file.path(), "VTP .bt")
    };

    side_files::complete(&mut info)?;
    if info.crs.is_none() && info.crs_problem.is_none() {
        match stated_crs(short(22), short(24), short(26)) {
            Ok(crs) => info.crs = crs,
            Err(problem) => info.crs_problem = Some(problem),
        }
    }

    let record_bytes = u64::from(height) * sample.bytes() as u64;
    let columns =
        RasterColumns { file, info, first: HEADER, record_bytes, decode: plain_little_endian(sample) }
            .checked()?;

    Ok(Box::new(BlockRaster::new(columns, options.cache_bytes, TO_TILES)?))
}

/// The system that the header's own fields state, if they state one; the error is why it is not read.
fn stated_crs(units: i64, zone: i64, datum: i64) -> std::result::Result<Option<Crs>, String> {
    let zone = match (units, zone) {
        (0, _) => None,
        (1, 1..=60 | -60..=-1) => Some(zone),
        _ => return Ok(None),
    };
    let code = u32::try_from(datum).map_err(|_| format!("its header names a datum of the number {datum}"))?;
    Crs::on_datum(code, zone).map(Some)
}
