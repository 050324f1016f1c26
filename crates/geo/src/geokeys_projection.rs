//! Projection and ellipsoid of a GeoTIFF that gives them by parameters instead of one code.

use super::geokey_directory::{Keys, USER_DEFINED, key};
use super::projection::{CONVERT, Method, Parameters, Term, proj_terms};
use super::units;

/// PROJ's terms of the projection. `unit`: metres per unit of lengths.
pub(super) fn projection_terms(keys: &Keys, unit: f64) -> Result<String, String> {
    match (keys.code(key::PROJECTION), keys.code(key::METHOD)) {
        (Some(code @ 16_001..=16_060), _) => Ok(format!("+proj=utm +zone={}", code - 16_000)),
        (Some(code @ 16_101..=16_160), _) => Ok(format!("+proj=utm +zone={} +south", code - 16_100)),
        (_, Some(code)) if code != USER_DEFINED => {
            proj_terms(method(code)?, &parameters(keys, unit)?)
        }
        (Some(code), _) if code != USER_DEFINED => {
            Err(format!("geo key 3074 gives the conversion EPSG:{code}, which is not known here; {CONVERT}"))
        }
        _ => Err("the geo keys declare a projected system, but give neither its code (key 3072) nor a method (key 3075); write it with: gdal_edit.py -a_srs EPSG:CODE FILE".into()),
    }
}

/// Method of a coordinate transformation code (GeoTIFF 1.0 §6.3.3.3).
fn method(code: u16) -> Result<Method, String> {
    Ok(match code {
        1 => Method::TransverseMercator,
        3 => Method::ObliqueMercatorA,
        5 => Method::SwissOblique,
        7 => Method::Mercator,
        8 | 9 => Method::LambertConformal,
        10 => Method::LambertAzimuthal,
        11 => Method::Albers,
        12 => Method::AzimuthalEquidistant,
        13 => Method::EquidistantConic,
        14 => Method::Stereographic,
        15 => Method::PolarStereographic,
        16 => Method::ObliqueStereographic,
        17 => Method::EquidistantCylindrical,
        18 => Method::Cassini,
        22 => Method::Polyconic,
        24 => Method::Sinusoidal,
        28 => Method::CylindricalEqualArea,
        9815 => Method::ObliqueMercatorB,
        other => {
            return Err(format!(
                "geo key 3075 gives projection method {other}, which is not read; {CONVERT}"
            ));
        }
    })
}

/// Keys of each parameter, in the order in which writers are to be believed, and what they count in.
const SOURCES: [(Term, &[u16], MethodKind); 9] = [
    (Term::Latitude, &[3081, 3089, 3085], MethodKind::Angle),
    (Term::Longitude, &[3080, 3088, 3084, 3095], MethodKind::Angle),
    (Term::Parallel1, &[3078], MethodKind::Angle),
    (Term::Parallel2, &[3079], MethodKind::Angle),
    (Term::Scale, &[3092, 3093], MethodKind::Ratio),
    (Term::Azimuth, &[3094], MethodKind::Angle),
    (Term::RectifiedAngle, &[3096], MethodKind::Angle),
    (Term::FalseEasting, &[3082, 3090, 3086], MethodKind::Length),
    (Term::FalseNorthing, &[3083, 3091, 3087], MethodKind::Length),
];

#[derive(Clone, Copy)]
enum MethodKind {
    Angle,
    Length,
    Ratio,
}

fn parameters(keys: &Keys, unit: f64) -> Result<Parameters, String> {
    let angle = units::angular_of_keys(keys.code(key::ANGULAR_UNITS), keys.number(key::ANGULAR_UNIT_SIZE))?;
    let mut parameters = Parameters::default();
    for (term, ids, kind) in SOURCES {
        if let Some(value) = ids.iter().find_map(|id| keys.number(*id)) {
            let factor = match kind {
                MethodKind::Angle => angle,
                MethodKind::Length => unit,
                MethodKind::Ratio => 1.0,
            };
            parameters.set(term, value * factor);
        }
    }
    Ok(parameters)
}

/// PROJ's terms of the ellipsoid.
pub(super) fn ellipsoid_terms(keys: &Keys) -> Result<String, String> {
    let named = match keys.code(key::ELLIPSOID) {
        Some(7001) => Some("airy"),
        Some(7004) => Some("bessel"),
        Some(7008) => Some("clrk66"),
        Some(7011) => Some("clrk80ign"),
        Some(7012 | 7034) => Some("clrk80"),
        Some(7019) => Some("GRS80"),
        Some(7022) => Some("intl"),
        Some(7024) => Some("krass"),
        Some(7030) => Some("WGS84"),
        Some(7043) => Some("WGS72"),
        _ => None,
    };

    if let Some(name) = named {
        return Ok(format!("+ellps={name}"));
    }

    let axis = keys.number(key::SEMI_MAJOR).filter(|axis| *axis > 0.0);
    let axis = axis.ok_or("the geo keys name neither a known datum nor an ellipsoid; write the reference system with: gdal_edit.py -a_srs EPSG:CODE FILE")?;
    let flattening = keys.number(key::INVERSE_FLATTENING).filter(|inverse| *inverse != 0.0);
    let minor = keys.number(key::SEMI_MINOR).filter(|minor| *minor > 0.0);

    Ok(match (flattening, minor) {
        (Some(inverse), _) => format!("+a={axis} +rf={inverse}"),
        (None, Some(minor)) => format!("+a={axis} +b={minor}"),
        (None, None) => format!("+R={axis}"),
    })
}
