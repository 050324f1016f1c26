//! The sun as files tell it.

use std::ops::Range;

use serde::Deserialize;
use time::OffsetDateTime;
use toml::Spanned;
use toml::value::Datetime;

use super::{Sun, SunSetting};
use hedgehop_base::document::Reading;

/// Says that a sun has a time and angles.
pub const BOTH: &str = "give time, or azimuth_deg and elevation_deg, not both";

/// A date and time, or what may be one.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "time must be a date and time with an offset from UTC, 2026-06-21T09:30:00Z")]
pub enum Time {
    /// Date as TOML has it.
    Date(Datetime),
    /// Date in quotation marks.
    Text(String),
}

impl Time {
    /// Whether it is a word in quotation marks.
    pub fn is(&self, word: &str) -> bool {
        matches!(self, Self::Text(text) if text == word)
    }
}

/// Fault of a value, and where that stands.
type Wrong = (Range<usize>, String);

/// Reads where a table says that the sun stands, by angles (degrees) or by a time; `None`: it does not.
///
/// # Errors
/// Both, half of the angles, or values that make no sense.
pub fn sun(
    table: &str,
    azimuth: Option<Spanned<f64>>,
    elevation: Option<Spanned<f64>>,
    time: Option<Spanned<Time>>,
) -> Result<Option<SunSetting>, Wrong> {
    let (azimuth, elevation) = match (azimuth, elevation, &time) {
        (None, None, Some(time)) => return Ok(Some(SunSetting::Time(read_time(time)?))),
        (None, None, None) => return Ok(None),
        (Some(_), _, Some(time)) | (_, Some(_), Some(time)) => {
            return Err((time.span(), BOTH.to_owned()));
        }
        (Some(azimuth), Some(elevation), None) => (azimuth, elevation),
        (Some(one), None, None) => {
            return Err((one.span(), format!("{table} needs elevation_deg, too")));
        }
        (None, Some(one), None) => {
            return Err((one.span(), format!("{table} needs azimuth_deg, too")));
        }
    };

    let degrees = |key: &str, value: &Spanned<f64>, most: f64, want: &str| {
        let checked = Reading::checked(key, *value.get_ref(), |degrees| degrees.abs() <= most, want);
        checked.map_err(|what| (value.span(), what))
    };

    Ok(Some(SunSetting::At(Sun {
        azimuth: degrees("azimuth_deg", &azimuth, 360.0, "must lie between -360 and 360 degrees")?,
        elevation: degrees("elevation_deg", &elevation, 90.0, "must be -90 to 90 degrees")?,
    })))
}

/// A date and time with an offset from UTC; as a string, too.
fn read_time(time: &Spanned<Time>) -> Result<OffsetDateTime, Wrong> {
    let text = match time.get_ref() {
        Time::Date(date) => date.to_string(),
        Time::Text(text) => text.clone(),
    };
    SunSetting::parse_time(&text).ok_or_else(|| {
        let what = format!(
            "time must be a date and time with an offset from UTC, 2026-06-21T09:30:00Z, not {text:?}"
        );
        (time.span(), what)
    })
}
