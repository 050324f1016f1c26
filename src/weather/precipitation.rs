//! Rain and snow, and their cover of the ground.

use serde::Deserialize;

use crate::weather::ranges::{FASTEST_FALL, is_rate, is_share, is_wind};

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
        is_rate(self.rate) && self.wind.into_iter().all(|speed| is_wind(speed, FASTEST_FALL))
    }
}

impl GroundCover {
    /// Whether its values lie within their ranges.
    pub(crate) fn is_sound(&self) -> bool {
        is_share(self.wet) && is_share(self.snow)
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
