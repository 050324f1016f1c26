//! From one horizontal system to another.
//!
//! [`proj4rs`] works in radians, and knows neither identity nor a domain; both are added here.

use proj4rs::Proj;

use super::crs::Crs;
use crate::error::{Error, Result};

/// How far a latitude may pass the pole by rounding, degrees (0.1 mm).
const POLE_SLACK: f64 = 1e-9;

/// Step along the meridian from which the direction of north is taken, degrees of latitude (about 11 m).
const NORTH_STEP: f64 = 1e-4;

/// Takes positions from one system to another.
#[derive(Debug)]
pub struct Transform {
    /// `None` where positions pass unchanged.
    systems: Option<Box<Systems>>,
    /// Where geographic results shall lie: within 180° of this longitude.
    centre: Option<f64>,
}

#[derive(Debug)]
struct Systems {
    from: Side,
    to: Side,
}

#[derive(Debug)]
struct Side {
    proj: Proj,
    degrees: bool,
}

impl Side {
    fn new(crs: &Crs) -> Result<Self> {
        let definition = crs.definition().ok_or_else(|| {
            Error::Configuration(format!(
                "'{}' is not placed on Earth; give its reference system with --crs",
                crs.name()
            ))
        })?;
        let proj = definition.load().map_err(Error::Configuration)?;
        Ok(Self { proj, degrees: definition.is_geographic() })
    }
}

impl Transform {
    /// From `from` to `to`; an error if one of them is local and the other not.
    pub fn new(from: &Crs, to: &Crs) -> Result<Self> {
        if from.is_local() != to.is_local() {
            let placed = if from.is_local() { to } else { from };
            return Err(Error::Configuration(format!(
                "local coordinates have no place in {}; give the reference system with --crs, or take all inputs as plain metres with --local",
                placed.name()
            )));
        }
        if from.is_equivalent(to) {
            return Ok(Self { systems: None, centre: None });
        }
        let systems = Systems { from: Side::new(from)?, to: Side::new(to)? };
        Ok(Self { systems: Some(Box::new(systems)), centre: None })
    }

    /// Puts geographic results within 180° of `longitude` (degrees), for a raster whose longitudes run from 0
    /// to 360 or across the 180th meridian. Without effect if the target is not geographic.
    pub fn centred_on(mut self, longitude: f64) -> Self {
        let geographic = self.systems.as_ref().is_some_and(|systems| systems.to.degrees);
        self.centre = (geographic && longitude.is_finite()).then_some(longitude);
        self
    }

    /// The position in the target system, or `None` where there is none (outside the projection's domain).
    /// Longitude and latitude in degrees. Never NaN, never infinite. Between equivalent systems every finite
    /// position passes unchanged, be it on Earth or not.
    pub fn apply(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        if !(x.is_finite() && y.is_finite()) {
            return None;
        }
        let Some(systems) = &self.systems else { return Some((x, y)) };
        let mut point = (x, y, 0.0);
        if systems.from.degrees {
            point = (x.to_radians(), on_earth(y)?.to_radians(), 0.0);
        }
        proj4rs::transform::transform(&systems.from.proj, &systems.to.proj, &mut point).ok()?;
        let (mut x, mut y, _) = point;
        if systems.to.degrees {
            (x, y) = (x.to_degrees(), on_earth(y.to_degrees())?);
            if let Some(centre) = self.centre {
                x -= ((x - centre) / 360.0).round() * 360.0;
            }
        }
        (x.is_finite() && y.is_finite()).then_some((x, y))
    }

    /// Transforms many positions in place; one that has none in the target becomes NaN, NaN.
    pub fn apply_many(&self, points: &mut [(f64, f64)]) {
        for point in points {
            *point = self.apply(point.0, point.1).unwrap_or((f64::NAN, f64::NAN));
        }
    }

    /// Whether both systems are the same, so that positions pass unchanged.
    pub fn is_identity(&self) -> bool {
        self.systems.is_none()
    }
}

/// A latitude in degrees within ±90, or `None` beyond (NaN too).
fn on_earth(latitude: f64) -> Option<f64> {
    (latitude.abs() <= 90.0 + POLE_SLACK).then(|| latitude.clamp(-90.0, 90.0))
}

/// Degrees to add to a heading from true north, so that it counts from the grid's north, at a position of
/// `crs`. 0 for local and geographic systems, and where the position is none on Earth.
pub fn grid_convergence(crs: &Crs, x: f64, y: f64) -> f64 {
    GridNorth::new(crs).map_or(0.0, |north| north.convergence(x, y))
}

/// [`grid_convergence`] for many positions of one system.
#[derive(Debug)]
pub struct GridNorth {
    /// To and from WGS 84; `None` where true north is grid north everywhere.
    transforms: Option<(Transform, Transform)>,
}

impl GridNorth {
    /// For a system; an error if it cannot be computed.
    pub fn new(crs: &Crs) -> Result<Self> {
        if crs.is_local() || crs.is_geographic() {
            return Ok(Self { transforms: None });
        }
        let wgs84 = Crs::wgs84();
        Ok(Self { transforms: Some((Transform::new(crs, &wgs84)?, Transform::new(&wgs84, crs)?)) })
    }

    /// Degrees to add to a heading from true north at a position, −180 to 180.
    pub fn convergence(&self, x: f64, y: f64) -> f64 {
        let Some((to_geographic, from_geographic)) = &self.transforms else { return 0.0 };
        let Some((longitude, latitude)) = to_geographic.apply(x, y) else { return 0.0 };
        // Towards the pole that is farther away, so that the step never crosses one.
        let step = if latitude > 0.0 { -NORTH_STEP } else { NORTH_STEP };
        let ends =
            from_geographic.apply(longitude, latitude).zip(from_geographic.apply(longitude, latitude + step));
        let Some(((x0, y0), (x1, y1))) = ends else { return 0.0 };
        let sign = step.signum();
        let (east, north) = (sign * (x1 - x0), sign * (y1 - y0));
        east.atan2(north).to_degrees()
    }
}
