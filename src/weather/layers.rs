//! Matter in the air of a scene: glow, fog, clouds.

use std::ops::RangeInclusive;

use serde::Deserialize;
use toml::Spanned;

use crate::weather::{GroundCover, Precipitation};
use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;

/// Metres above or below the datum beyond which there is no weather.
const HIGHEST: f64 = 100_000.0;

/// Metres that clouds may be deep, and that may lie from one to the next.
const CLOUD_DEPTHS: RangeInclusive<f64> = 10.0..=20_000.0;
const CLOUD_SCALES: RangeInclusive<f64> = 100.0..=100_000.0;

/// Metres per second of the strongest wind.
const FASTEST: f64 = 1000.0;

/// Visibility in clouds that say nothing of it, and from one to the next, metres.
const CLOUD_VISIBILITY: f64 = 120.0;
const CLOUD_SCALE: f64 = 2000.0;

/// Depth of the upper edge of fog that says nothing of it, metres.
const SOFT_TOP: f64 = 20.0;

/// Matter in the air besides haze. The default is nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Weather {
    /// Brightening of haze, fog and the sky's horizon towards the sun, 0 (not at all) … 1.
    pub glow: f64,
    /// A layer of fog.
    pub fog: Option<Fog>,
    /// A layer of clouds.
    pub clouds: Option<Clouds>,
    /// Rain or snow.
    pub precipitation: Option<Precipitation>,
    /// Cover of the ground.
    pub ground: GroundCover,
}

/// Clouds between two heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clouds {
    /// Height of the base, metres above the database's datum, 10⁵ at most either way.
    pub base: f64,
    /// Height of the top, metres above the datum: 10 m to 20 km above the base.
    pub top: f64,
    /// Share of the sky that is cloudy, 0…1.
    pub coverage: f64,
    /// Meteorological visibility where clouds are densest, metres, 1…10⁶.
    pub visibility: f64,
    /// Distance from cloud to cloud, metres, 100…10⁵.
    pub scale: f64,
    /// Seed that picks one sky of clouds among many.
    pub seed: u32,
    /// Velocity eastward and northward, metres per second, 1000 at most.
    pub wind: [f64; 2],
}

/// Fog that fills the air below a height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fog {
    /// Height of its upper edge's middle, metres above the database's datum, 10⁵ at most either way.
    pub top: f64,
    /// Meteorological visibility inside, haze included, metres, 1…10⁶.
    pub visibility: f64,
    /// Height over which the upper edge fades, half above `top` and half below, metres, 1…10⁵.
    pub soft: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the table [fog]")]
pub(crate) struct FogTable {
    top_m: Spanned<f64>,
    visibility_m: Spanned<f64>,
    soft_m: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the table [clouds]")]
pub(crate) struct CloudsTable {
    base_m: Spanned<f64>,
    top_m: Spanned<f64>,
    coverage: Spanned<f64>,
    visibility_m: Option<Spanned<f64>>,
    scale_m: Option<Spanned<f64>>,
    seed: Option<u32>,
    wind_mps: Option<Spanned<Vec<f64>>>,
}

impl Weather {
    /// Whether all values are within their ranges.
    pub fn is_sound(&self) -> bool {
        let fog = |fog: &Fog| fog.top.abs() <= HIGHEST && is_visibility(fog.visibility) && is_depth(fog.soft);
        let clouds = |clouds: &Clouds| {
            clouds.base.abs() <= HIGHEST
                && CLOUD_DEPTHS.contains(&(clouds.top - clouds.base))
                && is_share(clouds.coverage)
                && is_visibility(clouds.visibility)
                && CLOUD_SCALES.contains(&clouds.scale)
                && clouds.wind.into_iter().all(is_wind)
        };
        is_share(self.glow)
            && self.fog.as_ref().is_none_or(fog)
            && self.clouds.as_ref().is_none_or(clouds)
            && self.precipitation.as_ref().is_none_or(Precipitation::is_sound)
            && self.ground.is_sound()
    }
}

fn is_share(share: f64) -> bool {
    (0.0..=1.0).contains(&share)
}

fn is_wind(speed: f64) -> bool {
    speed.abs() <= FASTEST
}

/// Metres that may be seen inside of fog or clouds.
fn is_visibility(metres: f64) -> bool {
    (1.0..=1.0e6).contains(&metres)
}

/// Metres that a layer may be deep.
fn is_depth(metres: f64) -> bool {
    (1.0..=HIGHEST).contains(&metres)
}

impl FogTable {
    pub(crate) fn read(&self, reading: &Reading<'_>) -> Result<Fog> {
        let soft = self.soft_m.as_ref();
        let soft = soft.map(|soft| reading.number("soft_m", soft, is_depth, "must be 1 to 100,000 m"));
        Ok(Fog {
            top: height(reading, "top_m", &self.top_m)?,
            visibility: reading.number(
                "visibility_m",
                &self.visibility_m,
                is_visibility,
                "of fog must be 1 to 1,000,000 m",
            )?,
            soft: soft.transpose()?.unwrap_or(SOFT_TOP),
        })
    }
}

impl CloudsTable {
    pub(crate) fn read(&self, reading: &Reading<'_>) -> Result<Clouds> {
        let base = height(reading, "base_m", &self.base_m)?;
        let is_top = |top: f64| CLOUD_DEPTHS.contains(&(top - base));
        let top = reading.number("top_m", &self.top_m, is_top, "must lie 10 m to 20 km above base_m")?;
        let visibility = self.visibility_m.as_ref().map(|metres| {
            reading.number("visibility_m", metres, is_visibility, "of clouds must be 1 to 1,000,000 m")
        });
        let scale = self.scale_m.as_ref().map(|metres| {
            let holds = |metres| CLOUD_SCALES.contains(&metres);
            reading.number("scale_m", metres, holds, "must be 100 m to 100 km")
        });

        let wind = self.wind_mps.as_ref().map(|given| {
            let wind: [f64; 2] = reading.numbers("wind_mps", given)?;
            if wind.into_iter().all(is_wind) {
                return Ok(wind);
            }
            let what = format!("wind_mps must be two speeds of {FASTEST} m/s at most, not {wind:?}");
            Err(reading.wrong(given.span(), what))
        });

        Ok(Clouds {
            base,
            top,
            coverage: reading.number("coverage", &self.coverage, is_share, "must be 0 to 1")?,
            visibility: visibility.transpose()?.unwrap_or(CLOUD_VISIBILITY),
            scale: scale.transpose()?.unwrap_or(CLOUD_SCALE),
            seed: self.seed.unwrap_or_default(),
            wind: wind.transpose()?.unwrap_or_default(),
        })
    }
}

/// Returns how much the air glows: what the scene says; else all where it says where the sun stands.
pub(crate) fn glow(reading: &Reading<'_>, given: Option<&Spanned<f64>>, has_sun: bool) -> Result<f64> {
    match given {
        Some(glow) => reading.number("glow", glow, is_share, "must be 0 to 1"),
        None => Ok(if has_sun { 1.0 } else { 0.0 }),
    }
}

/// A height above the datum.
fn height(reading: &Reading<'_>, key: &str, value: &Spanned<f64>) -> Result<f64> {
    reading.number(key, value, |metres| metres.abs() <= HIGHEST, "must lie within 100 km of the datum")
}
