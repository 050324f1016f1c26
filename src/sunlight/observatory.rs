//! Sun and stars over a place on Earth, at any time.

use std::ops::RangeInclusive;

use glam::DVec2;
use solar_positioning::time::JulianDate;
use solar_positioning::{Location, RefractionCorrection, SolarPositions, delta_t};
use time::OffsetDateTime;

use super::{Firmament, Sky, Sun};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Crs, Transform, grid_convergence};

/// Julian date of the second from which the system counts, and seconds of a day.
const UNIX_EPOCH: f64 = 2_440_587.5;
const DAY: f64 = 86_400.0;

/// Julian date of the epoch of star catalogues; hour angle of the equinox at Greenwich then, degrees, and how far it goes in a day of universal time (IAU 1982).
const J2000: f64 = 2_451_545.0;
const SIDEREAL_AT_J2000: f64 = 280.460_618_37;
const SIDEREAL_PER_DAY: f64 = 360.985_647_366_29;

/// Years for which the Earth's turning is estimated; the algorithm itself holds longer.
const YEARS: RangeInclusive<i32> = -500..=2999;

/// Place on Earth that sun and stars are seen from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observatory {
    /// Degrees, east.
    longitude: f64,
    /// Degrees, north.
    latitude: f64,
    /// Grid north from true north, degrees, as it is added to azimuths.
    convergence: f64,
}

impl Observatory {
    /// A place of `crs`, in its metres or degrees.
    ///
    /// # Errors
    /// [`Error::Configuration`]: no place on Earth.
    pub fn new(crs: &Crs, place: DVec2) -> Result<Self> {
        if crs.is_local() {
            let what = "the area is not placed on Earth; give the sun's azimuth and elevation, or build the area with --crs";
            return Err(wrong(what));
        }

        let (longitude, latitude) =
            Transform::new(crs, &Crs::wgs84())?.apply(place.x, place.y).ok_or_else(|| {
                wrong(format!("{}, {} of {} is no place on Earth", place.x, place.y, crs.name()))
            })?;
        Ok(Self { longitude, latitude, convergence: grid_convergence(crs, place.x, place.y) })
    }

    /// Finds sun and stars at a time as the Solar Position Algorithm says (Reda and Andreas 2004), lifted by refraction, azimuths from grid north.
    ///
    /// # Errors
    /// [`Error::Configuration`]: a time outside the years -500 to 2999.
    pub fn sky(&self, time: OffsetDateTime) -> Result<Sky> {
        let Self { longitude, latitude, convergence } = *self;
        let utc = time.to_utc();
        if !YEARS.contains(&utc.year()) {
            return Err(wrong(format!(
                "the year {} is none of {} to {}, for which it is computed",
                utc.year(),
                YEARS.start(),
                YEARS.end()
            )));
        }

        let late =
            delta_t::estimate_from_date(utc.year(), u32::from(u8::from(utc.month()))).map_err(wrong)?;
        let seconds = utc.unix_timestamp() as f64 + f64::from(utc.nanosecond()) * 1.0e-9;
        let moment = JulianDate::new(UNIX_EPOCH + seconds / DAY, late).map_err(wrong)?;
        let location = Location { latitude, longitude: (longitude + 180.0).rem_euclid(360.0) - 180.0 };
        let position = SolarPositions::new()
            .at_from_julian(moment, location, 0.0, Some(RefractionCorrection::standard()))
            .map_err(wrong)?;
        let azimuth = (position.azimuth() + convergence).rem_euclid(360.0);
        let sun = Sun { azimuth, elevation: position.elevation_angle() };

        let days = UNIX_EPOCH + seconds / DAY - J2000;
        let sidereal = SIDEREAL_AT_J2000 + SIDEREAL_PER_DAY * days + longitude;
        let firmament = Firmament { sidereal: sidereal.rem_euclid(360.0), latitude, convergence };
        Ok(Sky { sun, firmament })
    }
}

fn wrong(what: impl std::fmt::Display) -> Error {
    Error::Configuration(format!("the sun by time: {what}"))
}
