//! Whether coordinates can be what their reference system says: degrees taken for metres, metres for degrees, swapped axes; and whether
//! pixels are such as cover ground at all.

use super::footprint::corner_bounds;
use crate::raster::{GeoTransform, RasterInfo};
use hedgehop::Size;
use hedgehop::voxel::limits;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// A file that states no reference system, or one that is not read, and what helps.
pub(super) fn no_crs(info: &RasterInfo, geo: GeoTransform, flag: &str) -> Error {
    // A guess from the coordinates would contradict what the file states: degrees of the Moon are not the Earth's.
    if let Some(problem) = &info.crs_problem {
        let what = format!("states a coordinate reference system that is not read: {problem}");
        return Error::unsupported(&info.path, what, format!("if it states a wrong one, say {flag} EPSG:…"));
    }

    if let Some(local) = &info.local {
        let what = format!("states {}, which has no place on Earth", local.words());
        return Error::unsupported(
            &info.path,
            what,
            format!(
                "say {flag} EPSG:… if you know where it lies, or --local to take its coordinates as plain metres"
            ),
        );
    }

    let guess = if looks_like_degrees(&geo, info.size()) {
        format!("its coordinates look like degrees: if they are, say {flag} EPSG:4326")
    } else {
        format!("say {flag} EPSG:… if you know it, or --local to take its coordinates as plain metres")
    };

    Error::unsupported(&info.path, "states no coordinate reference system", guess)
}

/// Refuses a local system whose unit is not the metre, where its coordinates would be taken as plain metres.
pub(super) fn local_in_metres(info: &RasterInfo, geo: &GeoTransform) -> Result<()> {
    let Some(local) = info.local.as_ref().filter(|local| !local.is_metric()) else { return Ok(()) };
    let [west, south, east, north] =
        corner_bounds(geo, info.size()).map(|side| (1e6 * local.metres_per_unit * side).round() / 1e6);
    let remedy = format!(
        "bring it to metres: gdal_translate -a_srs 'LOCAL_CS[\"metres\",UNIT[\"metre\",1]]' -a_ullr {west} {north} {east} {south} IN OUT.tif, and remove the .prj beside it"
    );
    Err(Error::unsupported(
        &info.path,
        format!("states {}, and --local takes plain metres", local.words()),
        remedy,
    ))
}

/// Extents of longitudes and latitudes, and pixels too small for metres from the air or space.
fn looks_like_degrees(geo: &GeoTransform, size: Size) -> bool {
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

/// Metres of a degree of latitude.
const DEGREE: f64 = 111_320.0;
/// Sides of pixels of which no ground is a picture, metres.
const PIXELS: std::ops::RangeInclusive<f64> = 1.0e-4..=2.0e6;
/// Ratio of length to width from which on a pixel is taken for a mistake: six occurs, in degrees towards the poles.
const LONGEST_PIXEL: f64 = 50.0;
/// Least sine of the angle between rows and columns.
const LEAST_ANGLE: f64 = 0.1;
/// Twice the Earth's circumference, metres: no map of anything on it is wider, but for its distant parts in odd projections.
const WIDEST: f64 = 80.0e6;
/// Farthest from the origin of a map's system that a place on Earth may lie, metres.
const FARTHEST_OF_MAPS: f64 = 1.0e9;

/// Refuses pixels that are no squares by far, or rasters without bound: georeferencing that is damaged or of something else.
fn sound_pixels(info: &RasterInfo, geo: &GeoTransform, crs: &Crs) -> Result<()> {
    let refuse = |what: String| {
        let remedy = "repair its georeferencing: the world file beside it, or its tags with `gdal_edit.py -a_ullr W N E S FILE`";
        Err(Error::unsupported(&info.path, what, remedy))
    };
    if !geo.iter().all(|term| term.is_finite()) {
        return refuse(format!("states {geo:?} as its geotransform, not all of which are numbers"));
    }

    let unit = if crs.is_geographic() { DEGREE } else { crs.metres_per_unit().unwrap_or(1.0) };
    let sides = [(geo[1], geo[4]), (geo[2], geo[5])].map(|(east, north)| unit * east.hypot(north));
    let [across, down] = sides;
    if sides.iter().any(|side| !PIXELS.contains(side)) {
        return refuse(format!("has pixels of {across} x {down} m, as no picture of ground has"));
    }
    if across.max(down) > LONGEST_PIXEL * across.min(down) {
        return refuse(format!("has pixels of {across} x {down} m, which are far from square"));
    }

    let area = (unit * unit * (geo[1] * geo[5] - geo[2] * geo[4])).abs();
    if area < LEAST_ANGLE * across * down {
        return refuse("has rows and columns that run nearly the same way".into());
    }

    let [west, south, east, north] = corner_bounds(geo, info.size()).map(|side| unit * side);
    let (width, height) = (east - west, north - south);
    let (widest, reach) = match crs.is_local() {
        true => (limits::FARTHEST, limits::FARTHEST),
        false => (WIDEST, FARTHEST_OF_MAPS),
    };
    if width.max(height) > widest {
        return refuse(format!(
            "covers {:.0} x {:.0} km, more than the Earth has",
            width / 1000.0,
            height / 1000.0
        ));
    }

    let farthest = [west, south, east, north].into_iter().fold(0.0, |far: f64, side| far.max(side.abs()));
    if farthest > reach {
        return refuse(format!("lies {:.0} km from the origin of {}", farthest / 1000.0, crs.name()));
    }

    Ok(())
}

/// Refuses coordinates that cannot be what the reference system says, and pixels that cover no ground.
pub(super) fn plausible(info: &RasterInfo, geo: &GeoTransform, crs: &Crs, flag: &str) -> Result<()> {
    of_system(info, geo, crs, flag)?;
    sound_pixels(info, geo, crs)
}

fn of_system(info: &RasterInfo, geo: &GeoTransform, crs: &Crs, flag: &str) -> Result<()> {
    let size = info.size();
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn judge(geo: GeoTransform, crs: &Crs) -> Result<()> {
        let info = RasterInfo { width: 64, height: 64, ..RasterInfo::blank(Path::new("a.png"), "PNG") };
        sound_pixels(&info, &geo, crs)
    }

    #[test]
    fn pixels_that_cover_no_ground_are_refused() {
        let utm = Crs::from_epsg(32633).unwrap();
        let sound = [500_000.0, 10.0, 0.0, 5_000_000.0, 0.0, -10.0];
        assert!(judge(sound, &utm).is_ok());

        // Turned by a third of a right angle, and three times as long as wide.
        assert!(judge([500_000.0, 8.66, -15.0, 5_000_000.0, 5.0, 25.98], &utm).is_ok());
        let table: [(usize, f64, &str); 11] = [
            (1, 4_294_967_296.0, "no picture of ground"),
            (1, 1.0e4, "far from square"),
            (5, -0.01, "far from square"),
            (5, 0.0, "no picture of ground"),
            (1, 1.0e-300, "no picture of ground"),
            (1, f64::NAN, "not all of which are numbers"),
            (0, f64::INFINITY, "not all of which are numbers"),
            (0, 1.0e300, "from the origin"),
            (3, -2.0e9, "from the origin"),
            (2, 400.0, "nearly the same way"),
            (4, f64::NEG_INFINITY, "not all of which are numbers"),
        ];

        for (term, value, word) in table {
            let mut geo = sound;
            geo[term] = value;
            // Sheared, columns are as long as they must be to be square.
            if term == 2 {
                geo[1] = 400.0;
            }
            let told = judge(geo, &utm).unwrap_err().to_string();
            assert!(told.contains(word) && told.contains("world file"), "{term} {value}: {told}");
        }
    }

    #[test]
    fn areas_larger_than_the_earth_are_refused() {
        let wide = [0.0, 1.5e6, 0.0, 0.0, 0.0, -1.5e6];
        assert!(
            judge(wide, &Crs::from_epsg(32633).unwrap()).unwrap_err().to_string().contains("than the Earth")
        );
        assert!(judge(wide, &Crs::local()).is_ok(), "plain metres are of no planet");
        // All of it, in degrees.
        let degrees = [-180.0, 360.0 / 64.0, 0.0, 90.0, 0.0, -180.0 / 64.0];
        assert!(judge(degrees, &Crs::wgs84()).is_ok());
    }
}
