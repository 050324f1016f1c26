//! DTED levels 0, 1 and 2 (MIL-PRF-89020B, appendix): three header records, then one record per longitude, each with its posts from
//! south to north.
//!
//! ```text
//! [tape headers, 80 bytes each]  UHL, 80 bytes  DSI, 648 bytes  ACC, 2700 bytes
//! record: 0xAA, block count (3 bytes), longitude count (2), latitude count (2), posts (2 each), checksum (4)
//! ```
//! Numbers are big-endian; posts are signed magnitude (the top bit is the sign), so a void is 0xFFFF, −32767. The
//! checksum is the sum of the record's other bytes. Some producers wrote two's complement: a magnitude beyond any depth is
//! taken as that, as GDAL does. Towards the poles columns are further apart than rows; the header says so.

use crate::raster::blocks::{BlockRaster, TO_TILES};
use crate::raster::columns::{GROUP, RasterColumns};
use crate::raster::file::InputFile;
use crate::raster::{OpenOptions, Raster, RasterInfo, SampleType};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Crs, VerticalCrs, VerticalDatum};

const UHL: u64 = 80;
const DSI: u64 = 648;
const ACC: u64 = 2700;
/// Bytes of a record before and after its posts.
const BEFORE: usize = 8;
const AFTER: usize = 4;
/// The deepest sea is less than 11 km deep; magnitudes beyond are two's complement.
const DEEPEST: i32 = -16_000;
const VOID: i16 = -32767;

/// Opens a cell.
pub(in crate::raster) fn open(file: InputFile, options: &OpenOptions) -> Result<Box<dyn Raster>> {
    let start = user_header(&file)?;
    let uhl = file.bytes_at(start, UHL)?;
    let dsi = file.bytes_at(start + UHL, DSI)?;
    if !dsi.starts_with(b"DSI") {
        let what = format!("has no DSI record at byte {}; it is damaged, fetch it again", start + UHL);
        return Err(Error::invalid(file.path(), what));
    }

    let header = DtedHeader::parse(&uhl, start).map_err(|what| Error::invalid(file.path(), what))?;
    let datum = String::from_utf8_lossy(&dsi[141..144]).into_owned();
    let horizontal = String::from_utf8_lossy(&dsi[144..149]).into_owned();

    let crs = match horizontal.trim() {
        "WGS84" => Crs::wgs84(),
        "WGS72" => Crs::from_epsg(4322)?,
        _ => {
            let what = format!("states the horizontal datum {horizontal:?}");
            return Err(Error::unsupported(
                file.path(),
                what,
                "convert it: gdalwarp -t_srs EPSG:4326 IN out.tif",
            ));
        }
    };

    let (longitude_step, latitude_step) = header.steps;
    let north = header.latitude + latitude_step * f64::from(header.posts - 1);
    let info = RasterInfo {
        width: header.columns,
        height: header.posts,
        sample: SampleType::I16,
        geo: Some([
            header.longitude - longitude_step / 2.0,
            longitude_step,
            0.0,
            north + latitude_step / 2.0,
            0.0,
            -latitude_step,
        ]),
        crs: Some(crs),
        vertical: VerticalCrs {
            datum: match datum.as_str() {
                "E96" => Some(VerticalDatum::Egm96),
                "E08" => Some(VerticalDatum::Egm2008),
                "MSL" => Some(VerticalDatum::Msl),
                _ => None,
            },
            metres_per_unit: Some(1.0),
            name: Some(datum.trim().to_owned()).filter(|name| !name.is_empty()),
        },
        nodata: Some(f64::from(VOID)),
        pixel_is_point: true,
        block: Size { width: GROUP.min(header.columns), height: header.posts },
        ..RasterInfo::blank(file.path(), level(&dsi))
    };

    let record_bytes = (BEFORE + AFTER) as u64 + 2 * u64::from(header.posts);
    let first = start + UHL + DSI + ACC;
    let columns = RasterColumns { file, info, first, record_bytes, decode: decode_column }.checked()?;

    Ok(Box::new(BlockRaster::new(columns, options.cache_bytes, TO_TILES)?))
}

fn level(dsi: &[u8]) -> &'static str {
    match &dsi[59..64] {
        b"DTED0" => "DTED level 0",
        b"DTED1" => "DTED level 1",
        b"DTED2" => "DTED level 2",
        _ => "DTED",
    }
}

/// Finds where the user header label begins, after tape headers.
fn user_header(file: &InputFile) -> Result<u64> {
    for start in (0..8).map(|record| record * 80) {
        match file.bytes_at(start, 4)?.as_slice() {
            b"UHL1" => return Ok(start),
            b"VOL1" | b"HDR1" => {}
            _ => break,
        }
    }
    Err(Error::invalid(
        file.path(),
        "has no DTED user header label (UHL1); it is damaged or of another format",
    ))
}

#[derive(Debug, PartialEq)]
struct DtedHeader {
    longitude: f64,
    latitude: f64,
    /// Degrees between columns and between posts.
    steps: (f64, f64),
    columns: u32,
    posts: u32,
}

impl DtedHeader {
    fn parse(uhl: &[u8], start: u64) -> std::result::Result<Self, String> {
        let field = |range: std::ops::Range<usize>| String::from_utf8_lossy(&uhl[range]).trim().to_owned();
        let number = |range: std::ops::Range<usize>, what: &str| {
            let at = start + range.start as u64;
            let text = field(range);
            text.parse::<u32>().map_err(|_| format!("states {text:?} as {what} at byte {at}; it is damaged"))
        };
        let columns = number(47..51, "its number of columns")?;
        let posts = number(51..55, "its number of posts")?;
        let longitude_step = number(20..24, "its longitude interval")?;
        let latitude_step = number(24..28, "its latitude interval")?;
        if columns == 0 || posts == 0 || longitude_step == 0 || latitude_step == 0 {
            return Err(format!(
                "states a size or interval of zero in its header at byte {start}; it is damaged"
            ));
        }

        let angle = |range: std::ops::Range<usize>| {
            let text = field(range);
            angle(&text).ok_or_else(|| {
                format!("states {text:?} as its origin in its header at byte {start}; it is damaged")
            })
        };
        let degrees = |tenths: u32| f64::from(tenths) / 36_000.0;
        let steps = (degrees(longitude_step), degrees(latitude_step));

        Ok(Self { longitude: angle(4..12)?, latitude: angle(12..20)?, steps, columns, posts })
    }
}

/// Degrees from `DDDMMSSH`.
fn angle(text: &str) -> Option<f64> {
    let part = |range: std::ops::Range<usize>| text.get(range)?.parse::<u16>().ok().map(f64::from);
    let degrees = part(0..3)? + part(3..5)? / 60.0 + part(5..7)? / 3600.0;
    match text.get(7..8)? {
        "N" | "E" if degrees <= 180.0 => Some(degrees),
        "S" | "W" if degrees <= 180.0 => Some(-degrees),
        _ => None,
    }
}

fn decode_column(column: u32, record: &mut [u8]) -> std::result::Result<(), String> {
    let (content, checksum) = record.split_at(record.len() - AFTER);
    if content[0] != 0xaa {
        return Err(format!("has no record mark before column {column}; it is damaged, fetch it again"));
    }

    let sum = content.iter().fold(0u32, |sum, byte| sum.wrapping_add(u32::from(*byte)));
    let stored = checksum.iter().fold(0u32, |value, byte| value << 8 | u32::from(*byte));
    if sum != stored {
        return Err(format!(
            "has a wrong checksum in column {column} (stored {stored}, found {sum}); it is damaged: fetch it again, or, \
             if its producer wrote wrong sums, gdal_translate IN out.tif"
        ));
    }

    let posts = (record.len() - BEFORE - AFTER) / 2;
    for post in 0..posts {
        let at = BEFORE + 2 * post;
        let height = signed_magnitude([record[at], record[at + 1]]);
        record[2 * post..2 * post + 2].copy_from_slice(&height.to_ne_bytes());
    }

    Ok(())
}

fn signed_magnitude(bytes: [u8; 2]) -> i16 {
    let bits = u16::from_be_bytes(bytes);
    let magnitude = i32::from(bits & 0x7fff);
    if bits & 0x8000 == 0 || bits == 0xffff || -magnitude >= DEEPEST {
        (if bits & 0x8000 == 0 { magnitude } else { -magnitude }) as i16
    } else {
        bits as i16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn posts() {
        assert_eq!(signed_magnitude([0x00, 0x05]), 5);
        assert_eq!(signed_magnitude([0x80, 0x05]), -5);
        assert_eq!(signed_magnitude([0xff, 0xff]), VOID);
        // −12 in two's complement.
        assert_eq!(signed_magnitude([0xff, 0xf4]), -12);
    }

    #[test]
    fn header() {
        let mut uhl = [b' '; 80];
        uhl[..55].copy_from_slice(b"UHL10060000W0750000S060003000051U              01810121");
        let header = DtedHeader::parse(&uhl, 0).unwrap();
        assert_eq!(
            (header.longitude, header.latitude, header.columns, header.posts),
            (-6.0, -75.0, 181, 121)
        );
        assert_eq!(header.steps, (600.0 / 36000.0, 300.0 / 36000.0));
        uhl[50] = b'x';
        assert!(DtedHeader::parse(&uhl, 0).unwrap_err().contains("byte 47"));
    }
}
