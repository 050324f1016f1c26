//! The reference system of a GeoTIFF, from its geo keys.
//!
//! Source: OGC 19-008r4, *GeoTIFF Standard* 1.1 (2019), §7 and annex D; codes of version 1.0 (Ritter and Ruth,
//! 2000) that files still use; the PE strings of Esri, which hold WKT in a citation.
//!
//! ```text
//! read the directory into id → value, checking every index
//! a PE string decides, if there is one
//! projected (model type 1): EPSG code, else method + parameters on the geographic system
//! geographic (model type 2): EPSG code, else datum code, else ellipsoid and shift
//! no model type: whichever of the two codes is present
//! vertical: code (which brings a unit), unit key over it
//! ```
//!
//! A directory that announces more keys than it holds is met in the wild (NASA WorldWind wrote such). Its codes are
//! believed, but neither parameters nor heights, whose keys come last and may be among the missing ones.
//!
//! Deviation: GDAL calls a file with a geographic code but no model type local; here the code is believed.

use super::crs::{Crs, shortened};
use super::datum::{VerticalCrs, VerticalDatum};
use super::geodetic::Geodetic;
use super::geokey_directory::{Keys, REPAIR, USER_DEFINED, key};
use super::geokeys_projection::{ellipsoid_terms, projection_terms};
use super::local::LocalSystem;
use super::{heights, registry, units, wkt, wkt_system};

/// Geo keys of a TIFF.
#[derive(Debug, Clone, PartialEq)]
pub struct GeoKeys {
    /// Horizontal system; `None` where the keys name none (or a local one).
    pub crs: Option<Crs>,
    /// Local system, where the keys describe one instead.
    pub local: Option<LocalSystem>,
    /// System of the heights, as far as the keys state one.
    pub vertical: VerticalCrs,
    /// Coordinates of a pixel are those of its centre (post), not of its corner.
    pub pixel_is_point: bool,
}

/// Reads the tags 34735 (directory), 34736 (doubles) and 34737 (text). The error is a sentence without the file's name.
pub fn parse_geokeys(directory: &[u16], doubles: &[f64], ascii: &str) -> Result<GeoKeys, String> {
    let keys = Keys::read(directory, doubles, ascii)?;
    let (crs, from_text) = horizontal(&keys)?;
    let local = if crs.is_none() { local(&keys)? } else { None };
    Ok(GeoKeys {
        crs,
        local,
        vertical: vertical(&keys)?.or(from_text.unwrap_or_default()),
        pixel_is_point: keys.code(key::RASTER_TYPE) == Some(2),
    })
}

/// The local system of keys that name no other: its citation and its unit.
fn local(keys: &Keys) -> Result<Option<LocalSystem>, String> {
    let unit = units::linear_of_keys(keys.code(key::LINEAR_UNITS), keys.number(key::LINEAR_UNIT_SIZE))?;
    let name = keys.text(key::CITATION).map(shortened);
    let is_stated = unit.is_some() || keys.code(key::MODEL_TYPE) == Some(USER_DEFINED);
    Ok(is_stated
        .then(|| LocalSystem { name: name.unwrap_or_default(), metres_per_unit: unit.unwrap_or(1.0) }))
}

const BROKEN: &str = "tag 34735 (GeoKeyDirectory) breaks off before the keys that describe the reference system; \
                      write the right one with: gdal_edit.py -a_srs EPSG:CODE FILE";

type Horizontal = (Option<Crs>, Option<VerticalCrs>);

fn horizontal(keys: &Keys) -> Result<Horizontal, String> {
    if let Some(text) = pe_string(keys) {
        let (crs, vertical) = wkt_system::read(text)?;
        return Ok((Some(crs), vertical));
    }
    let projected = keys.code(key::PROJECTED_CRS);
    let geodetic = keys.code(key::GEODETIC_CRS);
    match keys.code(key::MODEL_TYPE) {
        Some(1) => projected_crs(keys),
        Some(2) => geographic_crs(keys),
        Some(3) => Err("geo key 1024 declares geocentric coordinates, which are no map; convert the data with: gdalwarp -t_srs EPSG:4326 IN OUT.tif".into()),
        _ if projected.is_some_and(|code| code != USER_DEFINED) => projected_crs(keys),
        None if projected.is_none() && geodetic.is_some_and(|code| code != USER_DEFINED) => geographic_crs(keys),
        _ => Ok((None, None)),
    }
}

/// Esri's WKT in one of the citations.
fn pe_string(keys: &Keys) -> Option<&str> {
    [key::PROJECTED_CITATION, key::CITATION, key::GEODETIC_CITATION].iter().find_map(|id| {
        let (_, text) = keys.text(*id)?.split_once("ESRI PE String")?;
        let text = text.trim_start_matches([' ', '=']).trim_end_matches('|');
        wkt::looks_like_wkt(text).then_some(text)
    })
}

fn projected_crs(keys: &Keys) -> Result<Horizontal, String> {
    let linear = units::linear_of_keys(keys.code(key::LINEAR_UNITS), keys.number(key::LINEAR_UNIT_SIZE))?;
    let citation = [key::PROJECTED_CITATION, key::CITATION].iter().find_map(|id| keys.text(*id));
    match keys.code(key::PROJECTED_CRS) {
        Some(code) if code != USER_DEFINED => {
            let crs = Crs::by_code(u32::from(code))?;
            let own = crs.metres_per_unit().ok_or_else(|| {
                format!("geo key 3072 gives EPSG:{code}, which is no projected system; {REPAIR}")
            })?;
            match linear {
                Some(unit) if !units::same(unit, own) => Err(format!(
                    "geo key 3076 gives a unit of {unit} m, but EPSG:{code} of key 3072 counts in {own} m; {REPAIR}"
                )),
                _ => Ok((Some(crs), heights::part_of(u32::from(code)))),
            }
        }
        _ if keys.broken => Err(BROKEN.into()),
        _ => {
            let unit = linear.unwrap_or(1.0);
            let mut terms = projection_terms(keys, unit)?;
            if unit != 1.0 {
                terms += &format!(" +to_meter={unit}");
            }
            let name = citation.filter(|name| !matches!(*name, "unknown" | "unnamed"));
            let geodetic = geodetic(keys)?;
            let name = name.map_or_else(|| format!("{terms} {}", geodetic.terms), shortened);
            Ok((Some(Crs::of(&terms, &geodetic, &name)?), None))
        }
    }
}

fn geographic_crs(keys: &Keys) -> Result<Horizontal, String> {
    let unit = units::angular_of_keys(keys.code(key::ANGULAR_UNITS), keys.number(key::ANGULAR_UNIT_SIZE))?;
    if !units::same(unit, 1.0) {
        return Err(format!(
            "geo key 2054 gives coordinates in units of {unit} degrees, and only degrees are read; convert the data with: gdalwarp -t_srs EPSG:4326 IN OUT.tif"
        ));
    }
    if let Some(code) = keys.code(key::GEODETIC_CRS).filter(|code| *code != USER_DEFINED) {
        let crs = Crs::by_code(u32::from(code))?;
        if !crs.is_geographic() {
            return Err(format!("geo key 2048 gives EPSG:{code}, which is no geographic system; {REPAIR}"));
        }
        return Ok((Some(crs), heights::part_of(u32::from(code))));
    }
    if keys.broken {
        return Err(BROKEN.into());
    }

    let geodetic = geodetic(keys)?;
    let name = keys
        .text(key::GEODETIC_CITATION)
        .or(keys.text(key::CITATION))
        .map_or_else(|| geodetic.terms.clone(), shortened);

    Ok((Some(Crs::of("+proj=longlat", &geodetic, &name)?), None))
}

/// The datum, with the ellipsoid and the meridian that the keys give.
fn geodetic(keys: &Keys) -> Result<Geodetic, String> {
    let is_code = |code: &u16| *code != USER_DEFINED;
    if let Some(code) = keys.code(key::GEODETIC_CRS).filter(is_code) {
        let system = registry::geographic(u32::from(code));
        let system = system.ok_or_else(|| {
            format!(
                "geo key 2048 gives EPSG:{code}, which is no geographic system that is known here; {REPAIR}"
            )
        })?;
        return Geodetic::registered(&system);
    }
    if let Some(code) = keys.code(key::GEODETIC_DATUM).filter(is_code)
        && let Some(system) = registry::geographic_of_datum(u32::from(code))
    {
        return Geodetic::registered(&system);
    }

    let mut terms = ellipsoid_terms(keys)?;
    if let Some(longitude) = keys.number(key::PRIME_MERIDIAN_LONGITUDE).filter(|longitude| *longitude != 0.0)
    {
        terms = format!("{terms} +pm={longitude}");
    }

    let name = datum_name(keys).unwrap_or_else(|| terms.clone());
    if let Some(shift) = keys.numbers(key::TO_WGS84).filter(|shift| matches!(shift.len(), 3 | 7)) {
        let shift: Vec<String> = shift.iter().map(f64::to_string).collect();
        return Geodetic::stated(terms, Some(&shift.join(",")), &name);
    }

    match Geodetic::named(&name) {
        Some(system) => Ok(Geodetic { terms, ..Geodetic::registered(&system)? }),
        None => Geodetic::stated(terms, None, &name),
    }
}

/// Name of the datum in the citation of the geographic system: GDAL writes `GCS Name = … |Datum = … |`.
fn datum_name(keys: &Keys) -> Option<String> {
    let citation = keys.text(key::GEODETIC_CITATION)?;
    let datum = citation.split('|').find_map(|part| part.trim().strip_prefix("Datum = "));
    Some(shortened(datum.unwrap_or(citation).trim()))
}

/// The system of heights that the keys state.
fn vertical(keys: &Keys) -> Result<VerticalCrs, String> {
    if keys.broken {
        let named = [key::VERTICAL_CRS, key::VERTICAL_DATUM, key::VERTICAL_UNITS]
            .iter()
            .any(|id| keys.code(*id).is_some());
        let name = named.then(|| "one that a broken key directory describes in part".to_owned());
        return Ok(VerticalCrs { name, ..VerticalCrs::default() });
    }

    let code = keys.code(key::VERTICAL_CRS).filter(|code| *code != USER_DEFINED).map(u32::from);
    let known = code.and_then(|code| heights::by_code(code).or_else(|| heights::part_of(code)));
    let by_datum = || match keys.code(key::VERTICAL_DATUM)? {
        5100 => Some(VerticalDatum::Msl),
        5103 => Some(VerticalDatum::Navd88),
        5171 => Some(VerticalDatum::Egm96),
        1027 => Some(VerticalDatum::Egm2008),
        _ => None,
    };

    let named = || {
        let code = code.map(|code| format!("EPSG:{code}"));
        code.or_else(|| keys.text(key::VERTICAL_CITATION).map(shortened))
            .or_else(|| keys.code(key::VERTICAL_DATUM).map(|code| format!("the vertical datum EPSG:{code}")))
    };
    let mut vertical = known.unwrap_or_else(|| {
        let name = named();
        let datum = by_datum().or_else(|| heights::datum_of(name.as_deref()?));
        VerticalCrs { datum, metres_per_unit: None, name }
    });

    // The unit key counts before the code's unit; the direction is the code's.
    let unit = units::linear_of_keys(keys.code(key::VERTICAL_UNITS), None);
    let unit = unit.map_err(|reason| format!("geo key 4099 gives the unit of heights: {reason}"))?;
    if let Some(unit) = unit {
        let is_down = vertical.metres_per_unit.is_some_and(|metres| metres < 0.0);
        vertical.metres_per_unit = Some(if is_down { -unit } else { unit });
    }

    Ok(vertical)
}
