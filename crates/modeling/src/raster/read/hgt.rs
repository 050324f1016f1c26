//! SRTM `.hgt`: big-endian 16-bit heights, rows from the north, without a header. The name states the south-west
//! post (`N35E138`), the length the spacing: 1201² posts are 3″ apart, 3601² are 1″ apart, and the first and last rows
//! and columns lie on whole degrees (USGS, *SRTM Topography*, 2015, §2.1). Voids are −32768; heights are metres above EGM96.

use crate::raster::file::InputFile;
use crate::raster::raw::{RawRaster, RowStarts, SamplePlacement};
use crate::raster::sample::ByteOrder;
use crate::raster::{GeoTransform, Raster, RasterInfo, SampleType};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Crs, VerticalCrs, VerticalDatum};

/// Opens a tile.
pub(in crate::raster) fn open(file: InputFile) -> Result<Box<dyn Raster>> {
    let posts: u32 = match file.length() {
        2_884_802 => 1201,
        25_934_402 => 3601,
        length => {
            let what = format!("holds {length} bytes; an .hgt tile holds 1201² or 3601² 16-bit heights");
            return Err(Error::invalid(
                file.path(),
                format!("{what} (2884802 or 25934402 bytes), fetch it again"),
            ));
        }
    };

    let stem = file.path().file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let (longitude, latitude) = south_west(stem).ok_or_else(|| {
        Error::invalid(
            file.path(),
            "must be named after its south-west corner, such as N35E138.hgt, since nothing else states its place",
        )
    })?;

    let info = RasterInfo {
        width: posts,
        height: posts,
        sample: SampleType::I16,
        geo: Some(geo(longitude, latitude, posts)),
        crs: Some(Crs::wgs84()),
        vertical: VerticalCrs { datum: Some(VerticalDatum::Egm96), metres_per_unit: Some(1.0), name: None },
        nodata: Some(-32768.0),
        pixel_is_point: true,
        ..RasterInfo::blank(file.path(), "SRTM .hgt")
    };

    let placement = SamplePlacement {
        rows: RowStarts::Even { first: 0, row_bytes: u64::from(posts) * 2 },
        pixel_bytes: 2,
        band_bytes: 0,
        order: ByteOrder::Big,
    };

    Ok(Box::new(RawRaster::new(file, info, placement)?))
}

/// Posts lie on pixel centres, hence the half pixel.
fn geo(longitude: f64, latitude: f64, posts: u32) -> GeoTransform {
    let step = 1.0 / f64::from(posts - 1);
    [longitude - step / 2.0, step, 0.0, latitude + 1.0 + step / 2.0, 0.0, -step]
}

/// Longitude and latitude of the south-west post from a name that begins with `N35E138`.
fn south_west(stem: &str) -> Option<(f64, f64)> {
    let stem = stem.to_ascii_uppercase();
    let signed = |positive: char, negative: char, limit: f64, text: &str| {
        let (hemisphere, digits) = (text.chars().next()?, text.get(1..)?);
        let digits = Some(digits).filter(|digits| digits.bytes().all(|byte| byte.is_ascii_digit()))?;
        let degrees = f64::from(digits.parse::<u16>().ok()?);
        let sign = if hemisphere == positive {
            1.0
        } else if hemisphere == negative {
            -1.0
        } else {
            return None;
        };
        (degrees <= limit).then_some(sign * degrees)
    };
    let latitude = signed('N', 'S', 90.0, stem.get(..3)?)?;
    let longitude = signed('E', 'W', 180.0, stem.get(3..7)?)?;
    Some((longitude, latitude))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names() {
        assert_eq!(south_west("N35E138"), Some((138.0, 35.0)));
        assert_eq!(south_west("s01w078.SRTMGL1"), Some((-78.0, -1.0)));
        for name in ["", "N35", "X35E138", "N35E1", "N99E138", "N35EÄ8x", "N+5E138"] {
            assert_eq!(south_west(name), None, "{name}");
        }
    }
}
