//! Position of the sun.

use glam::{DVec2, Vec3};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use super::{Firmament, Observatory};
use hedgehop_base::error::Result;
use hedgehop_geo::Crs;

/// Direction to the sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Clockwise from grid north, degrees.
    pub azimuth: f64,
    /// Above the horizon, degrees, -90…90; below 0 it is night.
    pub elevation: f64,
}

/// Optical depth of clear air to the zenith at 610, 550 and 465 nm (Rayleigh; Bucholtz 1995, *Applied Optics* 34, 2765–2773).
const RAYLEIGH: Vec3 = Vec3::new(0.064, 0.098, 0.194);

/// Air masses beyond which sunlight does not redden any more: haze itself hides a lower sun.
const MOST_AIR: f64 = 12.0;

/// Linear Rec. 709 colour of white light that has come through so many air masses, < 0 for none, of which the largest part is 1.
pub fn seen_through(masses: f64) -> Vec3 {
    let seen = (-RAYLEIGH * masses.clamp(0.0, MOST_AIR) as f32).exp();
    seen / seen.max_element()
}

impl Default for Sun {
    /// A mid-morning sun in the south-east.
    fn default() -> Self {
        Self { azimuth: 135.0, elevation: 40.0 }
    }
}

impl Sun {
    /// Whether it stands above the horizon.
    pub fn is_up(&self) -> bool {
        self.elevation > 0.0
    }

    /// Air that its light comes through, as a multiple of that above the place; on the horizon and below it 38 (Kasten and Young 1989, *Applied Optics* 28,
    /// 4735–4738).
    pub fn air_mass(&self) -> f64 {
        let degrees = self.elevation.clamp(0.0, 90.0);
        1.0 / (degrees.to_radians().sin() + 0.505_72 * (degrees + 6.079_95).powf(-1.6364))
    }

    /// Unit vector to the sun, world axes.
    pub fn direction(&self) -> Vec3 {
        let (sin_azimuth, cos_azimuth) = self.azimuth.to_radians().sin_cos();
        let (sin_elevation, cos_elevation) = self.elevation.to_radians().sin_cos();
        Vec3::new(
            (sin_azimuth * cos_elevation) as f32,
            (cos_azimuth * cos_elevation) as f32,
            sin_elevation as f32,
        )
    }
}

/// Sun, stars and lamps over a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sky {
    /// The sun.
    pub sun: Sun,
    /// The stars.
    pub firmament: Firmament,
}

/// Light besides that of the sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Night {
    /// Illuminance of level ground by moon, and by the lamps of the land about, lx, 0…1000.
    pub lux: f64,
    /// Stand of the stars; `None`: there are none.
    pub stars: Option<Firmament>,
}

impl Default for Night {
    /// Some moonlight, and no stars.
    fn default() -> Self {
        Self { lux: 0.1, stars: None }
    }
}

impl Night {
    /// Brightest that a night may be, lx: the end of a day.
    pub const BRIGHTEST: f64 = 1000.0;

    /// Whether its values lie within their ranges.
    pub fn is_sound(&self) -> bool {
        let of_stars = |stars: &Firmament| [stars.sidereal, stars.latitude, stars.convergence];
        (0.0..=Self::BRIGHTEST).contains(&self.lux)
            && self.stars.as_ref().is_none_or(|stars| of_stars(stars).into_iter().all(f64::is_finite))
    }
}

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
