//! Position of the sun as it is asked for.

use glam::DVec2;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use super::{Firmament, Observatory, Sky, Sun};
use hedgehop_base::error::Result;
use hedgehop_geo::Crs;

/// Request for a sun, by angles or by time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SunSetting {
    /// Sun at these angles.
    At(Sun),
    /// Sun of a moment.
    Time(OffsetDateTime),
}

impl SunSetting {
    /// A date and time with an offset from UTC (RFC 3339; seconds may be left out).
    pub fn parse_time(text: &str) -> Option<OffsetDateTime> {
        let parse = |text: &str| OffsetDateTime::parse(text, &Rfc3339).ok();
        let with_seconds = |text: &str| {
            // 2026-06-21T09:30Z
            let (minutes, offset) = text.split_at_checked(16)?;
            parse(&format!("{minutes}:00{offset}"))
        };
        parse(text).or_else(|| with_seconds(text))
    }

    /// Finds sun and stars over a place of `crs` (its metres or degrees), by time as [`Observatory::sky`] does.
    ///
    /// # Errors
    /// As of [`Observatory::new`] and [`Observatory::sky`], where it is asked for by time.
    pub fn over(&self, crs: &Crs, place: DVec2) -> Result<Sky> {
        match self {
            Self::At(sun) => Ok(Sky { sun: *sun, firmament: Firmament::default() }),
            Self::Time(time) => Observatory::new(crs, place)?.sky(*time),
        }
    }
}

#[cfg(test)]
mod tests {
    use hedgehop_geo::Transform;
    use time::macros::datetime;

    use super::*;

    fn over(time: OffsetDateTime, longitude: f64, latitude: f64) -> Result<Sun> {
        SunSetting::Time(time).over(&Crs::wgs84(), DVec2::new(longitude, latitude)).map(|sky| sky.sun)
    }

    #[test]
    fn the_example_of_the_algorithm_is_met() {
        // Reda and Andreas 2004, table A5.1: azimuth 194.34024°, zenith angle 50.11162° with refraction at 820 hPa, 1830 m; at sea level refraction is
        // a little more than that.
        let sun = over(datetime!(2003-10-17 12:30:30 -7), -105.1786, 39.742_476).unwrap();
        assert!((sun.azimuth - 194.340_24).abs() < 1e-3, "{sun:?}");
        assert!((sun.elevation - (90.0 - 50.111_62)).abs() < 0.01, "{sun:?}");
    }

    #[test]
    fn times_are_those_of_rfc_3339() {
        let parse = SunSetting::parse_time;
        assert_eq!(parse("2026-06-21T09:30:15Z"), Some(datetime!(2026-06-21 09:30:15 UTC)));
        assert_eq!(parse("2026-06-21T09:30+02:00"), Some(datetime!(2026-06-21 07:30 UTC)));
        let wrong =
            ["2026-06-21", "2026-06-21T09:30:00", "2026-13-21T09:30Z", "noon", "2026-06-21T09:3é", ""];
        assert!(wrong.into_iter().all(|text| parse(text).is_none()));
    }

    #[test]
    fn azimuths_count_from_grid_north() {
        // Five degrees east of the zone's middle, where its north lies to the east of true north.
        let utm = Crs::from_epsg(32632).unwrap();
        let place = Transform::new(&Crs::wgs84(), &utm).unwrap().apply(14.0, 47.5).unwrap();
        let time = datetime!(2026-06-21 09:00 UTC);
        let [on_grid, on_earth] = [
            SunSetting::Time(time).over(&utm, place.into()).unwrap().sun.azimuth,
            over(time, 14.0, 47.5).unwrap().azimuth,
        ];
        // Meridian convergence, closely: difference of longitude times the sine of latitude.
        let convergence = 5.0 * 47.5_f64.to_radians().sin();
        assert!((on_earth - on_grid - convergence).abs() < 0.02, "{on_grid} {on_earth}");
    }

    #[test]
    fn nights_have_a_sun_below_the_horizon_and_places_that_are_nowhere_are_told() {
        let night = over(datetime!(2026-06-21 00:00 UTC), 10.0, 47.0).unwrap();
        // Midsummer at 47° N: as far below as the obliquity leaves of the colatitude, at true midnight.
        assert!(!night.is_up() && (night.elevation - (23.44 - 43.0)).abs() < 1.0, "{night:?}");
        for (time, year) in [(datetime!(9999-06-21 12:00 UTC), 9999), (datetime!(3000-01-01 12:00 UTC), 3000)]
        {
            let far = over(time, 10.0, 47.0).unwrap_err().to_string();
            assert!(far.contains(&format!("the year {year} is none of -500 to 2999")), "{far}");
        }
        assert!(over(datetime!(2999-12-31 12:00 UTC), 10.0, 47.0).is_ok());
        let nowhere = SunSetting::Time(datetime!(2026-06-21 12:00 UTC)).over(&Crs::local(), DVec2::ZERO);
        assert!(nowhere.unwrap_err().to_string().contains("--crs"));
    }
}
