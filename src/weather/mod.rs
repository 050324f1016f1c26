//! Weather: what lies in the air between the eye and what is seen.
//!
//! ```text
//! scene file ──▶ Weather: glow, fog, clouds, precipitation, wet or white ground; beside it, the visibility of haze
//! Atmosphere: haze, fog and glow along one ray          AtmosphereLanes: the same for sixteen planes at once
//! over what was rendered:  plumes, clouds, precipitation
//! ```

mod atmosphere;
mod atmosphere_lanes;
#[cfg(test)]
mod atmosphere_lanes_tests;
#[doc(hidden)]
pub mod clouds;
mod conditions;
mod fog;
mod glow;
mod plume;
mod precipitation;
mod precipitation_stage;
pub(crate) mod ranges;

pub(crate) use atmosphere::CLEAR_VISIBILITY;
#[doc(hidden)]
pub use atmosphere::{Atmosphere, Veil};
#[doc(hidden)]
pub use atmosphere_lanes::{AtmosphereLanes, SteepHeights};
pub use conditions::{Clouds, Fog, Weather};
#[doc(hidden)]
pub use plume::{Puff, SeenPuff};
pub use precipitation::{GroundCover, Precipitation, PrecipitationKind};
#[doc(hidden)]
pub use precipitation_stage::PrecipitationStage;
