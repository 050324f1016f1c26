//! The tables of weather: `[air]`, `[fog]`, `[clouds]`, `[precipitation]` and `[ground]`.

use serde::Deserialize;
use toml::Spanned;

use crate::weather::{Clouds, Fog, GroundCover, Precipitation, PrecipitationKind, Weather, ranges};
use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;

/// Visibility in clouds that say nothing of it, metres.
const CLOUD_VISIBILITY: f64 = 120.0;

/// Distance from one cloud to the next where clouds say nothing of it, metres.
const CLOUD_SCALE: f64 = 2000.0;

/// Depth of the upper edge of fog that says nothing of it, metres.
const SOFT_TOP: f64 = 20.0;

/// All tables of the weather.
pub(super) struct WeatherTables {
    /// Haze: its glow is a part of [`Weather`], its visibility is not.
    pub air: AirTable,
    /// Fog below a height.
    pub fog: Option<FogTable>,
    /// Clouds between two heights.
    pub clouds: Option<CloudsTable>,
    /// Rain or snow.
    pub precipitation: Option<PrecipitationTable>,
    /// Cover of the ground.
    pub ground: GroundTable,
}

/// Haze, and how it glows.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, expecting = "the table [air]")]
pub(super) struct AirTable {
    visibility_m: Option<Spanned<f64>>,
    glow: Option<Spanned<f64>>,
}

/// Fog below a height.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the table [fog]")]
pub(super) struct FogTable {
    top_m: Spanned<f64>,
    visibility_m: Spanned<f64>,
    soft_m: Option<Spanned<f64>>,
}

/// Clouds between two heights.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the table [clouds]")]
pub(super) struct CloudsTable {
    base_m: Spanned<f64>,
    top_m: Spanned<f64>,
    coverage: Spanned<f64>,
    visibility_m: Option<Spanned<f64>>,
    scale_m: Option<Spanned<f64>>,
    seed: Option<u32>,
    wind_mps: Option<Spanned<Vec<f64>>>,
}

/// Rain or snow.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the table [precipitation]")]
pub(super) struct PrecipitationTable {
    kind: PrecipitationKind,
    rate_mm_h: Spanned<f64>,
    wind_mps: Option<Spanned<Vec<f64>>>,
}

/// Water and snow on the ground.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, expecting = "the table [ground]")]
pub(super) struct GroundTable {
    wet: Option<Spanned<f64>>,
    snow: Option<Spanned<f64>>,
}

impl WeatherTables {
    /// Reads the weather; `has_sun`: the scene says where the sun stands.
    pub fn read(&self, reading: &Reading<'_>, has_sun: bool) -> Result<Weather> {
        let Self { air, fog, clouds, precipitation, ground } = self;
        let precipitation = precipitation.as_ref().map(|falls| falls.read(reading)).transpose()?;
        Ok(Weather {
            precipitation,
            ground: ground.read(reading, precipitation.as_ref())?,
            glow: air.read_glow(reading, has_sun)?,
            fog: fog.as_ref().map(|fog| fog.read(reading)).transpose()?,
            clouds: clouds.as_ref().map(|clouds| clouds.read(reading)).transpose()?,
        })
    }
}

impl AirTable {
    /// Reads the meteorological visibility at the lowest ground, metres, if it is given.
    pub fn read_visibility(&self, reading: &Reading<'_>) -> Result<Option<f64>> {
        let given = self.visibility_m.as_ref();
        given
            .map(|metres| {
                reading.number("visibility_m", metres, |metres| metres > 0.0, "must be more than 0 m")
            })
            .transpose()
    }

    /// Reads how much the air glows: what the scene says; else all where it says where the sun stands.
    fn read_glow(&self, reading: &Reading<'_>, has_sun: bool) -> Result<f64> {
        match &self.glow {
            Some(glow) => reading.number("glow", glow, ranges::is_share, "must be 0 to 1"),
            None => Ok(if has_sun { 1.0 } else { 0.0 }),
        }
    }
}

impl FogTable {
    fn read(&self, reading: &Reading<'_>) -> Result<Fog> {
        let soft = self.soft_m.as_ref();
        let soft =
            soft.map(|soft| reading.number("soft_m", soft, ranges::is_edge_depth, "must be 1 to 100,000 m"));
        Ok(Fog {
            top: read_height(reading, "top_m", &self.top_m)?,
            visibility: reading.number(
                "visibility_m",
                &self.visibility_m,
                ranges::is_visibility,
                "of fog must be 1 to 1,000,000 m",
            )?,
            soft: soft.transpose()?.unwrap_or(SOFT_TOP),
        })
    }
}

impl CloudsTable {
    fn read(&self, reading: &Reading<'_>) -> Result<Clouds> {
        let base = read_height(reading, "base_m", &self.base_m)?;
        let is_top = |top: f64| ranges::is_cloud_depth(top - base);
        let top = reading.number("top_m", &self.top_m, is_top, "must lie 10 m to 20 km above base_m")?;
        let visibility = self.visibility_m.as_ref().map(|metres| {
            let want = "of clouds must be 1 to 1,000,000 m";
            reading.number("visibility_m", metres, ranges::is_visibility, want)
        });
        let scale = self.scale_m.as_ref().map(|metres| {
            reading.number("scale_m", metres, ranges::is_cloud_scale, "must be 100 m to 100 km")
        });

        let wind = self.wind_mps.as_ref().map(|wind| read_wind(reading, wind, ranges::FASTEST_CLOUDS));

        Ok(Clouds {
            base,
            top,
            coverage: reading.number("coverage", &self.coverage, ranges::is_share, "must be 0 to 1")?,
            visibility: visibility.transpose()?.unwrap_or(CLOUD_VISIBILITY),
            scale: scale.transpose()?.unwrap_or(CLOUD_SCALE),
            seed: self.seed.unwrap_or_default(),
            wind: wind.transpose()?.unwrap_or_default(),
        })
    }
}

impl PrecipitationTable {
    fn read(&self, reading: &Reading<'_>) -> Result<Precipitation> {
        let rate = reading.number(
            "rate_mm_h",
            &self.rate_mm_h,
            ranges::is_rate,
            "must be more than 0 and at most 300 mm/h",
        )?;
        let wind = self.wind_mps.as_ref().map(|wind| read_wind(reading, wind, ranges::FASTEST_FALL));
        Ok(Precipitation { kind: self.kind, rate, wind: wind.transpose()?.unwrap_or_default() })
    }
}

impl GroundTable {
    /// Reads the table; what it leaves out follows from the precipitation.
    fn read(&self, reading: &Reading<'_>, falls: Option<&Precipitation>) -> Result<GroundCover> {
        let share = |key: &str, value: &Option<Spanned<f64>>, kind: PrecipitationKind| match value {
            Some(value) => reading.number(key, value, ranges::is_share, "must be 0 to 1"),
            None => Ok(if falls.is_some_and(|falls| falls.kind == kind) { 1.0 } else { 0.0 }),
        };
        Ok(GroundCover {
            wet: share("wet", &self.wet, PrecipitationKind::Rain)?,
            snow: share("snow", &self.snow, PrecipitationKind::Snow)?,
        })
    }
}

/// Reads a height above the datum, metres.
fn read_height(reading: &Reading<'_>, key: &str, value: &Spanned<f64>) -> Result<f64> {
    reading.number(key, value, ranges::is_height, "must lie within 100 km of the datum")
}

/// Reads the key `wind_mps`: speeds eastward and northward, metres per second, `fastest` at most.
fn read_wind(reading: &Reading<'_>, given: &Spanned<Vec<f64>>, fastest: f64) -> Result<[f64; 2]> {
    let wind: [f64; 2] = reading.numbers("wind_mps", given)?;
    if wind.into_iter().all(|speed| ranges::is_wind(speed, fastest)) {
        return Ok(wind);
    }
    let what = format!("wind_mps must be two speeds of {fastest} m/s at most, not {wind:?}");
    Err(reading.wrong(given.span(), what))
}
