//! Conditions of the weather, as scenes set them.

use crate::weather::ranges::{
    FASTEST_CLOUDS, is_cloud_depth, is_cloud_scale, is_edge_depth, is_height, is_share, is_visibility,
    is_wind,
};
use crate::weather::{GroundCover, Precipitation};

/// Weather, but for the visibility of haze, which options of rendering and scenes have beside it. The default is clear air without glow over
/// dry ground.
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

impl Weather {
    /// Whether all values are within their ranges.
    pub fn is_sound(&self) -> bool {
        let Self { glow, fog, clouds, precipitation, ground } = self;
        is_share(*glow)
            && fog.as_ref().is_none_or(Fog::is_sound)
            && clouds.as_ref().is_none_or(Clouds::is_sound)
            && precipitation.as_ref().is_none_or(Precipitation::is_sound)
            && ground.is_sound()
    }
}

impl Clouds {
    /// Whether its values lie within their ranges.
    fn is_sound(&self) -> bool {
        is_height(self.base)
            && is_cloud_depth(self.top - self.base)
            && is_share(self.coverage)
            && is_visibility(self.visibility)
            && is_cloud_scale(self.scale)
            && self.wind.into_iter().all(|speed| is_wind(speed, FASTEST_CLOUDS))
    }
}

impl Fog {
    /// Whether its values lie within their ranges.
    fn is_sound(&self) -> bool {
        is_height(self.top) && is_visibility(self.visibility) && is_edge_depth(self.soft)
    }
}
