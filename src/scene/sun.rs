//! The tables `[sun]` and `[night]`.

use serde::Deserialize;
use time::OffsetDateTime;
use toml::Spanned;
use toml::value::Datetime;

use super::file::Reading;
use super::{NightSky, SunLines};
use crate::error::Result;
use crate::sunlight::{Night, Sun, SunSetting};

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the table [sun]")]
pub(super) struct SunTable {
    azimuth_deg: Option<Spanned<f64>>,
    elevation_deg: Option<Spanned<f64>>,
    time: Option<Spanned<Time>>,
    shadows: Option<Spanned<bool>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, expecting = "the table [night]")]
pub(super) struct NightTable {
    light_lx: Option<Spanned<f64>>,
    stars: Option<bool>,
}

impl NightTable {
    pub fn read(self, reading: &Reading<'_>) -> Result<NightSky> {
        let default = NightSky::default();
        let lux = match &self.light_lx {
            Some(lux) => {
                let is_sound = |lux: f64| (0.0..=Night::BRIGHTEST).contains(&lux);
                reading.number("light_lx", lux, is_sound, "must be 0 to 1000 lx")?
            }
            None => default.lux,
        };
        Ok(NightSky { lux, stars: self.stars.unwrap_or(default.stars) })
    }
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "time must be a date and time with an offset from UTC, 2026-06-21T09:30:00Z")]
enum Time {
    Date(Datetime),
    Text(String),
}

impl SunTable {
    pub fn shadows(&self) -> Option<bool> {
        self.shadows.as_ref().map(|shadows| *shadows.get_ref())
    }

    /// Where the file says so.
    pub fn lines(&self, reading: &Reading<'_>) -> SunLines {
        SunLines {
            time: self.time.as_ref().map(|time| reading.line(&time.span())),
            shadows: self.shadows.as_ref().map(|shadows| reading.line(&shadows.span())),
        }
    }

    /// Where the sun stands, if it says so.
    pub fn read(self, reading: &Reading<'_>) -> Result<Option<SunSetting>> {
        let (azimuth, elevation) = match (self.azimuth_deg, self.elevation_deg, &self.time) {
            (None, None, Some(time)) => return Ok(Some(SunSetting::Time(read_time(reading, time)?))),
            (None, None, None) => return Ok(None),
            (Some(_), _, Some(time)) | (_, Some(_), Some(time)) => {
                return Err(
                    reading.wrong(time.span(), "give time, or azimuth_deg and elevation_deg, not both")
                );
            }
            (Some(azimuth), Some(elevation), None) => (azimuth, elevation),
            (Some(one), None, None) => {
                return Err(reading.wrong(one.span(), "[sun] needs elevation_deg, too"));
            }
            (None, Some(one), None) => return Err(reading.wrong(one.span(), "[sun] needs azimuth_deg, too")),
        };
        Ok(Some(SunSetting::At(Sun {
            azimuth: reading.number(
                "azimuth_deg",
                &azimuth,
                |degrees| degrees.abs() <= 360.0,
                "must lie between -360 and 360 degrees",
            )?,
            elevation: reading.number(
                "elevation_deg",
                &elevation,
                |degrees| degrees.abs() <= 90.0,
                "must be -90 to 90 degrees",
            )?,
        })))
    }
}

/// A date and time with an offset from UTC; as a string, too.
fn read_time(reading: &Reading<'_>, time: &Spanned<Time>) -> Result<OffsetDateTime> {
    let text = match time.get_ref() {
        Time::Date(date) => date.to_string(),
        Time::Text(text) => text.clone(),
    };
    SunSetting::parse_time(&text).ok_or_else(|| {
        let what = format!(
            "time must be a date and time with an offset from UTC, 2026-06-21T09:30:00Z, not {text:?}"
        );
        reading.wrong(time.span(), what)
    })
}
