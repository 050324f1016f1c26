//! What lies in the air of a scene: glow, fog, clouds.

use serde::Deserialize;
use toml::Spanned;

use super::file::Reading;
use crate::error::Result;

/// Metres above or below the datum beyond which there is no weather.
const HIGHEST: f64 = 100_000.0;

/// Depth of the upper edge of fog that says nothing of it, metres.
const SOFT_TOP: f64 = 20.0;

/// What lies in the air besides haze. The default is nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Weather {
    /// How much haze, fog and the sky's horizon brighten towards the sun, 0 (not at all) … 1.
    pub glow: f64,
    /// A layer of fog.
    pub fog: Option<Fog>,
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
pub(super) struct FogTable {
    top_m: Spanned<f64>,
    visibility_m: Spanned<f64>,
    soft_m: Option<Spanned<f64>>,
}

impl Weather {
    /// Whether all values are within their ranges.
    pub fn is_sound(&self) -> bool {
        let fog = |fog: &Fog| fog.top.abs() <= HIGHEST && is_visibility(fog.visibility) && is_depth(fog.soft);
        (0.0..=1.0).contains(&self.glow) && self.fog.as_ref().is_none_or(fog)
    }
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
    pub(super) fn read(&self, reading: &Reading<'_>) -> Result<Fog> {
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

/// How much the air glows: what the scene says; else all where it says where the sun stands.
pub(super) fn glow(reading: &Reading<'_>, given: Option<&Spanned<f64>>, has_sun: bool) -> Result<f64> {
    let share = |share: f64| (0.0..=1.0).contains(&share);
    match given {
        Some(glow) => reading.number("glow", glow, share, "must be 0 to 1"),
        None => Ok(if has_sun { 1.0 } else { 0.0 }),
    }
}

/// A height above the datum.
fn height(reading: &Reading<'_>, key: &str, value: &Spanned<f64>) -> Result<f64> {
    reading.number(key, value, |metres| metres.abs() <= HIGHEST, "must lie within 100 km of the datum")
}
