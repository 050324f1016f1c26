//! The tables `[precipitation]` and `[ground]`: what falls, and what it leaves on the ground.

use serde::Deserialize;
use toml::Spanned;

use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;

/// Heaviest fall, millimetres of water an hour: more than cloudbursts bring.
const HEAVIEST: f64 = 300.0;

/// Strongest wind, metres per second.
const FASTEST: f64 = 100.0;

/// Kind of precipitation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PrecipitationKind {
    /// Drops.
    Rain,
    /// Flakes.
    Snow,
}

/// Rain or snow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precipitation {
    /// Kind of precipitation.
    pub kind: PrecipitationKind,
    /// Millimetres of water an hour, more than 0 and at most 300.
    pub rate: f64,
    /// Eastward and northward, metres per second, 100 at most.
    pub wind: [f64; 2],
}

/// Cover of the ground by water and snow.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroundCover {
    /// Wetness, 0…1.
    pub wet: f64,
    /// Share of ground that is not too steep which is white, 0…1.
    pub snow: f64,
}

impl Precipitation {
    /// Meteorological visibility in clean air with it, metres: of rain after Atlas 1953 (*Journal of Meteorology* 10, 486–488), of dry snow about a kilometre
    /// for each millimetre an hour (Rasmussen, Vivekanandan, Cole, Myers and Masters 1999, *Journal of Applied Meteorology* 38, 1542–1563).
    pub fn visibility(&self) -> f64 {
        match self.kind {
            PrecipitationKind::Rain => 11_600.0 * self.rate.powf(-0.63),
            PrecipitationKind::Snow => 1000.0 / self.rate,
        }
    }

    /// Whether its values lie within their ranges.
    pub(crate) fn is_sound(&self) -> bool {
        is_rate(self.rate) && self.wind.into_iter().all(is_wind)
    }
}

impl GroundCover {
    /// Whether its values lie within their ranges.
    pub(crate) fn is_sound(&self) -> bool {
        is_share(self.wet) && is_share(self.snow)
    }
}

fn is_rate(rate: f64) -> bool {
    rate > 0.0 && rate <= HEAVIEST
}

fn is_wind(speed: f64) -> bool {
    speed.abs() <= FASTEST
}

fn is_share(share: f64) -> bool {
    (0.0..=1.0).contains(&share)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the table [precipitation]")]
pub(crate) struct PrecipitationTable {
    kind: PrecipitationKind,
    rate_mm_h: Spanned<f64>,
    wind_mps: Option<Spanned<Vec<f64>>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, expecting = "the table [ground]")]
pub(crate) struct GroundTable {
    wet: Option<Spanned<f64>>,
    snow: Option<Spanned<f64>>,
}

impl PrecipitationTable {
    pub fn read(&self, reading: &Reading<'_>) -> Result<Precipitation> {
        let rate = reading.number(
            "rate_mm_h",
            &self.rate_mm_h,
            is_rate,
            "must be more than 0 and at most 300 mm/h",
        )?;

        let wind: [f64; 2] = match &self.wind_mps {
            Some(wind) => {
                let speeds: [f64; 2] = reading.numbers("wind_mps", wind)?;
                if !speeds.into_iter().all(is_wind) {
                    let what =
                        format!("wind_mps must be two speeds of {FASTEST} m/s at most, not {speeds:?}");
                    return Err(reading.wrong(wind.span(), what));
                }
                speeds
            }
            None => [0.0; 2],
        };

        Ok(Precipitation { kind: self.kind, rate, wind })
    }
}

impl GroundTable {
    /// Reads the table; what it leaves out follows from the precipitation.
    pub fn read(&self, reading: &Reading<'_>, falls: Option<&Precipitation>) -> Result<GroundCover> {
        let share = |key: &str, value: &Option<Spanned<f64>>, kind: PrecipitationKind| match value {
            Some(value) => reading.number(key, value, is_share, "must be 0 to 1"),
            None => Ok(if falls.is_some_and(|falls| falls.kind == kind) { 1.0 } else { 0.0 }),
        };
        Ok(GroundCover {
            wet: share("wet", &self.wet, PrecipitationKind::Rain)?,
            snow: share("snow", &self.snow, PrecipitationKind::Snow)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heavier_falls_hide_more_and_snow_more_than_rain() {
        let visibility = |kind, rate| Precipitation { kind, rate, wind: [0.0; 2] }.visibility();
        assert!((visibility(PrecipitationKind::Rain, 1.0) - 11_600.0).abs() < 1e-9);
        assert!((visibility(PrecipitationKind::Rain, 25.0) - 1527.0).abs() < 20.0);
        assert!(
            visibility(PrecipitationKind::Snow, 2.0) == 500.0
                && visibility(PrecipitationKind::Snow, 2.0) < visibility(PrecipitationKind::Rain, 2.0)
        );
    }
}
