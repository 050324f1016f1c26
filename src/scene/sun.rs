//! The table `[sun]`.

use serde::Deserialize;
use toml::Spanned;

use super::file::Reading;
use crate::error::Result;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the table [sun]")]
pub(super) struct SunTable {
    azimuth_deg: Option<Spanned<f64>>,
    elevation_deg: Option<Spanned<f64>>,
    shadows: Option<bool>,
}

impl SunTable {
    pub fn shadows(&self) -> Option<bool> {
        self.shadows
    }

    /// Azimuth and elevation, degrees, if it says where the sun stands.
    pub fn read(self, reading: &Reading<'_>) -> Result<Option<[f64; 2]>> {
        let (azimuth, elevation) = match (self.azimuth_deg, self.elevation_deg) {
            (Some(azimuth), Some(elevation)) => (azimuth, elevation),
            (None, None) => return Ok(None),
            (Some(one), None) => return Err(reading.wrong(one.span(), "[sun] needs elevation_deg, too")),
            (None, Some(one)) => return Err(reading.wrong(one.span(), "[sun] needs azimuth_deg, too")),
        };
        Ok(Some([
            reading.number("azimuth_deg", &azimuth, |_| true, "must be finite")?,
            reading.number(
                "elevation_deg",
                &elevation,
                |degrees| degrees > 0.0 && degrees <= 90.0,
                "must be more than 0 and at most 90 degrees",
            )?,
        ]))
    }
}
