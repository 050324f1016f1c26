//! The tables `[sun]` and `[night]`.

use serde::Deserialize;
use toml::Spanned;

use super::{NightSky, SunLines};
use crate::sunlight::written::{self, BOTH};
use crate::sunlight::{FilmSun, Night, SunSetting};
use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the table [sun]")]
pub(super) struct SunTable {
    azimuth_deg: Option<Spanned<f64>>,
    elevation_deg: Option<Spanned<f64>>,
    time: Option<Spanned<written::Time>>,
    runs: Option<Spanned<bool>>,
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

impl SunTable {
    pub fn shadows(&self) -> Option<bool> {
        self.shadows.as_ref().map(|shadows| *shadows.get_ref())
    }

    /// Returns the lines of the file that say so.
    pub fn lines(&self, reading: &Reading<'_>) -> SunLines {
        SunLines {
            time: self.time.as_ref().map(|time| reading.line(&time.span())),
            shadows: self.shadows.as_ref().map(|shadows| reading.line(&shadows.span())),
        }
    }

    /// Reads the position of the sun, if it says so.
    pub fn read(self, reading: &Reading<'_>) -> Result<Option<FilmSun>> {
        let runs = self.runs.filter(|runs| *runs.get_ref());
        if let Some(time) = self.time.as_ref().filter(|time| time.get_ref().is("track")) {
            return match (self.azimuth_deg.or(self.elevation_deg), runs) {
                (Some(_), _) => Err(reading.wrong(time.span(), BOTH.to_owned())),
                (None, Some(runs)) => {
                    let what = "the sun of time = \"track\" runs as it is; leave runs out";
                    Err(reading.wrong(runs.span(), what.to_owned()))
                }
                (None, None) => Ok(Some(FilmSun::Track)),
            };
        }

        let read = written::sun("[sun]", self.azimuth_deg, self.elevation_deg, self.time);
        let still = read.map_err(|(span, what)| reading.wrong(span, what))?;
        match (still, runs) {
            (still, None) => Ok(still.map(FilmSun::Still)),
            (Some(SunSetting::Time(time)), Some(_)) => Ok(Some(FilmSun::From(time))),
            (_, Some(runs)) => {
                let what = "runs needs time: that of the flight's first fix";
                Err(reading.wrong(runs.span(), what.to_owned()))
            }
        }
    }
}
