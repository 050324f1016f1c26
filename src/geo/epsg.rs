//! EPSG codes: definitions of horizontal systems, names of the common ones, vertical systems.

use super::datum::{VerticalCrs, VerticalDatum};
use super::definition::Definition;
use super::projection::CONVERT;

/// US survey foot, metres (exactly 1200/3937).
pub(super) const US_SURVEY_FOOT: f64 = 1200.0 / 3937.0;
/// International foot, metres.
pub(super) const FOOT: f64 = 0.3048;

/// Codes of other authorities, or withdrawn ones, that mean the same as a current EPSG code.
const ALIASES: [(u32, u32); 6] =
    [(900_913, 3857), (102_100, 3857), (102_113, 3857), (3785, 3857), (4329, 4326), (54_001, 4087)];

/// Codes whose definition in the table moves places by half a metre or more against PROJ 9.5, or swaps or turns
/// the axes: Krovak and Cassini grids that count to the south and west, spherical EASE grids on an ellipsoid,
/// wrong false origins. Found by comparing all 5,222 projected definitions at one place each.
const UNSOUND: [u32; 11] = [2065, 3167, 3973, 3974, 3975, 5513, 6200, 6996, 6997, 8044, 8045];

/// The current code for `code`.
pub(super) fn current(code: u32) -> u32 {
    ALIASES.iter().find(|(alias, _)| *alias == code).map_or(code, |(_, current)| *current)
}

/// Definition of a horizontal system, or of the horizontal part of a compound one.
pub(super) fn definition(code: u32) -> Result<Definition, String> {
    let remedy = "give the system as a PROJ string instead, for example --crs '+proj=utm +zone=33 +datum=WGS84' (epsg.io shows one for each code)";
    if let Some(vertical) = vertical(code) {
        return Err(format!(
            "EPSG:{code} measures only heights ({}); give the horizontal system, and the heights as --src-vdatum",
            vertical.datum.label()
        ));
    }
    if UNSOUND.contains(&code) {
        return Err(format!("EPSG:{code} cannot be used: its definition here is not sound; {CONVERT}"));
    }
    let found = u16::try_from(horizontal_part(current(code))).ok().and_then(crs_definitions::from_code);
    let found = found.ok_or_else(|| format!("EPSG:{code} is not known here; {remedy}"))?;
    Definition::loadable(found.proj4).map_err(|reason| format!("EPSG:{code} cannot be used: {reason}"))
}

/// Name for people.
pub(super) fn name(code: u32) -> String {
    let utm = |first: u32, hemisphere: char| format!("WGS 84 / UTM zone {}{hemisphere}", code - first);
    let known = match code {
        32_601..=32_660 => return utm(32_600, 'N'),
        32_701..=32_760 => return utm(32_700, 'S'),
        4326 => "WGS 84",
        4979 => "WGS 84 (3D)",
        4258 => "ETRS89",
        4269 => "NAD83",
        4267 => "NAD27",
        3857 => "WGS 84 / Pseudo-Mercator",
        4087 => "WGS 84 / World Equidistant Cylindrical",
        3395 => "WGS 84 / World Mercator",
        3035 => "ETRS89-extended / LAEA Europe",
        5070 => "NAD83 / Conus Albers",
        2154 => "RGF93 v1 / Lambert-93",
        2056 => "CH1903+ / LV95",
        27_700 => "OSGB36 / British National Grid",
        3995 => "WGS 84 / Arctic Polar Stereographic",
        3031 => "WGS 84 / Antarctic Polar Stereographic",
        32_661 => "WGS 84 / UPS North (E,N)",
        32_761 => "WGS 84 / UPS South (E,N)",
        _ => return format!("EPSG:{code}"),
    };
    known.to_owned()
}

/// Vertical system of an EPSG code, or of one of the older GeoTIFF codes.
pub(super) fn vertical(code: u32) -> Option<VerticalCrs> {
    let (datum, metres_per_unit) = match code {
        5773 => (VerticalDatum::Egm96, 1.0),
        3855 => (VerticalDatum::Egm2008, 1.0),
        // 5103 is the GeoTIFF 1.0 code.
        5703 | 5103 => (VerticalDatum::Navd88, 1.0),
        6360 => (VerticalDatum::Navd88, US_SURVEY_FOOT),
        8228 => (VerticalDatum::Navd88, FOOT),
        5714 => (VerticalDatum::Msl, 1.0),
        // GeoTIFF 1.0: ellipsoids of GRS 80 and WGS 84.
        5019 | 5030 => (VerticalDatum::Ellipsoid, 1.0),
        _ => return None,
    };
    Some(VerticalCrs { datum, metres_per_unit })
}

/// Vertical part of a compound code or of a three-dimensional geographic one.
pub(super) fn vertical_part(code: u32) -> Option<VerticalCrs> {
    match code {
        4979 | 4937 | 6319 => vertical(5030),
        9707 => vertical(5773),
        6871 | 6893 | 9518 => vertical(3855),
        9705 => vertical(5714),
        5498..=5500 | 6349 | 8801..=8815 => vertical(5703),
        8712..=8800 => vertical(6360),
        8700..=8711 => vertical(8228),
        _ => None,
    }
}

/// Horizontal part of a compound code that the definitions lack or get wrong.
fn horizontal_part(code: u32) -> u32 {
    match code {
        9518 | 9705 | 9707 => 4326,
        6871 => 3857,
        _ => code,
    }
}
