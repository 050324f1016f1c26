//! Map projections by method and parameters, as WKT and GeoTIFF keys give them, turned into PROJ terms.
//!
//! Methods and their parameters after IOGP Guidance Note 373-7-2 (*Coordinate Conversions and
//! Transformations including Formulas*); PROJ's terms after its projection pages.

use std::fmt::Write;

/// Conversion that is offered where a projection is not read.
pub(super) const CONVERT: &str = "convert the data with: gdalwarp -t_srs EPSG:4326 IN OUT.tif";

/// Scale factors that a map can have.
const SCALES: std::ops::Range<f64> = 0.5..2.0;

/// A way to project.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Method {
    TransverseMercator,
    /// Transverse Mercator that counts to the west and south.
    SouthOrientated,
    /// Krovak that counts to the south and west.
    Krovak,
    /// Krovak that counts to the east and north, in negative numbers.
    KrovakNorth,
    /// One or two standard parallels, by which are given.
    LambertConformal,
    Albers,
    LambertAzimuthal,
    /// Scale at the equator, or a latitude of true scale.
    Mercator,
    WebMercator,
    /// Latitude of origin is a pole, or the latitude of true scale.
    PolarStereographic,
    ObliqueStereographic,
    Stereographic,
    EquidistantCylindrical,
    /// Origin at the natural origin (EPSG variant A).
    ObliqueMercatorA,
    /// Origin at the centre (EPSG variant B).
    ObliqueMercatorB,
    SwissOblique,
    AzimuthalEquidistant,
    EquidistantConic,
    CylindricalEqualArea,
    Cassini,
    Polyconic,
    Sinusoidal,
}

/// Parameter of a projection: angles in degrees, lengths in metres, ratios.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Term {
    Latitude,
    Longitude,
    Parallel1,
    Parallel2,
    Scale,
    Azimuth,
    RectifiedAngle,
    FalseEasting,
    FalseNorthing,
}

const TERMS: usize = 9;

/// Parameters of a projection.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Parameters([Option<f64>; TERMS]);

impl Parameters {
    pub(super) fn set(&mut self, term: Term, value: f64) {
        self.0[term as usize] = Some(value);
    }

    pub(super) fn get(&self, term: Term) -> Option<f64> {
        self.0[term as usize]
    }

    fn or(&self, term: Term, default: f64) -> f64 {
        self.get(term).unwrap_or(default)
    }
}

/// PROJ's terms of a projection (`+proj=tmerc +lat_0=…`), without datum and unit.
pub(super) fn proj_terms(method: Method, given: &Parameters) -> Result<String, String> {
    if given.0.iter().flatten().any(|value| !value.is_finite()) {
        return Err(
            "a parameter of the projection is not a finite number; repair the file's reference system".into(),
        );
    }

    let latitude = given.or(Term::Latitude, 0.0);
    let first = given.get(Term::Parallel1);
    let scale = given.or(Term::Scale, 1.0);
    if !SCALES.contains(&scale) {
        return Err(format!("a projection with a scale factor of {scale} is no map's; {CONVERT}"));
    }

    // Krovak's axes are turned by the method itself.
    let turned = given.or(Term::RectifiedAngle, 0.0);
    let takes_turn = matches!(
        method,
        Method::ObliqueMercatorA | Method::ObliqueMercatorB | Method::Krovak | Method::KrovakNorth
    );
    if turned != 0.0 && !takes_turn {
        return Err(format!("a projection whose axes are turned by {turned}° is not read; {CONVERT}"));
    }

    let mut words = match method {
        Method::TransverseMercator | Method::SouthOrientated => {
            format!("+proj=tmerc +lat_0={latitude} +k={scale}")
        }
        Method::Krovak | Method::KrovakNorth => krovak(given)?,
        Method::LambertConformal => lambert_conformal(given)?,
        Method::Albers => conic("aea", given)?,
        Method::EquidistantConic => conic("eqdc", given)?,
        Method::LambertAzimuthal => format!("+proj=laea +lat_0={latitude}"),
        Method::AzimuthalEquidistant => format!("+proj=aeqd +lat_0={latitude}"),
        Method::Mercator => match first {
            Some(parallel) => format!("+proj=merc +lat_ts={parallel}"),
            // Some writers put the latitude of true scale where the origin belongs.
            None if latitude != 0.0 && given.get(Term::Scale).is_none_or(|k| k == 1.0) => {
                format!("+proj=merc +lat_ts={latitude}")
            }
            None => format!("+proj=merc +k={scale}"),
        },
        Method::WebMercator => "+proj=webmerc".to_owned(),
        Method::PolarStereographic => polar_stereographic(given)?,
        Method::ObliqueStereographic => format!("+proj=sterea +lat_0={latitude} +k={scale}"),
        Method::Stereographic => format!("+proj=stere +lat_0={latitude} +k={scale}"),
        Method::EquidistantCylindrical => {
            format!("+proj=eqc +lat_ts={} +lat_0={latitude}", first.unwrap_or(0.0))
        }
        Method::CylindricalEqualArea => format!("+proj=cea +lat_ts={}", first.unwrap_or(0.0)),
        Method::ObliqueMercatorA | Method::ObliqueMercatorB => oblique_mercator(method, given)?,
        Method::SwissOblique => format!("+proj=somerc +lat_0={latitude} +k_0={scale}"),
        Method::Cassini => format!("+proj=cass +lat_0={latitude}"),
        Method::Polyconic => format!("+proj=poly +lat_0={latitude}"),
        Method::Sinusoidal => "+proj=sinu".to_owned(),
    };

    let longitude = if words.starts_with("+proj=omerc") { "lonc" } else { "lon_0" };
    let (x, y) = (given.or(Term::FalseEasting, 0.0), given.or(Term::FalseNorthing, 0.0));

    // Writing to a String cannot fail.
    let _ = write!(words, " +{longitude}={} +x_0={x} +y_0={y}", given.or(Term::Longitude, 0.0));
    Ok(words)
}

fn lambert_conformal(given: &Parameters) -> Result<String, String> {
    let latitude = given.or(Term::Latitude, 0.0);
    let scale = given.or(Term::Scale, 1.0);
    match (given.get(Term::Parallel1), given.get(Term::Parallel2)) {
        (Some(one), Some(two)) => {
            Ok(format!("+proj=lcc +lat_1={one} +lat_2={two} +lat_0={latitude} +k_0={scale}"))
        }
        (Some(one), None) => Ok(format!("+proj=lcc +lat_1={one} +lat_0={latitude} +k_0={scale}")),
        _ => match given.get(Term::Latitude) {
            Some(origin) => Ok(format!("+proj=lcc +lat_1={origin} +lat_0={origin} +k_0={scale}")),
            None => {
                Err("a Lambert conformal projection without parallels; repair the file's reference system"
                    .into())
            }
        },
    }
}

fn conic(name: &str, given: &Parameters) -> Result<String, String> {
    let first = given.get(Term::Parallel1);
    let first =
        first.ok_or("a conic projection without standard parallels; repair the file's reference system")?;
    let second = given.or(Term::Parallel2, first);
    Ok(format!("+proj={name} +lat_1={first} +lat_2={second} +lat_0={}", given.or(Term::Latitude, 0.0)))
}

fn polar_stereographic(given: &Parameters) -> Result<String, String> {
    let latitude = given.get(Term::Parallel1).or(given.get(Term::Latitude));
    let latitude = latitude
        .ok_or("a polar stereographic projection without latitude; repair the file's reference system")?;
    let pole = if latitude < 0.0 || given.get(Term::Latitude).is_some_and(|origin| origin < 0.0) {
        -90.0
    } else {
        90.0
    };
    if latitude.abs() == 90.0 {
        return Ok(format!("+proj=stere +lat_0={pole} +k={}", given.or(Term::Scale, 1.0)));
    }
    Ok(format!("+proj=stere +lat_0={pole} +lat_ts={latitude}"))
}

/// The pseudo standard parallel is the one of the only map that uses it; others are not read.
fn krovak(given: &Parameters) -> Result<String, String> {
    const PARALLEL: f64 = 78.5;
    let parallel = given.or(Term::Parallel1, PARALLEL);
    if (parallel - PARALLEL).abs() > 1e-9 {
        return Err(format!(
            "a Krovak projection with a pseudo standard parallel of {parallel} is not read; {CONVERT}"
        ));
    }
    let azimuth = given.or(Term::Azimuth, 30.288_139_752_777_8);
    let latitude = given.or(Term::Latitude, 49.5);
    Ok(format!("+proj=krovak +lat_0={latitude} +alpha={azimuth} +k={}", given.or(Term::Scale, 0.9999)))
}

fn oblique_mercator(method: Method, given: &Parameters) -> Result<String, String> {
    let latitude = given.or(Term::Latitude, 0.0);
    let scale = given.or(Term::Scale, 1.0);
    let azimuth = given
        .get(Term::Azimuth)
        .ok_or("an oblique Mercator projection without azimuth; repair the file's reference system")?;
    let angle = given.or(Term::RectifiedAngle, azimuth);
    if azimuth == 90.0 && angle == 90.0 {
        return Ok(format!("+proj=somerc +lat_0={latitude} +k_0={scale}"));
    }
    let origin = if method == Method::ObliqueMercatorA { " +no_uoff" } else { "" };
    Ok(format!("+proj=omerc +lat_0={latitude} +alpha={azimuth} +gamma={angle} +k={scale}{origin}"))
}
