//! Whether coordinates can be what their reference system says: degrees taken for metres, metres for degrees, swapped axes.

use super::inputs::corner_bounds;
use super::raster::{GeoTransform, RasterInfo};
use crate::error::{Error, Result};
use crate::geo::Crs;

/// A file that states no reference system, and what helps.
pub(super) fn no_crs(info: &RasterInfo, geo: GeoTransform, flag: &str) -> Error {
    let guess = if looks_like_degrees(&geo, (info.width, info.height)) {
        format!("its coordinates look like degrees: if they are, say {flag} EPSG:4326")
    } else {
        format!("say {flag} EPSG:… if you know it, or --local to take its coordinates as plain metres")
    };
    Error::unsupported(&info.path, "states no coordinate reference system", guess)
}

/// Extents of longitudes and latitudes, and pixels too small for metres from the air or space.
fn looks_like_degrees(geo: &GeoTransform, size: (u32, u32)) -> bool {
    /// Half a pixel beyond the poles and the 360th meridian, for coarse global rasters.
    const SLACK: f64 = 1.0;
    /// Pixels of a tenth of a degree and less, or whole-Earth rasters.
    const PIXEL: f64 = 0.1;
    let [west, south, east, north] = corner_bounds(geo, size);
    let small = geo[1].hypot(geo[4]) < PIXEL && geo[2].hypot(geo[5]) < PIXEL;
    let global = east - west > 350.0 && north - south > 120.0;
    west >= -180.0 - SLACK
        && east <= 360.0 + SLACK
        && south >= -90.0 - SLACK
        && north <= 90.0 + SLACK
        && (small || global)
}

/// Refuses coordinates that cannot be what the reference system says.
pub(super) fn plausible(info: &RasterInfo, geo: &GeoTransform, crs: &Crs, flag: &str) -> Result<()> {
    let size = (info.width, info.height);
    let [west, south, east, north] = corner_bounds(geo, size);
    let extent = format!("its coordinates, {west} … {east} east and {south} … {north} north,");
    let remedy = || match &info.crs {
        Some(_) => "its georeferencing is wrong; repair it with `gdal_edit.py -a_srs EPSG:… FILE`".to_owned(),
        None => format!("name the right system with {flag} EPSG:…"),
    };
    if !crs.is_geographic() {
        if looks_like_degrees(geo, size) {
            return Err(Error::unsupported(
                &info.path,
                format!("{extent} look like degrees, but would be taken as metres ({})", crs.name()),
                if info.crs.is_some() {
                    remedy()
                } else {
                    format!("say {flag} EPSG:4326 if they are degrees")
                },
            ));
        }
        return Ok(());
    }
    let (column, row) = (geo[1].hypot(geo[4]), geo[2].hypot(geo[5]));
    let within =
        west >= -360.0 - column && east <= 540.0 + column && south >= -90.0 - row && north <= 90.0 + row;
    if within && east - west <= 360.0 + 2.0 * column {
        return Ok(());
    }
    Err(Error::unsupported(&info.path, format!("{extent} cannot be degrees of {}", crs.name()), remedy()))
}
