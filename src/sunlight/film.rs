//! Sun of a film: one for all frames, or one that runs with the flight.

use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use super::{Observatory, Sky, SunSetting};
use hedgehop_base::error::{Error, Result};

/// Milliseconds of a second. Moments are whole ones, so that people can write any; the sun moves by 0.000004° in one.
const MILLISECONDS: f64 = 1000.0;
const NANOSECONDS: i128 = 1_000_000;

/// Sun of a film, as it is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FilmSun {
    /// Stands still.
    Still(SunSetting),
    /// Runs with the flight, by the clock of its path file.
    Track,
    /// Runs with the flight, from this time at the first fix on.
    From(OffsetDateTime),
}

impl FilmSun {
    /// Returns the time of the flight's first fix that it asks for, seconds since 1970-01-01T00:00:00Z.
    pub fn start(&self) -> Option<f64> {
        match self {
            Self::From(time) => Some(time.unix_timestamp() as f64 + f64::from(time.nanosecond()) * 1.0e-9),
            Self::Still(_) | Self::Track => None,
        }
    }
}

/// Sun and stars that run with a flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunningSky {
    observatory: Observatory,
    /// Time of the first fix, seconds since 1970-01-01T00:00:00Z.
    began: f64,
}

impl RunningSky {
    /// Sun and stars over a place, `began` (seconds since 1970-01-01T00:00:00Z) being the time of the flight's first fix.
    pub fn new(observatory: Observatory, began: f64) -> Self {
        Self { observatory, began }
    }

    /// Finds where they stand so many seconds after the first fix, to the millisecond.
    ///
    /// # Errors
    /// As of [`Observatory::sky`].
    pub fn at(&self, seconds: f64) -> Result<Sky> {
        self.observatory.sky(self.time_at(seconds)?)
    }

    /// Returns the time of the first fix (RFC 3339, UTC).
    ///
    /// # Errors
    /// As of [`Observatory::sky`].
    pub fn start(&self) -> Result<String> {
        let time = self.time_at(0.0)?;
        time.format(&Rfc3339).map_err(|_| nowhen(self.began))
    }

    fn time_at(&self, seconds: f64) -> Result<OffsetDateTime> {
        let time = self.began + seconds;
        // A float converts saturating.
        let milliseconds = (MILLISECONDS * time).round() as i64;
        OffsetDateTime::from_unix_timestamp_nanos(i128::from(milliseconds) * NANOSECONDS)
            .map_err(|_| nowhen(time))
    }
}

fn nowhen(seconds: f64) -> Error {
    Error::Configuration(format!(
        "{seconds} s after 1970 is no time that has a sun; check the clock of the path"
    ))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use hedgehop_geo::Crs;
    use time::macros::datetime;

    use super::*;

    #[test]
    fn running_suns_stand_where_those_of_their_moments_do() {
        let (crs, place) = (Crs::wgs84(), DVec2::new(10.0, 47.0));
        let start = datetime!(2026-06-21 03:59:59.25 +2);
        let sky =
            RunningSky::new(Observatory::new(&crs, place).unwrap(), FilmSun::From(start).start().unwrap());
        assert_eq!(sky.start().unwrap(), "2026-06-21T01:59:59.25Z");
        // Rounding of the seconds is not seen.
        for (seconds, time) in [
            (0.0, start),
            (0.750_3, datetime!(2026-06-21 02:00 UTC)),
            (0.1 + 0.2, datetime!(2026-06-21 01:59:59.55 UTC)),
            (86_400.75, datetime!(2026-06-22 02:00 UTC)),
        ] {
            assert_eq!(
                sky.at(seconds).unwrap(),
                SunSetting::Time(time).over(&crs, place).unwrap(),
                "{seconds}"
            );
        }
        assert!(sky.at(1.0e12).is_err() && sky.at(1.0e300).is_err());
    }
}
